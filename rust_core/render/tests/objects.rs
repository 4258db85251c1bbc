//! Depths of what listed displays light, on both renderers: which fragment counts where several are in front of each
//! other. `gpu_cpu.rs` compares the renderers in random scenes.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod common;

use std::sync::Arc;

use common::{at, camera, points, scene, square_mesh};
use rcs_render::{create, DepthRequest, Depths, Finished, Renderer, RendererChoice, View};
use rcs_scene::{
    Blending, CellSheet, Cells, DepthImage, DisplayMask, Drawable, Encoding, Geometry, HorizontalAlignment, Image,
    Lighting, LineTopology, Lines, Material, PointStyle, Points, RenderGroup, Rgba, Scene, Text, VerticalAlignment,
};

const SIZE_PX: u32 = 40;
const CENTRE: usize = (SIZE_PX * SIZE_PX / 2 + SIZE_PX / 2) as usize;

/// A display whose depths are wanted, and another.
const LISTED: u32 = 1;
const OTHER: u32 = 2;

/// How far a depth may be off: some steps of a depth buffer, and the bias of text and cells.
const DEPTH_TOLERANCE_M: f32 = 2e-3;

fn square(display: u32, z: f64, material: Material) -> Drawable {
    let mesh = Arc::new(square_mesh());
    Drawable { display, ..at(0.0, 0.0, z, Geometry::Mesh { mesh, material: Arc::new(material) }) }
}

fn opaque(display: u32, z: f64) -> Drawable {
    square(display, z, Material::lit(Rgba::WHITE))
}

fn translucent(display: u32, z: f64, alpha: f32) -> Drawable {
    square(display, z, Material::lit(Rgba::new(1.0, 1.0, 1.0, alpha)).translucent(true))
}

fn renderers() -> [Box<dyn Renderer>; 2] {
    [RendererChoice::Cpu, RendererChoice::Gpu].map(|choice| create(choice).unwrap())
}

/// The image and the depths of a scene, whose image is the same without them.
fn drawn(renderer: &mut dyn Renderer, scene: &Scene) -> (Image, Depths) {
    let (camera, visible) = (camera(SIZE_PX, SIZE_PX, 60.0), DisplayMask::all());
    let mut listed = DisplayMask::all();
    listed.set(OTHER, false);
    let view = View { scene, camera: &camera, visible: &visible, background: [0; 3], encoding: Encoding::Mono8 };
    let request = DepthRequest { opaque: true, objects_of: Some(&listed) };
    renderer.submit_with_depths(&view, &request).unwrap();
    let (mut image, mut depths, mut alone) = (Image::default(), Depths::default(), Image::default());
    assert_eq!(renderer.finish_with_depths(&mut image, &mut depths).unwrap(), Finished::Drawn);
    renderer.render(&view, &mut alone).unwrap();
    assert_eq!(image, alone);
    // The one kind does not depend on the other.
    let mut only = Depths::default();
    renderer.submit_with_depths(&view, &DepthRequest { opaque: true, objects_of: None }).unwrap();
    assert_eq!(renderer.finish_with_depths(&mut alone, &mut only).unwrap(), Finished::Drawn);
    assert_eq!(bits(&only.opaque), bits(&depths.opaque));
    assert_eq!(only.objects, DepthImage::default(), "not wanted");
    (image, depths)
}

fn bits(depth: &DepthImage) -> Vec<u32> {
    depth.depths_m.iter().map(|depth_m| depth_m.to_bits()).collect()
}

/// Asserts the depth of the object in the middle of the image.
fn assert_object(what: &str, drawables: Vec<Drawable>, expected_m: Option<f32>) {
    let scene = scene(drawables);
    for mut renderer in renderers() {
        let (_, depths) = drawn(renderer.as_mut(), &scene);
        let depth_m = depths.objects.depths_m[CENTRE];
        let is_right = match expected_m {
            Some(expected_m) => (depth_m - expected_m).abs() < DEPTH_TOLERANCE_M,
            None => depth_m.is_nan(),
        };
        assert!(is_right, "{what}, {}: {depth_m}, not {expected_m:?}", renderer.describe());
    }
}

#[test]
fn an_opaque_face_hides_the_objects_behind_it() {
    assert_object("nothing", vec![], None);
    assert_object("alone", vec![opaque(LISTED, 2.0)], Some(2.0));
    assert_object("another display's alone", vec![opaque(OTHER, 2.0)], None);
    assert_object("before another", vec![opaque(LISTED, 2.0), opaque(OTHER, 3.0)], Some(2.0));
    assert_object("after another", vec![opaque(OTHER, 3.0), opaque(LISTED, 2.0)], Some(2.0));
    assert_object("behind another", vec![opaque(LISTED, 2.0), opaque(OTHER, 1.5)], None);
    assert_object("behind one of its own", vec![opaque(LISTED, 2.0), opaque(LISTED, 1.5)], Some(1.5));
    let above = Drawable { group: RenderGroup::Above, ..opaque(OTHER, 3.0) };
    assert_object("another above, but farther", vec![opaque(LISTED, 2.0), above], Some(2.0));
}

#[test]
fn a_translucent_face_is_an_object_and_another_displays_leaves_those_behind_it() {
    assert_object("before another", vec![opaque(OTHER, 2.0), translucent(LISTED, 1.5, 0.3)], Some(1.5));
    assert_object("behind another", vec![opaque(OTHER, 2.0), translucent(LISTED, 2.5, 0.3)], None);
    assert_object("without alpha", vec![opaque(LISTED, 2.0), translucent(LISTED, 1.5, 0.0)], Some(2.0));
    assert_object("another in front", vec![opaque(LISTED, 2.0), translucent(OTHER, 1.5, 0.5)], Some(2.0));
    assert_object("another that covers", vec![opaque(LISTED, 2.0), translucent(OTHER, 1.5, 1.0)], None);
    let several = vec![translucent(LISTED, 2.5, 0.5), translucent(LISTED, 1.5, 0.5), translucent(OTHER, 1.0, 0.5)];
    assert_object("several", several, Some(1.5));
}

#[test]
fn clouds_lines_and_cells_are_objects_too() {
    let styles = [
        PointStyle::Points { diameter_px: 9.0 },
        PointStyle::Squares { size_m: [0.3, 0.3] },
        PointStyle::FlatSquares { side_m: 0.3 },
        PointStyle::Spheres { size_m: [0.3, 0.3] },
        PointStyle::Boxes { size_m: [0.3, 0.3, 1e-4] },
        PointStyle::Tiles { size_m: [0.3, 0.3], normal: [0.0, 0.0, -1.0], up: [0.0, 1.0, 0.0] },
    ];
    for (style, blended) in styles.into_iter().flat_map(|style| [(style, false), (style, true)]) {
        let what = format!("{style:?}, blended: {blended}");
        let alpha = if blended { 0.4 } else { 1.0 };
        // Off the axis, along which some styles have no direction upwards.
        let cloud = Points { alpha, blended, ..points(style, [255; 4], &[[0.01, 0.01, 0.0]]) };
        let cloud = |display| Drawable { display, ..at(0.0, 0.0, 1.5, Geometry::Points(cloud.clone())) };
        assert_object(&what, vec![opaque(OTHER, 2.0), cloud(LISTED)], Some(1.5));
        assert_object(&what, vec![opaque(LISTED, 2.0), cloud(OTHER)], blended.then_some(2.0));
    }
    for blending in [Blending::Replace, Blending::Alpha] {
        let rows = (-4..4).flat_map(|row| [-1.0, 1.0].map(|x| [x, row as f32 * 0.02, 0.0]));
        let positions: Vec<[f32; 3]> = rows.collect();
        let colors = vec![[255, 255, 255, 200]; positions.len()];
        let lines = Arc::new(Lines { positions, colors, topology: LineTopology::List, blending });
        let lines = |display| Drawable { display, ..at(0.0, 0.0, 1.5, Geometry::Lines(Arc::clone(&lines))) };
        assert_object("lines", vec![opaque(OTHER, 2.0), lines(LISTED)], Some(1.5));
        let expected_m = (blending == Blending::Alpha).then_some(2.0);
        assert_object("lines of another", vec![opaque(LISTED, 2.0), lines(OTHER)], expected_m);
        let cells = CellSheet {
            cells: Arc::new(Cells::new(1, 1, &[7])),
            palette: Arc::new([[200, 200, 200, 128]; 256]),
            alpha: 1.0,
            blending,
            depth_write: false,
        };
        let cells = |display| Drawable { display, ..at(-0.5, -0.5, 1.5, Geometry::Cells(cells.clone())) };
        assert_object("cells", vec![opaque(OTHER, 2.0), cells(LISTED)], Some(1.5));
        assert_object("cells of another", vec![opaque(LISTED, 2.0), cells(OTHER)], expected_m);
    }
}

#[test]
fn text_is_an_object_where_it_covers_and_not_between_its_letters() {
    // Black on white, each pixel is as much darker as the text covers it.
    let text = Text::new("HIM", 0.3, Rgba::BLACK, (HorizontalAlignment::Center, VerticalAlignment::Center));
    for text in [text.clone(), text.on_top()] {
        let text = Drawable { display: LISTED, ..at(0.0, 0.0, 1.5, Geometry::Text(Arc::new(text))) };
        let wall = square(OTHER, 2.0, Material { lighting: Lighting::Unlit, ..Material::lit(Rgba::WHITE) });
        let scene = scene([text, wall]);
        for mut renderer in renderers() {
            let (image, depths) = drawn(renderer.as_mut(), &scene);
            let (mut in_letters, mut between) = (0, 0);
            for (level, depth_m) in image.data.iter().zip(&depths.objects.depths_m) {
                match level {
                    1..=252 => {
                        in_letters += 1;
                        assert!((depth_m - 1.5).abs() < DEPTH_TOLERANCE_M, "{}: {depth_m}", renderer.describe());
                    }
                    255 => {
                        between += 1;
                        assert!(depth_m.is_nan(), "{}: {depth_m}", renderer.describe());
                    }
                    // Covered wholly or beside the wall, or so little that rounding decides.
                    _ => {}
                }
            }
            assert!(in_letters > 30 && between > 500, "{in_letters} {between}");
            let opaque_m = depths.opaque.depths_m[CENTRE];
            assert!((opaque_m - 2.0).abs() < DEPTH_TOLERANCE_M, "text hides nothing: {opaque_m}");
        }
    }
}
