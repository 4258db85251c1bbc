//! The CPU renderer.
//!
//! A picture is made in two steps, each spread over the cores:
//!
//! 1. The scene is cut into jobs (see [`frame_plan`]). A job projects points, or transforms, lights and clips triangles
//!    and lines, drops what is out of view, and sorts the rest into the picture's *bands*, a few dozen rows each.
//! 2. Each band is drawn: whatever the jobs have sorted into it, job after job, so in the scene's order. A band's
//!    colours and depths fit into a core's cache, belong to one thread, and are encoded into the picture when the band
//!    is done. There is no frame buffer of the whole picture, and no two threads write to the same pixel, so that the
//!    picture does not depend on the number of threads.
//!
//! Opaque faces that lie over each other many times are drawn by their *ranks* instead of in their order, so that those
//! which others hide cost next to nothing ([`ranked`], [`hiz`]). The picture is the same.
//!
//! What is drawn is what OpenGL draws with rviz's shaders on Mesa's software rasteriser; [`points`], [`triangles`] and
//! [`lines`] describe how.
//!
//! All memory that grows with the scene is kept for the next picture.

mod band;
mod bins;
mod clip;
mod costs;
mod depths;
mod edges;
mod frame_plan;
mod hiz;
mod instances;
mod lanes;
mod lighting;
mod lines;
mod paint;
mod points;
mod ranked;
mod screen;
mod solids;

#[cfg(test)]
mod tests;
mod texture;
mod triangles;

use std::collections::VecDeque;
use std::ops::Range;
use std::panic::{catch_unwind, AssertUnwindSafe};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use fearless_simd::Level;
use rcs_camera::{see_depth_through, see_through};
use rcs_scene::{DepthPicture, DisplayId, Encoding, Picture, MAX_SIDE_PX};

use self::band::{pack, Band, BandBuffers};
use self::bins::Bins;
use self::costs::WorkerCosts;
use self::depths::Depths;
use self::frame_plan::{FramePlan, FramePlanMemory, Job};
use self::instances::{InstanceScratch, Instances, Shapes};
use self::points::PointScratch;
use self::ranked::{Load, NearToFar};
use self::screen::Screen;
use self::solids::{Primitives, VertexCache};
use self::texture::Textures;
use crate::renderer::panic_text;
use crate::{Finished, RenderError, Renderer, View};

/// Draws on the CPU.
#[derive(Debug, Default)]
pub struct CpuRenderer {
    workers: Vec<Worker>,
    outcomes: Vec<Outcome>,
    textures: Textures,
    shapes: Shapes,
    /// The instruction set to use; `None`: the best that there is.
    simd_level: Option<Level>,
    culling: Culling,
    turns: Vec<Turn>,
    memory: FramePlanMemory,
    /// Drawn and not yet returned, the oldest first.
    finished: VecDeque<Picture>,
    /// Memory for the next picture.
    unused_picture: Picture,
    /// What is drawn of a picture that a lens bends.
    before_lens: Picture,
    depth_before_lens: DepthPicture,
    /// Whose the jobs of the last picture were.
    job_displays: Vec<DisplayId>,
    /// The next picture's first job panics.
    #[cfg(test)]
    panics_next: bool,
}

/// When faces that others hide are looked for. The picture does not depend on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Culling {
    /// Where many large faces lie over each other.
    #[default]
    Heavy,
    /// Everywhere.
    Always,
    /// Nowhere.
    Never,
}

/// What is drawn next in each band.
#[derive(Clone, Debug)]
enum Turn {
    /// A job, in its order.
    Job(usize),
    /// Jobs whose faces are drawn by their ranks.
    Ranked(Range<usize>),
}

/// The memory that a thread keeps.
#[derive(Debug, Default)]
struct Worker {
    band: BandBuffers,
    scratch: PointScratch,
    vertices: VertexCache,
    instances: InstanceScratch,
    order: NearToFar,
    costs: WorkerCosts,
}

/// The result of a job; only the part that belongs to its kind is filled.
#[derive(Debug, Default)]
struct Outcome {
    points: Bins,
    points_load: Load,
    primitives: Primitives,
    instances: Instances,
}

impl CpuRenderer {
    /// A renderer that uses all cores.
    pub fn new() -> Self {
        Self::with_threads(rayon::current_num_threads())
    }

    /// A renderer that uses this many threads (at least one). The picture does not depend on it.
    pub fn with_threads(threads: usize) -> Self {
        let workers = (0..threads.max(1)).map(|_| Worker::default()).collect();
        Self { workers, ..Self::default() }
    }

    /// Chooses when faces that others hide are looked for; for tests and measurements.
    #[must_use]
    pub fn with_culling(self, culling: Culling) -> Self {
        Self { culling, ..self }
    }
}

impl Renderer for CpuRenderer {
    fn describe(&self) -> String {
        match self.workers.len() {
            0 | 1 => "cpu (1 thread)".into(),
            threads => format!("cpu ({threads} threads)"),
        }
    }

    fn costs(&self) -> Vec<(DisplayId, Duration)> {
        costs::by_display(&self.job_displays, self.workers.iter().map(|worker| &worker.costs))
    }

    /// Draws at once: all cores are busy with one picture.
    fn submit(&mut self, view: &View<'_>) -> Result<(), RenderError> {
        self.submit_both(view, None)
    }

    fn submit_with_depth(&mut self, view: &View<'_>, depth: &mut DepthPicture) -> Result<(), RenderError> {
        self.submit_both(view, Some(depth))
    }

    fn finish(&mut self, picture: &mut Picture) -> Result<Finished, RenderError> {
        let Some(drawn) = self.finished.pop_front() else { return Ok(Finished::NoneInFlight) };
        self.unused_picture = std::mem::replace(picture, drawn);
        self.unused_picture.give_back_memory(picture.data.len());
        Ok(Finished::Drawn)
    }

    fn render(&mut self, view: &View<'_>, picture: &mut Picture) -> Result<(), RenderError> {
        self.finished.clear();
        self.draw(view, picture, None)
    }
}

impl CpuRenderer {
    /// Draws how far away is what a picture of the view would show, and drops the picture.
    pub(crate) fn draw_depth(&mut self, view: &View<'_>, depth: &mut DepthPicture) -> Result<(), RenderError> {
        let mut picture = std::mem::take(&mut self.unused_picture);
        let drawn = self.draw(view, &mut picture, Some(depth));
        self.unused_picture = picture;
        drawn
    }

    fn submit_both(&mut self, view: &View<'_>, depth: Option<&mut DepthPicture>) -> Result<(), RenderError> {
        let mut picture = std::mem::take(&mut self.unused_picture);
        let drawn = self.draw(view, &mut picture, depth);
        match drawn {
            Ok(()) => self.finished.push_back(picture),
            Err(_) => self.unused_picture = picture,
        }
        drawn
    }

    /// Draws a picture, and how far away is what it shows. A panic is an error: what the renderer kept for the next
    /// pictures is dropped, and those go on.
    pub(crate) fn draw(
        &mut self,
        view: &View<'_>,
        picture: &mut Picture,
        depth: Option<&mut DepthPicture>,
    ) -> Result<(), RenderError> {
        let drawn = catch_unwind(AssertUnwindSafe(|| self.draw_unguarded(view, picture, depth)));
        drawn.unwrap_or_else(|panic| {
            let (simd_level, culling) = (self.simd_level, self.culling);
            let finished = std::mem::take(&mut self.finished);
            *self = Self { simd_level, culling, finished, ..Self::with_threads(self.workers.len()) };
            Err(RenderError::Panicked { renderer: self.describe(), reason: panic_text(panic.as_ref()).to_owned() })
        })
    }

    fn draw_unguarded(
        &mut self,
        view: &View<'_>,
        picture: &mut Picture,
        depth: Option<&mut DepthPicture>,
    ) -> Result<(), RenderError> {
        let flip = view.camera.flip();
        let Some(map) = view.camera.lens() else {
            let mut depth = depth;
            self.draw_straight(view, picture, depth.as_deref_mut())?;
            flip.picture(picture);
            depth.into_iter().for_each(|depth| flip.depth(depth));
            return Ok(());
        };
        let (mut drawn, mut drawn_depth) =
            (std::mem::take(&mut self.before_lens), std::mem::take(&mut self.depth_before_lens));
        let straight = View { encoding: Encoding::Rgba8, ..*view };
        let result = self.draw_straight(&straight, &mut drawn, depth.is_some().then_some(&mut drawn_depth));
        if result.is_ok() {
            see_through(map, &drawn, view.background, view.encoding, picture);
            flip.picture(picture);
            if let Some(depth) = depth {
                see_depth_through(map, &drawn_depth, depth);
                flip.depth(depth);
            }
        }
        (self.before_lens, self.depth_before_lens) = (drawn, drawn_depth);
        result
    }

    /// Draws what a camera sees without its lens, before it is flipped.
    fn draw_straight(
        &mut self,
        view: &View<'_>,
        picture: &mut Picture,
        depth: Option<&mut DepthPicture>,
    ) -> Result<(), RenderError> {
        let (width_px, height_px) = (view.camera.width_px(), view.camera.height_px());
        if width_px.max(height_px) > MAX_SIDE_PX {
            let renderer = self.describe();
            return Err(RenderError::TooLarge { width_px, height_px, limit_px: MAX_SIDE_PX, renderer });
        }
        picture.reset(width_px, height_px, view.encoding);
        let depths = Depths::new(view.camera, depth);
        if picture.data.is_empty() {
            return Ok(());
        }
        if self.workers.is_empty() {
            self.workers.push(Worker::default());
        }
        let scene = view.scene.seen_from(view.camera);
        let view = &View { scene: &scene, ..*view };
        let mut screen = Screen::new(width_px, height_px, self.workers.len());
        screen.simd_level = self.simd_level.unwrap_or(screen.simd_level);
        self.textures.forget_dead();
        self.shapes.forget_dead();
        let mut plan = FramePlan::new(view, &mut self.textures, &mut self.shapes, &mut self.memory);
        let jobs = plan.jobs.len();
        if self.outcomes.len() < jobs || self.outcomes.len() > 2 * jobs + 16 {
            self.outcomes.resize_with(jobs, Outcome::default);
        }

        self.workers.iter_mut().for_each(|worker| worker.costs.reset(jobs));
        #[cfg(test)]
        let panics = std::mem::take(&mut self.panics_next);
        let jobs = plan.jobs.iter().zip(&mut self.outcomes).enumerate();
        in_parallel(&mut self.workers, jobs, |worker, (index, (job, outcome))| {
            worker.costs.begin();
            #[cfg(test)]
            assert!(!panics, "a test's panic");
            outcome.prepare(job, &plan, &screen, worker);
            worker.costs.add(index..index + 1);
        });

        plan.cull_clouds(|job| self.outcomes.get(job).into_iter().flat_map(|outcome| outcome.points.all()));

        let mut turns = std::mem::take(&mut self.turns);
        self.list_turns(&plan, &screen, &mut turns);

        let [r, g, b] = view.background;
        let background = pack([r, g, b, 255]);
        let step = picture.step();
        let outcomes = &self.outcomes;
        let to_metres = depths.to_metres();
        let depths = depths.into_bands(width_px as usize * screen.band_rows());
        let bands = picture.data.chunks_mut(step * screen.band_rows()).zip(depths).enumerate();
        in_parallel(&mut self.workers, bands, |worker, (index, (rows, depths))| {
            let Worker { band, scratch, instances, order, costs, .. } = worker;
            let mut band = band.begin(&screen, index, background);
            costs.begin();
            for turn in &turns {
                match turn {
                    Turn::Job(at) => {
                        if let (Some(job), Some(outcome)) = (plan.jobs.get(*at), outcomes.get(*at)) {
                            outcome.draw(job, &plan, &screen, index, (&mut *scratch, &mut *instances), &mut band);
                            costs.add(*at..at + 1);
                        }
                    }
                    Turn::Ranked(jobs) => {
                        let (Some(job), Some(outcomes)) = (plan.jobs.get(jobs.start), outcomes.get(jobs.clone()))
                        else {
                            continue;
                        };
                        let scratch = (&mut *scratch, &mut *instances, &mut *order);
                        draw_ranked(job, outcomes, &plan, (&screen, index), scratch, &mut band);
                        costs.add(jobs.clone());
                    }
                }
            }
            for (pixels, row) in band.pixel_rows().zip(rows.chunks_mut(step)) {
                view.encoding.write_row(pixels, row);
            }
            if let Some(depths) = depths {
                to_metres.write(band.depth_rows(), width_px as usize, depths);
            }
        });
        std::mem::swap(&mut self.job_displays, &mut plan.job_displays);
        self.memory.keep(plan);
        self.turns = turns;
        Ok(())
    }

    /// Lists the jobs in their order, those together whose faces are drawn by their ranks.
    fn list_turns(&self, plan: &FramePlan<'_>, screen: &Screen, turns: &mut Vec<Turn>) {
        turns.clear();
        let mut begin = 0;
        while let Some(job) = plan.jobs.get(begin) {
            let (mut end, mut load) = (begin, Load::default());
            for (job_there, outcome) in plan.jobs.iter().zip(&self.outcomes).skip(begin) {
                let both = load.and(outcome.load(job_there, plan));
                if both.in_order || !job.goes_with(job_there) {
                    break;
                }
                (end, load) = (end + 1, both);
            }
            let is_ranked = match self.culling {
                Culling::Heavy => load.is_heavy(screen),
                Culling::Always => end > begin,
                Culling::Never => false,
            };
            if is_ranked {
                turns.push(Turn::Ranked(begin..end));
            } else {
                turns.extend((begin..end.max(begin + 1)).map(Turn::Job));
            }
            begin = end.max(begin + 1);
        }
    }
}

/// Draws a band's rows of jobs of one kind whose faces are drawn by their ranks.
fn draw_ranked(
    job: &Job,
    outcomes: &[Outcome],
    plan: &FramePlan<'_>,
    (screen, index): (&Screen, usize),
    (scratch, instances, order): (&mut PointScratch, &mut InstanceScratch, &mut NearToFar),
    band: &mut Band<'_>,
) {
    match job {
        Job::Points(cloud, _) => {
            if let Some(cloud) = plan.clouds.get(*cloud) {
                let indices: Vec<&[u32]> = outcomes.iter().map(|outcome| outcome.points.band(index)).collect();
                points::draw_ranked(cloud, &indices, screen, (scratch, order), band);
            }
        }
        Job::Pieces(_) => {
            let jobs: Vec<&Primitives> = outcomes.iter().map(|outcome| &outcome.primitives).collect();
            Primitives::draw_ranked(&jobs, &plan.solids, index, order, band);
        }
        Job::Batches(_) => {
            if let Some(view) = &plan.batch_view {
                let jobs: Vec<&Instances> = outcomes.iter().map(|outcome| &outcome.instances).collect();
                Instances::draw_ranked(&jobs, (&plan.batches, view), (screen, index), (instances, order), band);
            }
        }
    }
}

/// Hands the items to the workers, each to the first that is free.
fn in_parallel<W: Send, T: Send>(
    workers: &mut [W],
    items: impl Iterator<Item = T> + Send,
    work: impl Fn(&mut W, T) + Sync,
) {
    let items = Mutex::new(items);
    let next = || items.lock().unwrap_or_else(PoisonError::into_inner).next();
    let run = |worker: &mut W| {
        while let Some(item) = next() {
            work(worker, item);
        }
    };
    match workers {
        [worker] => run(worker),
        workers => rayon::scope(|scope| {
            for worker in workers {
                scope.spawn(|_| run(worker));
            }
        }),
    }
}

impl Outcome {
    /// How much there is to draw.
    fn load(&self, job: &Job, plan: &FramePlan<'_>) -> Load {
        match job {
            Job::Points(cloud, _) => {
                let in_order = plan.clouds.get(*cloud).is_none_or(|cloud| !cloud.can_be_ranked());
                Load { in_order, ..self.points_load }
            }
            Job::Pieces(_) => self.primitives.load(),
            Job::Batches(_) => self.instances.load(),
        }
    }

    fn prepare(&mut self, job: &Job, plan: &FramePlan<'_>, screen: &Screen, worker: &mut Worker) {
        match job {
            Job::Points(index, range) => {
                let Some(cloud) = plan.clouds.get(*index) else { return };
                self.points.reset(screen);
                self.points_load = cloud.select(screen, range.clone(), &mut self.points);
            }
            Job::Pieces(pieces) => {
                self.primitives.clear(screen);
                for piece in plan.pieces.get(pieces.clone()).unwrap_or(&[]) {
                    if let Some(solid) = plan.solids.get(piece.solid) {
                        let range = piece.range.clone();
                        self.primitives.add(solid, piece.solid as u32, range, screen, &mut worker.vertices);
                    }
                }
            }
            Job::Batches(pieces) => {
                self.instances.clear(screen);
                let Some(view) = &plan.batch_view else { return };
                for piece in plan.batch_pieces.get(pieces.clone()).unwrap_or(&[]) {
                    self.instances.add(piece, &plan.batches, view, screen, &mut worker.instances);
                }
            }
        }
    }

    fn draw(
        &self,
        job: &Job,
        plan: &FramePlan<'_>,
        screen: &Screen,
        index: usize,
        (scratch, instances): (&mut PointScratch, &mut InstanceScratch),
        band: &mut Band<'_>,
    ) {
        match job {
            Job::Points(cloud, _) => {
                if let Some(cloud) = plan.clouds.get(*cloud) {
                    points::draw(cloud, self.points.band(index), screen, scratch, band);
                }
            }
            Job::Pieces(_) => self.primitives.draw(&plan.solids, index, band),
            Job::Batches(_) => {
                if let Some(view) = &plan.batch_view {
                    self.instances.draw(&plan.batches, view, screen, index, instances, band);
                }
            }
        }
    }
}
