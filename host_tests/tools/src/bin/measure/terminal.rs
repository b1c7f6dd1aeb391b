//! `cargo reports profile`: one solver's cycles, for who works on it.

use crate::bench::{Bench, Solve};
use crate::host::Limit;
use crate::image::{Image, name};
use crate::memory::Memory;
use crate::milling::{self, Ticks};
use crate::profile::{Part, Profile, Profiler};
use crate::scenes;
use crate::workload::{self, EVERYDAY_BALLS, Work, question};
use anyhow::{Context, Result};
use host_tests::campaign::report::Spread;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::Path;
use tools::report::{Choice, FULL};

/// Ticks of the milling cycle, and the second of it where they begin.
const MILLING: (usize, usize) = (2, 3000);

/// Measures one solver and prints where its cycles go.
pub fn profile(root: &Path, choice: &Choice) -> Result<()> {
    let &Choice {
        core, precision, ..
    } = choice;
    let balls = choice.balls.into();
    let scene = scenes::scene(&choice.scene).context("there is no such scene")?;
    let image = Image::of_scene(root, core, precision, balls, scene.name)?;
    let mut bench = Bench::new(image, core, precision)?;
    let mut profiler = Profiler::new(core, &bench.image)?;
    println!(
        "{}, {}, {balls} balls, {}: modelled cycles, +-15 %, no wait states\n",
        core.name(),
        name(precision),
        scene.name
    );

    let states = |work: &Work| {
        // With a displacement given, the states take one that a solver in doubles finds.
        let preload = scene.preload(work)?;
        anyhow::Ok(scene.states(work, preload))
    };
    let ask = |state| question(state, precision, Limit::Default);
    let bar = ProgressBar::new(choice.cases as u64).with_style(ProgressStyle::with_template(
        "{bar:40} {pos} of {len} cases",
    )?);
    let mut cold = Measured::default();
    let mut warm = Measured::default();
    let mut stack = 0;
    for seed in 0..choice.cases as u64 {
        let work = Work::mixed(seed, balls, scene.attitude.is_some());
        bar.inc(1);
        let Some(states) = states(&work)? else {
            continue;
        };
        bench.bearing(&work.design)?;
        for (measured, state) in [&mut cold, &mut warm].into_iter().zip(states) {
            let solve = bench.solve(&ask(state))?;
            if !solve.answer.solved {
                measured.unsolved.push(seed);
                // A tick after it would be another cold solve.
                break;
            }
            let profile = profiler.profile(&bench.machine, &solve.counts)?;
            measured.add(seed, &solve, &profile);
        }
        if seed < 60 {
            bench.reset()?;
            for state in states {
                stack = stack.max(bench.stack(&ask(state))?);
            }
        }
    }
    bar.finish_and_clear();

    let everyday = Work::everyday();
    if let Some(states) = states(&everyday)? {
        bench.bearing(&everyday.design)?;
        println!(
            "a B7005C at 20,000 rpm, 1000 N axial, 200 N radial, 3 N m, as far as the scene goes:"
        );
        for (start, state) in ["cold", "warm"].into_iter().zip(states) {
            let solve = bench.solve(&ask(state))?;
            println!(
                "  {start}: {} cycles, {} instructions, {} iterations",
                thousands(solve.cycles as f64),
                thousands(solve.instructions as f64),
                solve.answer.iterations
            );
        }
    }

    for (start, measured) in [("cold", &cold), ("warm", &warm)] {
        measured.print(start);
    }
    if scene.name == FULL
        && (core, precision, balls) == (milling::CORE, milling::PRECISION, EVERYDAY_BALLS)
    {
        let (from, count) = MILLING;
        let states = workload::milling(from, count)?;
        for limit in milling::LIMITS {
            let ticks = Ticks::measure(&mut bench, Some(&mut profiler), &states, limit)?;
            print_ticks(&ticks, limit);
        }
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

fn print_ticks(ticks: &Ticks, limit: Limit) {
    let (from, count) = MILLING;
    println!(
        "\n{count} ticks of the milling cycle from second {from} on, tolerance {:e}: {} warm, {} without an answer",
        limit.settings(milling::PRECISION).0,
        ticks.cycles.len(),
        ticks.failed
    );
    let spread = Spread::of(ticks.cycles.iter().copied());
    let errors = Spread::of(ticks.errors.iter().copied());
    println!(
        "  cycles       median {:>9}   99 % {:>9}   worst {:>9}",
        thousands(spread.median),
        thousands(spread.most),
        thousands(spread.worst)
    );
    println!(
        "  error of K   median {:>9.1e}   99 % {:>9.1e}   worst {:>9.1e}",
        errors.median, errors.most, errors.worst
    );
    println!(
        "  cycles an iteration: {}, {:.2} iterations a tick",
        thousands(ticks.profile.iterating() as f64 / ticks.iterations),
        ticks.iterations / ticks.cycles.len() as f64
    );
}

#[derive(Default)]
struct Measured {
    cycles: Vec<f64>,
    instructions: Vec<f64>,
    iterations: Vec<f64>,
    /// Numbers of the cases that were solved, and of those that were not.
    cases: Vec<u64>,
    unsolved: Vec<u64>,
    profile: Profile,
}

impl Measured {
    fn add(&mut self, case: u64, solve: &Solve, profile: &Profile) {
        self.cases.push(case);
        self.cycles.push(solve.cycles as f64);
        self.instructions.push(solve.instructions as f64);
        self.iterations.push(solve.answer.iterations.into());
        self.profile.add(profile);
    }

    fn print(&self, start: &str) {
        let solves = self.cycles.len().max(1) as f64;
        let iterations: f64 = self.iterations.iter().sum();
        println!(
            "\n{start}, {} mixed cases solved, not: {:?}",
            self.cycles.len(),
            self.unsolved
        );
        let longest = self.cycles.iter().zip(&self.cases);
        if let Some((_, case)) = longest.max_by(|a, b| a.0.total_cmp(b.0)) {
            println!("  the longest is case {case}");
        }
        for (what, values) in [
            ("cycles", &self.cycles),
            ("instructions", &self.instructions),
            ("iterations", &self.iterations),
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
            "  cycles an iteration: {} (all but start and rest), {:.2} iterations a solve",
            thousands(self.profile.iterating() as f64 / iterations),
            iterations / solves
        );
        println!("\n  cycles a solve (mean)  an iteration share   part");
        let total = self.profile.cycles() as f64;
        for part in Part::ALL {
            let cycles = self.profile.parts.get(&part).copied().unwrap_or(0) as f64;
            let share = 100.0 * cycles / total;
            println!(
                "  {:>10}            {:>11} {share:>6.1} %   {}",
                thousands(cycles / solves),
                thousands(cycles / iterations),
                part.name()
            );
        }
        println!("\n  cycles an iteration: own, with what it calls; share of own; function");
        let mut functions: Vec<_> = self.profile.functions.iter().collect();
        functions.sort_by_key(|(_, share)| std::cmp::Reverse(share.own));
        for (name, share) in functions {
            println!(
                "  {:>9} {:>9} {:>6.1} %   {name}",
                thousands(share.own as f64 / iterations),
                thousands(share.all as f64 / iterations),
                100.0 * share.own as f64 / total
            );
        }
        println!("\n  instructions and cycles an iteration, by class");
        for (class, (instructions, cycles)) in &self.profile.classes {
            println!(
                "  {:>9} {:>9}   {}",
                thousands(*instructions as f64 / iterations),
                thousands(*cycles as f64 / iterations),
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
