//! What a tick costs on cores that were measured. `cargo reports --check` holds it against the figures of the page
//! `docs/report.md`.

use super::tick::CycleCost;

impl CycleCost {
    /// Cortex-M4F, single precision, two rows of 16 balls, raceway control free: modelled.
    pub const CORTEX_M4F: Self = Self {
        fixed: 57_963,
        iteration: 36_221,
    };
    /// Cortex-M7, double precision, likewise.
    pub const CORTEX_M7: Self = Self {
        fixed: 92_250,
        iteration: 83_233,
    };
    /// The first with a single row of 16 balls: `SPINDLE_ROWS=1 cargo reports --check` has measured it.
    pub const CORTEX_M4F_SINGLE: Self = Self {
        fixed: 33_658,
        iteration: 20_799,
    };
    /// The second, likewise.
    pub const CORTEX_M7_SINGLE: Self = Self {
        fixed: 49_523,
        iteration: 44_375,
    };
}
