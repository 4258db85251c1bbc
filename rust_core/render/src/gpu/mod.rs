//! The GPU renderer.

use rcs_scene::Picture;

use crate::{RenderError, Renderer, View};

/// Draws with wgpu.
#[derive(Debug)]
pub struct GpuRenderer {}

impl GpuRenderer {
    /// Opens an adapter; `hardware_only` leaves software drivers out.
    ///
    /// # Errors
    /// [`RenderError::NoAdapter`].
    pub fn new(_hardware_only: bool) -> Result<Self, RenderError> {
        Err(RenderError::NoAdapter { reason: "none was looked for".into() })
    }
}

impl Renderer for GpuRenderer {
    fn describe(&self) -> String {
        "gpu".into()
    }

    fn render(&mut self, _view: &View<'_>, _picture: &mut Picture) -> Result<(), RenderError> {
        Err(RenderError::NoAdapter { reason: "none was looked for".into() })
    }
}
