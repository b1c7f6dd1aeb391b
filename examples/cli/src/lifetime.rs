//! Sums over a whole recording: rating life, worst pressure, least preload, time beyond each limit.

use crate::times::PAUSE;
use serde::Serialize;
use solvers::{Answer, LIFT_OFF};
use spindle_bearing::{Limit, RatingLife};
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fmt;

/// Steps of time by which the usual one is known.
const FIRST_STEPS: usize = 100;

/// Sums over a recording.
///
/// A record holds until the next one; the last, and one after which the time goes back, as long as the one
/// before it; one before a pause for the usual step. Where no time passes at all, every record holds for a second.
#[derive(Debug, Default, Serialize)]
pub struct Lifetime {
    /// Records.
    pub records: u64,
    /// How many of them have no answer.
    pub without_answer: u64,
    /// Time of the records with an answer, s.
    pub duration_s: f64,
    /// Records with a time before that of the record above.
    pub back_in_time: u64,
    /// Basic rating life of the set by ISO 281's sum over the records; none if it has no end.
    pub l10_mrev: Option<f64>,
    /// The same in hours.
    pub l10_h: Option<f64>,
    /// The rows.
    pub rows: Vec<RowLifetime>,
    /// Time beyond each limit, s.
    pub beyond_s: BTreeMap<&'static str, f64>,
    #[serde(skip)]
    damage: Damage,
    /// As if every record held for a second: duration, damage, time beyond limits.
    #[serde(skip)]
    even_s: f64,
    #[serde(skip)]
    even: Damage,
    #[serde(skip)]
    even_beyond_s: BTreeMap<&'static str, f64>,
    #[serde(skip)]
    last: Option<(f64, Record)>,
    #[serde(skip)]
    step: f64,
    /// Median of the first steps, s, if longer ones may be pauses.
    #[serde(skip)]
    usual_step: Option<f64>,
    /// Time and length of the first pause, s, and the number of pauses.
    #[serde(skip)]
    pauses: Option<(f64, f64, u64)>,
}

/// Sums over a recording, of one row.
#[derive(Debug, Default, Serialize)]
pub struct RowLifetime {
    /// Its basic rating life; none if it has no end.
    pub l10_mrev: Option<f64>,
    /// The same in hours.
    pub l10_h: Option<f64>,
    /// The largest peak pressure, Pa.
    pub worst_pressure_pa: f64,
    /// Its time, s.
    pub worst_pressure_at_s: f64,
    /// The least preload, N; none of a bearing alone.
    pub least_preload_n: Option<f64>,
    /// Its time, s.
    pub least_preload_at_s: Option<f64>,
    #[serde(skip)]
    damage: Damage,
    #[serde(skip)]
    even: Damage,
}

/// Revolutions in all, and the share of the life that they use up.
#[derive(Debug, Clone, Copy, Default)]
struct Damage {
    revolutions: f64,
    used: f64,
}

impl Damage {
    fn add(&mut self, weight: f64, revolutions: f64) {
        let life = RatingLife::of_weight(weight, 1.0).million_revolutions;
        self.revolutions += revolutions;
        self.used += revolutions / (1e6 * life);
    }

    /// Million revolutions, and hours if so many revolutions take `duration` seconds.
    fn life(&self, duration: f64) -> [Option<f64>; 2] {
        let both = [1e-6 * self.revolutions, duration / 3600.0];
        both.map(|of| Some(of / self.used).filter(|life| life.is_finite()))
    }
}

/// A record, as it counts in the sums.
#[derive(Debug)]
pub struct Record {
    time: Option<f64>,
    turns_per_s: f64,
    /// Its rows and names of the limits that are passed, if it has an answer.
    answer: Option<(Vec<RowRecord>, Vec<&'static str>)>,
}

#[derive(Debug)]
struct RowRecord {
    /// Weight for the life.
    weight: f64,
    /// Largest peak pressure, Pa.
    pressure: f64,
    preload: f64,
}

impl Record {
    /// Of its time if it could be read, its speed, its answer and the weights of the rows for the life.
    pub fn new(time: Option<f64>, omega: f64, answer: Option<(&Answer, &[f64])>) -> Self {
        let answer = answer.map(|(answer, weights)| {
            let rows = answer.rows.iter().zip(weights).map(|(row, weight)| {
                let pressures = row.motions.iter().flat_map(|ball| [ball.inner, ball.outer]);
                RowRecord {
                    weight: *weight,
                    pressure: pressures.fold(0.0, |most: f64, at| most.max(at.peak_pressure)),
                    preload: row.preload,
                }
            });
            (rows.collect(), answer.passed())
        });
        Self {
            time: time.filter(|time| time.is_finite()),
            turns_per_s: omega.abs() / TAU,
            answer,
        }
    }
}

impl Lifetime {
    /// Takes a step of more than ten usual ones for a pause, the usual one being the median of the first hundred.
    pub fn end_at_pauses(&mut self, first_times: impl Iterator<Item = f64>) {
        let times: Vec<f64> = first_times.take(FIRST_STEPS + 1).collect();
        let steps = times.windows(2).map(|pair| pair[1] - pair[0]);
        let mut steps: Vec<f64> = steps.filter(|step| *step > 0.0).collect();
        steps.sort_by(f64::total_cmp);
        self.usual_step = steps.get(steps.len().saturating_sub(1) / 2).copied();
    }

    /// The first pause that ended a record, and how many did.
    pub fn pauses(&self) -> Option<String> {
        let (at, length, count) = self.pauses?;
        let more = match count {
            1 => String::new(),
            _ => format!(", and {} more pauses", count - 1),
        };
        let usual = self.usual_step.unwrap_or_default();
        Some(format!(
            "the logger pauses for {length} s after {at} s{more}: each of these records counts for {usual} s; `--pauses hold` counts \
             it until the next one"
        ))
    }

    /// Adds the next record.
    pub fn add(&mut self, record: Record) {
        self.records += 1;
        self.without_answer += u64::from(record.answer.is_none());
        let Some(time) = record.time else {
            return;
        };
        self.close(Some(time));
        if let Some((rows, _)) = &record.answer {
            self.rows.resize_with(rows.len(), RowLifetime::default);
            for (sum, row) in self.rows.iter_mut().zip(rows) {
                if row.pressure > sum.worst_pressure_pa {
                    (sum.worst_pressure_pa, sum.worst_pressure_at_s) = (row.pressure, time);
                }
                let is_less = sum.least_preload_n.is_none_or(|least| row.preload < least);
                if is_less && rows.len() > 1 {
                    (sum.least_preload_n, sum.least_preload_at_s) = (Some(row.preload), Some(time));
                }
            }
        }
        self.last = Some((time, record));
    }

    /// Counts the last record up to the time of the next one.
    fn close(&mut self, next: Option<f64>) {
        let Some((time, record)) = self.last.take() else {
            return;
        };
        let mut step = next.map_or(self.step, |next| next - time);
        if let Some(usual) = self.usual_step.filter(|usual| step > PAUSE * usual) {
            let (at, length, count) = self.pauses.unwrap_or((time, step, 0));
            self.pauses = Some((at, length, count + 1));
            step = usual;
        }
        self.back_in_time += u64::from(step < 0.0);
        self.step = if step < 0.0 { self.step } else { step };
        let step = self.step;
        let Some((rows, passed)) = record.answer else {
            return;
        };
        let turns = record.turns_per_s;
        self.duration_s += step;
        self.even_s += 1.0;
        let all = rows.iter().map(|row| row.weight).sum();
        self.damage.add(all, turns * step);
        self.even.add(all, turns);
        for (sum, row) in self.rows.iter_mut().zip(rows) {
            sum.damage.add(row.weight, turns * step);
            sum.even.add(row.weight, turns);
        }
        for limit in passed {
            *self.beyond_s.entry(limit).or_default() += step;
            *self.even_beyond_s.entry(limit).or_default() += 1.0;
        }
    }

    /// Ends the recording.
    pub fn finish(&mut self) {
        self.close(None);
        if self.duration_s == 0.0 {
            self.duration_s = self.even_s;
            self.damage = self.even;
            self.beyond_s = std::mem::take(&mut self.even_beyond_s);
            for row in &mut self.rows {
                row.damage = row.even;
            }
        }
        [self.l10_mrev, self.l10_h] = self.damage.life(self.duration_s);
        for row in &mut self.rows {
            [row.l10_mrev, row.l10_h] = row.damage.life(self.duration_s);
        }
        for name in Limit::ALL.map(Limit::name).into_iter().chain([LIFT_OFF]) {
            self.beyond_s.entry(name).or_default();
        }
    }
}

impl fmt::Display for Lifetime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |part: f64, whole: f64| {
            if whole > 0.0 {
                100.0 * part / whole
            } else {
                0.0
            }
        };
        let life = |life: [Option<f64>; 2]| match life {
            [Some(revolutions), Some(hours)] => {
                format!("{hours:.0} h, {revolutions:.1} million revolutions")
            }
            _ => "without end".to_owned(),
        };
        let share = percent(self.without_answer as f64, self.records as f64);
        writeln!(f, "records            {}", self.records)?;
        writeln!(
            f,
            "without an answer  {} ({share:.2} %)",
            self.without_answer
        )?;
        writeln!(f, "time with answers  {:.6} s", self.duration_s)?;
        if self.back_in_time > 0 {
            writeln!(f, "time goes back     {} times", self.back_in_time)?;
        }
        writeln!(
            f,
            "L10 of all rows    {}",
            life([self.l10_mrev, self.l10_h])
        )?;
        for (i, row) in self.rows.iter().enumerate() {
            writeln!(f, "row {i}")?;
            writeln!(f, "  L10              {}", life([row.l10_mrev, row.l10_h]))?;
            let (pressure, at) = (1e-6 * row.worst_pressure_pa, row.worst_pressure_at_s);
            writeln!(f, "  worst pressure   {pressure:.0} MPa at {at} s")?;
            if let (Some(preload), Some(at)) = (row.least_preload_n, row.least_preload_at_s) {
                writeln!(f, "  least preload    {preload:.1} N at {at} s")?;
            }
        }
        writeln!(f, "time beyond limits")?;
        for (limit, time) in &self.beyond_s {
            writeln!(
                f,
                "  {limit:16} {time:.6} s ({:.2} %)",
                percent(*time, self.duration_s)
            )?;
        }
        Ok(())
    }
}
