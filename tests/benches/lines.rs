//! The renderer by the number of lines: `lines/20px/COUNT` for lines of one pixel's width and 20 pixels' length,
//! `lines/ribbons/ELEMENTS` for wide lines of ten elements each. The image has 1280×800 pixels; `RCS_RENDERER=gpu`
//! measures the GPU renderer.
#![expect(clippy::unwrap_used, reason = "a benchmark that cannot draw measures nothing")]

mod common;

use criterion::{criterion_group, criterion_main, BenchmarkId, Criterion, Throughput};
use rcs_scene::Geometry;
use rcs_tests::scenes::rendering::{camera, renderer, Rendering};
use rcs_tests::scenes::solids;

const FOCAL_PX: f64 = 1000.0;
const VIEW: [f64; 2] = [1.28, 0.8];

fn lines(c: &mut Criterion) {
    let mut group = c.benchmark_group("lines");
    let mut measure = |kind: &str, count: usize, geometry: Geometry| {
        group.throughput(Throughput::Elements(count as u64));
        let camera = camera([1280, 800], FOCAL_PX).unwrap();
        let mut rendering = Rendering::new(vec![solids::drawable(geometry)], camera, renderer().unwrap());
        group.bench_function(BenchmarkId::new(kind, count), |b| b.iter(|| rendering.draw().unwrap().data[0]));
    };
    for count in [1000, 10_000, 100_000, 1_000_000] {
        measure("20px", count, solids::lines(count, 20.0, FOCAL_PX, VIEW));
    }
    for count in [100, 1000, 10_000] {
        measure("ribbons", count, solids::ribbons(count, VIEW));
    }
    group.finish();
}

criterion_group! { name = benches; config = common::quick(); targets = lines }
criterion_main!(benches);
