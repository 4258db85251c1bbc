//! A camera's images in a window of this process, full screen on a monitor.
//!
//! The window has a thread of its own, which waits for events of its window system. While it cannot be open (no
//! display, no such monitor, a display server that went away), that is logged once and tried again, and nothing else of
//! the node depends on it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use anyhow::Result;
use rcs_render::LastStep;
use rcs_scene::{join_within, Picture};
use rcs_window::{
    run_with, LightLimit, LitPicture, Mask, OnScreen, PictureSink, Refresh, UserEvent, WindowKey, WindowOptions,
    WindowPermit, WindowView,
};

use super::{Output, OutputFrame};
use crate::runtime::watchdog::{self, Task, Worker};
use crate::safety::permit::{shares, Allowance, Permit};

/// Time until a window that could not be opened is tried again.
const RETRY_AFTER: Duration = Duration::from_secs(2);
const END_PATIENCE: Duration = Duration::from_millis(500);

/// Shows a camera's images in a window.
#[derive(Clone)]
pub(crate) struct WindowOutput {
    sink: PictureSink,
    viewer: Arc<Viewer>,
    /// Watched for as long as the output is used.
    _worker: Arc<WindowWorker>,
}

/// The window's thread for the watchdog: it hangs if its display server does.
struct WindowWorker {
    source: String,
    sink: PictureSink,
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
}

/// A window's thread. Closes the window when dropped.
pub(crate) struct WindowThread {
    sink: PictureSink,
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
        let (sink, viewer) = (PictureSink::new()?, Arc::<Viewer>::default());
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

    /// Confirms that the last image is still valid.
    pub(crate) fn confirm(&self) {
        self.sink.confirm();
    }

    /// Selects what the window shows.
    pub(crate) fn set_view(&self, view: WindowView) {
        self.sink.set_view(view);
    }

    /// Shows black until the next image: its camera was removed, or it is blacked out.
    pub(crate) fn clear(&self) {
        self.sink.clear();
    }
}

/// Opens the window again whenever it had to close, until that is asked for or the user closes it.
fn keep_open(options: &WindowOptions, sink: &PictureSink, viewer: &Viewer, wake: &dyn Fn(), press: &dyn Fn(WindowKey)) {
    let mut last_error = String::new();
    let opening = Task::watched(format!("opening the window of {}", options.source));
    while !sink.is_closing() {
        opening.begin();
        let result = run_with(options, sink, |event, _| match event {
            UserEvent::Opened(_) => {
                opening.wait_for_work();
                viewer.is_new.store(true, Ordering::Release);
                viewer.is_there.store(true, Ordering::Release);
                wake();
            }
            UserEvent::Key(key) => press(key),
            UserEvent::MonitorChanged(_) => {}
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
            let drawn_px = frame.permit.post.orientation.size_px([frame.picture.width_px, frame.picture.height_px]);
            let permit = window_permit(&frame.permit, Some(drawn_px));
            let picture = Arc::clone(&frame.picture);
            let on_screen = frame.shown.clone().map(|record| record as Arc<dyn OnScreen>);
            self.sink.show_drawn(LitPicture { picture, permit, on_screen });
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

/// Converts an image's permit for a window. `drawn_px` is the size of its images before they are turned; without one,
/// the monitor's.
pub fn window_permit(permit: &Permit, drawn_px: Option<[u32; 2]>) -> WindowPermit {
    WindowPermit { is_lit: permit.is_lit, test: test_light(permit, drawn_px) }
}

/// The light of test pictures in a window.
pub(crate) fn test_light(permit: &Permit, drawn_px: Option<[u32; 2]>) -> LightLimit {
    match permit.test {
        Allowance::All => LightLimit::All,
        Allowance::Masked => LightLimit::Masked(Arc::new(PostMask { post: Arc::clone(&permit.post), drawn_px })),
        Allowance::Nothing => LightLimit::Nothing,
    }
}

/// A camera's post-processing, for test pictures in its window.
#[derive(Debug)]
struct PostMask {
    post: Arc<LastStep>,
    /// Width and height before turning.
    drawn_px: Option<[u32; 2]>,
}

impl Mask for PostMask {
    fn shares(&self, monitor_px: [u32; 2]) -> Picture {
        let drawn_px = self.drawn_px.unwrap_or_else(|| self.post.orientation.size_px(monitor_px));
        shares(&self.post, drawn_px, monitor_px)
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
