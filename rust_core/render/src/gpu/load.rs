//! Which pictures the CPU draws instead of the GPU.
//!
//! A GPU visits each pixel of each face, also where something nearer hides it, and goes through all primitives,
//! wherever they are. The CPU renderer finds out first what may be seen. So there is one rule: a picture has a load,
//! the largest of three shares of what a GPU of the kind draws in some 10 ms:
//!
//! - pixels of points' faces, counted as often as they are covered. Translucent faces hide nothing, so that they count
//!   only for software drivers, which visit their pixels no faster than the CPU renderer does;
//! - things that are placed by themselves: drawables and solids;
//! - primitives, for software drivers only.
//!
//! The CPU draws pictures of a load above 1, and from then on until the load falls to a half: the pictures of a scene
//! about the limit do not change between the renderers, which may differ in a pixel. Pixels are estimated from a sample
//! of the points.

use nalgebra::{Matrix4, Vector4};
use rcs_scene::{Geometry, PointLook, PointStyle};

use crate::shading::drawn_point_size_px;
use crate::View;

/// The load from which on the GPU draws again.
const LOW: f64 = 0.5;

/// Points of a cloud that are looked at.
const SAMPLES: usize = 1024;

/// Some of a cloud's positions.
struct Sample {
    positions: Vec<[f32; 3]>,
    /// Number of points that each of them stands for.
    step: usize,
    /// Points of the cloud.
    count: usize,
}

/// The rule, and which renderer drew the last picture.
#[derive(Debug)]
pub(super) struct LoadRule {
    limit: Limit,
    is_cpus: bool,
}

/// The load of 1.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Limit {
    face_px: f64,
    with_blended: bool,
    things: usize,
    /// As many points.
    primitives: usize,
}

impl Limit {
    /// Discrete GPUs visit a hundred thousand million pixels in a second, integrated graphics a tenth of that. A solid
    /// of some hundred vertices took an H200 3 µs, a point Mesa's software driver 0.2 µs.
    fn of(kind: wgpu::DeviceType) -> Self {
        let is_software = kind == wgpu::DeviceType::Cpu;
        Self {
            face_px: if kind == wgpu::DeviceType::DiscreteGpu { 1024e6 } else { 128e6 },
            with_blended: is_software,
            things: 8_000,
            primitives: if is_software { 1_000_000 } else { usize::MAX },
        }
    }

    /// The load of a picture.
    fn load(&self, view: &View<'_>) -> f64 {
        let (mut things, mut primitives, mut face_px) = (0, 0, 0.0);
        for drawable in view.scene.drawables.iter().filter(|drawable| view.visible.shows(drawable.display)) {
            let (more_things, more_primitives) = counts(&drawable.geometry);
            (things, primitives) = (things + more_things, primitives + more_primitives);
            let sampled = match &drawable.geometry {
                Geometry::Points(points) => Some((points.look(), sample(points.buffer.positions.iter().copied()))),
                Geometry::Packed(points) => {
                    Some((points.look(), sample((0..points.count()).map(|i| points.position(i)))))
                }
                _ => None,
            };
            if let Some((look, sample)) = sampled.filter(|(look, _)| self.with_blended || !look.blended) {
                face_px += points_px(look, &sample, &drawable.fixed_from_object, view);
            }
        }
        let share = |count: usize, limit: usize| count as f64 / limit as f64;
        share(things, self.things).max(share(primitives, self.primitives)).max(face_px / self.face_px)
    }
}

impl LoadRule {
    /// For a GPU of a kind.
    pub(super) fn new(kind: wgpu::DeviceType) -> Self {
        Self { limit: Limit::of(kind), is_cpus: false }
    }

    /// True if the CPU draws the next picture.
    pub(super) fn is_cpus(&mut self, view: &View<'_>) -> bool {
        let limit = if self.is_cpus { LOW } else { 1.0 };
        self.is_cpus = self.limit.load(view) > limit;
        self.is_cpus
    }
}

/// Things that are placed by themselves, and primitives, as many points: a triangle or a glyph takes as long as two, a
/// line as four.
fn counts(geometry: &Geometry) -> (usize, usize) {
    match geometry {
        Geometry::Points(points) => (1, points.buffer.positions.len()),
        Geometry::Packed(points) => (1, points.count()),
        Geometry::Lines(lines) => (1, 4 * lines.segment_count()),
        Geometry::Mesh { mesh, .. } => (1, 2 * (mesh.indices.len() / 3)),
        Geometry::Ribbons(ribbons) => (1, 4 * ribbons.chains.iter().map(Vec::len).sum::<usize>()),
        Geometry::Text(text) => (1, 2 * text.glyphs().len()),
        Geometry::Solids(solids) => {
            let triangles = |shape: usize| solids.shapes().get(shape).map_or(0, |mesh| mesh.indices.len() / 3);
            (solids.len(), solids.as_slice().iter().map(|solid| 2 * triangles(solid.shape())).sum())
        }
        Geometry::Cells(_) | Geometry::Facing(_) => (1, 0),
    }
}

/// Looks at some of a cloud's positions.
fn sample(positions: impl ExactSizeIterator<Item = [f32; 3]>) -> Sample {
    let count = positions.len();
    let step = count.div_ceil(SAMPLES).max(1);
    Sample { positions: positions.step_by(step).collect(), step, count }
}

/// Pixels of a cloud's faces, each by itself and at most all of the picture.
fn points_px(look: PointLook, sample: &Sample, fixed_from_object: &Matrix4<f64>, view: &View<'_>) -> f64 {
    // Those that are too faint are not drawn, and auto-sized ones are the smaller the nearer they are.
    if look.alpha < 0.01 || look.auto_size {
        return 0.0;
    }
    let camera = view.camera;
    let half_size_px = [camera.width_px(), camera.height_px()].map(|side| 0.5 * f64::from(side));
    let all = 4.0 * half_size_px[0] * half_size_px[1];
    let [width_m, height_m] = match look.style {
        PointStyle::Points { diameter_px } => {
            return sample.count as f64 * f64::from(drawn_point_size_px(diameter_px)).powi(2).min(all);
        }
        PointStyle::Squares { size_m } | PointStyle::Spheres { size_m } | PointStyle::Tiles { size_m, .. } => size_m,
        PointStyle::FlatSquares { side_m } => [side_m; 2],
        // Of a box, about one side faces the eye.
        PointStyle::Boxes { size_m: [x, y, z] } => [x.max(z), y],
    }
    .map(|side_m| f64::from(side_m).abs());
    let view_from_fixed = camera.fixed_from_view().inverse().to_homogeneous();
    let clip_from_object = camera.clip_from_view() * view_from_fixed * fixed_from_object;
    // How far a metre reaches in clip coordinates, along each axis.
    let per_m = [0, 1, 3].map(|row| clip_from_object.row(row).columns(0, 3).norm());
    let reach_m = 0.5 * width_m.hypot(height_m);
    let at_one = width_m * height_m * per_m[0] * per_m[1] * half_size_px[0] * half_size_px[1];
    let px = sample.positions.iter().map(|position| {
        let [x, y, z] = position.map(f64::from);
        let place = clip_from_object * Vector4::new(x, y, z, 1.0);
        let is_seen = place.w > 0.0
            && place.x.abs() <= place.w + reach_m * per_m[0]
            && place.y.abs() <= place.w + reach_m * per_m[1];
        if is_seen {
            (at_one / place.w.max(camera.near_m()).powi(2)).min(all)
        } else {
            0.0
        }
    });
    px.sum::<f64>() * sample.step as f64
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use nalgebra::{Isometry3, Point3};
    use rcs_scene::{
        Camera, DisplayMask, Drawable, Encoding, Intrinsics, PointBuffer, PointColors, Points, RenderGroup, Scene,
    };

    use super::*;

    /// Shows a geometry to a camera of 640×480 pixels.
    fn with_view<T>(geometry: Geometry, work: impl FnOnce(&View<'_>) -> T) -> T {
        let p = [500.0, 0.0, 320.0, 0.0, 0.0, 500.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        let camera = Camera::new(Intrinsics::from_p(640, 480, &p).unwrap(), &Isometry3::identity(), 0.01);
        let (fixed_from_object, sort_point) = (Matrix4::identity(), Point3::origin());
        let drawable = Drawable { display: 0, fixed_from_object, sort_point, group: RenderGroup::Main, geometry };
        let (scene, visible) = (Scene { drawables: vec![drawable], light: None }, DisplayMask::all());
        work(&View { scene: &scene, camera: &camera, visible: &visible, background: [0; 3], encoding: Encoding::Rgb8 })
    }

    fn cloud(positions: Vec<[f32; 3]>, style: PointStyle, blended: bool) -> Geometry {
        let buffer = Arc::new(PointBuffer { positions, colors: PointColors::Uniform([255; 4]) });
        Geometry::Points(Points { buffer, style, alpha: 1.0, blended, auto_size: false })
    }

    /// Pixels of squares and boxes of a metre at these places.
    fn px(places: &[[f32; 3]]) -> [f64; 2] {
        [PointStyle::FlatSquares { side_m: 1.0 }, PointStyle::Boxes { size_m: [1.0; 3] }].map(|style| {
            let Geometry::Points(points) = cloud(places.to_vec(), style, false) else { return 0.0 };
            let (look, sample) = (points.look(), sample(points.buffer.positions.iter().copied()));
            with_view(Geometry::Points(points), |view| points_px(look, &sample, &Matrix4::identity(), view))
        })
    }

    #[test]
    fn a_square_has_the_pixels_that_it_covers() {
        // 50 by 50 pixels each at 10 m, and all of the picture at 0.1 m.
        let expected = 2.0 * 2500.0 + 640.0 * 480.0;
        for px in px(&[[0.0, 0.0, 10.0], [1.0, -1.0, 10.0], [0.0, 0.0, 0.1]]) {
            assert!((0.49..2.1).contains(&(px / expected)), "{px}");
        }
    }

    #[test]
    fn what_is_not_in_the_view_has_no_pixels() {
        let beside = [[0.0, 0.0, -2.0], [30.0, 0.0, 2.0], [-30.0, 0.0, 2.0], [0.0, 30.0, 2.0], [0.0, -30.0, 2.0]];
        let not_finite = [[f32::NAN, 0.0, 1.0], [f32::INFINITY; 3]];
        for places in [&beside[..], &not_finite, &[]] {
            assert_eq!(px(places), [0.0; 2]);
        }
    }

    #[test]
    fn each_kind_of_gpu_has_its_limit() {
        use wgpu::DeviceType::{Cpu, DiscreteGpu, IntegratedGpu, VirtualGpu};
        // 500 squares of one metre at one metre and less fill the picture; 150 million pixels.
        let places: Vec<[f32; 3]> = (0..500).map(|i| [0.0, 0.0, 0.5 + i as f32 * 0.001]).collect();
        let is_cpus = |blended: bool| {
            [DiscreteGpu, IntegratedGpu, VirtualGpu, Cpu].map(|kind| {
                let squares = cloud(places.clone(), PointStyle::FlatSquares { side_m: 1.0 }, blended);
                with_view(squares, |view| LoadRule::new(kind).is_cpus(view))
            })
        };
        assert_eq!(is_cpus(false), [false, true, true, true]);
        assert_eq!(is_cpus(true), [false, false, false, true]);
    }

    #[test]
    fn the_cpu_draws_until_the_load_has_fallen_to_a_half() {
        let mut rule = LoadRule::new(wgpu::DeviceType::Cpu);
        let mut is_cpus = |count: usize| {
            with_view(cloud(vec![[0.0, 0.0, 5.0]; count], PointStyle::Points { diameter_px: 1.0 }, false), |view| {
                rule.is_cpus(view)
            })
        };
        let counts = [1_000_000, 1_000_001, 1_000_000, 500_001, 500_000, 1_000_000];
        assert_eq!(counts.map(&mut is_cpus), [false, true, true, true, false, false]);
    }
}
