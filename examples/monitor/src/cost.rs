//! Cost of a tick on cores that were measured. `cargo reports --check` holds it against the figures of the repository's
//! page `docs/report.md`.

use crate::tick::CycleCost;

impl CycleCost {
    /// Cortex-M4F: modelled.
    pub const CORTEX_M4F: Self = Self {
        tick: 12_500,
        ball: 1_050,
        ball_report: 740,
        pass: 9_000,
        ball_pass: 2_490,
    };
    /// Cortex-M7, likewise.
    pub const CORTEX_M7: Self = Self {
        tick: 9_000,
        ball: 750,
        ball_report: 485,
        pass: 6_500,
        ball_pass: 1_820,
    };
}
