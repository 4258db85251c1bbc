//! The node's log on `/rosout`, for rqt_console and `rostopic echo`, and the services by which its level is changed.
//!
//! A line may be logged anywhere, under any lock, also by what publishes; so [`log_line`] only queues it, and a thread
//! publishes. Lines from before the node has started are published when it has.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex};
use std::time::{Duration, Instant};

use rcs_messages::roscpp::{GetLoggers, GetLoggersRes, Logger, SetLoggerLevel};
use rcs_messages::rosgraph_msgs::Log;
use rcs_messages::std_msgs::Header;
use rcs_messages::std_srvs::EmptyRes;
use rcs_messages::Time;
use rcs_scene::{lock, wait_timeout};

use crate::error::NodeError;
use crate::node::RosNode;

const TOPIC: &str = "/rosout";
/// Lines that wait for the thread; the oldest give way.
const MAX_LINES: usize = 200;
/// Lines that wait for a slow subscriber.
const QUEUE_SIZE: usize = 200;
/// How often the thread looks whether the node is still there.
const PATIENCE: Duration = Duration::from_secs(1);
/// How often a node that is about to end looks whether its last line was sent.
const FLUSH_POLL: Duration = Duration::from_millis(10);
const THREAD_NAME: &str = "ros-rosout";

/// A line of the log.
#[derive(Clone, Debug)]
pub struct LogLine {
    /// Its level.
    pub level: log::Level,
    /// The text.
    pub text: String,
    /// The Rust module that logged it.
    pub module: String,
    /// The source file.
    pub file: String,
    /// The line there.
    pub line: u32,
    /// The node's time, zero before it has started.
    pub stamp: Time,
}

#[derive(Default)]
struct Queue {
    lines: VecDeque<LogLine>,
    /// A line was taken and is not published yet.
    is_publishing: bool,
    /// Nobody takes lines any more.
    is_ended: bool,
}

static QUEUE: Mutex<Queue> = Mutex::new(Queue { lines: VecDeque::new(), is_publishing: false, is_ended: false });
static CHANGED: Condvar = Condvar::new();

/// Publishes a line of the log on `/rosout` once the process's node runs. Never waits.
pub fn log_line(line: LogLine) {
    // What publishing itself logs would be published without end.
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

/// The number of a level in `rosgraph_msgs/Log`.
fn number(level: log::Level) -> i8 {
    match level {
        log::Level::Error => Log::ERROR,
        log::Level::Warn => Log::WARN,
        log::Level::Info => Log::INFO,
        log::Level::Debug | log::Level::Trace => Log::DEBUG,
    }
}

/// What has levels that can be changed.
pub trait Loggers: Send + Sync {
    /// Each logger with the level that it has: `debug`, `info`, `warn`, `error` or `fatal`.
    fn levels(&self) -> Vec<(String, String)>;

    /// Gives a logger a level; false if there is no such logger or level.
    fn set_level(&self, logger: &str, level: &str) -> bool;
}

impl RosNode {
    /// Publishes the log on `/rosout` and offers `~get_loggers` and `~set_logger_level`, for as long as the node lives.
    ///
    /// # Errors
    /// [`NodeError`], where a name cannot be resolved or there is no thread left.
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
                // Fails for more than 4 GB, which no line has.
                let _ = publisher.send(message);
                lock(&QUEUE).is_publishing = false;
            }
        };
        let spawned = std::thread::Builder::new().name(THREAD_NAME.to_owned()).spawn(publishing);
        spawned.map_err(|error| NodeError::Start { what: "the log's topic", reason: error.to_string() })?;
        let all = Arc::clone(&loggers);
        self.serve::<GetLoggers>(&self.resolve("~get_loggers")?, move |_| {
            let loggers = all.levels().into_iter().map(|(name, level)| Logger { name, level }).collect();
            Ok(GetLoggersRes { loggers })
        });
        self.serve::<SetLoggerLevel>(&self.resolve("~set_logger_level")?, move |request| {
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
    /// Waits until the log's last line was sent to a subscriber of `/rosout`, which connects a moment after the node
    /// has started, but no longer than `limit`. For the error that ends a node, before [`shutdown`](Self::shutdown).
    pub fn flush_log(&self, limit: Duration) {
        let Ok(topic) = self.resolve(TOPIC) else { return };
        let until = Instant::now() + limit;
        // Twice in a row: what is no longer queued may be under way to the socket.
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

/// The oldest line that waits, as soon as there is one; none when `is_alive` says so and none waits any more.
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
