//! What a tick costs on cores that were measured. Made by `cargo reports monitor`; `docs/report.md` has the
//! whole of it.

use super::tick::CycleCost;

impl CycleCost {
    /// Cortex-M4F, single precision, 16 balls, raceway control free: modelled.
    pub const CORTEX_M4F: Self = Self {
        fixed: 29_763,
        start: 28_267,
        iteration: 19_280,
    };
    /// Cortex-M7, double precision, likewise.
    pub const CORTEX_M7: Self = Self {
        fixed: 37_266,
        start: 43_839,
        iteration: 43_269,
    };
}
