//! Many small things are drawn as if each were a drawable of its own that is transformed, cut and lit in one piece.

use std::f32::consts::{PI, TAU};
use std::sync::Arc;

use nalgebra::{Isometry3, Matrix4, Point3, Vector3};
use proptest::prelude::*;
use rcs_scene::{
    Camera, DirectionalLight, DisplayMask, Drawable, Encoding, Geometry, HorizontalAlignment, Image, Intrinsics,
    Material, Mesh, RenderGroup, Rgba, Scene, Solids, Text, Vertex, VerticalAlignment,
};

use crate::{CpuRenderer, Culling, Renderer, View};

/// A ball of diameter 1, or with few rings and segments something with flat sides.
pub(in crate::cpu) fn ball(rings: u32, segments: u32) -> Arc<Mesh> {
    let mut mesh = Mesh::default();
    for ring in 0..=rings {
        for segment in 0..=segments {
            let (polar, azimuth) = (PI * ring as f32 / rings as f32, TAU * segment as f32 / segments as f32);
            let normal = [polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos()];
            mesh.vertices.push(Vertex::new(normal.map(|c| c * 0.5), normal));
        }
    }
    for ring in 0..rings {
        for segment in 0..segments {
            let here = ring * (segments + 1) + segment;
            let below = here + segments + 1;
            mesh.indices.extend([here, below, below + 1, here, below + 1, here + 1]);
        }
    }
    Arc::new(mesh)
}

/// A solid of a scene.
#[derive(Clone, Debug)]
struct Thing {
    shape: usize,
    place: Matrix4<f64>,
    color: Rgba,
    display: u32,
}

fn scale() -> impl Strategy<Value = f64> {
    prop_oneof![6 => 0.001f64..0.05, 3 => 0.05f64..0.6, 1 => 1.0f64..40.0, 2 => -0.3f64..-0.01, 1 => Just(0.0)]
}

fn thing() -> impl Strategy<Value = Thing> {
    let place = prop_oneof![6 => [-1.2f64..1.2, -1.2..1.2, 0.5..4.0], 1 => [-0.2f64..0.2, -0.2..0.2, -0.5..0.5]];
    let alpha = prop_oneof![3 => Just(1.0f32), 2 => 0.1f32..0.9];
    (0..3usize, place, [-3.0f64..3.0, -3.0..3.0, -3.0..3.0], [scale(), scale(), scale()], any::<bool>(), alpha, 0..4u32)
        .prop_map(|(shape, place, turn, scale, is_even, alpha, display)| {
            let scale = if is_even { [scale[0]; 3] } else { scale };
            let pose = Isometry3::new(Vector3::from(place), Vector3::from(turn));
            let place = pose.to_homogeneous() * Matrix4::new_nonuniform_scaling(&Vector3::from(scale));
            let color = Rgba::new(0.2 + display as f32 / 5.0, 0.3 + shape as f32 / 4.0, 0.9, alpha);
            Thing { shape, place, color, display }
        })
}

fn drawable(display: u32, fixed_from_object: Matrix4<f64>, geometry: Geometry) -> Drawable {
    let sort_point = Point3::from(fixed_from_object.fixed_view::<3, 1>(0, 3).into_owned());
    Drawable { display, fixed_from_object, sort_point, group: RenderGroup::Main, geometry }
}

/// Each thing alone.
fn singly(things: &[Thing], shapes: &[Arc<Mesh>]) -> Vec<Drawable> {
    let one = |thing: &Thing| {
        let (mesh, material) = (shapes[thing.shape].clone(), Arc::new(Material::lit(thing.color)));
        drawable(thing.display, thing.place, Geometry::Mesh { mesh, material })
    };
    things.iter().map(one).collect()
}

/// Neighbours of the same display together.
fn together(things: &[Thing], shapes: &[Arc<Mesh>]) -> Vec<Drawable> {
    let chunk = |things: &[Thing]| {
        let mut solids = Solids::default();
        for thing in things {
            assert!(solids.push(&shapes[thing.shape], &thing.place, thing.color));
        }
        drawable(things[0].display, Matrix4::identity(), Geometry::Solids(Arc::new(solids)))
    };
    things.chunk_by(|a, b| a.display == b.display).map(chunk).collect()
}

fn image(drawables: Vec<Drawable>, visible: &DisplayMask) -> Vec<u8> {
    image_by(&mut CpuRenderer::with_threads(2).with_culling(Culling::Never), drawables, visible)
}

fn image_by(renderer: &mut CpuRenderer, drawables: Vec<Drawable>, visible: &DisplayMask) -> Vec<u8> {
    let p = [100.0, 0.0, 50.0, 0.0, 0.0, 100.0, 40.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let camera = Camera::new(Intrinsics::from_p(101, 83, &p).unwrap(), &Isometry3::identity(), 0.01);
    let light = Some(DirectionalLight { direction: Vector3::new(0.3, 0.5, 0.8).normalize() });
    let scene = Scene { drawables, light };
    let view = View { scene: &scene, camera: &camera, visible, background: [9; 3], encoding: Encoding::Rgba8 };
    let mut image = Image::default();
    renderer.render(&view, &mut image).unwrap();
    image.data
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn solids_look_the_same_singly_and_together(
        things in prop::collection::vec(thing(), 1..60),
        hidden in prop::option::of(0..4u32),
    ) {
        let shapes = [ball(6, 12), ball(2, 4), ball(16, 30)];
        let mut visible = DisplayMask::all();
        hidden.into_iter().for_each(|display| visible.set(display, false));
        let expected = image(singly(&things, &shapes), &visible);
        prop_assert!(image(together(&things, &shapes), &visible) == expected);
    }

    #[test]
    fn of_a_crowd_all_is_seen_that_others_do_not_hide(
        things in prop::collection::vec(thing(), 1..60),
        near in prop::collection::vec((0..40usize, 0.97f64..1.03), 0..400),
    ) {
        let shapes = [ball(6, 12), ball(2, 4), ball(16, 30)];
        let visible = DisplayMask::all();
        // Many more near some of them, or exactly there.
        let again = near.iter().enumerate().map(|(i, &(of, scale))| {
            let of = &things[of % things.len()];
            let scale = if i % 3 == 0 { 1.0 } else { scale };
            let color = Rgba::new(0.1, (i % 20) as f32 / 20.0, 0.3, of.color.a);
            Thing { place: Matrix4::new_scaling(scale) * of.place, color, ..of.clone() }
        });
        let things: Vec<Thing> = things.iter().cloned().chain(again).collect();
        let mut renderer = CpuRenderer::with_threads(2).with_culling(Culling::Always);
        let drawn = image_by(&mut renderer, together(&things, &shapes), &visible);
        prop_assert!(drawn == image(together(&things, &shapes), &visible));
    }

    #[test]
    fn text_looks_like_a_mesh_of_its_glyphs(
        caption in "[a-zA-Z .\n]{0,300}",
        place in [-32..32_i32, -32..32_i32, 20..128_i32],
        height_m in prop_oneof![4 => 0.01f32..0.2, 1 => -0.2f32..2.0, 1 => Just(f32::INFINITY)],
        is_on_top in any::<bool>(),
    ) {
        let alignment = (HorizontalAlignment::Center, VerticalAlignment::Center);
        let text = Text::new(&caption, height_m, Rgba::new(0.4, 0.9, 0.1, 0.7), alignment);
        let text = if is_on_top { text.on_top() } else { text };
        // Numbers that single precision holds, to which a text's place is rounded and a mesh's is not.
        let place = place.map(|sixtyfourths| f64::from(sixtyfourths) / 64.0);
        let mut mesh = Mesh::default();
        for glyph in text.glyphs() {
            let base = mesh.vertices.len() as u32;
            mesh.vertices.extend(text.quad(glyph));
            mesh.indices.extend(Text::QUAD_INDICES.map(|corner| base + corner as u32));
        }
        // The optical frame's y points down, the text's up.
        let fixed_from_text = Matrix4::new_translation(&Vector3::from(place));
        let upright = fixed_from_text * Matrix4::new_nonuniform_scaling(&Vector3::new(1.0, -1.0, -1.0));
        let material = Arc::new(text.material().clone());
        let as_mesh = drawable(0, upright, Geometry::Mesh { mesh: Arc::new(mesh), material });
        let cube = singly(&[Thing { shape: 0, place: fixed_from_text, color: Rgba::WHITE, display: 0 }], &[ball(2, 4)]);
        let both = |text: Drawable| cube.iter().cloned().chain([text]).collect();
        let visible = DisplayMask::all();
        let expected = image(both(as_mesh), &visible);
        let drawn = image(both(drawable(0, fixed_from_text, Geometry::Text(Arc::new(text)))), &visible);
        prop_assert!(drawn == expected);
    }
}
