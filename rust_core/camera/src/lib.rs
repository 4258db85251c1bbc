//! Parts of a CameraPub that this package's node and rviz with the plugin share.
//!
//! ```text
//!   CameraInfo ──► optics: intrinsics to draw with, and the lens    deviations: errors of a projection
//!   clock ───────► schedule (of changes), call_pacing (of calls): when an image is due
//!   drawn ───────► lens, readback, depth_buffer: the published image
//!   orientation ─► oriented_info: the CameraInfo of an image that is mirrored and turned
//!   times ───────► step_times, rolling_window, image_rate: statistics of the last hundred images
//! ```
//!
//! No messages, no topics, no windows and no drawing: plain numbers and bytes in and out. Pixels, lengths and frames
//! are those of [`rcs_scene`] and [`rcs_calibration`].
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod call_pacing;
mod depth_buffer;
mod deviations;
mod image_rate;
mod info;
mod lens;
mod optics;
mod oriented_info;
mod rate_limit;
mod readback;
mod rolling_window;
mod schedule;
pub mod simd_levels;
mod step_times;
mod through_lens;

pub use call_pacing::CallPacing;
pub use depth_buffer::metres_of_depth_buffer;
pub use deviations::{deviations, Advice};
pub use image_rate::ImageRate;
pub use info::{lens_of, CameraInfoFields, LensProblem};
pub use lens::{see_depth_through, see_through, write_depth_through, write_through};
pub use optics::{optics, CameraModel, Optics, Projection};
pub use oriented_info::{OrientedInfo, QuarterTurns};
pub use rate_limit::RateLimit;
pub use readback::{Readback, ReadbackProblem};
pub use rolling_window::{figure, Percentiles, RollingWindow};
pub use schedule::Schedule;
pub use step_times::{StepTimes, IMAGES};
pub use through_lens::{is_distorted, rectification, DrawnThroughLens, Lenses, NoLens};
