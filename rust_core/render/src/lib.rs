//! Draws scenes: the [`Renderer`] trait and its two renderers.
//!
//! [`CpuRenderer`] is the reference and the default where there is no hardware GPU: on a two-core machine it draws a
//! point cloud an order of magnitude faster than Mesa's software drivers do. [`GpuRenderer`] draws the same image
//! with wgpu, within the limits of GL 3.3-class hardware. Both take the same scene and both pass the same golden
//! tests; neither knows of ROS.
//!
//! A red point on a black image:
//!
//! ```
//! use std::sync::Arc;
//!
//! use nalgebra::{Isometry3, Matrix4, Point3};
//! use rcs_render::{create, RendererChoice, View};
//! use rcs_scene::{
//!     Camera, DisplayMask, Drawable, Encoding, Geometry, Intrinsics, Image, PointBuffer, PointColors, PointStyle,
//!     Points, RenderGroup, Scene,
//! };
//!
//! let buffer = PointBuffer { positions: vec![[0.0, 0.0, 2.0]], colors: PointColors::Uniform([255, 0, 0, 255]) };
//! let style = PointStyle::Points { diameter_px: 5.0 };
//! let cloud = Points { buffer: Arc::new(buffer), style, alpha: 1.0, blended: false, auto_size: false };
//! let drawable = Drawable {
//!     display: 0,
//!     fixed_from_object: Matrix4::identity(),
//!     sort_point: Point3::origin(),
//!     group: RenderGroup::Main,
//!     geometry: Geometry::Points(cloud),
//! };
//! let scene = Scene { drawables: vec![drawable], light: None };
//!
//! // 64×48 pixels, the focal length 50 pixels; the optical frame is the fixed frame.
//! let p = [50.0, 0.0, 32.0, 0.0, 0.0, 50.0, 24.0, 0.0, 0.0, 0.0, 1.0, 0.0];
//! let camera = Camera::new(Intrinsics::from_p(64, 48, &p)?, &Isometry3::identity(), 0.01);
//!
//! let mut renderer = create(RendererChoice::Cpu)?;
//! let visible = DisplayMask::all();
//! let view =
//!     View { scene: &scene, camera: &camera, visible: &visible, background: [0, 0, 0], encoding: Encoding::Rgb8 };
//! let mut image = Image::default();
//! renderer.render(&view, &mut image)?;
//!
//! let pixel = |x: usize, y: usize| &image.data[y * image.step() + 3 * x..][..3];
//! assert_eq!(pixel(32, 24), [255, 0, 0]);
//! assert_eq!(pixel(0, 0), [0, 0, 0]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod auto;
mod cache;
mod choice;
mod cpu;
mod depths;
mod gpu;
mod post;
mod renderer;
mod shading;

pub use choice::{create, RendererChoice};
pub use cpu::{CpuRenderer, Culling};
pub use depths::{DepthRequest, Depths};
pub use gpu::{GpuRenderer, GpuStats};
pub use post::{Blend, BlendError, Brightness, KeepOut, LightMask, Orientation, PostProcess, Sphere};
pub use renderer::{Finished, RenderError, Renderer, View};
