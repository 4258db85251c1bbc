//! rviz's displays: settings, messages and transforms into scene primitives.
//!
//! One file for each display class. [`SceneState`] holds all displays of a config; it takes messages, updates the
//! displays, and hands out the [`rcs_scene::Scene`] that every camera looks at. Nothing here connects to
//! ROS, reads a clock or draws: the image is a function of the config, the messages and a time.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod classes;
mod framework;
mod parts;

pub use framework::arrivals::ShownMessage;
pub use framework::display::TopicRequest;
pub use framework::in_view::InView;
pub use framework::lookups::FollowedFrames;
pub use framework::report::{DisplayAge, DisplayReport, ListedDisplay};
pub use framework::scene_state::{CameraView, Reconfigured, SceneState};
pub use framework::status::{Level, Status, StatusCause, StatusText, Statuses};
pub use framework::world::{raw_transforms, time_from_stamp, World};
pub use parts::compressed_image::unpack_image;
pub(crate) use parts::shapes::SolidShape;
