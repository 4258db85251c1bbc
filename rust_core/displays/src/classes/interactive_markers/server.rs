//! One interactive marker server, seen from the client: its messages, and whether one was lost.
//!
//! A server sends numbered updates, keep-alives that repeat the last number, and, on another topic, all its markers as
//! of some number. The client starts from the latter once it has received an update or keep-alive of the same number or
//! a later one, applies the updates that follow it, and starts again where a number is missing or a frame cannot be
//! found.

use std::collections::VecDeque;
use std::time::Duration;

use rcs_messages::visualization_msgs::{InteractiveMarkerInit, InteractiveMarkerUpdate};
use rcs_transforms::Time;

use super::batch::Batch;
use crate::{Level, Statuses, World};

/// The most lists of all markers that wait.
const MAX_INITS: usize = 6;
/// The most updates that wait while the client starts; later, more are an error.
const MAX_UPDATES: usize = 101;
/// A server that is silent for longer gets a warning.
const KEEP_ALIVE: Duration = Duration::from_secs(2);
/// How long the client waits after an error before it starts again.
const PAUSE: Duration = Duration::from_secs(1);
/// A little past a limit of time.
const PAST: Duration = Duration::from_millis(1);

#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    /// Waits for a list of all markers.
    Starting,
    Receiving,
    /// An error occurred at that time.
    Failed(Time),
}

/// A step for the display.
#[derive(Debug)]
pub(super) enum Step {
    /// Forget all markers of the server.
    Forget,
    /// Show these, and no others.
    Replace(Batch),
    /// Add, move and take away markers.
    Update(Batch),
}

/// A server by its id.
#[derive(Debug)]
pub(super) struct Server {
    id: String,
    /// Whether handles may be translucent.
    translucent: bool,
    state: State,
    first_sequence: Option<u64>,
    last_sequence: Option<u64>,
    last_update: Time,
    is_silent: bool,
    /// Newest first.
    inits: VecDeque<Batch>,
    /// Oldest first.
    updates: VecDeque<Batch>,
    steps: Vec<Step>,
}

impl Server {
    pub(super) fn new(id: &str, translucent: bool, statuses: &mut Statuses) -> Self {
        statuses.set(Level::Ok, id, "Waiting for init message.");
        Self {
            id: id.to_owned(),
            translucent,
            state: State::Starting,
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
        if self.state == State::Starting {
            self.inits.truncate(MAX_INITS - 1);
            self.inits.push_front(Batch::of_init(init, self.translucent));
            statuses.set(Level::Ok, &self.id, "Init message received.");
        }
    }

    /// Takes an update or a keep-alive.
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
        if is_keep_alive || matches!(self.state, State::Failed(_)) {
            return;
        }
        if self.state == State::Starting && self.updates.len() >= MAX_UPDATES {
            self.updates.pop_front();
        }
        self.updates.push_back(Batch::of_update(update, self.translucent));
    }

    /// Processes the messages whose frames are known. Returns whether it starts again and needs the last list of all
    /// markers.
    pub(super) fn update(&mut self, world: &World<'_>, statuses: &mut Statuses) -> bool {
        match self.state {
            State::Starting => {
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
            State::Receiving => {
                if self.place_updates(world, statuses) {
                    self.apply_updates(statuses);
                    self.check_keep_alive(world.now, statuses);
                    if self.updates.len() >= MAX_UPDATES {
                        self.reset("Update queue overflow. Resetting connection.", world.now, statuses);
                    }
                }
            }
            State::Failed(since) => {
                if world.now.saturating_since(since) > PAUSE || world.now < since {
                    statuses.set(Level::Error, &self.id, "1 second has passed. Re-initializing.");
                    self.state = State::Starting;
                    return true;
                }
            }
        }
        false
    }

    /// Whether markers or updates wait.
    pub(super) fn is_waiting(&self) -> bool {
        !self.inits.is_empty() || !self.updates.is_empty()
    }

    /// The display's steps since the last call.
    pub(super) fn take_steps(&mut self) -> Vec<Step> {
        std::mem::take(&mut self.steps)
    }

    /// When it changes by itself, as of `now`.
    pub(super) fn next_change(&self, now: Time) -> Option<Time> {
        match self.state {
            State::Starting => None,
            State::Failed(since) => Some(since.saturating_add(PAUSE + PAST)),
            State::Receiving if self.is_silent => {
                // The warning counts whole seconds, rounded.
                let silence = now.saturating_since(self.last_update) + Duration::from_millis(500);
                let next = Duration::from_secs(silence.as_secs() + 1) - Duration::from_millis(500);
                Some(self.last_update.saturating_add(next + PAST))
            }
            State::Receiving => Some(self.last_update.saturating_add(KEEP_ALIVE + PAST)),
        }
    }

    /// Places what waits. Returns whether nothing failed.
    fn place_updates(&mut self, world: &World<'_>, statuses: &mut Statuses) -> bool {
        match self.updates.iter_mut().try_for_each(|update| update.place(world)) {
            Ok(()) => true,
            Err(error) => {
                self.reset(&format!("Resetting due to tf error: {error}"), world.now, statuses);
                false
            }
        }
    }

    /// Starts from the newest list of all markers that is placed and that the updates continue.
    fn start(&mut self, statuses: &mut Statuses) {
        let (Some(first), Some(last)) = (self.first_sequence, self.last_sequence) else {
            let text = "Initialization: Waiting for first update/keep-alive message.";
            statuses.set(Level::Ok, &self.id, text);
            return;
        };
        let fits = |init: &Batch| init.is_ready() && (first..=last).contains(&init.sequence);
        let Some(init) = self.inits.iter().position(fits).and_then(|index| self.inits.remove(index)) else { return };
        while self.updates.front().is_some_and(|update| update.sequence <= init.sequence) {
            self.updates.pop_front();
        }
        self.inits.clear();
        self.state = State::Receiving;
        statuses.set(Level::Ok, &self.id, "Receiving updates.");
        self.steps.push(Step::Replace(init));
        self.apply_updates(statuses);
    }

    fn apply_updates(&mut self, statuses: &mut Statuses) {
        while let Some(update) = self.updates.pop_front() {
            if !update.is_ready() {
                self.updates.push_front(update);
                return;
            }
            statuses.set(Level::Ok, &self.id, "OK");
            self.steps.push(Step::Update(update));
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

    /// Forgets all messages after an error; the next one counts as the first.
    fn reset(&mut self, text: &str, now: Time, statuses: &mut Statuses) {
        self.state = State::Failed(now);
        self.updates.clear();
        self.inits.clear();
        (self.first_sequence, self.last_sequence) = (None, None);
        self.is_silent = false;
        self.steps = vec![Step::Forget];
        statuses.set(Level::Error, &self.id, text);
    }
}
