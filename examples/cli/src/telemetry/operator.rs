//! Orders of an operator to the board: alarms seen, a bearing replaced.
//!
//! The board answers every order ([`command`]): [`Operator::follow`] sends it again until it is answered.

use super::state::{State, words};
use anyhow::{Context, Result};
use spindle_monitor::command::{self, Command, Order, Request};
use spindle_monitor::judgement::AlarmState;
use std::collections::VecDeque;
use std::io::Write;

/// Time of the board after which a request is sent again, us, and how often it is sent.
const REPEAT_US: u64 = 1_000_000;
const TRIES: u32 = 5;
/// Time of the board in which it has told of all that stands, us: alarms are sent again every ten seconds.
const TOLD_US: u64 = 11_000_000;

/// A request on its way.
#[derive(Debug)]
struct Sent {
    request: Request,
    time_us: u64,
    tries: u32,
}

/// Sends an operator's orders.
#[derive(Debug)]
pub struct Operator<W> {
    to: W,
    number: u16,
    wanted: VecDeque<Order>,
    sent: Vec<Sent>,
    unanswered: Vec<Order>,
    /// Acknowledge what the board tells of until this time, us; `None` within for a time that is not known yet.
    acknowledging: Option<Option<u64>>,
    /// A key that waits for a yes.
    asked: Option<char>,
}

impl<W: Write> Operator<W> {
    /// An operator whose requests go to a port.
    pub const fn new(to: W) -> Self {
        Self {
            to,
            number: 0,
            wanted: VecDeque::new(),
            sent: Vec::new(),
            unanswered: Vec::new(),
            acknowledging: None,
            asked: None,
        }
    }

    /// Wants something.
    pub fn want(&mut self, order: Order) {
        self.wanted.push_back(order);
    }

    /// Wants all alarms acknowledged that the board tells of in its first eleven seconds.
    pub const fn want_all_acknowledged(&mut self) {
        self.acknowledging = Some(None);
    }

    /// Wants alarms acknowledged that the board has told of and nobody has acknowledged; returns their number.
    pub fn acknowledge(&mut self, state: &State) -> usize {
        let before = self.wanted.len();
        for (_, of) in state.standing() {
            let order = Order::Acknowledge {
                alarm: of.alarm,
                start: of.start,
                raised: of.raised,
            };
            let is_known = self.wanted.contains(&order)
                || self.sent.iter().any(|sent| sent.request.order == order);
            if of.state != AlarmState::Acknowledged && !is_known {
                self.want(order);
            }
        }
        self.wanted.len() - before
    }

    /// Orders that the board did not answer, however often they were sent.
    pub fn unanswered(&self) -> &[Order] {
        &self.unanswered
    }

    /// Sends new orders, and again unanswered ones. To be called after every event of the stream.
    ///
    /// # Errors
    ///
    /// The port takes no bytes.
    pub fn follow(&mut self, state: &State) -> Result<()> {
        let now = state.time_us;
        if let Some(until) = self.acknowledging {
            let until = until.unwrap_or(now + TOLD_US);
            self.acknowledging = (now < until).then_some(Some(until));
            self.acknowledge(state);
        }
        for mut sent in std::mem::take(&mut self.sent) {
            if (state.answer).is_some_and(|answer| answer.number == sent.request.number) {
                continue;
            }
            if now.saturating_sub(sent.time_us) >= REPEAT_US {
                if sent.tries == TRIES {
                    self.unanswered.push(sent.request.order);
                    continue;
                }
                self.send(sent.request)?;
                (sent.time_us, sent.tries) = (now, sent.tries + 1);
            }
            self.sent.push(sent);
        }
        while let Some(order) = self.wanted.pop_front() {
            self.number = self.number.wrapping_add(1);
            let number = self.number;
            let request = Request { number, order };
            self.send(request)?;
            self.sent.push(Sent {
                request,
                time_us: now,
                tries: 1,
            });
        }
        Ok(())
    }

    fn send(&mut self, request: Request) -> Result<()> {
        self.to
            .write_all(&command::encode(Command::Ask(request)))
            .and_then(|()| self.to.flush())
            .context("cannot send a command to the board")
    }

    /// Takes a key of the view; returns what to show, `None` if the key means nothing. A key that wants something is
    /// asked back, and `y` has it done.
    pub fn press(&mut self, key: char, state: &State) -> Option<String> {
        if let Some(asked) = self.asked.take() {
            return Some(match (key, asked) {
                ('y', 'a') => format!("{} to be acknowledged", self.acknowledge(state)),
                ('y', asked) => {
                    let order = order_of(asked)?;
                    self.want(order);
                    format!("asked to {}", words(&order))
                }
                _ => "nothing was sent".into(),
            });
        }
        let question = match (key, state.unacknowledged()) {
            ('a', 0) => return Some("no alarm to acknowledge".into()),
            ('a', count) => format!("acknowledge {count}"),
            _ => words(&order_of(key)?),
        };
        self.asked = Some(key);
        Some(format!("{question}? y, or any other key"))
    }

    /// Where the requests go.
    pub const fn get_mut(&mut self) -> &mut W {
        &mut self.to
    }
}

const fn order_of(key: char) -> Option<Order> {
    Some(match key {
        'r' => Order::ReplaceBearing,
        's' => Order::ShaftStands,
        'c' => Order::Commission,
        _ => return None,
    })
}

/// Whether a key of the view would tell a board something.
pub const fn wants_a_board(key: char) -> bool {
    key == 'a' || order_of(key).is_some()
}
