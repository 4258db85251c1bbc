//! The frame tree: the cost of looking up transforms.
//!
//! - `transform/latest/FRAMES`: across a chain of so many moving frames, at the latest common time.
//! - `transform/at_stamp/SAMPLES`: between two samples of one frame's history of so many.
//! - `transform/insert/SAMPLES`: one more sample at the end of such a history, the oldest of which is forgotten.
//! - `transform/place/MESSAGES`: so many messages go through the queue in which they wait for their frame.
#![expect(clippy::unwrap_used, reason = "a benchmark whose frames are not connected measures nothing")]

mod common;

use std::time::Duration;

use criterion::{criterion_group, criterion_main, BenchmarkId, Criterion, Throughput};
use rcs_transforms::{RawTransform, Time, TransformTree, WaitingQueue};

/// Time from a sample to the next: 300 Hz.
const STEP_NANOS: i64 = 3_333_333;

/// The time of a sample.
fn stamp(sample: i64) -> Time {
    Time::from_nanos(1_000_000_000 + sample * STEP_NANOS)
}

fn insert(tree: &mut TransformTree, parent: &str, child: &str, sample: i64) {
    let turn = (sample as f64 * 0.001).sin() * 0.5;
    let (translation, rotation_xyzw) = ([0.1, turn, 0.0], [0.0, 0.0, turn.sin(), turn.cos()]);
    let transform = RawTransform { parent, child, stamp: stamp(sample), translation, rotation_xyzw };
    tree.insert(&transform, false, "bench").unwrap();
}

/// `frame_0` to `frame_N`, each the parent of the next, with a history of so many samples.
fn chain(frames: usize, samples: i64) -> TransformTree {
    let mut tree = TransformTree::with_cache_length(stamp(samples).saturating_since(stamp(1)));
    for sample in 0..samples {
        for frame in 0..frames {
            insert(&mut tree, &format!("frame_{frame}"), &format!("frame_{}", frame + 1), sample);
        }
    }
    tree
}

fn transform(c: &mut Criterion) {
    let mut group = c.benchmark_group("transform");
    for frames in [1, 10, 100] {
        let tree = chain(frames, 100);
        let last = format!("frame_{frames}");
        group.bench_function(BenchmarkId::new("latest", frames), |b| {
            b.iter(|| tree.lookup("frame_0", &last, Time::ZERO).unwrap());
        });
    }
    for samples in [10, 100, 1000, 10_000] {
        let mut tree = chain(1, samples);
        let between = Time::from_nanos(stamp(samples / 2).as_nanos() + STEP_NANOS / 2);
        group.bench_function(BenchmarkId::new("at_stamp", samples), |b| {
            b.iter(|| tree.lookup("frame_0", "frame_1", between).unwrap());
        });
        let mut next = samples;
        group.bench_function(BenchmarkId::new("insert", samples), |b| {
            b.iter(|| {
                insert(&mut tree, "frame_0", "frame_1", next);
                next += 1;
            });
        });
    }
    let tree = chain(10, 100);
    for messages in [1, 100] {
        group.throughput(Throughput::Elements(messages as u64));
        let mut queue = WaitingQueue::new(messages as usize);
        group.bench_function(BenchmarkId::new("place", messages), |b| {
            b.iter(|| {
                for message in 0..messages {
                    queue.push("frame_10", stamp(50), message);
                }
                queue.take_ready(&tree, "frame_0")
            });
        });
    }
    group.finish();
}

criterion_group! { name = benches; config = common::quick().measurement_time(Duration::from_millis(300)); targets = transform }
criterion_main!(benches);
