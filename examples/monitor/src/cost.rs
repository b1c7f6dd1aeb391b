//! Cost of a tick on cores that were measured. `cargo reports --check` holds it against the figures of the repository's
//! page `docs/report.md`.

use crate::tick::CycleCost;

impl CycleCost {
    /// Cortex-M4F, rows on an elastic shaft: modelled.
    pub const CORTEX_M4F: Self = Self {
        tick: 13_000,
        ball: 1_300,
        ball_report: 1_030,
        pass: 22_900,
        ball_pass: 2_490,
    };
    /// Cortex-M7, likewise.
    pub const CORTEX_M7: Self = Self {
        tick: 5_800,
        ball: 1_000,
        ball_report: 610,
        pass: 12_800,
        ball_pass: 1_820,
    };
}
