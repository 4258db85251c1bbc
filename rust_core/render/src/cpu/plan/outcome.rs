//! What jobs make ready, and how it is drawn into a band.

use super::{Job, Plan};
use crate::cpu::geometry::instances::{InstanceScratch, Instances};
use crate::cpu::geometry::meshes::Primitives;
use crate::cpu::geometry::points::{self, BinnedPoints, PointScratch};
use crate::cpu::geometry::vertices::VertexScratch;
use crate::cpu::tile::band::Band;
use crate::cpu::tile::near_to_far::{Load, NearToFar};
use crate::cpu::tile::screen::Screen;

/// The result of a job. Its memory is used again by the job in its place in the next image.
#[derive(Debug)]
pub(in crate::cpu) enum Outcome {
    /// Points of a cloud.
    Points(BinnedPoints),
    /// Triangles and lines of meshes, lines and texts.
    Meshes(Primitives),
    /// Triangles of many small solids.
    Instances(Instances),
}

impl Default for Outcome {
    fn default() -> Self {
        Self::Points(BinnedPoints::default())
    }
}

/// Scratch buffers of a worker that makes things ready and draws them.
#[derive(Debug, Default)]
pub(in crate::cpu) struct Scratch {
    points: PointScratch,
    vertices: VertexScratch,
    instances: InstanceScratch,
    order: NearToFar,
}

/// The image that is drawn.
#[derive(Clone, Copy, Debug)]
pub(in crate::cpu) struct DrawContext<'a> {
    /// All jobs.
    pub plan: &'a Plan<'a>,
    /// Its pixels.
    pub screen: &'a Screen,
}

impl Outcome {
    /// The amount that is to be drawn.
    pub(in crate::cpu) fn load(&self, job: &Job, plan: &Plan<'_>) -> Load {
        match (job, self) {
            (Job::Points(cloud, _), Self::Points(points)) => {
                let in_order = plan.clouds.get(*cloud).is_none_or(|cloud| !cloud.can_be_ranked());
                Load { in_order, ..points.load }
            }
            (_, Self::Meshes(primitives)) => primitives.load(),
            (_, Self::Instances(_) | Self::Points(_)) => Load { in_order: true, ..Load::default() },
        }
    }

    /// Makes a job ready.
    pub(in crate::cpu) fn prepare(&mut self, job: &Job, context: &DrawContext<'_>, scratch: &mut Scratch) {
        let (plan, screen) = (context.plan, context.screen);
        match job {
            Job::Points(index, range) => {
                if !matches!(self, Self::Points(_)) {
                    *self = Self::Points(BinnedPoints::default());
                }
                if let (Self::Points(points), Some(cloud)) = (self, plan.clouds.get(*index)) {
                    cloud.select(screen, range.clone(), points);
                }
            }
            Job::Meshes(pieces) => {
                if !matches!(self, Self::Meshes(_)) {
                    *self = Self::Meshes(Primitives::default());
                }
                let Self::Meshes(primitives) = self else { return };
                primitives.clear(screen);
                for piece in plan.pieces.get(pieces.clone()).unwrap_or(&[]) {
                    if let Some(solid) = plan.solids.get(piece.primitive) {
                        let ids = (piece.primitive as u32, piece.range.clone());
                        primitives.add(solid, ids, screen, &mut scratch.vertices.cache);
                    }
                }
            }
            Job::Instances(pieces) => {
                if !matches!(self, Self::Instances(_)) {
                    *self = Self::Instances(Instances::default());
                }
                let Self::Instances(instances) = self else { return };
                instances.clear(screen);
                let Some(batches) = &plan.batches else { return };
                for piece in plan.pieces.get(pieces.clone()).unwrap_or(&[]) {
                    instances.add((piece.primitive, piece.range.clone()), batches, screen, &mut scratch.instances);
                }
            }
        }
    }

    /// Draws a band's rows of a job in its order.
    pub(in crate::cpu) fn draw(
        &self,
        job: &Job,
        context: &DrawContext<'_>,
        index: usize,
        scratch: &mut Scratch,
        band: &mut Band<'_>,
    ) {
        match (job, self) {
            (Job::Points(cloud, _), Self::Points(points)) => {
                if let Some(cloud) = context.plan.clouds.get(*cloud) {
                    points::draw(cloud, (points.bins.band(index), &[]), context.screen, &mut scratch.points, band);
                }
            }
            (_, Self::Meshes(primitives)) => {
                primitives.draw(&context.plan.solids, index, context.screen, &mut scratch.vertices, band);
            }
            (_, Self::Instances(instances)) => {
                if let Some(batches) = &context.plan.batches {
                    instances.draw(batches, index, context.screen, &mut scratch.instances, band);
                }
            }
            (_, Self::Points(_)) => {}
        }
    }

    /// Draws a band's rows of jobs that go together, by the ranks of their faces.
    pub(in crate::cpu) fn draw_ranked(
        (job, outcomes): (&Job, &[Self]),
        context: &DrawContext<'_>,
        index: usize,
        scratch: &mut Scratch,
        band: &mut Band<'_>,
    ) {
        let Scratch { points, order, .. } = scratch;
        match job {
            Job::Points(cloud, _) => {
                let Some(cloud) = context.plan.clouds.get(*cloud) else { return };
                let indices = outcomes.iter().map(|outcome| match outcome {
                    Self::Points(points) => points.bins.band(index),
                    _ => &[],
                });
                let indices: Vec<&[u32]> = indices.collect();
                points::draw_ranked(cloud, &indices, context.screen, (points, order), band);
            }
            Job::Meshes(_) => {
                let jobs = outcomes.iter().filter_map(|outcome| match outcome {
                    Self::Meshes(primitives) => Some(primitives),
                    _ => None,
                });
                Primitives::draw_ranked(&jobs.collect::<Vec<_>>(), &context.plan.solids, index, order, band);
            }
            Job::Instances(_) => {}
        }
    }
}
