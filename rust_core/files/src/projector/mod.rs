//! A projector's YAML file: its CameraInfo, lens distortion included, and its static frames.
//!
//! Two forms are read, each with the keys that its own tools write. The plain message, as `rostopic echo` prints it and
//! `rostopic pub -f` takes it:
//!
//! ```yaml
//! header: {frame_id: proj_view}      # seq and stamp are not used: the stamp is the time of publishing
//! height: 800
//! width: 1280
//! distortion_model: plumb_bob
//! D: [0, 0, 0, 0, 0]
//! K: [1900, 0, 640, 0, 1900, 817, 0, 0, 1]
//! R: [1, 0, 0, 0, 1, 0, 0, 0, 1]
//! P: [1900, 0, 640, 0, 0, 1900, 750, 0, 0, 0, 1, 0]
//! ```
//!
//! (ROS 2 prints d, k, r and p), and the file of `camera_calibration` and `camera_info_manager` (`image_width`,
//! `image_height`, `camera_matrix: {rows, cols, data}`, `distortion_coefficients`, `rectification_matrix`,
//! `projection_matrix`). Lists of numbers may be nested, row by row. What is missing is filled in: P from K, K from P,
//! R with the identity, D with zeros, `distortion_model` by `camera_model` (Melodic) or `fisheye_model` (OpenCV), else
//! with `plumb_bob`. Files of other calibrators are in [`other_tools`]. Three keys are this project's own, in any form:
//!
//! ```yaml
//! frame_id: proj_view                       # wins over header.frame_id
//! camera_info_topic: /proj_view/camera_info
//! frames:                                   # published on /tf_static
//!   - {parent: base_link, child: proj_link, translation: [0, 0, 0.1], rotation_rpy: [0, 0, 1.54]}
//!   - {parent: proj_link, child: proj_view, transform: "0.094 0.09 0.06 -1.57 0 -1.57"}
//!   - 0.094 0.09 0.06 -1.57 0 -1.57 proj_link proj_view 100
//! ```
//!
//! Lengths are metres, angles radians. `rotation_rpy` is roll, pitch and yaw about the parent's fixed x, y and z axes;
//! `rotation_xyzw` is a quaternion; `transform` and the plain text are `static_transform_publisher`'s arguments: x y z
//! yaw pitch roll, or x y z qx qy qz qw (the plain text with the frames behind, and a period that is not used).

mod camera_file;
pub(crate) mod checked_numbers;
mod distortion_name;
mod file;
pub(crate) mod frames;
mod in_place;
mod ini;
mod kalibr;
mod key_error;
mod lens;
mod matlab;
mod opencv_xml;
mod other_tools;
mod own_form;
mod raw_file;
mod shaped;
mod write;

pub use camera_file::write_camera;
pub use file::ProjectorFile;
pub use frames::{StaticFrame, TABLE_FRAME};
pub use in_place::{check_writable, file_before, restore_before, text_with_pose, write_frame, write_pose};
pub use lens::{fields_of, lens_of};
