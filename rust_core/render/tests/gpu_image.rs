//! Pixels of the GPU renderer's images, on any adapter (Mesa's software Vulkan will do).
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod common;

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use common::{at, camera, draw_on, lit_pixels, pixel, points, scene, square_mesh};
use nalgebra::{Matrix4, Vector3};
use rcs_render::{GpuRenderer, RenderError, Renderer, View};
use rcs_scene::{
    Blending, Camera, CellSheet, Cells, CullMode, DisplayMask, Drawable, Encoding, Geometry, Image, Material,
    PointStyle, Rgba, Scene, Vertex,
};

const RED: [u8; 4] = [255, 0, 0, 255];

fn gpu() -> std::sync::MutexGuard<'static, GpuRenderer> {
    static GPU: OnceLock<Mutex<GpuRenderer>> = OnceLock::new();
    let gpu = GPU.get_or_init(|| Mutex::new(GpuRenderer::new(false).unwrap()));
    gpu.lock().unwrap_or_else(PoisonError::into_inner)
}

fn drawn(scene: &Scene, camera: &Camera) -> Image {
    drawn_on(scene, camera, [0; 3])
}

fn drawn_on(scene: &Scene, camera: &Camera, background: [u8; 3]) -> Image {
    draw_on(&mut *gpu(), scene, camera, background).unwrap()
}

fn flat(z: f64, color: [u8; 4]) -> Drawable {
    at(0.0, 0.0, z, Geometry::Points(points(PointStyle::FlatSquares { side_m: 1.0 }, color, &[[0.0; 3]])))
}

fn colored_square(color: Rgba, material: Material) -> Geometry {
    let mut mesh = square_mesh();
    mesh.vertices.iter_mut().for_each(|v| v.color = color.to_rgba8());
    Geometry::Mesh { mesh: Arc::new(mesh), material: Arc::new(material) }
}

#[test]
fn an_empty_scene_is_the_background_in_every_encoding_and_odd_size() {
    let visible = DisplayMask::all();
    for (width, height) in [(1, 1), (3, 2), (65, 7), (641, 3)] {
        for encoding in Encoding::ALL {
            let camera = camera(width, height, 10.0);
            let view = View {
                scene: &Scene::default(),
                camera: &camera,
                visible: &visible,
                background: [10, 20, 30],
                encoding,
            };
            let mut image = Image { data: vec![7; 9], ..Image::default() };
            gpu().render(&view, &mut image).unwrap();
            let mut row = vec![0; image.step()];
            encoding.write_row(&vec![[10, 20, 30, 255]; width as usize], &mut row);
            assert_eq!((image.width_px, image.height_px), (width, height));
            assert_eq!(image.data, row.repeat(height as usize), "{width}×{height} {encoding:?}");
        }
    }
}

#[test]
fn a_point_covers_the_pixels_whose_centres_lie_within_its_circle() {
    let camera = camera(32, 24, 100.0);
    // Its centre is at pixel coordinates (16.3, 12.4).
    let center = [0.003, 0.004, 1.0];
    for diameter_px in [1.0_f32, 2.0, 5.0, 9.0, 21.5] {
        let cloud = points(PointStyle::Points { diameter_px }, RED, &[center]);
        let image = drawn(&scene([at(0.0, 0.0, 0.0, Geometry::Points(cloud))]), &camera);
        let mut expected = Vec::new();
        for (x, y) in (0..24).flat_map(|y| (0..32).map(move |x| (x, y))) {
            let (dx, dy) = (x as f32 + 0.5 - 16.3, y as f32 + 0.5 - 12.4);
            if dx * dx + dy * dy < diameter_px * diameter_px / 4.0 {
                expected.push((x, y));
            }
        }
        assert_eq!(lit_pixels(&image), expected, "{diameter_px} px");
    }
}

#[test]
fn a_image_of_several_bands_comes_back_whole() {
    let place = |column: u32, row: u32| [(column as f32 - 4095.5) / 100.0, (row as f32 - 1249.5) / 100.0, 1.0];
    let expected = [(8191, 0), (17, 2047), (17, 2048), (4000, 2499)];
    let positions = expected.map(|(column, row)| place(column, row));
    let cloud = points(PointStyle::Points { diameter_px: 1.0 }, RED, &positions);
    let image = drawn(&scene([at(0.0, 0.0, 0.0, Geometry::Points(cloud))]), &camera(8192, 2500, 100.0));
    assert_eq!(lit_pixels(&image), expected);
}

#[test]
fn the_back_is_culled_and_a_mirrored_object_keeps_its_front() {
    let camera = camera(20, 20, 20.0);
    let seen = |cull, transform: Matrix4<f64>| {
        let mut drawable = at(0.0, 0.0, 2.0, colored_square(Rgba::WHITE, Material { cull, ..Material::unlit(false) }));
        drawable.fixed_from_object *= transform;
        !lit_pixels(&drawn(&scene([drawable]), &camera)).is_empty()
    };
    let turned = Matrix4::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    let mirrored = Matrix4::new_nonuniform_scaling(&Vector3::new(-1.0, 1.0, 1.0));
    for (cull, [front, back]) in
        [(CullMode::Back, [true, false]), (CullMode::Front, [false, true]), (CullMode::None, [true, true])]
    {
        assert_eq!(seen(cull, Matrix4::identity()), front, "{cull:?}");
        assert_eq!(seen(cull, turned), back, "{cull:?} turned");
        assert_eq!(seen(cull, mirrored), front, "{cull:?} mirrored");
    }
}

#[test]
fn a_bias_lifts_a_surface_in_front_of_another_in_its_plane() {
    let turned = |mut drawable: Drawable| {
        drawable.fixed_from_object *= Matrix4::from_axis_angle(&Vector3::x_axis(), 0.6);
        drawable
    };
    let square = |color, depth_bias| {
        turned(at(0.0, 0.0, 2.0, colored_square(color, Material { depth_bias, ..Material::unlit(false) })))
    };
    let (red, green) = (Rgba::new(1.0, 0.0, 0.0, 1.0), Rgba::new(0.0, 1.0, 0.0, 1.0));
    let camera = camera(40, 40, 40.0);
    for bias in [1.0, 4.0] {
        let image = drawn(&scene([square(red, bias), square(green, 0.0)]), &camera);
        let lit = lit_pixels(&image);
        assert!(lit.len() > 200 && lit.iter().all(|&(x, y)| pixel(&image, x, y) == [255, 0, 0]), "{bias}");
    }
}

#[test]
fn a_new_geometry_is_drawn_where_an_old_one_was() {
    let camera = camera(10, 10, 10.0);
    for i in 0..200_u8 {
        let scene = scene([flat(1.0, [i, 255 - i, 7, 255])]);
        assert_eq!(pixel(&drawn(&scene, &camera), 5, 5), [i, 255 - i, 7]);
    }
}

#[test]
fn cells_that_change_are_drawn_changed_and_the_others_as_before() {
    let side = rcs_scene::TILE_SIDE;
    let camera = camera(4, 4, 8.0);
    let palette = Arc::new(std::array::from_fn(|value| [value as u8, 0, 0, 255]));
    let mut cells = Cells::new(2 * side, side, &[]);
    for left in 0..3 {
        cells.write([0, 0], side, &vec![left; (side * side) as usize]);
        if left == 1 {
            cells.write([side, 0], side, &vec![100; (side * side) as usize]);
        }
        let sheet = CellSheet {
            cells: Arc::new(cells.clone()),
            palette: Arc::clone(&palette),
            alpha: 1.0,
            blending: Blending::Replace,
            depth_write: true,
        };
        let scene = scene([at(-0.5, -0.5, 2.0, Geometry::Cells(sheet))]);
        let image = drawn(&scene, &camera);
        let right = if left == 0 { rcs_scene::UNSET_CELL } else { 100 };
        assert_eq!([pixel(&image, 1, 1), pixel(&image, 2, 1)], [[left, 0, 0], [right, 0, 0]]);
    }
}

#[test]
fn a_scene_far_from_the_origin_is_drawn_as_precisely_as_one_near() {
    let far = Vector3::new(500_000.0, 4_500_000.0, 100.0);
    let mut camera = camera(40, 40, 40.0);
    let near_image = drawn(&scene([flat(2.0, RED)]), &camera);
    camera = rcs_scene::Camera::new(*camera.intrinsics(), &nalgebra::Isometry3::translation(far.x, far.y, far.z), 0.01);
    let mut drawable = flat(2.0, RED);
    drawable.fixed_from_object = Matrix4::new_translation(&far) * drawable.fixed_from_object;
    assert_eq!(drawn(&scene([drawable]), &camera), near_image);
}

#[test]
fn thousands_of_drawables_are_all_drawn() {
    let camera = camera(100, 60, 100.0);
    let drawables = (0..6000).map(|i| {
        let (x, y) = (f64::from(i % 100), f64::from(i / 100));
        let style = PointStyle::Points { diameter_px: 1.0 };
        let place = [((x - 49.5) / 100.0) as f32, ((y - 29.5) / 100.0) as f32, 1.0];
        at(0.0, 0.0, 0.0, Geometry::Points(points(style, RED, &[place])))
    });
    assert_eq!(lit_pixels(&drawn(&scene(drawables), &camera)).len(), 6000);
}

#[test]
fn a_image_past_the_adapters_limit_is_refused_and_the_next_is_drawn() {
    let camera_of = |side: u32| camera(side, 1, 10.0);
    let result = draw_on(&mut *gpu(), &Scene::default(), &camera_of(16384), [1; 3]);
    match result {
        Ok(image) => assert_eq!(image.data.len(), 16384 * 4),
        Err(RenderError::TooLarge { width_px: 16384, limit_px, .. }) => assert!(limit_px < 16384),
        Err(error) => panic!("{error}"),
    }
    assert_eq!(pixel(&drawn_on(&Scene::default(), &camera_of(5), [1; 3]), 4, 0), [1; 3]);
}

#[test]
fn hardware_only_never_takes_a_software_driver() {
    match GpuRenderer::new(true) {
        Ok(gpu) => assert!(!gpu.describe().to_lowercase().contains("llvmpipe"), "{}", gpu.describe()),
        Err(error) => assert!(matches!(error, RenderError::NoAdapter { .. }), "{error}"),
    }
}

#[test]
fn triangles_with_nonfinite_vertices_or_missing_corners_are_dropped() {
    let mut mesh = square_mesh();
    mesh.vertices.push(Vertex::new([f32::NAN, 0.0, 0.0], [0.0; 3]));
    mesh.indices.extend([0, 1, 4, 0, 1, 99, 2, 3]);
    let material = Arc::new(Material::unlit(false));
    let broken = at(0.0, 0.0, 2.0, Geometry::Mesh { mesh: Arc::new(mesh), material: material.clone() });
    let whole = at(0.0, 0.0, 2.0, Geometry::Mesh { mesh: Arc::new(square_mesh()), material });
    let camera = camera(20, 20, 20.0);
    assert_eq!(drawn(&scene([broken]), &camera), drawn(&scene([whole]), &camera));
}
