//! Tests of the blending weights of several projectors on one surface.

use nalgebra::{Point3, UnitQuaternion, Vector3};

use super::*;
use crate::Distortion;

/// Projector 2 m before the wall z = 0 of the cloud's frame, `x` to the side and rotated towards its middle.
fn projector(x: f64, turned: f64, distortion: Distortion) -> PlacedProjector {
    let lens = Lens { distortion, ..Lens::pinhole([160, 100], [150.0, 152.0], [80.0, 60.0]) };
    let turn = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), turned);
    let cloud_from_projector = Isometry3::from_parts(Vector3::new(x, 0.0, -2.0).into(), turn);
    PlacedProjector { lens, projector_from_cloud: cloud_from_projector.inverse() }
}

/// Cloud of a wall at z = 0: a point every two centimetres.
fn wall() -> Vec<Point3<f64>> {
    let steps = -150..=150;
    steps
        .clone()
        .flat_map(|x| (-100..=100).map(move |y| Point3::new(0.02 * f64::from(x), 0.02 * f64::from(y), 0.0)))
        .collect()
}

/// Weight with which a projector lights a point.
fn weight_at(projector: &PlacedProjector, weights: &BlendWeights, point: &Point3<f64>) -> Option<f64> {
    let pixel =
        projector.lens.project(&(projector.projector_from_cloud * point)).filter(|at| projector.lens.contains(*at))?;
    let [width, height] = weights.size_px.map(|side| side as usize);
    let (x, y) = (pixel.x.clamp(0.0, width as f64 - 1.0), pixel.y.clamp(0.0, height as f64 - 1.0));
    let (left, above) = (x as usize, y as usize);
    let at =
        |column: usize, row: usize| f64::from(weights.weights[row.min(height - 1) * width + column.min(width - 1)]);
    let (x, y) = (x - left as f64, y - above as f64);
    let upper = at(left, above) * (1.0 - x) + at(left + 1, above) * x;
    let lower = at(left, above + 1) * (1.0 - x) + at(left + 1, above + 1) * x;
    Some(upper * (1.0 - y) + lower * y)
}

#[test]
fn weights_add_up_to_one_everywhere_and_fall_to_zero_at_the_edges() {
    let bent = Distortion::plumb_bob([-0.1, 0.02, 0.0, 0.0, 0.0]);
    let projectors =
        [projector(-0.6, 0.1, Distortion::NONE), projector(0.6, -0.15, bent), projector(0.1, 0.0, Distortion::NONE)];
    let blended = blend_weights(&projectors, &wall()).unwrap();
    let mut lit_by = [0; 4];
    for point in wall() {
        let lit = projectors.iter().zip(&blended).filter(|(projector, _)| edge_distance_px(projector, &point) > 0.0);
        // Near an edge, weights change too fast for the interpolation.
        if projectors.iter().any(|projector| edge_distance_px(projector, &point).abs() < 4.0) {
            continue;
        }
        let weights: Vec<f64> = lit.filter_map(|(projector, weights)| weight_at(projector, weights, &point)).collect();
        lit_by[weights.len()] += 1;
        let sum: f64 = weights.iter().sum();
        assert!(weights.is_empty() || (sum - 1.0).abs() < 0.02, "{point}: {weights:?}");
    }
    assert!(lit_by[1..].iter().all(|count| *count > 500), "{lit_by:?}");
    for weights in &blended {
        let [width, _] = weights.size_px.map(|side| side as usize);
        let edges = (20..80).flat_map(|row| [row * width, (row + 1) * width - 1]);
        // Where other projectors light the point, too.
        let shared: Vec<f32> = edges.filter(|at| weights.lifts[*at] < 2.0).map(|at| weights.weights[at]).collect();
        assert!(shared.len() >= 30 && shared.iter().all(|weight| *weight < 0.01), "{shared:?}");
    }
}

/// Distance of the pixel that lights a point from the edge of a projector's image; negative outside.
fn edge_distance_px(projector: &PlacedProjector, point: &Point3<f64>) -> f64 {
    let Some(pixel) = projector.lens.project(&(projector.projector_from_cloud * point)) else {
        return f64::NEG_INFINITY;
    };
    let [width, height] = projector.lens.size_px.map(f64::from);
    let x = (pixel.x + 0.5).min(width - 0.5 - pixel.x);
    x.min(pixel.y + 0.5).min(height - 0.5 - pixel.y)
}

#[test]
fn weights_change_smoothly_where_the_surface_is() {
    let projectors = [projector(-0.5, 0.0, Distortion::NONE), projector(0.5, 0.0, Distortion::NONE)];
    let blended = blend_weights(&projectors, &wall()).unwrap();
    for weights in &blended {
        let row = &weights.weights[50 * 160..51 * 160];
        let steps: Vec<f32> = row.windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(steps.iter().all(|step| step.abs() < 0.04), "{steps:?}");
        let kinks = steps.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        assert!(kinks.fold(0.0, f32::max) < 0.015);
        assert!(row.contains(&1.0) && row.iter().any(|weight| *weight < 0.01));
        assert!((0.2..0.9).contains(&weights.overlap) && weights.seen > 0.95, "{} {}", weights.overlap, weights.seen);
    }
}

#[test]
fn black_is_lifted_where_fewer_overlap_and_only_there() {
    let projectors = [projector(-0.5, 0.0, Distortion::NONE), projector(0.5, 0.0, Distortion::NONE)];
    let blended = blend_weights(&projectors, &wall()).unwrap();
    for weights in &blended {
        for (weight, lift) in weights.weights.iter().zip(&weights.lifts) {
            assert_eq!(*lift, if *weight == 1.0 { 1.0 } else { 0.0 }, "the leak of the other, where it is alone");
        }
    }
}

#[test]
fn in_the_shadow_of_an_object_the_other_projector_has_full_weight() {
    let projectors = [projector(-0.5, 0.0, Distortion::NONE), projector(0.5, 0.0, Distortion::NONE)];
    let mut cloud = wall();
    // A board before the wall, in the left projector's light: its shadow falls on the wall to its right.
    let board =
        (-20..=20).flat_map(|x| (-20..=20).map(move |y| Point3::new(0.005 * f64::from(x), 0.005 * f64::from(y), -0.6)));
    cloud.extend(board);
    let blended = blend_weights(&projectors, &cloud).unwrap();
    let in_shadow = Point3::new(0.25, 0.0, 0.0);
    let right = weight_at(&projectors[1], &blended[1], &in_shadow).unwrap();
    assert!(right > 0.99, "{right}");
    let beside = weight_at(&projectors[1], &blended[1], &Point3::new(0.0, 0.45, 0.0)).unwrap();
    assert!((0.3..0.7).contains(&beside), "{beside}");
}

#[test]
fn one_projector_or_one_that_lights_no_point_has_no_weights() {
    let one = projector(0.0, 0.0, Distortion::NONE);
    assert_eq!(blend_weights(&[one], &wall()), Err(BlendProblem::TooFew));
    let away = PlacedProjector {
        projector_from_cloud: Isometry3::rotation(Vector3::y() * 3.0) * one.projector_from_cloud,
        ..one
    };
    assert_eq!(blend_weights(&[one, away], &wall()), Err(BlendProblem::Dark { number: 2 }));
    let nowhere = [Point3::new(f64::NAN, 0.0, 0.0)];
    assert_eq!(blend_weights(&[one, one], &nowhere), Err(BlendProblem::Dark { number: 1 }));
}
