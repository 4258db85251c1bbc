//! The work for one image: what is to be drawn, in which order, by whom.
//!
//! The scene's drawables, in their order, are cut into [jobs](Job) of about equal size ([`Builder`]). A job turns a
//! chunk of a cloud, several meshes, lines and texts, or many small solids together into primitives that are sorted
//! into the image's bands: its [`Outcome`]. Jobs are independent of each other; the outcomes drawn in their order
//! give the image.
//!
//! A plan borrows from its scene, so it does not outlive the image; its memory does ([`PlanMemory`]).

mod builder;
mod outcome;

use std::borrow::Cow;
use std::ops::Range;

use rcs_scene::{DisplayId, DisplayMask, DrawOrder, Mesh};

use self::builder::Builder;
pub(in crate::cpu) use self::builder::Caches;
pub(in crate::cpu) use self::outcome::{DrawContext, Outcome, Scratch};
use super::geometry::instances::Batches;
use super::geometry::meshes::{Shape, Solid};
use super::geometry::points::Cloud;
use crate::View;

/// One job.
#[derive(Clone, Debug)]
pub(in crate::cpu) enum Job {
    /// Points of the cloud with this index.
    Points(usize, Range<usize>),
    /// Some of the plan's pieces, which are of solids.
    Meshes(Range<usize>),
    /// Some of the plan's pieces, which are of batches.
    Instances(Range<usize>),
}

impl Job {
    /// True if the faces of both may be drawn together: both are of one cloud, or both of triangles.
    pub(in crate::cpu) fn goes_with(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Points(cloud, _), Self::Points(other, _)) => cloud == other,
            (Self::Meshes(_), Self::Meshes(_)) => true,
            _ => false,
        }
    }
}

/// A part of a solid or of a batch.
#[derive(Clone, Debug)]
struct Piece {
    /// Index of the solid or batch.
    primitive: usize,
    /// Its primitives, or its small solids.
    range: Range<usize>,
}

/// All jobs of an image.
#[derive(Debug, Default)]
pub(in crate::cpu) struct Plan<'a> {
    /// In the order of drawing.
    pub jobs: Vec<Job>,
    /// The display of each job; where several share one, the first one's.
    pub job_displays: Vec<DisplayId>,
    /// The displays whose objects' depths are wanted. Either all of a job's displays are among them, or none is.
    objects_of: Option<&'a DisplayMask>,
    clouds: Vec<Cloud<'a>>,
    /// Meshes, ribbons, lines and texts.
    solids: Vec<Solid<'a>>,
    /// Many small solids together.
    batches: Option<Batches<'a>>,
    /// The parts of both that jobs draw.
    pieces: Vec<Piece>,
}

/// The memory of an image's plan, for the next one.
#[derive(Debug, Default)]
pub(in crate::cpu) struct PlanMemory {
    order: DrawOrder,
    plan: Plan<'static>,
    /// For wide lines that turn to the camera.
    ribbon_meshes: Vec<Mesh>,
}

impl PlanMemory {
    /// Takes the memory of a plan that is not needed any more.
    pub(in crate::cpu) fn keep(&mut self, mut plan: Plan<'_>) {
        // Those that this image did not use are dropped.
        self.ribbon_meshes.clear();
        self.ribbon_meshes.extend(plan.solids.iter_mut().filter_map(|solid| match &mut solid.shape {
            Shape::Mesh(Cow::Owned(mesh), _) => Some(std::mem::take(mesh)),
            _ => None,
        }));
        // The next image's are taken from the end.
        self.ribbon_meshes.reverse();
        self.plan = Plan {
            jobs: emptied(plan.jobs),
            job_displays: emptied(plan.job_displays),
            objects_of: None,
            clouds: emptied(plan.clouds),
            solids: emptied(plan.solids),
            pieces: emptied(plan.pieces),
            batches: None,
        };
    }
}

/// The memory of a vector for elements of the same type with another lifetime: the library collects in place here. The
/// memory of a much larger image is given back.
fn emptied<T, U>(vector: Vec<T>) -> Vec<U> {
    const SPARE: usize = 1024;
    let (used, room) = (vector.len(), vector.capacity());
    let mut vector: Vec<U> = vector.into_iter().filter_map(|_| None).collect();
    if room > 4 * used + SPARE {
        vector.shrink_to(used);
    }
    vector
}

impl<'a> Plan<'a> {
    /// Plans an image, with the depths of these displays' objects if they are wanted.
    pub(in crate::cpu) fn new(
        view: &View<'a>,
        objects_of: Option<&'a DisplayMask>,
        caches: &mut Caches,
        memory: &mut PlanMemory,
    ) -> Self {
        let mut order = std::mem::take(&mut memory.order);
        order.sort(view.scene, view.visible, &view.camera.eye());
        let mut builder = Builder::new(view, objects_of, caches, memory);
        order.of(view.scene).for_each(|ordered| builder.add(&ordered));
        let plan = builder.finish();
        memory.order = order;
        plan
    }

    /// True if the depths of a job's objects are wanted.
    pub(in crate::cpu) fn is_listed(&self, job: usize) -> bool {
        let display = self.job_displays.get(job);
        display.zip(self.objects_of).is_some_and(|(display, objects_of)| objects_of.shows(*display))
    }
}
