//! In heavy scenes what is hidden costs little, and what is not looked at for that would not have been seen.
#![allow(clippy::unwrap_used, reason = "a test may stop here")]

mod heavy_common;

use std::sync::Arc;
use std::time::Instant;

use heavy_common::{arrows, balls, camera_of, cloud, drawable, filling, lines, ribbons, rows, Numbers, TILT};
use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;
use rcs_render::{CpuRenderer, Culling, Renderer, View};
use rcs_scene::{
    Blending, Camera, CullMode, DisplayMask, Drawable, Encoding, Filtering, Geometry, Image, LineTopology, Material,
    Mesh, PointStyle, RenderGroup, Scene, Texture, Vertex, Wrapping,
};

fn render(renderer: &mut dyn Renderer, scene: &Scene, camera: &Camera) -> Image {
    let visible = DisplayMask::all();
    let (background, encoding) = ([20, 30, 40], Encoding::Rgba8);
    let mut image = Image::default();
    renderer.render(&View { scene, camera, visible: &visible, background, encoding }, &mut image).unwrap();
    image
}

/// Places so close to the lens that faces of some millimetres are large: spread, in a few places, in one, in a plane.
fn places() -> impl Strategy<Value = Vec<[f32; 3]>> {
    let count = prop_oneof![4 => 1usize..60, 1 => 200usize..900];
    (count, 0u8..6, any::<u64>(), prop_oneof![0.02f32..0.1, Just(0.06f32)]).prop_map(|(count, kind, seed, z)| {
        let mut numbers = Numbers::new(seed);
        let mut spread = |reach: f32| numbers.between(-reach, reach);
        let fixed: Vec<[f32; 3]> = (0..4).map(|_| [spread(0.01), spread(0.01), z + spread(0.005)]).collect();
        let mut place = |i: usize| match kind {
            0 => [spread(0.02), spread(0.02), z],
            1 => [spread(0.02), spread(0.02), z + spread(0.02)],
            2 => fixed[i * 7 % 4],
            3 => [spread(1e-4), spread(1e-4), z + spread(1e-6)],
            4 => [spread(0.02), spread(0.02), z - 0.00002 * i as f32],
            _ => [spread(0.05), spread(0.05), spread(0.1)],
        };
        (0..count).map(&mut place).collect()
    })
}

fn style() -> impl Strategy<Value = PointStyle> {
    let side = || prop::sample::select(vec![0.0005f32, 0.001, 0.004, 0.01]);
    prop_oneof![
        side().prop_map(|side_m| PointStyle::FlatSquares { side_m }),
        [side(), side()].prop_map(|size_m| PointStyle::Squares { size_m }),
        [side(), side()].prop_map(|size_m| PointStyle::Spheres { size_m }),
        [side(), side(), side()].prop_map(|size_m| PointStyle::Boxes { size_m }),
        ([side(), side()], any::<bool>()).prop_map(|(size_m, is_turned)| {
            let (normal, up) =
                if is_turned { ([0.6, 0.0, -0.8], [0.0, 1.0, 0.0]) } else { ([0.0, 0.0, -1.0], [0.0, -1.0, 0.0]) };
            PointStyle::Tiles { size_m, normal, up }
        }),
        (1.0f32..60.0).prop_map(|diameter_px| PointStyle::Points { diameter_px }),
    ]
}

fn clouds() -> impl Strategy<Value = Drawable> {
    let alpha = prop_oneof![3 => Just(1.0f32), 1 => Just(0.4f32)];
    (places(), style(), alpha, any::<bool>(), any::<bool>()).prop_map(|(positions, style, alpha, is_scaled, faint)| {
        let mut cloud = cloud(positions, style, alpha);
        if let Geometry::Points(points) = &mut cloud.geometry {
            points.auto_size = is_scaled && matches!(style, PointStyle::Points { .. } | PointStyle::FlatSquares { .. });
            if faint {
                // Some are too faint to be drawn, and hide nothing.
                let buffer = Arc::make_mut(&mut points.buffer);
                if let rcs_scene::PointColors::PerPoint(colors) = &mut buffer.colors {
                    colors.iter_mut().step_by(3).for_each(|color| color[3] = 0);
                }
            }
        }
        cloud
    })
}

fn material() -> impl Strategy<Value = Material> {
    (0u8..8, prop::sample::select(vec![CullMode::None, CullMode::Back, CullMode::Front]), any::<bool>()).prop_map(
        |(kind, cull, is_colored)| {
            let plain = Material { cull, vertex_colors: is_colored, ..Material::unlit(kind == 1) };
            match kind {
                2 => Material { depth_test: false, ..plain },
                3 => Material { depth_write: false, ..plain },
                4 => Material { depth_bias: 3.0, ..plain },
                5 => {
                    let rgba = vec![[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 0, 255]];
                    let (filtering, wrapping) = (Filtering::Nearest, Wrapping::Repeat);
                    let texture = Texture { width: 2, height: 2, rgba, filtering, wrapping };
                    Material { texture: Some(Arc::new(texture)), ..plain }
                }
                6 => Material { blending: Blending::Alpha, depth_write: true, ..plain },
                _ => plain,
            }
        },
    )
}

/// Triangles of all sizes, some of them several times, some in one plane. Large meshes are drawn another way than small
/// ones.
fn meshes() -> impl Strategy<Value = Drawable> {
    let flags = [any::<bool>(), any::<bool>()];
    (material(), any::<u64>(), 1usize..80, 0u8..4, flags).prop_map(
        |(material, seed, count, kind, [shares, is_large])| {
            let mut numbers = Numbers::new(seed);
            let mut mesh = Mesh::default();
            for i in 0..count {
                let z = match kind {
                    0 => 1.0,
                    1 => 0.5 + 0.01 * i as f32,
                    _ => numbers.between(0.3, 2.0),
                };
                let reach = if i % 3 == 0 { 5.0 } else { 0.7 };
                for _ in 0..3 {
                    let depth = if kind == 3 { numbers.between(-0.2, 2.0) } else { z };
                    let position = [numbers.between(-reach, reach), numbers.between(-reach, reach), depth];
                    let color = heavy_common::color(if shares { i } else { mesh.vertices.len() });
                    let uv = [numbers.next(), numbers.next()];
                    mesh.vertices.push(Vertex { color, uv, ..Vertex::new(position, [0.0, 0.0, -1.0]) });
                }
                let base = if i % 5 == 4 { 3 * (i as u32 - 2) } else { 3 * i as u32 };
                mesh.indices.extend([base, base + 1, base + 2]);
            }
            if is_large {
                mesh.indices.extend([0; 3 * 4096]);
            }
            drawable(Geometry::Mesh { mesh: Arc::new(mesh), material: Arc::new(material) })
        },
    )
}

fn others() -> impl Strategy<Value = Drawable> {
    (any::<u64>(), 0u8..5).prop_map(|(seed, kind)| {
        let mut numbers = Numbers::new(seed);
        let places: Vec<[f32; 3]> = (0..40)
            .map(|_| [numbers.between(-1.0, 1.0), numbers.between(-1.0, 1.0), numbers.between(-0.2, 1.5)])
            .collect();
        match kind {
            0 => lines(places, LineTopology::List, Blending::Replace),
            1 => lines(places, LineTopology::Strip, Blending::Alpha),
            2 => ribbons(&places, 9, Blending::Replace),
            3 => balls(&places, 0.2, 100),
            _ => arrows(&places),
        }
    })
}

fn scenes() -> impl Strategy<Value = Scene> {
    let group =
        prop::sample::select(vec![RenderGroup::Behind, RenderGroup::Main, RenderGroup::Main, RenderGroup::Above]);
    let pose = prop_oneof![
        3 => Just(Isometry3::identity()),
        1 => [-0.3f64..0.3, -0.3..0.3, -0.3..0.3].prop_map(|turn| {
            Isometry3::new(Vector3::new(0.001, -0.002, 0.003), Vector3::from(turn))
        }),
    ];
    let geometry = prop_oneof![4 => clouds(), 3 => meshes(), 1 => others()];
    let thing = (geometry, group, pose).prop_map(|(drawable, group, pose)| Drawable {
        group,
        fixed_from_object: pose.to_homogeneous(),
        ..drawable
    });
    prop::collection::vec(thing, 1..6).prop_map(|drawables| Scene { drawables, light: None })
}

fn cameras() -> impl Strategy<Value = Camera> {
    let size = prop::sample::select(vec![[64u32, 48], [100, 77], [333, 130], [640, 70]]);
    let focal = prop::sample::select(vec![150.0, 600.0, 1900.0, -600.0]);
    let turn = prop::sample::select(vec![[0.0; 3], TILT, [0.0, 0.0, std::f64::consts::FRAC_PI_2]]);
    (size, focal, turn).prop_map(|(size, focal, turn)| camera_of(size, focal, turn))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn what_is_hidden_does_not_show_in_the_image(scene in scenes(), camera in cameras()) {
        let draw = |culling| render(&mut CpuRenderer::with_threads(1).with_culling(culling), &scene, &camera);
        let image = draw(Culling::Never);
        let different = |other: Image| {
            other.data.chunks(4).zip(image.data.chunks(4)).position(|(a, b)| a != b)
        };
        prop_assert_eq!(different(draw(Culling::Always)), None);
        prop_assert_eq!(different(draw(Culling::Heavy)), None);
    }
}

/// The time of one image in seconds.
fn secs(renderer: &mut CpuRenderer, scene: &Scene, camera: &Camera) -> f64 {
    let start = Instant::now();
    render(renderer, scene, camera);
    start.elapsed().as_secs_f64()
}

/// The share of its things that a scene of the example is drawn with here, and how many times as fast as without
/// culling; where hardly anything is hidden, looking for that must not cost as much as all the rest.
fn demand(name: &str) -> (f64, f64) {
    let has = |parts: &[&str]| parts.iter().any(|part| name.contains(part));
    if has(&["filling triangles"]) {
        (0.02, 8.0)
    } else if has(&["at 6 cm"]) {
        (0.4, 2.0)
    } else {
        (0.2, 0.5)
    }
}

/// The rows of the table with some of their things. The fastest of a few images counts; of more where others keep the
/// processors busy.
#[test]
fn what_is_hidden_costs_little() {
    let mut late = Vec::new();
    for name in rows(0.0).into_iter().filter(|row| row.limit_ms.is_finite()).map(|row| row.name) {
        let (share, times_faster) = demand(&name);
        let row = rows(share).into_iter().find(|row| row.name == name).unwrap();
        let scene = row.scene();
        let [mut culling, mut never] =
            [Culling::Heavy, Culling::Never].map(|culling| CpuRenderer::new().with_culling(culling));
        let limit = secs(&mut never, &scene, &row.camera) / times_faster;
        let mut fastest = f64::INFINITY;
        for number in 0..20 {
            if number < 3 || fastest > limit {
                fastest = fastest.min(secs(&mut culling, &scene, &row.camera));
            }
        }
        println!("{name:45} {:8.1} ms, {:8.1} without culling", fastest * 1e3, limit * times_faster * 1e3);
        if fastest > limit {
            late.push(name);
        }
    }
    assert!(late.is_empty(), "{late:?}");
}

/// The same scenes with fewer things, drawn with and without culling.
#[test]
fn heavy_scenes_look_the_same_without_culling() {
    for row in rows(0.002) {
        let scene = row.scene();
        let draw = |culling| render(&mut CpuRenderer::new().with_culling(culling), &scene, &row.camera);
        let image = draw(Culling::Never);
        assert!(draw(Culling::Always) == image && draw(Culling::Heavy) == image, "{}", row.name);
    }
}

/// More workers have more bands of rows; no pixel may depend on where these begin.
#[test]
fn a_image_is_the_same_for_any_number_of_workers() {
    for row in rows(0.01) {
        let scene = row.scene();
        let draw = |threads| render(&mut CpuRenderer::with_threads(threads), &scene, &row.camera);
        let image = draw(1);
        for threads in [2, 3, 8] {
            assert!(draw(threads) == image, "{}, {threads} workers", row.name);
        }
    }
}

/// A fan of equal triangles, and the last one wins everywhere.
#[test]
fn of_equally_deep_faces_the_last_is_seen() {
    for blending in [Blending::Replace, Blending::Alpha] {
        let drawables = vec![filling(500, Blending::Replace, |_| 1.5), filling(3, blending, |_| 1.5)];
        let scene = Scene { drawables, light: None };
        let camera = camera_of([100, 80], 300.0, [0.0; 3]);
        let draw = |culling| render(&mut CpuRenderer::new().with_culling(culling), &scene, &camera);
        assert!(draw(Culling::Always) == draw(Culling::Never));
    }
}
