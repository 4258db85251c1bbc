//! What every renderer does, and the choice between them.

use std::str::FromStr;

use rcs_scene::{Camera, DisplayMask, Encoding, Picture, Scene};
use thiserror::Error;

use crate::{CpuRenderer, GpuRenderer};

/// One look at a scene.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// What is there.
    pub scene: &'a Scene,
    /// From where it is looked at; also the picture's size.
    pub camera: &'a Camera,
    /// Which displays the camera shows.
    pub visible: &'a DisplayMask,
    /// The colour where nothing is, red first.
    pub background: [u8; 3],
    /// How the picture is laid out.
    pub encoding: Encoding,
}

/// Why a picture could not be drawn.
#[derive(Debug, Error)]
pub enum RenderError {
    /// There is no GPU adapter that wgpu can use.
    #[error("no GPU adapter can be used: {reason}")]
    NoAdapter {
        /// What wgpu says.
        reason: String,
    },
    /// The GPU gave up while drawing.
    #[error("GPU {adapter}: {reason}")]
    Gpu {
        /// The adapter's name.
        adapter: String,
        /// What wgpu says.
        reason: String,
    },
    /// The picture is larger than this renderer can draw.
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

/// Draws pictures of scenes. It may keep what it derived from a geometry for as long as that geometry's `Arc` lives.
///
/// A picture is made in two steps, so that a GPU draws while its caller goes on: [`Renderer::submit`] begins one, and
/// [`Renderer::finish`] hands out the one that was begun first. Between the two it is *in flight*.
pub trait Renderer: Send {
    /// What it is, for the log: `cpu (2 threads)`, `gpu (Intel(R) HD Graphics, Vulkan)`.
    fn describe(&self) -> String;

    /// How many pictures may be in flight with a gain. Where that is one, a picture that is begun before another is
    /// finished only keeps that one waiting.
    fn pictures_at_once(&self) -> usize {
        1
    }

    /// Begins a picture. What the view refers to is not needed any more when this returns.
    ///
    /// # Errors
    /// See [`RenderError`]. A picture that is too large leaves the others in flight; with [`RenderError::Gpu`] they are
    /// gone, too.
    fn submit(&mut self, view: &View<'_>) -> Result<(), RenderError>;

    /// Waits for the picture that is in flight longest and writes it to `picture`, which takes its view's size and
    /// encoding; its memory is used again. `false`, and `picture` as it was, when none is in flight.
    ///
    /// # Errors
    /// See [`RenderError`]; the picture's content is then undefined, and with [`RenderError::Gpu`] no other is in flight
    /// any more.
    fn finish(&mut self, picture: &mut Picture) -> Result<bool, RenderError>;

    /// Draws into `picture`, which takes the view's size and encoding; its memory is used again. Pictures that are in
    /// flight are dropped.
    ///
    /// # Errors
    /// See [`RenderError`]; the picture's content is then undefined.
    fn render(&mut self, view: &View<'_>, picture: &mut Picture) -> Result<(), RenderError> {
        self.submit(view)?;
        while self.finish(picture)? {}
        Ok(())
    }
}

/// Which renderer a user asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum RendererChoice {
    /// A hardware GPU where there is one, else the CPU.
    #[default]
    Auto,
    /// The CPU.
    Cpu,
    /// The GPU, software drivers included.
    Gpu,
}

impl FromStr for RendererChoice {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        match name {
            "auto" => Ok(Self::Auto),
            "cpu" => Ok(Self::Cpu),
            "gpu" => Ok(Self::Gpu),
            _ => Err(format!("{name} is not one of auto, cpu, gpu")),
        }
    }
}

/// Makes the chosen renderer.
///
/// # Errors
/// [`RenderError::NoAdapter`] when the GPU is asked for and there is none that works.
pub fn create(choice: RendererChoice) -> Result<Box<dyn Renderer>, RenderError> {
    match choice {
        RendererChoice::Cpu => Ok(Box::new(CpuRenderer::new())),
        RendererChoice::Gpu => Ok(Box::new(GpuRenderer::new(false)?)),
        RendererChoice::Auto => Ok(match GpuRenderer::new(true) {
            Ok(gpu) => Box::new(gpu),
            Err(error) => {
                log::debug!("drawing on the CPU: {error}");
                Box::new(CpuRenderer::new())
            }
        }),
    }
}
