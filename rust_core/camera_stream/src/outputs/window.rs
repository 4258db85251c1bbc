//! A camera's images in a window of this process, full screen on a monitor.
//!
//! The window has a thread of its own, which waits for events of its window system. While it cannot be open (no
//! display, no such monitor, a display server that went away), that is logged once and tried again, and nothing else of
//! the node depends on it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use anyhow::Result;
use rcs_light::Grant;
use rcs_process::{join_within, lock};
use rcs_window::{run_with, ImageSink, MonitorInfo, OnScreen, Refresh, UserEvent, WindowKey, WindowOptions};

use super::{Output, OutputFrame};
use crate::runtime::watchdog::{self, Task, Worker};

/// Time until a window that could not be opened is tried again.
const RETRY_AFTER: Duration = Duration::from_secs(2);
const END_PATIENCE: Duration = Duration::from_millis(500);

/// Shows a camera's images in a window.
#[derive(Clone)]
pub(crate) struct WindowOutput {
    sink: ImageSink,
    viewer: Arc<Viewer>,
    /// Watched for as long as the output is used.
    _worker: Arc<WindowWorker>,
}

/// The window's thread for the watchdog: it hangs if its display server does.
struct WindowWorker {
    source: String,
    sink: ImageSink,
    viewer: Arc<Viewer>,
}

impl Worker for WindowWorker {
    fn step(&self) -> Option<(String, Instant)> {
        let since = self.sink.waiting_since().filter(|_| self.viewer.is_there.load(Ordering::Acquire))?;
        Some((format!("showing a picture in the window of {}", self.source), since))
    }

    fn consequence(&self) -> Option<&'static str> {
        Some("the display server may not answer")
    }
}

/// Viewers of the window.
#[derive(Debug, Default)]
struct Viewer {
    is_there: AtomicBool,
    is_new: AtomicBool,
    /// Size of the monitor.
    monitor_px: Mutex<Option<[u32; 2]>>,
}

/// A window's thread. Closes the window when dropped.
pub(crate) struct WindowThread {
    sink: ImageSink,
    thread: Option<JoinHandle<()>>,
}

impl WindowOutput {
    /// Opens a window, on a thread of its own. `wake` is called when it is open and has no image yet, `press` with each
    /// key.
    ///
    /// # Errors
    /// The thread or its descriptors cannot be created.
    pub(crate) fn open(
        options: WindowOptions,
        wake: impl Fn() + Send + 'static,
        press: impl Fn(WindowKey) + Send + 'static,
    ) -> std::io::Result<(WindowOutput, WindowThread)> {
        let (sink, viewer) = (ImageSink::new()?, Arc::<Viewer>::default());
        let source = options.source.clone();
        let worker = Arc::new(WindowWorker { source, sink: sink.clone(), viewer: Arc::clone(&viewer) });
        watchdog::watch(&worker);
        let output = Self { sink: sink.clone(), viewer: Arc::clone(&viewer), _worker: worker };
        let window_sink = sink.clone();
        let running = move || keep_open(&options, &window_sink, &viewer, &wake, &press);
        let thread = thread::Builder::new().name("window".to_owned()).spawn(running)?;
        Ok((output, WindowThread { sink, thread: Some(thread) }))
    }

    /// The refresh of the window's monitor; `None` where the display server does not tell, or the window is closed.
    pub(crate) fn refresh(&self) -> Option<Refresh> {
        self.sink.refresh().filter(|_| self.is_watched())
    }

    /// Size of the monitor, once the window was open.
    pub(crate) fn monitor_px(&self) -> Option<[u32; 2]> {
        *lock(&self.viewer.monitor_px)
    }

    /// Gives the last image a later grant.
    pub(crate) fn renew(&self, grant: &Grant) {
        self.sink.renew(grant);
    }

    /// Has the window check the grant of its image now.
    pub(crate) fn wake(&self) {
        self.sink.wake();
    }

    /// Shows black until the next image: its camera was removed.
    pub(crate) fn clear(&self) {
        self.sink.clear();
    }
}

/// Opens the window again whenever it had to close, until that is asked for or the user closes it.
fn keep_open(options: &WindowOptions, sink: &ImageSink, viewer: &Viewer, wake: &dyn Fn(), press: &dyn Fn(WindowKey)) {
    let mut last_error = String::new();
    let opening = Task::watched(format!("opening the window of {}", options.source));
    while !sink.is_closing() {
        opening.begin();
        let set_monitor = |monitor: &MonitorInfo| {
            *lock(&viewer.monitor_px) = Some([monitor.size_px.0, monitor.size_px.1]);
        };
        let result = run_with(options, sink, |event, _| match event {
            UserEvent::Opened(monitor) => {
                set_monitor(monitor);
                opening.wait_for_work();
                viewer.is_new.store(true, Ordering::Release);
                viewer.is_there.store(true, Ordering::Release);
                wake();
            }
            // A key that is held down would toggle something again and again.
            UserEvent::Key { key, is_repeat } if !is_repeat => press(key),
            UserEvent::Key { .. } => {}
            UserEvent::MonitorChanged(monitor) => set_monitor(monitor),
        });
        opening.wait_for_work();
        let was_open = viewer.is_there.swap(false, Ordering::AcqRel);
        match result {
            Ok(()) => {
                if !sink.is_closing() {
                    log::info!("{}: the window was closed; the topics go on", options.source);
                }
                return;
            }
            Err(error) => {
                let error = error.to_string();
                if was_open || error != last_error {
                    log::error!("{}: {error}; the topics go on, and the window is tried again", options.source);
                }
                last_error = error;
            }
        }
        let again = Instant::now() + RETRY_AFTER;
        while !sink.is_closing() && Instant::now() < again {
            thread::park_timeout(again.saturating_duration_since(Instant::now()));
        }
    }
}

impl Output for WindowOutput {
    fn send(&mut self, frame: &OutputFrame) -> Result<()> {
        if self.is_watched() {
            let on_screen = frame.shown.clone().map(|record| record as Arc<dyn OnScreen>);
            match frame.image.lit_image() {
                Some(lit) => self.sink.show_drawn(lit.clone(), on_screen),
                None => {
                    self.sink.clear();
                    on_screen.iter().for_each(|record| record.shown());
                }
            }
        }
        Ok(())
    }

    fn is_watched(&self) -> bool {
        self.viewer.is_there.load(Ordering::Acquire)
    }

    fn take_new_watcher(&mut self) -> bool {
        self.viewer.is_new.swap(false, Ordering::AcqRel)
    }
}

impl Drop for WindowThread {
    fn drop(&mut self) {
        self.sink.close();
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            // One that waits for its display server ends with the process.
            join_within(thread, END_PATIENCE);
        }
    }
}
