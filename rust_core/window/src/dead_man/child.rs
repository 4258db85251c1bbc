//! The child process of the dead-man's switch: two black windows, the second only while the process is silent.

use std::io::{self, Write};
use std::os::unix::net::UnixDatagram;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use rcs_process::join_within;
use rustix::event::{PollFd, PollFlags};
use rustix::io::{read, Errno};

use super::hand_over::BlackPlace;
use super::{BlackWindow, Shown, WindowRole, OPEN};
use crate::error::WindowError;
use crate::monitor::MonitorChoice;
use crate::open::run_with;
use crate::run::UserEvent;
use crate::sink::ImageSink;
use crate::switch_pipe::END;
use crate::system_window::{poll_until, WindowOptions};

/// Time in which a window comes to the screen.
const SHOW_PATIENCE: Duration = Duration::from_secs(2);
const SHOW_PERIOD: Duration = Duration::from_millis(2);
/// Period of checking the windows.
const PERIOD: Duration = Duration::from_millis(250);
/// Time in which the process's own window covers this one's predecessor, and period of ending that.
const HAND_OVER_PERIOD: Duration = Duration::from_secs(1);
/// Time in which a window closes.
const CLOSE_PATIENCE: Duration = Duration::from_millis(200);

/// Runs the child, with the arguments behind its first one.
pub(super) fn main(arguments: impl Iterator<Item = String>) -> ExitCode {
    // Processes are ended by their names: `killall camera_stream` must not end this one, too.
    let _ = rustix::thread::set_name(c"black-window");
    let opened = Arguments::read(arguments).ok_or("invalid arguments".to_owned()).and_then(Watch::open);
    let line = opened.as_ref().map_or_else(String::as_str, |_| OPEN);
    // A process that has died meanwhile is noticed by its pipe.
    let _ = writeln!(io::stdout(), "{line}");
    match opened {
        Ok(watch) => {
            watch.run();
            ExitCode::SUCCESS
        }
        Err(_) => ExitCode::FAILURE,
    }
}

/// The child's arguments.
struct Arguments {
    monitor: MonitorChoice,
    limit: Duration,
    /// Name of the process's window, for the titles.
    source: String,
}

impl Arguments {
    fn read(mut arguments: impl Iterator<Item = String>) -> Option<Self> {
        let monitor = arguments.next()?.parse().ok()?;
        let limit = Duration::from_millis(arguments.next()?.parse().ok()?);
        Some(Self { monitor, limit, source: arguments.next()? })
    }
}

/// A black window on a thread of its own. Closes it when dropped.
struct BlackThread {
    sink: ImageSink,
    shown: Arc<Shown>,
    /// Name of the monitor, once the window is open.
    monitor: Arc<OnceLock<String>>,
    thread: Option<JoinHandle<Result<(), WindowError>>>,
}

impl BlackThread {
    fn open(arguments: &Arguments, is_in_front: bool, is_orphaned: &Arc<AtomicBool>) -> io::Result<Self> {
        let (sink, shown, monitor) = (ImageSink::new()?, Arc::<Shown>::default(), Arc::<OnceLock<String>>::default());
        let (is_orphaned, of_window) = (Arc::clone(is_orphaned), Arc::clone(&shown));
        let options = WindowOptions {
            source: format!("{} (black)", arguments.source),
            monitor: arguments.monitor.clone(),
            role: WindowRole::Black(BlackWindow { is_in_front, is_orphaned, shown: of_window }),
            ..WindowOptions::default()
        };
        let (window_sink, opened) = (sink.clone(), Arc::clone(&monitor));
        let running = move || {
            run_with(&options, &window_sink, |event, _| {
                if let UserEvent::Opened(monitor) = event {
                    // There is one such event.
                    let _ = opened.set(monitor.name.clone());
                }
            })
        };
        let thread = thread::Builder::new().name("window".to_owned()).spawn(running)?;
        Ok(Self { sink, shown, monitor, thread: Some(thread) })
    }

    /// `true` once the window is closed.
    fn is_closed(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// `true` if the user has closed the window.
    fn is_closed_by_user(&mut self) -> bool {
        let closed = self.thread.take_if(|thread| thread.is_finished());
        closed.and_then(|thread| join_within(thread, CLOSE_PATIENCE)).is_some_and(|result| matches!(result, Ok(Ok(()))))
    }

    /// Waits until the window is on the screen.
    fn wait_until_shown(&mut self) -> Result<(), String> {
        let started = Instant::now();
        while !self.shown.0.load(Ordering::Acquire) {
            if self.is_closed() {
                let result = self.thread.take().and_then(|thread| join_within(thread, CLOSE_PATIENCE)?.ok());
                return Err(result.and_then(Result::err).map_or("it was closed".to_owned(), |error| error.to_string()));
            }
            if started.elapsed() >= SHOW_PATIENCE {
                return Err("the display server does not bring a new window to the front".to_owned());
            }
            thread::sleep(SHOW_PERIOD);
        }
        Ok(())
    }
}

impl Drop for BlackThread {
    fn drop(&mut self) {
        self.sink.close();
        // One that waits for its display server ends with the process.
        self.thread.take().map(|thread| join_within(thread, CLOSE_PATIENCE));
    }
}

/// Bytes that the child has read.
#[derive(Debug, PartialEq, Eq)]
enum Heard {
    /// The process is alive.
    Alive,
    /// Nothing.
    Nothing,
    /// The process closes its window in order.
    End,
    /// The process has died.
    Death,
}

/// Reads what the process has sent until a time.
#[expect(clippy::disallowed_methods, reason = "poll waits with a limit")]
fn hear(until: Instant) -> Heard {
    let stdin = io::stdin();
    let mut descriptors = [PollFd::new(&stdin, PollFlags::IN)];
    // An error of poll is one of read as well.
    let _ = poll_until(&mut descriptors, until);
    if descriptors.iter().all(|descriptor| descriptor.revents().is_empty()) {
        return Heard::Nothing;
    }
    let mut bytes = [0; 4096];
    match read(&stdin, &mut bytes) {
        Ok(0) => Heard::Death,
        Ok(count) if bytes.iter().take(count).any(|byte| *byte == END) => Heard::End,
        Ok(_) => Heard::Alive,
        Err(Errno::INTR | Errno::AGAIN) => Heard::Nothing,
        Err(_) => Heard::Death,
    }
}

/// The child at work.
struct Watch {
    arguments: Arguments,
    /// Lies below the process's own window.
    below: BlackThread,
    /// Covers that while the process is silent.
    front: Option<BlackThread>,
    place: Option<BlackPlace>,
    is_orphaned: Arc<AtomicBool>,
    last_beat: Instant,
    next_hand_over: Instant,
}

impl Watch {
    /// Opens the window that the process's own one will cover. A second window in front of it is tried out first: on a
    /// display server that does not show it, the process's own would not be seen either.
    fn open(arguments: Arguments) -> Result<Self, String> {
        let failed = |error: io::Error| format!("cannot open the black window: {error}");
        let is_orphaned = Arc::<AtomicBool>::default();
        let mut below = BlackThread::open(&arguments, false, &is_orphaned).map_err(failed)?;
        below.wait_until_shown()?;
        BlackThread::open(&arguments, true, &is_orphaned).map_err(failed)?.wait_until_shown()?;
        let place = below.monitor.get().and_then(|monitor| BlackPlace::new(monitor).ok());
        let last_beat = Instant::now();
        let next_hand_over = last_beat + HAND_OVER_PERIOD;
        Ok(Self { arguments, below, front: None, place, is_orphaned, last_beat, next_hand_over })
    }

    /// Watches the process until it closes its window, or dies.
    fn run(mut self) {
        while !self.below.is_closed() {
            let due = self.last_beat + self.arguments.limit;
            let tick = Instant::now() + PERIOD;
            match hear(if self.front.is_none() { due.min(tick) } else { tick }) {
                Heard::Alive => {
                    self.last_beat = Instant::now();
                    self.front = None;
                }
                Heard::Nothing if Instant::now() < due => {}
                Heard::Nothing => {
                    if self.front.is_none() {
                        let Arguments { limit, source, .. } = &self.arguments;
                        let limit = limit.as_secs_f32();
                        tell(format!("{source}: the program has been silent for {limit} s: black until it goes on"));
                    }
                    self.cover();
                }
                Heard::End => return,
                Heard::Death => return self.stay_black(),
            }
            if let Some(place) = self.place.as_ref().filter(|_| Instant::now() >= self.next_hand_over) {
                place.end_other();
                self.next_hand_over = Instant::now() + HAND_OVER_PERIOD;
            }
        }
    }

    /// Opens the window in front, if it is not open. Where that fails, it is tried again with the next call.
    fn cover(&mut self) {
        if self.front.as_ref().is_some_and(|front| !front.is_closed()) {
            return;
        }
        self.front = BlackThread::open(&self.arguments, true, &self.is_orphaned).ok();
    }

    /// Keeps the monitor black after the process's death, until Escape or another process covers it.
    fn stay_black(mut self) {
        self.cover();
        self.is_orphaned.store(true, Ordering::Release);
        let source = &self.arguments.source;
        tell(format!("{source}: the program has died: black until it runs again, or Escape is pressed in this window"));
        let mut heir: Option<UnixDatagram> = None;
        while !self.below.is_closed() && !self.front.as_mut().is_some_and(BlackThread::is_closed_by_user) {
            if let Some(place) = self.place.as_ref().filter(|_| heir.is_none()) {
                heir = place.take();
                if heir.is_none() {
                    place.end_other();
                }
            }
            let mut descriptors: Vec<_> = heir.iter().map(|heir| PollFd::new(heir, PollFlags::IN)).collect();
            let _ = poll_until(&mut descriptors, Instant::now() + PERIOD);
            if descriptors.iter().any(|descriptor| !descriptor.revents().is_empty()) {
                return;
            }
        }
    }
}

/// Writes a line to standard error, from a thread of its own: who reads it may hang.
fn tell(line: String) {
    let writing = move || {
        let _ = writeln!(io::stderr(), "[ERROR] {line}");
    };
    let _ = thread::Builder::new().name("log".to_owned()).spawn(writing);
}
