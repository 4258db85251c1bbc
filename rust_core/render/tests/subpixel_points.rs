//! Points below one pixel: both renderers light as many pixels as rviz does.
//!
//! The figures are rviz 1.14's on Mesa's software rasteriser without anti-aliasing: a cloud of 2400 points, scattered
//! over the pixels, in a top-down view of 100 pixels a metre, drawn in one colour on black, and the pixels of the
//! screenshot counted. The sizes of `Style: Points` below one pixel went to rviz's `PointCloud::setDimensions` past the
//! property's minimum of 1. rviz lit as many pixels for sizes of 0.9, 0.5, 0.3, 0.05, 0 and −2 pixels as for 1, because
//! OpenGL draws no smaller point; of what has its size in metres it lit as many pixels as the faces' areas hold.

mod common;

use common::{at, camera, draw, lit_pixels, points, scene};
use rcs_render::{CpuRenderer, GpuRenderer, Renderer};
use rcs_scene::{Geometry, PointStyle};

/// Points on a side of the test's cloud, a pixel's size at their distance, and from point to point in pixels.
const SIDE: u16 = 49;
const PIXEL_M: f32 = 0.01;
const SPACING_PX: f32 = 8.0;

/// So far away that the perspective view is nearly a parallel one.
const DISTANCE_M: f64 = 20.0;

/// rviz's points. The share of 2400 randomly placed ones has a standard deviation of up to 0.009.
const RVIZ_POINTS: f64 = 2400.0;
const TOLERANCE: f64 = 0.02;

/// Style, and the pixels that rviz lit.
fn measured() -> Vec<(PointStyle, u32)> {
    let round = |diameter_px| (PointStyle::Points { diameter_px }, 1890);
    let half_px = PIXEL_M * 0.5;
    let mut measured: Vec<_> = [1.0, 0.9, 0.5, 0.3, 0.05, 0.0, -2.0].map(round).into();
    measured.extend([
        (PointStyle::Points { diameter_px: 1.5 }, 4275),
        (PointStyle::FlatSquares { side_m: half_px }, 589),
        (PointStyle::Squares { size_m: [half_px; 2] }, 589),
        (PointStyle::Spheres { size_m: [half_px; 2] }, 459),
        (PointStyle::Spheres { size_m: [PIXEL_M * 0.2; 2] }, 70),
        // Flat, so that a perspective view shows no other side than the top-down one.
        (PointStyle::Boxes { size_m: [half_px, half_px, 0.0] }, 589),
    ]);
    measured
}

/// The lit pixels a point, over a cloud whose points lie in the pixels as evenly as may be.
fn lit_share(renderer: &mut dyn Renderer, style: PointStyle) -> f64 {
    // Coordinates from the middle: each row and column of points lies elsewhere in its pixels.
    let place = |i: u16| (f32::from(i) - f32::from(SIDE / 2)) * (SPACING_PX + 1.0 / f32::from(SIDE)) * PIXEL_M;
    let positions: Vec<[f32; 3]> = (0..SIDE * SIDE).map(|i| [place(i % SIDE), place(i / SIDE), 0.0]).collect();
    let cloud = Geometry::Points(points(style, [255, 0, 0, 255], &positions));
    let image = draw(renderer, &scene([at(0.0, 0.0, DISTANCE_M, cloud)]), &camera(500, 500, DISTANCE_M * 100.0));
    lit_pixels(&image).len() as f64 / positions.len() as f64
}

fn lights_as_many_pixels_as_rviz(renderer: &mut dyn Renderer) {
    for (style, pixels) in measured() {
        let (share, in_rviz) = (lit_share(renderer, style), f64::from(pixels) / RVIZ_POINTS);
        assert!((share - in_rviz).abs() < TOLERANCE, "{style:?}: {share} pixels a point, in rviz {in_rviz}");
    }
}

#[test]
fn the_cpu_lights_as_many_pixels_as_rviz() {
    lights_as_many_pixels_as_rviz(&mut CpuRenderer::new());
}

#[test]
fn the_gpu_lights_as_many_pixels_as_rviz() {
    lights_as_many_pixels_as_rviz(&mut GpuRenderer::new(false).expect("a GPU or Mesa's software Vulkan"));
}
