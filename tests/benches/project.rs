//! Projecting and selecting points, apart from drawing them: `project/KIND/POINTS`.
//!
//! - `missed`: squares of a micrometre. Each is projected to find the rows that it can touch, and nearly all touch the
//!   centre of none, so that nothing is left to sort and to draw.
//! - `beside`: the same squares, all of them beside the view. No point decides that the cloud has to be drawn, so
//!   the box around all of them is computed as well.
//!
//! The image has 64×40 pixels, so that clearing and encoding it does not count; for projecting a point its size does
//! not matter. `RCS_RENDERER=gpu` measures the GPU renderer.
#![expect(clippy::unwrap_used, reason = "a benchmark that cannot draw measures nothing")]

mod common;

use criterion::{criterion_group, criterion_main, BenchmarkId, Criterion, Throughput};
use nalgebra::{Matrix4, Vector3};
use rcs_scene::PointStyle;
use rcs_tests::scenes::clouds::{drawable, in_rows, DEPTH_CAMERA_POINTS};
use rcs_tests::scenes::rendering::{camera, renderer, Rendering};

fn project(c: &mut Criterion) {
    let mut group = c.benchmark_group("project");
    for count in [10_000, 100_000, DEPTH_CAMERA_POINTS, 1_000_000, 3_000_000] {
        group.throughput(Throughput::Elements(count as u64));
        for (kind, x_m) in [("missed", -0.05), ("beside", 10.0)] {
            let mut cloud = drawable(in_rows(count), PointStyle::FlatSquares { side_m: 1e-6 });
            cloud.fixed_from_object = Matrix4::new_translation(&Vector3::new(x_m, 0.0, 0.0));
            let mut rendering = Rendering::new(vec![cloud], camera([64, 40], 95.0).unwrap(), renderer().unwrap());
            group.bench_function(BenchmarkId::new(kind, count), |b| b.iter(|| rendering.draw().unwrap().data[0]));
        }
    }
    group.finish();
}

criterion_group! { name = benches; config = common::quick(); targets = project }
criterion_main!(benches);
