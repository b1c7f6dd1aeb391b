//! Cost of a tick on cores that were measured. `cargo reports --check` holds it against the figures of the page
//! `docs/report.md`.

use super::tick::CycleCost;

impl CycleCost {
    /// Cortex-M4F, single precision, two rows of 16 balls, raceway control free: modelled.
    pub const CORTEX_M4F: Self = Self {
        fixed: 59_598,
        iteration: 35_825,
    };
    /// Cortex-M7, double precision, likewise.
    pub const CORTEX_M7: Self = Self {
        fixed: 97_773,
        iteration: 83_617,
    };
    /// The first with a single row of 16 balls: `SPINDLE_ROWS=1 cargo reports --check` has measured it.
    pub const CORTEX_M4F_SINGLE: Self = Self {
        fixed: 44_693,
        iteration: 17_853,
    };
    /// The second, likewise.
    pub const CORTEX_M7_SINGLE: Self = Self {
        fixed: 64_221,
        iteration: 41_421,
    };
}
