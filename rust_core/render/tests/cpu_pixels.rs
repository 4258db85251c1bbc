//! Pixels of small scenes on the CPU renderer, by the numbers that rviz's shaders and OpenGL's rules give.
//!
//! The camera sees 100 by 100 pixels and stands in the fixed frame's origin, so that at a distance of 1 m a pixel is
//! a centimetre and (0, 0) is the corner where the four middle pixels meet. `gpu_cpu.rs` compares the GPU with it.
#![allow(clippy::unwrap_used, reason = "a test may stop here")]

mod common;

use std::sync::Arc;

use common::{at, camera, draw, lit_pixels, pixel, points, scene, square_mesh};
use nalgebra::Matrix4;
use rcs_render::{CpuRenderer, Renderer, View};
use rcs_scene::{
    Blending, DisplayMask, Drawable, Encoding, Geometry, HorizontalAlignment, Image, LineTopology, Lines, Material,
    PointStyle, Points, Rgba, Text, VerticalAlignment,
};

const RED: [u8; 4] = [200, 100, 0, 255];
const FLAT: PointStyle = PointStyle::FlatSquares { side_m: 0.04 };

fn pixels(drawables: impl IntoIterator<Item = Drawable>) -> Image {
    draw(&mut CpuRenderer::with_threads(2), &scene(drawables), &camera(100, 100, 100.0))
}

/// A cloud of one point.
fn point(style: PointStyle, position: [f32; 3], color: [u8; 4]) -> Drawable {
    at(0.0, 0.0, 0.0, Geometry::Points(points(style, color, &[position])))
}

/// A grey square in front of the camera.
fn wall(half_m: f64, distance_m: f64, level: u8) -> Drawable {
    let mut mesh = square_mesh();
    mesh.vertices.iter_mut().for_each(|vertex| vertex.color = [level, level, level, 255]);
    let material = Arc::new(Material::unlit(false));
    let mut wall = at(0.0, 0.0, distance_m, Geometry::Mesh { mesh: Arc::new(mesh), material });
    wall.fixed_from_object *= Matrix4::new_scaling(2.0 * half_m);
    wall
}

/// The pixels from (46, 46) to (53, 53), a letter each: `.` for the background, `#` for anything else.
fn middle(image: &Image) -> Vec<String> {
    (46..54).map(|y| (46..54).map(|x| if pixel(image, x, y) == [0; 3] { '.' } else { '#' }).collect()).collect()
}

#[test]
fn a_point_is_a_disc_of_pixels() {
    let image = pixels([point(PointStyle::Points { diameter_px: 4.0 }, [0.0, 0.0, 1.0], RED)]);
    let expected = ["........", "........", "...##...", "..####..", "..####..", "...##...", "........", "........"];
    assert_eq!(middle(&image), expected);
    assert_eq!(pixel(&image, 50, 50), [200, 100, 0]);
}

#[test]
fn a_flat_square_covers_its_side_in_pixels() {
    let image = pixels([point(FLAT, [0.0, 0.0, 1.0], RED)]);
    let expected = ["........", "........", "..####..", "..####..", "..####..", "..####..", "........", "........"];
    assert_eq!(middle(&image), expected);
    assert_eq!(pixel(&image, 48, 51), [200, 100, 0]);
    let smaller = pixels([point(FLAT, [0.0, 0.0, 2.0], RED)]);
    assert_eq!(lit_pixels(&smaller).len(), 4);
}

#[test]
fn tiles_are_seen_from_both_sides() {
    for normal in [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]] {
        let style = PointStyle::Tiles { size_m: [0.2, 0.1], normal, up: [0.0, 1.0, 0.0] };
        let image = pixels([point(style, [0.0, 0.0, 1.0], RED)]);
        assert_eq!(lit_pixels(&image).len(), 200);
        assert_eq!(pixel(&image, 50, 50), [200, 100, 0]);
    }
}

#[test]
fn a_line_has_one_pixel_a_step_and_blends_once() {
    let line = |a: [f32; 3], b: [f32; 3], blending: Blending| {
        let lines =
            Lines { positions: vec![a, b], colors: vec![[200, 100, 0, 127]], topology: LineTopology::List, blending };
        pixels([at(0.0, 0.0, 0.0, Geometry::Lines(Arc::new(lines)))])
    };
    let flat = line([-0.1, 0.005, 1.0], [0.1, 0.005, 1.0], Blending::Replace);
    assert_eq!(
        (lit_pixels(&flat).len(), pixel(&flat, 40, 50), pixel(&flat, 59, 50)),
        (20, [200, 100, 0], [200, 100, 0])
    );
    let diagonal = line([-0.1, -0.1, 1.0], [0.1, 0.1, 1.0], Blending::Alpha);
    assert_eq!(lit_pixels(&diagonal).len(), 20);
    assert_eq!(pixel(&diagonal, 45, 45), [100, 50, 0]);
    let through = line([0.0, 0.005, -1.0], [0.0, 0.005, 1.0], Blending::Replace);
    assert!(lit_pixels(&through).len() >= 49, "{}", lit_pixels(&through).len());
}

#[test]
fn joined_lines_draw_their_common_pixel_once() {
    let lines = Lines {
        positions: vec![[-0.105, 0.005, 1.0], [0.005, 0.005, 1.0], [0.105, 0.055, 1.0]],
        colors: vec![[200, 100, 0, 127]],
        topology: LineTopology::Strip,
        blending: Blending::Alpha,
    };
    let image = pixels([at(0.0, 0.0, 0.0, Geometry::Lines(Arc::new(lines)))]);
    assert!((0..100).flat_map(|y| (0..100).map(move |x| (x, y))).all(|(x, y)| pixel(&image, x, y)[0] <= 100));
    assert_eq!(pixel(&image, 50, 50), [100, 50, 0]);
}

#[test]
fn text_stands_before_a_wall_of_the_same_depth() {
    let text = |on_top: bool| {
        let text = Text::new("HHH", 0.3, Rgba::WHITE, (HorizontalAlignment::Center, VerticalAlignment::Center));
        at(0.0, 0.0, 1.0, Geometry::Text(Arc::new(if on_top { text.on_top() } else { text })))
    };
    let white = |drawables: [Drawable; 2]| {
        let image = pixels(drawables);
        lit_pixels(&image).iter().filter(|&&(x, y)| pixel(&image, x, y)[0] > 200).count()
    };
    assert!(white([wall(1.0, 1.0, 9), text(false)]) > 50);
    assert_eq!(white([wall(1.0, 0.99, 9), text(false)]), 0);
    assert!(white([wall(1.0, 0.99, 9), text(true)]) > 50);
}

#[test]
fn the_display_that_costs_most_is_known() {
    let tiles = |side_m: f32, count: usize| {
        let positions: Vec<[f32; 3]> = (0..count).map(|i| [0.0, 0.0, 1.0 + i as f32 * 1e-3]).collect();
        let points = points(PointStyle::FlatSquares { side_m }, [255, 0, 0, 128], &positions);
        at(0.0, 0.0, 0.0, Geometry::Points(Points { alpha: 0.5, blended: true, ..points }))
    };
    // The second covers the image a hundred times.
    let drawables = [(3, tiles(0.02, 1)), (5, tiles(6.0, 100)), (7, wall(0.01, 0.5, 255))];
    let scene = scene(drawables.map(|(display, drawable)| Drawable { display, ..drawable }));
    let (camera, visible) = (camera(320, 240, 100.0), DisplayMask::all());
    let mut renderer = CpuRenderer::with_threads(2);
    assert_eq!(renderer.costs(), [], "nothing was drawn");
    let view = View { scene: &scene, camera: &camera, visible: &visible, background: [0; 3], encoding: Encoding::Rgb8 };
    renderer.render(&view, &mut Image::default()).unwrap();
    let mut costs = renderer.costs();
    costs.sort_by_key(|(_, cost)| std::cmp::Reverse(*cost));
    let displays: Vec<_> = costs.iter().map(|(display, _)| *display).collect();
    assert_eq!((displays.len(), displays[0]), (3, 5), "{costs:?}");
    assert!(costs[0].1 > 10 * costs[1].1, "{costs:?}");
}
