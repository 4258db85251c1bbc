//! Labels of 16 characters: `text/lay_out/LABELS` makes them, `text/draw/LABELS` draws them, 7 to 20 pixels high,
//! on 1280×800 pixels. `RCS_RENDERER=gpu` measures the GPU renderer.
#![expect(clippy::unwrap_used, reason = "a benchmark that cannot draw measures nothing")]

mod common;

use criterion::{criterion_group, criterion_main, BenchmarkId, Criterion, Throughput};
use rcs_tests::scenes::rendering::{camera, renderer, Rendering};
use rcs_tests::scenes::solids;

const VIEW: [f64; 2] = [1.28, 0.8];

fn text(c: &mut Criterion) {
    let mut group = c.benchmark_group("text");
    for count in [10, 100, 1000] {
        group.throughput(Throughput::Elements(count as u64));
        group.bench_function(BenchmarkId::new("lay_out", count), |b| b.iter(|| solids::labels(count, VIEW)));
        let camera = camera([1280, 800], 1000.0).unwrap();
        let mut rendering = Rendering::new(solids::labels(count, VIEW), camera, renderer().unwrap());
        group.bench_function(BenchmarkId::new("draw", count), |b| b.iter(|| rendering.draw().unwrap().data[0]));
    }
    group.finish();
}

criterion_group! { name = benches; config = common::quick(); targets = text }
criterion_main!(benches);
