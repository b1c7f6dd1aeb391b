//! Values that are made where they stay. A large one that is returned is made on the stack, and copied.

#![allow(unsafe_code, reason = "memory that has no value yet")]

use core::mem::MaybeUninit;

/// Makes a `Self` in its place, field by field, and returns it.
///
/// First come fields that a function makes in their own place, then values. Every field must be named, or it does not compile.
macro_rules! in_place {
    ($place:expr, { $($field:ident <- $make:expr,)* }, { $($other:ident: $value:expr,)* }) => {{
        let place: &mut core::mem::MaybeUninit<Self> = $place;
        let _ = |all: &Self| {
            let Self { $($field: _,)* $($other: _,)* } = all;
        };
        let all = place.as_mut_ptr();
        $(
            #[allow(unsafe_code, reason = "a field of the place, which is exclusively borrowed")]
            // SAFETY: as the reason says.
            let field = unsafe { &mut *$crate::in_place::unmade(&raw mut (*all).$field) };
            $crate::in_place::fill(field, $make);
        )*
        $(
            #[allow(unsafe_code, reason = "likewise")]
            // SAFETY: as the reason says.
            let field = unsafe { &mut *$crate::in_place::unmade(&raw mut (*all).$other) };
            field.write($value);
        )*
        #[allow(unsafe_code, reason = "all fields have their values")]
        // SAFETY: as the reason says.
        let made = unsafe { place.assume_init_mut() };
        made
    }};
}
pub(crate) use in_place;

/// The place of a value.
pub(crate) const fn unmade<T>(value: *mut T) -> *mut MaybeUninit<T> {
    value.cast()
}

/// Has a function make a value in its place.
pub(crate) fn fill<T>(
    place: &mut MaybeUninit<T>,
    make: impl for<'p> FnOnce(&'p mut MaybeUninit<T>) -> &'p mut T,
) {
    make(place);
}

/// The value that a function makes in its place.
pub(crate) fn value<T>(make: impl for<'p> FnOnce(&'p mut MaybeUninit<T>) -> &'p mut T) -> T {
    let mut place = MaybeUninit::uninit();
    make(&mut place);
    // SAFETY: whatever the function, a reference to a value that lives as long as the place is one to the place.
    unsafe { place.assume_init() }
}
