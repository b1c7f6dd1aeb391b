//! Progress of a long run as a bar on the terminal.

use indicatif::{ProgressBar, ProgressStyle};
use judge::progress::Progress;

/// A bar on standard error.
pub struct Bar(ProgressBar);

impl Bar {
    /// A bar that looks as `template` says, in the words of [`ProgressStyle`].
    ///
    /// # Errors
    ///
    /// The template is malformed.
    pub fn new(template: &str) -> anyhow::Result<Self> {
        let style = ProgressStyle::with_template(template)?;
        Ok(Self(ProgressBar::new(0).with_style(style)))
    }

    /// Takes it away.
    pub fn finish(&self) {
        self.0.finish_and_clear();
    }
}

impl Progress for Bar {
    fn expect(&self, count: usize) {
        self.0.inc_length(count as u64);
    }

    fn done(&self, count: usize) {
        self.0.inc(count as u64);
    }

    fn stage(&self, name: &'static str) {
        self.0.set_message(name);
    }
}
