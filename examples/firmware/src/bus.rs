//! A bus that exchanges bytes, as the converter's driver wants it. Without any hardware, so that it is tested on
//! the host.

use embedded_hal::delay::DelayNs;
use embedded_hal::spi::{ErrorKind, ErrorType, Operation, SpiDevice};

/// `exchange` sends a byte and returns the one that comes in meanwhile, or none if the bus is dead. There is no
/// chip select: the converter's driver sets that by itself.
pub struct Bus<X, D> {
    exchange: X,
    delay: D,
}

impl<X: FnMut(u8) -> Option<u8>, D: DelayNs> Bus<X, D> {
    /// By these two.
    pub const fn new(exchange: X, delay: D) -> Self {
        Self { exchange, delay }
    }
}

impl<X, D> ErrorType for Bus<X, D> {
    type Error = ErrorKind;
}

impl<X: FnMut(u8) -> Option<u8>, D: DelayNs> SpiDevice for Bus<X, D> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        let mut exchange = |byte| (self.exchange)(byte).ok_or(ErrorKind::Other);
        for operation in operations {
            match operation {
                Operation::Read(to) => {
                    for to in to.iter_mut() {
                        *to = exchange(0)?;
                    }
                }
                Operation::Write(from) => {
                    for byte in from.iter() {
                        exchange(*byte)?;
                    }
                }
                // The shorter one is made up for, by zeros or by nothing.
                Operation::Transfer(to, from) => {
                    for i in 0..to.len().max(from.len()) {
                        let byte = exchange(from.get(i).copied().unwrap_or(0))?;
                        if let Some(to) = to.get_mut(i) {
                            *to = byte;
                        }
                    }
                }
                Operation::TransferInPlace(bytes) => {
                    for byte in bytes.iter_mut() {
                        *byte = exchange(*byte)?;
                    }
                }
                Operation::DelayNs(ns) => self.delay.delay_ns(*ns),
            }
        }
        Ok(())
    }
}
