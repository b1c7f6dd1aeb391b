//! Shaft speed from the pulses of a tachometer or an encoder.
//!
//! A timer counts the pulses and captures its own time at each; [`PulseInput`] reads both. From there
//! everything is arithmetic, so that it runs on a host as on a board.
//!
//! - **Slow**: the time between the last two pulses that were seen (by period).
//! - **Fast**: the pulses of a gate time, over the time from the pulse before the gate's first to its last
//!   (by count). A single period would be few counts of the timer. Both ends of a gate are pulses: there
//!   is no error of one pulse, and no jump where one method takes over from the other. Two
//!   thresholds keep them from taking turns.
//! - **No pulse**: the shaft has turned by less than a pitch since the last one, which bounds its speed from
//!   above, lower and lower. After a time-out it stands still.
//! - **Signal lost**: a shaft that turned at `omega` cannot stop within the pitch `theta` of a pulse
//!   unless `omega^2 <= 2 a theta`, `a` being its greatest deceleration. If the next pulse is overdue by
//!   twice its time under that deceleration, the signal is lost until pulses come again. This is an
//!   error and no standstill.
//! - **Direction**: a counter that counts down (quadrature, or a second channel as its direction) gives a
//!   negative speed. At a reversal the speed is 0.
//!
//! Slower than a pitch in the time-out reads as standstill.

use core::f32::consts::TAU;
use core::fmt;
use spindle_monitor::tick::Widened;

/// Pulses at a timer: their count, and the time of the last one. Both wrap at their width.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pulses {
    /// Pulses so far; counts down when the shaft turns backwards.
    pub count: u32,
    /// Time of the last pulse, in counts of the timer.
    pub capture: u32,
}

/// A timer that counts and captures pulses.
pub trait PulseInput {
    /// Reads the timer. Both values must belong together.
    fn pulses(&mut self) -> Pulses;
}

/// Pulses that an interrupt handler counts, where no timer does.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Edges {
    count: u32,
    capture: u32,
}

impl Edges {
    /// None so far.
    pub const fn new() -> Self {
        Self {
            count: 0,
            capture: 0,
        }
    }

    /// An edge at this time of the timer; `forward` is the level of the second channel, or `true`
    /// without one.
    pub const fn edge(&mut self, capture: u32, forward: bool) {
        self.capture = capture;
        self.count = if forward {
            self.count.wrapping_add(1)
        } else {
            self.count.wrapping_sub(1)
        };
    }
}

impl PulseInput for Edges {
    fn pulses(&mut self) -> Pulses {
        Pulses {
            count: self.count,
            capture: self.capture,
        }
    }
}

/// How pulses become a speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedSettings {
    /// Pulses of a revolution.
    pub pulses_per_revolution: u16,
    /// Counts of the timer in a second.
    pub timer_hz: u32,
    /// Width of the timer, bits. It must be read at least twice in the time in which it wraps.
    pub timer_bits: u8,
    /// Width of the pulse counter, bits.
    pub counter_bits: u8,
    /// Above this speed pulses are counted, rad/s.
    pub count_above: f32,
    /// Below this speed their period is taken, rad/s; less than `count_above`.
    pub period_below: f32,
    /// Time over which pulses are counted, us.
    pub gate_us: u32,
    /// Time without a pulse that is a standstill, us.
    pub standstill_us: u32,
    /// The greatest deceleration of the shaft, rad/s^2: what its brake can do, and more.
    pub deceleration: f32,
}

/// How a speed came about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SpeedMethod {
    /// There are no pulses, and need not be.
    Standstill,
    /// The time between pulses.
    Period,
    /// Pulses in a time.
    Count,
}

/// A measured speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Speed {
    /// Shaft speed `omega`, rad/s; negative backwards.
    pub omega: f32,
    /// How it came about.
    pub method: SpeedMethod,
}

/// Why there is no speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum SpeedError {
    /// Not enough pulses yet, nor a time-out without any.
    Unknown,
    /// Pulses stopped faster than the shaft can.
    Lost,
}

impl fmt::Display for SpeedError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Unknown => "no speed yet: too few pulses",
            Self::Lost => "speed signal lost: pulses stopped faster than the shaft can",
        })
    }
}

impl core::error::Error for SpeedError {}

/// Where the shaft's speed comes from.
pub trait SpeedSource {
    /// The speed at the time `now`, in counts of the source's timer.
    ///
    /// # Errors
    ///
    /// Why there is none.
    fn speed(&mut self, now: u32) -> Result<Speed, SpeedError>;
}

/// Speed from pulses.
#[derive(Debug)]
pub struct PulseSpeed<P> {
    input: P,
    settings: SpeedSettings,
    timer: Widened,
    counter: Widened,
    /// Shown by the counter last.
    count: u32,
    started: bool,
    lost: bool,
    /// Time of the last pulse, or of the start.
    last: u64,
    /// Whether there was a pulse at that time.
    pulsed: bool,
    /// Speed at the last pulse, if known.
    omega: Option<f32>,
    counting: bool,
    /// Pulses since the gate's beginning, and that.
    gate: (i32, u64),
}

impl<P: PulseInput> PulseSpeed<P> {
    /// A source that has seen no pulse.
    pub const fn new(input: P, settings: SpeedSettings) -> Self {
        Self {
            input,
            timer: Widened::new(settings.timer_bits, 0),
            counter: Widened::new(settings.counter_bits, 0),
            settings,
            count: 0,
            started: false,
            lost: false,
            last: 0,
            pulsed: false,
            omega: None,
            counting: false,
            gate: (0, 0),
        }
    }

    /// The timer, for those who feed it.
    pub const fn input(&mut self) -> &mut P {
        &mut self.input
    }

    /// Seconds between two times of the timer.
    fn seconds(&self, from: u64, to: u64) -> f32 {
        let counts = to.saturating_sub(from).min(u32::MAX.into()) as u32;
        counts as f32 / self.settings.timer_hz.max(1) as f32
    }

    /// Angle between two pulses, rad.
    fn pitch(&self) -> f32 {
        TAU / f32::from(self.settings.pulses_per_revolution.max(1))
    }

    /// Takes in pulses, the last of which came at the time `at`.
    fn pulse(&mut self, pulses: i32, at: u64) {
        let known = self.pulsed && !self.lost;
        let period = self.seconds(self.last, at);
        let by_period = pulses as f32 * self.pitch() / period;
        let reversed = self.omega.is_some_and(|omega| omega * by_period < 0.0);
        self.last = at;
        self.pulsed = true;
        self.lost = false;
        if !known || reversed || !by_period.is_finite() {
            // The first pulse only tells that the shaft moves; one in no time tells nothing.
            self.omega = if reversed { Some(0.0) } else { None };
            self.counting = false;
            return;
        }
        if !self.counting {
            self.omega = Some(by_period);
            if by_period.abs() > self.settings.count_above {
                self.counting = true;
                self.gate = (0, at);
            }
            return;
        }
        let (before, from) = self.gate;
        let counted = before.saturating_add(pulses);
        let time = self.seconds(from, at);
        if time * 1e6 < self.settings.gate_us as f32 {
            self.gate = (counted, from);
            return;
        }
        let omega = counted as f32 * self.pitch() / time;
        self.omega = Some(omega);
        self.gate = (0, at);
        self.counting = omega.abs() >= self.settings.period_below;
    }
}

impl<P: PulseInput> SpeedSource for PulseSpeed<P> {
    fn speed(&mut self, now: u32) -> Result<Speed, SpeedError> {
        let Pulses { count, capture } = self.input.pulses();
        if !self.started {
            self.started = true;
            self.timer = Widened::new(self.settings.timer_bits, now);
            self.count = count;
        }
        let time = self.timer.at(now);
        let pulses = self.counter.ahead(count, self.count);
        self.count = count;
        if pulses != 0 {
            let ahead = i64::from(self.timer.ahead(capture, now));
            self.pulse(pulses, time.saturating_add_signed(ahead));
        }
        let idle = self.seconds(self.last, time);
        let timed_out = idle * 1e6 >= self.settings.standstill_us as f32;
        let standstill = Speed {
            omega: 0.0,
            method: SpeedMethod::Standstill,
        };
        if self.lost {
            return Err(SpeedError::Lost);
        }
        let Some(omega) = self.omega else {
            // A pulse that nothing follows is one of a shaft that was moved a little.
            return if timed_out {
                Ok(standstill)
            } else {
                Err(SpeedError::Unknown)
            };
        };
        let pitch = self.pitch();
        let size = omega.abs();
        let discriminant = size * size - 2.0 * self.settings.deceleration * pitch;
        let root = spindle_bearing::sqrt_f32(discriminant);
        if discriminant > 0.0 {
            // Time to the next pulse under the greatest deceleration; rearranged, so that it is
            // right where deceleration hardly counts.
            let due = 2.0 * pitch / (size + root);
            if idle > 2.0 * due + self.settings.gate_us as f32 * 1e-6 {
                self.lost = true;
                self.omega = None;
                self.counting = false;
                return Err(SpeedError::Lost);
            }
        }
        if timed_out {
            self.omega = Some(0.0);
            self.pulsed = false;
            self.counting = false;
            return Ok(standstill);
        }
        let bound = pitch / idle;
        let method = if self.counting {
            SpeedMethod::Count
        } else {
            SpeedMethod::Period
        };
        Ok(Speed {
            // Also where `idle` is 0 and the bound infinite.
            omega: if bound < size {
                if omega < 0.0 { -bound } else { bound }
            } else {
                omega
            },
            method,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETTINGS: SpeedSettings = SpeedSettings {
        pulses_per_revolution: 4,
        timer_hz: 1_000_000,
        timer_bits: 32,
        counter_bits: 16,
        count_above: 400.0,
        period_below: 300.0,
        gate_us: 5000,
        standstill_us: 500_000,
        deceleration: 1000.0,
    };

    /// A shaft whose angle is integrated, its pulses timed exactly, and read every millisecond.
    struct Shaft {
        source: PulseSpeed<Edges>,
        timer: f64,
        angle: f64,
        hz: f64,
        mask: u32,
        dead: bool,
    }

    impl Shaft {
        fn new(settings: SpeedSettings, start: u32) -> Self {
            Self {
                source: PulseSpeed::new(Edges::default(), settings),
                timer: f64::from(start),
                angle: 0.1,
                hz: f64::from(settings.timer_hz),
                mask: (u64::from(u32::MAX) >> (32 - settings.timer_bits)) as u32,
                dead: false,
            }
        }

        fn step(&mut self, omega: f64) -> Result<Speed, SpeedError> {
            let pitch = f64::from(self.source.pitch());
            let from = self.angle;
            self.angle += omega * 1e-3;
            let (first, last) = ((from / pitch).floor(), (self.angle / pitch).floor());
            let edges = (last - first).abs() as i32;
            for i in 0..edges {
                let edge = if omega > 0.0 {
                    first + 1.0 + f64::from(i)
                } else {
                    first - f64::from(i)
                };
                let at = self.timer + (edge * pitch - from) / omega * self.hz;
                if !self.dead {
                    self.source
                        .input()
                        .edge(at as u64 as u32 & self.mask, omega > 0.0);
                }
            }
            self.timer += 1e-3 * self.hz;
            self.source.speed(self.timer as u64 as u32 & self.mask)
        }

        fn settle(&mut self, omega: f64) -> Speed {
            for _ in 0..2000 {
                let _ = self.step(omega);
            }
            self.step(omega).unwrap()
        }
    }

    #[test]
    fn every_speed_comes_out_within_the_resolution_of_the_timer() {
        for omega in [
            5.0, -5.0, 37.0, 120.0, 299.0, 350.0, 401.0, -900.0, 2094.0, -4000.0,
        ] {
            let speed = Shaft::new(SETTINGS, 7).settle(omega);
            assert!(
                (f64::from(speed.omega) / omega - 1.0).abs() < 1.5e-3,
                "{omega}: {speed:?}"
            );
            let method = if omega.abs() > 400.0 {
                SpeedMethod::Count
            } else {
                SpeedMethod::Period
            };
            assert_eq!(speed.method, method, "{omega}");
        }
    }

    #[test]
    fn the_switch_between_methods_is_no_jump_and_has_hysteresis() {
        let mut shaft = Shaft::new(SETTINGS, 0);
        shaft.settle(200.0);
        let (mut last, mut switches, mut method) = (200.0_f32, 0, SpeedMethod::Period);
        let (mut up, mut down) = (0.0, 0.0);
        for i in 0..2000 {
            let truth = 200.0 + 300.0 * (1.0 - (f64::from(i) / 1000.0 - 1.0).abs());
            let speed = shaft.step(truth).unwrap();
            if speed.method != method {
                switches += 1;
                method = speed.method;
                if method == SpeedMethod::Count {
                    up = speed.omega;
                } else {
                    down = speed.omega;
                }
            }
            // A gate and a pulse pass before the last speed is replaced: at 300 rad/s^2 less than 4.
            assert!(
                (speed.omega - last).abs() < 4.0,
                "{truth}: {last} to {speed:?}"
            );
            assert!((f64::from(speed.omega) - truth).abs() < 6.0);
            last = speed.omega;
        }
        assert_eq!(switches, 2);
        assert!(up > 400.0 && (290.0..300.0).contains(&down), "{up} {down}");
    }

    #[test]
    fn wraps_of_timer_and_counter_do_not_show() {
        for (timer_bits, start) in [(32, u32::MAX - 100_000), (24, 0), (16, 12)] {
            let settings = SpeedSettings {
                timer_bits,
                counter_bits: 8,
                ..SETTINGS
            };
            for omega in [60.0, 1500.0] {
                let mut shaft = Shaft::new(settings, start);
                shaft.settle(omega);
                for _ in 0..5000 {
                    let speed = shaft.step(omega).unwrap();
                    assert!(
                        (f64::from(speed.omega) / omega - 1.0).abs() < 2e-3,
                        "{speed:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_shaft_that_coasts_down_stands_still_and_is_not_lost() {
        let mut shaft = Shaft::new(SETTINGS, 0);
        shaft.settle(800.0);
        let mut omega = 800.0;
        let mut speed = Speed {
            omega: 800.0,
            method: SpeedMethod::Count,
        };
        for _ in 0..3000 {
            omega = (omega - 0.9_f64).max(0.0);
            speed = shaft.step(omega).unwrap();
            // The bound by the missing pulse is one from above.
            assert!(f64::from(speed.omega) > omega - 5.0, "{omega} {speed:?}");
        }
        assert_eq!((speed.omega, speed.method), (0.0, SpeedMethod::Standstill));
        // And starts again, backwards.
        assert!((shaft.settle(-50.0).omega + 50.0).abs() < 0.1);
    }

    #[test]
    fn a_signal_lost_at_full_speed_is_an_error_and_never_a_standstill() {
        for omega in [150.0, 2000.0] {
            let mut shaft = Shaft::new(SETTINGS, 0);
            shaft.settle(omega);
            shaft.dead = true;
            let (mut first, mut slowest) = (None, f32::INFINITY);
            for ms in 1..10_000 {
                match shaft.step(omega) {
                    Ok(speed) => {
                        assert!(first.is_none(), "{ms}");
                        slowest = slowest.min(speed.omega);
                    }
                    Err(error) => {
                        assert_eq!(error, SpeedError::Lost);
                        first = first.or(Some(ms));
                    }
                }
            }
            assert!(first.unwrap() < 40, "{omega}: {first:?}");
            assert!(slowest > 0.0);
            shaft.dead = false;
            assert!((f64::from(shaft.settle(omega).omega) / omega - 1.0).abs() < 2e-3);
        }
    }

    /// A shaft at `omega` takes `t = (omega - sqrt(omega^2 - 2 a theta)) / a` for a pitch `theta` under its greatest
    /// deceleration `a`, or stops within it: at 56 rad/s here.
    #[test]
    fn a_signal_is_lost_after_twice_the_time_that_the_greatest_deceleration_explains() {
        let (deceleration, pitch) = (1000.0, core::f64::consts::TAU / 4.0);
        for omega in [54.0, 57.0, 60.0, 100.0_f64] {
            let mut shaft = Shaft::new(SETTINGS, 0);
            shaft.settle(omega);
            shaft.dead = true;
            let since_pulse = shaft.angle.rem_euclid(pitch) / omega;
            let lost = (1..600).find(|_| shaft.step(omega).is_err());
            let left = omega * omega - 2.0 * deceleration * pitch;
            let due = (left > 0.0).then(|| (omega - left.sqrt()) / deceleration);
            let expected = due.map(|due| 1e3 * (2.0 * due - since_pulse) + 5.0);
            let agree = match (lost, expected) {
                (Some(lost), Some(ms)) => (f64::from(lost) - ms).abs() < 2.0,
                (lost, expected) => lost.is_none() && expected.is_none(),
            };
            assert!(agree, "{omega}: {lost:?}, {expected:?} ms");
        }
    }

    #[test]
    fn a_shaft_that_never_moved_stands_still_after_the_time_out() {
        let mut shaft = Shaft::new(SETTINGS, 99);
        let readings: std::vec::Vec<_> = (0..600).map(|_| shaft.step(0.0)).collect();
        assert_eq!(readings[100], Err(SpeedError::Unknown));
        assert_eq!(readings[520].map(|s| s.omega), Ok(0.0));
    }
}
