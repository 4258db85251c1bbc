//! Measures how many images of a cloud the GPU renderer draws in a second, and how long each step takes.
//!
//! `cargo run --release -p rcs_render --example gpu_throughput [-- POINTS [IMAGES]]` draws 3,000,000 points at 1280
//! by 800, with one and with two images in flight: a cloud that stays, under a camera that moves, a new cloud for
//! each image, and one in its message's bytes of 16 a point (making it is not in the times but shown apart). The
//! empty scene beside them gives the cost of reading back alone: the rest of a cloud's `wait` is the GPU's drawing.
//! With two in flight, `wait` is only what the other image's steps do not cover.

use std::error::Error;
use std::sync::Arc;
use std::time::{Duration, Instant};

use nalgebra::{Isometry3, Matrix4, Point3, Vector3};
use rcs_render::{GpuRenderer, GpuStats, Renderer, View};
use rcs_scene::{
    Camera, DisplayMask, Drawable, Encoding, Geometry, Image, Intrinsics, PackedColors, PackedPoints, PointBuffer,
    PointColors, PointLook, PointStyle, PositionLayout, RenderGroup, Scene, SharedBytes,
};

const SIZE_PX: [u32; 2] = [1280, 800];
const FOCAL_PX: f64 = 1100.0;

/// The scene that is drawn repeatedly.
#[derive(Clone, Copy, PartialEq)]
enum Content {
    Nothing,
    OneCloud,
    NewClouds,
    PackedClouds,
}

/// How each style is drawn.
fn look(style: PointStyle) -> PointLook {
    PointLook { style, alpha: 1.0, blended: false, auto_size: false }
}

/// A wavy surface about a metre away that fills the image. A new one each time: the phase tells them apart.
fn cloud(points: usize, phase: f64) -> PointBuffer {
    let columns = ((points as f64 * 1.6).sqrt().ceil() as usize).max(1);
    let rows = points.div_ceil(columns).max(1);
    let place = |i: usize| {
        let x = ((i % columns) as f64 / columns as f64 - 0.5) * f64::from(SIZE_PX[0]) / FOCAL_PX;
        let y = ((i / columns) as f64 / rows as f64 - 0.5) * f64::from(SIZE_PX[1]) / FOCAL_PX;
        let z = 1.0 + 0.15 * (6.0 * x + phase).sin() * (5.0 * y).cos();
        [(x * z) as f32, (y * z) as f32, z as f32]
    };
    let colors = (0..points).map(|i| [(i % columns % 256) as u8, (i / columns % 256) as u8, 90, 255]).collect();
    PointBuffer { positions: (0..points).map(place).collect(), colors: PointColors::PerPoint(colors) }
}

/// A cloud as the bytes of a message: x, y, z and rgb.
fn bytes(cloud: &PointBuffer) -> Vec<u8> {
    let point = |(i, position): (usize, &[f32; 3])| {
        let [r, g, b, _] = cloud.colors.get(i);
        let [x, y, z] = position.map(f32::to_le_bytes);
        [x, y, z, [b, g, r, 0]]
    };
    cloud.positions.iter().enumerate().flat_map(point).flatten().collect()
}

fn packed(bytes: &Arc<Vec<u8>>, style: PointStyle) -> Option<Geometry> {
    let layout = PositionLayout::new([0, 4, 8]);
    let colors = PackedColors::Rgb { offset: 12 };
    PackedPoints::new(Arc::clone(bytes) as SharedBytes, 16, layout, colors, look(style))
        .map(Arc::new)
        .map(Geometry::Packed)
}

fn scene(geometry: Geometry) -> Scene {
    let drawable = Drawable {
        display: 0,
        fixed_from_object: Matrix4::identity(),
        sort_point: Point3::origin(),
        group: RenderGroup::Main,
        geometry,
    };
    Scene { drawables: vec![drawable], light: None }
}

fn camera(turn_rad: f64) -> Result<Camera, Box<dyn Error>> {
    let [width, height] = SIZE_PX;
    let (cx, cy) = (f64::from(width) / 2.0, f64::from(height) / 2.0);
    let p = [FOCAL_PX, 0.0, cx, 0.0, 0.0, FOCAL_PX, cy, 0.0, 0.0, 0.0, 1.0, 0.0];
    let pose = Isometry3::new(Vector3::zeros(), Vector3::new(0.0, turn_rad, 0.0));
    Ok(Camera::new(Intrinsics::from_p(width, height, &p)?, &pose, 0.01))
}

/// Time for drawing `images` images, `in_flight` of them at a time.
fn draw(
    renderer: &mut GpuRenderer,
    images: usize,
    in_flight: usize,
    mut next: impl FnMut(usize) -> Result<(Scene, Camera), Box<dyn Error>>,
) -> Result<Duration, Box<dyn Error>> {
    let mut image = Image::default();
    let visible = DisplayMask::all();
    let mut drawing = Duration::ZERO;
    for i in 0..images + in_flight - 1 {
        // The scene is made outside of the timing.
        let wanted = if i < images { Some(next(i)?) } else { None };
        let start = Instant::now();
        if let Some((scene, camera)) = &wanted {
            let view = View { scene, camera, visible: &visible, background: [0; 3], encoding: Encoding::Rgb8 };
            renderer.submit(&view)?;
        }
        if i + 1 >= in_flight {
            let _ = renderer.finish(&mut image)?;
        }
        drawing += start.elapsed();
    }
    Ok(drawing)
}

/// A line of the table.
fn report(name: &str, in_flight: usize, images: usize, took: Duration, before: &GpuStats, after: &GpuStats) {
    let ms = |time: Duration| time.as_secs_f64() * 1e3 / images as f64;
    let steps = [
        ("prepare", ms(after.prepare - before.prepare)),
        ("submit", ms(after.submit - before.submit)),
        ("wait", ms(after.wait - before.wait)),
        ("copy", ms(after.copy - before.copy)),
    ];
    let longest = steps.iter().max_by(|a, b| a.1.total_cmp(&b.1)).map_or("", |step| step.0);
    let steps = steps.map(|(_, ms)| format!("{ms:9.2}")).join("");
    let rate = images as f64 / took.as_secs_f64();
    println!("{name:34}{in_flight:10}{rate:12.1}{steps}  {longest}");
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut numbers = std::env::args().filter_map(|argument| argument.parse::<usize>().ok());
    let points = numbers.next().unwrap_or(3_000_000);
    let images = numbers.next().unwrap_or(100).max(1);
    let opening = Instant::now();
    let mut renderer = GpuRenderer::new(false)?;
    println!(
        "{}, opened in {:.0} ms; {points} points, {} × {} rgb8, {images} pictures, {} threads",
        renderer.describe(),
        opening.elapsed().as_secs_f64() * 1e3,
        SIZE_PX[0],
        SIZE_PX[1],
        std::thread::available_parallelism().map_or(1, usize::from)
    );
    println!(
        "{:34}{:>10}{:>12}{:>9}{:>9}{:>9}{:>9}  longest",
        "ms a picture", "in flight", "pictures/s", "prepare", "submit", "wait", "copy"
    );
    // A point is as wide as the gap to the next one, and at least a pixel.
    let gap_px = (f64::from(SIZE_PX[0]) * f64::from(SIZE_PX[1]) / points.max(1) as f64).sqrt().max(1.0);
    let flat = PointStyle::FlatSquares { side_m: (gap_px / FOCAL_PX) as f32 };
    let round = PointStyle::Points { diameter_px: 3.0 };
    let clouds = [0.0, 1.0, 2.0].map(|phase| Arc::new(cloud(points, phase)));
    let messages = clouds.each_ref().map(|cloud| Arc::new(bytes(cloud)));
    let packing = Instant::now();
    let _ = packed(&messages[0], flat);
    println!("packing a cloud: {:.2} ms", packing.elapsed().as_secs_f64() * 1e3);
    for (name, content, style) in [
        ("empty", Content::Nothing, flat),
        ("Flat Squares", Content::OneCloud, flat),
        ("Flat Squares, each a new cloud", Content::NewClouds, flat),
        ("Flat Squares, each a packed cloud", Content::PackedClouds, flat),
        ("Points 3 px", Content::OneCloud, round),
        ("Points 3 px, each a new cloud", Content::NewClouds, round),
        ("Points 3 px, each a packed cloud", Content::PackedClouds, round),
    ] {
        for in_flight in [1, 2] {
            let next = |i: usize| {
                let scene = match content {
                    Content::Nothing => Scene::default(),
                    Content::OneCloud => scene(Geometry::Points(look(style).of(Arc::clone(&clouds[0])))),
                    Content::NewClouds => {
                        let cloud = Arc::new(PointBuffer::clone(&clouds[i % clouds.len()]));
                        scene(Geometry::Points(look(style).of(cloud)))
                    }
                    Content::PackedClouds => scene(packed(&messages[i % messages.len()], style).ok_or("not packed")?),
                };
                Ok((scene, camera(0.001 * (i % 100) as f64)?))
            };
            draw(&mut renderer, 2, in_flight, next)?;
            let before = renderer.stats();
            let took = draw(&mut renderer, images, in_flight, next)?;
            let after = renderer.stats();
            report(name, in_flight, images, took, &before, &after);
            check(content, images, &before, &after);
        }
    }
    Ok(())
}

/// Asserts that nothing is uploaded or built twice.
fn check(content: Content, images: usize, before: &GpuStats, after: &GpuStats) {
    let uploads = after.uploads - before.uploads;
    if after.pipelines != before.pipelines || after.targets != before.targets {
        println!("  pipelines or targets were made on the way: {after:?}");
    }
    if matches!(content, Content::NewClouds | Content::PackedClouds) != (uploads >= images as u64) {
        println!("  {uploads} uploads for {images} pictures");
    }
}
