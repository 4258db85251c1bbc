//! The solver against forward kinematics, for units as they are built and for random ones.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use proptest::prelude::*;

use super::*;
use crate::Hinge;

/// The angle between beam and target by forward kinematics.
fn miss_by_kinematics(unit: &PanTilt, beam: &Beam, target: Point3<f64>, positions: [f64; 2]) -> f64 {
    let base_from_lens = unit.base_from_lens(positions);
    let towards = target - base_from_lens * beam.origin;
    towards.angle(&(base_from_lens * beam.direction.into_inner()))
}

/// A pan about z with a tilt about -y above it, and a lens 11 cm before that; x forward, z of the lens along the light.
fn usual_unit(travel: [Travel; 2]) -> PanTilt {
    let optical = UnitQuaternion::from_euler_angles(-FRAC_PI_2, 0.0, -FRAC_PI_2);
    PanTilt {
        hinges: [
            Hinge { axis: Vector3::z_axis(), travel: travel[0] },
            Hinge { axis: Vector3::y_axis(), travel: travel[1] },
        ],
        first_from_second: Translation3::new(0.0, 0.0, 0.06).into(),
        second_from_lens: Isometry3::from_parts(Translation3::new(0.11, 0.06, 0.05), optical),
    }
}

fn straight() -> Beam {
    Beam { origin: Point3::origin(), direction: Vector3::z_axis() }
}

const WIDE: [Travel; 2] = [Travel { lower: -2.6, upper: 2.6 }, Travel { lower: -1.5, upper: 1.5 }];

#[test]
fn a_usual_unit_aims_at_a_table() {
    let (unit, target) = (usual_unit(WIDE), Point3::new(0.8, -0.3, -0.6));
    let aim = unit.aim(&straight(), target, [0.0, 0.0]).unwrap();
    assert!(aim.meets() && aim.miss_rad < 1e-9, "{aim:?}");
    assert!(miss_by_kinematics(&unit, &straight(), target, aim.positions) < 1e-7);
    // Right of ahead, and down: the lens is left of the axis, so the pan turns a little more.
    assert!(aim.positions[0] < -0.3 && aim.positions[1] > 0.5, "{aim:?}");
}

#[test]
fn what_lies_behind_a_limit_is_missed_by_the_least_angle() {
    let narrow = [Travel { lower: -0.5, upper: 0.5 }, Travel { lower: -1.5, upper: 1.5 }];
    let (unit, target) = (usual_unit(narrow), Point3::new(0.0, 2.0, 0.0));
    let aim = unit.aim(&straight(), target, [0.0, 0.0]).unwrap();
    assert!(!aim.meets() && aim.miss_rad > 0.8, "{aim:?}");
    assert!((aim.positions[0] - 0.5).abs() < 1e-9, "{aim:?}");
    // Nothing within the limits is nearer, by trying all.
    for pan in 0..=100 {
        for tilt in 0..=300 {
            let positions = [-0.5 + f64::from(pan) * 0.01, -1.5 + f64::from(tilt) * 0.01];
            let miss = miss_by_kinematics(&unit, &straight(), target, positions);
            assert!(miss > aim.miss_rad - 1e-9, "{positions:?}: {miss} is less than {}", aim.miss_rad);
        }
    }
}

#[test]
fn what_is_missed_is_missed_within_the_limits_to_the_last_digit() {
    // The end of the grid of start positions lies 4e-16 beyond the upper limit.
    let pan = Travel { lower: -3.92139976983135, upper: -0.36475648440321606 };
    let unit = usual_unit([pan, Travel { lower: -1.5, upper: 0.1 }]);
    let aim = unit.aim(&straight(), Point3::new(2.0, 1.0, -1.5), [0.0, 0.0]).unwrap();
    assert_eq!(aim.positions, [pan.upper, 0.1]);
}

#[test]
fn a_continuous_pan_goes_the_shorter_way_and_keeps_its_turns() {
    let unit = usual_unit([Travel::ENDLESS, WIDE[1]]);
    let target = Point3::new(-1.0, -0.2, 0.1);
    let near = |present: f64| unit.aim(&straight(), target, [present, 0.0]).unwrap().positions[0];
    assert!((near(3.0) - 3.0).abs() < 1.0 && (near(-3.0) + 3.0).abs() < 1.0);
    assert!((near(100.0) - 100.0).abs() < PI + 0.1);
}

#[test]
fn a_target_at_the_lens_or_without_a_place_is_none() {
    let mut unit = usual_unit(WIDE);
    unit.first_from_second = Isometry3::identity();
    unit.second_from_lens.translation = Translation3::identity();
    assert_eq!(unit.aim(&straight(), Point3::origin(), [0.0, 0.0]), None);
    assert_eq!(unit.aim(&straight(), Point3::new(f64::NAN, 0.0, 0.0), [0.0, 0.0]), None);
}

fn vectors(most: f64) -> impl Strategy<Value = Vector3<f64>> {
    [-most..most, -most..most, -most..most].prop_map(Vector3::from)
}

fn axes() -> impl Strategy<Value = Unit<Vector3<f64>>> {
    vectors(1.0).prop_filter_map("too short for a direction", |vector| Unit::try_new(vector, 0.1))
}

fn poses() -> impl Strategy<Value = Isometry3<f64>> {
    (vectors(0.4), axes(), -PI..PI).prop_map(|(place, axis, angle)| {
        Isometry3::from_parts(place.into(), UnitQuaternion::from_axis_angle(&axis, angle))
    })
}

fn travels() -> impl Strategy<Value = Travel> {
    let limited = (-4.0..3.0, 0.2..5.0).prop_map(|(lower, span): (f64, f64)| Travel { lower, upper: lower + span });
    prop_oneof![4 => limited, 1 => Just(Travel::ENDLESS)]
}

/// Units whose second axis is tilted against the first, as any that is to aim about.
fn units() -> impl Strategy<Value = PanTilt> {
    let parts = (axes(), axes(), travels(), travels(), poses(), poses());
    parts.prop_map(|(first, second, a, b, first_from_second, second_from_lens)| PanTilt {
        hinges: [Hinge { axis: first, travel: a }, Hinge { axis: second, travel: b }],
        first_from_second,
        second_from_lens,
    })
}

/// A position within the limits; of an endless joint, within a few turns.
fn position(travel: Travel, share: f64) -> f64 {
    let (lower, upper) = (travel.lower.max(-10.0), travel.upper.min(10.0));
    lower + (upper - lower) * share
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    // Whatever a random unit lights from a random posture, it finds again, from a posture that is at least as near.
    #[test]
    fn what_some_posture_lights_is_met_by_the_nearest(
        unit in units(),
        direction in axes(),
        origin in vectors(0.05),
        distance_m in 0.3..5.0,
        shares in [0.0..1.0, 0.0..1.0],
        present_shares in [0.0..1.0, 0.0..1.0],
    ) {
        let beam = Beam { origin: origin.into(), direction };
        let travel = unit.hinges.map(|hinge| hinge.travel);
        let lit_from = [0, 1].map(|joint| position(travel[joint], shares[joint]));
        let target = unit.base_from_lens(lit_from) * (beam.origin + direction.into_inner() * distance_m);
        let present = [0, 1].map(|joint| position(travel[joint], present_shares[joint]));
        let aim = unit.aim(&beam, target, present).unwrap();
        prop_assert!(aim.meets(), "missed by {}", aim.miss_rad);
        prop_assert!(miss_by_kinematics(&unit, &beam, target, aim.positions) < 2.0 * HIT_RAD);
        prop_assert!(travel[0].contains(aim.positions[0]) && travel[1].contains(aim.positions[1]), "{aim:?}");
        let (found, known) = (distance(aim.positions, present), distance(lit_from, present));
        prop_assert!(found <= known + 1e-3, "{found} is farther than {known}: {:?}, not {lit_from:?}", aim.positions);
    }

    // Where nothing meets the target, no posture of a fine grid misses it by less.
    #[test]
    fn what_is_missed_is_missed_by_the_least(
        unit in units(),
        direction in axes(),
        target in vectors(2.0),
        present_shares in [0.0..1.0, 0.0..1.0],
    ) {
        let beam = Beam { origin: Point3::origin(), direction };
        let travel = unit.hinges.map(|hinge| hinge.travel);
        let present = [0, 1].map(|joint| position(travel[joint], present_shares[joint]));
        let aim = unit.aim(&beam, target.into(), present).unwrap();
        prop_assert!(travel[0].contains(aim.positions[0]) && travel[1].contains(aim.positions[1]), "{aim:?}");
        let by_kinematics = miss_by_kinematics(&unit, &beam, target.into(), aim.positions);
        prop_assert!((by_kinematics - aim.miss_rad).abs() < 1e-6, "{by_kinematics} {}", aim.miss_rad);
        for cell in 0..60 * 60 {
            let shares = [f64::from(cell / 60) / 59.0, f64::from(cell % 60) / 59.0];
            let tried = [0, 1].map(|joint| position(travel[joint], shares[joint]));
            let miss = miss_by_kinematics(&unit, &beam, target.into(), tried);
            prop_assert!(miss > aim.miss_rad - 1e-5, "{tried:?} misses by {miss}, {aim:?} is worse");
        }
    }

    #[test]
    fn derivatives_are_the_differences(unit in units(), direction in axes(), target in vectors(2.0), at in [-3.0..3.0, -3.0..3.0]) {
        let beam = Beam { origin: Point3::origin(), direction };
        let problem = Problem { unit: &unit, beam: &beam, target: target.into() };
        let there = unit.base_from_lens(at).translation.vector;
        prop_assume!((there - target).norm() > 0.05);
        let miss = problem.miss(at).unwrap();
        for joint in 0..2 {
            let moved = |by: f64| { let mut at = at; at[joint] += by; problem.miss(at).unwrap().vector };
            let difference = (moved(1e-6) - moved(-1e-6)) / 2e-6;
            prop_assert!((difference - miss.by_position.column(joint)).norm() < 1e-4 * (1.0 + difference.norm()));
        }
    }
}
