//! Cuts the scene's drawables into jobs.

use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

use rcs_scene::{
    Blending, CellSheet, CullMode, DisplayId, DisplayMask, Drawable, Geometry, Material, Mesh, Ordered, Vertex,
};

use super::{Job, Piece, Plan, PlanMemory};
use crate::cpu::geometry::instances::{Batch, BatchPiece, BatchView, Shapes};
use crate::cpu::geometry::meshes::{Shape, Solid};
use crate::cpu::geometry::points::Cloud;
use crate::cpu::paint::{DepthBias, Paint, Surface};
use crate::cpu::texture::{MipTexture, Textures};
use crate::cpu::tile::band::Mode;
use crate::cpu::tile::screen::ObjectTransform;
use crate::View;

/// Points of a job.
const POINTS_PER_JOB: usize = 8192;

/// Triangles and lines of a job.
const TRIANGLES_PER_JOB: usize = 1024;

/// Solids of a job, and a few characters count as one. Most of their triangles are not even looked at.
const SOLIDS_PER_JOB: usize = 64;
const GLYPHS_PER_SOLID: usize = 16;

/// Values derived from the scene's geometries, for as long as they live.
#[derive(Debug, Default)]
pub(in crate::cpu) struct Caches {
    textures: Textures,
    shapes: Shapes,
}

impl Caches {
    /// Drops the values of geometries that are gone.
    pub(in crate::cpu) fn forget_dead(&mut self) {
        self.textures.forget_dead();
        self.shapes.forget_dead();
    }

    fn surface_of(&mut self, material: &Material) -> Surface {
        let texture = material.texture.as_ref().map(|texture| MipTexture::new(texture, &mut self.textures));
        Surface::of(material, texture)
    }
}

/// The triangles of cells.
fn sheet_mesh() -> &'static Mesh {
    static MESH: OnceLock<Mesh> = OnceLock::new();
    MESH.get_or_init(|| {
        let vertices = CellSheet::TRIANGLES.into_iter().flatten();
        let vertices = vertices.map(|[x, y]| Vertex { uv: [x, y], ..Vertex::new([x, y, 0.0], [0.0, 0.0, 1.0]) });
        Mesh { vertices: vertices.collect(), indices: (0..6).collect() }
    })
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

/// A plan that is being made, with the job that is open.
pub(super) struct Builder<'a, 'c> {
    view: View<'a>,
    caches: &'c mut Caches,
    plan: Plan<'a>,
    /// The indices of the batches of solids, by the solids' addresses.
    batch_of_solids: HashMap<usize, usize>,
    ribbon_meshes: &'c mut Vec<Mesh>,
    /// The display of the drawable at hand, and of the first one in the open job.
    display: DisplayId,
    open_display: DisplayId,
    open_triangles: usize,
    open_piece: usize,
    open_solids: usize,
    open_batch_piece: usize,
}

impl<'a, 'c> Builder<'a, 'c> {
    /// Begins a plan of nothing.
    pub(super) fn new(
        view: &View<'a>,
        objects_of: Option<&'a DisplayMask>,
        caches: &'c mut Caches,
        memory: &'c mut PlanMemory,
    ) -> Self {
        Self {
            view: *view,
            caches,
            plan: Plan { objects_of, ..std::mem::take(&mut memory.plan) },
            batch_of_solids: HashMap::new(),
            ribbon_meshes: &mut memory.ribbon_meshes,
            display: DisplayId::default(),
            open_display: DisplayId::default(),
            open_triangles: 0,
            open_piece: 0,
            open_solids: 0,
            open_batch_piece: 0,
        }
    }

    /// The finished plan.
    pub(super) fn finish(mut self) -> Plan<'a> {
        self.close();
        self.plan
    }

    /// Adds a drawable.
    pub(super) fn add(&mut self, ordered: &Ordered<'a>) {
        let display = ordered.drawable.display;
        if self.plan.objects_of.is_some_and(|objects_of| objects_of.shows(display) != objects_of.shows(self.display)) {
            self.close();
        }
        self.display = display;
        if let Some(rest) = self.add_small(ordered) {
            self.add_large(rest);
        }
    }

    /// Adds many small things. Returns any other drawable.
    fn add_small(&mut self, ordered: &Ordered<'a>) -> Option<&'a Drawable> {
        let (view, drawable) = (self.view, ordered.drawable);
        match &drawable.geometry {
            Geometry::Solids(solids) => {
                self.plan.batch_view.get_or_insert_with(|| BatchView::new(&view));
                // Translucent solids of several drawables may take turns.
                let batch = *self.batch_of_solids.entry(Arc::as_ptr(solids) as usize).or_insert_with(|| {
                    self.plan.batches.push(Batch::of_solids(solids, &mut self.caches.shapes));
                    self.plan.batches.len() - 1
                });
                self.add_batch(batch, ordered.solids.clone(), 1);
            }
            Geometry::Text(text) => {
                self.plan.batches.push(Batch::Text(text, drawable));
                let batch_view = self.plan.batch_view.get_or_insert_with(|| BatchView::new(&view));
                batch_view.note_text(text, |material| self.caches.surface_of(material));
                self.add_batch(self.plan.batches.len() - 1, 0..text.glyphs().len(), GLYPHS_PER_SOLID);
            }
            _ => return Some(drawable),
        }
        None
    }

    /// Adds a cloud, a mesh, ribbons, lines or cells.
    fn add_large(&mut self, drawable: &'a Drawable) {
        let (view, camera) = (self.view, self.view.camera);
        let view_from_object = camera.fixed_from_view().inverse().to_homogeneous() * drawable.fixed_from_object;
        let transform = ObjectTransform::new(camera, &view_from_object, view.scene.light.as_ref());
        let (surface, shape) = match &drawable.geometry {
            Geometry::Solids(_) | Geometry::Text(_) | Geometry::Facing(_) => return,
            Geometry::Points(points) => {
                return self.add_cloud(Cloud::new(points, transform, camera, &drawable.fixed_from_object));
            }
            Geometry::Packed(packed) => {
                return self.add_cloud(Cloud::new(packed.points(), transform, camera, &drawable.fixed_from_object));
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
                let mut mesh = self.ribbon_meshes.pop().unwrap_or_default();
                ribbons.write_to(&mut mesh, camera.eye_in_object(&drawable.fixed_from_object));
                let surface = mirrored_like(drawable, self.caches.surface_of(&material));
                (surface, Shape::Mesh(Cow::Owned(mesh), Cow::Owned(material)))
            }
            Geometry::Mesh { mesh, material } => {
                let surface = mirrored_like(drawable, self.caches.surface_of(material));
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
        let index = self.plan.clouds.len();
        let count = cloud.points.buffer.positions.len();
        self.plan.clouds.push(cloud);
        let first_job = self.plan.jobs.len();
        for begin in (0..count).step_by(POINTS_PER_JOB) {
            self.plan.jobs.push(Job::Points(index, begin..count.min(begin + POINTS_PER_JOB)));
            self.plan.job_displays.push(self.display);
        }
        self.plan.cloud_jobs.push(first_job..self.plan.jobs.len());
    }

    fn add_solid(&mut self, solid: Solid<'a>) {
        self.close_batches();
        let count = solid.shape.primitive_count();
        let index = self.plan.solids.len();
        self.plan.solids.push(solid);
        let mut begin = 0;
        while begin < count {
            let room = TRIANGLES_PER_JOB.saturating_sub(self.open_triangles).max(1);
            let end = count.min(begin + room);
            if self.open_piece == self.plan.pieces.len() {
                self.open_display = self.display;
            }
            self.plan.pieces.push(Piece { solid: index, range: begin..end });
            self.open_triangles += end - begin;
            if self.open_triangles >= TRIANGLES_PER_JOB {
                self.close_solids();
            }
            begin = end;
        }
    }

    /// Adds some of a batch; `in_solid` of them are as much work as a solid.
    fn add_batch(&mut self, batch: usize, range: Range<usize>, in_solid: usize) {
        self.close_solids();
        let mut begin = range.start;
        while begin < range.end {
            let room = SOLIDS_PER_JOB.saturating_sub(self.open_solids).max(1);
            let end = range.end.min(begin + room * in_solid);
            if self.open_batch_piece == self.plan.batch_pieces.len() {
                self.open_display = self.display;
            }
            self.plan.batch_pieces.push(BatchPiece { batch, range: begin..end });
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
        if self.open_piece < self.plan.pieces.len() {
            self.plan.jobs.push(Job::Meshes(self.open_piece..self.plan.pieces.len()));
            self.plan.job_displays.push(self.open_display);
        }
        (self.open_piece, self.open_triangles) = (self.plan.pieces.len(), 0);
    }

    fn close_batches(&mut self) {
        if self.open_batch_piece < self.plan.batch_pieces.len() {
            self.plan.jobs.push(Job::Instances(self.open_batch_piece..self.plan.batch_pieces.len()));
            self.plan.job_displays.push(self.open_display);
        }
        (self.open_batch_piece, self.open_solids) = (self.plan.batch_pieces.len(), 0);
    }
}
