//! Keys of a projector's file in its two forms.

use rcs_calibration::DistortionModel;
use rcs_messages::sensor_msgs::{CameraInfo, RegionOfInterest};
use rcs_messages::std_msgs::Header;
use serde::Deserialize;
use serde_yaml_ng::Value;

use super::checked_numbers::{Exactly, Matrix, Numbers, Size};
use super::distortion_name::distortion_model;
use super::frames::FrameEntry;
use super::key_error::KeyError;
use super::shaped::Shaped;

/// The keys of both forms side by side, so that each error has its line.
#[derive(Deserialize)]
pub(super) struct RawFile {
    header: Option<RawHeader>,
    height: Option<Size>,
    width: Option<Size>,
    distortion_model: Option<String>,
    camera_model: Option<String>,
    fisheye_model: Option<u64>,
    #[serde(rename = "D", alias = "d")]
    d: Option<Numbers>,
    #[serde(rename = "K", alias = "k")]
    k: Option<Matrix<9>>,
    #[serde(rename = "R", alias = "r")]
    r: Option<Matrix<9>>,
    #[serde(rename = "P", alias = "p")]
    p: Option<Matrix<12>>,
    #[serde(default)]
    binning_x: u32,
    #[serde(default)]
    binning_y: u32,
    #[serde(default)]
    roi: RawRegion,

    image_width: Option<Size>,
    image_height: Option<Size>,
    #[serde(rename = "camera_name")]
    _camera_name: Option<Value>,
    camera_matrix: Option<Shaped<Matrix<9>, Exactly<3>, Exactly<3>>>,
    distortion_coefficients: Option<Shaped<Numbers, Value, Value>>,
    rectification_matrix: Option<Shaped<Matrix<9>, Exactly<3>, Exactly<3>>>,
    projection_matrix: Option<Shaped<Matrix<12>, Exactly<3>, Exactly<4>>>,

    frame_id: Option<String>,
    pub(super) camera_info_topic: Option<String>,
    #[serde(default)]
    pub(super) frames: Vec<FrameEntry>,
}

#[derive(Deserialize)]
struct RawHeader {
    #[serde(rename = "seq")]
    _seq: Option<Value>,
    #[serde(rename = "stamp")]
    _stamp: Option<Value>,
    #[serde(default)]
    frame_id: String,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct RawRegion {
    x_offset: u32,
    y_offset: u32,
    height: u32,
    width: u32,
    do_rectify: bool,
}

/// The value of one of two keys with the same meaning.
fn either<T>(
    (message_key, message): (&'static str, Option<T>),
    (calibration_key, calibration): (&str, Option<T>),
) -> Result<Option<T>, KeyError> {
    match (message, calibration) {
        (Some(_), Some(_)) => Err((message_key, format!("the file has {calibration_key} too, which means the same"))),
        (message, calibration) => Ok(message.or(calibration)),
    }
}

impl RawFile {
    /// The message, or the invalid key and the reason.
    pub(super) fn camera_info(self) -> Result<CameraInfo, KeyError> {
        let data9 = |matrix: Option<Shaped<Matrix<9>, _, _>>| matrix.map(|matrix| matrix.data);
        let missing = |other: &str| format!("missing (or {other})");
        let width = either(("width", self.width), ("image_width", self.image_width))?
            .ok_or_else(|| ("width", missing("image_width")))?;
        let height = either(("height", self.height), ("image_height", self.image_height))?
            .ok_or_else(|| ("height", missing("image_height")))?;
        let k = either(("K", self.k), ("camera_matrix", data9(self.camera_matrix)))?;
        let r = either(("R", self.r), ("rectification_matrix", data9(self.rectification_matrix)))?;
        let projection = self.projection_matrix.map(|matrix| matrix.data);
        let p = either(("P", self.p), ("projection_matrix", projection))?;
        let coefficients = self.distortion_coefficients.map(|list| list.data);
        let d = either(("D", self.d), ("distortion_coefficients", coefficients))?;

        let (k, p) = match (k, p) {
            (Some(Matrix(k)), Some(Matrix(p))) => (k, p),
            (Some(Matrix(k)), None) => (k, p_from_k(k)),
            (None, Some(Matrix(p))) => (k_from_p(p), p),
            (None, None) => return Err(("P", "missing, and K too (or projection_matrix, camera_matrix)".to_owned())),
        };
        check_focal_lengths(&p)?;
        let model = distortion_model(self.distortion_model, self.camera_model.as_deref(), self.fisheye_model)?;
        let zeros = if model == DistortionModel::Equidistant.name() { 4 } else { 5 };
        let header_frame = self.header.map(|header| header.frame_id).unwrap_or_default();
        let RawRegion { x_offset, y_offset, height: roi_height, width: roi_width, do_rectify } = self.roi;
        Ok(CameraInfo {
            header: Header { frame_id: self.frame_id.unwrap_or(header_frame), ..Header::default() },
            height: height.0,
            width: width.0,
            distortion_model: model,
            D: d.map_or_else(|| vec![0.0; zeros], |Numbers(d)| d),
            K: k,
            R: r.map_or([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0], |Matrix(r)| r),
            P: p,
            binning_x: self.binning_x,
            binning_y: self.binning_y,
            roi: RegionOfInterest { x_offset, y_offset, height: roi_height, width: roi_width, do_rectify },
        })
    }
}

/// Checks that no focal length of P is zero.
pub(super) fn check_focal_lengths([fx, _, _, _, _, fy, ..]: &[f64; 12]) -> Result<(), KeyError> {
    if *fx == 0.0 || *fy == 0.0 {
        return Err(("P", format!("a focal length is zero (fx {fx}, fy {fy})")));
    }
    Ok(())
}

/// P of a camera that needs no rectification.
pub(super) fn p_from_k([fx, skew, cx, k10, fy, cy, k20, k21, k22]: [f64; 9]) -> [f64; 12] {
    [fx, skew, cx, 0.0, k10, fy, cy, 0.0, k20, k21, k22, 0.0]
}

/// The left three columns of P.
fn k_from_p([fx, skew, cx, _, p10, fy, cy, _, p20, p21, p22, _]: [f64; 12]) -> [f64; 9] {
    [fx, skew, cx, p10, fy, cy, p20, p21, p22]
}
