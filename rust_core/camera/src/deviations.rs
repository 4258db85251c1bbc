//! Where a picture does not fit the world when it is projected, although it is the picture that rviz draws.
//!
//! rviz uses one focal length and its own sign of `P[7]`, and does not bend the picture for the lens that D describes;
//! nor does this program unless it is asked to. For a picture on a screen that hardly matters; a projection misses its
//! objects.

use nalgebra::Point2;
use rcs_calibration::Distortion;
use rcs_scene::Intrinsics;

use crate::{is_distorted, CameraInfoFields, CameraModel, NoLens, Projection};

/// What whoever draws says about its settings that mend a deviation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Advice {
    /// How to draw what P says; empty where there is no such setting.
    pub exact: &'static str,
    /// How to allow for the lens.
    pub undistort: &'static str,
}

/// One phrase for each deviation, with its size; `no_lens` is why the lens could not be allowed for, if that was tried.
pub fn deviations(
    info: &CameraInfoFields<'_>,
    model: CameraModel,
    no_lens: Option<NoLens>,
    advice: Advice,
) -> Vec<String> {
    let Ok(intrinsics) = Intrinsics::from_p(info.width_px, info.height_px, info.p) else { return Vec::new() };
    let mut phrases = Vec::new();
    let is_through_lens = model.undistort && is_distorted(info) && no_lens.is_none();
    if model.projection == Projection::Rviz && !is_through_lens && !intrinsics.rviz_is_exact() {
        phrases.extend(focal_lengths(&intrinsics, advice));
        if intrinsics.ty != 0.0 {
            phrases.push(format!(
                "P[7] is {}, and rviz moves the camera to the other side: what is 1 m away is {:.1} px too high or too \
                 low{}",
                intrinsics.ty,
                2.0 * intrinsics.ty.abs(),
                after_semicolon(advice.exact)
            ));
        }
    }
    if !is_through_lens {
        phrases.extend(distortion(info, &intrinsics, no_lens, advice));
    }
    phrases
}

/// The advice after what it is about; nothing where there is none.
fn after_semicolon(advice: &str) -> String {
    if advice.is_empty() {
        String::new()
    } else {
        format!("; {advice}")
    }
}

fn focal_lengths(intrinsics: &Intrinsics, advice: Advice) -> Option<String> {
    let Intrinsics { fx_px, fy_px, width_px, height_px, .. } = *intrinsics;
    let zoom = (fx_px / fy_px).min(fy_px / fx_px);
    if (1.0 - zoom).abs() < 1e-6 {
        return None;
    }
    let (axis, side_px) = if fy_px > fx_px { ("height", height_px) } else { ("width", width_px) };
    let percent = 100.0 * (1.0 - zoom);
    let edge_px = (1.0 - zoom) * f64::from(side_px) / 2.0;
    Some(format!(
        "fx {fx_px} and fy {fy_px} differ by {percent:.2} %, and rviz draws with the shorter: in {axis}, the picture is \
         {percent:.2} % too small, {edge_px:.1} px at its edges{}",
        after_semicolon(advice.exact)
    ))
}

/// Lens distortion, which is not in the picture.
fn distortion(
    info: &CameraInfoFields<'_>,
    intrinsics: &Intrinsics,
    no_lens: Option<NoLens>,
    advice: Advice,
) -> Option<String> {
    if !is_distorted(info) {
        return None;
    }
    let model = info.distortion_model;
    if let Some(problem) = no_lens {
        return Some(format!("D is not zero ({model}), and the picture is drawn without distortion: {problem}"));
    }
    let Some(moved_px) = largest_shift_px(info, intrinsics) else {
        return Some(format!(
            "D is not zero (distortion_model \"{model}\"), and the picture is drawn without distortion"
        ));
    };
    let percent = 100.0 * moved_px / f64::from(intrinsics.width_px);
    Some(format!(
        "D is not zero ({model}), and the picture is drawn without distortion: that lens moves pixels by up to \
         {moved_px:.1} px, {percent:.2} % of the width{}",
        after_semicolon(advice.undistort)
    ))
}

/// The farthest that the distortion moves one of the picture's corners, middles of its edges, or centre. `None` where
/// the model is not known, or moves a point to nowhere.
fn largest_shift_px(info: &CameraInfoFields<'_>, intrinsics: &Intrinsics) -> Option<f64> {
    let Intrinsics { width_px, height_px, fx_px, fy_px, cx_px, cy_px, .. } = *intrinsics;
    let distortion = Distortion::from_message(info.distortion_model, info.d).ok()?;
    let mut largest_px = 0.0_f64;
    for column in [0.0, 0.5, 1.0] {
        for row in [0.0, 0.5, 1.0] {
            let x = (column * f64::from(width_px) - cx_px) / fx_px;
            let y = (row * f64::from(height_px) - cy_px) / fy_px;
            let moved = distortion.distort(Point2::new(x, y))? - Point2::new(x, y);
            largest_px = largest_px.max((moved.x * fx_px).hypot(moved.y * fy_px));
        }
    }
    Some(largest_px)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ADVICE: Advice = Advice { exact: "follow P", undistort: "bend it" };

    /// The deviations of a camera with these focal lengths, P[7] and distortion.
    fn found(fx: f64, fy: f64, ty: f64, (model, d): (&str, &[f64]), projection: Projection) -> Vec<String> {
        let (none, p) = ([0.0; 9], [fx, 0.0, 500.0, 0.0, 0.0, fy, 400.0, ty, 0.0, 0.0, 1.0, 0.0]);
        let info =
            CameraInfoFields { width_px: 1000, height_px: 800, distortion_model: model, d, k: &none, r: &none, p: &p };
        deviations(&info, projection.into(), None, ADVICE)
    }

    #[test]
    fn an_ideal_projector_has_no_deviation() {
        for projection in [Projection::Rviz, Projection::Exact] {
            assert_eq!(found(1000.0, 1000.0, 0.0, ("plumb_bob", &[0.0; 5]), projection), [""; 0]);
            assert_eq!(found(1000.0, 1000.0, 0.0, ("", &[]), projection), [""; 0]);
        }
    }

    #[test]
    fn focal_lengths_and_offsets_matter_only_to_rvizs_projection() {
        let one = |fx, fy, ty| {
            assert_eq!(found(fx, fy, ty, ("", &[]), Projection::Exact), [""; 0]);
            let found = found(fx, fy, ty, ("", &[]), Projection::Rviz);
            assert_eq!(found.len(), 1, "{found:?}");
            found[0].clone()
        };
        let tall = one(950.0, 1000.0, 0.0);
        assert!(tall.contains("differ by 5.00 %") && tall.contains("in height") && tall.contains("20.0 px"), "{tall}");
        let wide = one(1000.0, 990.0, 0.0);
        assert!(wide.contains("in width, the picture is 1.00 % too small, 5.0 px"), "{wide}");
        assert!(one(1000.0, 1000.0, -3.5).contains("7.0 px too high or too low; follow P"));
    }

    #[test]
    fn distortion_is_measured_where_it_is_largest() {
        let phrase = |model: &str, d: &[f64]| {
            let found = found(1000.0, 1000.0, 0.0, (model, d), Projection::Exact);
            assert_eq!(found.len(), 1, "{found:?}");
            found[0].clone()
        };
        // At the corner, r² = 0.5² + 0.4² = 0.41: k1 moves it by 1000 px · k1 · r³.
        let expected = format!("up to {:.1} px, ", 1000.0 * 0.1 * 0.41_f64.powf(1.5));
        assert!(phrase("plumb_bob", &[0.1, 0.0, 0.0, 0.0, 0.0]).contains(&expected));
        assert!(phrase("rational_polynomial", &[0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]).contains(&expected));
        // p1 at the middle of an edge above or below: 3 p1 y², and more at a corner.
        assert!(phrase("plumb_bob", &[0.0, 0.0, 0.01, 0.0]).contains("D is not zero (plumb_bob)"));
        let fisheye = 1000.0 * (0.41_f64.sqrt() - 0.41_f64.sqrt().atan());
        assert!(phrase("equidistant", &[1e-12, 0.0, 0.0, 0.0]).contains(&format!("up to {fisheye:.1} px")));
        assert!(phrase("own_model", &[1.0]).contains("distortion_model \"own_model\""));
    }
}
