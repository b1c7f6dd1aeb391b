//! Forces of cuts at the tool, tick by tick: teeth that pass, and ramps.

use std::f64::consts::PI;

/// Ticks of a cut, 1 ms each.
pub const TICKS: u32 = 3000;

/// Teeth that have passed at a tick: a little off the rate of the ticks, which thereby meet every part of a half-sine.
pub fn passed(tick: u32, per_second: f64) -> f64 {
    per_second * 1.0007e-3 * f64::from(tick)
}

/// Part of a tooth's largest load after so many teeth have passed, a half-sine: each cuts for a part of the time between two.
pub fn tooth(passed: f64, in_cut: f64) -> f64 {
    let part = passed.fract() / in_cut;
    if part < 1.0 { (PI * part).sin() } else { 0.0 }
}

/// Teeth or ramps.
pub struct Cut {
    /// Name in failure messages.
    pub name: String,
    /// Force at a tick, N.
    pub force: Box<dyn Fn(u32) -> [f64; 3] + Send + Sync>,
}

/// Cuts of all kinds.
pub fn cuts() -> Vec<Cut> {
    let mut cuts = Vec::new();
    // Teeth follow each other without a pause, or with one as long as a tooth's time in the cut.
    for per_second in [50.0, 125.0, 200.0, 400.0] {
        for amplitude in [200.0, 500.0, 1000.0] {
            for in_cut in [1.0, 0.5] {
                let part = move |tick| tooth(passed(tick, per_second), in_cut);
                cuts.push(Cut {
                    name: format!("{per_second} teeth/s of {amplitude} N, {in_cut} in the cut"),
                    force: Box::new(move |tick| [0.0, amplitude * part(tick), 0.0]),
                });
            }
        }
    }
    // From idling to so much more and back, along the shaft and in each radial direction.
    const FORCE: f64 = 2500.0;
    /// At each end, ms: not in step with the ticks.
    const PAUSE: f64 = 20.3;
    for rate in [50.0, 100.0, 200.0] {
        for along in [
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, -1.0, 0.0],
            [0.0, 0.0, 1.0],
            [0.0, 0.0, -1.0],
            [0.0, 0.6, 0.8],
        ] {
            let rise = FORCE / rate;
            let force = move |tick| {
                let at = f64::from(tick) % (2.0 * (rise + PAUSE));
                let (up, down) = (at - PAUSE, 2.0 * (PAUSE + rise) - at);
                let size = (rate * up.min(down)).clamp(0.0, FORCE);
                along.map(|part| part * size)
            };
            cuts.push(Cut {
                name: format!("{rate} N/ms along {along:?}"),
                force: Box::new(force),
            });
        }
    }
    cuts
}
