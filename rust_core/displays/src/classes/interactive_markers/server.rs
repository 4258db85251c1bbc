//! Connection to one interactive marker server, and detection of lost messages.
//!
//! A server sends numbered updates, keep-alives that repeat the last number, and, on another topic, all its markers as
//! of some number. The client starts from the latter once it has received an update or keep-alive of the same number or
//! a later one, applies the updates that follow it, and starts again where a number is missing or a frame cannot be
//! found.

use std::collections::VecDeque;
use std::time::Duration;

use rcs_messages::visualization_msgs::{InteractiveMarkerInit, InteractiveMarkerUpdate};
use rcs_transforms::Time;

use super::batch::MarkerBatch;
use crate::{Level, Statuses, World};

/// Largest number of waiting lists of all markers.
const MAX_INITS: usize = 6;
/// Largest number of waiting updates while the client starts; later, more are an error.
const MAX_UPDATES: usize = 101;
/// Silence of a server after which there is a warning.
const KEEP_ALIVE: Duration = Duration::from_secs(2);
/// Pause after an error before the client starts again.
const PAUSE: Duration = Duration::from_secs(1);
/// Margin past a time limit.
const PAST: Duration = Duration::from_millis(1);

#[derive(Clone, Copy, Debug, PartialEq)]
enum ConnectionState {
    Starting,
    Receiving,
    Failed(Time),
}

#[derive(Debug)]
pub(super) enum MarkerChange {
    Forget,
    Replace(MarkerBatch),
    Update(MarkerBatch),
}

#[derive(Debug)]
pub(super) struct Server {
    id: String,
    translucent: bool,
    state: ConnectionState,
    first_sequence: Option<u64>,
    last_sequence: Option<u64>,
    last_update: Time,
    is_silent: bool,
    /// Newest first.
    inits: VecDeque<MarkerBatch>,
    /// Oldest first.
    updates: VecDeque<MarkerBatch>,
    steps: Vec<MarkerChange>,
}

impl Server {
    pub(super) fn new(id: &str, translucent: bool, statuses: &mut Statuses) -> Self {
        statuses.set(Level::Ok, id, "Waiting for init message.");
        Self {
            id: id.to_owned(),
            translucent,
            state: ConnectionState::Starting,
            first_sequence: None,
            last_sequence: None,
            last_update: Time::ZERO,
            is_silent: false,
            inits: VecDeque::new(),
            updates: VecDeque::new(),
            steps: Vec::new(),
        }
    }

    /// Takes a list of all markers; it is ignored unless the client is starting.
    pub(super) fn take_init(&mut self, init: &InteractiveMarkerInit, statuses: &mut Statuses) {
        if self.state == ConnectionState::Starting {
            self.inits.truncate(MAX_INITS - 1);
            self.inits.push_front(MarkerBatch::of_init(init, self.translucent));
            statuses.set(Level::Ok, &self.id, "Init message received.");
        }
    }

    pub(super) fn take_update(&mut self, update: &InteractiveMarkerUpdate, now: Time, statuses: &mut Statuses) {
        let sequence = update.seq_num;
        self.first_sequence.get_or_insert(sequence);
        self.last_update = now;
        let is_keep_alive = update.type_ == InteractiveMarkerUpdate::KEEP_ALIVE;
        let expected = self.last_sequence.map(|last| if is_keep_alive { last } else { last.wrapping_add(1) });
        if let Some(expected) = expected.filter(|expected| *expected != sequence) {
            let text = format!("Sequence number of update is out of order. Expected: {expected} Received: {sequence}");
            return self.reset(&text, now, statuses);
        }
        self.last_sequence = Some(sequence);
        if is_keep_alive || matches!(self.state, ConnectionState::Failed(_)) {
            return;
        }
        if self.state == ConnectionState::Starting && self.updates.len() >= MAX_UPDATES {
            self.updates.pop_front();
        }
        self.updates.push_back(MarkerBatch::of_update(update, self.translucent));
    }

    /// Processes the messages whose frames are known. Returns whether it starts again and needs the last list of all
    /// markers.
    pub(super) fn update(&mut self, world: &World<'_>, statuses: &mut Statuses) -> bool {
        match self.state {
            ConnectionState::Starting => {
                for init in &mut self.inits {
                    if let Err(error) = init.place(world) {
                        let sequence = init.sequence;
                        let text = format!(
                            "Cannot get tf info for init message with sequence number {sequence}. Error: {error}"
                        );
                        statuses.set(Level::Warn, &self.id, text);
                    }
                }
                if self.place_updates(world, statuses) {
                    self.start(statuses);
                }
            }
            ConnectionState::Receiving => {
                if self.place_updates(world, statuses) {
                    self.apply_updates(statuses);
                    self.check_keep_alive(world.now, statuses);
                    if self.updates.len() >= MAX_UPDATES {
                        self.reset("Update queue overflow. Resetting connection.", world.now, statuses);
                    }
                }
            }
            ConnectionState::Failed(since) => {
                if world.now.saturating_since(since) > PAUSE || world.now < since {
                    statuses.set(Level::Error, &self.id, "1 second has passed. Re-initializing.");
                    self.state = ConnectionState::Starting;
                    return true;
                }
            }
        }
        false
    }

    pub(super) fn is_waiting(&self) -> bool {
        !self.inits.is_empty() || !self.updates.is_empty()
    }

    pub(super) fn take_changes(&mut self) -> Vec<MarkerChange> {
        std::mem::take(&mut self.steps)
    }

    /// Time of the next change without a message, as of `now`.
    pub(super) fn next_change(&self, now: Time) -> Option<Time> {
        match self.state {
            ConnectionState::Starting => None,
            ConnectionState::Failed(since) => Some(since.saturating_add(PAUSE + PAST)),
            ConnectionState::Receiving if self.is_silent => {
                // The warning counts whole seconds, rounded.
                let silence = now.saturating_since(self.last_update) + Duration::from_millis(500);
                let next = Duration::from_secs(silence.as_secs() + 1) - Duration::from_millis(500);
                Some(self.last_update.saturating_add(next + PAST))
            }
            ConnectionState::Receiving => Some(self.last_update.saturating_add(KEEP_ALIVE + PAST)),
        }
    }

    /// Places the waiting updates. Returns whether none failed.
    fn place_updates(&mut self, world: &World<'_>, statuses: &mut Statuses) -> bool {
        match self.updates.iter_mut().try_for_each(|update| update.place(world)) {
            Ok(()) => true,
            Err(error) => {
                self.reset(&format!("Resetting due to tf error: {error}"), world.now, statuses);
                false
            }
        }
    }

    /// Starts from the newest placed list of all markers that the updates continue.
    fn start(&mut self, statuses: &mut Statuses) {
        let (Some(first), Some(last)) = (self.first_sequence, self.last_sequence) else {
            let text = "Initialization: Waiting for first update/keep-alive message.";
            statuses.set(Level::Ok, &self.id, text);
            return;
        };
        let fits = |init: &MarkerBatch| init.is_ready() && (first..=last).contains(&init.sequence);
        let Some(init) = self.inits.iter().position(fits).and_then(|index| self.inits.remove(index)) else { return };
        while self.updates.front().is_some_and(|update| update.sequence <= init.sequence) {
            self.updates.pop_front();
        }
        self.inits.clear();
        self.state = ConnectionState::Receiving;
        statuses.set(Level::Ok, &self.id, "Receiving updates.");
        self.steps.push(MarkerChange::Replace(init));
        self.apply_updates(statuses);
    }

    fn apply_updates(&mut self, statuses: &mut Statuses) {
        while let Some(update) = self.updates.pop_front() {
            if !update.is_ready() {
                self.updates.push_front(update);
                return;
            }
            statuses.set(Level::Ok, &self.id, "OK");
            self.steps.push(MarkerChange::Update(update));
        }
    }

    fn check_keep_alive(&mut self, now: Time, statuses: &mut Statuses) {
        let silence = now.saturating_since(self.last_update);
        if silence > KEEP_ALIVE {
            let seconds = silence.as_secs_f64().round();
            statuses.set(Level::Warn, &self.id, format!("No update received for {seconds} seconds."));
            self.is_silent = true;
        } else if std::mem::take(&mut self.is_silent) {
            statuses.set(Level::Ok, &self.id, "OK");
        }
    }

    /// Removes all messages after an error; the next one counts as the first.
    fn reset(&mut self, text: &str, now: Time, statuses: &mut Statuses) {
        self.state = ConnectionState::Failed(now);
        self.updates.clear();
        self.inits.clear();
        (self.first_sequence, self.last_sequence) = (None, None);
        self.is_silent = false;
        self.steps = vec![MarkerChange::Forget];
        statuses.set(Level::Error, &self.id, text);
    }
}
