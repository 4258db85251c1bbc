//! Confirmed light: a pixel is lit only where a depth camera measures the surface that the light is meant for.

#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod cells;
mod comparison;
mod confirmer;
mod grazing;
mod grid;
mod hold_times;
mod objects;
mod picture_cells;
mod projected;
mod quads;
mod settings;
mod surface;

pub use confirmer::{Confirmation, Confirmer};
pub use grid::PointGrid;
pub use objects::{ObjectDepths, Shares};
pub use projected::HOLE_PX;
pub use settings::{ConfirmSettings, Unseen};
