//! What a projector's distortion costs: a depth camera's cloud on 1280×800 pixels, `lens/STYLE/without` and
//! `lens/STYLE/with`.
#![expect(clippy::unwrap_used, reason = "a benchmark that cannot draw measures nothing")]

mod common;

use std::sync::Arc;

use criterion::{criterion_group, criterion_main, BenchmarkId, Criterion};
use nalgebra::{Isometry3, Point2};
use rcs_calibration::{Distortion, Lens};
use rcs_scene::{Camera, Intrinsics, PixelMap};
use rcs_tests::scenes::clouds::{drawable, in_rows, DEPTH_CAMERA_POINTS, STYLES};
use rcs_tests::scenes::rendering::{projector, renderer, Rendering};

/// The projector behind a lens that moves the corners by some ten pixels.
fn behind_lens(projector: &Camera) -> Camera {
    let p = *projector.intrinsics();
    let (size_px, center_px) = ([p.width_px, p.height_px], [p.cx_px, p.cy_px]);
    let distortion = Distortion::plumb_bob([-0.12, 0.02, 0.0005, -0.001, 0.0]);
    let lens = Lens { distortion, ..Lens::pinhole(size_px, [p.fx_px, p.fy_px], center_px) };
    let place = |[u, v]: [f64; 2]| {
        let place = lens.plane(Point2::new(u, v))?;
        Some([p.fx_px * place.x + p.cx_px, p.fy_px * place.y + p.cy_px])
    };
    let map = PixelMap::new(size_px, place).unwrap();
    let ([width_px, height_px], [left, top]) = (map.source_size_px(), map.source_origin_px().map(f64::from));
    let drawn = Intrinsics { width_px, height_px, cx_px: p.cx_px - left, cy_px: p.cy_px - top, ..p };
    Camera::new(drawn, &Isometry3::identity(), projector.near_m()).with_lens(Arc::new(map))
}

fn lens(c: &mut Criterion) {
    let mut group = c.benchmark_group("lens");
    let straight = projector().unwrap();
    for (name, style) in STYLES {
        for (kind, camera) in [("without", straight.clone()), ("with", behind_lens(&straight))] {
            let cloud = drawable(in_rows(DEPTH_CAMERA_POINTS), style);
            let mut rendering = Rendering::new(vec![cloud], camera, renderer().unwrap());
            group.bench_function(BenchmarkId::new(name, kind), |b| b.iter(|| rendering.draw().unwrap().data[0]));
        }
    }
    group.finish();
}

criterion_group! { name = benches; config = common::quick(); targets = lens }
criterion_main!(benches);
