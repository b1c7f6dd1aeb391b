//! Cost of a tick on cores that were measured. `cargo reports --check` holds it against the figures of the repository's
//! page `docs/report.md`.

use super::tick::CycleCost;

impl CycleCost {
    /// Cortex-M4F, single precision, two rows of 16 balls, raceway control free: modelled.
    pub const CORTEX_M4F: Self = Self {
        fixed: 59_243,
        iteration: 36_098,
    };
    /// Cortex-M7, double precision, likewise.
    pub const CORTEX_M7: Self = Self {
        fixed: 95_102,
        iteration: 83_850,
    };
    /// The first with a single row of 16 balls: `SPINDLE_ROWS=1 cargo reports --check` has measured it.
    pub const CORTEX_M4F_SINGLE: Self = Self {
        fixed: 42_034,
        iteration: 17_959,
    };
    /// The second, likewise.
    pub const CORTEX_M7_SINGLE: Self = Self {
        fixed: 58_299,
        iteration: 41_357,
    };
}
