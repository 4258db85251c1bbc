//! The work for one picture: the scene's drawables in their order, cut into jobs of about equal size.
//!
//! A job turns a chunk of a cloud, or several meshes and lines together, into things that are sorted into the
//! picture's bands. Jobs are independent of each other; drawn in their order they give the picture.
//!
//! A plan borrows from its scene, so it does not outlive the picture; its memory does ([`FramePlanMemory`]).

use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Arc, OnceLock, Weak};

use rcs_scene::{Blending, CellSheet, CullMode, DrawOrder, Drawable, Geometry, Material, Mesh, Texture, Vertex};

use super::band::Mode;
use super::points::Cloud;
use super::screen::ObjectTransform;
use super::solids::{Shape, Solid};
use super::surface::{DepthBias, Paint, Surface};
use super::texture::MipTexture;
use crate::View;

/// Points of a job.
const POINTS_PER_JOB: usize = 8192;

/// Triangles and lines of a job.
const TRIANGLES_PER_JOB: usize = 1024;

/// Mipmaps of the textures that are alive.
#[derive(Debug, Default)]
pub(super) struct Textures {
    by_address: HashMap<usize, (Weak<Texture>, Arc<MipTexture>)>,
}

impl Textures {
    fn get(&mut self, texture: &Arc<Texture>) -> Arc<MipTexture> {
        let address = Arc::as_ptr(texture) as usize;
        let make = || (Arc::downgrade(texture), Arc::new(MipTexture::new(texture)));
        self.by_address.entry(address).or_insert_with(make).1.clone()
    }

    /// Drops those that only this cache still holds.
    pub(super) fn forget_dead(&mut self) {
        self.by_address.retain(|_, (texture, _)| texture.strong_count() > 1);
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

/// One job.
#[derive(Clone, Debug)]
pub(super) enum Job {
    /// Points of the cloud with this index.
    Points(usize, Range<usize>),
    /// Some of the plan's pieces.
    Pieces(Range<usize>),
}

impl Job {
    /// Whether the faces of both may be drawn together: both are of one cloud, or both of triangles.
    pub(super) fn goes_with(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Points(cloud, _), Self::Points(other, _)) => cloud == other,
            (Self::Pieces(_), Self::Pieces(_)) => true,
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
    /// The pieces of solids that the jobs draw.
    pub pieces: Vec<Piece>,
    /// In the order of drawing.
    pub jobs: Vec<Job>,
    cloud_jobs: Vec<Range<usize>>,
    open_triangles: usize,
    open_piece: usize,
    /// For wide lines that turn to the camera.
    reusable_meshes: Vec<Mesh>,
}

/// The memory of a picture's plan, for the next one.
#[derive(Debug, Default)]
pub(super) struct FramePlanMemory {
    order: DrawOrder,
    plan: FramePlan<'static>,
}

/// The memory of a vector for elements of the same type with another lifetime: the library collects in place here.
fn emptied<T, U>(vector: Vec<T>) -> Vec<U> {
    vector.into_iter().filter_map(|_| None).collect()
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

impl<'a> FramePlan<'a> {
    /// Plans a picture.
    pub(super) fn new(view: &View<'a>, textures: &mut Textures, memory: &mut FramePlanMemory) -> Self {
        let mut plan: Self = std::mem::take(&mut memory.plan);
        memory.order.sort(view.scene, view.visible, &view.camera.eye());
        for drawable in memory.order.of(view.scene) {
            plan.add(view, textures, drawable);
        }
        plan.close();
        plan
    }

    /// A plan of nothing in the same memory, and with the same reusable meshes.
    fn emptied(self) -> FramePlan<'static> {
        let Self { clouds, solids, mut pieces, mut jobs, mut cloud_jobs, reusable_meshes, .. } = self;
        pieces.clear();
        jobs.clear();
        cloud_jobs.clear();
        let (clouds, solids) = (emptied(clouds), emptied(solids));
        FramePlan { clouds, solids, pieces, jobs, cloud_jobs, open_triangles: 0, open_piece: 0, reusable_meshes }
    }

    fn add(&mut self, view: &View<'a>, textures: &mut Textures, drawable: &'a Drawable) {
        let camera = view.camera;
        let view_from_object = match drawable.geometry {
            Geometry::Text(_) => camera.view_from_facing(&drawable.fixed_from_object).cast(),
            _ => camera.fixed_from_view().inverse().to_homogeneous() * drawable.fixed_from_object,
        };
        let transform = ObjectTransform::new(camera, &view_from_object, view.scene.light.as_ref());
        let mut surface_of =
            |material: &Material| Surface::of(material, material.texture.as_ref().map(|texture| textures.get(texture)));
        let (surface, shape) = match &drawable.geometry {
            Geometry::Facing(_) => return,
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
                (surface_of(&material), Shape::Mesh(Cow::Owned(mesh), Cow::Owned(material)))
            }
            Geometry::Mesh { mesh, material } => {
                let surface = surface_of(material);
                let is_mirrored = drawable.fixed_from_object.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
                let surface = if is_mirrored { surface.mirrored() } else { surface };
                (surface, Shape::Mesh(Cow::Borrowed(mesh), Cow::Borrowed(material)))
            }
            Geometry::Text(text) => {
                let (mesh, material) = (text.mesh(), text.material());
                (surface_of(material), Shape::Mesh(Cow::Borrowed(mesh), Cow::Borrowed(material)))
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
        }
        self.cloud_jobs.push(first_job..self.jobs.len());
    }

    fn add_solid(&mut self, solid: Solid<'a>) {
        let count = solid.shape.primitive_count();
        let index = self.solids.len();
        self.solids.push(solid);
        let mut begin = 0;
        while begin < count {
            let room = TRIANGLES_PER_JOB.saturating_sub(self.open_triangles).max(1);
            let end = count.min(begin + room);
            self.pieces.push(Piece { solid: index, range: begin..end });
            self.open_triangles += end - begin;
            if self.open_triangles >= TRIANGLES_PER_JOB {
                self.close();
            }
            begin = end;
        }
    }

    fn close(&mut self) {
        if self.open_piece < self.pieces.len() {
            self.jobs.push(Job::Pieces(self.open_piece..self.pieces.len()));
        }
        (self.open_piece, self.open_triangles) = (self.pieces.len(), 0);
    }

    /// Marks the clouds that Ogre would not draw, given the points that each job has selected.
    pub(super) fn cull_clouds<I: Iterator<Item = u32>>(&mut self, selected: impl Fn(usize) -> I) {
        for (cloud, jobs) in self.clouds.iter_mut().zip(&self.cloud_jobs) {
            cloud.is_culled = cloud.lies_outside(jobs.clone().flat_map(&selected));
        }
    }
}
