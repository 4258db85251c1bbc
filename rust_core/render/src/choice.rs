//! The choice between the renderers.

use std::str::FromStr;

use crate::auto::AutoRenderer;
use crate::{CpuRenderer, GpuRenderer, RenderError, Renderer};

/// The renderer that a user asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum RendererChoice {
    /// The faster of the CPU and a hardware GPU.
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
/// ```
/// use rcs_render::{create, RendererChoice};
///
/// let choice: RendererChoice = "cpu".parse()?;
/// let renderer = create(choice)?;
/// assert!(renderer.describe().starts_with("cpu ("));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`RenderError::NoAdapter`] when the GPU is asked for and there is none that works.
pub fn create(choice: RendererChoice) -> Result<Box<dyn Renderer>, RenderError> {
    match choice {
        RendererChoice::Cpu => Ok(Box::new(CpuRenderer::new())),
        RendererChoice::Gpu => Ok(Box::new(GpuRenderer::new(false)?)),
        RendererChoice::Auto => Ok(Box::new(AutoRenderer::start())),
    }
}
