//! Cycles and memory that a spindle takes of its board: cycles by the measured costs of a tick's parts, memory as the image was
//! linked, the stack by the frames on its longest way of calls.

use anyhow::{Context, Result, ensure};
use object::{Object, ObjectSegment, ObjectSymbol};
use spindle_firmware::spindle::{BALLS, JOINTS, PERIOD_US, ROWS, SPINDLE, monitor_settings};
use spindle_monitor::tick::CycleCost;
use twin::graph::Graph;

/// Memory that an image is loaded into: 0x08000000 is flash.
const RAM: u64 = 0x2000_0000;
/// Passes over all rows that a solve takes, from a steady load to a tooth's.
const PASSES: [u32; 2] = [2, 4];

/// A line on the spindle and its firmware, for the core with this name.
///
/// # Errors
///
/// RAM has no room for the stack; the ELF is no firmware.
pub fn budget(elf: &[u8], core: &str) -> Result<String> {
    let settings = match core {
        "STM32H743" => monitor_settings(400_000_000, CycleCost::CORTEX_M7),
        _ => monitor_settings(168_000_000, CycleCost::CORTEX_M4F),
    };
    let (tick, counts) = (&settings.tick, SPINDLE.ball_counts());
    let balls = counts.iter().map(|count| u32::from(*count)).sum();
    let cost = tick.cost.of(ROWS as u32, balls, BALLS as u32);
    let pass = tick.cost.ball_row * balls + cost.step;
    let free = (tick.deadline_cycles - tick.cost.tick) as f32;
    // A sample waits for the solve that has begun, then for its own.
    let [young, old] = PASSES.map(|passes| {
        (passes * pass + cost.step + cost.open + cost.look * ROWS as u32) as f32 / free
    });
    let ms = PERIOD_US as f32 * 1e-3;
    let (young, old) = (young.ceil() * ms, 2.0 * old.ceil() * ms);

    let file = object::File::parse(elf)?;
    let flash: u64 = file
        .segments()
        .filter(|part| part.address() < RAM)
        .map(|part| part.size())
        .sum();
    let symbol = |name: &str| {
        let symbol = file.symbols().find(|symbol| symbol.name() == Ok(name));
        symbol
            .map(|symbol| symbol.address())
            .with_context(|| format!("there is no {name}: this is no firmware of the monitor"))
    };
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
    if old * 1e3 > settings.plausibility.fresh_us as f32 {
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
