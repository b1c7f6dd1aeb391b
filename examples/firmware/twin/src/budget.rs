//! Cycles and memory that a spindle takes of its board: cycles by the measured costs of a tick's parts, memory as the image was
//! linked, the stack by the frames on its longest way of calls.

use anyhow::{Context, Result, ensure};
use object::{Object, ObjectSegment, ObjectSymbol};
use spindle_bearing::{RacewayControlFree, Settings, Speed, SpindleSolver};
use spindle_firmware::spindle::{
    BALLS, FREEDOMS, IDLE, JOINTS, PERIOD_US, ROWS, SPINDLE, monitor_settings,
};
use spindle_monitor::MonitorSettings;
use spindle_monitor::tick::Core;
use std::array::from_fn;
use twin::graph::Graph;

/// Memory that an image is loaded into: 0x08000000 is flash.
const RAM: u64 = 0x2000_0000;
/// Change of a steady load from one solve to the next: that of a warm solve in docs/report.md.
const STEADY: f32 = 0.01;

/// Passes over all rows that a solve of this spindle takes at rest: of a steady load, and of a tooth's.
///
/// A tooth's load has changed in each direction by as much as is plausible within a tick, or by the largest half, quarter .. of
/// that change which the rows carry.
fn passes(settings: &MonitorSettings<ROWS>) -> Option<[u32; 2]> {
    let mut solver = SpindleSolver::<_, ROWS, BALLS, RacewayControlFree, FREEDOMS, JOINTS>::of();
    let effort = Settings {
        tolerance: settings.tolerance,
        ..Settings::default()
    };
    let mut passes = |load: [f32; 5]| {
        let solved = solver.solve(&SPINDLE, load, Speed::rad_per_s(0.0), &effort);
        solved.ok().map(|solution| u32::from(solution.iterations))
    };
    let mut part = settings.tick.period_us as f32 * 1e-6;
    let rates = settings.plausibility.load_rate;
    let steady = IDLE.map(|load| load * (1.0 + STEADY));
    for _ in 0..10 {
        passes(IDLE)?;
        let young = passes(steady)?;
        if let Some(old) = passes(from_fn(|i| IDLE[i] + part * rates[i])) {
            return Some([young, old]);
        }
        part *= 0.5;
    }
    None
}

/// A line on the spindle and its firmware, for the chip that it was linked for.
///
/// # Errors
///
/// RAM has no room for the stack; the ELF is no firmware.
pub fn budget(elf: &[u8]) -> Result<String> {
    let file = object::File::parse(elf)?;
    let symbol = |name: &str| {
        let symbol = file.symbols().find(|symbol| symbol.name() == Ok(name));
        symbol
            .map(|symbol| symbol.address())
            .with_context(|| format!("there is no {name}: this is no firmware of the monitor"))
    };
    let core = match symbol("_chip")? {
        743 => Core::STM32H743,
        _ => Core::STM32F405,
    };
    let settings = monitor_settings(&core);
    let tick = &settings.tick;
    let balls = SPINDLE.ball_counts().map(u32::from).sum();
    let cost = tick.cost.of(ROWS as u32, balls, BALLS as u32);
    let pass = tick.cost.ball_row * balls + cost.step;
    let free = f64::from(tick.deadline_cycles - tick.cost.tick);
    // A sample waits for the solve that has begun, then for its own.
    let passes =
        passes(&settings).context("the idling spindle has no equilibrium to start from")?;
    let [young, old] = passes.map(|passes| {
        (passes * pass + cost.step + cost.open + cost.look * ROWS as u32) as f64 / free
    });
    let ms = f64::from(PERIOD_US) * 1e-3;
    let (young, old) = (young.ceil() * ms, 2.0 * old.ceil() * ms);

    let flash: u64 = file
        .segments()
        .filter(|part| part.address() < RAM)
        .map(|part| part.size())
        .sum();
    let top = symbol("_stack_start")?;
    let variables = symbol("__euninit")? - top;
    let left = top - symbol("_stack_end")?;
    let graph = Graph::read(elf)?;
    let stack = graph.stack()?;
    ensure!(
        stack.bytes <= left,
        "variables take {variables} B of RAM, and leave {left} B for the stack, which needs {} B: fewer rows, or fewer balls in the largest \
         row. The longest way of calls: {}",
        stack.bytes,
        stack.names.join(" -> ")
    );
    if old * 1e3 > f64::from(settings.plausibility.fresh_us) {
        eprintln!(
            "warning: estimates grow older than fresh_ms under [monitor.plausible], {} ms: the STM32H743, or a longer period_ms",
            settings.plausibility.fresh_us / 1000
        );
    }
    let rows = match ROWS {
        1 => "a row",
        _ => &format!("{ROWS} rows"),
    };
    let shaft = if JOINTS > 0 { "elastic" } else { "rigid" };
    Ok(format!(
        "{rows}, {balls} balls, {shaft}: a pass takes {} k cycles at most, {:.1} ticks of {ms} ms; estimates {young} to {old} ms old; \
         {} KiB of flash, {} KiB of RAM; stack: {} B at most, of {left} B",
        pass.div_ceil(1000),
        pass as f32 / tick.deadline_cycles as f32,
        flash.div_ceil(1024),
        variables.div_ceil(1024),
        stack.bytes,
    ))
}
