//! Life cycle of a ROS node: arguments, signals, connection to the master, shutdown.
//!
//! SIGINT, SIGTERM and `rosnode kill` request the shutdown ([`EndRequest`]): the node unregisters and exits with 0. A
//! second signal ends it at once. The error that ends a node is the last line of its log, on `/rosout` and in the file
//! of
//! `__log:=` as well; only then it unregisters ([`finish`]).

use std::ffi::OsString;
use std::io;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::Context as _;
use clap::Parser;
use rcs_process::lock;
use rcs_ros::{NodeError, RosNode};
use signal_hook::consts::{SIGINT, SIGTERM};

/// Period at which a waiting node polls for the shutdown request.
const POLL_PERIOD: Duration = Duration::from_millis(100);
/// Time that the last line of the log may take to reach `/rosout`.
const LAST_LINE_TIMEOUT: Duration = Duration::from_secs(1);

/// The program's arguments, its name first, without those of ROS, which contain `:=`.
pub fn own_arguments() -> Vec<OsString> {
    without_ros_arguments(std::env::args_os())
}

fn without_ros_arguments(arguments: impl IntoIterator<Item = OsString>) -> Vec<OsString> {
    let is_own = |(index, argument): &(usize, OsString)| *index == 0 || !argument.to_string_lossy().contains(":=");
    arguments.into_iter().enumerate().filter(is_own).map(|(_, argument)| argument).collect()
}

/// Name remappings `from:=to` among the program's arguments, without `_parameter:=` and `__name:=`.
pub fn remappings() -> Vec<(String, String)> {
    remappings_among(std::env::args_os().skip(1))
}

fn remappings_among(arguments: impl IntoIterator<Item = OsString>) -> Vec<(String, String)> {
    let remapping = |argument: OsString| {
        let argument = argument.to_string_lossy().into_owned();
        let (from, to) = argument.split_once(":=")?;
        (!from.starts_with('_')).then(|| (from.to_owned(), to.to_owned()))
    };
    arguments.into_iter().filter_map(remapping).collect()
}

/// Runs a program with the process's arguments, and ends its node. An error is the last line of the log.
pub fn run_main<A: Parser>(run: impl FnOnce(A) -> anyhow::Result<()>) -> ExitCode {
    let arguments = A::parse_from(own_arguments());
    let _flush = rcs_logging::start_node(false);
    finish(&run(arguments))
}

/// Connects to the master, waiting for it, and runs `work` on the node. Returns at once if the shutdown is requested
/// while it waits.
///
/// # Errors
/// Signal handlers that cannot be installed, a node that cannot start, or the error of `work`.
pub fn with_node(
    default_name: &str,
    work: impl FnOnce(&RosNode, &EndRequest) -> anyhow::Result<()>,
) -> anyhow::Result<()> {
    let end = EndRequest::watch_signals().context("cannot handle signals")?;
    connect(default_name, &end)?.map_or(Ok(()), |node| work(&node, &end))
}

/// Logs the error that ended the program, if any, shuts the process's node down, and returns the exit status.
pub fn finish(result: &anyhow::Result<()>) -> ExitCode {
    let node = lock(&NODE).take();
    if let Err(error) = result {
        rcs_logging::log_last(&rcs_logging::one_line(error));
        if let Some(node) = &node {
            node.flush_log(LAST_LINE_TIMEOUT);
        }
    }
    if let Some(node) = node {
        node.shutdown();
    }
    if result.is_ok() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

/// The process's node, held until the error that ends the program is logged.
static NODE: Mutex<Option<Arc<RosNode>>> = Mutex::new(None);

/// Shutdown request of the process; clones share it.
#[derive(Debug, Clone)]
pub struct EndRequest {
    requested: Arc<AtomicBool>,
}

impl EndRequest {
    /// Handles SIGINT and SIGTERM.
    ///
    /// # Errors
    /// A signal handler cannot be installed.
    pub fn watch_signals() -> io::Result<Self> {
        let requested = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            // In this order: the first signal sets the flag, a second one finds it set.
            signal_hook::flag::register_conditional_default(signal, Arc::clone(&requested))?;
            signal_hook::flag::register(signal, Arc::clone(&requested))?;
        }
        Ok(Self { requested })
    }

    /// Requests the shutdown.
    pub fn request(&self) {
        self.requested.store(true, Ordering::Release);
    }

    /// `true` once a signal was received or the ROS master shut the node down.
    pub fn is_requested(&self) -> bool {
        self.requested.load(Ordering::Acquire) || rcs_ros::is_asked_to_end()
    }

    /// Waits until the shutdown is requested, at most for `duration`; `true` if it is.
    pub fn wait_for(&self, duration: Duration) -> bool {
        // None: the sum overflows.
        let until = Instant::now().checked_add(duration);
        loop {
            if self.is_requested() {
                return true;
            }
            rcs_logging::report_suppressed();
            let left = until.map_or(Duration::MAX, |until| until.saturating_duration_since(Instant::now()));
            if left.is_zero() {
                return false;
            }
            thread::sleep(left.min(POLL_PERIOD));
        }
    }
}

/// Waits for the ROS master and starts the node, which [`finish`] ends. `None` if the shutdown was requested meanwhile.
///
/// # Errors
/// [`NodeError`] if the master's address is invalid or the node cannot start.
pub fn connect(default_name: &str, end: &EndRequest) -> Result<Option<Arc<RosNode>>, NodeError> {
    started(RosNode::connect(default_name, &|| end.is_requested()))
}

/// As [`connect`], without waiting.
///
/// # Errors
/// As those of [`connect`], and [`NodeError::NoMaster`].
pub fn connect_now(default_name: &str, end: &EndRequest) -> Result<Option<Arc<RosNode>>, NodeError> {
    started(RosNode::connect_now(default_name, &|| end.is_requested()))
}

fn started(result: Result<RosNode, NodeError>) -> Result<Option<Arc<RosNode>>, NodeError> {
    match result {
        Ok(node) => {
            node.serve_log(rcs_logging::loggers())?;
            let node = Arc::new(node);
            *lock(&NODE) = Some(Arc::clone(&node));
            Ok(Some(node))
        }
        Err(NodeError::Cancelled(_)) => Ok(None),
        Err(error) => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ros_arguments_are_left_to_ros() {
        let arguments = ["/bin/a:=b", "file.yaml", "__name:=x", "_file:=y", "image:=/z", "--rate", "2"];
        let own = without_ros_arguments(arguments.map(OsString::from));
        assert_eq!(own, ["/bin/a:=b", "file.yaml", "--rate", "2"]);
        let arguments = ["file.yaml", "__name:=x", "_file:=y", "image:=/z", "--rate", "/a:=/b:=c"];
        let remappings = remappings_among(arguments.map(OsString::from));
        assert_eq!(remappings, [("image", "/z"), ("/a", "/b:=c")].map(|(from, to)| (from.to_owned(), to.to_owned())));
    }

    #[test]
    fn an_end_request_is_seen_by_all_and_ends_the_wait() {
        let end = EndRequest { requested: Arc::default() };
        assert!(!end.wait_for(Duration::from_millis(1)));
        let request = end.clone();
        let requesting = thread::spawn(move || request.request());
        for duration in [Duration::from_secs(60), Duration::from_secs_f64(1e19), Duration::MAX] {
            assert!(end.wait_for(duration), "{duration:?}");
        }
        requesting.join().unwrap();
    }
}
