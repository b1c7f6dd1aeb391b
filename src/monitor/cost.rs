//! What a tick costs on cores that were measured. Made by `cargo reports monitor`; `docs/report.md` has the
//! whole of it.

use super::tick::CycleCost;

impl CycleCost {
    /// Cortex-M4F, single precision, 16 balls, raceway control free: modelled.
    pub const CORTEX_M4F: Self = Self {
        fixed: 25_706,
        start: 25_728,
        iteration: 21_187,
    };
    /// Cortex-M7, double precision, likewise.
    pub const CORTEX_M7: Self = Self {
        fixed: 27_170,
        start: 42_891,
        iteration: 44_855,
    };
}
