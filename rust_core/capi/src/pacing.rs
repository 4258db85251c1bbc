//! Pacing of images.
//!
//! Times are nanoseconds of any clock that never goes back, the same for all calls of a camera.

use std::time::Duration;

use crate::camera::RcsCamera;
use crate::guard;
use crate::numbers::Flag;

/// Sets the rate of images, per second. Below 0: an image is due at each call of `rcs_camera_due`, once per frame of
/// rviz's window. 0, or NaN: only when triggered. Above 0: at that rate on average, or at each call if there are fewer
/// calls. NULL is allowed.
#[no_mangle]
pub extern "C" fn rcs_camera_set_frame_rate(camera: Option<&mut RcsCamera>, frame_rate_hz: f32) {
    guard::with(camera, (), |camera| camera.pacing.set_frame_rate(frame_rate_hz));
}

/// Makes one image due, at any frame rate and also without subscribers, from the next call of `rcs_camera_due` until
/// `rcs_camera_begin`. NULL is allowed.
#[no_mangle]
pub extern "C" fn rcs_camera_trigger(camera: Option<&mut RcsCamera>) {
    guard::with(camera, (), |camera| camera.pacing.trigger());
}

/// Returns true if an image is due now. Call it exactly once per frame of the window. `watched`: the image has
/// subscribers; without, only a triggered one is due. After a pause an image is due at once, and no burst follows.
/// False for NULL.
#[no_mangle]
pub extern "C" fn rcs_camera_due(camera: Option<&mut RcsCamera>, now_ns: u64, watched: Flag) -> bool {
    guard::with(camera, false, |camera| camera.pacing.is_due(Duration::from_nanos(now_ns), watched.is_set()))
}

/// Records that an image is being drawn: resets the trigger, and schedules the next image. NULL is allowed.
#[no_mangle]
pub extern "C" fn rcs_camera_begin(camera: Option<&mut RcsCamera>, now_ns: u64) {
    guard::with(camera, (), |camera| camera.pacing.begin(Duration::from_nanos(now_ns)));
}
