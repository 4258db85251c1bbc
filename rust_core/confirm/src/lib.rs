//! Confirmed light: a pixel is lit only where a depth camera measures the surface that the light is meant for.
//!
//! ```text
//! depth image ─► PointGrid ─► surface seen from the projector ─┐
//!                                                              ├─► comparison ─► hold times ─► LightMask, Shares
//! depths of the scene ─► ObjectDepths ─────────────────────────┘
//! ```
//!
//! [`Confirmer`] takes depth images and answers for images. The measured points are projected into the image that the
//! projector's pinhole draws, neighbours are connected, and jumps between them become side walls, behind which nothing
//! is known. Where there is light, surfaces and side walls are drawn into depth buffers over cells of 2×2 pixels; lens
//! and flip only choose a cell for each cell of the finished image. An object at the depth of its cell's surface is
//! confirmed, one behind it is blocked, one before it is gone, and one behind a side wall or without a surface is
//! unseen.
//!
//! Where something is nearer than all objects around it, it is in the way, and darkens a margin. The edge of an object,
//! which noise moves over the light of what is behind, does not.

#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod cells;
mod comparison;
mod confirmer;
mod grazing;
mod grid;
mod hold_times;
mod image_cells;
mod objects;
mod projected;
mod quads;
mod settings;
mod surface;
mod tiles;

pub use confirmer::{Confirmation, Confirmer};
pub use grid::PointGrid;
pub use objects::{ObjectDepths, Shares};
pub use projected::HOLE_PX;
pub use settings::{ConfirmSettings, Unseen};
