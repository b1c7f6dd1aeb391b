//! A solver on a modelled core over all cases and tasks.

use crate::bench::Bench;
use crate::host::{Limit, Sample, Task};
use crate::image::{Image, Variant};
use crate::memory::Memory;
use crate::profile::{Part, Profile, Profiler};
use crate::rows::{At, Rows, Start};
use crate::workload::{self, EVERYDAY_BALLS, Work};
use anyhow::{Result, bail};
use host_tests::dispatch::Precision;
use indicatif::ProgressBar;
use tools::timing::Core;

/// Cases whose stack is looked at: it is the same in all but a few.
const STACKS: usize = 40;

/// A solve on the core.
#[derive(Debug, Clone, Copy)]
struct Count {
    cycles: u64,
    instructions: u64,
}

/// Measures a program; fails if an answer of it is not the host's to the last bit.
pub fn measure(
    image: Image,
    variant: Variant,
    works: &[Work],
    tasks: &[Task],
    host: &[Vec<Option<Sample>>],
    bar: &ProgressBar,
) -> Result<Rows> {
    let mut bench = Bench::new(image, variant.core, variant.precision)?;
    let mut profiler = Profiler::new(variant.core, &bench.image)?;
    let mut counts: Vec<Vec<Count>> = vec![Vec::new(); tasks.len()];
    let mut profiles = [Profile::default(), Profile::default()];
    let mut iterations = [0.0; 2];
    let in_software = variant.core == Core::M4f && variant.precision == Precision::F64;
    for (case, work) in works.iter().enumerate() {
        bench.bearing(&work.design)?;
        // What the machine remembers after the cold solve.
        let mut solved: Option<Vec<u8>> = None;
        for start in Start::ALL {
            let number = start as usize;
            for (task, (_, limit)) in tasks.iter().enumerate().filter(|(_, t)| t.0 == start) {
                if in_software && *limit != Limit::Default {
                    continue;
                }
                let Some(expected) = &host[task][case] else {
                    continue;
                };
                match (start, &solved) {
                    (Start::Cold, _) => bench.reset()?,
                    (Start::Warm, Some(memory)) => bench.machine.restore(memory)?,
                    // The host could not solve the first tick, either.
                    (Start::Warm, None) => continue,
                }
                let state = match start {
                    Start::Cold => work.cold,
                    Start::Warm => work.warm,
                };
                let solve = bench.solve(&workload::question(state, variant.precision, *limit))?;
                let answer = &solve.answer;
                let same = bits(&answer.displacement) == bits(&expected.displacement)
                    && answer.stiffness.map(|r| bits(&r)) == expected.stiffness.map(|r| bits(&r))
                    && answer.iterations == u32::from(expected.iterations);
                if !same {
                    bail!(
                        "case {case}, {} {limit:?}, of {variant:?}: the core's answer is not the \
                         host's.\n{answer:?}\n{expected:?}\nThe library's promise of the same bits \
                         everywhere is broken, or the emulator is",
                        start.name()
                    );
                }
                counts[task].push(Count {
                    cycles: solve.cycles,
                    instructions: solve.instructions,
                });
                if *limit == Limit::Default {
                    profiles[number].add(&profiler.profile(&bench.machine, &solve.counts)?);
                    iterations[number] += f64::from(answer.iterations);
                    if start == Start::Cold {
                        solved = Some(bench.machine.memory()?);
                    }
                }
            }
        }
        bar.inc(1);
    }

    let mut rows = Rows::default();
    let at = At {
        core: Some(variant.core),
        precision: variant.precision,
        motion: variant.motion,
        balls: variant.balls,
        start: None,
    };
    for ((start, limit), counts) in tasks.iter().zip(&counts) {
        let at = At {
            start: Some(*start),
            ..at
        };
        let of = |f: fn(&Count) -> f64| counts.iter().map(f).collect::<Vec<_>>();
        let cycles = of(|c| c.cycles as f64);
        rows.spread(&at, &limit.metric("cycles"), &cycles, "cycles");
        if *limit == Limit::Default {
            let instructions = of(|c| c.instructions as f64);
            rows.spread(&at, "instructions", &instructions, "instructions");
        }
    }
    for start in Start::ALL {
        let at = At {
            start: Some(start),
            ..at
        };
        let (profile, iterations) = (&profiles[start as usize], iterations[start as usize]);
        let task = tasks.iter().position(|t| *t == (start, Limit::Default));
        let solves = task.map_or(0, |task| counts[task].len()) as f64;
        if iterations == 0.0 {
            continue;
        }
        let each = profile.iterating() as f64 / iterations;
        rows.add(&at, "cycles an iteration", "mean", each, "cycles");
        for part in Part::ALL {
            let cycles = profile.parts.get(&part).copied().unwrap_or(0) as f64 / solves;
            let metric = format!("cycles of {}", part.name());
            rows.add(&at, &metric, "mean", cycles, "cycles");
        }
        for (class, (instructions, cycles)) in &profile.classes {
            let metric = format!("instructions: {}", class.name());
            rows.add(
                &at,
                &metric,
                "mean",
                *instructions as f64 / solves,
                "instructions",
            );
            let metric = format!("cycles: {}", class.name());
            rows.add(&at, &metric, "mean", *cycles as f64 / solves, "cycles");
        }
    }
    let mut stack = 0;
    for work in works
        .iter()
        .take(if in_software { STACKS / 10 } else { STACKS })
    {
        bench.bearing(&work.design)?;
        for state in [work.cold, work.warm] {
            let question = workload::question(state, variant.precision, Limit::Default);
            stack = stack.max(bench.stack(&question)?);
        }
    }
    let memory = Memory::of(&bench)?;
    for (metric, value) in [
        ("flash", memory.flash() as f64),
        ("state", f64::from(memory.state)),
        ("constants", f64::from(memory.constants)),
        ("worst stack", f64::from(stack)),
    ] {
        rows.add(&at, metric, "value", value, "bytes");
    }
    for (size, symbol) in &memory.symbols {
        rows.add(
            &at,
            &format!("flash of {symbol}"),
            "value",
            *size as f64,
            "bytes",
        );
    }
    // As many of its balls as are measured most.
    if variant.balls == EVERYDAY_BALLS {
        let everyday = Work::everyday();
        bench.bearing(&everyday.design)?;
        for (start, state) in Start::ALL.into_iter().zip([everyday.cold, everyday.warm]) {
            let solve = bench.solve(&workload::question(
                state,
                variant.precision,
                Limit::Default,
            ))?;
            let at = At {
                start: Some(start),
                ..at
            };
            let metric = "cycles of the everyday case";
            rows.add(&at, metric, "value", solve.cycles as f64, "cycles");
            let metric = "instructions of the everyday case";
            rows.add(
                &at,
                metric,
                "value",
                solve.instructions as f64,
                "instructions",
            );
            let metric = "iterations of the everyday case";
            rows.add(&at, metric, "value", solve.answer.iterations.into(), "1");
        }
    }
    Ok(rows)
}

fn bits(values: &[f64; 5]) -> [u64; 5] {
    values.map(f64::to_bits)
}
