//! The monitored spindle: constants of its file, for boards and for the host's own build.
//!
//! The build script makes them of the file that `SPINDLE` names in the environment, or of the shipped `spindle.toml`.

use crate::bridges::Calibration;
use crate::tachometer::SpeedSettings;
use spindle_bearing::{
    Arrangement, Bearing, Design, Facing, FreeContact, Growth, LifeRating, Material, Mounted,
    Preload, Spindle,
};
use spindle_monitor::alarms::Threshold;
use spindle_monitor::plausibility::PlausibilitySettings;
use spindle_monitor::settings::{MonitorSettings, ResponseSettings, TelemetrySettings};
use spindle_monitor::tick::{Core, TickSettings};
use spindle_monitor::{Identity, RowSettings, ShaftSettings};

include!(concat!(env!("OUT_DIR"), "/spindle.rs"));
