//! What every CameraPub needs, whoever draws its picture: this package's node, or rviz with the plugin.
//!
//! ```text
//!   CameraInfo ──► optics: what to draw, and the lens behind it     deviations: where a projection will miss
//!   clock ───────► schedule (of changes), call_pacing (of calls): when a picture is due
//!   drawn ───────► lens, readback, depth_buffer: the picture that is published
//!   orientation ─► oriented_info: the CameraInfo of an image that is mirrored and turned
//!   times ───────► step_times, rolling_window: how long the last hundred pictures took
//! ```
//!
//! No messages, no topics, no windows and no drawing: plain numbers and bytes in and out. Pixels, lengths and frames
//! are those of [`rcs_scene`] and [`rcs_calibration`].
#![forbid(unsafe_code)]

mod call_pacing;
mod depth_buffer;
mod deviations;
mod info;
mod lens;
mod lens_of;
mod optics;
mod oriented_info;
mod picture_rate;
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
pub use info::CameraInfoFields;
pub use lens::{see_depth_through, see_through, write_depth_through, write_through};
pub use lens_of::{lens_of, LensProblem};
pub use optics::{optics, CameraModel, Optics, Projection};
pub use oriented_info::{OrientedInfo, QuarterTurns};
pub use picture_rate::PictureRate;
pub use rate_limit::RateLimit;
pub use readback::{Readback, ReadbackProblem};
pub use rolling_window::{figure, Percentiles, RollingWindow};
pub use schedule::Schedule;
pub use step_times::{StepTimes, PICTURES};
pub use through_lens::{is_distorted, rectification, DrawnThroughLens, Lenses, NoLens};
