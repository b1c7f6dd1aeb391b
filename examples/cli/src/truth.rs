//! Synthetic recordings at the probes of a spindle that is another one than its file says.
//!
//! Nothing here was measured. Tools come in turn, four cuts each, at depths that vary; between cuts the spindle idles as long as it cuts. The
//! shaft of the true spindle moves the probes, with runout at one and two a revolution and noise.

use crate::random::Random;
use anyhow::Result;
use solvers::dispatch::Precision;
use solvers::{Balls, with_solver};
use spindle_bearing::Preload;
use spindle_file::loads::LoadRow;
use spindle_file::spindles::SpindleFile;
use std::f64::consts::TAU;
use std::fmt::Write;

/// Forces of tools (N), and how far each cuts in front of `x = 0`, m.
const TOOLS: [[f64; 4]; 6] = [
    [-90.0, 270.0, 135.0, 0.05],
    [-200.0, 60.0, -60.0, 0.03],
    [0.0, -120.0, 200.0, 0.07],
    [150.0, 80.0, 90.0, 0.02],
    [-50.0, -250.0, -100.0, 0.06],
    [-120.0, 20.0, 160.0, 0.08],
];
/// Cuts of a tool before the next one comes.
const CUTS: usize = 4;
/// Least and largest depth of a cut, as a part of the usual one.
const DEPTHS: [f64; 2] = [0.36, 1.43];
/// Runout, and largest noise of a reading, um.
const RUNOUT: f64 = 3.0;
const NOISE: f64 = 0.2;
/// Temperatures of the inner and of the outer side, degrees Celsius.
const WARM: [f64; 2] = [24.0, 22.0];
/// Offset of a probe, um.
const OFFSET: f64 = 40.0;

/// A spindle in use.
#[derive(Debug, Clone, Copy)]
pub struct Truth {
    /// Speed, rpm.
    pub rpm: f64,
    /// Preload for which its rows are ground, N, before and after a time, s.
    pub preload: [f64; 2],
    /// That time.
    pub change: f64,
    /// Gains of the first two probes.
    pub gains: [f64; 2],
    /// It cuts with one tool at one depth until this time, s.
    pub one_until: f64,
    /// Time of a cut, s, and of the idling before it.
    pub half: f64,
    /// Time from row to row, s.
    pub step: f64,
}

impl Truth {
    /// 12 % less preload than 250 N, and probes that are 5 and 3 % off.
    pub const SOUND: Self = Self {
        rpm: 12_007.0,
        preload: [220.0; 2],
        change: 0.0,
        gains: [1.05, 0.97],
        one_until: 0.0,
        half: 0.2,
        step: 1e-3,
    };

    /// So many seconds of a spindle that is the file's but for all this, as a table in the project's own columns. No load is stuck.
    ///
    /// # Errors
    ///
    /// The spindle cannot be built.
    ///
    /// # Panics
    ///
    /// It has no equilibrium, or less than two probes.
    pub fn recording(&self, file: &SpindleFile, seconds: f64) -> Result<String> {
        let mut random = Random::seeded(1);
        let whole = 2.0 * self.half;
        let cuts = (0..=(seconds / whole) as usize).map(|cut| self.cut(cut, &mut random));
        let cuts: Vec<_> = cuts.collect();
        let [before, after] = self.preload;
        let truth = [
            self.seen(file, before, &cuts)?,
            self.seen(file, after, &cuts)?,
        ];
        let mut csv = "time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm".to_owned();
        let warm = file.heat.map(|_| WARM);
        if warm.is_some() {
            csv += ",t_inner_c,t_outer_c";
        }
        for probe in &file.probes[..2] {
            write!(csv, ",probe_{}_um", probe.name)?;
        }
        csv.push('\n');
        for i in 0..(seconds / self.step).round() as usize {
            let time = i as f64 * self.step;
            let cut = (time / whole) as usize;
            let is_cutting = time % whole > self.half;
            let [idle, cutting] = truth[usize::from(time >= self.change)][cut];
            let seen = if is_cutting { cutting } else { idle };
            write!(csv, "{time:.6}")?;
            for load in cuts[cut] {
                let load = if is_cutting { load } else { 0.0 };
                write!(csv, ",{:.4}", load + 1e-3 * (i % 7) as f64)?;
            }
            let turn = TAU * time * self.rpm / 60.0;
            let runout = RUNOUT * (libm::cos(turn) + libm::sin(2.0 * turn));
            let [axial, radial] =
                [0, 1].map(|p| self.gains[p] * seen[p] + NOISE * random.between(-1.0, 1.0));
            let [axial, radial] = [axial + runout + OFFSET, radial - runout];
            write!(csv, ",{}", self.rpm)?;
            if let Some([inner, outer]) = warm {
                write!(csv, ",{inner},{outer}")?;
            }
            writeln!(csv, ",{axial:.4},{radial:.4}")?;
        }
        Ok(csv)
    }

    /// Loads of a cut.
    fn cut(&self, number: usize, random: &mut Random) -> [f64; 5] {
        let is_one = 2.0 * self.half * (number as f64) < self.one_until;
        let (tool, depth) = match is_one {
            true => (0, 1.0),
            false => (
                number / CUTS % TOOLS.len(),
                random.between(DEPTHS[0], DEPTHS[1]),
            ),
        };
        let [x, y, z, arm] = TOOLS[tool];
        let [x, y, z] = [x, y, z].map(|force| depth * force);
        [x, y, z, arm * z, -arm * y]
    }

    /// Displacements at the first two probes, um, without a load and in each cut, of a spindle that is ground for this preload.
    fn seen(
        &self,
        file: &SpindleFile,
        preload: f64,
        cuts: &[[f64; 5]],
    ) -> Result<Vec<[[f64; 2]; 2]>> {
        let mut plan = file.plan.clone();
        for row in &mut plan.rows {
            row.preload = Preload::Force(preload);
        }
        let solved = with_solver(&plan, Balls::Free, Precision::F64, |solver| {
            let mut seen = |load: [f64; 5]| {
                let row = LoadRow {
                    time_s: 0.0,
                    load,
                    speed_rpm: self.rpm,
                    temperatures: file.heat.map(|_| WARM),
                    probes: [None; 4],
                };
                let answer = solver.answer(&file.question_at_probes(&row));
                [0, 1].map(|i| file.probes[i].sees(&answer.at[i].displacement))
            };
            let idle = seen([0.0; 5]);
            cuts.iter().map(|cut| [idle, seen(*cut)]).collect()
        });
        solved.map_err(|error| file.explain(&error).into())
    }
}
