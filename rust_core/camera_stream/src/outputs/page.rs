//! A camera's images on the operator's page, as its projector shows them, with the mask of where there may be light.
//!
//! A page that watches counts as a subscriber. Images are encoded on a thread of their own ([`encode_all`]), only while
//! a page waits for one, and once for all pages.

use std::time::Instant;

use anyhow::Result;
use rcs_light::Grant;
use rcs_messages::{stamp_nanos, Time};
use rcs_scene::Encoding;
use rcs_web::{ImageFile, Images};

use super::page_image::{image_file, mask_file};
use super::{FrameImage, Output, OutputFrame};
use crate::runtime::watchdog::Task;
use crate::safety::black_image::black_image;

/// Shows a camera's images on the page.
pub(crate) struct PageOutput {
    images: Images,
    camera: String,
    /// The grant and size of the mask that the pages have; the grant is `None` for all dark.
    mask: Option<(Option<Grant>, [u32; 2])>,
}

impl PageOutput {
    /// The pages' view of a camera.
    pub(crate) fn new(images: &Images, camera: &str) -> Self {
        Self { images: images.clone(), camera: camera.to_owned(), mask: None }
    }

    /// Offers the mask if it has changed.
    fn offer_mask(&mut self, image: &FrameImage, stamp_secs: f64) {
        let (grant, size_px) = (image.grant(), image.size_px());
        let is_same = |known: &Option<Grant>| match (known, grant) {
            (Some(known), Some(grant)) => known.allows_the_same(grant),
            (None, None) => true,
            (Some(_), None) | (None, Some(_)) => false,
        };
        if self.mask.as_ref().is_some_and(|(known, size)| *size == size_px && is_same(known)) {
            return;
        }
        self.mask = Some((grant.cloned(), size_px));
        let grant = grant.cloned();
        let mask = move || {
            let dark = || black_image(size_px, Encoding::Mono8);
            mask_file(&grant.map_or_else(dark, |grant| grant.allowed()), stamp_secs)
        };
        self.images.offer_mask(&self.camera, mask);
    }
}

impl Output for PageOutput {
    fn send(&mut self, frame: &OutputFrame) -> Result<()> {
        if !self.is_watched() {
            self.mask = None;
            return Ok(());
        }
        let (image, stamp_secs) = (frame.image.clone(), secs(frame.stamp));
        self.offer_mask(&image, stamp_secs);
        self.images.offer(&self.camera, move || encode(&image.content(Instant::now()), stamp_secs));
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

fn encode(image: &rcs_scene::Image, stamp_secs: f64) -> Option<ImageFile> {
    let file = image_file(image, stamp_secs);
    file.map_err(|error| log::error!("the page: cannot encode an image: {error}")).ok()
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
