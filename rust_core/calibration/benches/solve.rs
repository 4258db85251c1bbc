//! Solving 200,000 points: lens, distortion selected by held-out points, pose and covariance.

use std::hint::black_box;

use criterion::{criterion_group, criterion_main, Criterion};
use nalgebra::{Isometry3, Point2, Point3, Vector2, Vector3};
use rcs_calibration::{solve, Distortion, Lens, Report, Sample, SolveOptions};

const POINTS: usize = 200_000;
const SIZE_PX: [u32; 2] = [1280, 800];

/// Pseudo-random number from -1 to 1.
fn next(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// Wall with boxes before it, with a tenth of gross errors.
fn samples() -> Vec<Sample> {
    let distortion = Distortion::plumb_bob([-0.1, 0.0, 0.0, 0.0, 0.0]);
    let lens = Lens { distortion, ..Lens::pinhole(SIZE_PX, [1410.0, 1400.0], [645.0, 817.0]) };
    let projector_from_camera = Isometry3::new(Vector3::new(0.25, -0.1, 0.0), Vector3::new(0.26, -0.12, 0.0));
    let mut state = 1;
    let mut samples = Vec::with_capacity(POINTS);
    while samples.len() < POINTS {
        let (x, y) = (0.6 * next(&mut state), 0.45 * next(&mut state));
        let (column, row) = ((x * 8.0).floor(), (y * 8.0).floor());
        let box_m = (column * 12.9898 + row * 78.233).sin();
        let depth = if box_m > 0.2 { 1.7 - box_m + 0.1 * x } else { 1.7 / (1.0 + 0.1 * x) };
        let Some(pixel) = lens.project(&(projector_from_camera * Point3::new(x * depth, y * depth, depth))) else {
            continue;
        };
        if !lens.contains(pixel) {
            continue;
        }
        let seen = depth + 0.001 * depth * depth * (next(&mut state) + next(&mut state));
        let noise = Vector2::new(next(&mut state), next(&mut state)) * 0.3;
        let is_gross = next(&mut state) > 0.8;
        let anywhere = Point2::new(639.5 + 640.0 * next(&mut state), 399.5 + 400.0 * next(&mut state));
        let pixel = if is_gross { anywhere } else { pixel + noise };
        samples.push(Sample::new(pixel, Point3::new(x * seen, y * seen, seen)));
    }
    samples
}

fn bench(criterion: &mut Criterion) {
    let samples = samples();
    let options = SolveOptions::new(SIZE_PX);
    let mut group = criterion.benchmark_group("calibration");
    group.sample_size(10);
    group.bench_function("solve/200000", |bencher| bencher.iter(|| black_box(solve(black_box(&samples), &options))));
    if let Ok(solution) = solve(&samples, &options) {
        group.bench_function("report/200000", |bencher| {
            bencher.iter(|| black_box(Report::new(black_box(&samples), solution.clone())));
        });
    }
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
