//! An image of 1280×800 pixels as rviz's plugin reads it back (blue first, the lowest row first) to `rgb8`: as it
//! is, and through a projector's lens.

use std::hint::black_box;

use criterion::{criterion_group, criterion_main, Criterion};
use rcs_camera::{optics, write_through, CameraInfoFields, CameraModel, Lenses, Projection, Readback};
use rcs_scene::{Encoding, Image, PixelOrder};

const SIZE_PX: [u32; 2] = [1280, 800];

fn bench(criterion: &mut Criterion) {
    let [width_px, height_px] = SIZE_PX;
    let row_bytes = 4 * width_px as usize;
    let drawn: Vec<u8> = (0..row_bytes * height_px as usize).map(|i| (i / 7 % 256) as u8).collect();
    let mut out = vec![0; 3 * width_px as usize * height_px as usize];
    criterion.bench_function("1280x800 bgra, lowest row first, to rgb8", |bencher| {
        bencher.iter(|| {
            let image = Readback::new(black_box(&drawn), SIZE_PX, row_bytes, PixelOrder::Bgra, true);
            image.map(|image| image.write(Encoding::Rgb8, &mut out)).is_ok()
        });
    });

    let (k, r) = ([1900.0, 0.0, 640.0, 0.0, 1900.0, 750.0, 0.0, 0.0, 1.0], [0.0; 9]);
    let p = [1900.0, 0.0, 640.0, 0.0, 0.0, 1900.0, 750.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let (distortion_model, d) = ("plumb_bob", &[-0.1, 0.02, 0.0, 0.0, 0.0]);
    let (binning, region_px) = ([0; 2], [0; 4]);
    let info = CameraInfoFields { width_px, height_px, distortion_model, d, k: &k, r: &r, p: &p, binning, region_px };
    let model = CameraModel { projection: Projection::Exact, undistort: true };
    let Some(lens) = optics(&info, "", model, &Lenses::default()).ok().and_then(|optics| optics.lens) else { return };
    let mut before_lens = Image::default();
    let [width_px, height_px] = lens.source_size_px();
    before_lens.reset(width_px, height_px, Encoding::Rgba8);
    criterion.bench_function("through a lens", |bencher| {
        bencher.iter(|| write_through(&lens, black_box(&before_lens), [0; 3], Encoding::Rgb8, &mut out));
    });
}

criterion_group!(benches, bench);
criterion_main!(benches);
