//! Properties of every image of the CPU renderer, whatever numbers are in the scene.
#![allow(clippy::unwrap_used, reason = "a test may stop here")]

mod common;

use std::sync::Arc;

use common::{at, camera, draw, pixel, points};
use nalgebra::{Isometry3, Matrix4, Vector3};
use proptest::prelude::*;
use rcs_render::CpuRenderer;
use rcs_scene::{
    Blending, Camera, CullMode, DirectionalLight, Drawable, Filtering, Geometry, HorizontalAlignment, Intrinsics,
    LineTopology, Lines, Material, Mesh, PointBuffer, PointColors, PointStyle, Points, RenderGroup, Rgba,
    RibbonElement, Ribbons, Scene, Text, Texture, Vertex, VerticalAlignment, Wrapping,
};

/// Mostly numbers of a scene in front of the camera, and now and then extreme or non-finite ones.
fn number() -> impl Strategy<Value = f32> {
    prop_oneof![
        8 => -3.0f32..3.0,
        2 => -1e-3f32..1e-3,
        1 => prop::sample::select(vec![
            0.0, -0.0, 1.0, -1.0, 0.01, 100.0, f32::MAX, f32::MIN, f32::MIN_POSITIVE, f32::NAN, f32::INFINITY,
            f32::NEG_INFINITY, 1e20, -1e20, 65536.0,
        ]),
    ]
}

fn place() -> impl Strategy<Value = [f32; 3]> {
    [number(), number(), number()]
}

fn color() -> impl Strategy<Value = [u8; 4]> {
    any::<[u8; 4]>()
}

fn matrix() -> impl Strategy<Value = Matrix4<f64>> {
    prop_oneof![
        3 => Just(Matrix4::identity()),
        3 => [-2.0f64..2.0, -2.0..2.0, -1.0..4.0, -3.0..3.0, -3.0..3.0, -3.0..3.0].prop_map(|[x, y, z, a, b, c]| {
            Isometry3::new(Vector3::new(x, y, z), Vector3::new(a, b, c)).to_homogeneous()
        }),
        2 => prop::collection::vec(number(), 12).prop_map(|n| {
            let mut matrix = Matrix4::identity();
            for (i, n) in n.into_iter().enumerate() {
                matrix[(i / 4, i % 4)] = f64::from(n);
            }
            matrix
        }),
    ]
}

fn style() -> impl Strategy<Value = PointStyle> {
    prop_oneof![
        number().prop_map(|diameter_px| PointStyle::Points { diameter_px: diameter_px * 10.0 }),
        [number(), number()].prop_map(|size_m| PointStyle::Squares { size_m }),
        number().prop_map(|side_m| PointStyle::FlatSquares { side_m }),
        [number(), number()].prop_map(|size_m| PointStyle::Spheres { size_m }),
        place().prop_map(|size_m| PointStyle::Boxes { size_m }),
        ([number(), number()], place(), place()).prop_map(|(size_m, normal, up)| PointStyle::Tiles {
            size_m,
            normal,
            up
        }),
    ]
}

fn cloud() -> impl Strategy<Value = Geometry> {
    let colors = prop_oneof![
        color().prop_map(PointColors::Uniform),
        prop::collection::vec(color(), 0..12).prop_map(PointColors::PerPoint),
    ];
    (prop::collection::vec(place(), 0..12), colors, style(), number(), any::<bool>(), any::<bool>()).prop_map(
        |(positions, colors, style, alpha, blended, auto_size)| {
            let buffer = Arc::new(PointBuffer { positions, colors });
            Geometry::Points(Points { buffer, style, alpha, blended, auto_size })
        },
    )
}

fn texture() -> impl Strategy<Value = Texture> {
    (
        1u32..6,
        1u32..6,
        prop::collection::vec(color(), 0..36),
        prop::sample::select(vec![Filtering::Nearest, Filtering::Bilinear, Filtering::BilinearMipmap]),
        prop::sample::select(vec![Wrapping::Repeat, Wrapping::Clamp]),
    )
        .prop_map(|(width, height, rgba, filtering, wrapping)| Texture {
            width,
            height,
            rgba,
            filtering,
            wrapping,
        })
}

fn material() -> impl Strategy<Value = Material> {
    (
        prop_oneof![Just(None), [number(), number(), number(), number()].prop_map(Some)],
        prop::option::of(texture().prop_map(Arc::new)),
        any::<[bool; 4]>(),
        number(),
        prop::sample::select(vec![CullMode::None, CullMode::Back, CullMode::Front]),
    )
        .prop_map(|(lit, texture, [vertex_colors, blend, depth_write, depth_test], depth_bias, cull)| {
            let lit = lit.map(|diffuse| Material::lit(Rgba::from(diffuse)));
            Material {
                vertex_colors,
                texture,
                blending: if blend { Blending::Alpha } else { Blending::Replace },
                depth_write,
                depth_test,
                depth_bias,
                cull,
                ..lit.unwrap_or_else(|| Material::unlit(false))
            }
        })
}

fn mesh() -> impl Strategy<Value = Geometry> {
    let vertex = (place(), place(), [number(), number()], color()).prop_map(|(position, normal, uv, color)| Vertex {
        position,
        normal,
        uv,
        color,
    });
    (prop::collection::vec(vertex, 1..10), prop::collection::vec(0u32..11, 0..30), material()).prop_map(
        |(vertices, indices, material)| Geometry::Mesh {
            mesh: Arc::new(Mesh { vertices, indices }),
            material: Arc::new(material),
        },
    )
}

fn blending() -> impl Strategy<Value = Blending> {
    prop::sample::select(vec![Blending::Alpha, Blending::Replace])
}

fn lines() -> impl Strategy<Value = Geometry> {
    let topology = prop::sample::select(vec![LineTopology::List, LineTopology::Strip]);
    (prop::collection::vec(place(), 0..12), prop::collection::vec(color(), 0..12), topology, blending()).prop_map(
        |(positions, colors, topology, blending)| {
            Geometry::Lines(Arc::new(Lines { positions, colors, topology, blending }))
        },
    )
}

fn ribbons() -> impl Strategy<Value = Geometry> {
    let element = (place(), color()).prop_map(|(position, color)| RibbonElement { position, color });
    (prop::collection::vec(prop::collection::vec(element, 0..6), 0..3), number(), blending())
        .prop_map(|(chains, width_m, blending)| Geometry::Ribbons(Arc::new(Ribbons { chains, width_m, blending })))
}

fn text() -> impl Strategy<Value = Geometry> {
    ("[a-z \n]{0,8}", number()).prop_map(|(caption, height_m)| {
        let alignment = (HorizontalAlignment::Center, VerticalAlignment::Center);
        Geometry::Text(Arc::new(Text::new(&caption, height_m, Rgba::WHITE, alignment)))
    })
}

fn scene() -> impl Strategy<Value = Scene> {
    let geometry = prop_oneof![3 => cloud(), 3 => mesh(), 2 => lines(), 1 => ribbons(), 1 => text()];
    let group = prop::sample::select(vec![RenderGroup::Behind, RenderGroup::Main, RenderGroup::Above]);
    let thing = (geometry, matrix(), group).prop_map(|(geometry, fixed_from_object, group)| Drawable {
        fixed_from_object,
        group,
        ..at(0.0, 0.0, 0.0, geometry)
    });
    (prop::collection::vec(thing, 0..6), prop::option::of([-1.0f64..1.0, -1.0..1.0, -1.0..1.0])).prop_map(
        |(drawables, light)| Scene {
            drawables,
            light: light.map(|direction| DirectionalLight { direction: Vector3::from(direction) }),
        },
    )
}

fn any_camera() -> impl Strategy<Value = Camera> {
    let side = || prop::sample::select(vec![1u32, 2, 3, 17, 64, 100, 333]);
    let focal = || prop::sample::select(vec![100.0, 37.5, -100.0, 1e-3, 1e6]);
    (side(), side(), focal(), focal(), -1e3f64..1e3, -1e3f64..1e3, [-1.0f64..1.0, -1.0..1.0, -1.0..1.0]).prop_map(
        |(width, height, fx, fy, cx, cy, turn)| {
            let p = [fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0];
            let pose = Isometry3::new(Vector3::zeros(), Vector3::from(turn) * 0.3);
            Camera::new(Intrinsics::from_p(width, height, &p).unwrap(), &pose, 0.01)
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn a_image_depends_on_neither_the_threads_nor_the_time(scene in scene(), camera in any_camera()) {
        let draw = |threads| draw(&mut CpuRenderer::with_threads(threads), &scene, &camera);
        let image = draw(1);
        prop_assert!(draw(1) == image);
        prop_assert!(draw(2) == image);
        prop_assert!(draw(5) == image);
    }

    /// A fan of translucent triangles around a point covers a convex outline: each pixel inside is blended once.
    #[test]
    fn triangles_that_share_edges_draw_each_pixel_once(
        middle in [-0.2f32..0.2, -0.2..0.2],
        corners in prop::collection::vec((0.25f32..0.6, 0.9f32..1.3), 3..9),
    ) {
        let count = corners.len() as f32;
        let mut vertices = vec![[middle[0] * 0.2, middle[1] * 0.2, 1.0]];
        for (i, (radius, distance)) in corners.iter().enumerate() {
            let angle = i as f32 / count * std::f32::consts::TAU;
            vertices.push([angle.cos() * radius * distance, angle.sin() * radius * distance, *distance]);
        }
        let last = corners.len() as u32;
        let indices = (1..=last).flat_map(|i| [0, i, i % last + 1]).collect();
        let vertices = vertices
            .into_iter()
            .map(|position| Vertex { color: [200, 200, 200, 128], ..Vertex::new(position, [0.0; 3]) })
            .collect();
        let material = Material { cull: CullMode::None, ..Material::unlit(true) };
        let mesh = Geometry::Mesh { mesh: Arc::new(Mesh { vertices, indices }), material: Arc::new(material) };
        let scene = Scene { drawables: vec![at(0.0, 0.0, 0.0, mesh)], light: None };
        let image = draw(&mut CpuRenderer::with_threads(2), &scene, &camera(100, 100, 100.0));
        let seen = |level: u8| (0..10_000).filter(|i| pixel(&image, i % 100, i / 100)[0] == level).count();
        prop_assert_eq!(seen(0) + seen(100), 10_000);
        prop_assert!(seen(100) > 300);
        prop_assert_eq!(pixel(&image, 50, 50)[0], 100);
    }
}

#[test]
fn the_largest_images_are_drawn() {
    let cloud = points(PointStyle::Boxes { size_m: [0.5; 3] }, [255; 4], &[[0.0, 0.0, 1.0], [0.3, -0.2, 2.0]]);
    let scene = Scene { drawables: vec![at(0.0, 0.0, 0.0, Geometry::Points(cloud))], light: None };
    for (width, height) in [(16384, 64), (64, 16384)] {
        let image = draw(&mut CpuRenderer::with_threads(2), &scene, &camera(width, height, 100.0));
        assert_eq!(image.data.len(), (width * height * 4) as usize);
        assert!((0..height).any(|y| (0..width).any(|x| pixel(&image, x, y) != [0; 3])));
    }
}
