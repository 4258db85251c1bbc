//! Scenes whose faces lie over each other many times, or with very much in them: the GPU renderer leaves them to the
//! CPU, and draws all others.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod heavy_common;

use std::sync::Arc;

use heavy_common::{camera_of, cloud, drawable, filling, rows, spread, Numbers, Row, SIZE_PX, TILT};
use nalgebra::{Matrix4, Vector3};
use rcs_render::{CpuRenderer, DepthRequest, Depths, Finished, GpuRenderer, Renderer, View};
use rcs_scene::{
    Blending, Camera, DisplayMask, Encoding, Geometry, LineTopology, Lines, Picture, PointStyle, Rgba, Scene, Solids,
};

/// How far the depths of both renderers may be apart: some steps of a depth buffer of 24 bits.
const DEPTH_TOLERANCE_M: f32 = 1e-3;

/// Shows a scene to a renderer.
fn with_view<T>(scene: &Scene, camera: &Camera, work: impl FnOnce(&View<'_>) -> T) -> T {
    let visible = DisplayMask::all();
    work(&View { scene, camera, visible: &visible, background: [20, 30, 40], encoding: Encoding::Rgb8 })
}

fn draw(renderer: &mut dyn Renderer, scene: &Scene, camera: &Camera) -> Picture {
    let mut picture = Picture::default();
    with_view(scene, camera, |view| renderer.render(view, &mut picture)).unwrap();
    picture
}

fn by_cpu(renderer: &GpuRenderer) -> u64 {
    renderer.stats().pictures_by_cpu
}

/// The scenes of the example heavy_scenes of which a software GPU would draw seconds: its faces cover 1,000 pictures
/// and more.
fn heavy_rows() -> impl Iterator<Item = Row> {
    rows(1.0).into_iter().filter(|row| row.name.contains("at 6 cm, f"))
}

#[test]
fn heavy_scenes_are_the_cpus() {
    let mut renderer = GpuRenderer::new(false).unwrap();
    let mut cpu = CpuRenderer::new();
    for row in heavy_rows() {
        let scene = row.scene();
        let before = by_cpu(&renderer);
        let picture = draw(&mut renderer, &scene, &row.camera);
        assert_eq!(by_cpu(&renderer), before + 1, "{}", row.name);
        assert!(picture == draw(&mut cpu, &scene, &row.camera), "{}", row.name);
    }
}

#[test]
fn scenes_in_which_little_lies_over_each_other_are_the_gpus() {
    let mut renderer = GpuRenderer::new(false).unwrap();
    let camera = camera_of(SIZE_PX, 1400.0, [0.0; 3]);
    let mut numbers = Numbers::new(7);
    // As a depth camera sees a room: 300,000 points of 4 mm a metre and more away, and a few that it does not see.
    let mut room: Vec<[f32; 3]> = (0..300_000)
        .map(|_| [numbers.between(-1.0, 1.0), numbers.between(-1.0, 1.0), numbers.between(1.0, 4.0)])
        .collect();
    room.extend([[0.0, 0.0, 0.06]; 100]);
    // Many that would be large, if they were not behind the eye or beside the picture.
    room.extend(
        (0..300_000).map(|_| [numbers.between(-0.1, 0.1), numbers.between(-0.1, 0.1), numbers.between(-0.1, -0.02)]),
    );
    room.extend(
        (0..300_000).map(|_| [numbers.between(0.1, 0.2), numbers.between(-0.1, 0.1), numbers.between(0.03, 0.06)]),
    );
    let style = PointStyle::FlatSquares { side_m: 0.004 };
    let drawables = vec![cloud(room, style, 1.0), filling(300, Blending::Replace, |i| 1.0 + i as f32 * 0.01)];
    draw(&mut renderer, &Scene { drawables, light: None }, &camera);
    assert_eq!(by_cpu(&renderer), 0);
}

/// What is hidden by a translucent face is seen, so that a GPU has no more to do than a CPU. A software driver is one.
#[test]
fn heavy_translucent_scenes_are_the_cpus_where_the_gpu_is_one() {
    let mut renderer = GpuRenderer::new(false).unwrap();
    let is_software = renderer.describe().contains("llvmpipe");
    let style = PointStyle::FlatSquares { side_m: 10.0 };
    let places = (0..500).map(|i| [0.0, 0.0, 3.0 - i as f32 * 0.004]).collect();
    let scene = Scene { drawables: vec![cloud(places, style, 0.5)], light: None };
    draw(&mut renderer, &scene, &camera_of(SIZE_PX, 1400.0, [0.0; 3]));
    assert_eq!(by_cpu(&renderer), u64::from(is_software));
}

/// Many things are the CPU's on all GPUs, many primitives on software ones.
#[test]
fn pictures_with_very_much_in_them_are_the_cpus() {
    let mut renderer = GpuRenderer::new(false).unwrap();
    let is_software = u64::from(renderer.describe().contains("llvmpipe"));
    let mut by_cpu_of = |scene: &Scene, visible: &DisplayMask| {
        let (before, mut picture) = (by_cpu(&renderer), Picture::default());
        let (camera, background) = (camera_of(SIZE_PX, 500.0, [0.0; 3]), [0; 3]);
        let view = View { scene, camera: &camera, visible, background, encoding: Encoding::Rgb8 };
        renderer.render(&view, &mut picture).unwrap();
        by_cpu(&renderer) - before
    };
    let all = DisplayMask::all();
    let one = |geometry: Geometry| Scene { drawables: vec![drawable(geometry)], light: None };
    // Cubes far away, each of two triangles.
    let shape = match filling(2, Blending::Replace, |i| i as f32).geometry {
        Geometry::Mesh { mesh, .. } => mesh,
        other => panic!("{other:?}"),
    };
    let solids = |count: usize| {
        let mut solids = Solids::default();
        for i in 0..count {
            let place = Matrix4::new_translation(&Vector3::new(i as f64, 0.0, 9e3)).prepend_scaling(1e-3);
            solids.push(&shape, &place, Rgba::WHITE);
        }
        one(Geometry::Solids(Arc::new(solids)))
    };
    assert_eq!([7_999, 8_001].map(|count| by_cpu_of(&solids(count), &all)), [0, 1]);
    // A display that the camera does not show counts for nothing.
    let mut hidden = DisplayMask::all();
    hidden.set(0, false);
    assert_eq!(by_cpu_of(&solids(8_001), &hidden), 0);
    // After a picture of nothing the GPU draws again up to its limit.
    let mut of_both = |below: Scene, above: Scene| {
        by_cpu_of(&Scene::default(), &all);
        [below, above].map(|scene| by_cpu_of(&scene, &all))
    };
    let lines = |count: usize| {
        let positions = vec![[0.0, 0.0, 5.0]; 2 * count];
        let (colors, topology) = (vec![[255; 4]], LineTopology::List);
        one(Geometry::Lines(Arc::new(Lines { positions, colors, topology, blending: Blending::Replace })))
    };
    assert_eq!(of_both(lines(250_000), lines(250_001)), [0, is_software]);
    let points = |count: usize| Scene {
        drawables: vec![cloud(vec![[0.0, 0.0, 5.0]; count], PointStyle::Points { diameter_px: 1.0 }, 1.0)],
        light: None,
    };
    assert_eq!(of_both(points(1_000_000), points(1_000_001)), [0, is_software]);
    let layers =
        |count: usize| Scene { drawables: vec![filling(count, Blending::Alpha, |i| -1.0 - i as f32)], light: None };
    assert_eq!(of_both(layers(500_000), layers(500_001)), [0, is_software]);
}

#[test]
fn pictures_of_both_renderers_are_returned_in_their_order_with_their_depths() {
    let camera = camera_of(SIZE_PX, 1400.0, TILT);
    let near = spread(200_000, 1400.0, 0.06);
    let heavy = Scene { drawables: vec![cloud(near, PointStyle::FlatSquares { side_m: 0.01 }, 1.0)], light: None };
    let light = Scene { drawables: vec![filling(3, Blending::Replace, |i| 2.0 + i as f32)], light: None };
    let scenes = [&heavy, &light, &light, &heavy, &light, &heavy];
    let mut renderer = GpuRenderer::new(false).unwrap();
    let alone = [&heavy, &light].map(|scene| draw(&mut renderer, scene, &camera));
    assert!(alone[0] != alone[1]);
    let before = by_cpu(&renderer);
    let request = DepthRequest { opaque: true, objects_of: None };
    for scene in scenes {
        with_view(scene, &camera, |view| renderer.submit_with_depths(view, &request)).unwrap();
    }
    assert_eq!(by_cpu(&renderer), before + 3);
    let (mut picture, mut depths, mut expected) = (Picture::default(), Depths::default(), Depths::default());
    for scene in scenes {
        assert_eq!(renderer.finish_with_depths(&mut picture, &mut depths).unwrap(), Finished::Drawn);
        assert!(picture == alone[usize::from(std::ptr::eq(scene, &light))]);
        let mut cpu = CpuRenderer::new();
        with_view(scene, &camera, |view| cpu.submit_with_depths(view, &request)).unwrap();
        assert_eq!(cpu.finish_with_depths(&mut Picture::default(), &mut expected).unwrap(), Finished::Drawn);
        let pairs = depths.opaque.depths_m.iter().zip(&expected.opaque.depths_m);
        let differing = pairs.filter(|(found, expected)| {
            let is_same = (*found - *expected).abs() < DEPTH_TOLERANCE_M;
            !(is_same || found.is_nan() && expected.is_nan())
        });
        assert_eq!(differing.count(), 0);
    }
    assert_eq!(renderer.finish(&mut picture).unwrap(), Finished::NoneInFlight);
}
