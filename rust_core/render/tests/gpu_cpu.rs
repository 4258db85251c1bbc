//! The GPU renderer draws the CPU renderer's image.
//!
//! The two may round differently where an edge runs through a pixel's centre, so a pixel may be found one further away,
//! or be what the CPU draws for a camera that is a fraction of a pixel beside; a few may differ altogether. Each run
//! draws other scenes; a failure prints the smallest scene that shows it. Depths are compared in the same way.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod common;

use std::env;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use common::{camera, differing, draw_on, square_mesh};
use nalgebra::{Isometry3, Matrix4, Point3, UnitQuaternion, Vector3};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;
use rcs_render::{CpuRenderer, DepthRequest, Depths, Finished, GpuRenderer, Renderer, View};
use rcs_scene::{
    Blending, Camera, CellSheet, Cells, CullMode, DepthImage, DirectionalLight, DisplayMask, Drawable, Encoding,
    Filtering, Geometry, HorizontalAlignment, Image, Intrinsics, Lighting, LineTopology, Lines, Material, Mesh,
    PointBuffer, PointColors, PointStyle, Points, RenderGroup, Rgba, RibbonElement, Ribbons, Scene, Text, Texture,
    Vertex, VerticalAlignment, Wrapping,
};

const BACKGROUND: [u8; 3] = [30, 60, 90];

/// Levels of 255 that a channel may differ by, and how far a pixel may be from where it is looked for.
const LEVELS: u8 = 16;
const REACH_PX: i64 = 1;

/// How far a depth may be from those of the pixels around: some steps of a depth buffer of 24 bits, 0.1 mm each at 4 m.
/// By some such steps cells are moved back, which GPUs need not count.
const DEPTH_TOLERANCE_M: f32 = 3e-3;

/// Pixels of faces seen edge-on: their depths are arbitrary, and the pixels may be an image's only ones.
const MAX_DIFFERING_DEPTHS: usize = 8;

/// How far beside the camera may be with which the CPU draws a pixel's colour: a few of the 256ths of a pixel to which
/// vertices are rounded.
const SHIFT_PX: f64 = 0.02;

/// The share of pixels with content that may differ all the same, and the number that may in images with less content
/// than that is a share of: a single pixel of a side that is seen edge-on, whose colours are arbitrary.
const MAX_DIFFERING: f64 = 0.005;
const MAX_DIFFERING_PX: usize = 1;

/// Scenes drawn by each test in a run.
const CASES: u32 = 150;

/// Scenes that once differed, one line each.
const REGRESSIONS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/gpu_cpu.proptest-regressions");

fn gpu() -> &'static Mutex<GpuRenderer> {
    static GPU: OnceLock<Mutex<GpuRenderer>> = OnceLock::new();
    GPU.get_or_init(|| Mutex::new(GpuRenderer::new(false).unwrap()))
}

fn place() -> impl Strategy<Value = [f32; 3]> {
    [-1.0_f32..1.0, -1.0_f32..1.0, -1.0_f32..1.0]
}

fn blending() -> impl Strategy<Value = Blending> {
    prop_oneof![Just(Blending::Replace), Just(Blending::Alpha)]
}

fn style() -> impl Strategy<Value = PointStyle> {
    let side = || 0.02_f32..0.4;
    prop_oneof![
        (1.0_f32..30.0).prop_map(|diameter_px| PointStyle::Points { diameter_px }),
        [side(), side()].prop_map(|size_m| PointStyle::Squares { size_m }),
        side().prop_map(|side_m| PointStyle::FlatSquares { side_m }),
        [side(), side()].prop_map(|size_m| PointStyle::Spheres { size_m }),
        [side(), side(), side()].prop_map(|size_m| PointStyle::Boxes { size_m }),
        [side(), side()].prop_map(|size_m| PointStyle::Tiles { size_m, normal: [0.0, 0.6, 0.8], up: [1.0, 0.0, 0.0] }),
    ]
}

fn cloud() -> impl Strategy<Value = Geometry> {
    (vec((place(), any::<[u8; 4]>()), 1..30), style(), 0.2_f32..1.0, any::<bool>()).prop_map(
        |(points, style, alpha, blended)| {
            let (positions, colors) = points.into_iter().unzip();
            Geometry::Points(Points {
                buffer: Arc::new(PointBuffer { positions, colors: PointColors::PerPoint(colors) }),
                style,
                alpha: if blended { alpha } else { 1.0 },
                blended,
                auto_size: false,
            })
        },
    )
}

fn lines() -> impl Strategy<Value = Geometry> {
    (vec((place(), any::<[u8; 4]>()), 2..12), any::<bool>(), blending()).prop_map(|(vertices, strip, blending)| {
        let (positions, colors) = vertices.into_iter().unzip();
        let topology = if strip { LineTopology::Strip } else { LineTopology::List };
        Geometry::Lines(Arc::new(Lines { positions, colors, topology, blending }))
    })
}

fn ribbons() -> impl Strategy<Value = Geometry> {
    let element = (place(), any::<[u8; 4]>()).prop_map(|(position, color)| RibbonElement { position, color });
    (vec(vec(element, 2..6), 1..3), 0.01_f32..0.2, blending())
        .prop_map(|(chains, width_m, blending)| Geometry::Ribbons(Arc::new(Ribbons { chains, width_m, blending })))
}

fn texture() -> impl Strategy<Value = Texture> {
    let filtering = prop_oneof![Just(Filtering::Nearest), Just(Filtering::Bilinear)];
    (vec([0_u8..120, 60_u8..180, 100_u8..255, 200_u8..255], 12..13), filtering, any::<bool>()).prop_map(
        |(rgba, filtering, repeat)| {
            let wrapping = if repeat { Wrapping::Repeat } else { Wrapping::Clamp };
            Texture { width: 4, height: 3, rgba, filtering, wrapping }
        },
    )
}

fn material() -> impl Strategy<Value = Material> {
    let cull = prop_oneof![Just(CullMode::None), Just(CullMode::Back), Just(CullMode::Front)];
    (any::<[bool; 3]>(), [0.0_f32..1.0, 0.0_f32..1.0, 0.2_f32..1.0], cull, proptest::option::of(texture())).prop_map(
        |([lit, vertex_colors, translucent], [red, glow, alpha], cull, texture)| Material {
            lighting: if lit {
                Lighting::Lit {
                    diffuse: Rgba::new(red, 0.5, 1.0, if translucent { alpha } else { 1.0 }),
                    emissive: Rgba::new(glow, 0.1, 0.0, 1.0),
                }
            } else {
                Lighting::Unlit
            },
            vertex_colors,
            texture: texture.map(Arc::new),
            cull,
            ..Material::unlit(translucent)
        },
    )
}

fn mesh() -> impl Strategy<Value = Geometry> {
    let soup = vec((place(), place(), [0.0_f32..2.0, 0.0_f32..2.0], any::<[u8; 4]>()), 3..18).prop_map(|corners| {
        let vertices = corners.into_iter().map(|(position, normal, uv, color)| {
            let normal = Vector3::from(normal).try_normalize(1e-3).unwrap_or(Vector3::x()).into();
            Vertex { position, normal, uv, color }
        });
        let vertices: Vec<_> = vertices.collect();
        let indices = (0..vertices.len() as u32 / 3 * 3).collect();
        Mesh { vertices, indices }
    });
    (prop_oneof![soup, Just(square_mesh())], material())
        .prop_map(|(mesh, material)| Geometry::Mesh { mesh: Arc::new(mesh), material: Arc::new(material) })
}

fn text() -> impl Strategy<Value = Geometry> {
    ("[a-zA-Z0-9 ]{1,8}", 0.1_f32..0.4, any::<bool>()).prop_map(|(caption, height_m, on_top)| {
        let alignment = (HorizontalAlignment::Center, VerticalAlignment::Center);
        let text = Text::new(&caption, height_m, Rgba::new(1.0, 0.9, 0.5, 1.0), alignment);
        Geometry::Text(Arc::new(if on_top { text.on_top() } else { text }))
    })
}

fn cells() -> impl Strategy<Value = Geometry> {
    (vec(any::<u8>(), 12..13), 0.2_f32..1.0, blending(), any::<bool>()).prop_map(
        |(values, alpha, blending, depth_write)| {
            let palette = std::array::from_fn(|value| [value as u8, 255 - value as u8, 99, 255 - value as u8 / 2]);
            Geometry::Cells(CellSheet {
                cells: Arc::new(Cells::new(4, 3, &values)),
                palette: Arc::new(palette),
                alpha,
                blending,
                depth_write,
            })
        },
    )
}

fn drawable() -> impl Strategy<Value = Drawable> {
    placed(prop_oneof![3 => cloud(), 1 => lines(), 1 => ribbons(), 3 => mesh(), 1 => text()], 2.0)
}

/// Turned by at most so much about each axis.
fn placed(geometry: impl Strategy<Value = Geometry>, max_turn_rad: f64) -> impl Strategy<Value = Drawable> {
    let group = prop_oneof![8 => Just(RenderGroup::Main), 1 => Just(RenderGroup::Above)];
    (place(), place(), prop_oneof![3 => Just(1.0_f64), 1 => 0.3..2.0, 1 => Just(-1.0)], group, geometry).prop_map(
        move |(place, turn, scale, group, geometry)| {
            let place = Vector3::from(place).cast::<f64>() + Vector3::new(0.0, 0.0, 2.2);
            let turn = UnitQuaternion::from_scaled_axis(Vector3::from(turn).cast::<f64>() * max_turn_rad);
            // Only meshes are ever mirrored.
            let scale = if matches!(geometry, Geometry::Mesh { .. }) { scale } else { scale.abs() };
            Drawable {
                display: 0,
                fixed_from_object: Isometry3::from_parts(place.into(), turn).to_homogeneous()
                    * Matrix4::new_nonuniform_scaling(&Vector3::new(scale, 1.0, 1.0)),
                sort_point: Point3::from(place),
                group,
                geometry,
            }
        },
    )
}

proptest! {
    // Other scenes in each run; `PROPTEST_RNG_SEED=N` repeats a run, `PROPTEST_CASES=N` draws more. A scene that fails
    // is kept and drawn first from then on.
    #![proptest_config(ProptestConfig {
        cases: if env::var_os("PROPTEST_CASES").is_some() { ProptestConfig::default().cases } else { CASES },
        failure_persistence: Some(Box::new(FileFailurePersistence::Direct(REGRESSIONS))),
        ..ProptestConfig::default()
    })]

    #[test]
    fn both_draw_the_same_image(
        drawables in vec(drawable(), 1..6),
        size in (60_u32..200, 60_u32..200),
        lit in any::<bool>(),
        turn in place(),
    ) {
        both_agree(drawables, size, lit, turn)?;
    }

    #[test]
    fn both_draw_the_same_cells(
        // At a grazing angle cells are so narrow that the pixels beside do not have their colours.
        drawables in vec(placed(prop_oneof![2 => cells(), 1 => mesh()], 0.6), 1..4),
        size in (60_u32..200, 60_u32..200),
        turn in place(),
    ) {
        both_agree(drawables, size, true, turn)?;
    }
}

/// A sheet larger than most textures can be: its parts as a whole, and each cell in its last corner.
#[test]
fn both_draw_thousands_of_cells_a_side() {
    let (columns, rows, block) = (6000_u32, 4500_u32, 1500);
    let last =
        |x: u32, y: u32| (x >= columns - 4 && y >= rows - 3).then(|| 100 + (x + 4 - columns) + 4 * (y + 3 - rows));
    let value = |x: u32, y: u32| last(x, y).unwrap_or(10 + x / block + 4 * (y / block)) as u8;
    let values: Vec<u8> = (0..rows).flat_map(|y| (0..columns).map(move |x| value(x, y))).collect();
    let sheet = CellSheet {
        cells: Arc::new(Cells::new(columns, rows, &values)),
        palette: Arc::new(std::array::from_fn(|value| [value as u8, 0, 0, 255])),
        alpha: 1.0,
        blending: Blending::Replace,
        depth_write: true,
    };
    // One metre wide and 0.75 m high, so that cells are square; 2 m away.
    let drawn = |middle: [f64; 2], focal_px: f64| {
        let mut drawable = common::at(-middle[0], -middle[1], 2.0, Geometry::Cells(sheet.clone()));
        drawable.fixed_from_object *= Matrix4::new_nonuniform_scaling(&Vector3::new(1.0, 0.75, 1.0));
        let (scene, camera) = (common::scene([drawable]), camera(4, 3, focal_px));
        let mut gpu = gpu().lock().unwrap_or_else(PoisonError::into_inner);
        let images = [common::draw(&mut *gpu, &scene, &camera), common::draw(&mut CpuRenderer::new(), &scene, &camera)];
        images.map(|image| (0..12).map(|i| common::pixel(&image, i % 4, i / 4)[0]).collect::<Vec<u8>>())
    };
    let from = |first: u8| (first..first + 12).collect::<Vec<u8>>();
    assert_eq!(drawn([0.5, 0.375], 8.0), [from(10), from(10)]);
    let pixel_m = 1.0 / f64::from(columns);
    assert_eq!(drawn([1.0 - 2.0 * pixel_m, 0.75 - 1.5 * pixel_m], 2.0 / pixel_m), [from(100), from(100)]);
}

/// The largest difference of a pixel of both renderers' images of one line, which are drawn in the same pixels.
fn worst_of_a_line(positions: Vec<[f32; 3]>, colors: Vec<[u8; 4]>) -> u8 {
    let lines = Lines { positions, colors, topology: LineTopology::List, blending: Blending::Replace };
    let scene = common::scene([common::at(0.0, 0.0, 0.0, Geometry::Lines(lines.into()))]);
    let camera = camera(128, 128, 1.0);
    let from_gpu = common::draw(&mut *gpu().lock().unwrap_or_else(PoisonError::into_inner), &scene, &camera);
    let from_cpu = common::draw(&mut CpuRenderer::new(), &scene, &camera);
    let lit = common::lit_pixels(&from_cpu);
    assert_eq!(common::lit_pixels(&from_gpu), lit);
    let differences =
        lit.iter().map(|&(x, y)| common::difference(common::pixel(&from_gpu, x, y), common::pixel(&from_cpu, x, y)));
    differences.max().unwrap_or(0)
}

/// Along a line of a few pixels colours change much from pixel to pixel, and its ends are anywhere in theirs.
#[test]
fn both_color_each_pixel_of_a_short_line_the_same() {
    for turn in 0_u8..48 {
        let (sin, cos) = (f32::from(turn) * std::f32::consts::PI / 24.0 + 0.01).sin_cos();
        let length_px = 2.0 + 0.13 * f32::from(turn);
        let start = [0.017 * f32::from(turn), 0.31 + 0.011 * f32::from(turn), 1.0];
        // Twice as far at the end, so that colours are not linear in the image.
        let end = [2.0 * (start[0] + length_px * cos), 2.0 * (start[1] + length_px * sin), 2.0];
        let worst = worst_of_a_line(vec![start, end], vec![[0, 0, 255, 255], [255, 120, 0, 255]]);
        assert!(worst <= 3, "{worst} levels at turn {turn}");
    }
}

/// The far end of a steep line is extended by more than its depth allows; the colour is the same all along.
#[test]
fn both_color_a_line_of_one_color_the_same() {
    for step in 0_u8..60 {
        let length_px = 20.0 + 0.7 * f32::from(step);
        let start = [1.5 * (0.03 * f32::from(step) - 40.0), 1.5 * 0.2, 1.5];
        let end = [100.0 * (start[0] / 1.5 + length_px), 100.0 * (0.2 + 0.02 * f32::from(step)), 100.0];
        let worst = worst_of_a_line(vec![start, end], vec![[90, 200, 255, 255]]);
        assert!(worst <= 1, "{worst} levels at {length_px} px");
    }
}

fn both_agree(mut drawables: Vec<Drawable>, size: (u32, u32), lit: bool, turn: [f32; 3]) -> Result<(), TestCaseError> {
    let direction = Vector3::new(0.3, 0.4, 1.0).normalize();
    (0..).zip(&mut drawables).for_each(|(index, drawable)| drawable.display = index % DISPLAYS);
    let scene = Scene { drawables, light: lit.then_some(DirectionalLight { direction }) };
    let straight = *camera(size.0, size.1, 120.0).intrinsics();
    let turn = UnitQuaternion::from_scaled_axis(Vector3::from(turn).cast::<f64>() * 0.3);
    let shifted = |right_px: f64, down_px: f64| {
        let intrinsics = Intrinsics { cx_px: straight.cx_px + right_px, cy_px: straight.cy_px + down_px, ..straight };
        Camera::new(intrinsics, &Isometry3::from_parts(Vector3::zeros().into(), turn), 0.01)
    };
    let cpu = |camera: &Camera| draw_on(&mut CpuRenderer::new(), &scene, camera, BACKGROUND).unwrap();
    let camera = shifted(0.0, 0.0);
    let from_gpu = draw_on(&mut *gpu().lock().unwrap_or_else(PoisonError::into_inner), &scene, &camera, BACKGROUND);
    let from_gpu = from_gpu.unwrap();
    let (content, mut differing) = differing(&from_gpu, &cpu(&camera), BACKGROUND, LEVELS, REACH_PX);
    if !differing.is_empty() {
        let shifts = [-SHIFT_PX, 0.0, SHIFT_PX];
        let nearby: Vec<Image> =
            shifts.iter().flat_map(|&right| shifts.map(|down| cpu(&shifted(right, down)))).collect();
        differing.retain(|&(x, y)| {
            let colors = nearby.iter().map(|image| common::pixel(image, x, y));
            let color = common::pixel(&from_gpu, x, y);
            !colors.into_iter().any(|nearby| common::difference(nearby, color) <= LEVELS)
        });
    }
    let allowed = MAX_DIFFERING_PX.max((f64::from(content) * MAX_DIFFERING) as usize);
    prop_assert!(differing.len() <= allowed, "{differing:?} of {content} pixels differ, at most {allowed} may");
    depths_agree(
        &scene,
        &[-SHIFT_PX, 0.0, SHIFT_PX].map(|right| [-SHIFT_PX, 0.0, SHIFT_PX].map(|down| shifted(right, down))),
    )
}

/// Displays that the drawables belong to in turn; the first one's objects are compared.
const DISPLAYS: u32 = 2;

/// The GPU's depths at the camera in the middle are those of the CPU there, or at a camera beside it.
fn depths_agree(scene: &Scene, cameras: &[[Camera; 3]; 3]) -> Result<(), TestCaseError> {
    let (visible, mut listed) = (DisplayMask::all(), DisplayMask::all());
    (1..DISPLAYS).for_each(|display| listed.set(display, false));
    let depths = |renderer: &mut dyn Renderer, camera: &Camera| {
        let view = View { scene, camera, visible: &visible, background: BACKGROUND, encoding: Encoding::Mono8 };
        let (mut image, mut depths) = (Image::default(), Depths::default());
        let request = DepthRequest { opaque: true, objects_of: Some(&listed) };
        renderer.submit_with_depths(&view, &request).unwrap();
        assert_eq!(renderer.finish_with_depths(&mut image, &mut depths).unwrap(), Finished::Drawn);
        depths
    };
    let camera = &cameras[1][1];
    let from_gpu = depths(&mut *gpu().lock().unwrap_or_else(PoisonError::into_inner), camera);
    let mut cpu = CpuRenderer::new();
    let from_cpu: Vec<Depths> = cameras.iter().flatten().map(|camera| depths(&mut cpu, camera)).collect();
    type Kind = fn(&Depths) -> &DepthImage;
    let kinds: [(&str, Kind); 2] = [("opaque", |depths| &depths.opaque), ("objects", |depths| &depths.objects)];
    for (kind, of) in kinds {
        let from_cpu: Vec<&DepthImage> = from_cpu.iter().map(of).collect();
        let content = from_cpu[0].depths_m.iter().filter(|depth_m| !depth_m.is_nan()).count();
        let differing = unlike(of(&from_gpu), &from_cpu);
        let allowed = MAX_DIFFERING_DEPTHS.max((content as f64 * MAX_DIFFERING) as usize);
        prop_assert!(differing.len() <= allowed, "{kind}: {differing:?} of {content} differ, at most {allowed} may");
    }
    Ok(())
}

/// The pixels of `a` whose depths are not among those around them in images of the same size.
fn unlike(a: &DepthImage, others: &[&DepthImage]) -> Vec<([i64; 2], f32)> {
    let [width, height] = [a.width_px, a.height_px].map(i64::from);
    let is_like = |x: i64, y: i64, depth_m: f32| {
        let rows = (y - REACH_PX).max(0)..(y + REACH_PX + 1).min(height);
        let columns = (x - REACH_PX).max(0)..(x + REACH_PX + 1).min(width);
        let around = rows.flat_map(|y| columns.clone().map(move |x| (y * width + x) as usize));
        let around = around.flat_map(|at| others.iter().map(move |other| other.depths_m[at]));
        let (nowhere, there): (Vec<f32>, Vec<f32>) = around.partition(|depth_m| depth_m.is_nan());
        if depth_m.is_nan() {
            return !nowhere.is_empty();
        }
        let nearest = there.iter().copied().fold(f32::INFINITY, f32::min);
        let farthest = there.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        (nearest - DEPTH_TOLERANCE_M..=farthest + DEPTH_TOLERANCE_M).contains(&depth_m)
    };
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| [x, y])).zip(a.depths_m.iter().copied());
    pixels.filter(|&([x, y], depth_m)| !is_like(x, y, depth_m)).collect()
}
