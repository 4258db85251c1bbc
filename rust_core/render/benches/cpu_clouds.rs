//! How long the CPU renderer takes for a depth camera's cloud: 640 by 480 points, drawn in each style at 1280 by 800.
//!
//! `cargo bench -p rcs_render --bench cpu_clouds [-- THREADS [PICTURES]]` prints the fastest and the median picture of
//! each style in milliseconds, for points in the order of the camera's rows and for shuffled ones.

use std::error::Error;
use std::sync::Arc;
use std::time::Instant;

use nalgebra::{Isometry3, Matrix4, Point3, Vector3};
use rcs_render::{CpuRenderer, Renderer, View};
use rcs_scene::{
    Camera, DisplayMask, Drawable, Encoding, Geometry, Intrinsics, Picture, PointBuffer, PointColors, PointStyle,
    Points, RenderGroup, Scene,
};

/// A wavy surface about a metre away, in the camera's optical frame.
fn depth_cloud() -> PointBuffer {
    let (mut positions, mut colors) = (Vec::new(), Vec::new());
    for row in 0..480_u16 {
        for column in 0..640_u16 {
            let (x, y) = ((f64::from(column) - 320.0) / 570.0, (f64::from(row) - 240.0) / 570.0);
            let z = 1.0 + 0.15 * (6.0 * x).sin() * (5.0 * y).cos();
            positions.push([(x * z) as f32, (y * z) as f32, z as f32]);
            colors.push([(column % 256) as u8, (row % 256) as u8, 90, 255]);
        }
    }
    PointBuffer { positions, colors: PointColors::PerPoint(colors) }
}

/// The same points in an order that has nothing to do with where they are.
fn shuffled(buffer: &PointBuffer) -> PointBuffer {
    let count = buffer.positions.len();
    // A step that shares no factor with the count visits every point once.
    let order = (0..count).map(|i| (i * 100_003) % count);
    PointBuffer {
        positions: order.clone().filter_map(|i| buffer.positions.get(i).copied()).collect(),
        colors: PointColors::PerPoint(order.map(|i| buffer.colors.get(i)).collect()),
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut numbers = std::env::args().filter_map(|argument| argument.parse::<usize>().ok());
    let (threads, pictures) = (numbers.next().unwrap_or(2), numbers.next().unwrap_or(30).max(1));
    let p = [1100.0, 0.0, 640.0, 0.0, 0.0, 1100.0, 400.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let pose = Isometry3::new(Vector3::new(0.05, -0.05, 0.0), Vector3::new(0.05, 0.02, 0.1));
    let camera = Camera::new(Intrinsics::from_p(1280, 800, &p)?, &pose, 0.01);
    let in_rows = Arc::new(depth_cloud());
    let mixed = Arc::new(shuffled(&in_rows));
    let mut renderer = CpuRenderer::with_threads(threads);
    let mut picture = Picture::default();
    println!("{}, {} points", renderer.describe(), in_rows.positions.len());
    let side_m = 0.0036;
    for (name, style) in [
        ("Points 3 px", PointStyle::Points { diameter_px: 3.0 }),
        ("Flat Squares 4 px", PointStyle::FlatSquares { side_m }),
        ("Squares 4 px", PointStyle::Squares { size_m: [side_m; 2] }),
        ("Spheres 4 px", PointStyle::Spheres { size_m: [side_m; 2] }),
        ("Boxes 4 px", PointStyle::Boxes { size_m: [side_m; 3] }),
    ] {
        for (order, buffer) in [("in rows", &in_rows), ("shuffled", &mixed)] {
            let points = Points { buffer: buffer.clone(), style, alpha: 1.0, blended: false, auto_size: false };
            let drawable = Drawable {
                display: 0,
                fixed_from_object: Matrix4::identity(),
                sort_point: Point3::origin(),
                group: RenderGroup::Main,
                geometry: Geometry::Points(points),
            };
            let scene = Scene { drawables: vec![drawable], light: None };
            let visible = DisplayMask::all();
            let view = View {
                scene: &scene,
                camera: &camera,
                visible: &visible,
                background: [0, 0, 0],
                encoding: Encoding::Rgb8,
            };
            let mut times_ms = Vec::with_capacity(pictures);
            for _ in 0..pictures {
                let start = Instant::now();
                renderer.render(&view, &mut picture)?;
                times_ms.push(start.elapsed().as_secs_f64() * 1e3);
            }
            times_ms.sort_by(f64::total_cmp);
            let (fastest, median) = (times_ms[0], times_ms[times_ms.len() / 2]);
            println!("{name:18} {order:9} fastest {fastest:6.2} ms, median {median:6.2} ms");
        }
    }
    Ok(())
}
