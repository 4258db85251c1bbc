//! The process's side of the dead-man's switch: starts the child, and tells it that the window's thread is alive.

use std::io::{self, Read};
use std::os::unix::process::CommandExt;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::Arc;
use std::thread::sleep;
use std::time::{Duration, Instant};

use rustix::event::{poll, PollFd, PollFlags, Timespec};
use rustix::fs::{fcntl_setfl, OFlags};
use rustix::io::Errno;

use super::{WindowRole, ALIVE, CHILD_ARGUMENT, OPEN};
use crate::monitor::MonitorChoice;
use crate::sink::ImageSink;
use crate::switch_pipe::SwitchPipe;
use crate::system_window::WindowOptions;

/// Silence after which the child blacks the monitor out, if the window has no light limit.
const DEFAULT_LIMIT: Duration = Duration::from_secs(5);
/// The shortest such silence: a busy computer pauses a thread for a moment.
const MIN_LIMIT: Duration = Duration::from_secs(1);
/// Bytes that the process sends per light limit.
const BEATS: u32 = 5;
/// Time in which the child opens its window.
const OPEN_PATIENCE: Duration = Duration::from_secs(5);
const POLL_PERIOD: Timespec = Timespec { tv_sec: 0, tv_nsec: 50_000_000 };
/// Time in which the child closes its windows.
const END_PATIENCE: Duration = Duration::from_millis(400);
const END_PERIOD: Duration = Duration::from_millis(5);
/// Time for which the child must be gone before that is an error: a display server that ends takes both windows away.
const LOSS_PATIENCE: Duration = Duration::from_secs(1);
/// Longest line of the child.
const MAX_LINE_BYTES: usize = 4096;

/// The dead-man's switch of a window, if it has one. Ends the child when dropped.
pub(crate) struct DeadManSwitch {
    source: String,
    state: SwitchState,
    /// `true` while the window's monitor is missing.
    is_monitor_gone: bool,
}

enum SwitchState {
    /// The window has none.
    Off,
    /// The child could not be started: why.
    Failed(String),
    Running(RunningChild),
}

/// The child process.
struct RunningChild {
    child: Child,
    pipe: Arc<SwitchPipe>,
    sink: ImageSink,
    period: Duration,
    next_beat: Instant,
    lost_at: Option<Instant>,
    is_loss_logged: bool,
}

impl DeadManSwitch {
    /// Starts the child for a window that is to be opened on top of its black one, and waits until that is on the
    /// screen. Does nothing for roles other than [`WindowRole::Guarded`].
    pub(crate) fn start(options: &WindowOptions, sink: &ImageSink) -> Self {
        let state = match options.role {
            WindowRole::Guarded if !sink.is_closing() => {
                RunningChild::start(options, sink).map_or_else(SwitchState::Failed, SwitchState::Running)
            }
            _ => SwitchState::Off,
        };
        Self { source: options.source.clone(), state, is_monitor_gone: false }
    }

    /// Logs a missing child. To be called when the process's own window is open: where no window can be opened, that is
    /// another error.
    pub(crate) fn report(&self) {
        if let SwitchState::Failed(reason) = &self.state {
            log::warn!("{}: no dead-man's switch: {reason}; {}", self.source, consequence());
        }
    }

    /// Tells the child that the window's thread is alive. Returns the time of the next call, at the latest.
    pub(crate) fn beat(&mut self, now: Instant) -> Option<Instant> {
        let SwitchState::Running(child) = &mut self.state else { return None };
        if now >= child.next_beat {
            child.next_beat = now + child.period;
            child.beat(now, &self.source);
        }
        Some(child.next_beat)
    }

    /// Starts the child anew if the window's monitor is back after it was missing. Returns `true` if the window then
    /// has to come to the front of the child's.
    pub(crate) fn restart_if_back(&mut self, is_there: bool, options: &WindowOptions, sink: &ImageSink) -> bool {
        let was_gone = std::mem::replace(&mut self.is_monitor_gone, !is_there);
        if matches!(self.state, SwitchState::Off) || !is_there || !was_gone {
            return false;
        }
        // The old child ends first.
        self.state = SwitchState::Off;
        *self = Self::start(options, sink);
        self.report();
        true
    }
}

/// The consequence of a missing child.
fn consequence() -> &'static str {
    "if the program hangs or is killed, the projector keeps the last image or shows the desktop"
}

impl RunningChild {
    /// Starts the child and waits for its window.
    #[expect(clippy::disallowed_methods, reason = "this program again, without a shell")]
    fn start(options: &WindowOptions, sink: &ImageSink) -> Result<Self, String> {
        // A grant of zero is one without an end.
        let limit = options.light_limit.filter(|limit| !limit.is_zero()).map_or(DEFAULT_LIMIT, |l| l.max(MIN_LIMIT));
        let monitor = match &options.monitor {
            MonitorChoice::Secondary => "auto",
            MonitorChoice::NameOrIndex(wanted) => wanted,
        };
        // The kernel's link leads to the executable even after an update has replaced its file.
        let mut command = Command::new("/proc/self/exe");
        if let Some(name) = std::env::args_os().next() {
            command.arg0(name);
        }
        command.args([CHILD_ARGUMENT, monitor, &limit.as_millis().to_string(), &options.source]);
        // Ctrl-C must reach the process first.
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).process_group(0);
        let mut child = command.spawn().map_err(|error| format!("cannot start the black window: {error}"))?;
        let opened = match (child.stdin.take(), child.stdout.take()) {
            (Some(pipe), Some(lines)) => wait_for_line(lines, sink)
                .and_then(|()| SwitchPipe::new(pipe).map_err(|error| format!("cannot use the pipe: {error}"))),
            _ => Err("no pipe".to_owned()),
        };
        match opened {
            Ok(pipe) => {
                let (pipe, sink) = (Arc::new(pipe), sink.clone());
                sink.set_switch(Some(Arc::clone(&pipe)));
                if sink.is_closing() {
                    pipe.end();
                }
                let (period, next_beat) = (limit / BEATS, Instant::now());
                Ok(Self { child, pipe, sink, period, next_beat, lost_at: None, is_loss_logged: false })
            }
            Err(reason) => {
                kill(&mut child);
                Err(reason)
            }
        }
    }

    fn beat(&mut self, now: Instant, source: &str) {
        if self.pipe.send(ALIVE) {
            return;
        }
        let lost_at = *self.lost_at.get_or_insert(now);
        if now.duration_since(lost_at) >= LOSS_PATIENCE && !self.is_loss_logged {
            self.is_loss_logged = true;
            let status = self.child.try_wait().ok().flatten().map(|status| format!(" with {status}"));
            let status = status.unwrap_or_default();
            log::error!("{source}: the dead-man's switch has ended{status}: {}; restart the program", consequence());
        }
    }
}

impl Drop for RunningChild {
    fn drop(&mut self) {
        self.sink.set_switch(None);
        self.pipe.end();
        if !has_ended(&mut self.child) {
            // It waits for a display server that hangs.
            kill(&mut self.child);
        }
    }
}

/// Waits a moment for a child's end; `false` if it runs on.
fn has_ended(child: &mut Child) -> bool {
    let started = Instant::now();
    while matches!(child.try_wait(), Ok(None)) {
        if started.elapsed() >= END_PATIENCE {
            return false;
        }
        sleep(END_PERIOD);
    }
    true
}

fn kill(child: &mut Child) {
    // Fails only if it has ended.
    let _ = child.kill();
    has_ended(child);
}

/// Waits until the child says that its window is open.
fn wait_for_line(mut lines: ChildStdout, sink: &ImageSink) -> Result<(), String> {
    let failed = |error: io::Error| format!("cannot read from the black window: {error}");
    fcntl_setfl(&lines, OFlags::NONBLOCK).map_err(|error| failed(error.into()))?;
    let started = Instant::now();
    let mut line = Vec::new();
    while !line.ends_with(b"\n") && line.len() < MAX_LINE_BYTES {
        if started.elapsed() >= OPEN_PATIENCE || sink.is_closing() {
            return Err(format!("the black window has not opened within {} s", OPEN_PATIENCE.as_secs()));
        }
        let mut descriptors = [PollFd::new(&lines, PollFlags::IN)];
        match poll(&mut descriptors, Some(&POLL_PERIOD)) {
            Ok(0) | Err(Errno::INTR) => continue,
            Ok(_) => {}
            Err(error) => return Err(failed(error.into())),
        }
        let mut bytes = [0; 256];
        match lines.read(&mut bytes) {
            Ok(0) => return Err("the black window's process has ended".to_owned()),
            Ok(count) => line.extend_from_slice(bytes.get(..count).unwrap_or(&bytes)),
            Err(error) if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted) => {}
            Err(error) => return Err(failed(error)),
        }
    }
    match String::from_utf8_lossy(&line).trim() {
        OPEN => Ok(()),
        reason => Err(reason.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn child_of(script: &str) -> Child {
        let mut command = Command::new("sh");
        command.args(["-c", script]).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap()
    }

    fn answer(script: &str) -> Result<(), String> {
        let mut child = child_of(script);
        let answer = wait_for_line(child.stdout.take().unwrap(), &ImageSink::new().unwrap());
        kill(&mut child);
        answer
    }

    #[test]
    fn a_child_says_that_it_is_open_or_why_not() {
        assert_eq!(answer("printf op; sleep 0.1; echo en"), Ok(()));
        assert_eq!(answer("echo 'no window: DISPLAY is not set'"), Err("no window: DISPLAY is not set".to_owned()));
        assert_eq!(answer("true"), Err("the black window's process has ended".to_owned()));
        assert!(answer("cat /dev/zero").is_err(), "an endless line");
    }

    #[test]
    fn a_closing_window_does_not_wait_for_its_child() {
        let mut child = child_of("sleep 100");
        let sink = ImageSink::new().unwrap();
        sink.close();
        assert!(wait_for_line(child.stdout.take().unwrap(), &sink).is_err());
        kill(&mut child);
    }

    #[test]
    fn a_full_pipe_does_not_block_and_a_closed_one_is_told() {
        let mut child = child_of("exec sleep 100");
        let pipe = SwitchPipe::new(child.stdin.take().unwrap()).unwrap();
        // More than a pipe holds.
        assert!((0..2_000_000).all(|_| pipe.send(ALIVE)));
        kill(&mut child);
        assert!(!pipe.send(ALIVE));
    }
}
