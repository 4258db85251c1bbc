//! The renderer by a cloud's style and size: a depth camera's wavy surface fills 1280×800 pixels.
//!
//! `styles/STYLE/POINTS` for points in the order of the camera's rows, `shuffled/STYLE/POINTS` in an order that is
//! independent of their places, `threads/STYLE/THREADS` for the CPU renderer on so many threads.
//! `RCS_RENDERER=gpu` measures the GPU renderer.
#![expect(clippy::unwrap_used, reason = "a benchmark that cannot draw measures nothing")]

mod common;

use criterion::{criterion_group, criterion_main, BenchmarkId, Criterion, Throughput};
use rcs_render::CpuRenderer;
use rcs_scene::PointBuffer;
use rcs_tests::scenes::clouds::{drawable, in_rows, shuffled, DEPTH_CAMERA_POINTS, STYLES};
use rcs_tests::scenes::rendering::{projector, renderer, Rendering};

const POINTS: [usize; 5] = [10_000, 100_000, DEPTH_CAMERA_POINTS, 1_000_000, 3_000_000];

fn measure(c: &mut Criterion, group: &str, buffer: &PointBuffer) {
    let mut group = c.benchmark_group(group);
    let count = buffer.positions.len();
    group.throughput(Throughput::Elements(count as u64));
    for (name, style) in STYLES {
        let mut rendering =
            Rendering::new(vec![drawable(buffer.clone(), style)], projector().unwrap(), renderer().unwrap());
        group.bench_function(BenchmarkId::new(name, count), |b| b.iter(|| rendering.draw().unwrap().data[0]));
    }
    group.finish();
}

fn styles(c: &mut Criterion) {
    for count in POINTS {
        measure(c, "styles", &in_rows(count));
    }
}

fn order(c: &mut Criterion) {
    measure(c, "shuffled", &shuffled(DEPTH_CAMERA_POINTS));
}

fn threads(c: &mut Criterion) {
    let mut group = c.benchmark_group("threads");
    let buffer = in_rows(DEPTH_CAMERA_POINTS);
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    for threads in [1, all] {
        for (name, style) in STYLES.into_iter().filter(|(name, _)| ["points", "flat_squares"].contains(name)) {
            let renderer = Box::new(CpuRenderer::with_threads(threads));
            let mut rendering = Rendering::new(vec![drawable(buffer.clone(), style)], projector().unwrap(), renderer);
            group.bench_function(BenchmarkId::new(name, threads), |b| b.iter(|| rendering.draw().unwrap().data[0]));
        }
    }
    group.finish();
}

criterion_group! { name = benches; config = common::quick(); targets = styles, order, threads }
criterion_main!(benches);
