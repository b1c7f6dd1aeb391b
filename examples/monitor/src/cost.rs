//! Cost of a tick on cores that were measured. `cargo reports --check` holds it against the figures of the repository's
//! page `docs/report.md`. `probe` was measured with two probes at the shipped spindle, whose ticks then stay within their period:
//! 1,000 cycles in any tick of a Cortex-M4F, 2,700 for the displacement where a solve ends, some 1,000 where a block ends. `filter` was
//! measured with two probes (26,200 cycles of a load step; 15,500 of a Cortex-M7) and with four (55,200 of a Cortex-M7).

use crate::tick::{Core, CycleCost};

impl CycleCost {
    /// Cortex-M4F, rows on an elastic shaft: modelled.
    pub const CORTEX_M4F: Self = Self {
        tick: 18_800,
        ball_row: 2_950,
        step: 4_000,
        ball_step: 500,
        rows_step: 350,
        open: 2_000,
        ball_look: 1_075,
        ball_report: 1_170,
        probe: 2_500,
        ball_slopes: 1_000,
        filter: 740,
    };
    /// Cortex-M7, likewise.
    pub const CORTEX_M7: Self = Self {
        tick: 6_000,
        ball_row: 2_290,
        step: 4_000,
        ball_step: 330,
        rows_step: 250,
        open: 8_200,
        ball_look: 610,
        ball_report: 680,
        probe: 1_500,
        ball_slopes: 700,
        filter: 440,
    };
}

impl Core {
    /// That of an STM32F405, at its highest frequency.
    pub const STM32F405: Self = Self {
        chip: "STM32F405",
        hz: 168_000_000,
        cost: CycleCost::CORTEX_M4F,
    };
    /// That of an STM32H743, at the frequency that every revision reaches.
    pub const STM32H743: Self = Self {
        chip: "STM32H743",
        hz: 400_000_000,
        cost: CycleCost::CORTEX_M7,
    };
}
