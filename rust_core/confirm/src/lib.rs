//! Confirmed light: a pixel is lit only where a depth camera measures the surface that the light is meant for.

#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod confirmer;
mod grid;
mod settings;

pub use confirmer::{Confirmation, Confirmer, ObjectDepths, Shares};
pub use grid::PointGrid;
pub use settings::{ConfirmSettings, Unseen};
