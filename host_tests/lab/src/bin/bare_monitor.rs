//! The monitor and nothing else, as `cargo check-firmware` wants it: see `bare_solver.rs`.

#![cfg_attr(target_os = "none", no_std)]
#![cfg_attr(target_os = "none", no_main)]

lab::image!(bare::run);

#[cfg(target_os = "none")]
mod bare {
    use core::convert::Infallible;
    use core::hint::black_box;
    use embedded_hal::delay::DelayNs;
    use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
    use embedded_hal::spi::{self, Operation, SpiDevice};
    use embedded_storage::nor_flash::{self, NorFlash, NorFlashErrorKind, ReadNorFlash};
    use spindle_firmware::bridges::{Ads131m08, Ads131m08Bridges, StrainBridge};
    use spindle_firmware::spindle::{
        self, CALIBRATION, CHANNELS, IDENTITY, TACHOMETER, monitor_settings,
    };
    use spindle_firmware::tachometer::{Edges, PulseSpeed, SpeedMethod, SpeedSource};
    use spindle_monitor::board::ResetCause;
    use spindle_monitor::loads::{FramedLoads, LoadSource};
    use spindle_monitor::record;
    use spindle_monitor::settings::MonitorSettings;
    use spindle_monitor::tick::{Core, CycleCounter, Watchdog, Widened};
    use spindle_monitor::{Alarm, Monitor, Readings, Store};

    static MONITOR: MonitorSettings<{ spindle::ROWS }> = monitor_settings(&Core::STM32F405);

    /// Pins, bus, cycles and watchdog that the compiler knows nothing of.
    struct Unknown;

    impl ErrorType for Unknown {
        type Error = Infallible;
    }
    impl InputPin for Unknown {
        fn is_high(&mut self) -> Result<bool, Infallible> {
            Ok(black_box(true))
        }
        fn is_low(&mut self) -> Result<bool, Infallible> {
            Ok(black_box(true))
        }
    }
    impl OutputPin for Unknown {
        fn set_low(&mut self) -> Result<(), Infallible> {
            Ok(())
        }
        fn set_high(&mut self) -> Result<(), Infallible> {
            Ok(())
        }
    }
    impl spi::ErrorType for Unknown {
        type Error = spi::ErrorKind;
    }
    impl SpiDevice for Unknown {
        fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Self::Error> {
            for operation in operations {
                if let Operation::TransferInPlace(bytes) | Operation::Read(bytes) = operation {
                    bytes.fill_with(|| black_box(0));
                }
            }
            black_box(Ok(()))
        }
    }
    impl DelayNs for Unknown {
        fn delay_ns(&mut self, _: u32) {}
    }
    impl nor_flash::ErrorType for Unknown {
        type Error = NorFlashErrorKind;
    }
    impl ReadNorFlash for Unknown {
        const READ_SIZE: usize = 4;
        fn read(&mut self, _: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
            bytes.fill_with(|| black_box(0));
            black_box(Ok(()))
        }
        fn capacity(&self) -> usize {
            black_box(0)
        }
    }
    impl NorFlash for Unknown {
        const WRITE_SIZE: usize = 4;
        const ERASE_SIZE: usize = 128 * 1024;
        fn erase(&mut self, _: u32, _: u32) -> Result<(), NorFlashErrorKind> {
            black_box(Ok(()))
        }
        fn write(&mut self, _: u32, _: &[u8]) -> Result<(), NorFlashErrorKind> {
            black_box(Ok(()))
        }
    }
    impl CycleCounter for Unknown {
        fn cycles(&mut self) -> u32 {
            black_box(0)
        }
    }
    impl Watchdog for Unknown {
        fn feed(&mut self) {}
    }

    pub fn run() {
        let (mut store, past) =
            Store::open(Unknown, black_box(IDENTITY), black_box(ResetCause::Pin));
        let mut monitor: Monitor<
            { spindle::ROWS },
            { spindle::BALLS },
            12,
            { spindle::FREEDOMS },
            { spindle::JOINTS },
        > = Monitor::new(&spindle::SPINDLE, &MONITOR).with_past(&past);
        let _ = monitor.prepare(black_box([420.0; 5]));
        let mut frames = FramedLoads::new();
        let calibration = black_box(CALIBRATION);
        let _ = black_box(calibration.check());
        let device = Ads131m08::new(Unknown, Unknown, Unknown, Unknown, Unknown);
        let Ok(adc) =
            Ads131m08Bridges::<_, CHANNELS>::start(device, &black_box(Default::default()))
        else {
            return;
        };
        let mut bridges = StrainBridge::new(adc, calibration, black_box(20));
        let mut tachometer = PulseSpeed::new(Edges::default(), black_box(TACHOMETER));
        let mut clock = Widened::new(black_box(32), 0);
        while black_box(true) {
            let now = black_box(0);
            let time_us = clock.at(now);
            frames.push(black_box(0));
            if let Some(record) = black_box(None) {
                black_box(record::encode(&record));
            }
            tachometer.input().edge(black_box(0), black_box(true));
            let speed = tachometer.speed(now);
            let standing = speed.is_ok_and(|speed| speed.method == SpeedMethod::Standstill);
            bridges.set_turning(!standing);
            bridges.set_temperature(black_box(20.0));
            if black_box(true) {
                let _ = bridges.take_tare(black_box(9));
            }
            let loads = if black_box(true) {
                bridges.sample(time_us)
            } else {
                frames.sample(time_us)
            };
            let readings = Readings {
                loads,
                speed: black_box(Some(speed.ok().map(|speed| speed.omega))),
                temperatures: black_box(None),
            };
            let outcome = monitor.tick(time_us, &readings, &mut Unknown, &mut Unknown);
            black_box(outcome);
            monitor.acknowledge(time_us, black_box(Alarm::Slip));
            if black_box(true) {
                monitor.replace_bearing(time_us);
            }
            monitor.retain(time_us, &mut store);
            black_box((store.step(), store.error()));
            black_box(monitor.power_fails(time_us, &mut store));
            black_box(monitor.life().kept());
            let mut buffer = [0; 64];
            black_box(monitor.outbox().fill(&mut buffer));
            black_box((monitor.outbox().next_byte(), buffer, bridges.tare()));
        }
    }
}
