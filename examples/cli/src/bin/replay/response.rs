//! `cargo replay --response`: measured over computed displacement at the probes, second by second.

use crate::arguments::Args;
use crate::input::progress_bar;
use crate::output::unwritable;
use anyhow::{Result, bail, ensure};
use cli::fault::LoadsError;
use cli::output::{NewFile, place};
use cli::recordings::{self, Loads};
use cli::replay::{REFUSED_INPUT, Summary};
use rayon::prelude::*;
use spindle_file::loads::LoadRow;
use spindle_file::solvers::{AnySolver, Choices};
use spindle_file::spindles::SpindleFile;
use spindle_monitor::Alarm;
use spindle_monitor::response::{LEAST_STEPS, Response, is_aliased};
use spindle_monitor::tick::Core;
use std::io::Write;
use std::path::Path;

/// Rows that are solved one after the other, from a cold start on.
const BLOCK: usize = 500;
/// Blocks that are read ahead.
const AHEAD: usize = 32;
/// Load steps of the reference where `--commission` does not say it: 20 engagements.
const REFERENCE: u32 = 40;

/// A row of the recording: its loads and, once it is solved, the displacements computed at the probes, um.
struct Record {
    row: Option<LoadRow>,
    computed: Result<Vec<f64>, (&'static str, String)>,
}

/// Replays the recording.
///
/// # Errors
///
/// No probes, no columns of them, a recording that cannot be read, a file that cannot be written.
pub fn replay(
    args: &Args,
    file: &SpindleFile,
    solver: &mut dyn AnySolver,
    path: &Path,
) -> Result<Summary> {
    let name = args.design().display();
    ensure!(
        !file.probes.is_empty(),
        "--response: {name} has no [[probe]]; add one with name, position_mm and direction"
    );
    let out = place(path).map_err(|error| unwritable(path, &error))?;
    let loads = args.loads.as_deref().unwrap_or(Path::new(""));
    let import = args.recording.import.as_deref();
    let inputs = [loads, args.design()].into_iter().chain(import);
    for input in inputs.chain(file.files()) {
        if place(input).is_ok_and(|input| input == out) {
            bail!(
                "--response would overwrite its own input {}; name another file",
                path.display()
            );
        }
    }
    let mut wanted = args.wanted(file.heat.is_some())?;
    wanted.probes = file.probes.iter().map(|probe| probe.name.clone()).collect();
    let import = args.recording.import()?;
    let mut loads = recordings::read(loads, import.as_ref(), &wanted)?;
    let has: Vec<bool> = loads.has_probes().collect();
    ensure!(
        has.contains(&true),
        "{}: there is no column probe_{}_um; add one for each [[probe]], or describe it with --import",
        loads.file(),
        file.probes[0].name
    );
    for (probe, _) in file.probes.iter().zip(&has).filter(|(_, has)| !**has) {
        let (file, name) = (loads.file(), &probe.name);
        eprintln!("replay: {file}: there is no column probe_{name}_um");
    }
    let mut out = NewFile::create(path).map_err(|error| unwritable(path, &error))?;
    let mut history = match file.probes.len() {
        1 => History::<1>::boxed(args, file),
        2 => History::<2>::boxed(args, file),
        3 => History::<3>::boxed(args, file),
        _ => History::<4>::boxed(args, file),
    };
    solver.choose(&Choices {
        parts: 0,
        tolerance: args.tolerance,
        ..Choices::default()
    });
    let mut summary = Summary::default();
    let bar = progress_bar(loads.total_bytes(), "{bytes} of {total_bytes}");
    let mut text = "time_s,probe,ratio,ratio_error,steps,state\n".to_owned();
    loop {
        let mut records = read(&mut loads, &mut summary)?;
        if records.is_empty() {
            break;
        }
        let blocks: Vec<_> = records
            .chunks_mut(BLOCK)
            .map(|block| (solver.copy(), block))
            .collect();
        blocks.into_par_iter().for_each(|(mut solver, block)| {
            solver.reset();
            solve(&mut *solver, file, block);
        });
        history.take(&records, &mut summary, &mut text);
        out.write_all(text.as_bytes())
            .map_err(|error| unwritable(path, &error))?;
        text.clear();
        bar.set_position(loads.bytes_read());
    }
    for line in loads.account().lines() {
        eprintln!("replay: {line}");
    }
    ensure!(
        summary.rows > 0,
        "{}: there is no row below the header",
        loads.file()
    );
    out.finish().map_err(|error| unwritable(path, &error))?;
    Ok(summary)
}

/// The next records of the recording; none at its end.
fn read(loads: &mut Loads, summary: &mut Summary) -> Result<Vec<Record>> {
    let mut records = Vec::new();
    while records.len() < AHEAD * BLOCK {
        let row = match loads.next() {
            Some(Ok(row)) => Some(row),
            Some(Err(LoadsError::Row(bad))) => {
                summary.first_fault.get_or_insert(bad.fault);
                None
            }
            Some(Err(fault)) => return Err(fault.into()),
            None => break,
        };
        records.push(Record {
            row,
            computed: Err((REFUSED_INPUT, String::new())),
        });
    }
    Ok(records)
}

fn solve(solver: &mut dyn AnySolver, file: &SpindleFile, block: &mut [Record]) {
    for record in block {
        let Some(row) = &record.row else { continue };
        let answer = solver.solve(&file.question_at_probes(row));
        record.computed = match answer {
            Ok(answer) => {
                let probes = file.probes.iter().zip(&answer.at);
                Ok(probes
                    .map(|(probe, at)| probe.sees(&at.displacement))
                    .collect())
            }
            Err(status) => Err((status.name(), status.to_string())),
        };
    }
}

/// Records in their order.
trait Take {
    fn take(&mut self, records: &[Record], summary: &mut Summary, text: &mut String);
}

/// History of a spindle with `P` probes.
struct History<'h, const P: usize> {
    file: &'h SpindleFile,
    commission: Option<[f64; 2]>,
    /// Begins with the first records, which say how many there are in a second.
    response: Option<Response<P>>,
    step: f64,
    /// Time of the last record, and of the next line.
    last: f64,
    next: f64,
    rpm: f32,
    has_begun: bool,
    refers: [bool; P],
    is_told: bool,
}

impl<'h, const P: usize> History<'h, P> {
    fn boxed(args: &Args, file: &'h SpindleFile) -> Box<dyn Take + 'h> {
        Box::new(Self {
            file,
            commission: args.response.commission,
            response: None,
            step: 0.0,
            last: f64::NAN,
            next: 0.0,
            rpm: 0.0,
            has_begun: false,
            refers: [true; P],
            is_told: false,
        })
    }

    fn new_response(&self) -> Response<P> {
        let accuracies = std::array::from_fn(|i| self.file.probes[i].accuracy as f32);
        let alarms = self.file.settings(&Core::STM32F405).alarms;
        let limits =
            [Alarm::StiffnessLoss, Alarm::StiffnessGain].map(|alarm| alarms[alarm as usize].raise);
        Response::new(accuracies, (1.0 / self.step) as f32, limits)
    }

    /// Step of time and first second, of the first records.
    fn begin(&mut self, records: &[Record]) {
        let times: Vec<f64> = records
            .iter()
            .filter_map(|record| Some(record.row?.time_s))
            .collect();
        let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.retain(|step| *step > 0.0);
        steps.sort_by(f64::total_cmp);
        self.step = steps.get(steps.len() / 2).copied().unwrap_or(1.0);
        self.next = times.first().map_or(0.0, |time| time.floor() + 1.0);
        self.response = Some(self.new_response());
    }

    /// Begins and ends the reference of each probe when it is time to.
    fn refer(&mut self, time: f64) {
        if let Some([from, _]) = self.commission
            && time >= from
            && !self.has_begun
        {
            self.has_begun = true;
            self.response = Some(self.new_response());
        }
        let Some(response) = &mut self.response else {
            return;
        };
        let reports = response.reports();
        for i in 0..P {
            if !self.refers[i] {
                continue;
            }
            let steps = reports[i].steps;
            self.refers[i] = match self.commission {
                Some([_, to]) => time < to,
                None => steps < REFERENCE,
            };
            if !self.refers[i] && !response.refer(i) {
                let name = &self.file.probes[i].name;
                eprintln!(
                    "replay: probe {name}: {steps} load steps until {time} s, where a reference needs {LEAST_STEPS}; widen --commission"
                );
            }
        }
    }

    fn add(&mut self, record: &Record, text: &mut String) {
        let time = record.row.map_or(self.last + self.step, |row| row.time_s);
        self.refer(time);
        let Some(response) = &mut self.response else {
            return;
        };
        if (time - self.last - self.step).abs() > 0.5 * self.step {
            response.tick(None, None, [None; P]);
        }
        if let Some(row) = record.row {
            self.rpm = row.speed_rpm as f32;
        }
        let rate = (1.0 / self.step) as f32;
        if is_aliased(self.rpm, rate) && !self.is_told {
            self.is_told = true;
            let rpm = self.rpm;
            eprintln!(
                "replay: at {time} s, runout at {rpm} rpm cannot be told from drift with {rate} samples a second; such times do not count"
            );
        }
        let computed = record.computed.as_ref().ok();
        let computed = computed.map(|all| std::array::from_fn(|i| all[i] as f32));
        let measured = |i: usize| Some(record.row?.probes[i]? as f32);
        response.tick(Some(self.rpm), computed, std::array::from_fn(measured));
        self.last = time;
        while time + 1.5 * self.step >= self.next {
            for (probe, report) in self.file.probes.iter().zip(response.reports()) {
                let figures = report.ratio.map_or(",".to_owned(), |ratio| {
                    format!("{:.6},{:.6}", ratio.value, ratio.error)
                });
                let (next, name) = (self.next, &probe.name);
                let (steps, state) = (report.steps, report.state.name());
                text.push_str(&format!("{next},{name},{figures},{steps},{state}\n"));
            }
            // Pauses of the logger have no lines.
            self.next = (self.next + 1.0).max(time.floor());
        }
    }
}

impl<const P: usize> Take for History<'_, P> {
    fn take(&mut self, records: &[Record], summary: &mut Summary, text: &mut String) {
        if self.response.is_none() {
            self.begin(records);
        }
        for record in records {
            summary.rows += 1;
            if let Err((status, why)) = &record.computed {
                *summary.refused.entry(status).or_default() += 1;
                if let Some(row) = record.row {
                    summary
                        .first_refusal
                        .get_or_insert_with(|| (row.time_s, why.clone()));
                }
            }
            self.add(record, text);
        }
    }
}
