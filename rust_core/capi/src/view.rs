//! A CameraInfo from C, and its view.

use std::ffi::c_char;

use nalgebra::Isometry3;
use rcs_camera::{CameraInfoFields, Optics};
use rcs_scene::{Camera, FAR_CLIP_M};

use crate::fault::{Fault, RcsResult};
use crate::pointers;

/// Most coefficients of a distortion, more than any model has.
const MAX_COEFFICIENTS: usize = 1024;

/// The fields of a `sensor_msgs/CameraInfo` that define the projection. The caller owns the memory behind its pointers,
/// which is not used after the call.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct RcsCameraInfo {
    /// Pixels in a row, 1 to 16384.
    pub width: u32,
    /// Rows, 1 to 16384.
    pub height: u32,
    /// The model of D, such as `"plumb_bob"`; ends with a NUL, not NULL.
    pub distortion_model: *const c_char,
    /// The coefficients D; may be NULL where `d_length` is 0.
    pub d: *const f64,
    /// Number of coefficients, 1024 at most.
    pub d_length: usize,
    /// K, 3×3 row by row, pixels.
    pub k: [f64; 9],
    /// R, 3×3 row by row; all 0: not set.
    pub r: [f64; 9],
    /// P, 3×4 row by row, pixels.
    pub p: [f64; 12],
    /// `binning_x`. Binning and region of interest are not applied, as `rcs_camera_warning` reports: publish the whole
    /// image's CameraInfo with it (these fields 0).
    pub binning_x: u32,
    /// `binning_y`.
    pub binning_y: u32,
    /// `roi.x_offset`.
    pub roi_x_offset: u32,
    /// `roi.y_offset`.
    pub roi_y_offset: u32,
    /// `roi.width`; 0 for the whole image.
    pub roi_width: u32,
    /// `roi.height`; 0 for the whole image.
    pub roi_height: u32,
}

/// Rule for the projection of P.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RcsProjection {
    /// As in rviz's CameraPub: one focal length for both axes, P[7] upwards.
    Rviz = 0,
    /// Exactly P, to the pixel.
    Exact,
}

/// The view to draw for a CameraInfo. For a mirrored image (negative focal lengths) the texture is drawn unmirrored:
/// `rcs_camera_encode` and `rcs_camera_encode_depth` flip it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RcsView {
    /// Width of the texture to draw, pixels, at most 16384: the image's, or another one for a lens.
    pub drawn_width: u32,
    /// Height of the texture, pixels.
    pub drawn_height: u32,
    /// Width of the published image, pixels: the CameraInfo's.
    pub image_width: u32,
    /// Height of the published image, pixels.
    pub image_height: u32,
    /// The projection of the texture, as OpenGL's, row by row: from the view frame (x right, y up, looking along -z,
    /// metres) to clip coordinates with depths from -w to w.
    pub clip_from_view: [f64; 16],
    /// The eye in the CameraInfo's optical frame (x right, y down, z forward), metres: not 0 where P has Tx or Ty.
    pub optical_from_eye: [f64; 3],
    /// Near clip distance along the optical axis, metres, clamped to the possible range.
    pub near_m: f64,
    /// Far clip distance, metres.
    pub far_m: f64,
}

/// Calls `with` with the fields of a CameraInfo.
///
/// # Safety
/// Its pointers are as [`RcsCameraInfo`] says.
pub(crate) unsafe fn with_fields<T>(
    info: &RcsCameraInfo,
    with: impl FnOnce(&CameraInfoFields<'_>) -> Result<T, Fault>,
) -> Result<T, Fault> {
    if info.d_length > MAX_COEFFICIENTS {
        let text = format_args!("info.d_length is {}, more than {MAX_COEFFICIENTS}", info.d_length).to_string();
        return Err(Fault::new(RcsResult::BadLength, text));
    }
    // SAFETY: as the caller promises.
    let model = unsafe { pointers::text(info.distortion_model, "info.distortion_model") }?;
    // SAFETY: as the caller promises.
    let d = unsafe { pointers::slice(info.d, info.d_length, "info.d") }?;
    let (width_px, height_px) = (info.width, info.height);
    with(&CameraInfoFields {
        width_px,
        height_px,
        distortion_model: &model,
        d,
        k: &info.k,
        r: &info.r,
        p: &info.p,
        binning: [info.binning_x, info.binning_y],
        region_px: [info.roi_x_offset, info.roi_y_offset, info.roi_width, info.roi_height],
    })
}

/// The view of a CameraInfo's optics and its image's size.
///
/// # Errors
/// Numbers that are infinite in the 32 bits of a graphics library.
pub(crate) fn view(optics: Optics, [image_width, image_height]: [u32; 2], near_clip_m: f64) -> Result<RcsView, Fault> {
    let camera = optics.camera(&Isometry3::identity(), near_clip_m);
    let (clip_from_view, optical_from_eye) = (row_by_row(&camera), camera.eye().coords.into());
    if clip_from_view.iter().chain(&optical_from_eye).any(|number| !(*number as f32).is_finite()) {
        return Err(Fault::new(RcsResult::BadCameraInfo, "P is too large to draw with"));
    }
    Ok(RcsView {
        drawn_width: camera.width_px(),
        drawn_height: camera.height_px(),
        image_width,
        image_height,
        clip_from_view,
        optical_from_eye,
        near_m: camera.near_m(),
        far_m: FAR_CLIP_M,
    })
}

fn row_by_row(camera: &Camera) -> [f64; 16] {
    let columns = camera.clip_from_view().transpose();
    let mut rows = [0.0; 16];
    rows.copy_from_slice(columns.as_slice());
    rows
}
