//! What a tick costs on cores that were measured. Made by `cargo reports monitor`; `docs/report.md` has the
//! whole of it.

use super::tick::CycleCost;

impl CycleCost {
    /// Cortex-M4F, single precision, 16 balls, raceway control free: modelled.
    pub const CORTEX_M4F: Self = Self {
        fixed: 29_869,
        start: 25_984,
        iteration: 19_302,
    };
    /// Cortex-M7, double precision, likewise.
    pub const CORTEX_M7: Self = Self {
        fixed: 37_058,
        start: 41_757,
        iteration: 43_261,
    };
}
