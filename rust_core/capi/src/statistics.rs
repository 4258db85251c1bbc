//! Durations of the last images.

use std::ffi::c_char;
use std::time::Duration;

use rcs_camera::{figure, RollingWindow, IMAGES};

use crate::camera::RcsCamera;
use crate::fault::{Fault, RcsResult};
use crate::guard;
use crate::pointers::required;
use crate::text::write_text;

/// Times at which the steps of one image ended: nanoseconds of the clock that is used with `rcs_camera_due`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct RcsTimes {
    /// Drawing began.
    pub begun_ns: u64,
    /// Drawing ended.
    pub drawn_ns: u64,
    /// The pixels were read back.
    pub read_ns: u64,
    /// The image was converted and published.
    pub published_ns: u64,
}

/// Records a published image. `RCS_RESULT_BAD_VALUE` if a step is before the one that precedes it.
#[no_mangle]
pub extern "C" fn rcs_camera_record(camera: Option<&mut RcsCamera>, times: Option<&RcsTimes>) -> RcsResult {
    guard::result(|| {
        let camera = required(camera, "camera")?;
        let RcsTimes { begun_ns, drawn_ns, read_ns, published_ns } = *required(times, "times")?;
        let step = |from: u64, to: u64| to.checked_sub(from).map(Duration::from_nanos);
        let steps = [step(begun_ns, drawn_ns), step(drawn_ns, read_ns), step(read_ns, published_ns)];
        let ([Some(draw), Some(read), Some(publish)], Some(whole)) = (steps, step(begun_ns, published_ns)) else {
            return Err(Fault::new(RcsResult::BadValue, "times: a step is before the one that precedes it"));
        };
        camera.steps.push([draw, read, publish], whole);
        camera.rate.push(Duration::from_nanos(published_ns));
        Ok(())
    })
}

/// Writes one line about the last hundred recorded images: their rate, and the median and the 95th percentile of each
/// step and of the whole in milliseconds. Empty before the first one. Buffer and returned length are as in
/// `rcs_last_error`.
///
/// # Safety
/// `buffer` has room for `length` bytes.
#[no_mangle]
pub unsafe extern "C" fn rcs_camera_statistics(
    camera: Option<&RcsCamera>,
    now_ns: u64,
    buffer: *mut c_char,
    length: usize,
) -> usize {
    guard::value(0, || {
        let line = line(required(camera, "camera")?, Duration::from_nanos(now_ns));
        // SAFETY: as the caller promises.
        unsafe { write_text(&line, buffer, length) }
    })
}

fn line(camera: &RcsCamera, now: Duration) -> String {
    let RcsCamera { steps, rate, .. } = camera;
    if steps.images() == 0 {
        return String::new();
    }
    let hz = figure(rate.hz(now).map(|hz| format!("{hz:.1}")));
    let ms = |window: &RollingWindow<IMAGES>| figure(window.percentiles());
    let [draw, read, publish] = steps.steps_ms().each_ref().map(ms);
    let (images, whole) = (steps.images(), ms(steps.whole_ms()));
    format!(
        "{hz} pictures/s; median / p95 ms of the last {images}: draw {draw}, read back {read}, publish {publish}, \
         whole {whole}"
    )
}
