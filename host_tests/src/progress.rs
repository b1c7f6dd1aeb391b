//! Who is told how far a long run has got.

/// A listener to the progress of a run, which says nothing unless told otherwise.
pub trait Progress: Sync {
    /// There are `count` more steps to do.
    fn expect(&self, count: usize) {
        let _ = count;
    }

    /// `count` steps are done.
    fn done(&self, count: usize) {
        let _ = count;
    }

    /// What the next steps are about.
    fn stage(&self, name: &'static str) {
        let _ = name;
    }
}

/// Nobody.
impl Progress for () {}
