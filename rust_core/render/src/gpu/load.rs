//! Which pictures the CPU draws instead of the GPU.
//!
//! A GPU visits each pixel of each face, also where something nearer hides it, and goes through all primitives,
//! wherever they are. The CPU renderer finds out first what may be seen. So there is one rule: a picture has a load,
//! the largest of three shares of what a GPU of the kind draws in some 10 ms:
//!
//! - pixels of faces, counted as often as they are covered. Translucent faces hide nothing, so that they count only for
//!   software drivers, which visit their pixels no faster than the CPU renderer does;
//! - things that are placed by themselves: drawables and solids;
//! - primitives, for software drivers only.
//!
//! The CPU draws pictures of a load above 1, and from then on until the load falls to a half: the pictures of a scene
//! about the limit do not change between the renderers, which may differ in a pixel. Pixels are estimated from a sample
//! of the faces. Lines of a pixel, text and cells cover little.

use nalgebra::{Matrix4, Vector4};
use rcs_scene::{Blending, Drawable, Geometry, Mesh, PointStyle, Points};

use crate::shading::drawn_point_size_px;
use crate::View;

/// The load from which on the GPU draws again.
const LOW: f64 = 0.5;

/// Faces of a drawable that are looked at.
const SAMPLES: usize = 1024;

/// Triangles of a solid that are looked at.
const SAMPLES_OF_SOLID: usize = 16;

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
            if self.with_blended || !is_blended(&drawable.geometry) {
                face_px += faces_px(drawable, &Projection::new(view));
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

/// True if all of a geometry is blended.
fn is_blended(geometry: &Geometry) -> bool {
    match geometry {
        Geometry::Points(points) => points.blended,
        Geometry::Mesh { material, .. } => material.blending == Blending::Alpha,
        Geometry::Ribbons(ribbons) => ribbons.blending == Blending::Alpha,
        _ => false,
    }
}

/// From the fixed frame to the picture.
struct Projection {
    clip_from_fixed: Matrix4<f64>,
    half_size_px: [f64; 2],
    near_m: f64,
}

impl Projection {
    fn new(view: &View<'_>) -> Self {
        let camera = view.camera;
        Self {
            clip_from_fixed: camera.clip_from_view() * camera.fixed_from_view().inverse().to_homogeneous(),
            half_size_px: [camera.width_px(), camera.height_px()].map(|side| 0.5 * f64::from(side)),
            near_m: camera.near_m(),
        }
    }

    /// At most all of the picture; also where it is not a number.
    fn in_picture(&self, px: f64) -> f64 {
        let all = 4.0 * self.half_size_px[0] * self.half_size_px[1];
        if px < all {
            px
        } else {
            all
        }
    }

    /// Pixels of a triangle with these corners in clip coordinates, from both sides; none beside the picture.
    fn triangle_px(&self, corners: [Vector4<f64>; 3]) -> f64 {
        let is_beyond = |distance: fn(&Vector4<f64>) -> f64| corners.iter().all(|corner| distance(corner) < 0.0);
        let is_beside = is_beyond(|c| c.w - c.x)
            || is_beyond(|c| c.w + c.x)
            || is_beyond(|c| c.w - c.y)
            || is_beyond(|c| c.w + c.y)
            || is_beyond(|c| c.w);
        if is_beside || corners.iter().any(|corner| !corner.sum().is_finite()) {
            return 0.0;
        }
        if corners.iter().any(|corner| corner.w < self.near_m) {
            return self.in_picture(f64::INFINITY);
        }
        let [a, b, c] = corners.map(|corner| corner.xy() / corner.w);
        self.in_picture(0.5 * (b - a).perp(&(c - a)).abs() * self.half_size_px[0] * self.half_size_px[1])
    }
}

/// The sum over all, from a sample of them.
fn sampled<T>(all: impl ExactSizeIterator<Item = T>, samples: usize, px: impl Fn(T) -> f64) -> f64 {
    let step = all.len().div_ceil(samples).max(1);
    all.step_by(step).map(px).sum::<f64>() * step as f64
}

/// Pixels of a drawable's faces, each by itself.
fn faces_px(drawable: &Drawable, projection: &Projection) -> f64 {
    let clip_from_object = projection.clip_from_fixed * drawable.fixed_from_object;
    match &drawable.geometry {
        Geometry::Points(points) => points_px(points, &clip_from_object, projection),
        Geometry::Mesh { mesh, .. } => mesh_px(mesh, &clip_from_object, projection, SAMPLES),
        Geometry::Solids(solids) => sampled(solids.as_slice().iter(), SAMPLES, |solid| {
            let clip_from_solid = projection.clip_from_fixed * solid.matrix();
            let mesh = solids.shapes().get(solid.shape());
            mesh.map_or(0.0, |mesh| mesh_px(mesh, &clip_from_solid, projection, SAMPLES_OF_SOLID))
        }),
        Geometry::Ribbons(ribbons) => {
            let width_m = f64::from(ribbons.width_m).abs();
            let pieces: Vec<_> = ribbons.chains.iter().flat_map(|chain| chain.windows(2)).collect();
            sampled(pieces.iter(), SAMPLES, |piece| {
                let ends = [0, 1].map(|i| clip_from_object * homogeneous(piece[i].position));
                let across =
                    Vector4::new(0.0, width_m * projection.clip_from_fixed.row(1).columns(0, 3).norm(), 0.0, 0.0);
                2.0 * projection.triangle_px([ends[0], ends[1], ends[1] + across])
            })
        }
        Geometry::Lines(_) | Geometry::Text(_) | Geometry::Cells(_) | Geometry::Facing(_) => 0.0,
    }
}

fn homogeneous(position: [f32; 3]) -> Vector4<f64> {
    let [x, y, z] = position.map(f64::from);
    Vector4::new(x, y, z, 1.0)
}

fn mesh_px(mesh: &Mesh, clip_from_mesh: &Matrix4<f64>, projection: &Projection, samples: usize) -> f64 {
    sampled(mesh.indices.as_chunks::<3>().0.iter(), samples, |corners| {
        let corners = corners.map(|index| mesh.vertices.get(index as usize));
        let [Some(a), Some(b), Some(c)] = corners else { return 0.0 };
        projection.triangle_px([a, b, c].map(|vertex| clip_from_mesh * homogeneous(vertex.position)))
    })
}

fn points_px(points: &Points, clip_from_object: &Matrix4<f64>, projection: &Projection) -> f64 {
    // Those that are too faint are not drawn, and auto-sized ones are the smaller the nearer they are.
    if points.alpha < 0.01 || points.auto_size {
        return 0.0;
    }
    let [width_m, height_m] = match points.style {
        PointStyle::Points { diameter_px } => {
            let px = f64::from(drawn_point_size_px(diameter_px)).powi(2);
            return points.buffer.positions.len() as f64 * projection.in_picture(px);
        }
        PointStyle::Squares { size_m } | PointStyle::Spheres { size_m } | PointStyle::Tiles { size_m, .. } => size_m,
        PointStyle::FlatSquares { side_m } => [side_m; 2],
        // Of a box, about one side faces the eye.
        PointStyle::Boxes { size_m: [x, y, z] } => [x.max(z), y],
    }
    .map(|side_m| f64::from(side_m).abs());
    // How far a metre reaches in clip coordinates, along each axis.
    let per_m = [0, 1, 3].map(|row| clip_from_object.row(row).columns(0, 3).norm());
    let reach_m = 0.5 * width_m.hypot(height_m);
    let at_one = width_m * height_m * per_m[0] * per_m[1] * projection.half_size_px[0] * projection.half_size_px[1];
    sampled(points.buffer.positions.iter(), SAMPLES, |position| {
        let place = clip_from_object * homogeneous(*position);
        let is_seen = place.w > 0.0
            && place.x.abs() <= place.w + reach_m * per_m[0]
            && place.y.abs() <= place.w + reach_m * per_m[1];
        if is_seen {
            projection.in_picture(at_one / place.w.max(projection.near_m).powi(2))
        } else {
            0.0
        }
    })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use nalgebra::{Isometry3, Point3, Vector3};
    use rcs_scene::{
        Camera, CullMode, DisplayMask, Encoding, Intrinsics, Material, PointBuffer, PointColors, RenderGroup, Rgba,
        RibbonElement, Ribbons, Scene, Solids, Vertex,
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

    fn px(geometry: Geometry) -> f64 {
        with_view(geometry, |view| faces_px(&view.scene.drawables[0], &Projection::new(view)))
    }

    fn cloud(positions: Vec<[f32; 3]>, style: PointStyle, blended: bool) -> Geometry {
        let buffer = Arc::new(PointBuffer { positions, colors: PointColors::Uniform([255; 4]) });
        Geometry::Points(Points { buffer, style, alpha: 1.0, blended, auto_size: false })
    }

    /// A square of one metre across the line of sight, for each of these places.
    fn squares(places: &[[f32; 3]]) -> Arc<Mesh> {
        let mut mesh = Mesh::default();
        for &[x, y, z] in places {
            let first = mesh.vertices.len() as u32;
            let corners = [[-0.5, -0.5], [-0.5, 0.5], [0.5, 0.5], [0.5, -0.5]];
            mesh.vertices.extend(corners.map(|[u, v]| Vertex::new([x + u, y + v, z], [0.0, 0.0, -1.0])));
            mesh.indices.extend([0, 1, 2, 0, 2, 3].map(|corner| first + corner));
        }
        Arc::new(mesh)
    }

    fn all_kinds(places: &[[f32; 3]]) -> [(&'static str, Geometry); 5] {
        let material = Arc::new(Material { cull: CullMode::None, ..Material::unlit(false) });
        let mut solids = Solids::default();
        for place in places {
            let place = Vector3::from(place.map(f64::from));
            solids.push(&squares(&[[0.0; 3]]), &Matrix4::new_translation(&place), Rgba::WHITE);
        }
        let across = |&[x, y, z]: &[f32; 3]| {
            [[x - 0.5, y, z], [x + 0.5, y, z]].map(|position| RibbonElement { position, color: [255; 4] }).to_vec()
        };
        let chains = places.iter().map(across).collect();
        [
            ("squares", cloud(places.to_vec(), PointStyle::FlatSquares { side_m: 1.0 }, false)),
            ("boxes", cloud(places.to_vec(), PointStyle::Boxes { size_m: [1.0; 3] }, false)),
            ("mesh", Geometry::Mesh { mesh: squares(places), material }),
            ("solids", Geometry::Solids(Arc::new(solids))),
            ("ribbons", Geometry::Ribbons(Arc::new(Ribbons { chains, width_m: 1.0, blending: Blending::Replace }))),
        ]
    }

    #[test]
    fn a_square_has_the_pixels_that_it_covers() {
        // 50 by 50 pixels each at 10 m, and all of the picture at 0.1 m.
        for (name, geometry) in all_kinds(&[[0.0, 0.0, 10.0], [1.0, -1.0, 10.0], [0.0, 0.0, 0.1]]) {
            let expected = 2.0 * 2500.0 + 640.0 * 480.0;
            let px = px(geometry);
            // A mesh's triangles are each at most a picture.
            assert!((0.49..2.1).contains(&(px / expected)), "{name}: {px}");
        }
    }

    #[test]
    fn what_is_not_in_the_view_has_no_pixels() {
        let beside = [[0.0, 0.0, -2.0], [30.0, 0.0, 2.0], [-30.0, 0.0, 2.0], [0.0, 30.0, 2.0], [0.0, -30.0, 2.0]];
        let not_finite = [[f32::NAN, 0.0, 1.0], [f32::INFINITY; 3]];
        for places in [&beside[..], &not_finite, &[]] {
            for (name, geometry) in all_kinds(places) {
                assert_eq!(px(geometry), 0.0, "{name}");
            }
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
