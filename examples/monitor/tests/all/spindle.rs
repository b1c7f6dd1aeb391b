//! The spindle that the firmware is shipped for: two bearings back to back on a hollow shaft in a housing that gives way.

use mock::rig::{B7005C, BEARING};
use spindle_bearing::{
    Arrangement, ElasticSpindle, Expansion, Facing, Material, Mounted, Preload, Section, Shaft,
    Spindle, Support,
};
use spindle_monitor::settings::{MonitorSettings, RowSettings};
use spindle_monitor::temperature::TemperatureSettings;
use spindle_monitor::tick::{Core, TickSettings};

/// Bore of the shaft, m.
pub(super) const BORE: f64 = 0.010;
/// Half of the rows' distance, m: back to back, a longer shaft takes preload away.
pub(super) const REACH: f64 = -0.05;

/// Nose and shaft.
pub(super) const SECTIONS: [Section; 2] =
    [section(0.0, 0.022, 0.032), section(0.022, 0.160, 0.025)];

const fn section(from: f64, to: f64, outer: f64) -> Section {
    Section {
        from,
        to,
        outer,
        inner: BORE,
    }
}

static SHAFT: Shaft<f32, 2> = Shaft::<f32, 2>::const_new(&SECTIONS, &Material::STEEL);

/// The spindle.
pub(super) static SPINDLE: ElasticSpindle<'static, f32, 2, 16> = {
    const fn row(position: f32, facing: Facing) -> Mounted<'static, f32, 16> {
        Mounted::new(&BEARING, position, facing).with(Preload::Force(250.0))
    }
    const HOUSING: Support<f32> = Support {
        axial: 400e6,
        radial: 300e6,
        tilting: f32::INFINITY,
    };
    let rows = [row(0.03, Facing::PlusX), row(0.13, Facing::MinusX)];
    Spindle::<f32, 2, 16>::const_new(Arrangement::BackToBack, rows)
        .const_elastic(&SHAFT, [HOUSING; 2])
};

/// Settings of its monitor on an STM32F405.
pub(super) static MONITOR: MonitorSettings<2> = {
    const MOST: [f64; 5] = [1700.0, 1700.0, 1700.0, 85.0, 85.0];
    let mut settings = MonitorSettings::new(&B7005C, 16);
    settings.rows = [RowSettings::new(&B7005C, 16)
        .with_heat(&B7005C, &Expansion::STEEL, REACH)
        .with_rotation(&B7005C, BORE); 2];
    settings.temperatures = Some(TemperatureSettings::SPINDLE);
    settings.tick = TickSettings::new(1000, Core::STM32F405.hz, Core::STM32F405.cost);
    let mut i = 0;
    while i < 5 {
        settings.set_range(i, [-MOST[i], MOST[i]]);
        settings.plausibility.load_rate[i] = (660e3 / 1700.0 * MOST[i]) as f32;
        i += 1;
    }
    settings
};
