//! The GPU renderer draws many solids as if each were a drawable of its own, in few draw calls.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

use std::cell::RefCell;
use std::sync::Arc;

use nalgebra::{Isometry3, Matrix4, Point3, Vector3};
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use rcs_render::{GpuRenderer, Renderer, View};
use rcs_scene::{
    Camera, DirectionalLight, DisplayMask, Drawable, Encoding, Geometry, Image, Intrinsics, Material, Mesh,
    RenderGroup, Rgba, Scene, Solids, Vertex,
};

/// The displays of a scene.
const DISPLAYS: u32 = 3;

/// A double pyramid around the z axis.
fn pyramids(sides: u32) -> Arc<Mesh> {
    let mut mesh = Mesh::default();
    for side in 0..sides {
        let rim = |side: u32| {
            let (sin, cos) = (side as f32 / sides as f32 * std::f32::consts::TAU).sin_cos();
            [cos * 0.5, sin * 0.5, 0.0]
        };
        for (tip, [a, b]) in [(0.5, [side, side + 1]), (-0.5, [side + 1, side])] {
            for position in [[0.0, 0.0, tip], rim(a), rim(b)] {
                let normal = Vector3::from(position).normalize().into();
                mesh.indices.push(mesh.vertices.len() as u32);
                mesh.vertices.push(Vertex::new(position, normal));
            }
        }
    }
    Arc::new(mesh)
}

fn drawable(display: u32, fixed_from_object: Matrix4<f64>, geometry: Geometry) -> Drawable {
    let sort_point = Point3::from(fixed_from_object.fixed_view::<3, 1>(0, 3).into_owned());
    Drawable { display, fixed_from_object, sort_point, group: RenderGroup::Main, geometry }
}

/// A solid of a scene: shape, place, colour, display.
type Thing = (usize, Matrix4<f64>, Rgba, u32);

fn things() -> impl Strategy<Value = Vec<Thing>> {
    let scale = || prop_oneof![4 => 0.05f64..0.5, 1 => -0.5f64..-0.05];
    let alpha = prop_oneof![Just(1.0f32), 0.2f32..0.9];
    let thing = (
        0..2usize,
        [-1.0f64..1.0, -1.0..1.0, 0.8..4.0],
        [-3.0f64..3.0, -3.0..3.0, -3.0..3.0],
        [scale(), scale(), scale()],
        [0.2f32..1.0, 0.2..1.0],
        alpha,
        0..DISPLAYS,
    );
    let thing = thing.prop_map(|(shape, place, turn, scale, [red, green], alpha, display)| {
        let pose = Isometry3::new(Vector3::from(place), Vector3::from(turn));
        let place = pose.to_homogeneous() * Matrix4::new_nonuniform_scaling(&Vector3::from(scale));
        (shape, place, Rgba::new(red, green, 0.5, alpha), display)
    });
    prop::collection::vec(thing, 1..80)
}

fn singly(things: &[Thing], shapes: &[Arc<Mesh>]) -> Vec<Drawable> {
    let one = |(shape, place, color, display): &Thing| {
        let (mesh, material) = (shapes[*shape].clone(), Arc::new(Material::lit(*color)));
        drawable(*display, *place, Geometry::Mesh { mesh, material })
    };
    things.iter().map(one).collect()
}

fn together(things: &[Thing], shapes: &[Arc<Mesh>]) -> Vec<Drawable> {
    let chunk = |things: &[Thing]| {
        let mut solids = Solids::default();
        for (shape, place, color, _) in things {
            assert!(solids.push(&shapes[*shape], place, *color));
        }
        drawable(things[0].3, Matrix4::identity(), Geometry::Solids(Arc::new(solids)))
    };
    things.chunk_by(|a, b| a.3 == b.3).map(chunk).collect()
}

fn image(gpu: &mut GpuRenderer, drawables: Vec<Drawable>, visible: &DisplayMask) -> Image {
    let p = [100.0, 0.0, 64.0, 0.0, 0.0, 100.0, 48.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let camera = Camera::new(Intrinsics::from_p(128, 96, &p).unwrap(), &Isometry3::identity(), 0.01);
    let light = Some(DirectionalLight { direction: Vector3::new(0.3, 0.5, 0.8).normalize() });
    let scene = Scene { drawables, light };
    let view = View { scene: &scene, camera: &camera, visible, background: [9; 3], encoding: Encoding::Rgb8 };
    let mut image = Image::default();
    gpu.render(&view, &mut image).unwrap();
    image
}

#[test]
fn solids_look_the_same_singly_and_together() {
    let (shapes, gpu) = ([pyramids(4), pyramids(12)], RefCell::new(GpuRenderer::new(false).unwrap()));
    let scenes = (things(), prop::option::of(0..DISPLAYS));
    let mut runner = TestRunner::new(ProptestConfig::with_cases(60));
    let result = runner.run(&scenes, |(things, hidden)| {
        let mut visible = DisplayMask::all();
        hidden.into_iter().for_each(|display| visible.set(display, false));
        let gpu = &mut *gpu.borrow_mut();
        let alone = image(gpu, singly(&things, &shapes), &visible);
        prop_assert!(image(gpu, together(&things, &shapes), &visible).data == alone.data);
        Ok(())
    });
    result.unwrap();
}

#[test]
fn neighbours_of_one_shape_are_one_draw_call_whoever_they_belong_to() {
    let shapes = [pyramids(4), pyramids(12)];
    let place = |i: usize| Matrix4::new_translation(&Vector3::new(i as f64 * 1e-3 - 0.5, 0.0, 3.0 - i as f64 * 1e-3));
    let thing = |i: usize, shape, alpha| (shape, place(i), Rgba::WHITE.with_alpha(alpha), (i / 250) as u32);
    let mut gpu = GpuRenderer::new(false).unwrap();
    let mut draws = |things: &[Thing]| {
        let drawn = [singly(things, &shapes), together(things, &shapes)].map(|drawables| {
            let before = gpu.stats().draws;
            image(&mut gpu, drawables, &DisplayMask::all());
            gpu.stats().draws - before
        });
        assert_eq!(drawn[0], drawn[1]);
        drawn[1]
    };
    let all = |shape: fn(usize) -> usize, alpha: fn(usize) -> f32| {
        (0..1000).map(|i| thing(i, shape(i), alpha(i))).collect::<Vec<_>>()
    };
    assert_eq!(draws(&all(|_| 0, |_| 1.0)), 1);
    assert_eq!(draws(&all(|_| 0, |_| 0.5)), 1, "they are sorted as they are");
    assert_eq!(draws(&all(|i| i / 500, |_| 1.0)), 2);
    assert_eq!(draws(&all(|_| 0, |i| if i % 2 == 0 { 1.0 } else { 0.5 })), 2);
}
