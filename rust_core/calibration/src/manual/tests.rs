//! Tests of the formulas, errors, warnings and the stated accuracy.

use proptest::prelude::*;

use super::*;
use crate::solve::random::SplitMix64;
use crate::Lens;

/// Errorless measurements with the wall at a distance from the light's origin, measured from `behind_m` before it.
fn wall(lens: &Lens, from_light_m: f64, behind_m: f64) -> WallMeasures {
    let [width, height] = lens.size_px.map(f64::from);
    let on_wall = |px: f64, focal: f64| px / focal * from_light_m;
    WallMeasures {
        distance_m: from_light_m - behind_m,
        image_m: [on_wall(width, lens.focal_px.x), on_wall(height, lens.focal_px.y)],
        axis_m: Some([on_wall(lens.center_px.x, lens.focal_px.x), on_wall(lens.center_px.y, lens.focal_px.y)]),
    }
}

fn beamer() -> Lens {
    Lens::pinhole([1280, 800], [1900.0, 1900.0], [640.0, 817.0])
}

fn measures(first: WallMeasures, second: Option<WallMeasures>) -> ManualMeasures {
    ManualMeasures { size_px: [1280, 800], first, second, tape_error_m: 0.001 }
}

fn simple() -> WallMeasures {
    WallMeasures { distance_m: 1.25, image_m: [0.8, 0.5], axis_m: Some([0.41, 0.53]) }
}

#[test]
fn one_distance_is_the_papers_formulas() {
    let lens = solve(&measures(simple(), None)).unwrap().lens;
    assert_eq!(lens.focal_px.x, 1280.0 * 1.25 / 0.8);
    assert_eq!(lens.focal_px.y, 800.0 * 1.25 / 0.5);
    assert_eq!(lens.center_px.x, 1280.0 * 0.41 / 0.8);
    assert_eq!(lens.center_px.y, 800.0 * 0.53 / 0.5);
    assert_eq!(lens.distortion, crate::Distortion::NONE);
}

#[test]
fn a_good_measurement_has_no_warnings_and_a_center_below_the_image_stays_there() {
    let lens = beamer();
    for second in [None, Some(wall(&lens, 2.0, 0.03))] {
        let found = solve(&measures(wall(&lens, 1.0, 0.03), second)).unwrap();
        assert_eq!(found.warnings, [], "{second:?}");
        assert!((found.lens.center_px.y - 817.0).abs() < 1e-9);
    }
    let high = Lens { center_px: [640.0, 1500.0].into(), ..lens };
    let found = solve(&measures(wall(&high, 1.0, 0.0), None)).unwrap();
    assert_eq!((found.lens.center_px.y.round(), found.warnings), (1500.0, Vec::new()));
}

proptest! {
    #[test]
    fn two_distances_cancel_the_place_of_the_lens(
        focal in 600.0..4000.0, shape in 0.95..1.05, cx in 0.0..1280.0, cy in -400.0..1200.0,
        near in 0.5..1.5, further in 0.2..2.0, behind in -0.1..0.1, is_swapped in any::<bool>(),
    ) {
        let lens = Lens::pinhole([1280, 800], [focal, focal * shape], [cx, cy]);
        let mut walls = [wall(&lens, near, behind), wall(&lens, near + further, behind)];
        if is_swapped {
            walls.reverse();
        }
        let found = solve(&measures(walls[0], Some(walls[1]))).unwrap();
        prop_assert!((found.lens.focal_px - lens.focal_px).norm() < 1e-6);
        prop_assert!((found.lens.center_px - lens.center_px).norm() < 1e-6);
        for place in found.lens_place_m.unwrap() {
            prop_assert!((place - behind).abs() < 1e-9);
        }
        let is_about_focal = |warning: &ManualWarning| matches!(warning, ManualWarning::FocalLengthsDiffer(..));
        let is_different = focal_difference_is_large(shape);
        prop_assert!(found.warnings.iter().all(|warning| is_different && is_about_focal(warning)));
    }

    #[test]
    fn any_input_gives_finite_numbers_or_an_error(
        values in prop::array::uniform10(prop_oneof![any::<f64>(), -2.0..2.0]),
        size in prop::array::uniform2(0..3000_u32),
        parts in 0..8,
    ) {
        let [z1, w1, h1, x1, y1, z2, w2, h2, x2, y2] = values;
        let at = |distance_m, image_m, axis_m, has_axis: bool| {
            WallMeasures { distance_m, image_m, axis_m: has_axis.then_some(axis_m) }
        };
        let first = at(z1, [w1, h1], [x1, y1], parts & 1 == 0);
        let second = (parts & 2 == 0).then(|| at(z2, [w2, h2], [x2, y2], parts & 4 == 0));
        match solve(&ManualMeasures { size_px: size, first, second, tape_error_m: 0.001 }) {
            Ok(found) => {
                let lens = found.lens;
                prop_assert!(lens.focal_px.min() > 0.0 && lens.focal_px.iter().all(|f| f.is_finite()));
                prop_assert!(lens.center_px.iter().all(|c| c.is_finite()));
                found.warnings.iter().for_each(|warning| assert_eq!(warning.to_string().lines().count(), 1));
            }
            Err(error) => prop_assert_eq!(error.to_string().lines().count(), 1),
        }
    }
}

fn focal_difference_is_large(shape: f64) -> bool {
    (shape - 1.0).abs() > 0.019
}

#[test]
fn impossible_measurements_are_refused() {
    let near = simple();
    let far = WallMeasures { distance_m: 2.5, image_m: [1.6, 1.0], axis_m: Some([0.82, 1.06]) };
    type Change = fn(&mut ManualMeasures);
    let cases: [(Change, &str); 10] = [
        (|m| m.size_px[0] = 0, "0x800 pixels"),
        (|m| m.first.distance_m = 0.0, "the distance is 0 m"),
        (|m| m.first.distance_m = f64::NAN, "the distance is NaN"),
        (|m| m.first.image_m[1] = -0.5, "the picture's height is -0.5 m"),
        (|m| m.second.as_mut().unwrap().image_m[0] = f64::INFINITY, "width at the second distance is inf"),
        (|m| m.second.as_mut().unwrap().axis_m = Some([0.1, f64::NAN]), "Y at the second distance is NaN"),
        (|m| m.second.as_mut().unwrap().distance_m = 1.25, "both distances are 1.25 m"),
        (|m| m.second.as_mut().unwrap().image_m[0] = 0.8, "the width is 0.8 m at 2.5 m and 0.8 m at 1.25 m"),
        (|m| m.second.as_mut().unwrap().distance_m = 1.0, "the width is 0.8 m at 1.25 m and 1.6 m at 1 m"),
        (
            |m| {
                m.first.axis_m = None;
                m.second.as_mut().unwrap().axis_m = None;
            },
            "at no distance",
        ),
    ];
    for (change, expected) in cases {
        let mut measures = measures(near, Some(far));
        change(&mut measures);
        let error = solve(&measures).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    let tiny = WallMeasures { image_m: [1e-310, 0.5], ..near };
    assert!(matches!(solve(&measures(tiny, None)), Err(ManualError::Absurd { .. })));
}

#[test]
fn each_warning_has_its_cause() {
    let lens = beamer();
    let (near, far) = (wall(&lens, 1.0, 0.02), wall(&lens, 2.0, 0.02));
    type Change = fn(&mut WallMeasures, &mut WallMeasures);
    let cases: [(Change, bool, &str); 7] = [
        (|near, _| near.image_m[1] *= 1.03, false, "fx 1862.0 and fy 1807.8 differ by 3.0 %"),
        (|near, _| near.distance_m *= 1000.0, false, "are all lengths in metres?"),
        (|near, _| near.axis_m = Some([-0.1, 0.4]), false, "cx -190.0 is far outside of the picture (0 to 1280)"),
        (|near, _| near.axis_m = Some([0.3, 0.9]), false, "cy 1710.0 is far outside of the picture (0 to 800)"),
        (|_, far| far.image_m[1] += 0.02, true, "the picture is 1.600 times as wide as high at the first, 1.563"),
        (|_, far| far.axis_m = Some([0.7, 0.86]), true, "cx is 640.0 by the first, 665.0 by the second"),
        (|near, far| (near.distance_m, far.distance_m) = (0.7, 1.7), true, "from 300 mm behind the place"),
    ];
    for (change, has_second, expected) in cases {
        let (mut near, mut far) = (near, far);
        change(&mut near, &mut far);
        let found = solve(&measures(near, has_second.then_some(far))).unwrap();
        let lines: Vec<String> = found.warnings.iter().map(ToString::to_string).collect();
        assert!(lines.iter().any(|line| line.contains(expected)), "{expected}: {lines:?}");
    }
}

#[test]
fn the_stated_accuracy_is_that_of_simulated_tape_errors() {
    let lens = beamer();
    let (near, far) = (wall(&lens, 1.0, 0.0), wall(&lens, 2.0, 0.0));
    for second in [None, Some(far)] {
        let exact = measures(near, second);
        let accuracy = solve(&exact).unwrap().accuracy;
        let trials = 20_000;
        let (mut focal_sum, mut center_sum) = (0.0, 0.0);
        let mut random = SplitMix64::new(7, 0);
        for _ in 0..trials {
            // Uniform errors with a deviation of 1 mm.
            let mut error = || 0.001 * 3.0_f64.sqrt() * (2.0 * random.unit() - 1.0);
            let mut blurred = exact;
            for wall in [Some(&mut blurred.first), blurred.second.as_mut()].into_iter().flatten() {
                wall.distance_m += error();
                wall.image_m.iter_mut().chain(wall.axis_m.iter_mut().flatten()).for_each(|length| *length += error());
            }
            let found = solve(&blurred).unwrap().lens;
            focal_sum += (found.focal_px.x / lens.focal_px.x - 1.0).powi(2);
            center_sum += (found.center_px.y - lens.center_px.y).powi(2);
        }
        let [focal, center] = [focal_sum, center_sum].map(|sum: f64| (sum / f64::from(trials)).sqrt());
        assert!((focal / accuracy.focal_share.x - 1.0).abs() < 0.1, "{focal} {accuracy:?}");
        assert!((center / accuracy.center_px.y - 1.0).abs() < 0.1, "{center} {accuracy:?}");
    }
}

#[test]
fn accuracy_is_at_a_metre_and_one_distance_depends_on_the_lens_position() {
    let lens = beamer();
    let one = solve(&measures(wall(&lens, 2.0, 0.0), None)).unwrap().accuracy;
    assert_eq!(one.focal_share_by_place, Some(0.5));
    assert!((0.000_5..0.002).contains(&one.light_m), "{one:?}");
    let two = solve(&measures(wall(&lens, 1.0, 0.0), Some(wall(&lens, 2.0, 0.0)))).unwrap().accuracy;
    assert_eq!(two.focal_share_by_place, None);
    assert!(two.light_m > one.light_m, "{two:?}");
}

#[test]
fn differing_matrices_are_compared_in_pixels_and_millimetres() {
    let k = [1900.0, 0.0, 640.0, 0.0, 1900.0, 817.0, 0.0, 0.0, 1.0];
    let p = [1900.0, 0.0, 640.0, 0.0, 0.0, 1900.0, 750.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let warning = |p: &[f64; 12]| compare_matrices([1280, 800], &k, p).map(|difference| difference.to_string());
    assert!(warning(&p).unwrap().contains("cy 817 and 750: up to 67 pixels, 35 mm at a metre"));
    let mut same = p;
    same[6] = 817.0;
    assert_eq!(warning(&same), None);
    let mut long = same;
    long[0] = 1881.0;
    assert!(warning(&long).unwrap().contains("fx 1900 and 1881: up to 6 pixels, 3 mm at a metre"));
    let mut none = same;
    none[0] = f64::NAN;
    assert!(warning(&none).unwrap().contains("fx 1900 and NaN"), "{:?}", warning(&none));
}
