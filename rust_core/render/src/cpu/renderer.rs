//! The renderer: from a view to an image, in two steps on all threads.

use std::collections::VecDeque;
use std::ops::Range;
use std::panic::{catch_unwind, AssertUnwindSafe};
use std::time::Duration;

use fearless_simd::Level;
use rcs_scene::{DepthImage, DisplayId, Encoding, Image, MAX_SIDE_PX};

use super::costs::{self, WorkerCosts};
use super::plan::{Caches, DrawContext, Outcome, Plan, PlanMemory, Scratch};
use super::threads::in_parallel;
use super::tile::band::{Band, BandBuffers};
use super::tile::color::pack;
use super::tile::near_to_far::Load;
use super::tile::screen::Screen;
use crate::depths::{Drawn, ToMetres};
use crate::renderer::panic_text;
use crate::{DepthRequest, Depths, Finished, RenderError, Renderer, View};

/// Time to wake up a thread, and to draw a job; roughly.
const WAKE_UP: Duration = Duration::from_micros(50);
const JOB: Duration = Duration::from_micros(100);

/// Draws on the CPU.
#[derive(Debug, Default)]
pub struct CpuRenderer {
    workers: Vec<Worker>,
    /// Number of workers that draw the image; the others sleep.
    pub(super) active: usize,
    /// All of them draw each image.
    uses_all: bool,
    /// By job; some more may be left of other images.
    outcomes: Vec<Outcome>,
    caches: Caches,
    /// The instruction set to use; `None`: the best that there is.
    simd_level: Option<Level>,
    culling: Culling,
    runs: Vec<Run>,
    memory: PlanMemory,
    images: Images,
    /// The displays of the last image's jobs.
    job_displays: Vec<DisplayId>,
    /// The next image's first job panics.
    #[cfg(test)]
    pub(super) panics_next: bool,
}

/// Images of a renderer.
#[derive(Debug, Default)]
struct Images {
    /// Drawn and not yet returned, the oldest first.
    finished: VecDeque<Drawn>,
    /// Memory for the next one.
    unused: Drawn,
    /// Drawn before a lens bends it.
    before_lens: Drawn,
}

/// When faces that others hide are looked for. The image does not depend on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Culling {
    /// In images in which many large faces lie over each other.
    #[default]
    Heavy,
    /// Everywhere.
    Always,
    /// Nowhere.
    Never,
}

/// Jobs that are drawn one after the other in each band.
#[derive(Clone, Debug)]
struct Run {
    jobs: Range<usize>,
    /// They are drawn by the ranks of their faces, not in their order.
    is_ranked: bool,
}

/// The memory that a thread keeps.
#[derive(Debug, Default)]
struct Worker {
    band: BandBuffers,
    scratch: Scratch,
    costs: WorkerCosts,
}

impl CpuRenderer {
    /// A renderer that uses as many cores as pay for an image.
    pub fn new() -> Self {
        Self::with_up_to(rayon::current_num_threads())
    }

    /// A renderer that uses at most this many threads.
    pub(super) fn with_up_to(threads: usize) -> Self {
        Self { uses_all: false, ..Self::with_threads(threads) }
    }

    /// A renderer that uses this many threads (at least one). The image does not depend on it.
    pub fn with_threads(threads: usize) -> Self {
        let workers = (0..threads.max(1)).map(|_| Worker::default()).collect();
        Self { workers, uses_all: true, ..Self::default() }
    }

    /// Chooses when faces that others hide are looked for; for tests and measurements.
    #[must_use]
    pub fn with_culling(self, culling: Culling) -> Self {
        Self { culling, ..self }
    }

    /// Chooses the instruction set.
    #[cfg(test)]
    pub(super) fn with_simd_level(self, level: Level) -> Self {
        Self { simd_level: Some(level), ..self }
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
        costs::by_display(&self.job_displays, self.workers[..self.active].iter().map(|worker| &worker.costs))
    }

    /// Draws at once: all cores are busy with one image.
    fn submit_with_depths(&mut self, view: &View<'_>, request: &DepthRequest<'_>) -> Result<(), RenderError> {
        let mut drawn = std::mem::take(&mut self.images.unused);
        let result = self.draw(view, request, &mut drawn);
        match result {
            Ok(()) => self.images.finished.push_back(drawn),
            Err(_) => self.images.unused = drawn,
        }
        result
    }

    fn finish_with_depths(&mut self, image: &mut Image, depths: &mut Depths) -> Result<Finished, RenderError> {
        let Some(mut drawn) = self.images.finished.pop_front() else { return Ok(Finished::NoneInFlight) };
        drawn.swap(image, depths);
        self.images.unused = drawn;
        Ok(Finished::Drawn)
    }

    fn render(&mut self, view: &View<'_>, image: &mut Image) -> Result<(), RenderError> {
        self.images.finished.clear();
        let mut drawn = Drawn { image: std::mem::take(image), ..Drawn::default() };
        let result = self.draw(view, &DepthRequest::default(), &mut drawn);
        *image = drawn.image;
        result
    }
}

impl CpuRenderer {
    /// Draws an image with the depths that are wanted. A panic is an error: what the renderer kept for the next
    /// images is dropped, and those go on.
    fn draw(&mut self, view: &View<'_>, request: &DepthRequest<'_>, drawn: &mut Drawn) -> Result<(), RenderError> {
        let result = catch_unwind(AssertUnwindSafe(|| self.draw_unguarded(view, request, drawn)));
        result.unwrap_or_else(|panic| {
            let (simd_level, culling, uses_all) = (self.simd_level, self.culling, self.uses_all);
            let finished = std::mem::take(&mut self.images.finished);
            *self = Self { simd_level, culling, uses_all, ..Self::with_threads(self.workers.len()) };
            self.images.finished = finished;
            Err(RenderError::Panicked { renderer: self.describe(), reason: panic_text(panic.as_ref()).to_owned() })
        })
    }

    fn draw_unguarded(
        &mut self,
        view: &View<'_>,
        request: &DepthRequest<'_>,
        drawn: &mut Drawn,
    ) -> Result<(), RenderError> {
        if let Some(map) = view.camera.lens() {
            let mut straight = std::mem::take(&mut self.images.before_lens);
            let result = self.draw_straight(&View { encoding: Encoding::Rgba8, ..*view }, request, &mut straight);
            if result.is_ok() {
                drawn.see_through(map, &straight, view.background, view.encoding);
            }
            self.images.before_lens = straight;
            result?;
        } else {
            self.draw_straight(view, request, drawn)?;
        }
        drawn.flip(view.camera.flip());
        Ok(())
    }

    /// Draws the view of a camera without its lens, before it is flipped.
    fn draw_straight(
        &mut self,
        view: &View<'_>,
        request: &DepthRequest<'_>,
        drawn: &mut Drawn,
    ) -> Result<(), RenderError> {
        let (width_px, height_px) = (view.camera.width_px(), view.camera.height_px());
        if width_px.max(height_px) > MAX_SIDE_PX {
            let renderer = self.describe();
            return Err(RenderError::TooLarge { width_px, height_px, limit_px: MAX_SIDE_PX, renderer });
        }
        drawn.image.reset(width_px, height_px, view.encoding);
        drawn.depths.reset(request.wanted(), [width_px, height_px]);
        if drawn.image.data.is_empty() {
            return Ok(());
        }
        if self.workers.is_empty() {
            self.workers.push(Worker::default());
        }
        let scene = view.scene.seen_from(view.camera);
        let view = &View { scene: &scene, ..*view };
        self.caches.forget_dead();
        let mut plan = Plan::new(view, request.objects_of, &mut self.caches, &mut self.memory);
        self.active = self.paying_workers(plan.jobs.len());
        let mut screen = Screen::new(width_px, height_px, self.active);
        screen.simd_level = self.simd_level.unwrap_or(screen.simd_level);
        self.prepare(&plan, &screen);
        self.list_runs(&plan, &screen);
        self.draw_bands(&DrawContext { plan: &plan, screen: &screen }, view, drawn);
        std::mem::swap(&mut self.job_displays, &mut plan.job_displays);
        self.memory.keep(plan);
        Ok(())
    }

    /// The number of workers that draw an image of this number of jobs soonest, if it takes as long as they usually do
    /// or as the last one: `work / workers + WAKE_UP · workers` is least at the root of their quotient.
    pub(super) fn paying_workers(&self, jobs: usize) -> usize {
        let last: Duration = self.workers.iter().map(|worker| worker.costs.sum()).sum();
        let work_s = last.as_secs_f64().max(jobs as f64 * JOB.as_secs_f64());
        let paying = (work_s / WAKE_UP.as_secs_f64()).sqrt() as usize;
        let all = self.workers.len();
        if self.uses_all {
            all
        } else {
            paying.clamp(1, all)
        }
    }

    /// The first step: all jobs.
    fn prepare(&mut self, plan: &Plan<'_>, screen: &Screen) {
        let jobs = plan.jobs.len();
        if self.outcomes.len() < jobs || self.outcomes.len() > 2 * jobs + 16 {
            self.outcomes.resize_with(jobs, Outcome::default);
            self.outcomes.shrink_to(2 * jobs);
        }
        self.workers.iter_mut().for_each(|worker| worker.costs.reset(jobs));
        #[cfg(test)]
        let panics = std::mem::take(&mut self.panics_next);
        let context = DrawContext { plan, screen };
        let jobs = plan.jobs.iter().zip(&mut self.outcomes).enumerate();
        in_parallel(&mut self.workers[..self.active], jobs, |worker, (index, (job, outcome))| {
            worker.costs.begin();
            #[cfg(test)]
            assert!(!panics, "a test's panic");
            outcome.prepare(job, &context, &mut worker.scratch);
            worker.costs.add(index..index + 1);
        });
    }

    /// Lists the jobs in their order, those together whose faces are drawn by their ranks.
    fn list_runs(&mut self, plan: &Plan<'_>, screen: &Screen) {
        self.runs.clear();
        let mut begin = 0;
        while let Some(job) = plan.jobs.get(begin) {
            let (mut end, mut load) = (begin, Load::default());
            for (job_there, outcome) in plan.jobs.iter().zip(&self.outcomes).skip(begin) {
                let both = load.and(outcome.load(job_there, plan));
                let goes_with = job.goes_with(job_there) && plan.is_listed(begin) == plan.is_listed(end);
                if both.in_order || !goes_with {
                    break;
                }
                (end, load) = (end + 1, both);
            }
            let is_ranked = match self.culling {
                Culling::Heavy => load.is_heavy(screen),
                Culling::Always => end > begin,
                Culling::Never => false,
            };
            let jobs = begin..end.max(begin + 1);
            begin = jobs.end;
            self.runs.push(Run { jobs, is_ranked });
        }
    }

    /// The second step: all bands.
    fn draw_bands(&mut self, context: &DrawContext<'_>, view: &View<'_>, drawn: &mut Drawn) {
        let Drawn { image, depths: Depths { opaque, objects } } = drawn;
        let [r, g, b] = view.background;
        let background = pack([r, g, b, 255]);
        let (step, width, rows) = (image.step(), image.width_px as usize, context.screen.band_rows());
        let (outcomes, runs, has_objects) = (self.outcomes.as_slice(), &self.runs, !objects.depths_m.is_empty());
        let to_metres = ToMetres::new(view.camera);
        let depths = depth_bands(opaque, width * rows).zip(depth_bands(objects, width * rows));
        let bands = image.data.chunks_mut(step * rows).zip(depths).enumerate();
        in_parallel(&mut self.workers[..self.active], bands, |worker, (index, (rows, (opaque, objects)))| {
            let Worker { band, scratch, costs } = worker;
            let mut band = band.begin(context.screen, index, background, has_objects);
            costs.begin();
            for run in runs {
                run.draw(context, (outcomes, index), scratch, costs, &mut band);
            }
            for (pixels, row) in band.pixel_rows().zip(rows.chunks_mut(step)) {
                view.encoding.write_row(pixels, row);
            }
            write_metres(to_metres, band.depth_rows(), opaque);
            write_metres(to_metres, band.object_rows(), objects);
        });
    }
}

/// The depths band by band, of this number of pixels each; without end.
fn depth_bands(depth: &mut DepthImage, pixels: usize) -> impl Iterator<Item = &mut [f32]> {
    depth.depths_m.chunks_mut(pixels.max(1)).chain(std::iter::repeat_with(<&mut [f32]>::default))
}

/// Writes rows of a depth buffer as metres, if these are wanted.
fn write_metres<'d>(to_metres: ToMetres, rows: impl Iterator<Item = &'d [f32]>, mut metres: &mut [f32]) {
    for row in rows {
        let Some((to, below)) = std::mem::take(&mut metres).split_at_mut_checked(row.len()) else { return };
        to.iter_mut().zip(row).for_each(|(metres, depth)| *metres = to_metres.metres(*depth));
        metres = below;
    }
}

impl Run {
    /// Draws the rows of the band of an index.
    fn draw(
        &self,
        context: &DrawContext<'_>,
        (outcomes, index): (&[Outcome], usize),
        scratch: &mut Scratch,
        costs: &mut WorkerCosts,
        band: &mut Band<'_>,
    ) {
        let (jobs, listed) = (&context.plan.jobs, self.jobs.clone());
        let Some((all, outcomes)) = jobs.get(listed.clone()).zip(outcomes.get(listed.clone())) else { return };
        if let (true, Some(first)) = (self.is_ranked, all.first()) {
            band.set_listed(context.plan.is_listed(listed.start));
            Outcome::draw_ranked((first, outcomes), context, index, scratch, band);
            return costs.add(listed);
        }
        for (at, (job, outcome)) in listed.zip(all.iter().zip(outcomes)) {
            band.set_listed(context.plan.is_listed(at));
            outcome.draw(job, context, index, scratch, band);
            costs.add(at..at + 1);
        }
    }
}
