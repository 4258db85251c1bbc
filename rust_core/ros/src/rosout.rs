//! The node's log on `/rosout`, and the services that change its level.
//!
//! A line may be logged under any lock, also while publishing, so [`log_line`] only queues it, and a thread publishes
//! it once the node has started.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex};
use std::time::{Duration, Instant};

use rcs_messages::roscpp::{GetLoggers, GetLoggersRes, Logger, SetLoggerLevel};
use rcs_messages::rosgraph_msgs::Log;
use rcs_messages::std_msgs::Header;
use rcs_messages::std_srvs::EmptyRes;
use rcs_messages::Time;
use rcs_process::{lock, wait_timeout};

use crate::error::NodeError;
use crate::node::RosNode;

const TOPIC: &str = "/rosout";
/// Queued lines; the oldest are dropped.
const MAX_LINES: usize = 200;
/// Queue size of a slow subscriber.
const QUEUE_SIZE: usize = 200;
/// Period at which the thread checks for the node's end.
const PATIENCE: Duration = Duration::from_secs(1);
/// Polling period of [`RosNode::flush_log`].
const FLUSH_POLL: Duration = Duration::from_millis(10);
const THREAD_NAME: &str = "ros-rosout";

/// A line of the log.
#[derive(Clone, Debug)]
pub struct LogLine {
    /// Level.
    pub level: log::Level,
    /// Text.
    pub text: String,
    /// Rust module that logged it.
    pub module: String,
    /// Source file.
    pub file: String,
    /// Line of the source file.
    pub line: u32,
    /// The node's time; zero before it has started.
    pub stamp: Time,
}

#[derive(Default)]
struct Queue {
    lines: VecDeque<LogLine>,
    /// A line was dequeued and is not published yet.
    is_publishing: bool,
    /// The thread has ended.
    is_ended: bool,
}

static QUEUE: Mutex<Queue> = Mutex::new(Queue { lines: VecDeque::new(), is_publishing: false, is_ended: false });
static CHANGED: Condvar = Condvar::new();

/// Publishes a line of the log on `/rosout` once the process's node runs. Never waits.
pub fn log_line(line: LogLine) {
    // Lines logged while publishing would cause endless further ones.
    if std::thread::current().name() == Some(THREAD_NAME) {
        return;
    }
    let mut queue = lock(&QUEUE);
    if queue.is_ended {
        return;
    }
    while queue.lines.len() >= MAX_LINES {
        queue.lines.pop_front();
    }
    queue.lines.push_back(line);
    drop(queue);
    CHANGED.notify_all();
}

/// Number of a level in `rosgraph_msgs/Log`.
fn number(level: log::Level) -> i8 {
    match level {
        log::Level::Error => Log::ERROR,
        log::Level::Warn => Log::WARN,
        log::Level::Info => Log::INFO,
        log::Level::Debug | log::Level::Trace => Log::DEBUG,
    }
}

/// Loggers whose levels can be changed.
pub trait Loggers: Send + Sync {
    /// Loggers with their levels: `debug`, `info`, `warn`, `error` or `fatal`.
    fn levels(&self) -> Vec<(String, String)>;

    /// Sets a logger's level; `false` if there is no such logger or level.
    fn set_level(&self, logger: &str, level: &str) -> bool;
}

impl RosNode {
    /// Publishes the log on `/rosout` and offers `~get_loggers` and `~set_logger_level`, for as long as the node lives.
    ///
    /// # Errors
    /// [`NodeError::Name`] or [`NodeError::Start`].
    pub fn serve_log(&self, loggers: Arc<dyn Loggers>) -> Result<(), NodeError> {
        let publisher = self.latched_publisher(TOPIC, QUEUE_SIZE)?;
        let (node, name) = (Arc::downgrade(&self.shared), self.name().to_owned());
        let publishing = move || {
            while let Some(line) = next_line(|| node.strong_count() > 0) {
                let Some(node) = node.upgrade() else { return };
                let message = Log {
                    header: Header { stamp: line.stamp, ..Header::default() },
                    level: number(line.level),
                    name: name.clone(),
                    msg: line.text,
                    file: line.file,
                    function: line.module,
                    line: line.line,
                    topics: node.network.topics(),
                };
                // Fails only for more than 4 GB.
                let _ = publisher.send(message);
                lock(&QUEUE).is_publishing = false;
            }
        };
        let spawned = std::thread::Builder::new().name(THREAD_NAME.to_owned()).spawn(publishing);
        spawned.map_err(|error| NodeError::Start { what: "the log's topic", reason: error.to_string() })?;
        let all = Arc::clone(&loggers);
        self.serve::<GetLoggers>(&self.resolve("~get_loggers")?, move |_, _| {
            let loggers = all.levels().into_iter().map(|(name, level)| Logger { name, level }).collect();
            Ok(GetLoggersRes { loggers })
        });
        self.serve::<SetLoggerLevel>(&self.resolve("~set_logger_level")?, move |_, request| {
            if loggers.set_level(&request.logger, &request.level) {
                Ok(EmptyRes {})
            } else {
                Err(format!("no logger '{}' or no level '{}'", request.logger, request.level))
            }
        });
        Ok(())
    }
}

impl RosNode {
    /// Waits until the last line was sent to a subscriber of `/rosout`, at most for `limit`. To be called before
    /// [`shutdown`](Self::shutdown) of a node that ends with an error.
    pub fn flush_log(&self, limit: Duration) {
        let Ok(topic) = self.resolve(TOPIC) else { return };
        let until = Instant::now() + limit;
        // Twice in a row: a line that is no longer queued may not be written to the socket yet.
        let mut times_sent = 0;
        while times_sent < 2 && Instant::now() < until {
            std::thread::sleep(FLUSH_POLL);
            let is_published = {
                let queue = lock(&QUEUE);
                queue.lines.is_empty() && !queue.is_publishing
            };
            times_sent = if is_published && self.network().has_sent_all(&topic) { times_sent + 1 } else { 0 };
        }
    }
}

/// Waits for the oldest queued line; `None` when none is queued and `is_alive` is `false`.
fn next_line(is_alive: impl Fn() -> bool) -> Option<LogLine> {
    let mut queue = lock(&QUEUE);
    loop {
        if let Some(line) = queue.lines.pop_front() {
            queue.is_publishing = true;
            return Some(line);
        }
        if !is_alive() {
            queue.is_ended = true;
            return None;
        }
        queue = wait_timeout(&CHANGED, queue, PATIENCE);
    }
}
