//! The frame tree over time, with tf2's semantics.
//!
//! Robots publish the pose of a child frame in its parent frame, again and again (`/tf`) or once and for all
//! (`/tf_static`). [`TransformTree`] remembers ten seconds of each moving frame and looks up the pose of one frame in
//! another at a time, interpolating between the samples and never extrapolating unless a [`Prediction`] is asked for.
//! [`WaitingQueue`] holds messages whose frame cannot be placed yet, as tf2_ros' message filter does for rviz's
//! displays.
//!
//! Nothing here has a clock, a thread or a connection: the caller brings transforms, messages and times.
//!
//! ```
//! use rcs_transforms::{RawTransform, Time, TransformTree};
//!
//! let mut tree = TransformTree::new();
//! for (secs, x) in [(10, 1.0), (11, 3.0)] {
//!     let transform = RawTransform {
//!         parent: "map",
//!         child: "base_link",
//!         stamp: Time::from_secs_nanos(secs, 0),
//!         translation: [x, 0.0, 0.0],
//!         rotation_xyzw: [0.0, 0.0, 0.0, 1.0],
//!     };
//!     tree.insert(&transform, false, "/localization")?;
//! }
//! let map_from_base = tree.lookup("map", "base_link", Time::from_secs_nanos(10, 500_000_000))?;
//! assert_eq!(map_from_base.translation.x, 2.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod frames;
mod history;
mod lookup;
mod motion;
mod prediction;
mod sample;
mod time;
mod transform;
mod tree;
mod waiting;

pub use frames::MOST_FRAMES;
pub use lookup::{LookupError, LookupProblem};
pub use prediction::Prediction;
pub use sample::interpolate;
pub use time::Time;
pub use transform::{InsertError, InsertProblem, RawTransform};
pub use tree::{Inserted, TransformTree};
pub use waiting::{DropCounts, DropReason, Dropped, WaitingQueue};
