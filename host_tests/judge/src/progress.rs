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

    /// Name of the next steps.
    fn stage(&self, name: &'static str) {
        let _ = name;
    }
}

/// A listener that is not there.
impl Progress for () {}
