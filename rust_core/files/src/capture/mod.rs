//! A capture folder: a camera's images of a projector's patterns, and what decoding needs.
//!
//! `capture.yaml` names everything else, relative to the folder:
//!
//! ```yaml
//! projector: {width: 1280, height: 800}
//! patterns:
//!   - {file: c000.png, kind: white}
//!   - {file: c001.png, kind: black}
//!   - {file: c002.png, kind: gray_code, axis: x, bits: 11, bit: 0, step: 1, offset: 0, inverted: false}
//! camera_info: camera_info.yaml    # a CameraInfo, see `projector`; its size is that of all images
//! camera_calibrated: true          # optional; false: only its size is right, solve --board finds the lens
//! depth: depth.png                 # optional: 16 bit, registered to the images; 0 is no depth
//! depth_scale_m: 0.0001            # metres of the depth 1; this is what is taken if the key is missing
//! frames:                          # optional: TF during the scan, from the camera up to the root
//!   - {parent: head_pan_link, child: head_tilt_link, translation: [0.14, 0, 0.06], rotation_xyzw: [0, 0, 0, 1],
//!      motion: revolute, joint: head_tilt_joint}
//! robot_description: robot.urdf    # optional
//! ```
//!
//! `motion` is the type of the URDF's joint; for frames that the URDF does not have, `fixed` on /tf_static and `moving`
//! on /tf.
//!
//! Images are PNGs of 8 bits, grey or in colours, of which the luma of ITU-R BT.601 counts (0.299 red, 0.587 green,
//! 0.114 blue), as in cv_bridge. [`rcs_calibration::patterns::Stripes`] defines the stripes. Names may lead into
//! subfolders, never out of the folder, links included.
//!
//! [`PatternList`] is the same list without a camera, as `patterns.yaml` beside the images to be shown.

mod error;
mod file_name;
mod folder;
mod images;
mod limits;
mod pattern_entry;
mod pattern_list;
mod robot;
mod write;
mod yaml_file;

pub use error::CaptureError;
pub use folder::{Capture, PatternImage, CAPTURE_FILE, DEPTH_SCALE_M};
pub use images::read_depth;
pub use limits::{MOST_BYTES, MOST_PATTERNS, MOST_PIXELS};
pub use pattern_list::{parse_patterns, read_patterns, write_patterns, PatternList, PATTERNS_FILE};
pub use robot::{CapturedFrame, CapturedRobot, FrameMotion};

#[cfg(test)]
mod tests;
