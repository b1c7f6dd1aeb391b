//! Constants of the estimator by their names.

use spindle_monitor::estimator::Constants;

/// A constant: its name, how its number is got and how it is set. A whole number is the nearest one.
pub struct Constant {
    /// Its name, with an index where there are two.
    pub name: &'static str,
    /// Its number.
    pub get: fn(&Constants) -> f64,
    set: fn(&mut Constants, f64),
}

/// Makes the list of all constants: those with one number, and those with two.
macro_rules! list {
    ($($one:ident)*; $($two:ident)*) => {
        /// All of them.
        pub const ALL: &[Constant] = &[
            $(Constant {
                name: stringify!($one),
                get: |constants| constants.$one.into(),
                set: |constants, number| constants.$one = number as _,
            },)*
            $(Constant {
                name: concat!(stringify!($two), "[0]"),
                get: |constants| constants.$two[0].into(),
                set: |constants, number| constants.$two[0] = number as _,
            },
            Constant {
                name: concat!(stringify!($two), "[1]"),
                get: |constants| constants.$two[1].into(),
                set: |constants, number| constants.$two[1] = number as _,
            },)*
        ];
        // None is missing.
        const _: Constants = {
            let Constants { $($one,)* $($two,)* } = Constants::USUAL;
            Constants { $($one,)* $($two,)* }
        };
    };
}

list! {
    preload angle preload_walk gain_walk model least least_load expected kept surprise outlier outliers mean_of steps enters ratio_kept wrong fed turned;
    opens unexplained known ratio errors
}

impl Constant {
    /// The constants with another number for this one. They stay until the program ends, as the board's do.
    pub fn with(&self, constants: &Constants, number: f64) -> &'static Constants {
        let mut constants = *constants;
        (self.set)(&mut constants, number);
        Box::leak(Box::new(constants))
    }

    /// Twice its number; of what a step leaves of a sum, that of a sum over twice the steps.
    pub fn doubled(&self, constants: &Constants) -> f64 {
        let number = (self.get)(constants);
        if self.name.ends_with("kept") {
            0.5 + 0.5 * number
        } else {
            2.0 * number
        }
    }
}
