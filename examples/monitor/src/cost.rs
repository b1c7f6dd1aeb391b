//! Cost of a tick on cores that were measured. `cargo reports --check` holds it against the figures of the repository's
//! page `docs/report.md`.

use crate::tick::CycleCost;

impl CycleCost {
    /// Cortex-M4F, rows on an elastic shaft: modelled.
    pub const CORTEX_M4F: Self = Self {
        tick: 13_800,
        ball_row: 2_950,
        step: 10_000,
        ball_step: 500,
        ball_look: 1_090,
        ball_report: 1_190,
    };
    /// Cortex-M7, likewise.
    pub const CORTEX_M7: Self = Self {
        tick: 5_800,
        ball_row: 2_290,
        step: 8_000,
        ball_step: 330,
        ball_look: 760,
        ball_report: 690,
    };
}
