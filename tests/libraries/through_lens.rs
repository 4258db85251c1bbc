//! Images for a projector with distortion: after its lens, light lies where it should, on both renderers.
//!
//! Each pixel's expected place comes from `rcs_calibration::Lens`, whose own tests compare it with OpenCV's figures.
#![expect(clippy::unwrap_used, reason = "the functions that tests call fail as these do")]

use std::sync::Arc;

use nalgebra::{Matrix3, Point2, Point3, Rotation3, Vector2, Vector3};
use rcs_camera::{CameraModel, Projection};
use rcs_files::projector::lens_of;
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_render::{create, CpuRenderer, Renderer, RendererChoice, View};
use rcs_scene::{
    Blending, Camera, DisplayMask, Drawable, Encoding, Geometry, HorizontalAlignment, Image, LineTopology, Lines,
    Material, Mesh, Rgba, Scene, Text, Vertex, VerticalAlignment,
};
use rcs_tests::scenes::{rendering::camera_of, solids::drawable};

/// By how much light may be off, in pixels.
const LIMIT_PX: f64 = 0.1;

/// Both renderers.
fn renderers() -> [Box<dyn Renderer>; 2] {
    [RendererChoice::Cpu, RendererChoice::Gpu].map(|choice| create(choice).unwrap())
}

const UNDISTORTED: CameraModel = CameraModel { projection: Projection::Rviz, undistort: true };

/// A projector that throws upwards; P is K and R the identity.
fn projector(model: &str, coefficients: &[f64]) -> CameraInfo {
    let mut info = CameraInfo { width: 640, height: 400, distortion_model: model.to_owned(), ..CameraInfo::default() };
    info.header.frame_id = "map".to_owned();
    info.D = coefficients.to_vec();
    info.K = [700.0, 0.0, 322.3, 0.0, 690.0, 360.8, 0.0, 0.0, 1.0];
    info.R = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    info.P = [700.0, 0.0, 322.3, 0.0, 0.0, 690.0, 360.8, 0.0, 0.0, 0.0, 1.0, 0.0];
    info
}

fn projectors() -> Vec<CameraInfo> {
    let mut rectified = projector("plumb_bob", &[0.12, -0.05, -0.002, 0.001, 0.0]);
    rectified.R = row_major(&Rotation3::from_euler_angles(0.01, -0.02, 0.015).into_inner());
    rectified.P = [650.0, 0.0, 330.0, 0.0, 0.0, 655.0, 350.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    // As camera_calibration writes fisheye lenses, and a P with a skew that counts up to scale.
    let mut skewed = projector("fisheye", &[0.05, -0.01, 0.0, 0.0]);
    (skewed.K[1], skewed.P[1]) = (-4.0, 30.0);
    skewed.P = skewed.P.map(|value| 2.0 * value);
    vec![
        projector("plumb_bob", &[-0.2, 0.05, 0.001, -0.002, 0.0]),
        projector("plumb_bob", &[0.3, -0.1, 0.0005, 0.0, 0.02, 0.45, -0.05, 0.01]),
        projector("equidistant", &[0.02, -0.01, 0.003, 0.0]),
        projector("equidistant", &[0.0; 4]),
        rectified,
        skewed,
    ]
}

fn row_major(matrix: &Matrix3<f64>) -> [f64; 9] {
    std::array::from_fn(|i| matrix[(i / 3, i % 3)])
}

/// The raw pixel that a point of the CameraInfo's frame lands on: K, D and R, without this project's drawing.
fn lands_on(info: &CameraInfo, point: &Point3<f64>) -> Point2<f64> {
    let raw_from_rectified = Matrix3::from_row_slice(&info.R).transpose();
    lens_of(info).unwrap().project(&(raw_from_rectified * point)).unwrap()
}

/// The point at a distance that a raw pixel lights.
fn lit_by(info: &CameraInfo, [u, v]: [f64; 2], distance_m: f64) -> Point3<f64> {
    let ray = Matrix3::from_row_slice(&info.R) * lens_of(info).unwrap().ray(Point2::new(u, v)).unwrap();
    Point3::from(ray * (distance_m / ray.z))
}

/// White things on black.
struct Light {
    image: Image,
}

impl Light {
    fn of(drawables: Vec<Drawable>, camera: &Camera, renderer: &mut dyn Renderer) -> Self {
        let scene = Scene { drawables, light: None };
        let visible = DisplayMask::all();
        let view = View { scene: &scene, camera, visible: &visible, background: [0; 3], encoding: Encoding::Mono8 };
        let mut image = Image::default();
        renderer.render(&view, &mut image).unwrap();
        Self { image }
    }

    /// 0 to 1; dark beside the image.
    fn at(&self, x: i64, y: i64) -> f64 {
        let [width, height] = [self.image.width_px, self.image.height_px].map(i64::from);
        if (0..width).contains(&x) && (0..height).contains(&y) {
            f64::from(self.image.data[(y * width + x) as usize]) / 255.0
        } else {
            0.0
        }
    }

    /// Between pixels' centres.
    fn between(&self, place: Point2<f64>) -> f64 {
        let (x, y) = (place.x.floor(), place.y.floor());
        let (right, down) = (place.x - x, place.y - y);
        let (x, y) = (x as i64, y as i64);
        let row = |y| self.at(x, y) * (1.0 - right) + self.at(x + 1, y) * right;
        row(y) * (1.0 - down) + row(y + 1) * down
    }

    /// The centre of the light within a distance of a place.
    fn center(&self, place: Point2<f64>, within_px: f64) -> Point2<f64> {
        let reach = within_px.ceil() as i64 + 1;
        let (mut sum, mut moment) = (0.0, Vector2::zeros());
        for y in place.y as i64 - reach..=place.y as i64 + reach {
            for x in place.x as i64 - reach..=place.x as i64 + reach {
                let pixel = Point2::new(x as f64, y as f64);
                if (pixel - place).norm() <= within_px {
                    sum += self.at(x, y);
                    moment += pixel.coords * self.at(x, y);
                }
            }
        }
        assert!(sum > 1.0, "there is no light near {place}");
        Point2::from(moment / sum)
    }
}

const CORNERS: u32 = 48;

/// The corners of a disc of some pixels that faces the projector.
fn rim(info: &CameraInfo, center: Point3<f64>, radius_px: f64) -> impl Iterator<Item = Point3<f64>> {
    let radius_m = radius_px * center.z / info.P[0] * info.P[10];
    (0..CORNERS).map(move |i| {
        let (y, x) = (std::f64::consts::TAU * f64::from(i) / f64::from(CORNERS)).sin_cos();
        center + Vector3::new(x, y, 0.0) * radius_m
    })
}

/// Where the middle of a disc's light lands, which is not quite where its middle lands.
fn middle_lands_on(info: &CameraInfo, center: Point3<f64>, radius_px: f64) -> Point2<f64> {
    let corners: Vec<_> = rim(info, center, radius_px).map(|point| lands_on(info, &point)).collect();
    let (mut area, mut moment) = (0.0, Vector2::zeros());
    for i in 0..corners.len() {
        let (a, b) = (corners[i].coords, corners[(i + 1) % corners.len()].coords);
        area += a.perp(&b);
        moment += (a + b) * (a.perp(&b) / 3.0);
    }
    Point2::from(moment / area)
}

fn disc(info: &CameraInfo, center: Point3<f64>, radius_px: f64) -> Drawable {
    let vertex = |point: Point3<f64>| Vertex::new(point.cast::<f32>().into(), [0.0, 0.0, -1.0]);
    let vertices = std::iter::once(center).chain(rim(info, center, radius_px)).map(vertex).collect();
    let indices = (0..CORNERS).flat_map(|i| [0, 1 + i, 1 + (i + 1) % CORNERS]).collect();
    drawable(Geometry::Mesh { mesh: Arc::new(Mesh { vertices, indices }), material: both_sides() })
}

fn both_sides() -> Arc<Material> {
    Arc::new(Material { cull: rcs_scene::CullMode::None, ..Material::unlit(false) })
}

/// Discs of several sizes, as each by itself is off by some hundredths of a pixel: its edge is one of whole pixels.
#[test]
fn points_land_where_k_d_and_p_send_them() {
    const RADII_PX: [f64; 4] = [13.1, 14.3, 15.2, 16.4];
    let mut renderers = renderers();
    let mut mirrored = projector("plumb_bob", &[-0.2, 0.05, 0.001, -0.002, 0.0]);
    mirrored.K = [-700.0, 5.0, 316.7, 0.0, 690.0, 360.8, 0.0, 0.0, 1.0];
    for info in projectors().into_iter().chain([mirrored]) {
        let pixels = (0..20).map(|i| [40.0 + 139.3 * f64::from(i % 5), 35.0 + 109.7 * f64::from(i / 5)]);
        let points: Vec<_> = pixels.enumerate().map(|(i, pixel)| lit_by(&info, pixel, 1.0 + 0.07 * i as f64)).collect();
        for renderer in &mut renderers {
            let mut off = vec![Vector2::zeros(); points.len()];
            for radius_px in RADII_PX {
                let discs = points.iter().map(|point| disc(&info, *point, radius_px)).collect();
                let light = Light::of(discs, &camera_of(&info, UNDISTORTED).unwrap(), renderer.as_mut());
                assert_eq!((light.image.width_px, light.image.height_px), (640, 400));
                for (off, point) in off.iter_mut().zip(&points) {
                    let expected = middle_lands_on(&info, *point, radius_px);
                    assert!((expected - lands_on(&info, point)).norm() < 2.0 * LIMIT_PX, "the disc is too large");
                    *off += (light.center(expected, radius_px + 10.0) - expected) / RADII_PX.len() as f64;
                }
            }
            for (off, point) in off.iter().zip(&points) {
                let (off, at) = (off.norm(), lands_on(&info, point));
                assert!(off <= LIMIT_PX, "{}, {}: {off:.3} px at {at}", info.distortion_model, renderer.describe());
            }
        }
    }
}

/// The edge of light along a curve in the image, how far it is from there on average: positive to the right of the
/// way from the first point to the last one, as the image shows it.
fn edge_offset(light: &Light, curve: &[Point2<f64>]) -> f64 {
    const REACH_PX: f64 = 3.0;
    const STEPS: i32 = 60;
    let mut offsets = Vec::new();
    for pair in curve.windows(2) {
        let along = (pair[1] - pair[0]).normalize();
        let right = Vector2::new(-along.y, along.x);
        let step = 2.0 * REACH_PX / f64::from(STEPS);
        let places = (0..STEPS).map(|i| (f64::from(i) + 0.5) * step - REACH_PX);
        let lit: f64 = places.map(|distance| light.between(pair[0] + right * distance) * step).sum();
        // Light is on the left.
        offsets.push(lit - REACH_PX);
    }
    offsets.iter().sum::<f64>() / offsets.len() as f64
}

fn along(from: Point3<f64>, to: Point3<f64>, [begin, end]: [f64; 2]) -> impl Iterator<Item = Point3<f64>> {
    (0..=100).map(move |i| from + (to - from) * (begin + (end - begin) * f64::from(i) / 100.0))
}

#[test]
fn edges_of_triangles_and_lines_bend_as_the_lens_unbends_them() {
    let mut renderers = renderers();
    for info in projectors() {
        let corner = |u, v, distance_m| lit_by(&info, [u, v], distance_m);
        // Counter-clockwise as the image shows it, so that the inside is on the left.
        let corners = [corner(60.0, 350.0, 1.4), corner(330.3, 371.0, 1.2), corner(285.0, 22.0, 1.6)];
        let vertices = corners.map(|point| Vertex::new(point.cast::<f32>().into(), [0.0, 0.0, -1.0])).to_vec();
        let mesh = Arc::new(Mesh { vertices, indices: vec![0, 1, 2] });
        let line = [corner(370.0, 380.0, 1.1), corner(611.0, 18.0, 1.9)];
        let lines = Lines {
            positions: line.map(|point| point.cast::<f32>().into()).to_vec(),
            colors: vec![[255; 4]; 2],
            topology: LineTopology::List,
            blending: Blending::Replace,
        };
        let drawables =
            vec![drawable(Geometry::Mesh { mesh, material: both_sides() }), drawable(Geometry::Lines(Arc::new(lines)))];
        let name = &info.distortion_model;
        for renderer in &mut renderers {
            let light = Light::of(drawables.clone(), &camera_of(&info, UNDISTORTED).unwrap(), renderer.as_mut());
            for part in [[0.08, 0.3], [0.4, 0.6], [0.7, 0.92]] {
                let curve = |from, to| along(from, to, part).map(|point| lands_on(&info, &point)).collect::<Vec<_>>();
                for i in 0..3 {
                    let off = edge_offset(&light, &curve(corners[i], corners[(i + 1) % 3]));
                    assert!(off.abs() <= LIMIT_PX, "{name}, {}: edge {i}, {part:?}: {off:.3} px", renderer.describe());
                }
                let places = curve(line[0], line[1]);
                let off = places.iter().map(|place| light.center(*place, 4.0) - place).sum::<Vector2<f64>>();
                let direction = (places[100] - places[0]).normalize();
                let off = off.perp(&direction) / places.len() as f64;
                assert!(off.abs() <= LIMIT_PX, "{name}, {}: line, {part:?}: {off:.3} px", renderer.describe());
            }
        }
    }
}

#[test]
fn text_lands_where_it_should() {
    let mut renderers = renderers();
    let info = projector("plumb_bob", &[-0.2, 0.05, 0.001, -0.002, 0.0]);
    let mut straight = info.clone();
    straight.D.clear();
    let white = Rgba { r: 1.0, g: 1.0, b: 1.0, a: 1.0 };
    for pixel in [[80.0, 60.0], [540.0, 330.0], [320.0, 200.0]] {
        let at = lit_by(&info, pixel, 1.5);
        let text = Text::new("o", 0.05, white, (HorizontalAlignment::Center, VerticalAlignment::Center));
        let mut label = drawable(Geometry::Text(Arc::new(text)));
        label.fixed_from_object = nalgebra::Translation3::from(at.coords).to_homogeneous();
        for renderer in &mut renderers {
            let exact = CameraModel::from(Projection::Exact);
            let [before, after] = [(&straight, exact), (&info, UNDISTORTED)].map(|(info, model)| {
                let light = Light::of(vec![label.clone()], &camera_of(info, model).unwrap(), renderer.as_mut());
                light.center(lands_on(info, &at), 25.0)
            });
            let [fx, cx, fy, cy] = [info.K[0], info.K[2], info.K[4], info.K[5]];
            let expected = lands_on(&info, &Point3::new((before.x - cx) / fx, (before.y - cy) / fy, 1.0));
            let off = (after - expected).norm();
            assert!(off <= LIMIT_PX, "{}: {off:.3} px at {expected}", renderer.describe());
        }
    }
}

#[test]
fn without_distortion_the_image_is_the_same() {
    for coefficients in [&[][..], &[0.0; 5]] {
        let info = projector("plumb_bob", coefficients);
        let discs = || vec![disc(&info, lit_by(&projector("plumb_bob", &[]), [100.0, 100.0], 1.0), 20.0)];
        for projection in [Projection::Rviz, Projection::Exact] {
            let [with, without] = [true, false].map(|undistort| {
                Light::of(
                    discs(),
                    &camera_of(&info, CameraModel { projection, undistort }).unwrap(),
                    &mut CpuRenderer::new(),
                )
                .image
            });
            assert_eq!(with, without);
            assert!(with.data.iter().any(|level| *level > 0));
        }
    }
}

/// A lens that folds back: beyond some radius, farther points would land nearer to the middle again.
#[test]
fn beyond_the_lens_models_valid_radius_nothing_is_drawn_twice() {
    let mut renderers = renderers();
    let mut info = projector("plumb_bob", &[-0.6, 0.0, 0.0, 0.0, 0.0]);
    info.K[5] = 200.0;
    info.P[6] = 200.0;
    // Where the fold's inner side lands: 1.1 is sent to 1.1 (1 − 0.6 · 1.21) = 0.301, as is 0.344.
    let disc = |radius: f64| disc(&info, Point3::new(radius, 0.0, 1.0), 6.0);
    for renderer in &mut renderers {
        let camera = camera_of(&info, UNDISTORTED).unwrap();
        let folded = Light::of(vec![disc(1.1)], &camera, renderer.as_mut());
        assert!(folded.image.data.iter().all(|level| *level == 0), "{}", renderer.describe());
        let seen = Light::of(vec![disc(0.344)], &camera, renderer.as_mut());
        let expected = lands_on(&info, &Point3::new(0.344, 0.0, 1.0));
        assert!((seen.center(expected, 12.0) - expected).norm() < 2.0 * LIMIT_PX);
        let lit = seen.image.data.iter().filter(|level| **level > 127).count();
        assert!((40..=120).contains(&lit), "{lit}");
    }
}

#[test]
fn exact_hits_the_pixels_that_p_names() {
    let mut renderers = renderers();
    let info = projector("plumb_bob", &[]);
    let points: Vec<_> = (0..12)
        .map(|i| lit_by(&info, [60.25 + 41.3 * f64::from(i), 50.5 + 27.7 * f64::from(i)], 1.0 + 0.1 * f64::from(i)))
        .collect();
    let discs: Vec<_> = points.iter().map(|point| disc(&info, *point, 13.0)).collect();
    for renderer in &mut renderers {
        for (projection, shift) in [(Projection::Exact, 0.0), (Projection::Rviz, -0.5)] {
            let mut info = info.clone();
            // One focal length: elsewhere rviz draws another image.
            info.P[5] = info.P[0];
            let light = Light::of(discs.clone(), &camera_of(&info, projection.into()).unwrap(), renderer.as_mut());
            let off = points.iter().map(|point| {
                let [fx, cx, fy, cy] = [info.P[0], info.P[2], info.P[5], info.P[6]];
                let expected = Point2::new(fx * point.x / point.z + cx, fy * point.y / point.z + cy);
                light.center(expected, 20.0) - expected
            });
            let off = off.sum::<Vector2<f64>>() / points.len() as f64;
            assert!((off - Vector2::repeat(shift)).norm() < LIMIT_PX, "{projection:?}, {}: {off}", renderer.describe());
        }
    }
}

#[test]
fn exact_follows_skews_and_takes_p_up_to_scale() {
    let mut renderers = renderers();
    let mut info = projector("plumb_bob", &[]);
    (info.P[1], info.P[3], info.P[4], info.P[7]) = (50.0, -14.0, -20.0, 9.0);
    let points: Vec<_> = (0..12)
        .map(|i| lit_by(&info, [60.25 + 41.3 * f64::from(i), 70.5 + 21.7 * f64::from(i)], 1.0 + 0.1 * f64::from(i)))
        .collect();
    let by_p = |point: &Point3<f64>| {
        let pixel = nalgebra::Matrix3x4::from_row_slice(&info.P) * point.to_homogeneous();
        Point2::new(pixel.x / pixel.z, pixel.y / pixel.z)
    };
    let discs: Vec<_> = points.iter().map(|point| disc(&info, *point, 13.0)).collect();
    for scale in [1.0, 2.0, 0.01] {
        let scaled = CameraInfo { P: info.P.map(|value| scale * value), ..info.clone() };
        for renderer in &mut renderers {
            let light =
                Light::of(discs.clone(), &camera_of(&scaled, Projection::Exact.into()).unwrap(), renderer.as_mut());
            let off = points.iter().map(|point| light.center(by_p(point), 20.0) - by_p(point));
            let off = off.sum::<Vector2<f64>>() / points.len() as f64;
            assert!(off.norm() < LIMIT_PX, "{scale}, {}: {off}", renderer.describe());
        }
    }
}
