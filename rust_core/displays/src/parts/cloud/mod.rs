//! The common part of all displays of clouds: points in one of five styles, coloured by one of six transformers.
//!
//! Reproduces `rviz::PointCloudCommon`. As there, whatever a display subscribes to becomes a `sensor_msgs/PointCloud2`
//! ([`CloudSource`]); that is decoded and coloured once, when it is placed, and drawing it again costs no decoding. A
//! cloud stands where its frame was at its stamp. Without a decay time the newest cloud replaces the one before it.

mod clouds;
mod color;
mod display;
mod fields;
mod pieces;
mod points;

pub(crate) use clouds::{one_row, Clouds, Decoded, PlacedCloud};
pub(crate) use display::{CloudDisplay, CloudSource};
pub(crate) use pieces::max_points;
pub(crate) use points::NonFinite;
