//! Pictures that a GPU would take long for: with very much in them (`counts`), or whose faces lie over each other so
//! many times.
//!
//! A GPU visits each pixel of each face, also where something nearer hides it. 300,000 points of 4 mm that lie 6 cm
//! before the lens have thousands of millions of them. The CPU renderer looks for what is hidden before it draws, and
//! takes a tenth of a second for such a picture on two cores, so that it draws these instead: the ones whose faces
//! cover more than a [`Limit`]. How many pixels that are is estimated from distances and sizes, generously, and depends
//! on nothing but the scene and the camera, so that equal views are drawn by the same renderer.
//!
//! Lines of a pixel, text and cells cover little, or lie side by side.

use std::sync::Arc;

use nalgebra::{Matrix4, Vector3};
use rayon::prelude::*;
use rcs_scene::{
    Blending, Drawable, Geometry, Mesh, PointBuffer, PointStyle, Points, RibbonElement, Ribbons, Solids, Vertex,
};

use super::counts::Counts;
use super::geometry::Derived;
use crate::bounds::Bounds;
use crate::shading::drawn_point_size_px;
use crate::View;

/// How much a GPU draws in one picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Limit {
    /// The most pixels of its faces.
    face_px: f64,
    /// Whether those that blend with what is behind them count as well. No renderer can leave out what they hide, but a
    /// software driver visits their pixels no faster than the CPU renderer does.
    with_blended: bool,
    /// The most drawables and solids. More than these the CPU renderer places at least as fast.
    things: usize,
    /// The most points, lines, triangles and glyphs, as many points. Only a software driver takes long for them.
    work: usize,
}

impl Limit {
    /// Of a GPU of this kind, for some 10 ms. Discrete ones visit a hundred thousand million pixels in a second,
    /// integrated graphics a tenth of that.
    pub(super) fn of(kind: wgpu::DeviceType) -> Self {
        let face_px = if kind == wgpu::DeviceType::DiscreteGpu { 1024e6 } else { 128e6 };
        let is_software = kind == wgpu::DeviceType::Cpu;
        let work = if is_software { 1_000_000 } else { usize::MAX };
        Self { face_px, with_blended: is_software, things: 8_000, work }
    }
}

/// A core looks at so many faces before it takes the next.
const FACES_IN_SHARE: usize = 1 << 13;

/// What is known of the geometries that were met.
#[derive(Debug)]
pub(super) struct Overdraw {
    clouds: Derived<PointBuffer, Option<Bounds>>,
    meshes: Derived<Mesh, Surface>,
}

/// A mesh's size in its own frame.
#[derive(Clone, Copy, Debug)]
struct Surface {
    bounds: Option<Bounds>,
    area_m2: f64,
}

impl Surface {
    fn of(mesh: &Mesh) -> Self {
        let around = |vertices: &[Vertex]| {
            let positions: Vec<[f32; 3]> = vertices.iter().map(|vertex| vertex.position).collect();
            Bounds::around(&positions)
        };
        let bounds = mesh.vertices.par_chunks(FACES_IN_SHARE).filter_map(around).reduce_with(Bounds::joined);
        let area_m2 = |indices: &[u32]| triangles(indices, mesh).map(|corners| area_m2(&corners)).sum();
        Self { bounds, area_m2: sum_of(mesh.indices.par_chunks(3 * FACES_IN_SHARE).map(area_m2)) }
    }
}

/// The sum of what all cores find, which does not depend on which of them is first.
fn sum_of(shares: impl IndexedParallelIterator<Item = f64>) -> f64 {
    let shares: Vec<f64> = shares.collect();
    shares.iter().sum()
}

/// The corners of some triangles.
fn triangles<'a>(indices: &'a [u32], mesh: &'a Mesh) -> impl Iterator<Item = [[f32; 3]; 3]> + 'a {
    indices.as_chunks::<3>().0.iter().filter_map(|corners| {
        let [a, b, c] = corners.map(|index| mesh.vertices.get(index as usize).map(|vertex| vertex.position));
        Some([a?, b?, c?])
    })
}

/// A triangle's area; 0 where it is not finite.
fn area_m2(corners: &[[f32; 3]; 3]) -> f64 {
    let [a, b, c] = corners.map(Vector3::from);
    let area = 0.5 * (b - a).cross(&(c - a)).norm();
    if area.is_finite() {
        f64::from(area)
    } else {
        0.0
    }
}

/// How large a drawable's faces are in the picture.
struct Projection {
    /// The rows of the matrix to clip coordinates that give x, y and w.
    rows: [[f32; 4]; 3],
    clip_from_object: Matrix4<f64>,
    /// A length across the line of sight of a metre has so many pixels at a w of one, to the right and down.
    px_per_m: [f64; 2],
    near_w: f64,
    picture_px: f64,
}

impl Projection {
    fn new(view: &View<'_>, fixed_from_object: &Matrix4<f64>) -> Self {
        let camera = view.camera;
        let clip_from_object =
            camera.clip_from_view() * camera.fixed_from_view().inverse().to_homogeneous() * fixed_from_object;
        let row = |i: usize| [0, 1, 2, 3].map(|j| clip_from_object[(i, j)] as f32);
        let half_size = [camera.width_px(), camera.height_px()].map(|side| 0.5 * f64::from(side));
        let px_per_m = [0, 1].map(|i| half_size[i] * clip_from_object.fixed_view::<1, 3>(i, 0).norm());
        let picture_px = 4.0 * half_size[0] * half_size[1];
        Self { rows: [row(0), row(1), row(3)], clip_from_object, px_per_m, near_w: camera.near_m(), picture_px }
    }

    /// The most pixels of the picture that a face of this area covers, no part of which has a smaller w.
    fn face_px(&self, area_m2: f64, w: f64) -> f64 {
        let w = w.max(self.near_w);
        let px = area_m2 * self.px_per_m[0] * self.px_per_m[1] / (w * w);
        // Not where it is not a number.
        if px < self.picture_px {
            px
        } else {
            self.picture_px
        }
    }

    /// x, y and w of a place.
    fn clip(&self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        self.rows.map(|[a, b, c, d]| a * x + b * y + c * z + d)
    }

    /// Pixels of a face with these corners; none where it surely lies beside the picture or behind the eye.
    fn cornered_px<const N: usize>(&self, corners: [[f32; 3]; N], area_m2: f64) -> f64 {
        let corners = corners.map(|corner| self.clip(corner));
        let all = |is_outside: fn(&[f32; 3]) -> bool| corners.iter().all(is_outside);
        let is_outside = all(|[x, _, w]| x > w)
            || all(|[x, _, w]| -x > *w)
            || all(|[_, y, w]| y > w)
            || all(|[_, y, w]| -y > *w)
            || all(|[_, _, w]| *w <= 0.0);
        if is_outside {
            return 0.0;
        }
        self.face_px(area_m2, corners.iter().map(|[_, _, w]| f64::from(*w)).fold(f64::INFINITY, f64::min))
    }
}

impl Overdraw {
    pub(super) fn new() -> Self {
        Self { clouds: Derived::new(), meshes: Derived::new() }
    }

    pub(super) fn forget_dead(&mut self) {
        self.clouds.forget_dead();
        self.meshes.forget_dead();
    }

    /// Whether a picture has more than a limit in it.
    pub(super) fn is_heavy(&mut self, view: &View<'_>, limit: Limit) -> bool {
        let Limit { face_px, with_blended, things, work } = limit;
        let counts = Counts::of(view);
        if counts.things > things || counts.work > work {
            return true;
        }
        let shown = view.scene.drawables.iter().filter(|drawable| view.visible.shows(drawable.display));
        let counted: Vec<&Drawable> =
            shown.filter(|drawable| with_blended || !is_blended(&drawable.geometry)).collect();
        let at_most: f64 = counted.iter().map(|drawable| self.at_most_px(drawable, view)).sum();
        if at_most <= face_px {
            return false;
        }
        let mut sum_px = 0.0;
        counted.into_iter().any(|drawable| {
            sum_px += self.faces_px(drawable, view, with_blended);
            sum_px > face_px
        })
    }

    /// Pixels of a drawable's faces, no fewer than [`Self::faces_px`] says and found without a look at each face.
    fn at_most_px(&mut self, drawable: &Drawable, view: &View<'_>) -> f64 {
        let projection = Projection::new(view, &drawable.fixed_from_object);
        match &drawable.geometry {
            Geometry::Points(points) => {
                let bounds = self.bounds(&points.buffer);
                let nearest_w = bounds.map_or(f64::INFINITY, |bounds| bounds.nearest_w(&projection.clip_from_object));
                points.buffer.positions.len() as f64 * point_px(points, &projection, nearest_w)
            }
            Geometry::Mesh { mesh, .. } => {
                let Surface { bounds, area_m2 } = *self.meshes.get(mesh, Surface::of);
                let Some(bounds) = bounds else { return 0.0 };
                let nearest_w = bounds.nearest_w(&projection.clip_from_object).max(projection.near_w);
                let px = area_m2 * projection.px_per_m[0] * projection.px_per_m[1] / (nearest_w * nearest_w);
                px.min(mesh.indices.len() as f64 / 3.0 * projection.picture_px)
            }
            Geometry::Solids(solids) => solids.len() as f64 * projection.picture_px,
            Geometry::Ribbons(ribbons) => {
                ribbons.chains.iter().map(Vec::len).sum::<usize>() as f64 * projection.picture_px
            }
            Geometry::Lines(_) | Geometry::Text(_) | Geometry::Cells(_) | Geometry::Facing(_) => 0.0,
        }
    }

    /// Pixels of a drawable's faces, each by itself.
    fn faces_px(&mut self, drawable: &Drawable, view: &View<'_>, with_blended: bool) -> f64 {
        let projection = Projection::new(view, &drawable.fixed_from_object);
        match &drawable.geometry {
            Geometry::Points(points) => points_px(points, &projection),
            Geometry::Mesh { mesh, .. } => mesh_px(mesh, &projection),
            Geometry::Solids(solids) => {
                self.solids_px(solids, &Projection::new(view, &Matrix4::identity()), with_blended)
            }
            Geometry::Ribbons(ribbons) => ribbons_px(ribbons, &projection),
            Geometry::Lines(_) | Geometry::Text(_) | Geometry::Cells(_) | Geometry::Facing(_) => 0.0,
        }
    }

    fn bounds(&mut self, cloud: &Arc<PointBuffer>) -> Option<Bounds> {
        *self
            .clouds
            .get(cloud, |cloud| Bounds::around_finite(&cloud.positions).or_else(|| Bounds::around(&cloud.positions)))
    }

    /// Pixels of solids, whose places are in the fixed frame.
    fn solids_px(&mut self, solids: &Solids, projection: &Projection, with_blended: bool) -> f64 {
        let surfaces: Vec<Surface> = solids.shapes().iter().map(|shape| *self.meshes.get(shape, Surface::of)).collect();
        let counted = solids.as_slice().iter().filter(|solid| with_blended || !solid.is_translucent());
        let px = counted.filter_map(|solid| {
            let Surface { bounds, area_m2 } = surfaces.get(solid.shape())?;
            let columns = [0, 1, 2].map(|i| solid.fixed_from_shape.column(i).norm());
            let scale = columns.into_iter().fold(0.0, f64::max);
            let reach_m = scale * bounds.as_ref()?.reach_m();
            let [x, y, w] = projection.clip(solid.sort_point().cast().into()).map(f64::from);
            let [right, down, nearer] = projection.rows.map(|[a, b, c, _]| reach_m * f64::from(a.hypot(b).hypot(c)));
            let is_outside = w + nearer <= 0.0 || x.abs() - right > w + nearer || y.abs() - down > w + nearer;
            // The half that faces the eye; the other one is culled.
            let px = projection.face_px(0.5 * area_m2 * scale * scale, w - nearer);
            Some(if is_outside { 0.0 } else { px })
        });
        px.sum()
    }
}

/// Whether all of a geometry is blended.
fn is_blended(geometry: &Geometry) -> bool {
    match geometry {
        Geometry::Points(points) => points.blended,
        Geometry::Mesh { material, .. } => material.blending == Blending::Alpha,
        Geometry::Ribbons(ribbons) => ribbons.blending == Blending::Alpha,
        _ => false,
    }
}

/// The most pixels of a point at a distance.
fn point_px(points: &Points, projection: &Projection, w: f64) -> f64 {
    // Those that are too faint are not drawn, and auto-sized ones are the smaller the nearer they are.
    if points.alpha < 0.01 || points.auto_size {
        return 0.0;
    }
    let area = |[width, height]: [f32; 2]| f64::from(width * height).abs();
    match points.style {
        PointStyle::Points { diameter_px } => {
            f64::from(drawn_point_size_px(diameter_px)).powi(2).min(projection.picture_px)
        }
        PointStyle::Squares { size_m } | PointStyle::Spheres { size_m } | PointStyle::Tiles { size_m, .. } => {
            projection.face_px(area(size_m), w)
        }
        PointStyle::FlatSquares { side_m } => projection.face_px(area([side_m; 2]), w),
        // Of a box, one side faces the eye; those beside it add little.
        PointStyle::Boxes { size_m: [x, y, z] } => {
            let largest = area([x, y]).max(area([y, z])).max(area([x, z]));
            projection.face_px(largest, w)
        }
    }
}

/// How far a face reaches from its point.
fn reach_m(style: &PointStyle) -> f32 {
    match style {
        PointStyle::Points { .. } => 0.0,
        PointStyle::Squares { size_m } | PointStyle::Spheres { size_m } | PointStyle::Tiles { size_m, .. } => {
            0.5 * size_m[0].hypot(size_m[1])
        }
        PointStyle::FlatSquares { side_m } => side_m.abs(),
        PointStyle::Boxes { size_m: [x, y, z] } => 0.5 * x.hypot(*y).hypot(*z),
    }
}

fn points_px(points: &Points, projection: &Projection) -> f64 {
    let reach_m = reach_m(&points.style);
    let reach = projection.rows.map(|[a, b, c, _]| reach_m * a.hypot(b).hypot(c));
    let share_px = |positions: &[[f32; 3]]| -> f64 {
        let in_view = positions.iter().filter_map(|position| {
            let [x, y, w] = projection.clip(*position);
            let is_seen = w > 0.0 && x.abs() <= w + reach[0] && y.abs() <= w + reach[1];
            is_seen.then_some(f64::from(w))
        });
        in_view.map(|w| point_px(points, projection, w)).sum()
    };
    sum_of(points.buffer.positions.par_chunks(FACES_IN_SHARE).map(share_px))
}

fn mesh_px(mesh: &Mesh, projection: &Projection) -> f64 {
    let share_px = |indices: &[u32]| -> f64 {
        triangles(indices, mesh).map(|corners| projection.cornered_px(corners, area_m2(&corners))).sum()
    };
    sum_of(mesh.indices.par_chunks(3 * FACES_IN_SHARE).map(share_px))
}

fn ribbons_px(ribbons: &Ribbons, projection: &Projection) -> f64 {
    let chain_px = |chain: &Vec<RibbonElement>| -> f64 {
        let pieces = chain.par_windows(2).with_min_len(FACES_IN_SHARE);
        pieces
            .map(|piece| {
                let ends = [0, 1].map(|i| piece.get(i).map_or([f32::NAN; 3], |element| element.position));
                let length_m = (Vector3::from(ends[1]) - Vector3::from(ends[0])).norm();
                projection.cornered_px(ends, f64::from((length_m * ribbons.width_m).abs()))
            })
            .sum()
    };
    ribbons.chains.par_iter().with_min_len(64).map(chain_px).sum()
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Point3};
    use proptest::prelude::*;
    use rcs_scene::{
        Camera, CullMode, DisplayMask, Encoding, Intrinsics, Material, PointColors, RenderGroup, Rgba, Scene,
    };

    use super::*;

    const SIZE_PX: [u32; 2] = [640, 480];

    fn camera() -> Camera {
        let p = [500.0, 0.0, 320.0, 0.0, 0.0, 500.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        Camera::new(Intrinsics::from_p(SIZE_PX[0], SIZE_PX[1], &p).unwrap(), &Isometry3::identity(), 0.01)
    }

    fn drawable(geometry: Geometry) -> Drawable {
        let (fixed_from_object, sort_point) = (Matrix4::identity(), Point3::origin());
        Drawable { display: 0, fixed_from_object, sort_point, group: RenderGroup::Main, geometry }
    }

    fn cloud(positions: Vec<[f32; 3]>, style: PointStyle) -> Geometry {
        let buffer = Arc::new(PointBuffer { positions, colors: PointColors::Uniform([255; 4]) });
        Geometry::Points(Points { buffer, style, alpha: 1.0, blended: false, auto_size: false })
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

    /// What is estimated without and with a look at each face.
    fn estimates(geometry: Geometry) -> [f64; 2] {
        let scene = Scene { drawables: vec![drawable(geometry)], light: None };
        let (camera, visible) = (camera(), DisplayMask::all());
        let view =
            View { scene: &scene, camera: &camera, visible: &visible, background: [0; 3], encoding: Encoding::Rgb8 };
        let mut overdraw = Overdraw::new();
        let drawable = &scene.drawables[0];
        [overdraw.at_most_px(drawable, &view), overdraw.faces_px(drawable, &view, true)]
    }

    #[test]
    fn each_kind_of_gpu_has_its_limit() {
        use wgpu::DeviceType::{Cpu, DiscreteGpu, IntegratedGpu, Other, VirtualGpu};
        let discrete = Limit { face_px: 1024e6, with_blended: false, things: 8_000, work: usize::MAX };
        assert_eq!(Limit::of(DiscreteGpu), discrete);
        for kind in [IntegratedGpu, VirtualGpu, Other] {
            assert_eq!(Limit::of(kind), Limit { face_px: 128e6, ..discrete });
        }
        assert_eq!(Limit::of(Cpu), Limit { face_px: 128e6, with_blended: true, work: 1_000_000, ..discrete });
        // 500 squares of one metre at one metre and less fill the picture; 150 million pixels.
        let places: Vec<[f32; 3]> = (0..500).map(|i| [0.0, 0.0, 0.5 + i as f32 * 0.001]).collect();
        let blended = |blended: bool| match cloud(places.clone(), PointStyle::FlatSquares { side_m: 1.0 }) {
            Geometry::Points(points) => Geometry::Points(Points { blended, ..points }),
            other => other,
        };
        let is_heavy = |geometry: Geometry, limit: Limit| {
            let scene = Scene { drawables: vec![drawable(geometry)], light: None };
            let (camera, visible, background) = (camera(), DisplayMask::all(), [0; 3]);
            let view = View { scene: &scene, camera: &camera, visible: &visible, background, encoding: Encoding::Rgb8 };
            Overdraw::new().is_heavy(&view, limit)
        };
        let [discrete, integrated, software] = [DiscreteGpu, IntegratedGpu, Cpu].map(Limit::of);
        assert_eq!([discrete, integrated, software].map(|limit| is_heavy(blended(false), limit)), [false, true, true]);
        assert_eq!([discrete, integrated, software].map(|limit| is_heavy(blended(true), limit)), [false, false, true]);
    }

    fn all_kinds(places: Vec<[f32; 3]>) -> [(&'static str, Geometry); 5] {
        let mesh = squares(&places);
        let material = Arc::new(Material { cull: CullMode::None, ..Material::unlit(false) });
        let mut solids = Solids::default();
        for &[x, y, z] in &places {
            let place = Vector3::new(f64::from(x), f64::from(y), f64::from(z));
            solids.push(&squares(&[[0.0; 3]]), &Matrix4::new_translation(&place), Rgba::WHITE);
        }
        let across = |&[x, y, z]: &[f32; 3]| {
            [[x - 0.5, y, z], [x + 0.5, y, z]].map(|position| RibbonElement { position, color: [255; 4] }).to_vec()
        };
        let chains = places.iter().map(across).collect();
        [
            ("squares", cloud(places.clone(), PointStyle::FlatSquares { side_m: 1.0 })),
            ("boxes", cloud(places, PointStyle::Boxes { size_m: [1.0; 3] })),
            ("mesh", Geometry::Mesh { mesh, material }),
            ("solids", Geometry::Solids(Arc::new(solids))),
            ("ribbons", Geometry::Ribbons(Arc::new(Ribbons { chains, width_m: 1.0, blending: Blending::Replace }))),
        ]
    }

    #[test]
    fn a_square_has_the_pixels_that_it_covers() {
        // 50 by 50 pixels each at 10 m, and all of the picture at 0.1 m.
        for (name, geometry) in all_kinds(vec![[0.0, 0.0, 10.0], [1.0, -1.0, 10.0], [0.0, 0.0, 0.1]]) {
            let [_, px] = estimates(geometry);
            let expected = 2.0 * 2500.0 + 640.0 * 480.0;
            // Of solids half of the surface is seen, and they may reach nearer to the eye; a mesh's triangles are each
            // at most a picture.
            assert!((0.49..2.1).contains(&(px / expected)), "{name}: {px}");
        }
    }

    #[test]
    fn what_is_not_in_the_view_has_no_pixels() {
        let places = vec![[0.0, 0.0, -2.0], [30.0, 0.0, 2.0], [-30.0, 0.0, 2.0], [0.0, 30.0, 2.0], [0.0, -30.0, 2.0]];
        for (name, geometry) in all_kinds(places) {
            assert_eq!(estimates(geometry)[1], 0.0, "{name}");
        }
        // Right behind the eye, where solids may reach before it.
        for (name, geometry) in all_kinds(vec![[0.0, 0.0, -0.3]]).into_iter().filter(|(name, _)| *name != "solids") {
            assert_eq!(estimates(geometry)[1], 0.0, "{name}");
        }
        assert_eq!(estimates(cloud(Vec::new(), PointStyle::FlatSquares { side_m: 1.0 })), [0.0; 2]);
        let not_finite = vec![[f32::NAN, 0.0, 1.0], [f32::INFINITY; 3]];
        for (name, geometry) in all_kinds(not_finite) {
            let [at_most, px] = estimates(geometry);
            assert!(at_most.is_finite() && px.is_finite(), "{name}: {at_most} {px}");
        }
    }

    proptest! {
        #[test]
        fn no_face_is_missed_by_the_first_look(
            places in prop::collection::vec([-3.0..3.0_f32, -3.0..3.0, -3.0..6.0], 1..40)
        ) {
            for (name, geometry) in all_kinds(places) {
                let [at_most, px] = estimates(geometry);
                prop_assert!(px <= at_most * 1.0001, "{name}: {px} of {at_most}");
            }
        }
    }
}
