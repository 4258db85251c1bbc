//! Projection errors of an image that is drawn as rviz does.
//!
//! rviz uses one focal length and its own sign of `P[7]`, mirrors nothing, leaves out skews and P's third row, and does
//! not undo the distortion of D; nor does this program unless it is asked to. On a screen that hardly matters; a
//! projection misses its objects.

use rcs_calibration::Distortion;
use rcs_scene::Intrinsics;

use crate::{is_distorted, CameraInfoFields, CameraModel, NoLens, Projection};

/// Advice on the settings that correct a deviation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Advice {
    /// How to draw by P exactly; empty where there is no such setting.
    pub exact: &'static str,
    /// How to undo the distortion.
    pub undistort: &'static str,
}

/// One phrase for each deviation, with its size; `no_lens` is the reason why the distortion could not be undone, if
/// that was tried.
pub fn deviations(
    info: &CameraInfoFields<'_>,
    model: CameraModel,
    no_lens: Option<NoLens>,
    advice: Advice,
) -> Vec<String> {
    let Ok(intrinsics) = Intrinsics::from_p(info.width_px, info.height_px, info.p) else { return Vec::new() };
    let mut phrases = Vec::new();
    let is_through_lens = model.undistort && is_distorted(info) && no_lens.is_none();
    if model.projection == Projection::Rviz && !is_through_lens {
        phrases.extend(of_rviz(info, &intrinsics).into_iter().map(|phrase| phrase + &after_semicolon(advice.exact)));
    }
    if !is_through_lens {
        phrases.extend(distortion(info, &intrinsics, no_lens, advice));
    }
    phrases.extend(not_applied(info));
    phrases
}

/// Deviations of rviz's projection from P by more than half a pixel.
fn of_rviz(info: &CameraInfoFields<'_>, intrinsics: &Intrinsics) -> Vec<String> {
    let [.., below_x, below_y, scale, below_w] = *info.p;
    let row = [below_x, below_y, scale, below_w];
    let third_row = (row != [0.0, 0.0, 1.0, 0.0])
        .then(|| format!("the third row of P is {row:?}, and rviz draws as if it were [0.0, 0.0, 1.0, 0.0]"));
    let ty = intrinsics.ty;
    let offset = (ty != 0.0).then(|| {
        let px = 2.0 * ty.abs();
        format!(
            "P[7] is {ty}, and rviz moves the camera to the other side: what is 1 m away is {px:.1} px too high or too \
             low"
        )
    });
    let phrases = [third_row, mirror(intrinsics), focal_lengths(intrinsics)];
    phrases.into_iter().flatten().chain(skews(intrinsics)).chain(offset).collect()
}

/// A mirror, which rviz leaves out.
fn mirror(intrinsics: &Intrinsics) -> Option<String> {
    let Intrinsics { fx_px, fy_px, .. } = *intrinsics;
    (fx_px * fy_px < 0.0).then(|| {
        format!("P[0] is {fx_px} and P[5] is {fy_px}, which is a mirrored picture, and rviz draws one that is not")
    })
}

/// Skews, which rviz leaves out.
fn skews(intrinsics: &Intrinsics) -> impl Iterator<Item = String> {
    let Intrinsics { fx_px, fy_px, skew_px, cx_px, cy_px, width_px, height_px, .. } = *intrinsics;
    let farthest = |center_px: f64, side_px: u32| center_px.abs().max((f64::from(side_px) - center_px).abs());
    let by_y = ("P[1]", skew_px[0], farthest(cy_px, height_px) / fy_px);
    let by_x = ("P[4]", skew_px[1], farthest(cx_px, width_px) / fx_px);
    [by_y, by_x].into_iter().filter(|(_, skew_px, _)| *skew_px != 0.0).map(|(field, skew_px, farthest)| {
        let px = (skew_px * farthest).abs();
        format!("{field} is {skew_px} (a skew), which rviz leaves out: up to {px:.1} px at the edges")
    })
}

/// The CameraInfo's binning and region of interest, which are not applied.
fn not_applied(info: &CameraInfoFields<'_>) -> Option<String> {
    let CameraInfoFields { width_px, height_px, binning: [x, y], region_px: [left, top, width, height], .. } = *info;
    let binning = info.is_binned().then(|| format!("binning {x}x{y}"));
    let region = info.is_cropped().then(|| format!("the region of interest {width}x{height} at ({left}, {top})"));
    let parts: Vec<_> = [binning, region].into_iter().flatten().collect();
    (!parts.is_empty()).then(|| {
        let parts = parts.join(" and ");
        format!("{parts} not applied: the picture and its CameraInfo are the whole {width_px}x{height_px}")
    })
}

/// `; ADVICE`, or nothing without advice.
fn after_semicolon(advice: &str) -> String {
    if advice.is_empty() {
        String::new()
    } else {
        format!("; {advice}")
    }
}

fn focal_lengths(intrinsics: &Intrinsics) -> Option<String> {
    let Intrinsics { fx_px, fy_px, width_px, height_px, .. } = *intrinsics;
    let zoom = (fx_px / fy_px).abs().min((fy_px / fx_px).abs());
    if (1.0 - zoom).abs() < 1e-6 {
        return None;
    }
    let (axis, side_px) = if fy_px.abs() > fx_px.abs() { ("height", height_px) } else { ("width", width_px) };
    let percent = 100.0 * (1.0 - zoom);
    let edge_px = (1.0 - zoom) * f64::from(side_px) / 2.0;
    Some(format!(
        "fx {fx_px} and fy {fy_px} differ by {percent:.2} %, and rviz draws with the shorter: in {axis}, the picture is \
         {percent:.2} % too small, {edge_px:.1} px at its edges"
    ))
}

/// Lens distortion, which is not in the image.
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

/// Largest shift by the distortion among the image's corners, middles of its edges, and centre. `None` for an unknown
/// model or a point that it cannot distort.
fn largest_shift_px(info: &CameraInfoFields<'_>, intrinsics: &Intrinsics) -> Option<f64> {
    // By what P means, where it means something; that counts from pixels' edges.
    let exact = Intrinsics::exactly(info.width_px, info.height_px, info.p).ok();
    let intrinsics = exact.map_or(*intrinsics, |(intrinsics, _)| intrinsics);
    let distortion = Distortion::from_message(info.distortion_model, info.d).ok()?;
    let mut largest_px = 0.0_f64;
    for column in [0.0, 0.5, 1.0] {
        for row in [0.0, 0.5, 1.0] {
            let from = [column * f64::from(info.width_px) + 0.5, row * f64::from(info.height_px) + 0.5];
            let to = intrinsics.place(distortion.distort(intrinsics.plane(from).into())?.into());
            largest_px = largest_px.max((to[0] - from[0]).hypot(to[1] - from[1]));
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
        deviations(
            &CameraInfoFields { distortion_model: model, d, ..ideal(&none, &p) },
            projection.into(),
            None,
            ADVICE,
        )
    }

    fn ideal<'a>(none: &'a [f64; 9], p: &'a [f64; 12]) -> CameraInfoFields<'a> {
        CameraInfoFields {
            width_px: 1000,
            height_px: 800,
            distortion_model: "",
            d: &[],
            k: none,
            r: none,
            p,
            binning: [0; 2],
            region_px: [0; 4],
        }
    }

    /// The deviations of a camera where these numbers of P are others.
    fn with_p(changes: &[(usize, f64)], projection: Projection) -> Vec<String> {
        let (none, mut p) = ([0.0; 9], [1000.0, 0.0, 500.0, 0.0, 0.0, 1000.0, 400.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        changes.iter().for_each(|(i, value)| p[*i] = *value);
        deviations(&ideal(&none, &p), projection.into(), None, ADVICE)
    }

    #[test]
    fn what_rviz_leaves_out_of_p_is_told_with_its_size() {
        for (changes, expected) in [
            (&[(1, 50.0)][..], "P[1] is 50 (a skew), which rviz leaves out: up to 20.0 px at the edges; follow P"),
            (&[(4, -50.0)], "P[4] is -50 (a skew), which rviz leaves out: up to 25.0 px at the edges; follow P"),
            (&[(10, 2.0)], "the third row of P is [0.0, 0.0, 2.0, 0.0], and rviz draws as if"),
            (&[(0, -1000.0)], "P[0] is -1000 and P[5] is 1000, which is a mirrored picture, and rviz draws one"),
            (&[(5, -1000.0)], "P[0] is 1000 and P[5] is -1000, which is a mirrored picture"),
        ] {
            let found = with_p(changes, Projection::Rviz);
            assert!(found.len() == 1 && found[0].starts_with(expected), "{found:?}");
            assert_eq!(with_p(changes, Projection::Exact), [""; 0]);
        }
        assert_eq!(with_p(&[(0, -1000.0), (5, -1000.0)], Projection::Rviz), [""; 0], "turned by half, as P says");
    }

    #[test]
    fn binning_and_a_region_of_interest_are_told_unless_they_are_the_whole_image() {
        let (none, p) = ([0.0; 9], [1000.0, 0.0, 500.0, 0.0, 0.0, 1000.0, 400.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        let of = |binning, region_px| {
            let info = CameraInfoFields { binning, region_px, ..ideal(&none, &p) };
            deviations(&info, Projection::Exact.into(), None, ADVICE).join("|")
        };
        assert_eq!(of([1, 0], [0, 0, 1000, 800]), "");
        assert_eq!(
            of([4, 4], [100, 0, 300, 200]),
            "binning 4x4 and the region of interest 300x200 at (100, 0) not applied: the picture and its CameraInfo are \
             the whole 1000x800"
        );
        assert!(of([1, 2], [0; 4]).starts_with("binning 1x2 not applied"));
        assert!(of([0; 2], [0, 0, 1000, 400]).starts_with("the region of interest 1000x400 at (0, 0) not applied"));
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
