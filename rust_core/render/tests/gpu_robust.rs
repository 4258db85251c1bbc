//! Any scene is drawn without a panic and without an error of the GPU.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod common;

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use common::{camera, draw_on};
use nalgebra::{Isometry3, Matrix4, Point3, Vector3};
use proptest::collection::vec;
use proptest::prelude::*;
use rcs_render::GpuRenderer;
use rcs_scene::{
    Blending, Camera, CullMode, DirectionalLight, Drawable, Filtering, Geometry, HorizontalAlignment, LineTopology,
    Lines, Material, Mesh, PointBuffer, PointColors, PointStyle, Points, RenderGroup, Rgba, RibbonElement, Ribbons,
    Scene, Text, Texture, Vertex, VerticalAlignment, Wrapping,
};

fn gpu() -> &'static Mutex<GpuRenderer> {
    static GPU: OnceLock<Mutex<GpuRenderer>> = OnceLock::new();
    GPU.get_or_init(|| Mutex::new(GpuRenderer::new(false).unwrap()))
}

fn number() -> impl Strategy<Value = f32> {
    prop_oneof![
        8 => -3.0_f32..3.0,
        1 => Just(0.0),
        1 => prop_oneof![Just(f32::NAN), Just(f32::INFINITY), Just(f32::MAX), Just(-1e20), Just(1e-30)],
    ]
}

fn position() -> impl Strategy<Value = [f32; 3]> {
    [number(), number(), number()]
}

fn blending() -> impl Strategy<Value = Blending> {
    prop_oneof![Just(Blending::Replace), Just(Blending::Alpha)]
}

fn style() -> impl Strategy<Value = PointStyle> {
    prop_oneof![
        number().prop_map(|diameter_px| PointStyle::Points { diameter_px }),
        (number(), number()).prop_map(|(width, height)| PointStyle::Squares { size_m: [width, height] }),
        number().prop_map(|side_m| PointStyle::FlatSquares { side_m }),
        (number(), number()).prop_map(|(width, height)| PointStyle::Spheres { size_m: [width, height] }),
        position().prop_map(|size_m| PointStyle::Boxes { size_m }),
        (position(), position(), number()).prop_map(|(normal, up, side)| PointStyle::Tiles {
            size_m: [side, 0.3],
            normal,
            up
        }),
    ]
}

fn cloud() -> impl Strategy<Value = Geometry> {
    (vec(position(), 0..20), vec(any::<[u8; 4]>(), 0..20), style(), number(), any::<[bool; 3]>()).prop_map(
        |(positions, colors, style, alpha, [blended, auto_size, uniform])| {
            let colors = if uniform { PointColors::Uniform([200; 4]) } else { PointColors::PerPoint(colors) };
            Geometry::Points(Points {
                buffer: Arc::new(PointBuffer { positions, colors }),
                style,
                alpha,
                blended,
                auto_size,
            })
        },
    )
}

fn lines() -> impl Strategy<Value = Geometry> {
    (vec(position(), 0..12), vec(any::<[u8; 4]>(), 0..12), any::<bool>(), blending()).prop_map(
        |(positions, colors, strip, blending)| {
            let topology = if strip { LineTopology::Strip } else { LineTopology::List };
            Geometry::Lines(Arc::new(Lines { positions, colors, topology, blending }))
        },
    )
}

fn ribbons() -> impl Strategy<Value = Geometry> {
    let element = (position(), any::<[u8; 4]>()).prop_map(|(position, color)| RibbonElement { position, color });
    (vec(vec(element, 0..6), 0..4), number(), blending())
        .prop_map(|(chains, width_m, blending)| Geometry::Ribbons(Arc::new(Ribbons { chains, width_m, blending })))
}

fn texture() -> impl Strategy<Value = Texture> {
    let filtering = prop_oneof![Just(Filtering::Nearest), Just(Filtering::Bilinear), Just(Filtering::BilinearMipmap)];
    (0_u32..40, 0_u32..9, vec(any::<[u8; 4]>(), 0..64), filtering, any::<bool>()).prop_map(
        |(width, height, rgba, filtering, repeat)| {
            let wrapping = if repeat { Wrapping::Repeat } else { Wrapping::Clamp };
            Texture { width, height, rgba, filtering, wrapping }
        },
    )
}

fn mesh() -> impl Strategy<Value = Geometry> {
    let vertex = (position(), position(), number(), any::<[u8; 4]>()).prop_map(|(position, normal, u, color)| Vertex {
        position,
        normal,
        uv: [u, 0.3],
        color,
    });
    let cull = prop_oneof![Just(CullMode::None), Just(CullMode::Back), Just(CullMode::Front)];
    let material = (any::<[bool; 4]>(), number(), number(), cull, blending(), proptest::option::of(texture()))
        .prop_map(|([lit, vertex_colors, depth_write, depth_test], depth_bias, shade, cull, blending, texture)| {
            Material {
                vertex_colors,
                depth_write,
                depth_test,
                depth_bias,
                cull,
                blending,
                texture: texture.map(Arc::new),
                ..if lit { Material::lit(Rgba::new(shade, 0.5, 1.0, 0.7)) } else { Material::unlit(false) }
            }
        });
    (vec(vertex, 0..12), vec(0_u32..13, 0..30), material).prop_map(|(vertices, indices, material)| Geometry::Mesh {
        mesh: Arc::new(Mesh { vertices, indices }),
        material: Arc::new(material),
    })
}

fn text() -> impl Strategy<Value = Geometry> {
    (".{0,8}", number(), any::<bool>()).prop_map(|(caption, height_m, on_top)| {
        let alignment = (HorizontalAlignment::Center, VerticalAlignment::Center);
        let text = Text::new(&caption, height_m, Rgba::WHITE, alignment);
        Geometry::Text(Arc::new(if on_top { text.on_top() } else { text }))
    })
}

fn drawable() -> impl Strategy<Value = Drawable> {
    let geometry = prop_oneof![cloud(), lines(), ribbons(), mesh(), text()];
    let group = prop_oneof![Just(RenderGroup::Behind), Just(RenderGroup::Main), Just(RenderGroup::Above)];
    (position(), position(), group, geometry).prop_map(|(place, scale, group, geometry)| {
        let [place, scale] = [place, scale].map(|v| Vector3::from(v).cast::<f64>());
        Drawable {
            display: 0,
            fixed_from_object: Matrix4::new_translation(&place) * Matrix4::new_nonuniform_scaling(&scale),
            sort_point: Point3::from(place),
            group,
            geometry,
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_scene_is_drawn(
        drawables in vec(drawable(), 0..8),
        size in (1_u32..90, 1_u32..90),
        focal in prop_oneof![Just(30.0), Just(-30.0), Just(1e-9), Just(1e9)],
        lit in any::<bool>(),
    ) {
        let scene = Scene { drawables, light: lit.then_some(DirectionalLight { direction: Vector3::z() }) };
        let camera = camera(size.0, size.1, focal);
        let mut gpu = gpu().lock().unwrap_or_else(PoisonError::into_inner);
        let image = draw_on(&mut *gpu, &scene, &camera, [1, 2, 3]);
        prop_assert!(image.is_ok(), "{:?}", image);
    }
}

#[test]
fn a_camera_at_a_nonfinite_pose_draws_without_an_error() {
    let whole = camera(20, 20, 20.0);
    let nowhere = Camera::new(*whole.intrinsics(), &Isometry3::translation(f64::NAN, 0.0, 0.0), 0.01);
    let mesh = common::square_mesh();
    let square = Geometry::Mesh { mesh: Arc::new(mesh), material: Arc::new(Material::lit(Rgba::WHITE)) };
    let mut gpu = gpu().lock().unwrap_or_else(PoisonError::into_inner);
    draw_on(&mut *gpu, &common::scene([common::at(0.0, 0.0, 1.0, square)]), &nowhere, [0; 3]).unwrap();
}
