//! The bench of an STM32H743, for `cargo bench-h743`: clock, caches and log are those of the firmware.

#![no_std]
#![no_main]

#[cortex_m_rt::entry]
fn main() -> ! {
    lab::on_board::run(spindle_firmware::stm32::start())
}
