//! A path as arrows of one length, one behind the other.
//!
//! They are laid from the path's end, so that the last tip is the goal and arrows stay in place while a robot drives
//! and replans to the same goal. An arrow is the chord between two points of the path, its length apart along the path.

use nalgebra::{Isometry3, Point3, Translation3, Unit, UnitQuaternion, Vector3};

/// Most arrows of a path; those nearest to the goal are kept.
pub(crate) const MOST_ARROWS: usize = 10_000;
/// Minimum length of a path with a direction, metres.
const LEAST_LENGTH_M: f64 = 1e-6;

/// Size and spacing of arrows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ArrowLayout {
    /// From tail to tip along the path, metres.
    pub(crate) length_m: f64,
    /// From tip to tip along the path, metres.
    pub(crate) spacing_m: f64,
    /// Above the path, metres.
    pub(crate) height_m: f64,
}

/// An arrow; its x axis points from the tail, the origin, to the tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Arrow {
    /// Pose in the path's frame.
    pub(crate) pose: Isometry3<f64>,
    /// Metres.
    pub(crate) length_m: f64,
}

/// The arrows of a path from start to goal. A path of one point is one arrow that ends there, in the direction of the
/// last pose.
pub(crate) fn arrows(path: &[Isometry3<f64>], layout: &ArrowLayout) -> Vec<Arrow> {
    let Some(goal) = path.last() else { return Vec::new() };
    let lift = Vector3::z() * layout.height_m;
    let points: Vec<Point3<f64>> = path.iter().map(|pose| pose.translation.vector + lift).map(Point3::from).collect();
    let line = Polyline::of(&points);
    if line.length_m() < LEAST_LENGTH_M {
        let back = goal.rotation * Vector3::x() * layout.length_m;
        let tail = Translation3::from(goal.translation.vector + lift - back);
        return vec![Arrow { pose: Isometry3::from_parts(tail, goal.rotation), length_m: layout.length_m }];
    }
    let count = ((line.length_m() - layout.length_m) / layout.spacing_m + 1e-9).floor().max(0.0) as usize + 1;
    let laid = (0..count.min(MOST_ARROWS)).rev().filter_map(|from_goal| {
        let tip_m = line.length_m() - from_goal as f64 * layout.spacing_m;
        arrow(line.at((tip_m - layout.length_m).max(0.0)), line.at(tip_m))
    });
    laid.collect()
}

/// `None` for an arrow of no length, such as where a path doubles back.
fn arrow(tail: Point3<f64>, tip: Point3<f64>) -> Option<Arrow> {
    let (along, length_m) = Unit::try_new_and_get(tip - tail, LEAST_LENGTH_M)?;
    // Yaw, then pitch, without roll: an arrow on the floor stays flat.
    let yaw = along.y.atan2(along.x);
    let pitch = -along.z.atan2(along.x.hypot(along.y));
    let rotation = UnitQuaternion::from_euler_angles(0.0, pitch, yaw);
    Some(Arrow { pose: Isometry3::from_parts(tail.coords.into(), rotation), length_m })
}

/// A polyline.
struct Polyline<'a> {
    points: &'a [Point3<f64>],
    /// Distance of each point along the line, metres.
    distances_m: Vec<f64>,
}

impl<'a> Polyline<'a> {
    fn of(points: &'a [Point3<f64>]) -> Self {
        let mut length_m = 0.0;
        let mut distances_m = Vec::with_capacity(points.len());
        for (index, place) in points.iter().enumerate() {
            length_m += points.get(index.wrapping_sub(1)).map_or(0.0, |before| (place - before).norm());
            distances_m.push(length_m);
        }
        Self { points, distances_m }
    }

    fn length_m(&self) -> f64 {
        self.distances_m.last().copied().unwrap_or_default()
    }

    /// The point at a distance along the line, clamped to its end.
    fn at(&self, distance_m: f64) -> Point3<f64> {
        let after = self.distances_m.partition_point(|distance| *distance < distance_m);
        let last = self.points.len().saturating_sub(1);
        let (from, to) = (after.min(last).saturating_sub(1), after.min(last));
        let (Some(a), Some(b)) = (self.points.get(from), self.points.get(to)) else { return Point3::origin() };
        let (begin, end) = (self.distances_m[from], self.distances_m[to]);
        let share = if end > begin { ((distance_m - begin) / (end - begin)).clamp(0.0, 1.0) } else { 1.0 };
        a + (b - a) * share
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use proptest::prelude::*;

    use super::*;

    const LAYOUT: ArrowLayout = ArrowLayout { length_m: 0.3, spacing_m: 0.5, height_m: 0.0 };

    fn path(points: &[[f64; 3]]) -> Vec<Isometry3<f64>> {
        points.iter().map(|[x, y, z]| Isometry3::translation(*x, *y, *z)).collect()
    }

    fn tip(arrow: &Arrow) -> Point3<f64> {
        arrow.pose * Point3::new(arrow.length_m, 0.0, 0.0)
    }

    #[test]
    fn the_last_arrow_reaches_the_goal_and_the_others_stand_before_it() {
        let laid = arrows(&path(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]), &LAYOUT);
        let tips: Vec<[f64; 3]> = laid.iter().map(|arrow| tip(arrow).coords.data.0[0]).collect();
        let expected = [[0.5, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.5, 0.0], [1.0, 1.0, 0.0]];
        assert_eq!(laid.len(), 4, "{tips:?}");
        for (tip, expected) in tips.iter().zip(expected) {
            assert!((Vector3::from(*tip) - Vector3::from(expected)).norm() < 1e-9, "{tips:?}");
        }
        assert!((laid[3].pose.rotation.euler_angles().2 - FRAC_PI_2).abs() < 1e-9);
        assert!(laid.iter().all(|arrow| (arrow.length_m - 0.3).abs() < 1e-9), "{laid:?}");
    }

    #[test]
    fn arrows_stay_where_they_are_when_only_the_beginning_of_the_path_changes() {
        let whole = arrows(&path(&[[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 2.0, 0.0]]), &LAYOUT);
        let driven = arrows(&path(&[[1.23, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 2.0, 0.0]]), &LAYOUT);
        for (a, b) in whole.iter().rev().zip(driven.iter().rev()) {
            assert!((tip(a) - tip(b)).norm() < 1e-9);
        }
    }

    #[test]
    fn short_paths_have_one_arrow_and_empty_ones_none() {
        assert!(arrows(&[], &LAYOUT).is_empty());
        let short = arrows(&path(&[[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]]), &LAYOUT);
        assert!(matches!(short[..], [arrow] if (arrow.length_m - 0.1).abs() < 1e-9), "{short:?}");
        let turned = UnitQuaternion::from_euler_angles(0.0, 0.0, FRAC_PI_2);
        let there = Isometry3::from_parts(Translation3::new(1.0, 2.0, 0.0), turned);
        let raised = ArrowLayout { height_m: 0.02, ..LAYOUT };
        let one = arrows(&[there, there], &raised);
        assert!(matches!(&one[..], [arrow] if (tip(arrow) - Point3::new(1.0, 2.0, 0.02)).norm() < 1e-9), "{one:?}");
    }

    #[test]
    fn an_endless_path_keeps_the_arrows_at_its_goal() {
        let laid = arrows(&path(&[[0.0, 0.0, 0.0], [1e6, 0.0, 0.0]]), &LAYOUT);
        assert_eq!(laid.len(), MOST_ARROWS);
        assert!((tip(&laid[MOST_ARROWS - 1]).x - 1e6).abs() < 1e-6);
    }

    proptest! {
        #[test]
        fn every_arrow_begins_and_ends_on_the_path(
            points in proptest::collection::vec([-3.0..3.0, -3.0..3.0, -0.1..0.1], 2..30),
            length_m in 0.05..1.0,
            spacing_m in 0.05..2.0,
        ) {
            let poses = path(&points);
            let laid = arrows(&poses, &ArrowLayout { length_m, spacing_m, height_m: 0.0 });
            let goal = Point3::from(poses[poses.len() - 1].translation.vector);
            prop_assert!((tip(laid.last().unwrap()) - goal).norm() < 1e-6);
            for arrow in &laid {
                prop_assert!(arrow.length_m <= length_m + 1e-9);
                for place in [arrow.pose * Point3::origin(), tip(arrow)] {
                    let off = poses.windows(2).map(|ends| off_piece(place, ends[0], ends[1])).fold(f64::MAX, f64::min);
                    prop_assert!(off < 1e-6, "{place} is {off} m off the path");
                }
            }
        }
    }

    /// How far a place is from the straight piece between two poses.
    fn off_piece(place: Point3<f64>, a: Isometry3<f64>, b: Isometry3<f64>) -> f64 {
        let (a, b) = (a.translation.vector, b.translation.vector);
        let along = b - a;
        let share = ((place.coords - a).dot(&along) / along.norm_squared().max(1e-12)).clamp(0.0, 1.0);
        (place.coords - a - along * share).norm()
    }
}
