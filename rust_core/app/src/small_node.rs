//! The life of a small ROS node: its arguments, the wait for the master, and an orderly end.
//!
//! ROS gives every node arguments with `:=` in them (`topic:=other`, `_param:=value`, `__name:=name`), which rosrust
//! reads by itself; [`own_arguments`] are the others. SIGINT, SIGTERM and `rosnode kill` ask the node to end
//! ([`EndRequest`]); it then unregisters and exits with 0. A second signal ends it at once.

use std::ffi::OsString;
use std::io;
use std::net::{TcpStream, ToSocketAddrs};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGINT, SIGTERM};

/// How often the node looks whether it is asked to end, and for a master that is not there yet.
const LOOK_PERIOD: Duration = Duration::from_millis(100);
/// How long unregistering may take when the master does not answer.
const UNREGISTER_TIME: Duration = Duration::from_secs(2);

/// Why there is no node.
#[derive(Debug, thiserror::Error)]
pub enum NodeError {
    /// The master's address cannot be used.
    #[error("ROS_MASTER_URI '{0}' is not of the form http://HOST:PORT")]
    MasterUri(String),
    /// rosrust cannot start the node.
    #[error("cannot start the node at the ROS master {master_uri}: {reason}")]
    Start {
        /// The master's address.
        master_uri: String,
        /// What rosrust says.
        reason: String,
    },
}

/// The program's arguments, its name first, without those that are ROS's.
pub fn own_arguments() -> Vec<OsString> {
    without_ros_arguments(std::env::args_os())
}

fn without_ros_arguments(arguments: impl IntoIterator<Item = OsString>) -> Vec<OsString> {
    let is_own = |(index, argument): &(usize, OsString)| *index == 0 || !argument.to_string_lossy().contains(":=");
    arguments.into_iter().enumerate().filter(is_own).map(|(_, argument)| argument).collect()
}

/// The right side of the remapping `name:=other` among the program's arguments, if there is one.
pub fn remapping_of(name: &str) -> Option<String> {
    std::env::args_os().skip(1).find_map(|argument| {
        let argument = argument.to_string_lossy().into_owned();
        let (from, to) = argument.split_once(":=")?;
        (from.trim_start_matches('/') == name).then(|| to.to_owned())
    })
}

/// Whether the node is asked to end. Clones ask the same.
#[derive(Debug, Clone)]
pub struct EndRequest {
    requested: Arc<AtomicBool>,
}

impl EndRequest {
    /// Takes SIGINT and SIGTERM from now on.
    ///
    /// # Errors
    /// The system's, when it refuses.
    pub fn watch_signals() -> io::Result<Self> {
        let requested = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            // In this order: the first signal sets the flag, a second one finds it set.
            signal_hook::flag::register_conditional_default(signal, Arc::clone(&requested))?;
            signal_hook::flag::register(signal, Arc::clone(&requested))?;
        }
        Ok(Self { requested })
    }

    /// Asks the node to end.
    pub fn request(&self) {
        self.requested.store(true, Ordering::Release);
    }

    /// Whether a signal came or the ROS master asked the node to end.
    pub fn is_requested(&self) -> bool {
        self.requested.load(Ordering::Acquire) || (rosrust::is_initialized() && !rosrust::is_ok())
    }

    /// Waits until the end is requested, or for `duration`; true for the end.
    pub fn wait_for(&self, duration: Duration) -> bool {
        let until = Instant::now() + duration;
        loop {
            if self.is_requested() {
                return true;
            }
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return false;
            }
            thread::sleep(left.min(LOOK_PERIOD));
        }
    }

    /// Waits until the end is requested.
    pub fn wait(&self) {
        while !self.wait_for(Duration::from_secs(3600)) {}
    }
}

/// Waits for the ROS master, saying so once, and starts the node there. False when the end was requested before.
///
/// # Errors
/// [`NodeError`] when the master's address is no address or the node cannot start.
pub fn connect(default_name: &str, end: &EndRequest) -> Result<bool, NodeError> {
    let master_uri = rosrust::api::resolve::master();
    let address = host_and_port(&master_uri).ok_or_else(|| NodeError::MasterUri(master_uri.clone()))?;
    let mut said = false;
    while !answers(&address) {
        if !said {
            log::warn!("no ROS master at {master_uri} yet, waiting for it");
            said = true;
        }
        if end.wait_for(LOOK_PERIOD) {
            return Ok(false);
        }
    }
    // The signals are taken already.
    rosrust::try_init_with_options(default_name, false)
        .map_err(|error| NodeError::Start { master_uri, reason: error.to_string() })?;
    Ok(true)
}

/// The whole name of a topic, remappings applied, for messages.
pub fn resolved(topic: &str) -> String {
    // A parameter's name is resolved by the same rules as a topic's.
    let name = rosrust::is_initialized().then(|| rosrust::param(topic)).flatten();
    name.map_or_else(|| topic.to_owned(), |parameter| parameter.name().to_owned())
}

/// Host and port of `http://HOST:PORT/`.
fn host_and_port(uri: &str) -> Option<String> {
    let address = uri.strip_prefix("http://")?.trim_end_matches('/');
    let (host, port) = address.rsplit_once(':')?;
    port.parse::<u16>().ok()?;
    (!host.is_empty()).then(|| address.to_owned())
}

fn answers(address: &str) -> bool {
    let Ok(mut addresses) = address.to_socket_addrs() else {
        return false;
    };
    addresses.any(|address| TcpStream::connect_timeout(&address, Duration::from_secs(1)).is_ok())
}

/// Unregisters: drops `connections` (publishers and subscribers), then ends the node. Waits two seconds at most, so
/// that a master that does not answer cannot hold the program.
pub fn shut_down<T: Send + 'static>(connections: T) {
    let (done, is_done) = mpsc::channel();
    let spawned = thread::Builder::new().name("unregister".to_owned()).spawn(move || {
        drop(connections);
        if rosrust::is_initialized() {
            rosrust::shutdown();
        }
        // Nobody waits any longer when time was up.
        let _ = done.send(());
    });
    if spawned.is_err() || is_done.recv_timeout(UNREGISTER_TIME).is_err() {
        log::warn!("the ROS master does not answer; ending without unregistering");
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
    }

    #[test]
    fn the_masters_address_is_read_from_its_uri() {
        assert_eq!(host_and_port("http://localhost:11311").as_deref(), Some("localhost:11311"));
        assert_eq!(host_and_port("http://10.0.0.2:123/").as_deref(), Some("10.0.0.2:123"));
        for wrong in ["localhost:11311", "http://localhost", "http://:1", "http://host:port", ""] {
            assert_eq!(host_and_port(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn an_end_request_is_seen_by_all_and_ends_the_wait() {
        let end = EndRequest { requested: Arc::default() };
        assert!(!end.wait_for(Duration::from_millis(1)));
        end.clone().request();
        assert!(end.wait_for(Duration::from_secs(60)));
    }
}
