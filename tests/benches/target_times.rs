//! The scenes with a target time, each an image of 1280×800 pixels on two cores:
//!
//! - `target_times/points_15px` and `target_times/squares_15px`: the clusters of a few objects, 1,200 points of
//!   15 pixels. Target: below 1 ms.
//! - `target_times/flat_squares_307200`: a depth camera's cloud as in the end-to-end benchmark, squares of 4 mm.
//!   Target: 6 ms.
//! - `target_times/points_3px_307200`: the same cloud as spots of 3 pixels. Target: 4 ms.
//!
//! `RCS_RENDERER=gpu` measures the GPU renderer.
#![expect(clippy::unwrap_used, reason = "a benchmark that cannot draw measures nothing")]

mod common;

use std::time::Duration;

use criterion::{criterion_group, criterion_main, Criterion};
use rcs_scene::PointStyle;
use rcs_tests::scenes::clouds::{drawable, in_rows, DEPTH_CAMERA_POINTS, SIDE_M};
use rcs_tests::scenes::rendering::{projector, renderer, Rendering};

/// Points of the smallest scene.
const FEW: usize = 1200;
/// The side of a square that covers 15 pixels of the projector, 1.5 m away.
const SIDE_OF_15_PX_M: f32 = 15.0 * 1.5 / 1900.0;

fn target_times(c: &mut Criterion) {
    let mut group = c.benchmark_group("target_times");
    group.sample_size(20).measurement_time(Duration::from_secs(1));
    for (name, count, style) in [
        ("points_15px", FEW, PointStyle::Points { diameter_px: 15.0 }),
        ("squares_15px", FEW, PointStyle::Squares { size_m: [SIDE_OF_15_PX_M; 2] }),
        ("flat_squares_307200", DEPTH_CAMERA_POINTS, PointStyle::FlatSquares { side_m: SIDE_M }),
        ("points_3px_307200", DEPTH_CAMERA_POINTS, PointStyle::Points { diameter_px: 3.0 }),
    ] {
        let mut rendering =
            Rendering::new(vec![drawable(in_rows(count), style)], projector().unwrap(), renderer().unwrap());
        group.bench_function(name, |b| b.iter(|| rendering.draw().unwrap().data[0]));
    }
    group.finish();
}

criterion_group! { name = benches; config = common::quick(); targets = target_times }
criterion_main!(benches);
