//! The scenes that are measured and proved, in one table for the images beside this file and for the programs that
//! build them and look at them.

#![no_std]

/// Hands the table to a macro: `for_every_scene!(of_mine)`.
///
/// A row has a number and a name; motion, count of freedoms, what is given of them, and output; then the rule of
/// attitude (nothing at rest), what the scene leaves out of the whole solver or has in its place, whether it is
/// measured in doubles, too, and the parts that must not be in its image. Whoever asks has these names in scope.
///
/// States of balls and the way from a design to constants are left out by all of them.
#[macro_export]
#[rustfmt::skip]
macro_rules! for_every_scene {
    ($with:ident) => {
        $with! {
            0 "axial-static": Static, 1, Loads, Stiffness;
                None, "speed, radial displacements, tilts", true,
                [Speed, Friction, RaceControl, RacewayControlFree, Rest, Iteration, Radial, Tilts, Held];
            1 "axial-centrifugal": Centrifugal, 1, Loads, Stiffness;
                FREE, "friction, radial displacements, tilts", false,
                [Friction, RaceControl, Rest, ClosedForm, Radial, Tilts, Held];
            2 "axial-full": Full, 1, Loads, Stiffness;
                FREE, "radial displacements, tilts", false,
                [RaceControl, Rest, ClosedForm, Radial, Tilts, Held];
            3 "translations-static": Static, 3, Loads, Stiffness;
                None, "speed, tilts", false,
                [Speed, Friction, RaceControl, RacewayControlFree, ClosedForm, Tilts, Held];
            4 "translations-full": Full, 3, Loads, Stiffness;
                FREE, "tilts", true,
                [RaceControl, Rest, ClosedForm, Tilts, Held];
            5 "all-static": Static, 5, Loads, Stiffness;
                None, "speed", true,
                [Speed, Friction, RaceControl, RacewayControlFree, ClosedForm, Held];
            6 "all-centrifugal": Centrifugal, 5, Loads, Stiffness;
                FREE, "friction", false,
                [Friction, RaceControl, Rest, ClosedForm, Held];
            7 "all-outer": Full<OuterRaceControl>, 5, Loads, Stiffness;
                Some(Attitude::Outer), "free attitude: outer race control", false,
                [RacewayControlFree, Rest, ClosedForm, Held];
            8 "all-displacements": Full, 5, Loads, Displacements;
                FREE, "stiffness", false,
                [RaceControl, Rest, ClosedForm, Held, Stiffness];
            9 "all-preloaded": Full, 5, RigidPreload, Stiffness;
                FREE, "axial load: displacement given", false,
                [RaceControl, Rest, ClosedForm];
            10 "all-full": Full, 5, Loads, Stiffness;
                FREE, "nothing", true,
                [RaceControl, Rest, ClosedForm, Held];
        }
    };
}
