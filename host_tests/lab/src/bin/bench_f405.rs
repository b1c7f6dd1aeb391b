//! The bench of an STM32F405, for `cargo bench-f405`: clock, flash and log are those of the firmware.

#![no_std]
#![no_main]

#[cortex_m_rt::entry]
fn main() -> ! {
    lab::on_board::run(spindle_firmware::stm32::start())
}
