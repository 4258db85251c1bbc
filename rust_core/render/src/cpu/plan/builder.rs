//! Cuts the scene's drawables into jobs.

use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

use nalgebra::Matrix4;
use rcs_scene::{
    Blending, CellSheet, CullMode, DisplayId, DisplayMask, Drawable, Geometry, Material, Mesh, Ordered, Points, Vertex,
};

use super::{Job, Piece, Plan, PlanMemory};
use crate::cpu::geometry::instances::{Batch, Batches, Shapes};
use crate::cpu::geometry::meshes::{Shape, Solid};
use crate::cpu::geometry::points::Cloud;
use crate::cpu::paint::{DepthBias, Paint, Surface};
use crate::cpu::texture::{MipTexture, Textures};
use crate::cpu::tile::band::Mode;
use crate::cpu::tile::screen::ObjectTransform;
use crate::View;

/// Points of a job.
const POINTS_PER_JOB: usize = 8192;

/// Work of a job, in triangles or lines.
const WORK_PER_JOB: usize = 1024;

/// Work of a glyph, and of a small solid, most of whose triangles are not even looked at.
const WORK_OF_GLYPH: usize = 8;
const WORK_OF_SOLID: usize = 16;

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
    /// The first piece of the open job, and the work of all.
    open_piece: usize,
    open_work: usize,
    has_batches: bool,
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
            open_piece: 0,
            open_work: 0,
            has_batches: false,
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
        match &ordered.drawable.geometry {
            Geometry::Solids(solids) => {
                let batches = &mut self.plan.batches.get_or_insert_with(|| Batches::new(&self.view)).batches;
                // Translucent solids of several drawables may take turns.
                let batch = *self.batch_of_solids.entry(Arc::as_ptr(solids) as usize).or_insert_with(|| {
                    batches.push(Batch::new(solids, &mut self.caches.shapes));
                    batches.len() - 1
                });
                self.add_pieces(batch, ordered.solids.clone(), WORK_OF_SOLID, true);
            }
            _ => self.add_large(ordered.drawable),
        }
    }

    /// Adds any drawable but small solids.
    fn add_large(&mut self, drawable: &'a Drawable) {
        let (view, camera) = (self.view, self.view.camera);
        let view_from_object = match &drawable.geometry {
            Geometry::Text(_) => camera.view_from_facing(&drawable.fixed_from_object).cast(),
            _ => camera.fixed_from_view().inverse().to_homogeneous() * drawable.fixed_from_object,
        };
        let transform = ObjectTransform::new(camera, &view_from_object, view.scene.light.as_ref());
        let (surface, shape) = match &drawable.geometry {
            Geometry::Solids(_) | Geometry::Facing(_) => return,
            Geometry::Points(points) => return self.add_cloud(points, transform, &drawable.fixed_from_object),
            Geometry::Packed(packed) => {
                return self.add_cloud(packed.points(), transform, &drawable.fixed_from_object);
            }
            Geometry::Lines(lines) => {
                let mode = Mode::new(lines.blending == Blending::Alpha);
                (
                    Surface { paint: Paint::Color, mode, cull: CullMode::None, depth_bias: DepthBias::NONE },
                    Shape::Lines(lines),
                )
            }
            Geometry::Text(text) => (self.caches.surface_of(text.material()), Shape::Text(text)),
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
        let (index, count) = (self.plan.solids.len(), shape.primitive_count());
        let work_of_each = if matches!(shape, Shape::Text(_)) { WORK_OF_GLYPH } else { 1 };
        self.plan.solids.push(Solid { transform, surface, shape });
        self.add_pieces(index, 0..count, work_of_each, false);
    }

    fn add_cloud(&mut self, points: &'a Points, transform: ObjectTransform, fixed_from_object: &Matrix4<f64>) {
        self.close();
        let camera = self.view.camera;
        let cloud = Cloud::new(points, transform, camera.eye_in_object(fixed_from_object));
        if cloud.lies_outside(camera, fixed_from_object) {
            return;
        }
        let (index, count) = (self.plan.clouds.len(), points.buffer.positions.len());
        self.plan.clouds.push(cloud);
        for begin in (0..count).step_by(POINTS_PER_JOB) {
            self.plan.jobs.push(Job::Points(index, begin..count.min(begin + POINTS_PER_JOB)));
            self.plan.job_displays.push(self.display);
        }
    }

    /// Adds pieces of a batch or of a solid to the open job, and to as many others as they need.
    fn add_pieces(&mut self, primitive: usize, range: Range<usize>, work_of_each: usize, is_batch: bool) {
        if self.has_batches != is_batch {
            self.close();
            self.has_batches = is_batch;
        }
        let mut begin = range.start;
        while begin < range.end {
            let room = WORK_PER_JOB.saturating_sub(self.open_work) / work_of_each;
            let end = range.end.min(begin + room.max(1));
            if self.open_piece == self.plan.pieces.len() {
                self.open_display = self.display;
            }
            self.plan.pieces.push(Piece { primitive, range: begin..end });
            self.open_work += (end - begin) * work_of_each;
            if self.open_work >= WORK_PER_JOB {
                self.close();
            }
            begin = end;
        }
    }

    fn close(&mut self) {
        let pieces = self.open_piece..self.plan.pieces.len();
        (self.open_piece, self.open_work) = (pieces.end, 0);
        if !pieces.is_empty() {
            let job = if self.has_batches { Job::Instances } else { Job::Meshes };
            self.plan.jobs.push(job(pieces));
            self.plan.job_displays.push(self.open_display);
        }
    }
}
