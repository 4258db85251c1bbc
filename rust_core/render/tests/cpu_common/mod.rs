//! Scenes, a camera and images for the tests of the CPU renderer.
#![allow(dead_code, unreachable_pub, reason = "each test file uses its part of this module")]
#![allow(clippy::unwrap_used, reason = "a test may stop here")]

use std::sync::Arc;

use nalgebra::{Isometry3, Matrix4, Point3};
use rcs_render::{CpuRenderer, Renderer, View};
use rcs_scene::{
    Camera, DisplayMask, Drawable, Encoding, Geometry, Image, Intrinsics, Material, Mesh, PointBuffer, PointColors,
    PointStyle, Points, RenderGroup, Scene, Vertex,
};

/// A camera in the fixed frame's origin that sees 1 m at a distance of 1 m in 100 pixels.
pub fn camera(width_px: u32, height_px: u32) -> Camera {
    let (cx, cy) = (f64::from(width_px) / 2.0, f64::from(height_px) / 2.0);
    let p = [100.0, 0.0, cx, 0.0, 0.0, 100.0, cy, 0.0, 0.0, 0.0, 1.0, 0.0];
    Camera::new(Intrinsics::from_p(width_px, height_px, &p).unwrap(), &Isometry3::identity(), 0.01)
}

/// A drawable in the fixed frame's origin.
pub fn drawable(geometry: Geometry) -> Drawable {
    Drawable {
        display: 0,
        fixed_from_object: Matrix4::identity(),
        sort_point: Point3::origin(),
        group: RenderGroup::Main,
        geometry,
    }
}

/// An opaque cloud of one colour.
pub fn cloud(style: PointStyle, positions: &[[f32; 3]], color: [u8; 4]) -> Geometry {
    let buffer = PointBuffer { positions: positions.to_vec(), colors: PointColors::Uniform(color) };
    Geometry::Points(Points { buffer: Arc::new(buffer), style, alpha: 1.0, blended: false, auto_size: false })
}

/// A square in front of the camera and turned to it; its texture's upper left corner is the image's.
pub fn quad(half_m: f32, distance_m: f32, material: Material, color: [u8; 4]) -> Geometry {
    let corner = |x: f32, y: f32| Vertex {
        position: [x * half_m, y * half_m, distance_m],
        normal: [0.0, 0.0, -1.0],
        uv: [x * 0.5 + 0.5, y * 0.5 + 0.5],
        color,
    };
    let vertices = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let mesh = Mesh { vertices, indices: vec![0, 2, 1, 0, 3, 2] };
    Geometry::Mesh { mesh: Arc::new(mesh), material: Arc::new(material) }
}

/// A scene drawn on black.
pub fn render(scene: &Scene, camera: &Camera, visible: &DisplayMask, encoding: Encoding, threads: usize) -> Image {
    let mut image = Image::default();
    let view = View { scene, camera, visible, background: [0, 0, 0], encoding };
    CpuRenderer::with_threads(threads).render(&view, &mut image).unwrap();
    image
}

/// An image's pixels.
pub struct Grid {
    width: usize,
    rgb: Vec<[u8; 3]>,
}

impl Grid {
    /// The pixels of an `rgb8` image.
    pub fn of(image: &Image) -> Self {
        let rgb = image.data.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
        Self { width: image.width_px as usize, rgb }
    }

    /// One pixel.
    pub fn at(&self, x: usize, y: usize) -> [u8; 3] {
        self.rgb[y * self.width + x]
    }

    /// The number of pixels that are not black.
    pub fn lit(&self) -> usize {
        self.rgb.iter().filter(|&&pixel| pixel != [0, 0, 0]).count()
    }
}

/// A scene as the [`camera`] of 100 by 100 pixels sees it.
pub fn pixels(scene: &Scene) -> Grid {
    Grid::of(&render(scene, &camera(100, 100), &DisplayMask::all(), Encoding::Rgb8, 2))
}
