//! The cues as they are known, which of them is shown, and who asks for another.
//!
//! ```text
//!  ~set_cue, ~next_cue, dynamic_reconfigure ─► requests ─► thread of the cues ─┬─► displays of cameras, brightness
//!  page: show, save, remove ──────────────────► worker ──────────────────────┘ └─► ~cue
//! ```
//!
//! The [thread](crate::runtime::cue_thread) reads the file for each request, because it may be on a network share that
//! hangs.

use std::sync::{Arc, Mutex, MutexGuard};

use rcs_files::cue_file::Cue;
use rcs_messages::std_msgs;
use rcs_process::lock;
use rcs_ros::{EventQueue, EventSender, NodeError, Publisher, RosNode};

/// Requests that may wait; the oldest are dropped.
const MOST_WAITING: usize = 64;

/// Callback for a request's result: the name of the cue that is shown now, or why nothing changed.
pub(crate) type Done = Box<dyn FnOnce(Result<String, String>) + Send>;

/// A request to show a cue.
pub(crate) struct CueRequest {
    /// The cue's name; `None` for the next one.
    pub(crate) name: Option<String>,
    pub(crate) caller: String,
    pub(crate) done: Done,
}

/// The cues of the node's config.
pub(crate) struct Cues {
    pub(crate) requests: Arc<EventQueue<CueRequest>>,
    sender: EventSender<CueRequest>,
    topic: Publisher<std_msgs::String>,
    /// The file as it was last read.
    known: Mutex<Result<Vec<Cue>, String>>,
    current: Mutex<Option<Cue>>,
    /// Held while the file is read and a cue is shown, or it is written.
    file: Mutex<()>,
}

impl Cues {
    /// Publishes that none is shown.
    ///
    /// # Errors
    /// The topic's name.
    pub(crate) fn start(ros: &RosNode) -> Result<Self, NodeError> {
        let requests = Arc::<EventQueue<CueRequest>>::default();
        let (sender, topic) = (requests.sender(MOST_WAITING), ros.latched_publisher("~cue", 1)?);
        let known = Mutex::new(Ok(Vec::new()));
        let cues = Self { requests, sender, topic, known, current: Mutex::default(), file: Mutex::default() };
        cues.set_current(None);
        Ok(cues)
    }

    /// Asks for a cue, or for the next one.
    pub(crate) fn ask(&self, name: Option<&str>, caller: &str, done: Done) {
        self.sender.push(CueRequest { name: name.map(str::to_owned), caller: caller.to_owned(), done });
    }

    /// The right to use the file.
    pub(crate) fn lock_file(&self) -> MutexGuard<'_, ()> {
        lock(&self.file)
    }

    /// The file as it was last read.
    pub(crate) fn known(&self) -> Result<Vec<Cue>, String> {
        lock(&self.known).clone()
    }

    /// Keeps the file as it was read now. Returns `true` if it was another one before.
    pub(crate) fn set_known(&self, read: Result<Vec<Cue>, String>) -> bool {
        let mut known = lock(&self.known);
        let has_changed = *known != read;
        *known = read;
        has_changed
    }

    /// The cue that was shown last, until something else is set.
    pub(crate) fn current(&self) -> Option<Cue> {
        lock(&self.current).clone()
    }

    /// Keeps and publishes which cue is shown; an empty name for none.
    pub(crate) fn set_current(&self, cue: Option<Cue>) {
        let data = cue.as_ref().map(|cue| cue.name.clone()).unwrap_or_default();
        *lock(&self.current) = cue;
        if let Err(error) = self.topic.send(std_msgs::String { data }) {
            log::warn!("{}: {error}", self.topic.topic());
        }
    }
}
