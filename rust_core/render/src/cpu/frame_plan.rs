//! The work for one picture: the scene's drawables in their order, cut into jobs of about equal size.
//!
//! A job turns a chunk of a cloud, several meshes and lines, or many small solids and glyphs together into things that
//! are sorted into the picture's bands. Jobs are independent of each other; drawn in their order they give the picture.
//!
//! A plan borrows from its scene, so it does not outlive the picture; its memory does ([`FramePlanMemory`]).

use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

use rcs_scene::{
    Blending, CellSheet, CullMode, DisplayId, DrawOrder, Drawable, Geometry, Material, Mesh, Ordered, Vertex,
};

use super::band::Mode;
use super::instances::{shape_of, Batch, BatchPiece, BatchView, Shapes, SmallMesh};
use super::paint::{DepthBias, Paint, Surface};
use super::points::Cloud;
use super::screen::ObjectTransform;
use super::solids::{Shape, Solid};
use super::texture::{MipTexture, Textures};
use crate::View;

/// Points of a job.
const POINTS_PER_JOB: usize = 8192;

/// Triangles and lines of a job.
const TRIANGLES_PER_JOB: usize = 1024;

/// Meshes of fewer triangles go with the many small things.
const TRIANGLES_OF_SMALL_MESH: usize = 2048;

/// Solids of a job, and a few characters count as one. Most of their triangles are not even looked at.
const SOLIDS_PER_JOB: usize = 64;
const GLYPHS_PER_SOLID: usize = 16;

/// The triangles of cells.
fn sheet_mesh() -> &'static Mesh {
    static MESH: OnceLock<Mesh> = OnceLock::new();
    MESH.get_or_init(|| {
        let vertices = CellSheet::TRIANGLES.into_iter().flatten();
        let vertices = vertices.map(|[x, y]| Vertex { uv: [x, y], ..Vertex::new([x, y, 0.0], [0.0, 0.0, 1.0]) });
        Mesh { vertices: vertices.collect(), indices: (0..6).collect() }
    })
}

/// One job.
#[derive(Clone, Debug)]
pub(super) enum Job {
    /// Points of the cloud with this index.
    Points(usize, Range<usize>),
    /// Some of the plan's pieces.
    Pieces(Range<usize>),
    /// Some of the plan's pieces of batches.
    Batches(Range<usize>),
}

impl Job {
    /// Whether the faces of both may be drawn together: both are of one cloud, or both of triangles.
    pub(super) fn goes_with(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Points(cloud, _), Self::Points(other, _)) => cloud == other,
            (Self::Pieces(_), Self::Pieces(_)) | (Self::Batches(_), Self::Batches(_)) => true,
            _ => false,
        }
    }
}

/// Some primitives of the solid with this index.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    /// Index of the solid.
    pub solid: usize,
    /// Which of its triangles or lines.
    pub range: Range<usize>,
}

/// All jobs of a picture.
#[derive(Debug, Default)]
pub(super) struct FramePlan<'a> {
    /// The clouds.
    pub clouds: Vec<Cloud<'a>>,
    /// Everything else.
    pub solids: Vec<Solid<'a>>,
    /// Meshes of fewer triangles are small.
    small_mesh_triangles: usize,
    /// The pieces of solids that the jobs draw.
    pub pieces: Vec<Piece>,
    /// Many small solids together, and texts.
    pub batches: Vec<Batch<'a>>,
    /// The indices of the batches of solids, by the solids' addresses.
    batch_of_solids: HashMap<usize, usize>,
    /// The pieces of batches that the jobs draw.
    pub batch_pieces: Vec<BatchPiece>,
    /// What the batches share, where there are some.
    pub batch_view: Option<BatchView<'a>>,
    /// In the order of drawing.
    pub jobs: Vec<Job>,
    /// Whose each job is; where several share one, the first one's.
    pub job_displays: Vec<DisplayId>,
    /// That of the drawable at hand, and of the first one in the open job.
    display: DisplayId,
    open_display: DisplayId,
    cloud_jobs: Vec<Range<usize>>,
    open_triangles: usize,
    open_piece: usize,
    open_solids: usize,
    open_batch_piece: usize,
    /// For wide lines that turn to the camera.
    reusable_meshes: Vec<Mesh>,
}

/// The memory of a picture's plan, for the next one.
#[derive(Debug, Default)]
pub(super) struct FramePlanMemory {
    order: DrawOrder,
    plan: FramePlan<'static>,
    /// For tests: meshes of fewer triangles are small.
    pub small_mesh_triangles: Option<usize>,
}

/// The memory of a vector for elements of the same type with another lifetime: the library collects in place here. The
/// memory of a much larger picture is given back.
fn emptied<T, U>(vector: Vec<T>) -> Vec<U> {
    const SPARE: usize = 1024;
    let (used, room) = (vector.len(), vector.capacity());
    let mut vector: Vec<U> = vector.into_iter().filter_map(|_| None).collect();
    if room > 4 * used + SPARE {
        vector.shrink_to(used);
    }
    vector
}

impl FramePlanMemory {
    /// Takes the memory of a plan that is not needed any more.
    pub(super) fn keep(&mut self, mut plan: FramePlan<'_>) {
        // Those that this picture did not use are dropped.
        plan.reusable_meshes.clear();
        plan.reusable_meshes.extend(plan.solids.iter_mut().filter_map(|solid| match &mut solid.shape {
            Shape::Mesh(Cow::Owned(mesh), _) => Some(std::mem::take(mesh)),
            _ => None,
        }));
        // The next picture's are taken from the end.
        plan.reusable_meshes.reverse();
        self.plan = plan.emptied();
    }
}

/// The surface of a drawable that may be turned inside out.
fn mirrored_like(drawable: &Drawable, surface: Surface) -> Surface {
    let is_mirrored = drawable.fixed_from_object.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
    if is_mirrored {
        surface.mirrored()
    } else {
        surface
    }
}

impl<'a> FramePlan<'a> {
    /// Plans a picture.
    pub(super) fn new(
        view: &View<'a>,
        textures: &mut Textures,
        shapes: &mut Shapes,
        memory: &mut FramePlanMemory,
    ) -> Self {
        let mut plan: Self = std::mem::take(&mut memory.plan);
        plan.small_mesh_triangles = memory.small_mesh_triangles.unwrap_or(TRIANGLES_OF_SMALL_MESH);
        memory.order.sort(view.scene, view.visible, &view.camera.eye());
        for ordered in memory.order.of(view.scene) {
            plan.display = ordered.drawable.display;
            plan.add(view, textures, shapes, ordered);
        }
        plan.close();
        plan
    }

    /// A plan of nothing in the same memory, and with the same reusable meshes.
    fn emptied(self) -> FramePlan<'static> {
        FramePlan {
            clouds: emptied(self.clouds),
            solids: emptied(self.solids),
            pieces: emptied(self.pieces),
            batches: emptied(self.batches),
            batch_pieces: emptied(self.batch_pieces),
            jobs: emptied(self.jobs),
            job_displays: emptied(self.job_displays),
            cloud_jobs: emptied(self.cloud_jobs),
            reusable_meshes: self.reusable_meshes,
            ..FramePlan::default()
        }
    }

    fn add(&mut self, view: &View<'a>, textures: &mut Textures, shapes: &mut Shapes, ordered: Ordered<'a>) {
        let (camera, drawable) = (view.camera, ordered.drawable);
        let mut surface_of = |material: &Material| {
            Surface::of(material, material.texture.as_ref().map(|texture| MipTexture::new(texture, textures)))
        };
        match &drawable.geometry {
            Geometry::Solids(solids) => {
                self.batch_view.get_or_insert_with(|| BatchView::new(view));
                // Translucent solids of several drawables may take turns.
                let batch = *self.batch_of_solids.entry(Arc::as_ptr(solids) as usize).or_insert_with(|| {
                    self.batches.push(Batch::of_solids(solids, shapes));
                    self.batches.len() - 1
                });
                return self.add_batch(batch, ordered.solids, 1);
            }
            Geometry::Text(text) => {
                self.batches.push(Batch::Text(text, drawable));
                self.batch_view.get_or_insert_with(|| BatchView::new(view)).note_text(text, surface_of);
                return self.add_batch(self.batches.len() - 1, 0..text.glyphs().len(), GLYPHS_PER_SOLID);
            }
            Geometry::Mesh { mesh, material } if mesh.indices.len() / 3 < self.small_mesh_triangles => {
                let surface = mirrored_like(drawable, surface_of(material));
                let shape = shape_of(mesh, shapes);
                self.batches.push(Batch::Mesh(SmallMesh { drawable, mesh, material, surface, shape }));
                self.batch_view.get_or_insert_with(|| BatchView::new(view));
                return self.add_batch(self.batches.len() - 1, 0..1, 1);
            }
            _ => {}
        }
        let view_from_object = camera.fixed_from_view().inverse().to_homogeneous() * drawable.fixed_from_object;
        let transform = ObjectTransform::new(camera, &view_from_object, view.scene.light.as_ref());
        let (surface, shape) = match &drawable.geometry {
            Geometry::Solids(_) | Geometry::Text(_) | Geometry::Facing(_) => return,
            Geometry::Points(points) => {
                return self.add_cloud(Cloud::new(points, transform, camera, &drawable.fixed_from_object));
            }
            Geometry::Lines(lines) => {
                let mode = Mode::new(lines.blending == Blending::Alpha);
                (
                    Surface { paint: Paint::Color, mode, cull: CullMode::None, depth_bias: DepthBias::NONE },
                    Shape::Lines(lines),
                )
            }
            Geometry::Ribbons(ribbons) => {
                let material = Material::unlit(ribbons.blending == Blending::Alpha);
                let mut mesh = self.reusable_meshes.pop().unwrap_or_default();
                ribbons.write_to(&mut mesh, camera.eye_in_object(&drawable.fixed_from_object));
                let surface = mirrored_like(drawable, surface_of(&material));
                (surface, Shape::Mesh(Cow::Owned(mesh), Cow::Owned(material)))
            }
            Geometry::Mesh { mesh, material } => {
                let surface = mirrored_like(drawable, surface_of(material));
                (surface, Shape::Mesh(Cow::Borrowed(mesh), Cow::Borrowed(material)))
            }
            Geometry::Cells(sheet) => {
                (Surface::of_cells(sheet), Shape::Mesh(Cow::Borrowed(sheet_mesh()), Cow::Owned(Material::unlit(false))))
            }
        };
        self.add_solid(Solid { transform, surface, shape });
    }

    fn add_cloud(&mut self, cloud: Cloud<'a>) {
        self.close();
        let index = self.clouds.len();
        let count = cloud.points.buffer.positions.len();
        self.clouds.push(cloud);
        let first_job = self.jobs.len();
        for begin in (0..count).step_by(POINTS_PER_JOB) {
            self.jobs.push(Job::Points(index, begin..count.min(begin + POINTS_PER_JOB)));
            self.job_displays.push(self.display);
        }
        self.cloud_jobs.push(first_job..self.jobs.len());
    }

    fn add_solid(&mut self, solid: Solid<'a>) {
        self.close_batches();
        let count = solid.shape.primitive_count();
        let index = self.solids.len();
        self.solids.push(solid);
        let mut begin = 0;
        while begin < count {
            let room = TRIANGLES_PER_JOB.saturating_sub(self.open_triangles).max(1);
            let end = count.min(begin + room);
            if self.open_piece == self.pieces.len() {
                self.open_display = self.display;
            }
            self.pieces.push(Piece { solid: index, range: begin..end });
            self.open_triangles += end - begin;
            if self.open_triangles >= TRIANGLES_PER_JOB {
                self.close_solids();
            }
            begin = end;
        }
    }

    /// Adds some of a batch, of which so many are as much work as a solid.
    fn add_batch(&mut self, batch: usize, range: Range<usize>, in_solid: usize) {
        self.close_solids();
        let mut begin = range.start;
        while begin < range.end {
            let room = SOLIDS_PER_JOB.saturating_sub(self.open_solids).max(1);
            let end = range.end.min(begin + room * in_solid);
            if self.open_batch_piece == self.batch_pieces.len() {
                self.open_display = self.display;
            }
            self.batch_pieces.push(BatchPiece { batch, range: begin..end });
            self.open_solids += (end - begin).div_ceil(in_solid);
            if self.open_solids >= SOLIDS_PER_JOB {
                self.close_batches();
            }
            begin = end;
        }
    }

    fn close(&mut self) {
        self.close_solids();
        self.close_batches();
    }

    fn close_solids(&mut self) {
        if self.open_piece < self.pieces.len() {
            self.jobs.push(Job::Pieces(self.open_piece..self.pieces.len()));
            self.job_displays.push(self.open_display);
        }
        (self.open_piece, self.open_triangles) = (self.pieces.len(), 0);
    }

    fn close_batches(&mut self) {
        if self.open_batch_piece < self.batch_pieces.len() {
            self.jobs.push(Job::Batches(self.open_batch_piece..self.batch_pieces.len()));
            self.job_displays.push(self.open_display);
        }
        (self.open_batch_piece, self.open_solids) = (self.batch_pieces.len(), 0);
    }

    /// Marks the clouds that Ogre would not draw, given the points that each job has selected.
    pub(super) fn cull_clouds<I: Iterator<Item = u32>>(&mut self, selected: impl Fn(usize) -> I) {
        for (cloud, jobs) in self.clouds.iter_mut().zip(&self.cloud_jobs) {
            cloud.is_culled = cloud.lies_outside(jobs.clone().flat_map(&selected));
        }
    }
}
