//! Frequencies of the core and of what divides its own from them.

/// The clock that was reached.
#[derive(Clone, Copy)]
pub struct Clock {
    /// Where it comes from.
    pub source: &'static str,
    /// Frequency of the core, Hz.
    pub core_hz: u32,
    /// Frequency that the monitor's port divides its baud rate from, Hz.
    pub usart_hz: u32,
    /// Frequency that USART2, the log's port, divides its baud rate from, Hz.
    pub log_hz: u32,
    /// Frequency that TIM2 counts from, Hz.
    pub timer_hz: u32,
}

impl Clock {
    /// The internal oscillator at this frequency, for all.
    pub const fn internal(hz: u32) -> Self {
        Self {
            source: "InternalWithoutPll",
            core_hz: hz,
            usart_hz: hz,
            log_hz: hz,
            timer_hz: hz,
        }
    }
}
