//! Draws scenes: the [`Renderer`] trait and its two renderers.
//!
//! [`CpuRenderer`] is the reference and the default where there is no hardware GPU: on a two-core machine it draws a
//! point cloud an order of magnitude faster than Mesa's software drivers do. [`GpuRenderer`] draws the same picture
//! with wgpu, within the limits of GL 3.3-class hardware. Both take the same scene and both pass the same golden
//! tests; neither knows of ROS.
#![forbid(unsafe_code)]

mod bounds;
mod cpu;
mod gpu;
mod renderer;

pub use cpu::CpuRenderer;
pub use gpu::{GpuRenderer, GpuStats};
pub use renderer::{create, RenderError, Renderer, RendererChoice, View};
