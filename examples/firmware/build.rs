//! Makes the monitored spindle of its file: constants in Rust, of which the compiler makes bearings, shaft and spindle.
//!
//! `SPINDLE` in the environment names the file, from the root of the checkout on. Without it, `spindle.toml` beside this
//! script counts. Errors are those of `cargo replay`, with line and column.

use spindle_bearing::{Design, Preload, Support};
use spindle_file::monitors::Sensors;
use spindle_file::mounting::board;
use spindle_file::mounting::preload::response;
use spindle_file::plan::{Plan, Row};
use spindle_file::probes::MOST_PROBES;
use spindle_file::spindles::SpindleFile;
use spindle_monitor::tick::Core;
use spindle_monitor::{MonitorSettings, ResponseSettings};
use std::fmt::Write;
use std::path::{Path, PathBuf};

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

fn main() {
    println!("cargo::rerun-if-env-changed=SPINDLE");
    if let Err(error) = make() {
        for line in error.to_string().lines() {
            println!("cargo::error={line}");
        }
    }
}

fn make() -> Result<()> {
    let here = PathBuf::from(std::env::var("CARGO_MANIFEST_DIR")?);
    let path = match std::env::var_os("SPINDLE") {
        // An absolute path stays, and so does a name of the catalogue.
        Some(path) if here.join("../..").join(&path).exists() => here.join("../..").join(path),
        Some(name) => name.into(),
        None => here.join("spindle.toml"),
    };
    let file = SpindleFile::read(&path)?;
    for path in file.files().filter(|path| path.exists()) {
        println!("cargo::rerun-if-changed={}", path.display());
    }
    for doubt in &file.doubts {
        println!("cargo::warning={doubt}");
    }
    let board = chosen_board();
    if let Some((folder, _)) = board {
        // A linker finds `chip.x` there before that of the project's configuration.
        println!("cargo::rustc-link-search={}", here.join(folder).display());
    }
    let plan = board::plan(&file, board.map(|(_, core)| core))?;
    let to = Path::new(&std::env::var("OUT_DIR")?).join("spindle.rs");
    Ok(std::fs::write(to, constants(&file, &plan)?)?)
}

/// Folder and core of the board that this is built for; none for a host, which has no ticks to miss.
fn chosen_board() -> Option<(&'static str, Core)> {
    let is_for = |feature: &str| std::env::var_os(feature).is_some();
    let h743 = is_for("CARGO_FEATURE_H743").then_some(("h743", Core::STM32H743));
    h743.or(is_for("CARGO_FEATURE_F405").then_some(("f405", Core::STM32F405)))
}

/// The spindle and its settings as Rust.
fn constants(file: &SpindleFile, plan: &Plan) -> Result<String> {
    let mut text = String::new();
    spindle(&mut text, plan)?;
    sensors(&mut text, file)?;
    probes(&mut text, file)?;
    settings(&mut text, file)?;
    Ok(text)
}

/// A number in single precision, as Rust writes it.
fn number(x: f64) -> String {
    match x {
        f64::INFINITY => "f32::INFINITY".into(),
        f64::NEG_INFINITY => "f32::NEG_INFINITY".into(),
        _ => format!("{:?}", x as f32),
    }
}

/// Some of them, as an array.
fn numbers(all: impl IntoIterator<Item = f64>) -> String {
    let all: Vec<String> = all.into_iter().map(number).collect();
    format!("[{}]", all.join(", "))
}

fn spindle(text: &mut String, plan: &Plan) -> Result<()> {
    let Plan { rows, shaft, .. } = plan;
    let most = rows.iter().map(|row| row.balls).max().unwrap_or_default();
    let joints = shaft.as_ref().map_or(0, |_| rows.len());
    let freedoms = if plan.spring.is_some() { 6 } else { 5 };
    for (name, size, means) in [
        ("ROWS", rows.len(), "Rows of balls."),
        ("BALLS", most, "Balls of the largest row."),
        (
            "FREEDOMS",
            freedoms,
            "Freedoms of the shaft, with the one of a sprung sleeve.",
        ),
        ("JOINTS", joints, "Rows on an elastic shaft."),
    ] {
        writeln!(text, "/// {means}\npub const {name}: usize = {size};")?;
    }
    // Alike bearings are one.
    let mut bearings: Vec<(&Design, usize)> = Vec::new();
    let mut mounted = String::new();
    for Row {
        balls,
        design,
        position,
        facing,
        preload,
    } in rows
    {
        let known = bearings.iter().position(|known| *known == (design, *balls));
        let bearing = known.unwrap_or_else(|| {
            bearings.push((design, *balls));
            bearings.len() - 1
        });
        let preload = match preload {
            Preload::Closure(e) => format!("Closure({})", number(*e)),
            Preload::Force(force) => format!("Force({})", number(*force)),
            _ => "Spring".into(),
        };
        writeln!(
            mounted,
            "Mounted::new(&BEARING_{bearing}, {}, Facing::{facing:?}).with(Preload::{preload}),",
            number(*position)
        )?;
    }
    for (i, (design, balls)) in bearings.into_iter().enumerate() {
        writeln!(
            text,
            "/// A bearing's design.\n\
             pub const DESIGN_{i}: Design = {{ use FreeContact::*; {design:?} }};\n\
             /// The bearing of that design.\n\
             pub static BEARING_{i}: Bearing<f32, {balls}> = Bearing::<f32, {balls}>::const_new(&DESIGN_{i});"
        )?;
    }
    let (make, spring) = match plan.spring {
        Some(force) => ("const_sprung", format!(", {}", number(force))),
        None => ("const_new", String::new()),
    };
    let mut on_shaft = String::new();
    if let Some(shaft) = shaft {
        let (sections, said) = (shaft.sections.len(), &shaft.sections);
        writeln!(
            text,
            "static SHAFT: spindle_bearing::Shaft<f32, {sections}> = {{\n\
             use spindle_bearing::*;\n\
             Shaft::<f32, {sections}>::const_new(&{said:?}, &{:?})\n}};",
            shaft.material
        )?;
        on_shaft += ".const_elastic(&SHAFT, [";
        for Support {
            axial,
            radial,
            tilting,
        } in &shaft.supports
        {
            let [axial, radial, tilting] = [axial, radial, tilting].map(|k| number(*k));
            write!(
                on_shaft,
                "spindle_bearing::Support {{ axial: {axial}, radial: {radial}, tilting: {tilting} }}, "
            )?;
        }
        on_shaft += "])";
        if !shaft.loads.is_empty() {
            writeln!(
                text,
                "static LOADS: [spindle_bearing::ShaftLoad<f32>; {}] = [",
                shaft.loads.len()
            )?;
            for at in &shaft.loads {
                let (position, load) = (number(at.position), numbers(at.load));
                writeln!(
                    text,
                    "spindle_bearing::ShaftLoad {{ position: {position}, load: {load} }},"
                )?;
            }
            writeln!(text, "];")?;
            on_shaft += ".const_with_loads(&LOADS)";
        }
    }
    writeln!(
        text,
        "/// The spindle.\npub static SPINDLE: Spindle<'static, f32, ROWS, BALLS, FREEDOMS, JOINTS> = \
         Spindle::<f32, ROWS, BALLS{}>::{make}(Arrangement::{:?}, [{mounted}]{spring}){on_shaft};",
        if freedoms == 6 { ", 6" } else { "" },
        plan.arrangement
    )?;
    let load = known_load(plan);
    Ok(writeln!(
        text,
        "/// Axial load that the spindle carries in normal use, N, for a self check.\n\
         pub const KNOWN_LOAD: f32 = {load:?};"
    )?)
}

/// Of the size of the preload, or, without a preload as a force, of a thousandth of the load rating.
fn known_load(plan: &Plan) -> f32 {
    let forces = plan.rows.iter().map(|row| match row.preload {
        Preload::Force(force) => force,
        _ => row.design.dynamic_load_rating(row.balls) * 1e-3,
    });
    plan.spring.unwrap_or(forces.fold(0.0, f64::max)) as f32
}

/// Where loads and speed come from.
fn sensors(text: &mut String, file: &SpindleFile) -> Result<()> {
    let Sensors {
        idle,
        tachometer,
        bridges,
        tare_samples,
        ..
    } = &file.sensors;
    // Without bridges, nobody reads their calibration.
    let count = bridges.as_ref().map_or(5, |bridges| bridges.counts.len());
    let (mut loads, mut counts) = (String::new(), String::new());
    if let Some(bridges) = bridges {
        for load in 0..5 {
            write!(
                loads,
                "{},",
                numbers(bridges.loads.iter().map(|bridge| bridge[load]))
            )?;
        }
        for bridge in &bridges.counts {
            write!(counts, "{},", numbers(*bridge))?;
        }
    } else {
        (loads, counts) = ("[0.0; 5]; 5".into(), "[0.0; 5]; 5".into());
    }
    Ok(writeln!(
        text,
        "/// Loads of the idling spindle (N, N m), to start from.\n\
         pub const IDLE: [f32; 5] = {idle:?};\n\
         /// Whether loads and speed come from strain bridges and a tachometer at the board, not as records over the port.\n\
         pub const BRIDGES: bool = {};\n\
         /// Bridges.\n\
         pub const CHANNELS: usize = {count};\n\
         /// Calibration of the bridges.\n\
         pub const CALIBRATION: Calibration<CHANNELS> = {{\n\
         let mut calibration = Calibration::new([{loads}], [{counts}]);\n\
         calibration.standing = IDLE;\n\
         calibration\n}};\n\
         const _: () = assert!(!BRIDGES || CALIBRATION.check().is_ok());\n\
         /// Samples of a tare.\n\
         pub const TARE_SAMPLES: u16 = {};\n\
         /// The tachometer's pulses, at a timer of 1 MHz.\n\
         pub const TACHOMETER: SpeedSettings = SpeedSettings {{\n\
         pulses_per_revolution: {},\ntimer_hz: 1_000_000,\ntimer_bits: 32,\ncounter_bits: 32,\n\
         count_above: {:?},\nperiod_below: {:?},\ngate_us: {},\nstandstill_us: {},\ndeceleration: {:?},\n}};",
        bridges.is_some(),
        tare_samples,
        tachometer.pulses_per_revolution,
        tachometer.count_above,
        tachometer.period_below,
        tachometer.gate_us,
        tachometer.standstill_us,
        file.settings(&Core::STM32F405).plausibility.deceleration,
    )?)
}

fn probes(text: &mut String, file: &SpindleFile) -> Result<()> {
    let response = match file.probes.len() {
        0 => format!("{:?}", ResponseSettings::NONE),
        1 => format!("{:?}", response::<1>(file)?),
        2 => format!("{:?}", response::<2>(file)?),
        3 => format!("{:?}", response::<3>(file)?),
        _ => format!("{:?}", response::<MOST_PROBES>(file)?),
    };
    let channels = file.probes.iter().map(|probe| probe.channel);
    let channels: Option<Vec<_>> = channels.collect();
    let channels = channels.filter(|channels| !channels.is_empty());
    let channels = channels.map(|all| {
        all.into_iter()
            .map(|(channel, um)| (channel, um as f32))
            .collect::<Vec<_>>()
    });
    Ok(writeln!(
        text,
        "/// Whose data are kept over a power cycle: another spindle does not take them.\n\
         pub const IDENTITY: Identity = Identity::of({:#x}, {:#x});\n\
         /// Probes.\n\
         pub const PROBES: usize = {};\n\
         /// Channels of the converter that the probes are at, and um per count; none for readings over the port.\n\
         pub const PROBE_CHANNELS: Option<[(usize, f32); PROBES]> = {channels:?};\n\
         /// Settings of the probes.\n\
         pub static RESPONSE: ResponseSettings<PROBES> = {{\n\
         #[allow(unused_imports, reason = \"a spindle without probes\")]\n\
         use spindle_monitor::{{ProbeSettings, preload::{{PreloadBy::*, PreloadLaw}}}};\n\
         {response}\n}};\n\
         const _: () = assert!(RESPONSE.check().is_ok());",
        file.bearings_checksum(),
        file.displacements_checksum(),
        file.probes.len()
    )?)
}

/// The settings of the monitor. Each board has a core of its own.
fn settings(text: &mut String, file: &SpindleFile) -> Result<()> {
    let MonitorSettings {
        rows,
        shaft,
        temperatures,
        tick,
        tolerance,
        accuracy,
        plausibility,
        overload,
        alarms,
        telemetry,
    } = file.settings(&Core::STM32F405);
    let rows = &rows[..file.plan.rows.len()];
    let temperatures = match temperatures {
        Some(temperatures) => format!("Some(spindle_monitor::{temperatures:?})"),
        None => "None".to_owned(),
    };
    Ok(writeln!(
        text,
        "/// Period of a tick, us.\n\
         pub const PERIOD_US: u32 = {};\n\
         /// Settings of the monitor on this core.\n\
         pub const fn monitor_settings(core: &Core) -> MonitorSettings<ROWS> {{\n\
         let settings = MonitorSettings {{\n\
         rows: {rows:?}, shaft: {shaft:?}, temperatures: {temperatures},\n\
         tick: TickSettings::new(PERIOD_US, core.hz, core.cost.with_probes(PROBES)),\n\
         tolerance: {tolerance:?}, accuracy: {accuracy:?}, plausibility: {plausibility:?},\n\
         overload: {overload:?}, alarms: {alarms:?}, telemetry: {telemetry:?}\n\
         }};\n\
         match settings.check() {{\n\
         Ok(()) => settings,\n\
         Err(error) => panic!(\"{{}}\", error.field),\n\
         }}\n}}",
        tick.period_us
    )?)
}
