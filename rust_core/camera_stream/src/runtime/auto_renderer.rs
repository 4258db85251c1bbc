//! The renderer that `auto` chooses: the CPU until a hardware GPU is open, then whichever draws an image sooner.

use std::collections::VecDeque;
use std::sync::mpsc::{sync_channel, Receiver, TryRecvError};
use std::time::{Duration, Instant};

use rcs_render::{CpuRenderer, DepthRequest, Depths, Finished, GpuRenderer, RenderError, Renderer, View};
use rcs_scene::{DisplayId, DisplayMask, Picture, Scene};

/// Images that each renderer is measured by.
const MEASURED: u32 = 8;
/// Images before these: the first ones fill the renderer's caches.
const WARM_UP: u32 = 2;
/// Least time between two measurements.
const INTERVAL: Duration = Duration::from_secs(60);
/// Longest time between two measurements: a renderer that stays behind is measured more and more seldom.
const LONGEST_INTERVAL: Duration = Duration::from_secs(3600);
/// The other renderer replaces the present one where it takes less than this share of its time.
const REPLACING_SHARE: f64 = 0.8;
/// A measurement ends early where the other renderer takes this multiple of the present one's time.
const HOPELESS: f64 = 2.0;
/// Images before a measurement may end early: one alone may have waited for a processor.
const MEASURED_AT_LEAST: u32 = 2;

/// Longest wait for a GPU that is being opened when the node ends: drivers may crash in a process that ends.
const CLOSING: Duration = Duration::from_secs(5);

type Opened = Result<Box<dyn Renderer>, RenderError>;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Which {
    Cpu,
    Gpu,
}

/// Draws with the CPU or a GPU.
pub(super) struct AutoRenderer {
    cpu: Box<dyn Renderer>,
    gpu: Option<Box<dyn Renderer>>,
    /// Present until the GPU is open, or known to be missing.
    opening: Option<Receiver<Opened>>,
    comparison: Comparison,
    /// `true` from the first decision on, which is logged also where it changes nothing.
    has_decided: bool,
    /// Which renderer draws each image in flight, the oldest first.
    in_flight: VecDeque<Which>,
    /// Images since none was in flight, and when the first of them was submitted.
    round: (u32, Instant),
}

impl AutoRenderer {
    /// Draws with the CPU, and opens a hardware GPU on a thread of its own.
    pub(super) fn start() -> Self {
        Self::new(Box::new(CpuRenderer::new()), || Ok(Box::new(GpuRenderer::new(true)?)))
    }

    fn new(cpu: Box<dyn Renderer>, open: impl FnOnce() -> Opened + Send + 'static) -> Self {
        let (sender, opening) = sync_channel(1);
        let thread = std::thread::Builder::new().name("gpu-open".to_owned()).spawn(move || {
            // Nobody receives it where the node has ended.
            let _ = sender.send(open());
        });
        if let Err(error) = thread {
            log::warn!("drawing on the CPU: cannot start the thread that opens a GPU: {error}");
        }
        let round = (0, Instant::now());
        let (comparison, in_flight) = (Comparison::new(round.1), VecDeque::new());
        Self { cpu, gpu: None, opening: Some(opening), comparison, has_decided: false, in_flight, round }
    }

    /// Takes the GPU once it is open.
    fn poll_opening(&mut self, now: Instant) {
        let opened = match self.opening.as_ref().map(Receiver::try_recv) {
            None | Some(Err(TryRecvError::Empty)) => return,
            Some(Ok(Ok(gpu))) => Some(gpu),
            Some(Ok(Err(error))) => {
                log::debug!("drawing on the CPU: {error}");
                None
            }
            Some(Err(TryRecvError::Disconnected)) => None,
        };
        self.opening = None;
        self.gpu = opened;
        self.comparison = Comparison::new(now);
    }

    fn renderer(&mut self, which: Which) -> &mut dyn Renderer {
        match (which, &mut self.gpu) {
            (Which::Gpu, Some(gpu)) => gpu.as_mut(),
            _ => self.cpu.as_mut(),
        }
    }

    /// The renderer of the next image.
    fn next(&self) -> Which {
        match self.gpu {
            Some(_) => self.comparison.drawing(),
            None => Which::Cpu,
        }
    }

    fn describe_one(&self, which: Which) -> String {
        match (which, &self.gpu) {
            (Which::Gpu, Some(gpu)) => gpu.describe(),
            _ => self.cpu.describe(),
        }
    }

    /// Measures the images that were in flight together.
    fn end_round(&mut self, which: Which, now: Instant) {
        let (images, begun) = self.round;
        if self.gpu.is_none() {
            return;
        }
        if let Some(decision) = self.comparison.record(which, images, now - begun, now) {
            let text = decision.describe(&[Which::Cpu, Which::Gpu].map(|which| self.describe_one(which)));
            if decision.has_changed || !self.has_decided {
                log::info!("{text}");
            } else {
                log::debug!("{text}");
            }
            self.has_decided = true;
        }
    }

    /// Forgets what was in flight where a GPU fails: it is lost.
    fn checked<T>(&mut self, result: Result<T, RenderError>) -> Result<T, RenderError> {
        if let Err(RenderError::Gpu { .. }) = result {
            self.in_flight.clear();
        }
        result
    }
}

impl Drop for AutoRenderer {
    fn drop(&mut self) {
        if let Some(opening) = self.opening.take() {
            // Where it fails or takes too long there is nothing to close.
            let _ = opening.recv_timeout(CLOSING);
        }
    }
}

impl Renderer for AutoRenderer {
    fn describe(&self) -> String {
        self.describe_one(self.next())
    }

    fn costs(&self) -> Vec<(DisplayId, Duration)> {
        match (self.next(), &self.gpu) {
            (Which::Gpu, Some(gpu)) => gpu.costs(),
            _ => self.cpu.costs(),
        }
    }

    fn pictures_at_once(&self) -> usize {
        match (self.next(), &self.gpu) {
            (Which::Gpu, Some(gpu)) => gpu.pictures_at_once(),
            _ => self.cpu.pictures_at_once(),
        }
    }

    fn takes_packed_points(&self) -> bool {
        match (self.next(), &self.gpu) {
            (Which::Gpu, Some(gpu)) => gpu.takes_packed_points(),
            _ => self.cpu.takes_packed_points(),
        }
    }

    /// Not while the renderers are measured: what is prepared meanwhile would count.
    fn can_upload(&self) -> bool {
        let is_measured = self.comparison.measurement.is_some();
        !is_measured && self.next() == Which::Gpu && self.gpu.as_ref().is_some_and(|gpu| gpu.can_upload())
    }

    fn upload(&mut self, scene: &Scene, visible: &DisplayMask) {
        self.renderer(Which::Gpu).upload(scene, visible);
    }

    fn submit_with_depths(&mut self, view: &View<'_>, request: &DepthRequest<'_>) -> Result<(), RenderError> {
        if self.in_flight.is_empty() {
            let now = Instant::now();
            self.poll_opening(now);
            self.comparison.begin_if_due(now);
            self.round = (0, now);
        }
        let which = self.next();
        let submitted = self.renderer(which).submit_with_depths(view, request);
        self.checked(submitted)?;
        self.in_flight.push_back(which);
        self.round.0 += 1;
        Ok(())
    }

    fn finish_with_depths(&mut self, picture: &mut Picture, depths: &mut Depths) -> Result<Finished, RenderError> {
        let Some(which) = self.in_flight.pop_front() else { return Ok(Finished::NoneInFlight) };
        let finished = self.renderer(which).finish_with_depths(picture, depths);
        let finished = self.checked(finished)?;
        if self.in_flight.is_empty() {
            self.end_round(which, Instant::now());
        }
        Ok(finished)
    }

    fn forget_sizes(&mut self) {
        self.cpu.forget_sizes();
        self.gpu.iter_mut().for_each(|gpu| gpu.forget_sizes());
    }
}

/// Which of two renderers draws, by the time that an image takes.
#[derive(Debug)]
struct Comparison {
    present: Which,
    /// When the next measurement begins, and the time between the last two.
    due: Instant,
    interval: Duration,
    measurement: Option<Measurement>,
}

/// Images drawn by the present renderer, then by the other one.
#[derive(Debug, Default)]
struct Measurement {
    /// The image that the present renderer takes, once that is known.
    present: Option<Duration>,
    /// Of the renderer at hand: images, and the time that those after the warm-up took.
    images: u32,
    took: Duration,
}

/// The outcome of a measurement.
#[derive(Debug, PartialEq)]
struct Decision {
    chosen: Which,
    has_changed: bool,
    /// Milliseconds an image, of the CPU and of the GPU.
    image_ms: [f64; 2],
}

impl Decision {
    /// Which renderer draws and why; the names are the CPU's and the GPU's.
    fn describe(&self, names: &[String; 2]) -> String {
        let (chosen, [cpu, gpu]) = (&names[self.chosen as usize], names);
        let since = if self.has_changed { "from now on" } else { "as before" };
        let [cpu_ms, gpu_ms] = self.image_ms;
        format!("drawing with {chosen} {since}: {cpu_ms:.1} ms an image with {cpu}, {gpu_ms:.1} ms with {gpu}")
    }
}

impl Which {
    fn other(self) -> Self {
        match self {
            Self::Cpu => Self::Gpu,
            Self::Gpu => Self::Cpu,
        }
    }
}

impl Comparison {
    /// The CPU draws; both are measured from now on.
    fn new(now: Instant) -> Self {
        Self { present: Which::Cpu, due: now, interval: INTERVAL, measurement: None }
    }

    fn begin_if_due(&mut self, now: Instant) {
        if now >= self.due && self.measurement.is_none() {
            self.measurement = Some(Measurement::default());
        }
    }

    /// The renderer of the next image.
    fn drawing(&self) -> Which {
        match &self.measurement {
            Some(Measurement { present: Some(_), .. }) => self.present.other(),
            _ => self.present,
        }
    }

    /// Records images that a renderer has drawn together.
    fn record(&mut self, which: Which, images: u32, took: Duration, now: Instant) -> Option<Decision> {
        let is_drawing = which == self.drawing();
        let measurement = self.measurement.as_mut().filter(|_| is_drawing)?;
        if measurement.images < WARM_UP {
            measurement.images = (measurement.images + images).min(WARM_UP);
            return None;
        }
        measurement.images += images;
        measurement.took += took;
        let measured = measurement.images - WARM_UP;
        let image = measurement.took / measured.max(1);
        let Some(present) = measurement.present else {
            if measured >= MEASURED {
                *measurement = Measurement { present: Some(image), ..Measurement::default() };
            }
            return None;
        };
        let is_hopeless = measured >= MEASURED_AT_LEAST && image > present.mul_f64(HOPELESS);
        if measured < MEASURED && !is_hopeless {
            return None;
        }
        let has_changed = image < present.mul_f64(REPLACING_SHARE);
        let ms = |duration: Duration| duration.as_secs_f64() * 1e3;
        let image_ms = match self.present {
            Which::Cpu => [ms(present), ms(image)],
            Which::Gpu => [ms(image), ms(present)],
        };
        self.interval = if has_changed { INTERVAL } else { self.interval };
        (self.measurement, self.due) = (None, now + self.interval);
        if has_changed {
            self.present = self.present.other();
        } else {
            self.interval = (self.interval * 2).min(LONGEST_INTERVAL);
        }
        Some(Decision { chosen: self.present, has_changed, image_ms })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{channel, Sender};

    use nalgebra::Isometry3;
    use rcs_scene::{Camera, DisplayMask, Encoding, Intrinsics, Scene};

    use super::*;

    const MS: Duration = Duration::from_millis(1);

    /// Decision between a CPU and a GPU that take these milliseconds an image, and the number of images drawn by each.
    fn decide(comparison: &mut Comparison, [cpu, gpu]: [u32; 2], now: Instant) -> (Option<Decision>, [u32; 2]) {
        let mut drawn = [0; 2];
        comparison.begin_if_due(now);
        for _ in 0..100 {
            let which = comparison.drawing();
            drawn[which as usize] += 1;
            let took = MS * if which == Which::Cpu { cpu } else { gpu };
            if let Some(decision) = comparison.record(which, 1, took, now) {
                return (Some(decision), drawn);
            }
        }
        (None, drawn)
    }

    #[test]
    fn the_faster_one_draws_and_is_changed_at_most_once_a_minute() {
        let start = Instant::now();
        let mut comparison = Comparison::new(start);
        assert_eq!(comparison.drawing(), Which::Cpu);
        let (decision, drawn) = decide(&mut comparison, [10, 5], start);
        let gpu_chosen = Decision { chosen: Which::Gpu, has_changed: true, image_ms: [10.0, 5.0] };
        assert_eq!((decision, drawn), (Some(gpu_chosen), [WARM_UP + MEASURED; 2]));
        assert_eq!(comparison.drawing(), Which::Gpu);
        assert_eq!(decide(&mut comparison, [1, 5], start + INTERVAL - MS).0, None, "not yet");
        let (decision, _) = decide(&mut comparison, [1, 5], start + INTERVAL);
        assert_eq!(decision.map(|decision| decision.chosen), Some(Which::Cpu));
    }

    #[test]
    fn a_decision_says_which_renderer_draws_and_why() {
        let names = ["cpu (2 threads)", "gpu (a GPU, vulkan)"].map(str::to_owned);
        let changed = Decision { chosen: Which::Gpu, has_changed: true, image_ms: [10.04, 5.0] };
        let why = "10.0 ms an image with cpu (2 threads), 5.0 ms with gpu (a GPU, vulkan)";
        assert_eq!(changed.describe(&names), format!("drawing with gpu (a GPU, vulkan) from now on: {why}"));
        let kept = Decision { chosen: Which::Cpu, has_changed: false, ..changed };
        assert_eq!(kept.describe(&names), format!("drawing with cpu (2 threads) as before: {why}"));
    }

    #[test]
    fn one_that_is_hardly_faster_does_not_replace_the_other() {
        let start = Instant::now();
        let mut comparison = Comparison::new(start);
        let (decision, _) = decide(&mut comparison, [10, 9], start);
        assert_eq!(decision.map(|decision| decision.has_changed), Some(false));
        assert_eq!(comparison.drawing(), Which::Cpu);
    }

    #[test]
    fn one_that_is_far_slower_draws_few_images_and_is_measured_more_and_more_seldom() {
        let mut now = Instant::now();
        let mut comparison = Comparison::new(now);
        for minutes in [1, 2, 4, 8, 16, 32, 60, 60] {
            let (decision, [_, gpu]) = decide(&mut comparison, [10, 500], now);
            assert_eq!(
                (decision.map(|decision| decision.chosen), gpu),
                (Some(Which::Cpu), WARM_UP + MEASURED_AT_LEAST)
            );
            now += INTERVAL * minutes;
            assert_eq!(decide(&mut comparison, [10, 500], now - MS).0, None, "before {minutes} minutes");
        }
    }

    #[test]
    fn images_that_are_in_flight_together_share_their_time() {
        let start = Instant::now();
        let mut comparison = Comparison::new(start);
        comparison.begin_if_due(start);
        let drawn = std::iter::repeat_with(|| match comparison.drawing() {
            Which::Cpu => comparison.record(Which::Cpu, 1, MS * 10, start),
            Which::Gpu => comparison.record(Which::Gpu, 4, MS * 20, start),
        });
        let decision = drawn.take(100).flatten().next();
        assert_eq!(decision.map(|decision| decision.image_ms), Some([10.0, 5.0]));
    }

    /// Says when an image of a name is begun or finished; takes this long.
    struct Named(&'static str, Duration, Sender<&'static str>);

    impl Renderer for Named {
        fn describe(&self) -> String {
            self.0.to_owned()
        }

        fn submit_with_depths(&mut self, _: &View<'_>, _: &DepthRequest<'_>) -> Result<(), RenderError> {
            std::thread::sleep(self.1);
            self.2.send(self.0).unwrap();
            Ok(())
        }

        fn finish_with_depths(&mut self, _: &mut Picture, _: &mut Depths) -> Result<Finished, RenderError> {
            Ok(Finished::Drawn)
        }
    }

    /// Draws an empty scene of this background.
    fn draw(renderer: &mut AutoRenderer, background: [u8; 3]) -> Picture {
        let p = [50.0, 0.0, 4.0, 0.0, 0.0, 50.0, 3.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        let camera = Camera::new(Intrinsics::from_p(8, 6, &p).unwrap(), &Isometry3::identity(), 0.01);
        let (scene, visible, encoding) = (Scene::default(), DisplayMask::all(), Encoding::Rgb8);
        let mut picture = Picture::default();
        renderer.submit(&View { scene: &scene, camera: &camera, visible: &visible, background, encoding }).unwrap();
        assert_eq!(renderer.finish(&mut picture).unwrap(), Finished::Drawn);
        picture
    }

    #[test]
    fn real_renderers_take_turns_without_losing_an_image() {
        let mut renderer = AutoRenderer::new(Box::new(CpuRenderer::new()), || Ok(Box::new(GpuRenderer::new(false)?)));
        let mut backgrounds = (0..=255).cycle().map(|level| [level, 7, 9]);
        while renderer.opening.is_some() || renderer.comparison.measurement.is_some() {
            let background = backgrounds.next().unwrap();
            assert_eq!(draw(&mut renderer, background).data, background.repeat(8 * 6));
        }
        assert!(renderer.gpu.is_some(), "there is no Vulkan driver, not even a software one");
        assert!(renderer.comparison.due > Instant::now() && renderer.in_flight.is_empty());
    }

    #[test]
    fn the_cpu_draws_until_the_gpu_is_open_and_goes_on_where_there_is_none() {
        let (sender, drawn) = channel();
        let (open, opening) = channel::<Opened>();
        let cpu = || Box::new(Named("cpu", MS * 50, sender.clone()));
        let mut renderer = AutoRenderer::new(cpu(), move || opening.recv().unwrap());
        (0..12).for_each(|_| drop(draw(&mut renderer, [0; 3])));
        assert!(drawn.try_iter().all(|name| name == "cpu") && renderer.describe() == "cpu");
        open.send(Ok(Box::new(Named("gpu", Duration::ZERO, sender.clone())))).unwrap();
        let mut images = 0;
        while renderer.describe() != "gpu" || renderer.comparison.measurement.is_some() {
            draw(&mut renderer, [0; 3]);
            images += 1;
            assert!(images < 10_000, "the GPU is never taken");
        }
        assert_eq!(drawn.try_iter().last(), Some("gpu"));

        let reason = "none".to_owned();
        let mut renderer = AutoRenderer::new(cpu(), || Err(RenderError::NoAdapter { reason }));
        (0..12).for_each(|_| drop(draw(&mut renderer, [0; 3])));
        assert!(drawn.try_iter().all(|name| name == "cpu") && renderer.opening.is_none());
    }
}
