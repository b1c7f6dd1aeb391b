//! `cargo reports profile`: one solver's cycles, for who works on it.

use crate::bench::Bench;
use crate::host::Limit;
use crate::image::{Image, Motion, Variant, name};
use crate::memory::Memory;
use crate::profile::{Part, Profile, Profiler};
use crate::workload::{Work, question};
use anyhow::Result;
use host_tests::campaign::report::Spread;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::Path;
use tools::report::Choice;

/// Measures one solver and prints where its cycles go.
pub fn profile(root: &Path, choice: &Choice) -> Result<()> {
    let variant = Variant {
        core: choice.core,
        precision: choice.precision,
        balls: choice.balls.into(),
        motion: if choice.rest {
            Motion::Static
        } else {
            Motion::AtSpeed(choice.attitude)
        },
    };
    let mut bench = Bench::new(
        Image::build(root, &variant)?,
        variant.core,
        variant.precision,
    )?;
    let mut profiler = Profiler::new(variant.core, &bench.image)?;
    println!(
        "{}, {}, {} balls, {}: modelled cycles, +-15 %, no wait states\n",
        variant.core.name(),
        name(variant.precision),
        variant.balls,
        variant.motion.name()
    );

    let bar = ProgressBar::new(choice.cases as u64).with_style(ProgressStyle::with_template(
        "{bar:40} {pos} of {len} cases",
    )?);
    let mut cold = Measured::default();
    let mut warm = Measured::default();
    let mut stack = 0;
    for seed in 0..choice.cases as u64 {
        let work = Work::mixed(seed, variant.balls, variant.motion != Motion::Static);
        let questions =
            [work.cold, work.warm].map(|q| question(q, variant.precision, Limit::Default));
        bench.bearing(&work.design)?;
        for (measured, question) in [&mut cold, &mut warm].into_iter().zip(&questions) {
            let solve = bench.solve(question)?;
            if !solve.answer.solved {
                measured.unsolved += 1;
                // A tick after it would be another cold solve.
                break;
            }
            measured.cycles.push(solve.cycles as f64);
            measured.instructions.push(solve.instructions as f64);
            measured.sweeps.push(solve.answer.sweeps.into());
            measured
                .profile
                .add(&profiler.profile(&bench.machine, &solve.counts)?);
        }
        bar.inc(1);
    }
    bar.finish_and_clear();

    let everyday = Work::everyday();
    let questions =
        [everyday.cold, everyday.warm].map(|q| question(q, variant.precision, Limit::Default));
    bench.bearing(&everyday.design)?;
    println!("a B7005C at 20,000 rpm, 1000 N axial, 200 N radial, 3 N m:");
    for (start, question) in ["cold", "warm"].into_iter().zip(&questions) {
        let solve = bench.solve(question)?;
        println!(
            "  {start}: {} cycles, {} instructions, {} sweeps",
            thousands(solve.cycles as f64),
            thousands(solve.instructions as f64),
            solve.answer.sweeps
        );
    }
    for seed in 0..choice.cases.min(60) as u64 {
        let work = Work::mixed(seed, variant.balls, variant.motion != Motion::Static);
        bench.bearing(&work.design)?;
        for question in
            [work.cold, work.warm].map(|q| question(q, variant.precision, Limit::Default))
        {
            stack = stack.max(bench.stack(&question)?);
        }
    }

    for (start, measured) in [("cold", &cold), ("warm", &warm)] {
        measured.print(start);
    }

    let memory = Memory::of(&bench)?;
    println!(
        "\nflash of the solver, {} bytes:",
        thousands(memory.flash() as f64)
    );
    for (size, name) in &memory.symbols {
        println!("{size:8} {name}");
    }
    println!(
        "\nstate {} bytes, the bearing's constants {} bytes, worst stack {stack} bytes",
        memory.state, memory.constants
    );
    Ok(())
}

#[derive(Default)]
struct Measured {
    cycles: Vec<f64>,
    instructions: Vec<f64>,
    sweeps: Vec<f64>,
    unsolved: usize,
    profile: Profile,
}

impl Measured {
    fn print(&self, start: &str) {
        let solves = self.cycles.len().max(1) as f64;
        let sweeps: f64 = self.sweeps.iter().sum();
        println!(
            "\n{start}, {} mixed cases solved, {} not",
            self.cycles.len(),
            self.unsolved
        );
        for (what, values) in [
            ("cycles", &self.cycles),
            ("instructions", &self.instructions),
            ("sweeps", &self.sweeps),
        ] {
            let spread = Spread::of(values.iter().copied());
            println!(
                "  {what:12} median {:>9}   99 % {:>9}   worst {:>9}   mean {:>9}",
                thousands(spread.median),
                thousands(spread.most),
                thousands(spread.worst),
                thousands(values.iter().sum::<f64>() / solves)
            );
        }
        println!(
            "  cycles a sweep: {} (all but start and rest), {} sweeps a solve",
            thousands(self.profile.sweeping() as f64 / sweeps),
            format_args!("{:.2}", sweeps / solves)
        );
        println!("\n  cycles a solve (mean)      a sweep   share   part");
        let total = self.profile.cycles() as f64;
        for part in Part::ALL {
            let cycles = self.profile.parts.get(&part).copied().unwrap_or(0) as f64;
            let share = 100.0 * cycles / total;
            println!(
                "  {:>10}            {:>11} {share:>6.1} %   {}",
                thousands(cycles / solves),
                thousands(cycles / sweeps),
                part.name()
            );
        }
        println!("\n  cycles a sweep: own, with what it calls; share of own; function");
        let mut functions: Vec<_> = self.profile.functions.iter().collect();
        functions.sort_by_key(|(_, share)| std::cmp::Reverse(share.own));
        for (name, share) in functions {
            println!(
                "  {:>9} {:>9} {:>6.1} %   {name}",
                thousands(share.own as f64 / sweeps),
                thousands(share.all as f64 / sweeps),
                100.0 * share.own as f64 / total
            );
        }
        println!("\n  instructions and cycles a sweep, by class");
        for (class, (instructions, cycles)) in &self.profile.classes {
            println!(
                "  {:>9} {:>9}   {}",
                thousands(*instructions as f64 / sweeps),
                thousands(*cycles as f64 / sweeps),
                class.name()
            );
        }
    }
}

/// A whole number with its thousands set apart.
pub fn thousands(value: f64) -> String {
    let digits = format!("{:.0}", value.abs());
    let mut out = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(c);
    }
    if value < 0.0 && digits != "0" {
        format!("-{out}")
    } else {
        out
    }
}
