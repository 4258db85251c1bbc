//! The CPU renderer.

use rcs_scene::Picture;

use crate::{RenderError, Renderer, View};

/// Draws on the CPU.
#[derive(Debug, Default)]
pub struct CpuRenderer {}

impl CpuRenderer {
    /// A renderer that uses all cores.
    pub fn new() -> Self {
        Self::default()
    }
}

impl Renderer for CpuRenderer {
    fn describe(&self) -> String {
        "cpu".into()
    }

    fn render(&mut self, view: &View<'_>, picture: &mut Picture) -> Result<(), RenderError> {
        picture.reset(view.camera.width_px(), view.camera.height_px(), view.encoding);
        Ok(())
    }
}
