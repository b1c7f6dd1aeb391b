//! Code that a solver for a microcontroller must not contain, told by its symbols.

use crate::program::Program;
use anyhow::{Result, bail};
use twin::graph::{self, Reach};

/// A kind of unwanted code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unwanted {
    /// The way into a panic.
    Panic,
    /// Double precision, which this core works out in software.
    Double,
    /// Numbers written as text.
    Formatting,
    /// Memory from a heap.
    Allocation,
    /// The routine for square roots, beside the FPU's instruction.
    Root,
}

impl Unwanted {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Panic,
        Self::Double,
        Self::Formatting,
        Self::Allocation,
        Self::Root,
    ];
    /// Kinds unwanted in the monitor and in a rating life, in which a power takes a root in software.
    pub const BUT_ROOTS: [Self; 4] = [
        Self::Panic,
        Self::Double,
        Self::Formatting,
        Self::Allocation,
    ];
    /// Kinds unwanted on a core that computes in double precision.
    pub const IN_DOUBLE: [Self; 3] = [Self::Panic, Self::Formatting, Self::Allocation];

    /// Verb for code that contains this kind.
    pub fn verb(self) -> &'static str {
        match self {
            Self::Panic => "can panic",
            Self::Double => "computes in double precision",
            Self::Formatting => "formats text",
            Self::Allocation => "allocates memory",
            Self::Root => "takes square roots in software",
        }
    }

    /// Advice on the search for its cause.
    pub fn advice(self) -> &'static str {
        match self {
            Self::Panic => {
                "Look in the last function of the library for an index, a division of integers, \
                 an `unwrap` or an `assert` that the compiler cannot prove away; iterators and \
                 arrays of known length need no check."
            }
            Self::Double => {
                "Look in the last function of the library for an `f64`, or for a constant that is \
                 converted at run time; `T::of` of a literal is worked out by the compiler only \
                 where it is inlined."
            }
            Self::Formatting => "Look in the last function of the library for a `write!`.",
            Self::Allocation => "Use arrays whose length is known, or `heapless`.",
            Self::Root => {
                "Look in the last function of the library for a root behind a branch for positive \
                 numbers, where the compiler drops the magnitude that it is taken of: `src/sqrt.rs` \
                 says how to take it."
            }
        }
    }

    /// Whether a symbol of this (demangled) name is of the kind.
    pub fn is(self, name: &str) -> bool {
        let last = name.rsplit("::").next().unwrap_or(name);
        match self {
            Self::Panic => {
                last == "rust_begin_unwind"
                    || ["panic", "unwrap_failed", "expect_failed", "slice::index"]
                        .iter()
                        .any(|part| name.contains(part))
            }
            Self::Double => {
                // Of the ARM run-time ABI, of GCC's library, and of the C library. The last do
                // without the first two where they work on the bits.
                last.starts_with("__aeabi_d")
                    || last.starts_with("__aeabi_cd")
                    || last.starts_with("__aeabi_") && last.ends_with("2d")
                    || last.starts_with("__") && last.contains("df")
                    || (last == name || name.contains("libm")) && C_DOUBLE.contains(&last)
            }
            Self::Formatting => name.contains("core::fmt::"),
            Self::Root => (last == name || name.contains("libm")) && last == "sqrtf",
            Self::Allocation => {
                name.starts_with("alloc::")
                    || name.starts_with("<alloc::")
                    || ["malloc", "calloc", "realloc", "free"].contains(&name)
                    || ["__rust_", "__rg_", "__rdl_"].iter().any(|prefix| {
                        last.strip_prefix(prefix)
                            .is_some_and(|rest| rest.contains("alloc"))
                    })
            }
        }
    }
}

/// Functions of the C library on doubles.
const C_DOUBLE: [&str; 16] = [
    "sqrt", "cbrt", "fma", "fmod", "floor", "ceil", "trunc", "round", "rint", "sin", "cos", "tan",
    "atan", "atan2", "exp", "pow",
];

/// A way to code of this kind, if there is one.
pub fn find<'r>(reach: &'r Reach<'_>, kind: Unwanted) -> Option<graph::Path<'r>> {
    reach.path(|name| kind.is(name))
}

/// Fails if anything unwanted is reachable, and says by which way.
pub fn clean(what: &str, program: &Program, reach: &Reach<'_>, kinds: &[Unwanted]) -> Result<()> {
    for kind in kinds {
        if let Some(path) = find(reach, *kind) {
            let names = path.names.join("\n    -> ");
            // The way is worth telling without the lines, too.
            let lines = path.last.and_then(|at| program.lines_of(at).ok());
            bail!(
                "{what} {}:\n       {names}{}\n{}",
                kind.verb(),
                lines.unwrap_or_default(),
                kind.advice()
            );
        }
    }
    let verbs: Vec<_> = kinds.iter().map(|kind| kind.verb()).collect();
    println!(
        "{what}: {} functions and constants, nothing that {}",
        reach.names().count(),
        verbs.join(", ")
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kind(name: &str) -> Option<Unwanted> {
        Unwanted::ALL.into_iter().find(|kind| kind.is(name))
    }

    /// A name for each way to be known.
    #[test]
    fn unwanted_symbols_are_known_by_their_names() {
        use Unwanted::{Allocation, Double, Formatting, Panic, Root};
        for (expected, names) in [
            (
                Panic,
                "core::panicking::panic_fmt core::option::unwrap_failed core::option::expect_failed \
                 core::slice::index::slice_end_index_len_fail rust_begin_unwind __rustc::rust_begin_unwind",
            ),
            (
                Double,
                "__aeabi_dadd __aeabi_cdcmple __aeabi_f2d __adddf3 sqrt libm::math::atan2::atan2 \
                 compiler_builtins::float::mul::__muldf3",
            ),
            (
                Formatting,
                "core::fmt::write core::fmt::Formatter::pad_integral",
            ),
            (
                Allocation,
                "__rust_alloc __rustc::__rust_realloc __rg_dealloc alloc::vec::Vec<T>::push \
                 <alloc::boxed::Box<T> malloc",
            ),
            (Root, "sqrtf libm::math::sqrtf::sqrtf"),
        ] {
            for name in names.split(' ') {
                assert_eq!(kind(name), Some(expected), "{name}");
            }
        }
    }

    #[test]
    fn a_solver_in_single_precision_has_nothing_unwanted() {
        let names = "main spindle_bearing::sqrt::sqrt_f32 libm::math::atan2f::atan2f __aeabi_memcpy4 \
            __aeabi_fadd __aeabi_uidiv __addsf3 spindle_monitor::record::round __defmt_default_timestamp";
        for name in names.split(' ') {
            assert_eq!(kind(name), None, "{name}");
        }
    }
}
