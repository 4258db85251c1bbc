//! Pixels of small scenes on the CPU renderer, by the numbers that rviz's shaders and OpenGL's rules give.
//!
//! The camera sees 100 by 100 pixels and stands in the fixed frame's origin, so that at a distance of 1 m a pixel is
//! a centimetre and (0, 0) is the corner where the four middle pixels meet.

mod cpu_common;

use std::sync::Arc;

use cpu_common::{camera, cloud, drawable, pixels, quad, render, Grid};
use nalgebra::{Matrix4, Vector3};
use rcs_render::{CpuRenderer, Renderer, View};
use rcs_scene::{
    Blending, CullMode, DirectionalLight, DisplayMask, Drawable, Encoding, Filtering, Geometry, HorizontalAlignment,
    Image, LineTopology, Lines, Material, Mesh, PointStyle, RenderGroup, Rgba, RibbonElement, Ribbons, Scene, Text,
    Texture, VerticalAlignment, Wrapping,
};

const RED: [u8; 4] = [200, 100, 0, 255];
const FLAT: PointStyle = PointStyle::FlatSquares { side_m: 0.04 };

fn scene(geometries: Vec<Geometry>) -> Scene {
    Scene { drawables: geometries.into_iter().map(drawable).collect(), light: None }
}

/// The lit pixels' red channel from (46, 46) to (53, 53), a letter each: `.` for the background, `#` for anything else.
fn middle(image: &Grid) -> Vec<String> {
    (46..54).map(|y| (46..54).map(|x| if image.at(x, y) == [0, 0, 0] { '.' } else { '#' }).collect()).collect()
}

#[test]
fn a_point_is_a_disc_of_pixels() {
    let image = pixels(&scene(vec![cloud(PointStyle::Points { diameter_px: 4.0 }, &[[0.0, 0.0, 1.0]], RED)]));
    let expected = ["........", "........", "...##...", "..####..", "..####..", "...##...", "........", "........"];
    assert_eq!(middle(&image), expected);
    assert_eq!(image.at(50, 50), [200, 100, 0]);
}

#[test]
fn a_point_of_one_pixel_can_miss_every_pixel() {
    let at = |x: f32, y: f32| {
        let scene = scene(vec![cloud(PointStyle::Points { diameter_px: 1.0 }, &[[x, y, 1.0]], RED)]);
        pixels(&scene).lit()
    };
    assert_eq!(at(0.005, 0.005), 1);
    assert_eq!(at(0.0, 0.0), 0);
}

#[test]
fn a_point_outside_of_the_image_is_dropped_whole() {
    let style = PointStyle::Points { diameter_px: 20.0 };
    assert_eq!(pixels(&scene(vec![cloud(style, &[[0.501, 0.0, 1.0]], RED)])).lit(), 0);
    assert!(pixels(&scene(vec![cloud(style, &[[0.499, 0.0, 1.0]], RED)])).lit() > 100);
    assert_eq!(
        pixels(&scene(vec![cloud(style, &[[0.0, 0.0, 0.009], [0.0, 0.0, 101.0], [0.0, 0.0, -1.0]], RED)])).lit(),
        0
    );
}

#[test]
fn a_flat_square_covers_its_side_in_pixels() {
    let image = pixels(&scene(vec![cloud(FLAT, &[[0.0, 0.0, 1.0]], RED)]));
    let expected = ["........", "........", "..####..", "..####..", "..####..", "..####..", "........", "........"];
    assert_eq!(middle(&image), expected);
    assert_eq!(image.at(48, 51), [200, 100, 0]);
    let smaller = pixels(&scene(vec![cloud(FLAT, &[[0.0, 0.0, 2.0]], RED)]));
    assert_eq!(smaller.lit(), 4);
}

#[test]
fn a_cloud_is_culled_when_all_its_points_are_off_one_side() {
    let large = PointStyle::FlatSquares { side_m: 0.4 };
    let off = [[0.6, 0.0, 1.0], [0.55, 0.3, 1.0]];
    assert_eq!(pixels(&scene(vec![cloud(large, &off, RED)])).lit(), 0);
    let around = [[0.6, 0.0, 1.0], [-0.6, 0.0, 1.0]];
    assert!(pixels(&scene(vec![cloud(large, &around, RED)])).lit() > 500);
}

#[test]
fn a_flat_square_turns_with_the_clouds_frame() {
    let mut turned = drawable(cloud(PointStyle::FlatSquares { side_m: 0.2 }, &[[0.0, 0.0, 1.0]], RED));
    turned.fixed_from_object = Matrix4::new_rotation(Vector3::new(0.0, 0.0, std::f64::consts::FRAC_PI_4));
    let image = pixels(&Scene { drawables: vec![turned], light: None });
    assert_eq!((image.at(50, 37), image.at(50, 35)), ([200, 100, 0], [0, 0, 0]));
    assert_eq!((image.at(58, 41), image.at(42, 58)), ([0, 0, 0], [0, 0, 0]));
}

#[test]
fn a_square_has_a_contrasting_edge() {
    let style = PointStyle::Squares { size_m: [0.2, 0.2] };
    let image = pixels(&scene(vec![cloud(style, &[[0.0, 0.0, 1.0]], RED)]));
    // The outermost pixel's centre lies 0.475 sides from the middle: 0.926 of the full contrast of 51 levels.
    assert_eq!(image.at(40, 50), [153, 53, 0]);
    assert_eq!((image.at(41, 50), image.at(39, 50)), ([200, 100, 0], [0, 0, 0]));
    let dark = pixels(&scene(vec![cloud(style, &[[0.0, 0.0, 1.0]], [20, 10, 0, 255])]));
    assert_eq!(dark.at(40, 50), [67, 57, 47]);
}

#[test]
fn a_sphere_is_a_shaded_disc() {
    let style = PointStyle::Spheres { size_m: [0.04, 0.04] };
    let image = pixels(&scene(vec![cloud(style, &[[0.0, 0.0, 1.0]], RED)]));
    let expected = ["........", "........", "...##...", "..####..", "..####..", "...##...", "........", "........"];
    assert_eq!(middle(&image), expected);
    assert_eq!(image.at(50, 50), [195, 98, 0]);
}

#[test]
fn a_box_shows_the_side_that_faces_the_eye() {
    let style = PointStyle::Boxes { size_m: [0.2, 0.1, 0.02] };
    let image = pixels(&scene(vec![cloud(style, &[[0.0, 0.0, 1.01]], RED)]));
    // That is the −z side, half as bright.
    assert_eq!(image.at(50, 50), [100, 50, 0]);
    assert_eq!((image.at(40, 50), image.at(50, 45)), ([54, 27, 0], [100, 50, 0]));
    assert_eq!((image.at(39, 50), image.at(50, 44)), ([0, 0, 0], [0, 0, 0]));
}

#[test]
fn tiles_are_seen_from_both_sides() {
    for normal in [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]] {
        let style = PointStyle::Tiles { size_m: [0.2, 0.1], normal, up: [0.0, 1.0, 0.0] };
        let image = pixels(&scene(vec![cloud(style, &[[0.0, 0.0, 1.0]], RED)]));
        assert_eq!(image.lit(), 200);
        assert_eq!(image.at(50, 50), [200, 100, 0]);
    }
}

#[test]
fn auto_size_multiplies_by_the_points_z() {
    let Geometry::Points(mut points) = cloud(FLAT, &[[0.0, 0.0, 2.0]], RED) else { unreachable!() };
    points.auto_size = true;
    assert_eq!(pixels(&scene(vec![Geometry::Points(points)])).lit(), 16);
}

#[test]
fn faint_points_are_dropped_and_translucent_ones_blend() {
    let with = |alpha: f32, color: [u8; 4]| {
        let Geometry::Points(mut points) = cloud(FLAT, &[[0.0, 0.0, 1.0], [0.0, 0.0, 1.5]], color) else {
            unreachable!()
        };
        (points.alpha, points.blended) = (alpha, true);
        pixels(&scene(vec![Geometry::Points(points)]))
    };
    assert_eq!(with(0.0019, RED).lit(), 0);
    assert_eq!(with(0.003, RED).lit(), 16);
    assert_eq!(with(1.0, [200, 100, 0, 0]).lit(), 0);
    // The farther one comes second and is not hidden.
    assert_eq!(with(0.5, RED).at(50, 50), [150, 75, 0]);
    assert_eq!(with(0.5, RED).at(48, 48), [100, 50, 0]);
}

#[test]
fn of_two_equally_far_the_later_is_seen() {
    let blue = [0, 0, 255, 255];
    let at = [[0.0, 0.0, 1.0]];
    let image = pixels(&scene(vec![cloud(FLAT, &at, RED), cloud(FLAT, &at, blue)]));
    assert_eq!(image.at(50, 50), [0, 0, 255]);
    let image = pixels(&scene(vec![cloud(FLAT, &at, RED), cloud(FLAT, &[[0.0, 0.0, 1.001]], blue)]));
    assert_eq!(image.at(50, 50), [200, 100, 0]);
}

#[test]
fn groups_are_drawn_one_after_another_and_hidden_displays_not() {
    let mut behind = drawable(quad(0.1, 0.5, Material::unlit(false), [1, 2, 3, 255]));
    behind.group = RenderGroup::Behind;
    let mut hidden = drawable(quad(0.1, 0.4, Material::unlit(false), [9, 9, 9, 255]));
    hidden.display = 7;
    let scene = Scene { drawables: vec![drawable(cloud(FLAT, &[[0.0, 0.0, 0.5]], RED)), behind, hidden], light: None };
    let mut visible = DisplayMask::all();
    visible.set(7, false);
    let image = render(&scene, &camera(100, 100), &visible, Encoding::Rgb8, 2);
    assert_eq!(Grid::of(&image).at(50, 50), [200, 100, 0]);
}

#[test]
fn a_mesh_is_lit_by_the_cosine_and_culled_from_behind() {
    let mut material = Material::lit(Rgba::new(1.0, 0.5, 0.0, 1.0));
    let light = Some(DirectionalLight { direction: Vector3::new(0.0, 0.6, 0.8) });
    let draw = |material: &Material| {
        let scene = Scene { drawables: vec![drawable(quad(0.1, 1.0, material.clone(), [255; 4]))], light };
        pixels(&scene).at(50, 50)
    };
    assert_eq!(draw(&material), [204, 102, 0]);
    material.cull = CullMode::Front;
    assert_eq!(draw(&material), [0, 0, 0]);
}

#[test]
fn a_mirrored_mesh_keeps_its_outside() {
    let draw = |x: f64, y: f64, z: f64| {
        let mut scaled = drawable(quad(0.1, 1.0, Material::unlit(false), RED));
        scaled.fixed_from_object = Matrix4::new_nonuniform_scaling(&Vector3::new(x, y, z));
        pixels(&Scene { drawables: vec![scaled], light: None }).lit()
    };
    assert_eq!(draw(-1.0, 1.0, 1.0), 400);
    assert_eq!(draw(-1.0, -1.0, 1.0), 400);
    assert_eq!(draw(-1.0, 1.0, -1.0), 0, "behind the eye");
}

#[test]
fn a_texture_is_multiplied_with_the_colour() {
    let texture = Texture {
        width: 2,
        height: 2,
        rgba: vec![[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 255, 255]],
        filtering: Filtering::Nearest,
        wrapping: Wrapping::Repeat,
    };
    let material = Material { texture: Some(Arc::new(texture)), ..Material::unlit(false) };
    let image = pixels(&scene(vec![quad(0.1, 1.0, material, [100, 200, 50, 255])]));
    assert_eq!((image.at(45, 45), image.at(55, 45)), ([100, 0, 0], [0, 200, 0]));
    assert_eq!((image.at(45, 55), image.at(55, 55)), ([0, 0, 50], [100, 200, 50]));
}

#[test]
fn a_mesh_through_the_eyes_plane_is_cut_there() {
    let floor = Mesh {
        vertices: [[-1.0, 0.1, -1.0], [1.0, 0.1, -1.0], [1.0, 0.1, 3.0], [-1.0, 0.1, 3.0]]
            .map(|position| rcs_scene::Vertex { color: RED, ..rcs_scene::Vertex::new(position, [0.0; 3]) })
            .to_vec(),
        indices: vec![0, 1, 2, 0, 2, 3],
    };
    let material = Arc::new(Material { cull: CullMode::None, ..Material::unlit(false) });
    let image = pixels(&scene(vec![Geometry::Mesh { mesh: Arc::new(floor), material }]));
    assert_eq!((image.at(50, 52), image.at(50, 54)), ([0, 0, 0], [200, 100, 0]));
    assert!((0..100).all(|x| image.at(x, 99) == [200, 100, 0]));
}

#[test]
fn a_line_has_one_pixel_a_step_and_blends_once() {
    let line = |a: [f32; 3], b: [f32; 3], blending: Blending| {
        let lines =
            Lines { positions: vec![a, b], colors: vec![[200, 100, 0, 127]], topology: LineTopology::List, blending };
        pixels(&scene(vec![Geometry::Lines(Arc::new(lines))]))
    };
    let flat = line([-0.1, 0.005, 1.0], [0.1, 0.005, 1.0], Blending::Replace);
    assert_eq!((flat.lit(), flat.at(40, 50), flat.at(59, 50)), (20, [200, 100, 0], [200, 100, 0]));
    let diagonal = line([-0.1, -0.1, 1.0], [0.1, 0.1, 1.0], Blending::Alpha);
    assert_eq!(diagonal.lit(), 20);
    assert_eq!(diagonal.at(45, 45), [100, 50, 0]);
    let through = line([0.0, 0.005, -1.0], [0.0, 0.005, 1.0], Blending::Replace);
    assert!(through.lit() >= 49, "{}", through.lit());
}

#[test]
fn joined_lines_draw_their_common_pixel_once() {
    let lines = Lines {
        positions: vec![[-0.105, 0.005, 1.0], [0.005, 0.005, 1.0], [0.105, 0.055, 1.0]],
        colors: vec![[200, 100, 0, 127]],
        topology: LineTopology::Strip,
        blending: Blending::Alpha,
    };
    let image = pixels(&scene(vec![Geometry::Lines(Arc::new(lines))]));
    assert!((0..100).flat_map(|y| (0..100).map(move |x| (x, y))).all(|(x, y)| image.at(x, y)[0] <= 100));
    assert_eq!(image.at(50, 50), [100, 50, 0]);
}

#[test]
fn a_ribbon_has_its_width_in_metres() {
    let element = |x: f32| RibbonElement { position: [x, 0.0, 1.0], color: RED };
    let ribbons =
        Ribbons { chains: vec![vec![element(-0.1), element(0.1)]], width_m: 0.04, blending: Blending::Replace };
    let image = pixels(&scene(vec![Geometry::Ribbons(Arc::new(ribbons))]));
    assert_eq!(image.lit(), 20 * 4);
    assert_eq!(image.at(45, 51), [200, 100, 0]);
}

#[test]
fn text_stands_before_a_wall_of_the_same_depth() {
    let alignment = (HorizontalAlignment::Center, VerticalAlignment::Center);
    let text = |on_top: bool| {
        let text = Text::new("HHH", 0.3, Rgba::WHITE, alignment);
        let mut text = drawable(Geometry::Text(Arc::new(if on_top { text.on_top() } else { text })));
        text.fixed_from_object = Matrix4::new_translation(&Vector3::new(0.0, 0.0, 1.0));
        text
    };
    let wall = |distance_m: f32| drawable(quad(1.0, distance_m, Material::unlit(false), [9, 9, 9, 255]));
    let white = |drawables| {
        let image = pixels(&Scene { drawables, light: None });
        (0..10_000).filter(|i| image.at(i % 100, i / 100)[0] > 200).count()
    };
    assert!(white(vec![wall(1.0), text(false)]) > 50);
    assert_eq!(white(vec![wall(0.99), text(false)]), 0);
    assert!(white(vec![wall(0.99), text(true)]) > 50);
}

#[test]
fn every_encoding_shows_the_same_image() {
    let scene = scene(vec![cloud(FLAT, &[[0.0, 0.0, 1.0]], RED)]);
    for encoding in Encoding::ALL {
        let image = render(&scene, &camera(100, 100), &DisplayMask::all(), encoding, 2);
        assert_eq!((image.width_px, image.height_px, image.encoding), (100, 100, encoding));
        assert_eq!(image.data.len(), 10_000 * encoding.bytes_per_pixel());
        let red_at = match encoding {
            Encoding::Bgr8 | Encoding::Bgra8 => 2,
            _ => 0,
        };
        let at = (50 * 100 + 50) * encoding.bytes_per_pixel() + red_at;
        assert_eq!(image.data[at], 200, "{encoding:?}");
    }
}

#[test]
fn the_display_that_costs_most_is_known() {
    let tiles = |half_m: f32, count: usize| {
        let positions: Vec<[f32; 3]> = (0..count).map(|i| [0.0, 0.0, 1.0 + i as f32 * 1e-3]).collect();
        let mut points = match cloud(PointStyle::FlatSquares { side_m: 2.0 * half_m }, &positions, [255, 0, 0, 128]) {
            Geometry::Points(points) => points,
            _ => unreachable!(),
        };
        (points.alpha, points.blended) = (0.5, true);
        Geometry::Points(points)
    };
    // The second covers the image a hundred times.
    let drawables = [(3, tiles(0.01, 1)), (5, tiles(3.0, 100)), (7, quad(0.01, 0.5, Material::unlit(false), [255; 4]))];
    let drawables = drawables.map(|(display, geometry)| Drawable { display, ..drawable(geometry) });
    let scene = Scene { drawables: drawables.into(), light: None };
    let (camera, visible) = (camera(320, 240), DisplayMask::all());
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
