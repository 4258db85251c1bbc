//! A camera's images as JPEG or PNG on the topic `compressed` below the image topic, as image_transport has it.
//!
//! Encoding takes longer than publishing, so it has a thread of its own, with lower priority than those that draw. Its
//! queue holds one image, which a newer one replaces, and nobody waits for the thread. Nothing is encoded while nobody
//! subscribes, and the thread starts with the first image.

use std::panic::{catch_unwind, AssertUnwindSafe};
use std::sync::mpsc::{sync_channel, Receiver};
use std::sync::{Arc, Condvar, Mutex};
use std::thread;
use std::time::Instant;

use rcs_files::image_file;
use rcs_messages::dynamic_reconfigure::Config as Values;
use rcs_messages::sensor_msgs::CompressedImage;
use rcs_messages::std_msgs::Header;
use rcs_process::{lock, wait_while};
use rcs_ros::settings::{accepted, NamedValues};
use rcs_ros::{Publisher, ReconfigureServer, RosNode};

use super::compressed_settings::{CompressionSettings, NAMES};
use super::FrameImage;
use crate::runtime::watchdog::Task;

pub(super) struct CompressedOutput {
    shared: Arc<CompressionQueue>,
    /// The settings that the parameter server holds, until they have come.
    start: Option<Receiver<CompressionSettings>>,
    /// `None` before those have come, and where its services cannot be offered.
    server: Option<ReconfigureServer>,
    is_started: bool,
}

/// The queue of the thread that encodes.
struct CompressionQueue {
    publisher: Arc<Publisher<CompressedImage>>,
    work: Mutex<Work>,
    changed: Condvar,
}

struct Work {
    /// The newest image that is not encoded yet.
    next: Option<Waiting>,
    settings: CompressionSettings,
    is_ended: bool,
}

/// An image that is not encoded yet.
struct Waiting {
    image: FrameImage,
    header: Header,
}

impl CompressionQueue {
    /// The next image, with the settings for it; `None` at the end.
    fn wait(&self) -> Option<(Waiting, CompressionSettings)> {
        let idle = |work: &mut Work| work.next.is_none() && !work.is_ended;
        let mut work = wait_while(&self.changed, lock(&self.work), idle);
        let next = work.next.take().filter(|_| !work.is_ended)?;
        Some((next, work.settings))
    }
}

impl CompressedOutput {
    /// Uses default settings until those of the parameter server have come.
    pub(super) fn start(ros: &RosNode, publisher: &Arc<Publisher<CompressedImage>>) -> Self {
        let settings = CompressionSettings::default();
        let work = Mutex::new(Work { next: None, settings, is_ended: false });
        let shared = Arc::new(CompressionQueue { publisher: Arc::clone(publisher), work, changed: Condvar::new() });
        let (sender, start) = sync_channel(1);
        let events = Arc::clone(ros.events());
        // The master may be silent.
        let names = NAMES.map(|name| format!("{}/{name}", publisher.topic()));
        ros.fetch_texts(names.to_vec(), move |values| {
            let value = |name: &str| values.get(NAMES.iter().position(|known| *known == name)?)?.clone();
            // Fails where the topic is gone.
            let _ = sender.send(CompressionSettings::start(value));
            events.wake();
        });
        Self { shared, start: Some(start), server: None, is_started: false }
    }

    /// Takes over the settings that the parameter server had, and offers them, once they have come.
    pub(super) fn poll_settings(&mut self, ros: &RosNode) {
        let Some(settings) = self.start.as_ref().and_then(|start| start.try_recv().ok()) else { return };
        self.start = None;
        lock(&self.shared.work).settings = settings;
        let topic = self.shared.publisher.topic();
        let server = ros.serve_reconfigure(topic, settings.groups());
        self.server = server.map_err(|error| log::error!("{error}")).ok();
    }

    /// dynamic_reconfigure's server with its settings.
    pub(super) fn server(&self) -> Option<&ReconfigureServer> {
        self.server.as_ref()
    }

    /// Applies a user's values from the next image on. Returns those that apply now; `None` without a server.
    pub(super) fn reconfigure(&mut self, ros: &RosNode, request: &NamedValues) -> Option<Values> {
        let server = self.server.as_mut()?;
        let mut settings = lock(&self.shared.work).settings;
        accepted(server.groups(), request).iter().for_each(|(name, value)| settings.take(name, value));
        lock(&self.shared.work).settings = settings;
        Some(server.set(ros, settings.groups()))
    }

    /// Has an image encoded and published if somebody subscribes. Never waits.
    pub(super) fn offer(&mut self, image: &FrameImage, header: Header) {
        if !self.shared.publisher.is_watched() {
            return;
        }
        lock(&self.shared.work).next = Some(Waiting { image: image.clone(), header });
        self.shared.changed.notify_one();
        if !self.is_started {
            let shared = Arc::clone(&self.shared);
            let started = thread::Builder::new().name("compress".to_owned()).spawn(move || encode_all(&shared));
            self.is_started = started.is_ok();
            if let Err(error) = started {
                log::error!("{}: cannot start the thread that compresses: {error}", self.shared.publisher.topic());
            }
        }
    }
}

impl Drop for CompressedOutput {
    fn drop(&mut self) {
        lock(&self.shared.work).is_ended = true;
        self.shared.changed.notify_one();
    }
}

fn encode_all(shared: &CompressionQueue) {
    rcs_resources::yield_to_others();
    let mut is_failure_logged = false;
    let task = Task::watched(format!("compressing a picture of {}", shared.publisher.topic()));
    while let Some((Waiting { image, header }, settings)) = shared.wait() {
        let publisher = &shared.publisher;
        task.begin();
        let result = guarded(|| {
            let content = image.content(Instant::now());
            let data = image_file::encode(&content, settings.coding()).map_err(|error| error.to_string())?;
            let format = settings.format(content.encoding);
            // Drawn into again while the message is on its way.
            drop(content);
            if image.grant().is_some_and(|grant| !grant.is_valid(Instant::now())) {
                // A blackout came meanwhile.
                return Ok(());
            }
            drop(image);
            publisher.send_compressed(header, &format, data).map_err(|error| error.to_string())
        });
        task.wait_for_work();
        match result {
            Ok(()) => is_failure_logged = false,
            Err(error) if !is_failure_logged => {
                log::error!("{}: cannot compress: {error}", publisher.topic());
                is_failure_logged = true;
            }
            Err(_) => {}
        }
    }
}

/// Catches a panic of the encoder, which is logged, so that the next image is encoded all the same.
fn guarded<T>(encode: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(encode)).unwrap_or_else(|_| Err("the encoder panicked".to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_of_the_encoder_costs_that_image_only() {
        assert_eq!(guarded(|| Ok(1)), Ok(1));
        assert_eq!(guarded::<u8>(|| std::panic::panic_any("damaged")), Err("the encoder panicked".to_owned()));
    }
}
