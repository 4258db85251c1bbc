//! CameraInfos with negative focal lengths: the image is bit for bit the flipped one of the positive ones, with the
//! principal point where a mirror shows it, on both renderers; depths and keep-out silhouettes too.
#![expect(clippy::unwrap_used, reason = "the functions that tests call fail as these do")]

use std::sync::Arc;

use nalgebra::{Matrix4, Point3, Translation3, UnitQuaternion, Vector3};
use rcs_camera::{CameraModel, Projection};
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_render::{
    create, DepthRequest, Depths, Finished, KeepOut, Orientation, PostProcess, RendererChoice, Sphere, View,
};
use rcs_scene::{
    Blending, Camera, DepthImage, DirectionalLight, DisplayMask, Drawable, Encoding, Geometry, HorizontalAlignment,
    Image, LineTopology, Lines, Material, Mesh, PointBuffer, PointColors, PointStyle, Points, Rgba, Scene, Text,
    Vertex, VerticalAlignment,
};
use rcs_tests::scenes::{rendering::camera_of, solids::drawable};

const EXACT: CameraModel = CameraModel { projection: Projection::Exact, undistort: false };
const UNDISTORTED: CameraModel = CameraModel { projection: Projection::Exact, undistort: true };

/// Left and right, up and down, both.
const MIRRORS: [[bool; 2]; 3] = [[true, false], [false, true], [true, true]];

fn straight() -> CameraInfo {
    let mut info = CameraInfo { width: 320, height: 240, ..CameraInfo::default() };
    info.header.frame_id = "map".to_owned();
    info.K = [250.0, 3.0, 150.25, 0.0, 245.0, 131.5, 0.0, 0.0, 1.0];
    info.P = [250.0, 0.0, 150.25, -7.0, 0.0, 250.0, 131.5, 4.0, 0.0, 0.0, 1.0, 0.0];
    info.distortion_model = "plumb_bob".to_owned();
    info.D = vec![-0.12, 0.03, 0.002, -0.001, 0.0];
    info
}

/// Like `straight`, with rows of K and P negated, about pixels' centres: u' = W - 1 - u.
fn mirrored([is_left_right, is_up_down]: [bool; 2]) -> CameraInfo {
    let mut info = straight();
    if is_left_right {
        info.P[..4].iter_mut().chain(&mut info.K[..3]).for_each(|value| *value = -*value);
        (info.P[2], info.K[2]) = (info.P[2] + 319.0, info.K[2] + 319.0);
    }
    if is_up_down {
        info.P[4..8].iter_mut().chain(&mut info.K[3..6]).for_each(|value| *value = -*value);
        (info.P[6], info.K[5]) = (info.P[6] + 239.0, info.K[5] + 239.0);
    }
    info
}

/// A box whose faces are seen from outside only.
fn solid() -> Mesh {
    let faces = [Vector3::x(), Vector3::y(), Vector3::z()].map(|normal| [normal, -normal]);
    let (mut vertices, mut indices) = (Vec::new(), Vec::new());
    for normal in faces.into_iter().flatten() {
        let right = Vector3::new(normal.y, normal.z, normal.x);
        let up = normal.cross(&right);
        let first = vertices.len() as u32;
        for [a, b] in [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]] {
            let corner: Vector3<f32> = (normal + right * a + up * b) * 0.5;
            vertices.push(Vertex::new(corner.into(), normal.into()));
        }
        indices.extend([0, 1, 2, 0, 2, 3].map(|i| first + i));
    }
    Mesh { vertices, indices }
}

fn cloud(style: PointStyle, seed: u32) -> Drawable {
    let number = |i: u32| (i.wrapping_mul(2_654_435_761).rotate_left(7) % 1000) as f32 / 1000.0 - 0.5;
    let positions: Vec<_> = (0..60)
        .map(|i| [number(3 * i + seed) * 1.4, number(3 * i + 1 + seed), 1.6 + number(3 * i + 2 + seed)])
        .collect();
    let colors = (0..60_u8).map(|i| [4 * i, 255 - 3 * i, 90, 255]).collect();
    let buffer = Arc::new(PointBuffer { positions, colors: PointColors::PerPoint(colors) });
    drawable(Geometry::Points(Points { buffer, style, alpha: 1.0, blended: false, auto_size: false }))
}

/// Boxes, points of all kinds that have a shape, lines and text, none of them symmetrical.
fn scene() -> Scene {
    let pose = Translation3::new(-0.25, 0.1, 1.5) * UnitQuaternion::from_euler_angles(0.4, 0.7, 0.2);
    let color = Rgba { r: 1.0, g: 0.5, b: 0.2, a: 1.0 };
    let mut solid = drawable(Geometry::Mesh { mesh: Arc::new(solid()), material: Arc::new(Material::lit(color)) });
    solid.fixed_from_object = pose.to_homogeneous() * Matrix4::new_scaling(0.4);
    let lines = Lines {
        positions: vec![[-0.7, -0.4, 1.3], [0.6, 0.2, 1.9], [0.1, 0.5, 1.2], [0.6, -0.3, 1.4]],
        colors: vec![[255, 255, 0, 255]; 4],
        topology: LineTopology::List,
        blending: Blending::Replace,
    };
    let words = Text::new("Rp", 0.2, Rgba::WHITE, (HorizontalAlignment::Left, VerticalAlignment::Center));
    let mut words = drawable(Geometry::Text(Arc::new(words)));
    words.fixed_from_object = Translation3::new(0.15, -0.3, 1.2).to_homogeneous();
    let light = Some(DirectionalLight { direction: Vector3::new(0.3, 0.2, 1.0) });
    let clouds = [
        PointStyle::Points { diameter_px: 5.0 },
        PointStyle::Squares { size_m: [0.03, 0.05] },
        PointStyle::Spheres { size_m: [0.06, 0.06] },
        PointStyle::Boxes { size_m: [0.05, 0.03, 0.04] },
    ];
    let clouds = (0..).zip(clouds).map(|(seed, style)| cloud(style, 1000 * seed));
    let drawables = [solid, drawable(Geometry::Lines(Arc::new(lines))), words].into_iter().chain(clouds).collect();
    Scene { drawables, light }
}

/// What both renderers draw: the image and the depths of each.
fn drawn(camera: &Camera, encoding: Encoding) -> Vec<(Image, DepthImage)> {
    let (scene, visible) = (scene(), DisplayMask::all());
    let view = View { scene: &scene, camera, visible: &visible, background: [9, 20, 31], encoding };
    let draw = |choice| {
        let mut renderer = create(choice).unwrap();
        let (mut image, mut depths) = (Image::default(), Depths::default());
        renderer.submit_with_depths(&view, &DepthRequest { opaque: true, objects_of: None }).unwrap();
        assert_eq!(renderer.finish_with_depths(&mut image, &mut depths).unwrap(), Finished::Drawn);
        let mut alone = Image::default();
        renderer.render(&view, &mut alone).unwrap();
        assert_eq!(image, alone);
        (image, depths.opaque)
    };
    [RendererChoice::Cpu, RendererChoice::Gpu].map(draw).into()
}

/// An image as a mirror shows it, by the code that turns images for outputs.
fn flipped(image: &Image, [is_left_right, is_up_down]: [bool; 2]) -> Image {
    let orientation: Orientation = match (is_left_right, is_up_down) {
        (true, false) => "mirrored",
        (false, true) => "mirrored-180",
        _ => "180",
    }
    .parse()
    .unwrap();
    let mut image = image.clone();
    PostProcess { orientation, ..PostProcess::default() }.apply(&mut image, &mut Image::default());
    image
}

/// Depths as bytes of an image, so that equal ones are equal where they are none.
fn as_image(depth: &DepthImage) -> Image {
    let data = depth.depths_m.iter().flat_map(|depth_m| depth_m.to_le_bytes()).collect();
    Image { width_px: depth.width_px, height_px: depth.height_px, encoding: Encoding::Rgba8, data }
}

#[test]
fn a_mirrored_projection_is_bit_for_bit_the_flipped_image() {
    for model in [EXACT, UNDISTORTED] {
        for encoding in [Encoding::Rgb8, Encoding::Mono16] {
            let expected = drawn(&camera_of(&straight(), model).unwrap(), encoding);
            for (image, depth) in &expected {
                let lit = image.data.iter().filter(|level| **level > 100).count();
                assert!(lit > image.data.len() / 20, "{lit} bytes are lit");
                assert!(depth.depths_m.iter().filter(|depth_m| depth_m.is_finite()).count() > 5000);
                assert_ne!(flipped(image, [true, false]), *image);
            }
            for mirror in MIRRORS {
                let found = drawn(&camera_of(&mirrored(mirror), model).unwrap(), encoding);
                for ((found, found_depth), (image, depth)) in found.iter().zip(&expected) {
                    let what = format!("{mirror:?} {encoding:?} {model:?}");
                    assert!(*found == flipped(image, mirror), "{what}");
                    assert!(as_image(found_depth) == flipped(&as_image(depth), mirror), "depths: {what}");
                }
            }
        }
    }
}

#[test]
fn the_silhouette_of_a_mirrored_image_stays_dark_where_the_mirror_shows_it() {
    let spheres = [Sphere { center: Point3::new(0.2, -0.15, 1.3), radius_m: 0.12 }];
    let dark = |info: &CameraInfo, model| {
        let keep_out = KeepOut::new(&camera_of(info, model).unwrap(), &spheres);
        let mut image = Image::default();
        image.reset(320, 240, Encoding::Mono8);
        image.data.fill(255);
        PostProcess { keep_out, ..PostProcess::default() }.apply(&mut image, &mut Image::default());
        image
    };
    for model in [EXACT, UNDISTORTED] {
        let expected = dark(&straight(), model);
        let count = expected.data.iter().filter(|level| **level == 0).count();
        assert!((1000..30_000).contains(&count), "{count}");
        for mirror in MIRRORS {
            assert!(dark(&mirrored(mirror), model) == flipped(&expected, mirror), "{mirror:?} {model:?}");
        }
    }
}

/// rviz gives both focal lengths one sign: an image that P mirrors is not mirrored, and none is inside out.
#[test]
fn rvizs_projection_of_a_mirrored_camera_info_is_rvizs_image() {
    let rviz = CameraModel::from(Projection::Rviz);
    let mut as_rviz = straight();
    let mut left_right = mirrored([true, false]);
    // rviz mirrors the principal point about the image's middle, edges included.
    (as_rviz.P[2], as_rviz.P[3]) = (320.0 - left_right.P[2], -left_right.P[3]);
    left_right.P[7] = as_rviz.P[7];
    let [found, expected] = [left_right, as_rviz].map(|info| drawn(&camera_of(&info, rviz).unwrap(), Encoding::Rgb8));
    for ((found, _), (expected, _)) in found.iter().zip(&expected) {
        assert!(found == expected);
    }
}
