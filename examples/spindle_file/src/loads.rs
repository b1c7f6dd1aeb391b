//! Loads, speed, temperatures and displacements of one instant.

use crate::probes::MOST_PROBES;

/// Measured values of one instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LoadRow {
    /// Time, s.
    pub time_s: f64,
    /// Load on the inner ring `(Fx, Fy, Fz, My, Mz)`, N and N m.
    pub load: [f64; 5],
    /// Shaft speed, revolutions per minute.
    pub speed_rpm: f64,
    /// Temperatures of the inner and of the outer side, degrees Celsius, if the file has them.
    pub temperatures: Option<[f64; 2]>,
    /// Displacements that the wanted probes measured, um; none of an empty field.
    pub probes: [Option<f64>; MOST_PROBES],
}

impl LoadRow {
    /// Shaft speed `omega`, rad/s.
    pub fn omega(&self) -> f64 {
        self.speed_rpm * std::f64::consts::PI / 30.0
    }
}

/// Refuses a temperature that no bearing survives: mostly one in kelvin.
pub fn celsius(t: f64) -> Result<f64, String> {
    if t > 200.0 {
        return Err(format!(
            "{t} is above 200 deg C; is it in kelvin or degrees Fahrenheit?"
        ));
    }
    Ok(t)
}
