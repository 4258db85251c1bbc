//! Progress of a scan or verification on the terminal and, for a live scan, as a preview on a topic.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use rcs_scan::preview::PreviewDecoder;
use rcs_scan::{ScanEvent, ScanFailure, ScanResult};
use rcs_scene::Image;

use super::screens::ImageTopic;

/// Time between two frames of the spinner.
const TICK: Duration = Duration::from_millis(200);

/// A progress bar that keeps clear of the log, and the preview's topic.
pub(crate) struct Progress {
    bar: ProgressBar,
    decoder: PreviewDecoder,
    preview: Option<ImageTopic>,
    camera_px: [u32; 2],
    projector_px: [u32; 2],
}

impl Progress {
    /// A spinner; `activity` says what the scan does until its first image.
    pub(crate) fn new(
        activity: &'static str,
        preview: Option<ImageTopic>,
        camera_px: [u32; 2],
        projector_px: [u32; 2],
    ) -> Self {
        let bar = ProgressBar::new_spinner().with_message(activity);
        bar.enable_steady_tick(TICK);
        Self { bar, decoder: PreviewDecoder::default(), preview, camera_px, projector_px }
    }

    /// Handles an event of the session.
    pub(crate) fn show(&mut self, event: &ScanEvent<'_>) {
        match event {
            ScanEvent::Delay(delay, images) => {
                let (seen, settled) = (delay.seen.as_millis(), delay.settled.as_millis());
                self.bar.suspend(|| log::info!("light is seen after {seen} ms and has settled after {settled} ms"));
                let style = ProgressStyle::with_template("{bar:40} {pos}/{len} pictures, {eta} left, {msg}");
                self.bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
                self.bar.set_length(*images as u64);
                // The time left is that of the images alone, without the search for the light.
                self.bar.reset();
                self.bar.set_message("");
            }
            ScanEvent::Captured { images, readable } => {
                self.bar.inc(1);
                self.decoder.add(images);
                if let Some(decoded) = self.decoder.share() {
                    self.bar.set_message(format!(
                        "{:.0} % of the lit pixels decoded so far, {:.0} % read the last stripes",
                        100.0 * decoded,
                        100.0 * readable
                    ));
                    if self.preview.is_some() {
                        let image = self.decoder.image(self.camera_px, self.projector_px);
                        self.publish(image);
                    }
                }
            }
            ScanEvent::Note(note) => self.bar.suspend(|| log::info!("{note}")),
            ScanEvent::Warning(warning) => self.bar.suspend(|| log::warn!("{warning}")),
        }
    }

    /// Publishes an image, if there is a topic for it.
    pub(crate) fn publish(&mut self, image: Image) {
        if let Some(Err(error)) = self.preview.as_mut().map(|preview| preview.send(image)) {
            self.bar.suspend(|| log::warn!("{error:#}"));
        }
    }

    /// Removes the bar.
    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }

    /// Leaves the bar of a scan with the share that was decoded in the end, in place of the estimate so far.
    pub(crate) fn finish_scan(&self, scanned: Result<ScanResult, ScanFailure>) -> Result<ScanResult, ScanFailure> {
        match &scanned {
            Ok(ScanResult { decoded, .. }) => {
                let message = format!("{:.0} % of the lit pixels decoded", 100.0 * decoded.share());
                self.bar.abandon_with_message(message);
            }
            Err(_) => self.finish(),
        }
        scanned
    }
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use rcs_scan::Delay;

    use super::*;

    #[test]
    fn the_time_left_counts_from_the_first_image() {
        let mut progress = Progress::new("looking for the light", None, [1, 1], [1, 1]);
        progress.bar.inc(5);
        std::thread::sleep(Duration::from_millis(20));
        let begin = Instant::now();
        let delay = Delay { seen: Duration::ZERO, settled: Duration::ZERO };
        progress.show(&ScanEvent::Delay(delay, 46));
        assert!(progress.bar.elapsed() <= begin.elapsed());
        assert_eq!((progress.bar.position(), progress.bar.length()), (0, Some(46)));
    }
}
