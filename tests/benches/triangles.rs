//! The renderer by the number of triangles and their size: `triangles/LEG/COUNT`, the leg in pixels of 1280×800.
//!
//! The triangles share no corners; `big_robot` among the tests measures meshes that do. `RCS_RENDERER=gpu` measures the
//! GPU renderer.
#![expect(clippy::unwrap_used, reason = "a benchmark that cannot draw measures nothing")]

mod common;

use criterion::{criterion_group, criterion_main, BenchmarkId, Criterion, Throughput};
use rcs_tests::scenes::rendering::{camera, renderer, Rendering};
use rcs_tests::scenes::solids;

const FOCAL_PX: f64 = 1000.0;

fn triangles(c: &mut Criterion) {
    let mut group = c.benchmark_group("triangles");
    for (leg_px, counts) in
        [(2.0, &[1000, 10_000, 100_000, 1_000_000][..]), (10.0, &[1000, 10_000, 100_000]), (100.0, &[10, 100, 1000])]
    {
        for &count in counts {
            group.throughput(Throughput::Elements(count as u64));
            let geometry = solids::triangles(count, leg_px, FOCAL_PX, [1.28, 0.8]);
            let camera = camera([1280, 800], FOCAL_PX).unwrap();
            let mut rendering = Rendering::new(vec![solids::drawable(geometry)], camera, renderer().unwrap());
            let id = BenchmarkId::new(format!("{leg_px}px"), count);
            group.bench_function(id, |b| b.iter(|| rendering.draw().unwrap().data[0]));
        }
    }
    group.finish();
}

criterion_group! { name = benches; config = common::quick(); targets = triangles }
criterion_main!(benches);
