//! The interface of the renderers.

use std::any::Any;
use std::time::Duration;

use rcs_scene::{Camera, DisplayId, DisplayMask, Encoding, Image, Scene};
use thiserror::Error;

use crate::{DepthRequest, Depths};

/// A scene as a camera sees it: the input of an image.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The camera that sees it; it also gives the image's size.
    pub camera: &'a Camera,
    /// Which displays the camera shows.
    pub visible: &'a DisplayMask,
    /// The colour where nothing is, red first.
    pub background: [u8; 3],
    /// How the image is laid out.
    pub encoding: Encoding,
}

/// Why an image could not be drawn.
#[derive(Debug, Error)]
pub enum RenderError {
    /// There is no GPU adapter that wgpu can use.
    #[error("no GPU adapter can be used: {reason}")]
    NoAdapter {
        /// wgpu's message.
        reason: String,
    },
    /// The GPU failed while drawing.
    #[error("GPU {adapter}: {reason}")]
    Gpu {
        /// The adapter's name.
        adapter: String,
        /// wgpu's message.
        reason: String,
    },
    /// Something in the renderer panicked. What it kept for the next images is dropped, and it can draw again.
    #[error("{renderer} panicked: {reason}")]
    Panicked {
        /// Which renderer.
        renderer: String,
        /// The panic's message.
        reason: String,
    },
    /// The image is larger than this renderer can draw.
    #[error("a picture of {width_px}×{height_px} is larger than the {limit_px} that {renderer} can draw")]
    TooLarge {
        /// Pixels in a row.
        width_px: u32,
        /// Rows.
        height_px: u32,
        /// The longest side it can draw.
        limit_px: u32,
        /// Which renderer.
        renderer: String,
    },
}

/// What [`Renderer::finish`] found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum Finished {
    /// An image, which was written.
    Drawn,
    /// No image was in flight.
    NoneInFlight,
}

/// The message of a panic.
pub(crate) fn panic_text(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("no message")
}

/// Draws images of scenes. It may keep what it derived from a geometry for as long as that geometry's `Arc` lives.
///
/// An image is made in two steps, so that a GPU draws while its caller goes on: [`Renderer::submit`] begins one, and
/// [`Renderer::finish`] returns the one that was begun first. Between the two it is *in flight*.
///
/// ```
/// use nalgebra::Isometry3;
/// use rcs_render::{CpuRenderer, Finished, Renderer, View};
/// use rcs_scene::{Camera, DisplayMask, Encoding, Intrinsics, Image, Scene};
///
/// let p = [50.0, 0.0, 4.0, 0.0, 0.0, 50.0, 3.0, 0.0, 0.0, 0.0, 1.0, 0.0];
/// let camera = Camera::new(Intrinsics::from_p(8, 6, &p)?, &Isometry3::identity(), 0.01);
/// let (scene, visible) = (Scene::default(), DisplayMask::all());
/// let view =
///     View { scene: &scene, camera: &camera, visible: &visible, background: [1, 2, 3], encoding: Encoding::Rgb8 };
///
/// let mut renderer = CpuRenderer::new();
/// renderer.submit(&view)?;
/// let mut image = Image::default();
/// assert_eq!(renderer.finish(&mut image)?, Finished::Drawn);
/// assert_eq!(image.data, [1, 2, 3].repeat(8 * 6));
/// assert_eq!(renderer.finish(&mut image)?, Finished::NoneInFlight);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Renderer: Send {
    /// A name for the log: `cpu (2 threads)`, `gpu (Intel(R) HD Graphics, Vulkan)`.
    fn describe(&self) -> String;

    /// What drawing each display took in the image that was finished last, added over all threads and shared out
    /// as well as the renderer knows. Empty for a renderer that does not measure that, or an image that was not slow.
    fn costs(&self) -> Vec<(DisplayId, Duration)> {
        Vec::new()
    }

    /// The number of images in flight from which more bring no gain. Where that is one, an image that is begun
    /// before another is finished only keeps that one waiting.
    fn images_at_once(&self) -> usize {
        1
    }

    /// True if it draws [`PackedPoints`](rcs_scene::PackedPoints) without decoding them on the CPU.
    fn takes_packed_points(&self) -> bool {
        false
    }

    /// True while a GPU draws images in flight, so that its caller may prepare the next scene and
    /// [`upload`](Self::upload) it without keeping them waiting.
    fn can_upload(&self) -> bool {
        false
    }

    /// Uploads the clouds of a scene that will be drawn next. A failure is found with the next image.
    fn upload(&mut self, _scene: &Scene, _visible: &DisplayMask) {}

    /// Begins an image. What the view refers to is not needed any more when this returns.
    ///
    /// # Errors
    /// See [`RenderError`]. An image that is too large leaves the others in flight; with [`RenderError::Gpu`] they are
    /// dropped, too.
    fn submit(&mut self, view: &View<'_>) -> Result<(), RenderError> {
        self.submit_with_depths(view, &DepthRequest::default())
    }

    /// Like [`Renderer::submit`], for an image whose depths are wanted, too. The image is the same.
    ///
    /// # Errors
    /// See [`Renderer::submit`].
    fn submit_with_depths(&mut self, view: &View<'_>, request: &DepthRequest<'_>) -> Result<(), RenderError>;

    /// Waits for the image that is in flight longest and writes it to `image`, which takes its view's size and
    /// encoding; its memory is used again. When none is in flight, `image` stays as it was.
    ///
    /// # Errors
    /// See [`RenderError`]; the image's content is then undefined, and with [`RenderError::Gpu`] no other is in
    /// flight any more.
    fn finish(&mut self, image: &mut Image) -> Result<Finished, RenderError> {
        self.finish_with_depths(image, &mut Depths::default())
    }

    /// Like [`Renderer::finish`], and writes the depths that were requested with the image.
    ///
    /// # Errors
    /// See [`Renderer::finish`]; the depths are then undefined, too.
    fn finish_with_depths(&mut self, image: &mut Image, depths: &mut Depths) -> Result<Finished, RenderError>;

    /// Gives memory back that is kept for the next images of the sizes that there were: they have others from now on.
    /// Images in flight are not affected.
    fn forget_sizes(&mut self) {}

    /// Draws into `image`, which takes the view's size and encoding; its memory is used again. Images that are in
    /// flight are dropped.
    ///
    /// # Errors
    /// See [`RenderError`]; the image's content is then undefined.
    fn render(&mut self, view: &View<'_>, image: &mut Image) -> Result<(), RenderError> {
        self.submit(view)?;
        while self.finish(image)? == Finished::Drawn {}
        Ok(())
    }
}
