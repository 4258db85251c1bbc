//! The renderer of `auto`: the faster of the CPU and a hardware GPU, chosen once.
//!
//! The CPU draws while a GPU is opened on a thread. Then both draw the same few frames, of which the CPU's are
//! returned. The faster renderer draws all others. A GPU that fails is replaced by the CPU for good.

use std::sync::mpsc::{sync_channel, Receiver, TryRecvError};
use std::time::{Duration, Instant};

use rcs_scene::{DisplayId, DisplayMask, Image, Scene};

use crate::{CpuRenderer, DepthRequest, Depths, Finished, GpuRenderer, RenderError, Renderer, View};

/// Frames that are compared, after one that fills the GPU's caches.
const COMPARED: u32 = 3;
/// Frames that the CPU draws in less time are not compared: a scene that is still empty says nothing about the next.
const FAST: Duration = Duration::from_millis(5);
/// Longest wait for a GPU that is being opened when the program ends: drivers may crash in a process that ends.
const CLOSING: Duration = Duration::from_secs(5);

type Opened = Result<Box<dyn Renderer>, RenderError>;

/// Draws with the CPU or a GPU.
pub(crate) struct AutoRenderer {
    cpu: Box<dyn Renderer>,
    gpu: Gpu,
}

enum Gpu {
    /// Until it is open, or known to be missing.
    Opening(Receiver<Opened>),
    /// It draws frames of the CPU's as well.
    Compared(Trial),
    /// It draws all frames.
    Chosen(Box<dyn Renderer>),
    /// It is missing, slower or has failed.
    Unused,
}

/// A GPU, and the times of the frames that both renderers have drawn.
struct Trial {
    gpu: Box<dyn Renderer>,
    frames: u32,
    /// Times of the CPU and the GPU, without the first frame.
    took: [Duration; 2],
    /// Memory for the GPU's frames.
    image: Image,
    depths: Depths,
}

impl AutoRenderer {
    /// Draws with the CPU, and opens a hardware GPU.
    pub(crate) fn start() -> Self {
        Self::new(Box::new(CpuRenderer::new()), || Ok(Box::new(GpuRenderer::new(true)?)))
    }

    fn new(cpu: Box<dyn Renderer>, open: impl FnOnce() -> Opened + Send + 'static) -> Self {
        let (sender, opening) = sync_channel(1);
        let thread = std::thread::Builder::new().name("gpu-open".to_owned()).spawn(move || {
            // Nobody receives it where the program has ended.
            let _ = sender.send(open());
        });
        if let Err(error) = thread {
            log::warn!("drawing on the CPU: cannot start the thread that opens a GPU: {error}");
        }
        Self { cpu, gpu: Gpu::Opening(opening) }
    }

    /// Takes the GPU once it is open.
    fn poll_opening(&mut self) {
        let Gpu::Opening(opening) = &self.gpu else { return };
        self.gpu = match opening.try_recv() {
            Err(TryRecvError::Empty) => return,
            Ok(Ok(gpu)) => Gpu::Compared(Trial::new(gpu)),
            Ok(Err(error)) => {
                log::debug!("drawing on the CPU: {error}");
                Gpu::Unused
            }
            Err(TryRecvError::Disconnected) => Gpu::Unused,
        };
    }

    fn drawing(&self) -> &dyn Renderer {
        match &self.gpu {
            Gpu::Chosen(gpu) => gpu.as_ref(),
            _ => self.cpu.as_ref(),
        }
    }

    fn drawing_mut(&mut self) -> &mut dyn Renderer {
        match &mut self.gpu {
            Gpu::Chosen(gpu) => gpu.as_mut(),
            _ => self.cpu.as_mut(),
        }
    }

    /// Draws a frame that the CPU has drawn on the GPU, too, and chooses a renderer after the last of these.
    fn compare(&mut self, view: &View<'_>, request: &DepthRequest<'_>, cpu_took: Duration) {
        let Gpu::Compared(trial) = &mut self.gpu else { return };
        if let Err(error) = trial.draw(view, request, cpu_took) {
            return self.give_up_gpu(&error);
        }
        if trial.frames <= COMPARED {
            return;
        }
        let Gpu::Compared(Trial { gpu, took, .. }) = std::mem::replace(&mut self.gpu, Gpu::Unused) else { return };
        let [cpu_ms, gpu_ms] = took.map(|took| took.as_secs_f64() * 1e3 / f64::from(COMPARED));
        let [cpu_name, gpu_name] = [self.cpu.describe(), gpu.describe()];
        let times = format!("{cpu_ms:.1} ms an image with {cpu_name}, {gpu_ms:.1} ms with {gpu_name}");
        if gpu_ms < cpu_ms {
            self.gpu = Gpu::Chosen(gpu);
            log::info!("drawing with {gpu_name} from now on: {times}");
        } else {
            log::info!("drawing with {cpu_name} as before: {times}");
        }
    }

    fn give_up_gpu(&mut self, error: &RenderError) {
        self.gpu = Gpu::Unused;
        log::warn!("drawing with {} from now on: {error}", self.cpu.describe());
    }

    /// Replaces a GPU that has failed by the CPU, with no frame in flight.
    fn checked<T>(&mut self, result: Result<T, RenderError>) -> Result<T, RenderError> {
        if let Err(error @ RenderError::Gpu { .. }) = &result {
            self.cpu = Box::new(CpuRenderer::new());
            self.give_up_gpu(error);
        }
        result
    }
}

impl Trial {
    fn new(gpu: Box<dyn Renderer>) -> Self {
        Self { gpu, frames: 0, took: Default::default(), image: Image::default(), depths: Depths::default() }
    }

    /// Draws a frame that took the CPU this long.
    fn draw(&mut self, view: &View<'_>, request: &DepthRequest<'_>, cpu_took: Duration) -> Result<(), RenderError> {
        let start = Instant::now();
        self.gpu.submit_with_depths(view, request)?;
        let _ = self.gpu.finish_with_depths(&mut self.image, &mut self.depths)?;
        if self.frames > 0 {
            let [cpu, gpu] = &mut self.took;
            *cpu += cpu_took;
            *gpu += start.elapsed();
        }
        self.frames += 1;
        Ok(())
    }
}

impl Drop for AutoRenderer {
    fn drop(&mut self) {
        if let Gpu::Opening(opening) = &self.gpu {
            // Where it fails or takes too long there is nothing to close.
            let _ = opening.recv_timeout(CLOSING);
        }
    }
}

impl Renderer for AutoRenderer {
    fn describe(&self) -> String {
        self.drawing().describe()
    }

    fn costs(&self) -> Vec<(DisplayId, Duration)> {
        self.drawing().costs()
    }

    fn images_at_once(&self) -> usize {
        self.drawing().images_at_once()
    }

    fn takes_packed_points(&self) -> bool {
        self.drawing().takes_packed_points()
    }

    fn can_upload(&self) -> bool {
        self.drawing().can_upload()
    }

    fn upload(&mut self, scene: &Scene, visible: &DisplayMask) {
        self.drawing_mut().upload(scene, visible);
    }

    fn submit_with_depths(&mut self, view: &View<'_>, request: &DepthRequest<'_>) -> Result<(), RenderError> {
        self.poll_opening();
        if let Gpu::Chosen(gpu) = &mut self.gpu {
            let submitted = gpu.submit_with_depths(view, request);
            return self.checked(submitted);
        }
        let start = Instant::now();
        self.cpu.submit_with_depths(view, request)?;
        let cpu_took = start.elapsed();
        if cpu_took >= FAST {
            self.compare(view, request, cpu_took);
        }
        Ok(())
    }

    fn finish_with_depths(&mut self, image: &mut Image, depths: &mut Depths) -> Result<Finished, RenderError> {
        // Frames in flight on the CPU were submitted before the GPU was chosen.
        let finished = self.cpu.finish_with_depths(image, depths)?;
        match &mut self.gpu {
            Gpu::Chosen(gpu) if finished == Finished::NoneInFlight => {
                let finished = gpu.finish_with_depths(image, depths);
                self.checked(finished)
            }
            _ => Ok(finished),
        }
    }

    fn forget_sizes(&mut self) {
        self.drawing_mut().forget_sizes();
    }

    /// A frame that the GPU fails to draw is drawn on the CPU.
    fn render(&mut self, view: &View<'_>, image: &mut Image) -> Result<(), RenderError> {
        let mut draw = || {
            self.submit(view)?;
            while self.finish(image)? == Finished::Drawn {}
            Ok(())
        };
        match draw() {
            Err(RenderError::Gpu { .. }) => draw(),
            result => result,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{channel, Sender};

    use nalgebra::Isometry3;
    use rcs_scene::{Camera, Encoding, Intrinsics};

    use super::*;

    /// Milliseconds by the number of the image, from 1 on.
    type ImageMs = fn(u32) -> u64;

    /// Draws its name as an image, and tells when it does.
    struct Named {
        name: &'static str,
        image_ms: ImageMs,
        drawn: Sender<&'static str>,
        submitted: u32,
        finished: u32,
        /// The number of the image that fails.
        fails_at: u32,
    }

    impl Named {
        fn new(name: &'static str, image_ms: ImageMs, drawn: &Sender<&'static str>) -> Box<Self> {
            Box::new(Self { name, image_ms, drawn: drawn.clone(), submitted: 0, finished: 0, fails_at: 0 })
        }
    }

    impl Renderer for Named {
        fn describe(&self) -> String {
            self.name.to_owned()
        }

        fn images_at_once(&self) -> usize {
            usize::from(self.name == "gpu") * 3 + 1
        }

        fn submit_with_depths(&mut self, _: &View<'_>, _: &DepthRequest<'_>) -> Result<(), RenderError> {
            self.submitted += 1;
            std::thread::sleep(Duration::from_millis((self.image_ms)(self.submitted)));
            self.drawn.send(self.name).unwrap();
            Ok(())
        }

        fn finish_with_depths(&mut self, image: &mut Image, _: &mut Depths) -> Result<Finished, RenderError> {
            if self.finished == self.submitted {
                return Ok(Finished::NoneInFlight);
            }
            self.finished += 1;
            if self.finished == self.fails_at {
                return Err(RenderError::Gpu { adapter: self.name.to_owned(), reason: "the device was lost".into() });
            }
            image.data = self.name.as_bytes().to_vec();
            Ok(Finished::Drawn)
        }
    }

    /// Shows an empty scene of this background.
    fn with_view<T>(background: [u8; 3], work: impl FnOnce(&View<'_>) -> T) -> T {
        let p = [50.0, 0.0, 4.0, 0.0, 0.0, 50.0, 3.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        let camera = Camera::new(Intrinsics::from_p(8, 6, &p).unwrap(), &Isometry3::identity(), 0.01);
        let (scene, visible, encoding) = (Scene::default(), DisplayMask::all(), Encoding::Rgb8);
        work(&View { scene: &scene, camera: &camera, visible: &visible, background, encoding })
    }

    fn draw(renderer: &mut AutoRenderer, background: [u8; 3]) -> Result<Vec<u8>, RenderError> {
        let mut image = Image::default();
        with_view(background, |view| renderer.submit(view))?;
        assert_eq!(renderer.finish(&mut image)?, Finished::Drawn);
        Ok(image.data)
    }

    /// Draws images, and returns the names on them.
    fn images(renderer: &mut AutoRenderer, count: usize) -> Vec<String> {
        (0..count).map(|_| String::from_utf8(draw(renderer, [0; 3]).unwrap()).unwrap()).collect()
    }

    /// A renderer whose GPU is open.
    fn opened(cpu: Box<dyn Renderer>, gpu: Box<dyn Renderer>) -> AutoRenderer {
        AutoRenderer { cpu, gpu: Gpu::Compared(Trial::new(gpu)) }
    }

    #[test]
    fn both_draw_the_same_few_images_and_the_faster_one_all_others() {
        let slow_at_first = |image| if image == 1 { 500 } else { 0 };
        let kinds: [(ImageMs, _, _); 2] = [(slow_at_first, "gpu", 4), (|_| 100, "cpu", 1)];
        for (gpu_ms, chosen, at_once) in kinds {
            let (sender, drawn) = channel();
            let mut renderer = opened(Named::new("cpu", |_| 50, &sender), Named::new("gpu", gpu_ms, &sender));
            assert_eq!(renderer.images_at_once(), 1);
            assert_eq!(images(&mut renderer, 4), ["cpu"; 4], "the CPU's are shown");
            assert_eq!(drawn.try_iter().collect::<Vec<_>>(), ["cpu", "gpu"].repeat(4));
            assert_eq!((renderer.describe().as_str(), renderer.images_at_once()), (chosen, at_once));
            assert_eq!(images(&mut renderer, 8), [chosen; 8]);
            assert_eq!(drawn.try_iter().collect::<Vec<_>>(), [chosen; 8]);
        }
    }

    #[test]
    fn images_that_the_cpu_draws_at_once_are_not_compared() {
        let (sender, drawn) = channel();
        let mut renderer = opened(Named::new("cpu", |_| 0, &sender), Named::new("gpu", |_| 0, &sender));
        for _ in 0..50 {
            let start = Instant::now();
            images(&mut renderer, 1);
            // A busy machine may interrupt it.
            let is_fast = start.elapsed() < FAST;
            assert_eq!(drawn.try_iter().nth(1).filter(|_| is_fast), None);
        }
    }

    #[test]
    fn the_cpu_draws_until_the_gpu_is_open_and_goes_on_where_there_is_none() {
        let (sender, drawn) = channel();
        let (open, opening) = channel::<Opened>();
        let cpu = || Named::new("cpu", |_| 10, &sender);
        let mut renderer = AutoRenderer::new(cpu(), move || opening.recv().unwrap());
        assert_eq!(images(&mut renderer, 12), ["cpu"; 12]);
        assert!(drawn.try_iter().all(|name| name == "cpu") && renderer.describe() == "cpu");
        open.send(Ok(Named::new("gpu", |_| 0, &sender))).unwrap();
        let mut count = 0;
        while renderer.describe() != "gpu" {
            images(&mut renderer, 1);
            count += 1;
            assert!(count < 1000, "the GPU is never taken");
        }
        assert_eq!(images(&mut renderer, 1), ["gpu"]);

        let reason = "none".to_owned();
        let mut renderer = AutoRenderer::new(cpu(), || Err(RenderError::NoAdapter { reason }));
        while matches!(renderer.gpu, Gpu::Opening(_)) {
            images(&mut renderer, 1);
        }
        assert_eq!(images(&mut renderer, 8), ["cpu"; 8]);
    }

    #[test]
    fn frames_in_flight_when_the_gpu_is_chosen_are_returned_in_their_order() {
        let (sender, _drawn) = channel();
        let mut renderer = opened(Named::new("cpu", |_| 50, &sender), Named::new("gpu", |_| 0, &sender));
        (0..6).for_each(|_| with_view([0; 3], |view| renderer.submit(view)).unwrap());
        let mut image = Image::default();
        for name in ["cpu", "cpu", "cpu", "cpu", "gpu", "gpu"] {
            assert_eq!(renderer.finish(&mut image).unwrap(), Finished::Drawn);
            assert_eq!(image.data, name.as_bytes());
        }
        assert_eq!(renderer.finish(&mut image).unwrap(), Finished::NoneInFlight);
    }

    #[test]
    fn a_gpu_that_fails_is_replaced_by_the_cpu_where_auto_had_chosen_it() {
        let (sender, _drawn) = channel();
        let chosen = || {
            let gpu = Box::new(Named { fails_at: 6, ..*Named::new("gpu", |_| 0, &sender) });
            let mut renderer = opened(Named::new("cpu", |_| 50, &sender), gpu);
            assert_eq!(images(&mut renderer, 5), ["cpu", "cpu", "cpu", "cpu", "gpu"]);
            renderer
        };
        let (mut renderer, mut image) = (chosen(), Image::default());
        with_view([1; 3], |view| renderer.submit(view)).unwrap();
        assert!(matches!(renderer.finish(&mut image), Err(RenderError::Gpu { .. })));
        assert_eq!(renderer.finish(&mut image).unwrap(), Finished::NoneInFlight, "reported once");
        assert_eq!(draw(&mut renderer, [7, 8, 9]).unwrap(), [7, 8, 9].repeat(48));
        assert!(renderer.describe().starts_with("cpu ("));

        let mut renderer = chosen();
        with_view([7, 8, 9], |view| renderer.render(view, &mut image)).unwrap();
        assert_eq!(image.data, [7, 8, 9].repeat(48), "without an error where the view is still there");
        assert!(renderer.describe().starts_with("cpu ("));
    }

    #[test]
    fn a_gpu_that_fails_while_it_is_compared_draws_nothing_more() {
        let (sender, drawn) = channel();
        let gpu = Box::new(Named { fails_at: 2, ..*Named::new("gpu", |_| 0, &sender) });
        let mut renderer = opened(Named::new("cpu", |_| 50, &sender), gpu);
        assert_eq!(images(&mut renderer, 8), ["cpu"; 8]);
        assert_eq!(drawn.try_iter().filter(|name| *name == "gpu").count(), 2);
    }

    #[test]
    fn a_real_gpu_takes_over() {
        let (sender, _drawn) = channel();
        let gpu = GpuRenderer::new(false).expect("a Vulkan driver, at least a software one");
        let mut renderer = opened(Named::new("cpu", |_| 500, &sender), Box::new(gpu));
        assert_eq!(images(&mut renderer, 4), ["cpu"; 4]);
        assert!(renderer.describe().starts_with("gpu ("));
        for level in 0..8 {
            let background = [level, 7, 9];
            assert_eq!(draw(&mut renderer, background).unwrap(), background.repeat(8 * 6));
        }
    }
}
