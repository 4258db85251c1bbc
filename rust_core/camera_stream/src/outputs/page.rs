//! A camera's images on the operator's page, as its projector shows them, with the mask of where there may be light.
//!
//! A page that watches counts as a subscriber. Images are encoded on a thread of their own ([`encode_all`]), only while
//! a page waits for one, and once for all pages.

use std::sync::{Arc, Mutex};

use anyhow::Result;
use rcs_messages::{stamp_nanos, Time};
use rcs_render::LastStep;
use rcs_scene::lock;
use rcs_web::{ImageFile, Images};

use super::page_image::{mask_file, Costs};
use super::{Output, OutputFrame};
use crate::runtime::watchdog::Task;
use crate::safety::permit::shares;

/// Shows a camera's images on the page.
pub(crate) struct PageOutput {
    images: Images,
    camera: String,
    costs: Arc<Mutex<Costs>>,
    /// Post-processing and size of the mask that the pages have.
    mask: Option<(Arc<LastStep>, [u32; 2])>,
}

impl PageOutput {
    /// The pages' view of a camera.
    pub(crate) fn new(images: &Images, camera: &str) -> Self {
        Self { images: images.clone(), camera: camera.to_owned(), costs: Arc::default(), mask: None }
    }

    /// Offers the mask if it has changed.
    fn offer_mask(&mut self, post: &Arc<LastStep>, size_px: [u32; 2], stamp_secs: f64) {
        if self
            .mask
            .as_ref()
            .is_some_and(|(known, size)| *size == size_px && (Arc::ptr_eq(known, post) || known == post))
        {
            return;
        }
        self.mask = Some((Arc::clone(post), size_px));
        let post = Arc::clone(post);
        let drawn_px = post.orientation.size_px(size_px);
        self.images.offer_mask(&self.camera, move || mask_file(&shares(&post, drawn_px, size_px), stamp_secs));
    }
}

impl Output for PageOutput {
    fn send(&mut self, frame: &OutputFrame) -> Result<()> {
        if !self.is_watched() {
            self.mask = None;
            return Ok(());
        }
        let (picture, costs, stamp_secs) = (Arc::clone(&frame.picture), Arc::clone(&self.costs), secs(frame.stamp));
        self.offer_mask(&frame.permit.post, [picture.width_px, picture.height_px], stamp_secs);
        self.images.offer(&self.camera, move || encode(&picture, &costs, stamp_secs));
        Ok(())
    }

    fn is_watched(&self) -> bool {
        self.images.is_watched(&self.camera)
    }

    fn take_new_watcher(&mut self) -> bool {
        let is_new = self.images.take_new_watcher(&self.camera);
        if is_new {
            // The pages that watched before may have left meanwhile, and what they had with them.
            self.mask = None;
        }
        is_new
    }
}

fn encode(picture: &rcs_scene::Picture, costs: &Mutex<Costs>, stamp_secs: f64) -> Option<ImageFile> {
    lock(costs)
        .encode(picture, stamp_secs)
        .map_err(|error| log::error!("the page: cannot encode an image: {error}"))
        .ok()
}

fn secs(stamp: Time) -> f64 {
    stamp_nanos(stamp) as f64 * 1e-9
}

/// The encoder's thread: encodes until the server has ended.
pub(crate) fn encode_all(images: &Images) {
    rcs_resources::yield_to_others();
    let task = Task::watched("encoding an image for the page");
    while let Some(job) = images.next_job() {
        task.begin();
        job.run();
        task.wait_for_work();
    }
}
