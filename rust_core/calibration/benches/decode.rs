//! Decoding 44 images of 640×480 pixels.

use std::hint::black_box;

use criterion::{criterion_group, criterion_main, Criterion};
use rcs_calibration::patterns::gray_code;
use rcs_calibration::{decode, Images};
use rcs_scan_simulator::{Conditions, Rig, Room, Scan, View};

const PROJECTOR_PX: [u32; 2] = [1280, 800];

fn bench(criterion: &mut Criterion) {
    let view = View::new(&Room::cluttered(3), &Rig::random(3));
    let patterns = gray_code(PROJECTOR_PX);
    let images = Scan::new(&view, Conditions::random(3)).capture_all(&patterns);
    let levels = images.iter().map(Vec::as_slice).collect();
    let images = Images { size_px: view.size_px(), patterns: &patterns, levels };
    let mut group = criterion.benchmark_group("decode");
    group.sample_size(20);
    group.bench_function("44 pictures of 640x480", |bencher| {
        bencher.iter(|| decode(black_box(&images), PROJECTOR_PX));
    });
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
