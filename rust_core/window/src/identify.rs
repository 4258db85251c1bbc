//! Identification of monitors: each shows its number, name, resolution and position for a while.

use std::thread;
use std::time::{Duration, Instant};

use rcs_process::join_within;

use crate::test_images::identification;
use crate::{list_monitors, run_with, ImageSink, MonitorChoice, MonitorInfo, ScreenImage, WindowError, WindowOptions};

/// Period of checks for the end.
const PERIOD: Duration = Duration::from_millis(50);

/// Longest time for all windows to close.
const CLOSE_TIMEOUT: Duration = Duration::from_secs(4);

/// Shows each monitor's identification on it, until Escape or q there, for `duration`, or until `is_ending`.
///
/// # Errors
/// The first [`WindowError`]; the other monitors are identified nevertheless.
pub fn identify(duration: Duration, is_ending: impl Fn() -> bool) -> Result<(), WindowError> {
    let mut shown = Vec::new();
    for (index, monitor) in list_monitors()?.into_iter().enumerate() {
        let sink = ImageSink::new()?;
        let window_sink = sink.clone();
        let showing = move || show(index, &monitor, &window_sink);
        shown.push((sink, thread::Builder::new().name(format!("monitor {index}")).spawn(showing)?));
    }
    let start = Instant::now();
    let are_open = |shown: &[(_, thread::JoinHandle<_>)]| shown.iter().any(|(_, thread)| !thread.is_finished());
    while start.elapsed() < duration && !is_ending() && are_open(&shown) {
        thread::sleep(PERIOD);
    }
    shown.iter().for_each(|(sink, _)| sink.close());
    let asked = Instant::now();
    let ended = shown.into_iter().map(|(_, thread)| join_within(thread, CLOSE_TIMEOUT.saturating_sub(asked.elapsed())));
    let results = ended.map(|result| match result {
        Some(Ok(result)) => result,
        // The panic was printed.
        Some(Err(_)) => Ok(()),
        None => Err(WindowError::Lost("the display server does not answer".to_owned())),
    });
    results.fold(Ok(()), Result::and)
}

fn show(index: usize, monitor: &MonitorInfo, sink: &ImageSink) -> Result<(), WindowError> {
    let image = identification(index, monitor);
    if let Ok(image) = ScreenImage::from_image(&image) {
        sink.show(image);
    }
    let name = if monitor.name.is_empty() { index.to_string() } else { monitor.name.clone() };
    let monitor = MonitorChoice::NameOrIndex(name);
    let options = WindowOptions { source: "the monitor's name".to_owned(), monitor, ..WindowOptions::default() };
    run_with(&options, sink, |_, _| {})
}
