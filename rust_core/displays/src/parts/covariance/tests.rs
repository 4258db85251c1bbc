//! Covariances by the solids that they become.

use nalgebra::{Matrix3, Point3};
use rcs_messages::geometry_msgs::PoseWithCovariance;

use super::*;

/// A pose in space without covariances between coordinates, at the origin.
fn message(variances: [f64; 6]) -> PoseWithCovariance {
    let mut message = PoseWithCovariance::default();
    message.pose.orientation.w = 1.0;
    for (i, variance) in variances.into_iter().enumerate() {
        message.covariance[7 * i] = variance;
    }
    message
}

fn drawn(settings: &CovarianceSettings, scales: &mut CovarianceScales, message: &PoseWithCovariance) -> Vec<Drawable> {
    let (pose, covariance) = uncertain_pose(message).expect("finite");
    CovarianceSymbol::new(0, settings).drawables(&Isometry3::identity(), &pose, &covariance, scales)
}

/// Extent of a unit solid along the fixed frame's axes, in metres.
fn extent(drawable: &Drawable) -> Vector3<f64> {
    let linear: Matrix3<f64> = drawable.fixed_from_object.fixed_view::<3, 3>(0, 0).into_owned();
    Vector3::from_fn(|row, _| linear.row(row).norm())
}

#[test]
fn the_ellipsoid_reaches_its_standard_deviations_and_discs_stand_on_their_axes() {
    let drawn = drawn(
        &CovarianceSettings::default(),
        &mut CovarianceScales::default(),
        &message([0.04, 0.01, 0.25, 0.0004, 0.0009, 0.0016]),
    );
    let [ellipsoid, roll, pitch, yaw] = drawn.as_slice() else { panic!("{} solids", drawn.len()) };
    assert!((extent(ellipsoid) - Vector3::new(0.4, 0.2, 1.0)).norm() < 1e-6);
    // The tip of x sways along y under yaw and along z under pitch, and that of y likewise; but rviz draws the disc of
    // z with roll along x and pitch along y, where its tip would sway the other way round.
    let sway = |deviation_rad: f64| 2.0 * deviation_rad.tan();
    for (disc, at, size) in [
        (roll, Vector3::x(), [FLAT_M, sway(0.04), sway(0.03)]),
        (pitch, Vector3::y(), [sway(0.04), FLAT_M, sway(0.02)]),
        (yaw, Vector3::z(), [sway(0.02), sway(0.03), FLAT_M]),
    ] {
        assert!((disc.sort_point - Point3::from(at)).norm() < 1e-9);
        assert!((extent(disc) - Vector3::from(size)).norm() < 1e-6, "{at}: {}", extent(disc));
    }
}

#[test]
fn a_pose_in_the_plane_has_an_ellipse_and_a_cone() {
    let drawn = drawn(
        &CovarianceSettings::default(),
        &mut CovarianceScales::default(),
        &message([0.04, 0.01, 0.0, 0.0, 0.0, 0.01]),
    );
    let [ellipse, cone] = drawn.as_slice() else { panic!("{} solids", drawn.len()) };
    assert!((extent(ellipse) - Vector3::new(0.4, 0.2, FLAT_M)).norm() < 1e-6);
    assert!((extent(cone) - Vector3::new(1.0, 2.0 * 0.1_f64.tan(), FLAT_M)).norm() < 1e-6);
    let tip = cone.fixed_from_object.transform_point(&Point3::new(0.0, 0.5, 0.0));
    assert!(tip.coords.norm() < 0.01, "{tip}");
}

#[test]
fn a_negative_variance_keeps_the_sizes_of_the_covariance_before_it() {
    let settings = CovarianceSettings::default();
    let mut scales = CovarianceScales::default();
    let good = message([0.04, 0.04, 0.04, 0.01, 0.01, 0.01]);
    let bad = message([-0.5, 0.09, 0.09, -0.01, 0.01, 0.01]);
    let first = drawn(&settings, &mut CovarianceScales::default(), &bad);
    assert!((extent(&first[0]) - Vector3::repeat(1.0)).norm() < 1e-6, "the first ellipsoid has 1 m");
    // Of the discs only roll's does without the negative variance.
    assert_eq!(first.len(), 2);
    drawn(&settings, &mut scales, &good);
    let kept = drawn(&settings, &mut scales, &bad);
    assert_eq!(kept.len(), 4);
    assert!((extent(&kept[0]) - Vector3::repeat(0.4)).norm() < 1e-6);
}

#[test]
fn what_is_switched_off_or_too_large_for_single_precision_is_not_drawn() {
    let good = message([0.04, 0.04, 0.04, 0.01, 0.01, 0.01]);
    let hidden = CovarianceSettings { position: None, orientation: None };
    assert_eq!(drawn(&hidden, &mut CovarianceScales::default(), &good).len(), 0);
    for i in 0..6 {
        let mut variances = [1.0; 6];
        for (variance, is_drawn) in [(3.4e38, true), (3.5e38, false), (f64::MAX, false), (f64::INFINITY, false)] {
            variances[i] = variance;
            assert_eq!(uncertain_pose(&message(variances)).is_some(), is_drawn, "{variances:?}");
        }
    }
}
