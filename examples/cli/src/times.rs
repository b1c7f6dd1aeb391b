//! Records that a logger has stamped with one time, such as whole seconds: they share the time to the next one.

use std::collections::VecDeque;

/// Most records that share a time, those of a second at 1 MHz: 150 MB.
const MOST: usize = 1 << 20;

/// A step to the next time of so many times the one before is a pause of the logger, as in the summary.
pub const PAUSE: f64 = 10.0;

/// Rows on their way, and how many have shared a time.
pub(crate) struct Times<Row> {
    /// The time of a row, s, if it has one.
    time_of: fn(&mut Row) -> Option<&mut f64>,
    ready: VecDeque<Row>,
    /// Rows of one time.
    group: Vec<Row>,
    time: f64,
    /// Time from the time before to this one, and what each record had of it, s.
    before: Option<(f64, f64)>,
    /// Records that have shared a time, and the first such time.
    shared: Option<(u64, f64)>,
}

impl<Row> Times<Row> {
    pub fn of(time_of: fn(&mut Row) -> Option<&mut f64>) -> Self {
        Self {
            time_of,
            ready: VecDeque::new(),
            group: Vec::new(),
            time: 0.0,
            before: None,
            shared: None,
        }
    }

    /// The next row of those that `read` brings.
    pub fn next(&mut self, mut read: impl FnMut() -> Option<Row>) -> Option<Row> {
        loop {
            if let Some(row) = self.ready.pop_front() {
                return Some(row);
            }
            let Some(mut row) = read() else {
                self.close(None);
                return self.ready.pop_front();
            };
            match (self.time_of)(&mut row) {
                Some(time) if *time != self.time || self.group.len() == MOST => {
                    let time = *time;
                    self.close(Some(time));
                    self.time = time;
                }
                _ => {}
            }
            self.group.push(row);
        }
    }

    /// Ends a group where the time goes on to `next`, or where the recording ends.
    fn close(&mut self, next: Option<f64>) {
        let mut group = std::mem::take(&mut self.group);
        let times: Vec<&mut f64> = group.iter_mut().filter_map(self.time_of).collect();
        if times.is_empty() {
            self.ready.extend(group);
            return;
        }
        let count = times.len() as f64;
        // There is none to the rest of a group that is too long.
        let step = next.map(|next| next - self.time).filter(|step| *step > 0.0);
        let is_pause = |step: f64| self.before.is_some_and(|(usual, _)| step > PAUSE * usual);
        let part = match (step, self.before) {
            (Some(step), Some((_, part))) if is_pause(step) => Some(part.min(step / count)),
            (Some(step), _) => Some(step / count),
            (None, before) => before.map(|(_, part)| part),
        };
        if let (Some(part), true) = (part, times.len() > 1) {
            let (shared, first) = self.shared.unwrap_or((0, self.time));
            self.shared = Some((shared + times.len() as u64, first));
            for (i, time) in times.into_iter().enumerate() {
                *time += i as f64 * part;
            }
        }
        if let (Some(step), Some(part)) = (step.filter(|step| !is_pause(*step)), part) {
            self.before = Some((step, part));
        }
        self.ready.extend(group);
    }

    /// How many records have shared a time, in one line.
    pub fn account(&self) -> Option<String> {
        let (shared, first) = self.shared?;
        Some(format!(
            "{shared} records have the time of another one, the first at {first} s: records of one time share the time to the next one"
        ))
    }
}
