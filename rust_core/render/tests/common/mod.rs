//! Shared by the renderers' tests: scenes of a few lines, pixels, and how close two images are.
#![allow(dead_code, reason = "each test file uses a part of it")]
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

use std::sync::Arc;

use nalgebra::{Isometry3, Matrix4, Point3, Vector3};
use rcs_render::{RenderError, Renderer, View};
use rcs_scene::{
    Camera, DirectionalLight, DisplayMask, Drawable, Encoding, Geometry, Image, Intrinsics, Mesh, PointBuffer,
    PointColors, PointStyle, Points, RenderGroup, Scene, Vertex,
};

/// A camera at the fixed frame's origin, facing along z with x to the right and y down, its principal point in the
/// middle.
pub(crate) fn camera(width_px: u32, height_px: u32, focal_px: f64) -> Camera {
    let (cx, cy) = (f64::from(width_px) / 2.0, f64::from(height_px) / 2.0);
    let p = [focal_px, 0.0, cx, 0.0, 0.0, focal_px, cy, 0.0, 0.0, 0.0, 1.0, 0.0];
    Camera::new(Intrinsics::from_p(width_px, height_px, &p).unwrap(), &Isometry3::identity(), 0.01)
}

/// A geometry at a place.
pub(crate) fn at(x: f64, y: f64, z: f64, geometry: Geometry) -> Drawable {
    Drawable {
        display: 0,
        fixed_from_object: Matrix4::new_translation(&Vector3::new(x, y, z)),
        sort_point: Point3::new(x, y, z),
        group: RenderGroup::Main,
        geometry,
    }
}

/// A scene with light that comes from the camera.
pub(crate) fn scene(drawables: impl IntoIterator<Item = Drawable>) -> Scene {
    let light = Some(DirectionalLight { direction: Vector3::z() });
    Scene { drawables: drawables.into_iter().collect(), light }
}

/// A cloud of one colour, opaque.
pub(crate) fn points(style: PointStyle, color: [u8; 4], positions: &[[f32; 3]]) -> Points {
    let buffer = PointBuffer { positions: positions.to_vec(), colors: PointColors::Uniform(color) };
    Points { buffer: Arc::new(buffer), style, alpha: 1.0, blended: false, auto_size: false }
}

/// A square of side 1 in the plane z = 0, seen from in front by [`camera`], with its texture's row 0 at the top.
pub(crate) fn square_mesh() -> Mesh {
    let corner = |x: f32, y: f32| Vertex { uv: [x + 0.5, y + 0.5], ..Vertex::new([x, y, 0.0], [0.0, 0.0, -1.0]) };
    Mesh {
        vertices: vec![corner(-0.5, -0.5), corner(-0.5, 0.5), corner(0.5, 0.5), corner(0.5, -0.5)],
        indices: vec![0, 1, 2, 0, 2, 3],
    }
}

/// An image in RGBA on a background.
pub(crate) fn draw_on(
    renderer: &mut dyn Renderer,
    scene: &Scene,
    camera: &Camera,
    background: [u8; 3],
) -> Result<Image, RenderError> {
    let mut image = Image::default();
    let visible = DisplayMask::all();
    let view = View { scene, camera, visible: &visible, background, encoding: Encoding::Rgba8 };
    renderer.render(&view, &mut image)?;
    Ok(image)
}

/// An image in RGBA on black.
pub(crate) fn draw(renderer: &mut dyn Renderer, scene: &Scene, camera: &Camera) -> Image {
    draw_on(renderer, scene, camera, [0; 3]).unwrap()
}

/// Red, green and blue of a pixel of an RGBA image.
pub(crate) fn pixel(image: &Image, x: u32, y: u32) -> [u8; 3] {
    let i = (y * image.width_px + x) as usize * 4;
    image.data[i..i + 3].try_into().unwrap()
}

/// The pixels that are not black, by column and row.
pub(crate) fn lit_pixels(image: &Image) -> Vec<(u32, u32)> {
    (0..image.height_px)
        .flat_map(|y| (0..image.width_px).map(move |x| (x, y)))
        .filter(|&(x, y)| pixel(image, x, y) != [0; 3])
        .collect()
}

/// The largest difference of two colours' channels.
pub(crate) fn difference(a: [u8; 3], b: [u8; 3]) -> u8 {
    (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap_or(0)
}

/// How far two RGBA images of one size agree where either differs from the background: the number of those pixels,
/// and which of them have channels that differ by more than `levels`, a match being allowed `reach` pixels away, in
/// both directions.
pub(crate) fn differing(a: &Image, b: &Image, background: [u8; 3], levels: u8, reach: i64) -> (u32, Vec<(u32, u32)>) {
    assert_eq!((a.width_px, a.height_px), (b.width_px, b.height_px));
    let matches = |from: &Image, to: &Image, x: u32, y: u32| {
        let color = pixel(from, x, y);
        (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy))).any(|(dx, dy)| {
            let near_x = (i64::from(x) + dx).clamp(0, i64::from(to.width_px) - 1) as u32;
            let near_y = (i64::from(y) + dy).clamp(0, i64::from(to.height_px) - 1) as u32;
            difference(color, pixel(to, near_x, near_y)) <= levels
        })
    };
    let (mut content, mut differing) = (0_u32, Vec::new());
    for y in 0..a.height_px {
        for x in 0..a.width_px {
            if [a, b].iter().all(|image| difference(pixel(image, x, y), background) <= 2) {
                continue;
            }
            content += 1;
            if !matches(a, b, x, y) || !matches(b, a, x, y) {
                differing.push((x, y));
            }
        }
    }
    (content, differing)
}
