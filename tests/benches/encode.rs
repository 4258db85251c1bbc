//! From drawn pixels to the wire: `encode/ENCODING/SIZE` writes an image's rows in an encoding, from one row of pixels
//! as the renderer does from its cache; `encode/message/SIZE` makes the bytes of an rgb8 Image message, one copy;
//! `encode/jpeg 80/SIZE` and `encode/png 1/SIZE` compress an image that is black but for a pattern of colours in its
//! middle quarter.
#![expect(clippy::unwrap_used, reason = "a benchmark that cannot encode measures nothing")]

mod common;

use std::sync::Arc;

use criterion::{criterion_group, criterion_main, BenchmarkId, Criterion, Throughput};
use rcs_files::image_file::Coding;
use rcs_messages::std_msgs::Header;
use rcs_messages::Image as ImageMessage;
use rcs_scene::{Encoding, Image};

const SIZES_PX: [[u32; 2]; 4] = [[640, 480], [1280, 800], [1920, 1080], [3840, 2160]];

fn encode(c: &mut Criterion) {
    let mut group = c.benchmark_group("encode");
    for [width_px, height_px] in SIZES_PX {
        let size = format!("{width_px}x{height_px}");
        let pixels: Vec<[u8; 4]> = (0..width_px).map(u32::to_le_bytes).collect();
        let mut image = Image::default();
        for encoding in Encoding::ALL {
            image.reset(width_px, height_px, encoding);
            let step = image.step();
            group.throughput(Throughput::Bytes(image.data.len() as u64));
            group.bench_function(BenchmarkId::new(encoding.name(), &size), |b| {
                b.iter(|| {
                    for row in image.data.chunks_exact_mut(step) {
                        encoding.write_row(std::hint::black_box(&pixels), row);
                    }
                });
            });
        }
        image.reset(width_px, height_px, Encoding::Rgb8);
        let (left, right) = (width_px as usize / 4 * 3, width_px as usize * 9 / 4);
        let step = image.step();
        for (y, row) in image.data.chunks_exact_mut(step).enumerate().skip(height_px as usize / 4) {
            if y < height_px as usize * 3 / 4 {
                row[left..right].iter_mut().enumerate().for_each(|(x, value)| *value = ((x / 12) ^ (y / 4)) as u8);
            }
        }
        group.throughput(Throughput::Bytes(image.data.len() as u64));
        for (name, coding) in [("jpeg 80", Coding::Jpeg { quality: 80 }), ("png 1", Coding::Png { level: 1 })] {
            group.bench_function(BenchmarkId::new(name, &size), |b| {
                b.iter(|| rcs_files::image_file::encode(&image, coding).unwrap());
            });
        }
        group.throughput(Throughput::Bytes(image.data.len() as u64));
        let (encoding, step) = (image.encoding.name(), image.step() as u32);
        let image = ImageMessage::new(Header::default(), [width_px, height_px], encoding, step, Arc::new(image.data));
        group.bench_function(BenchmarkId::new("message", &size), |b| b.iter(|| image.parts()));
    }
    group.finish();
}

criterion_group! { name = benches; config = common::quick(); targets = encode }
criterion_main!(benches);
