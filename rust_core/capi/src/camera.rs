//! One camera: its CameraInfo and view.

use std::ffi::c_char;
use std::mem::MaybeUninit;
use std::sync::Arc;

use rcs_camera::{
    deviations, is_distorted, optics, Advice, CallPacing, CameraModel, ImageRate, Lenses, NoLens, StepTimes,
};
use rcs_scene::{DepthImage, Flip, Image, PixelMap};

use crate::fault::{Fault, RcsResult};
use crate::guard;
use crate::numbers::{Flag, ProjectionNumber};
use crate::pointers::required;
use crate::text::write_text;
use crate::view::{view, with_fields, RcsCameraInfo, RcsView};

/// Names of the plugin's settings that correct a deviation.
const ADVICE: Advice =
    Advice { exact: "the property Projection: exact follows P", undistort: "the property Undistort allows for it" };

/// The lenses' key for this camera's CameraInfo, the only one.
const TOPIC: &str = "";

/// The camera of a CameraPub display. It holds no thread and no file, and is used by one thread at a time; different
/// cameras by different threads at once.
#[derive(Debug, Default)]
pub struct RcsCamera {
    lenses: Lenses,
    pub(crate) current: Option<Current>,
    warning: String,
    pub(crate) pacing: CallPacing,
    pub(crate) steps: StepTimes<3>,
    pub(crate) rate: ImageRate,
    /// Scratch buffer for the image before the lens.
    pub(crate) before_lens: Image,
    /// Scratch buffer for depths before the lens.
    pub(crate) depth_before_lens: DepthImage,
}

/// The view of the CameraInfo that was set.
#[derive(Debug)]
pub(crate) struct Current {
    pub(crate) view: RcsView,
    pub(crate) lens: Option<Arc<PixelMap>>,
    pub(crate) flip: Flip,
}

impl RcsCamera {
    pub(crate) fn current(&self) -> Result<&Current, Fault> {
        self.current.as_ref().ok_or_else(Fault::no_camera_info)
    }
}

/// A camera without a CameraInfo, for which an image is due at each call. The caller frees it with `rcs_camera_free`.
/// NULL only after a bug of this library.
#[no_mangle]
pub extern "C" fn rcs_camera_new() -> Option<Box<RcsCamera>> {
    guard::value(None, || Ok(Some(Box::default())))
}

/// Frees a camera; NULL is allowed. No pointer to it may be used afterwards.
#[no_mangle]
pub extern "C" fn rcs_camera_free(camera: Option<Box<RcsCamera>>) {
    guard::value((), || {
        drop(camera);
        Ok(())
    });
}

/// Sets the camera's CameraInfo: checks it as the node does, and writes the view to draw for it to `view`.
/// `undistort`: where D is not 0, or the lens is equidistant, the image is bent so that it is right after the lens of
/// K and D; the texture is larger then, and P is followed exactly at any `projection`. A lens that cannot be corrected
/// is no error: the image is drawn without it, and `rcs_camera_warning` has the reason. `near_clip_m`: metres,
/// clamped to 1e-6 to 99.9.
///
/// A lens takes up to some tenths of a second, once: the same CameraInfo again costs less than a microsecond.
///
/// `RCS_RESULT_BAD_CAMERA_INFO`: `rcs_last_error` names the field and its fault, such as "P[0] (a focal length) is 0".
/// After every failure except a NULL camera, the camera has no CameraInfo, as after `rcs_camera_clear_info`.
///
/// # Safety
/// What `info` points to is as `RcsCameraInfo` says.
#[no_mangle]
pub unsafe extern "C" fn rcs_camera_set_info(
    camera: Option<&mut RcsCamera>,
    info: Option<&RcsCameraInfo>,
    projection: ProjectionNumber,
    undistort: Flag,
    near_clip_m: f64,
    view: Option<&mut MaybeUninit<RcsView>>,
) -> RcsResult {
    guard::result(|| {
        let camera = required(camera, "camera")?;
        camera.clear_info();
        let (info, view) = (required(info, "info")?, required(view, "view")?);
        if !near_clip_m.is_finite() {
            return Err(Fault::new(RcsResult::BadValue, format_args!("near_clip_m is {near_clip_m}")));
        }
        let model = CameraModel { projection: projection.checked()?, undistort: undistort.is_set() };
        // SAFETY: as the caller promises.
        unsafe { camera.set_info(info, model, near_clip_m) }?;
        view.write(camera.current()?.view);
        Ok(())
    })
}

/// Forgets the CameraInfo: images cannot be encoded until the next one is set. NULL is allowed.
#[no_mangle]
pub extern "C" fn rcs_camera_clear_info(camera: Option<&mut RcsCamera>) {
    guard::with(camera, (), RcsCamera::clear_info);
}

/// Writes the reasons why a projection of the image misses its objects, as in the node's status Camera Info: with
/// rviz's projection fx ≠ fy, P[7] ≠ 0, skews, a mirror and a third row of P; D ≠ 0 without lens correction, each with
/// its size in pixels; why a lens could not be corrected; and binning and regions of interest, which are not applied.
/// Empty without reasons or CameraInfo. Buffer and returned length are as in `rcs_last_error`.
///
/// # Safety
/// `buffer` has room for `length` bytes.
#[no_mangle]
pub unsafe extern "C" fn rcs_camera_warning(camera: Option<&RcsCamera>, buffer: *mut c_char, length: usize) -> usize {
    guard::value(0, || {
        let camera = required(camera, "camera")?;
        // SAFETY: as the caller promises.
        unsafe { write_text(&camera.warning, buffer, length) }
    })
}

impl RcsCamera {
    fn clear_info(&mut self) {
        self.current = None;
        self.warning.clear();
    }

    /// # Safety
    /// The pointers of `info` are as it says.
    unsafe fn set_info(&mut self, info: &RcsCameraInfo, model: CameraModel, near_clip_m: f64) -> Result<(), Fault> {
        // SAFETY: as the caller promises.
        let (optics, warning) = unsafe {
            with_fields(info, |fields| {
                // Only lenses and mirrors are computed by several threads.
                let is_mirrored = fields.p[0] < 0.0 || fields.p[5] < 0.0;
                if is_mirrored || (model.undistort && is_distorted(fields)) {
                    rcs_process::name_threads();
                }
                let optics = optics(fields, TOPIC, model, &self.lenses);
                let optics = optics.map_err(|error| Fault::new(RcsResult::BadCameraInfo, error))?;
                let no_lens: Option<NoLens> = self.lenses.problem(TOPIC).filter(|_| model.undistort);
                Ok((optics, deviations(fields, model, no_lens, ADVICE).join("; ")))
            })
        }?;
        let (lens, flip) = (optics.lens.clone(), optics.flip);
        let image_size_px = lens.as_ref().map_or([info.width, info.height], |lens| lens.size_px());
        self.current = Some(Current { view: view(optics, image_size_px, near_clip_m)?, lens, flip });
        self.warning = warning;
        Ok(())
    }
}
