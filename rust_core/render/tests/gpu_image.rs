//! Pixels of the GPU renderer's images, on any adapter (Mesa's software Vulkan will do).
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod common;

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use common::{at, camera, difference, draw_on, lit_pixels, pixel, points, scene, square_mesh};
use nalgebra::{Matrix4, Vector3};
use rcs_render::{GpuRenderer, RenderError, Renderer, View};
use rcs_scene::{
    Blending, Camera, CellSheet, Cells, CullMode, DisplayMask, Drawable, Encoding, Filtering, Geometry,
    HorizontalAlignment, Image, Lighting, LineTopology, Lines, Material, PointBuffer, PointColors, PointStyle, Points,
    RenderGroup, Rgba, RibbonElement, Ribbons, Scene, Text, Texture, Vertex, VerticalAlignment, Wrapping,
};

const RED: [u8; 4] = [255, 0, 0, 255];
const GREEN: [u8; 4] = [0, 255, 0, 255];

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
fn a_point_whose_centre_is_off_the_image_is_not_drawn() {
    let camera = camera(32, 24, 100.0);
    let style = PointStyle::Points { diameter_px: 9.0 };
    let off = [[-0.17, 0.0, 1.0], [0.17, 0.0, 1.0], [0.0, -0.13, 1.0], [0.0, 0.13, 1.0], [0.0, 0.0, -1.0], [0.0; 3]];
    let image = drawn(&scene([at(0.0, 0.0, 0.0, Geometry::Points(points(style, RED, &off)))]), &camera);
    assert_eq!(lit_pixels(&image), []);
}

#[test]
fn a_cloud_whose_centres_are_all_off_the_image_is_culled() {
    let style = PointStyle::FlatSquares { side_m: 1.0 };
    let camera = camera(40, 40, 40.0);
    let seen = |positions: &[[f32; 3]]| {
        let cloud = at(0.0, 0.0, 0.0, Geometry::Points(points(style, RED, positions)));
        lit_pixels(&drawn(&scene([cloud]), &camera)).iter().any(|&(x, _)| x > 30)
    };
    assert!(!seen(&[[0.6, 0.0, 1.0], [0.7, 0.0, 1.0]]));
    assert!(seen(&[[0.6, 0.0, 1.0], [-0.4, 0.0, 1.0]]));
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
fn a_square_has_the_size_that_the_camera_gives_it() {
    let image = drawn(&scene([flat(2.0, RED)]), &camera(40, 40, 40.0));
    let expected: Vec<_> = (10..30).flat_map(|y| (10..30).map(move |x| (x, y))).collect();
    assert_eq!(lit_pixels(&image), expected);
}

#[test]
fn squares_have_a_contrasting_edge_spheres_are_darker_there_and_boxes_half_as_bright() {
    let camera = camera(200, 200, 200.0);
    let colors = |style, color, columns: [u32; 2]| {
        let cloud = Geometry::Points(points(style, color, &[[0.0; 3]]));
        let image = drawn(&scene([at(0.0, 0.0, 2.0, cloud)]), &camera);
        columns.map(|x| pixel(&image, x, 100))
    };
    let squares = PointStyle::Squares { size_m: [1.0; 2] };
    assert_eq!(colors(squares, [40, 40, 80, 255], [100, 148]), [[40, 40, 80], [91, 91, 131]]);
    assert_eq!(colors(squares, [200, 100, 60, 255], [100, 148]), [[200, 100, 60], [149, 49, 9]]);
    let spheres = PointStyle::Spheres { size_m: [1.0; 2] };
    let [middle, edge] = colors(spheres, [200, 100, 50, 255], [100, 148]);
    assert!(difference(middle, [200, 100, 50]) <= 1 && difference(edge, [162, 81, 41]) <= 1, "{middle:?} {edge:?}");
    // The side towards -z has a shade of one half; at 1.625 m it reaches 46.15 pixels to each side.
    let boxes = PointStyle::Boxes { size_m: [0.75; 3] };
    assert_eq!(colors(boxes, [200, 100, 48, 255], [100, 145]), [[100, 50, 24], [50, 25, 12]]);
}

#[test]
fn an_eye_inside_of_a_box_does_not_see_it() {
    let cloud = points(PointStyle::Boxes { size_m: [1.0; 3] }, RED, &[[0.0, 0.0, 0.3]]);
    let image = drawn(&scene([at(0.0, 0.0, 0.0, Geometry::Points(cloud))]), &camera(20, 20, 20.0));
    assert_eq!(lit_pixels(&image), []);
}

#[test]
fn tiles_are_oriented_by_their_normal_and_up() {
    let style = PointStyle::Tiles { size_m: [1.0, 0.5], normal: [0.0, 0.0, -1.0], up: [0.0, -1.0, 0.0] };
    let cloud = Geometry::Points(points(style, RED, &[[0.0; 3]]));
    let image = drawn(&scene([at(0.0, 0.0, 2.0, cloud)]), &camera(40, 40, 40.0));
    let expected: Vec<_> = (15..25).flat_map(|y| (10..30).map(move |x| (x, y))).collect();
    assert_eq!(lit_pixels(&image), expected);
}

#[test]
fn auto_size_multiplies_by_the_points_z() {
    let mut cloud = points(PointStyle::FlatSquares { side_m: 0.25 }, RED, &[[0.0, 0.0, 2.0]]);
    let side = |cloud: &Points| {
        let scene = scene([at(0.0, 0.0, 0.0, Geometry::Points(cloud.clone()))]);
        lit_pixels(&drawn(&scene, &camera(80, 80, 80.0))).len()
    };
    assert_eq!(side(&cloud), 10 * 10);
    cloud.auto_size = true;
    assert_eq!(side(&cloud), 20 * 20);
}

#[test]
fn the_nearer_hides_the_farther_and_the_later_wins_at_equal_depth() {
    let camera = camera(10, 10, 10.0);
    let middle = |drawables: [Drawable; 2]| pixel(&drawn(&scene(drawables), &camera), 5, 5);
    assert_eq!(middle([flat(2.0, RED), flat(3.0, GREEN)]), [255, 0, 0]);
    assert_eq!(middle([flat(3.0, GREEN), flat(2.0, RED)]), [255, 0, 0]);
    assert_eq!(middle([flat(2.0, RED), flat(2.0, GREEN)]), [0, 255, 0]);
    let mut behind = flat(1.0, RED);
    behind.group = RenderGroup::Behind;
    assert_eq!(middle([flat(1.0, GREEN), behind]), [0, 255, 0]);
}

#[test]
fn translucent_points_blend_and_leave_no_depth() {
    let translucent = |z, color| {
        let mut drawable = flat(z, color);
        if let Geometry::Points(points) = &mut drawable.geometry {
            (points.alpha, points.blended) = (0.5, true);
        }
        drawable
    };
    let scene = scene([translucent(1.0, GREEN), translucent(3.0, RED), flat(4.0, [0, 0, 255, 255])]);
    let [r, g, b] = pixel(&drawn(&scene, &camera(10, 10, 10.0)), 5, 5);
    assert!(difference([r, g, b], [64, 128, 64]) <= 1, "{r} {g} {b}");
}

#[test]
fn invisible_points_are_not_drawn_whether_they_blend_or_not() {
    for blended in [false, true] {
        let mut cloud = points(PointStyle::FlatSquares { side_m: 1.0 }, RED, &[[0.0; 3]]);
        (cloud.alpha, cloud.blended) = (0.0015, blended);
        let drawables = [at(0.0, 0.0, 1.0, Geometry::Points(cloud)), flat(2.0, GREEN)];
        assert_eq!(pixel(&drawn(&scene(drawables), &camera(10, 10, 10.0)), 5, 5), [0, 255, 0]);
    }
}

#[test]
fn every_point_has_its_own_colour() {
    let buffer = PointBuffer {
        positions: vec![[-0.25, 0.0, 1.0], [0.25, 0.0, 1.0]],
        colors: PointColors::PerPoint(vec![RED, GREEN]),
    };
    let style = PointStyle::FlatSquares { side_m: 0.4 };
    let cloud = Points { buffer: Arc::new(buffer), style, alpha: 1.0, blended: false, auto_size: false };
    let image = drawn(&scene([at(0.0, 0.0, 0.0, Geometry::Points(cloud))]), &camera(20, 20, 20.0));
    assert_eq!([5, 15].map(|x| pixel(&image, x, 10)), [[255, 0, 0], [0, 255, 0]]);
}

fn line(positions: &[[f32; 3]], topology: LineTopology) -> Drawable {
    let lines = Lines { positions: positions.to_vec(), colors: vec![[255; 4]], topology, blending: Blending::Replace };
    at(0.0, 0.0, 0.0, Geometry::Lines(Arc::new(lines)))
}

#[test]
fn a_flat_line_has_a_pixel_in_every_column_and_a_steep_one_in_every_row() {
    let camera = camera(40, 40, 40.0);
    let flat = line(&[[-0.45, -0.2, 1.0], [0.45, 0.1, 1.0]], LineTopology::List);
    let columns: Vec<_> = lit_pixels(&drawn(&scene([flat]), &camera)).iter().map(|p| p.0).collect();
    let mut sorted = columns.clone();
    sorted.sort_unstable();
    assert_eq!(sorted, (2..38).collect::<Vec<_>>());
    let steep = line(&[[-0.2, -0.45, 1.0], [0.1, 0.45, 1.0]], LineTopology::List);
    let rows: Vec<_> = lit_pixels(&drawn(&scene([steep]), &camera)).iter().map(|p| p.1).collect();
    assert_eq!(rows, (2..38).collect::<Vec<_>>());
}

#[test]
fn a_line_through_the_near_plane_is_cut_there() {
    let image =
        drawn(&scene([line(&[[0.01, 0.1, 1.0], [0.01, 0.1, -1.0]], LineTopology::List)]), &camera(40, 40, 40.0));
    let lit = lit_pixels(&image);
    assert_eq!(lit.first().map(|p| p.1), Some(24));
    assert_eq!(lit.len(), 16, "{lit:?}");
}

#[test]
fn a_strip_joins_the_vertices_that_a_list_leaves_apart() {
    let corners = [[-0.4, 0.0, 1.0], [-0.1, 0.0, 1.0], [0.1, 0.0, 1.0], [0.4, 0.0, 1.0]];
    let camera = camera(40, 40, 40.0);
    let [list, strip] = [LineTopology::List, LineTopology::Strip]
        .map(|topology| lit_pixels(&drawn(&scene([line(&corners, topology)]), &camera)).len());
    assert_eq!((list, strip), (24, 32));
}

#[test]
fn a_ribbon_turns_its_width_to_the_eye() {
    let chain = [-0.4_f32, 0.4].map(|x| RibbonElement { position: [x, 0.0, 0.0], color: RED }).to_vec();
    let ribbons = Arc::new(Ribbons { chains: vec![chain], width_m: 0.2, blending: Blending::Replace });
    for turn in [0.0, 0.7, 2.0] {
        let mut drawable = at(0.0, 0.0, 1.0, Geometry::Ribbons(ribbons.clone()));
        drawable.fixed_from_object *= Matrix4::from_axis_angle(&Vector3::x_axis(), turn);
        let image = drawn(&scene([drawable]), &camera(40, 40, 40.0));
        let expected: Vec<_> = (16..24).flat_map(|y| (4..36).map(move |x| (x, y))).collect();
        assert_eq!(lit_pixels(&image), expected, "turned by {turn}");
    }
}

#[test]
fn a_lit_surface_is_as_bright_as_the_cosine_to_the_light_and_black_without_light() {
    let color = Rgba::new(0.8, 0.4, 0.2, 1.0);
    let mut scene = scene([at(0.0, 0.0, 2.0, colored_square(Rgba::WHITE, Material::lit(color)))]);
    let camera = camera(20, 20, 20.0);
    assert_eq!(pixel(&drawn(&scene, &camera), 10, 10), [204, 102, 51]);
    scene.light.as_mut().unwrap().direction = Vector3::new(0.0, 0.8, 0.6);
    assert_eq!(pixel(&drawn(&scene, &camera), 10, 10), [122, 61, 31]);
    scene.light.as_mut().unwrap().direction = -Vector3::z();
    assert_eq!(pixel(&drawn_on(&scene, &camera, [9; 3]), 10, 10), [0; 3]);
    scene.light = None;
    assert_eq!(pixel(&drawn_on(&scene, &camera, [9; 3]), 10, 10), [0; 3]);
    let glowing = Material {
        lighting: Lighting::Lit { diffuse: color, emissive: Rgba::new(0.2, 0.0, 0.4, 1.0) },
        ..Material::lit(color)
    };
    scene.drawables = vec![at(0.0, 0.0, 2.0, colored_square(Rgba::WHITE, glowing))];
    assert_eq!(pixel(&drawn(&scene, &camera), 10, 10), [51, 0, 102]);
}

#[test]
fn a_scaled_object_is_lit_as_one_that_is_not() {
    let mut drawable = at(0.0, 0.0, 2.0, colored_square(Rgba::WHITE, Material::lit(Rgba::new(0.8, 0.4, 0.2, 1.0))));
    drawable.fixed_from_object *= Matrix4::new_nonuniform_scaling(&Vector3::new(0.5, 1.5, 0.1));
    assert_eq!(pixel(&drawn(&scene([drawable]), &camera(20, 20, 20.0)), 10, 10), [204, 102, 51]);
}

#[test]
fn vertex_colours_replace_the_diffuse_colour_where_the_material_uses_them() {
    let lit = Material { vertex_colors: true, ..Material::lit(Rgba::WHITE) };
    for material in [lit, Material::unlit(false)] {
        let square = colored_square(Rgba::new(0.4, 0.6, 0.8, 1.0), material);
        let image = drawn(&scene([at(0.0, 0.0, 2.0, square)]), &camera(20, 20, 20.0));
        assert_eq!(pixel(&image, 10, 10), [102, 153, 204]);
    }
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
fn a_texture_has_its_first_row_on_top_and_is_multiplied_with_the_colour() {
    let texture = Texture {
        width: 2,
        height: 2,
        rgba: vec![[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 255, 255]],
        filtering: Filtering::Nearest,
        wrapping: Wrapping::Clamp,
    };
    let material = Material { texture: Some(Arc::new(texture)), ..Material::unlit(false) };
    let square = colored_square(Rgba::new(0.6, 0.6, 0.6, 1.0), material);
    let image = drawn(&scene([at(0.0, 0.0, 1.0, square)]), &camera(20, 20, 20.0));
    assert_eq!(
        [(5, 5), (15, 5), (5, 15), (15, 15)].map(|(x, y)| pixel(&image, x, y)),
        [[153, 0, 0], [0, 153, 0], [0, 0, 153], [153, 153, 153]]
    );
}

#[test]
fn a_far_texture_is_the_mean_of_its_texels_where_it_has_mipmaps() {
    let side = 64;
    let rgba = (0..side * side).map(|i| if (i + i / side) % 2 == 0 { [255; 4] } else { [0, 0, 0, 255] }).collect();
    let texture =
        Texture { width: side, height: side, rgba, filtering: Filtering::BilinearMipmap, wrapping: Wrapping::Repeat };
    let material = Material { texture: Some(Arc::new(texture)), ..Material::unlit(false) };
    let image = drawn(&scene([at(0.0, 0.0, 1.0, colored_square(Rgba::WHITE, material))]), &camera(8, 8, 8.0));
    let lit = lit_pixels(&image);
    assert_eq!(lit.len(), 64);
    for (x, y) in lit {
        assert!(difference(pixel(&image, x, y), [128; 3]) <= 1, "{:?}", pixel(&image, x, y));
    }
}

#[test]
fn text_faces_the_camera_and_hides_nothing() {
    let text = Text::new("HHHH", 0.5, Rgba::WHITE, (HorizontalAlignment::Center, VerticalAlignment::Center));
    let mut drawable = at(0.0, 0.0, 1.0, Geometry::Text(Arc::new(text)));
    let camera = camera(80, 40, 40.0);
    let upright = drawn(&scene([drawable.clone(), flat(1.5, RED)]), &camera);
    assert!(lit_pixels(&upright).iter().filter(|&&(x, y)| pixel(&upright, x, y)[1] > 128).count() > 40);
    assert!(lit_pixels(&upright).iter().any(|&(x, y)| pixel(&upright, x, y) == [255, 0, 0]));
    drawable.fixed_from_object *= Matrix4::from_axis_angle(&Vector3::y_axis(), 1.0);
    assert_eq!(drawn(&scene([drawable, flat(1.5, RED)]), &camera), upright);
}

#[test]
fn text_on_top_is_drawn_over_nearer_surfaces() {
    let text = || Text::new("HH", 0.5, Rgba::WHITE, (HorizontalAlignment::Center, VerticalAlignment::Center));
    let camera = camera(40, 40, 40.0);
    let inked = |text: Text| {
        let drawables = [flat(0.9, RED), at(0.0, 0.0, 1.0, Geometry::Text(Arc::new(text)))];
        let image = drawn(&scene(drawables), &camera);
        lit_pixels(&image).iter().any(|&(x, y)| pixel(&image, x, y)[1] > 128)
    };
    assert!(!inked(text()));
    assert!(inked(text().on_top()));
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
fn hidden_displays_are_not_drawn() {
    let mut mask = DisplayMask::all();
    let mut hidden = flat(1.0, RED);
    hidden.display = 3;
    mask.set(3, false);
    let (scene, camera) = (scene([hidden, flat(2.0, GREEN)]), camera(10, 10, 10.0));
    let view = View { scene: &scene, camera: &camera, visible: &mask, background: [0; 3], encoding: Encoding::Rgba8 };
    let mut image = Image::default();
    gpu().render(&view, &mut image).unwrap();
    assert_eq!(pixel(&image, 5, 5), [0, 255, 0]);
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
