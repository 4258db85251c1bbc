//! The images of the cameras for the pages: encoded once for all, only while a page waits for one.
//!
//! ```text
//!   offer ──► newest image of each camera ──► EncodingJob, 10/s at most ──► encoded ──► pages with credit
//! ```
//!
//! A page has credit for one image (`ready`). What nobody has credit for is not encoded, and a newer image replaces
//! one that waits. A camera's mask needs no credit and is sent when it changes.

use std::collections::HashMap;
use std::panic::{catch_unwind, AssertUnwindSafe};
use std::sync::{Arc, Condvar, Mutex};
use std::time::{Duration, Instant};

use hyper::body::Bytes;
use rcs_process::{lock, wait_timeout, IDLE_PERIOD};
use serde_json::json;
use tokio::sync::watch;

/// Shortest time between two images, or two masks, of a camera.
const PERIOD: Duration = Duration::from_millis(100);

/// Format of an encoded image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageFormat {
    /// Lossless.
    Png,
    /// Lossy.
    Jpeg,
}

/// An encoded image.
#[derive(Clone, Debug)]
pub struct ImageFile {
    /// The format of `bytes`.
    pub format: ImageFormat,
    /// Width and height of the encoded image in pixels.
    pub size_px: [u32; 2],
    /// Width and height of the camera's image, of which this may be a smaller copy.
    pub full_size_px: [u32; 2],
    /// The image's stamp in seconds of ROS time.
    pub stamp_secs: f64,
    /// The file.
    pub bytes: Vec<u8>,
}

/// Encodes an image; `None` if that fails.
type Encode = Box<dyn FnOnce() -> Option<ImageFile> + Send>;

/// The images of all cameras. Clones share them.
#[derive(Clone)]
pub struct Images(Arc<SharedImages>);

struct SharedImages {
    state: Mutex<ImagesState>,
    /// Work for the encoder's thread.
    work: Condvar,
    /// Something that pages send is new.
    news: watch::Sender<()>,
}

#[derive(Default)]
struct ImagesState {
    cameras: HashMap<String, Camera>,
    pages: HashMap<u64, Page>,
    last_page: u64,
    /// Counts encoded images and masks of all cameras.
    encoded: u64,
    is_ended: bool,
}

#[derive(Default)]
struct Camera {
    image: Slot,
    mask: Slot,
    /// A page has begun to watch.
    has_new_watcher: bool,
}

/// The newest image of a kind.
#[derive(Default)]
struct Slot {
    waiting: Option<Encode>,
    /// When the last one began to be encoded.
    begun: Option<Instant>,
    /// The number of the newest one that is encoded, and its message.
    encoded: Option<(u64, Bytes)>,
}

/// The cameras that a page watches, and the images that it has received.
#[derive(Default)]
struct Page {
    cameras: Vec<String>,
    has_credit: bool,
    /// The numbers of the last image and the last mask, by camera.
    sent: HashMap<String, [u64; 2]>,
}

/// The object of an encoding job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Image,
    Mask,
}

/// An image that is to be encoded.
pub struct EncodingJob {
    camera: String,
    kind: Kind,
    encode: Encode,
    images: Images,
}

impl Images {
    pub(crate) fn new(news: watch::Sender<()>) -> Self {
        Self(Arc::new(SharedImages { state: Mutex::default(), work: Condvar::new(), news }))
    }

    /// Returns `true` if a page watches the camera.
    pub fn is_watched(&self, camera: &str) -> bool {
        lock(&self.0.state).is_watched(camera)
    }

    /// Returns `true` if a page began to watch the camera since the last call.
    pub fn take_new_watcher(&self, camera: &str) -> bool {
        let mut state = lock(&self.0.state);
        state.cameras.get_mut(camera).is_some_and(|camera| std::mem::take(&mut camera.has_new_watcher))
    }

    /// Offers a camera's newest image, which replaces one that waits. Ignored while no page watches.
    pub fn offer(&self, camera: &str, encode: impl FnOnce() -> Option<ImageFile> + Send + 'static) {
        self.put(camera, Kind::Image, Box::new(encode));
    }

    /// Offers a camera's mask, as [`offer`](Self::offer) an image. Pages that begin to watch later get it, too.
    pub fn offer_mask(&self, camera: &str, encode: impl FnOnce() -> Option<ImageFile> + Send + 'static) {
        self.put(camera, Kind::Mask, Box::new(encode));
    }

    fn put(&self, camera: &str, kind: Kind, encode: Encode) {
        let mut state = lock(&self.0.state);
        if !state.is_watched(camera) {
            return;
        }
        let Some(slots) = state.cameras.get_mut(camera) else { return };
        slots.slot(kind).waiting = Some(encode);
        drop(state);
        self.0.work.notify_all();
    }

    /// Waits for the next image to encode; `None` at the end. For one thread.
    pub fn next_job(&self) -> Option<EncodingJob> {
        let mut state = lock(&self.0.state);
        while !state.is_ended {
            let now = Instant::now();
            match state.next_due(now) {
                Some((due, camera, kind)) if due <= now => {
                    let slot = state.cameras.get_mut(&camera)?.slot(kind);
                    slot.begun = Some(now);
                    let encode = slot.waiting.take()?;
                    return Some(EncodingJob { camera, kind, encode, images: self.clone() });
                }
                Some((due, ..)) => state = wait_timeout(&self.0.work, state, due.saturating_duration_since(now)),
                None => state = wait_timeout(&self.0.work, state, IDLE_PERIOD),
            }
        }
        None
    }

    /// Lets [`next_job`](Self::next_job) return `None`.
    pub(crate) fn end(&self) {
        lock(&self.0.state).is_ended = true;
        self.0.work.notify_all();
    }

    fn finish(&self, camera: &str, kind: Kind, file: &ImageFile) {
        let message = message(camera, kind, file);
        let mut state = lock(&self.0.state);
        state.encoded += 1;
        let encoded = (state.encoded, message);
        if let Some(slots) = state.cameras.get_mut(camera) {
            slots.slot(kind).encoded = Some(encoded);
        }
        drop(state);
        self.0.news.send_replace(());
    }

    /// A page that has connected.
    pub(crate) fn join(&self) -> u64 {
        let mut state = lock(&self.0.state);
        state.last_page += 1;
        let page = state.last_page;
        state.pages.insert(page, Page::default());
        page
    }

    pub(crate) fn leave(&self, page: u64) {
        let mut state = lock(&self.0.state);
        state.pages.remove(&page);
        state.forget_unwatched();
    }

    /// Replaces the cameras that a page watches. It has no credit then.
    pub(crate) fn watch(&self, page: u64, cameras: Vec<String>) {
        let mut state = lock(&self.0.state);
        for camera in &cameras {
            state.cameras.entry(camera.clone()).or_default().has_new_watcher = true;
        }
        state.pages.insert(page, Page { cameras, ..Page::default() });
        state.forget_unwatched();
    }

    /// Gives a page credit for one more image.
    pub(crate) fn ready(&self, page: u64) {
        if let Some(page) = lock(&self.0.state).pages.get_mut(&page) {
            page.has_credit = true;
        }
        self.0.work.notify_all();
    }

    /// The next message for a page: a mask, or an image if it has credit, which is used up then.
    pub(crate) fn next_message(&self, page: u64) -> Option<Bytes> {
        let mut state = lock(&self.0.state);
        let ImagesState { cameras, pages, .. } = &mut *state;
        let page = pages.get_mut(&page)?;
        for camera in &page.cameras {
            let sent = page.sent.entry(camera.clone()).or_default();
            let mask = cameras.get(camera).and_then(|slots| slots.mask.encoded.as_ref());
            if let Some((number, message)) = mask.filter(|(number, _)| *number > sent[1]) {
                sent[1] = *number;
                return Some(message.clone());
            }
        }
        if !page.has_credit {
            return None;
        }
        let new = |camera: &String| {
            let (slots, sent) = (cameras.get(camera)?, page.sent.get(camera).map_or(0, |sent| sent[0]));
            let (number, message) = slots.image.encoded.as_ref().filter(|(number, _)| *number > sent)?;
            slots.image.is_current().then(|| (sent, camera.clone(), *number, message.clone()))
        };
        // Of several cameras, the one that waited longest.
        let next = page.cameras.iter().filter_map(new).min_by_key(|(sent, ..)| *sent);
        let (_, camera, number, message) = next?;
        page.sent.entry(camera).or_default()[0] = number;
        page.has_credit = false;
        Some(message)
    }
}

impl ImagesState {
    fn is_watched(&self, camera: &str) -> bool {
        self.pages.values().any(|page| page.watches(camera))
    }

    /// The next image to encode, and when: now or later.
    fn next_due(&self, now: Instant) -> Option<(Instant, String, Kind)> {
        let due = |(name, camera): (&String, &Camera)| {
            let is_wanted = || self.pages.values().any(|page| page.has_credit && page.watches(name));
            let mask = camera.mask.due(now).map(|due| (due, name.clone(), Kind::Mask));
            let image = camera.image.due(now).filter(|_| is_wanted()).map(|due| (due, name.clone(), Kind::Image));
            mask.into_iter().chain(image).min_by_key(|(due, ..)| *due)
        };
        self.cameras.iter().filter_map(due).min_by_key(|(due, ..)| *due)
    }

    /// Drops the images of cameras that nobody watches: the next page gets new ones.
    fn forget_unwatched(&mut self) {
        let pages = &self.pages;
        self.cameras.retain(|camera, _| pages.values().any(|page| page.watches(camera)));
    }
}

impl Camera {
    fn slot(&mut self, kind: Kind) -> &mut Slot {
        match kind {
            Kind::Image => &mut self.image,
            Kind::Mask => &mut self.mask,
        }
    }
}

impl Slot {
    /// When the image that waits may be encoded.
    fn due(&self, now: Instant) -> Option<Instant> {
        self.waiting.as_ref().map(|_| self.begun.map_or(now, |begun| begun + PERIOD))
    }

    /// `true` unless a newer image waits that may be encoded already.
    fn is_current(&self) -> bool {
        self.waiting.is_none() || self.begun.is_some_and(|begun| begun.elapsed() < PERIOD)
    }
}

impl Page {
    fn watches(&self, camera: &str) -> bool {
        self.cameras.iter().any(|watched| watched == camera)
    }
}

impl EncodingJob {
    /// Encodes the image and gives it to the pages. A panic costs this image only.
    pub fn run(self) {
        let Self { camera, kind, encode, images } = self;
        // Why there is no file was logged where it failed.
        if let Ok(Some(file)) = catch_unwind(AssertUnwindSafe(encode)) {
            images.finish(&camera, kind, &file);
        }
    }
}

/// The message with an image: length of the head (4 bytes, little-endian), the head as JSON, the file.
fn message(camera: &str, kind: Kind, file: &ImageFile) -> Bytes {
    let head = json!({
        "type": match kind { Kind::Image => "image", Kind::Mask => "mask" },
        "camera": camera,
        "format": match file.format { ImageFormat::Png => "png", ImageFormat::Jpeg => "jpeg" },
        "width": file.size_px[0],
        "height": file.size_px[1],
        "full_width": file.full_size_px[0],
        "full_height": file.full_size_px[1],
        "stamp": file.stamp_secs,
    });
    let head = head.to_string();
    let mut message = Vec::with_capacity(4 + head.len() + file.bytes.len());
    message.extend_from_slice(&(head.len() as u32).to_le_bytes());
    message.extend_from_slice(head.as_bytes());
    message.extend_from_slice(&file.bytes);
    message.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn images() -> Images {
        Images::new(watch::Sender::new(()))
    }

    fn file(number: u8) -> Option<ImageFile> {
        let (size_px, full_size_px) = ([2, 1], [4, 2]);
        Some(ImageFile { format: ImageFormat::Png, size_px, full_size_px, stamp_secs: 1.5, bytes: vec![number] })
    }

    fn encode_next(images: &Images) {
        images.next_job().unwrap().run();
    }

    #[test]
    fn an_image_is_encoded_once_and_only_for_pages_with_credit() {
        let images = images();
        images.offer("proj", || panic!("nobody watches"));
        let pages = [images.join(), images.join()];
        pages.iter().for_each(|page| images.watch(*page, vec!["proj".to_owned()]));
        assert!(images.is_watched("proj") && !images.is_watched("other"));
        assert!(images.take_new_watcher("proj") && !images.take_new_watcher("proj"));
        images.offer("proj", || panic!("replaced by a newer one"));
        images.offer("proj", || file(7));
        assert!(lock(&images.0.state).next_due(Instant::now()).is_none(), "nobody has credit");
        images.ready(pages[0]);
        encode_next(&images);
        let message = images.next_message(pages[0]).unwrap();
        assert_eq!(message.last(), Some(&7));
        let head_len = u32::from_le_bytes(message[..4].try_into().unwrap()) as usize;
        let head: serde_json::Value = serde_json::from_slice(&message[4..4 + head_len]).unwrap();
        assert_eq!((&head["type"], &head["full_width"], &head["stamp"]), (&json!("image"), &json!(4), &json!(1.5)));
        assert!(images.next_message(pages[0]).is_none());
        images.ready(pages[0]);
        assert!(images.next_message(pages[0]).is_none(), "it has that image");
        assert!(images.next_message(pages[1]).is_none(), "it has no credit");
        images.ready(pages[1]);
        assert_eq!(images.next_message(pages[1]), Some(message));
    }

    #[test]
    fn a_page_gets_the_newest_image_and_not_one_that_waits_for_long() {
        let images = images();
        let page = images.join();
        images.watch(page, vec!["proj".to_owned()]);
        images.ready(page);
        images.offer("proj", || file(1));
        encode_next(&images);
        images.offer("proj", || file(2));
        std::thread::sleep(PERIOD);
        assert!(images.next_message(page).is_none(), "the second one is about to be encoded");
        encode_next(&images);
        assert_eq!(images.next_message(page).unwrap().last(), Some(&2));
    }

    #[test]
    fn masks_need_no_credit_and_several_cameras_take_turns() {
        let images = images();
        let page = images.join();
        images.watch(page, vec!["left".to_owned(), "right".to_owned()]);
        images.offer_mask("right", || file(9));
        encode_next(&images);
        assert_eq!(images.next_message(page).unwrap().last(), Some(&9));
        let mut seen = Vec::new();
        for _ in 0..4 {
            images.ready(page);
            for camera in ["left", "right"] {
                let number = camera.len() as u8;
                images.offer(camera, move || file(number));
            }
            encode_next(&images);
            encode_next(&images);
            seen.push(*images.next_message(page).unwrap().last().unwrap());
        }
        assert_ne!(seen[0], seen[1]);
        assert_eq!((seen[0], seen[1]), (seen[2], seen[3]));
    }

    #[test]
    fn a_panic_costs_one_image_and_what_nobody_watches_is_forgotten() {
        let images = images();
        let page = images.join();
        images.watch(page, vec!["proj".to_owned()]);
        images.ready(page);
        images.offer("proj", || panic!("a test's panic"));
        encode_next(&images);
        images.offer("proj", || file(3));
        encode_next(&images);
        assert_eq!(images.next_message(page).unwrap().last(), Some(&3));
        images.leave(page);
        assert!(lock(&images.0.state).cameras.is_empty() && !images.is_watched("proj"));
        images.end();
        assert!(images.next_job().is_none());
    }
}
