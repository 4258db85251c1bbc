//! From a PointCloud2's bytes on the wire to points that can be drawn.
//!
//! - `decode/message/POINTS`: the bytes become a message, one copy.
//! - `decode/points/POINTS`: a PointCloud2 display takes the message and makes positions and colours of it.
//! - `decode/both/POINTS`: both, as for each message of a camera.
//! - `decode/COLOURS/POINTS`: as `points`, with another colour transformer.
//!
//! One point in 64 is NaN, as in a depth camera's clouds, and is left out.
#![expect(clippy::unwrap_used, reason = "a benchmark that cannot decode measures nothing")]

mod common;

use std::sync::Arc;

use criterion::{criterion_group, criterion_main, BenchmarkId, Criterion, Throughput};
use rcs_messages::{AnyMessage, MessageKind};
use rcs_tests::scenes::clouds::{message, DEPTH_CAMERA_POINTS};
use rcs_tests::scenes::display_pipeline::DisplayPipeline;

fn config(transformer: &str) -> String {
    format!(
        "  - {{Class: rviz/PointCloud2, Name: cloud, Enabled: true, Topic: /c, Color Transformer: {transformer}}}\n"
    )
}

fn decode(c: &mut Criterion) {
    let mut group = c.benchmark_group("decode");
    for count in [10_000, 100_000, DEPTH_CAMERA_POINTS, 1_000_000, 3_000_000] {
        group.throughput(Throughput::Elements(count as u64));
        let cloud = message("map", count, 0);
        let bytes = rcs_messages::encode(&cloud);
        group.bench_function(BenchmarkId::new("message", count), |b| {
            b.iter(|| MessageKind::PointCloud2.decode(&bytes).unwrap());
        });
        let cloud = AnyMessage::PointCloud2(Arc::new(cloud));
        let mut pipeline = DisplayPipeline::new(&config("RGB8"));
        group.bench_function(BenchmarkId::new("points", count), |b| {
            b.iter(|| pipeline.receive("/c", &cloud).drawables.len());
        });
        group.bench_function(BenchmarkId::new("both", count), |b| {
            b.iter(|| {
                let cloud = MessageKind::PointCloud2.decode(&bytes).unwrap();
                pipeline.receive("/c", &cloud).drawables.len()
            });
        });
    }
    group.throughput(Throughput::Elements(DEPTH_CAMERA_POINTS as u64));
    let cloud = AnyMessage::PointCloud2(Arc::new(message("map", DEPTH_CAMERA_POINTS, 0)));
    for (name, transformer) in
        [("flat", "FlatColor"), ("mono8", "MONO8"), ("axis", "AxisColor"), ("intensity", "Intensity, Channel Name: z")]
    {
        let mut pipeline = DisplayPipeline::new(&config(transformer));
        let id = BenchmarkId::new(name, DEPTH_CAMERA_POINTS);
        group.bench_function(id, |b| b.iter(|| pipeline.receive("/c", &cloud).drawables.len()));
    }
    group.finish();
}

criterion_group! { name = benches; config = common::quick(); targets = decode }
criterion_main!(benches);
