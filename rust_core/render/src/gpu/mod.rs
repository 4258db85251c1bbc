//! The GPU renderer: the same image as the CPU's, drawn with wgpu.
//!
//! ```text
//! hardware   whether there may be a GPU at all
//! device     an adapter (Vulkan before GL, hardware before software) and its errors
//! points     ┐ one file for each kind of primitive, with a shader of the same name: an immutable set of pipelines,
//! lines      │ made when the device is opened, and the draw data of one drawable in one image
//! triangles  │
//! text       │
//! cells      ┘
//! draw       the draws of all kinds, recorded into the passes
//! pipeline   what all pipelines have in common, and the fixed state and output in which they differ
//! geometry   what the buffers of geometries have in common
//! texture    images with their mipmaps
//! uniforms   the constants of all drawables of an image, in one buffer with dynamic offsets
//! target     the image and its depths on the GPU; one for each image in flight
//! readback   its way back
//! stats      how often and how long things were done
//! ```
//!
//! An image goes in two halves. The first uploads what is new, and hands the GPU the commands that draw the image
//! and copy it to memory; from then on it is in flight, and the CPU is free, for example for the next image's first
//! half. The second half waits for that one submission and encodes what came back. Nothing is set up during the first
//! image: pipelines are built with the device, and buffers and textures are used again. Depths that are wanted are
//! passes of their own in the same commands, whose pipelines are built when they are first asked for.
//!
//! It stays within WebGL 2's limits (no storage buffers, no compute), so that GL 3.3-class graphics do. Depth is
//! OpenGL's, moved from −1…1 to wgpu's 0…1. A device that is lost or out of memory is closed with an error, and the
//! next image opens it anew.

mod cells;
mod device;
mod draw;
mod geometry;
mod hardware;
mod lines;
mod mesh;
mod pipeline;
mod points;
mod readback;
mod stats;
mod target;
mod text;
mod texture;
mod triangles;
mod uniforms;

use std::collections::VecDeque;
use std::panic::{catch_unwind, AssertUnwindSafe};
use std::sync::atomic::Ordering;
use std::sync::Arc;
use std::time::Instant;

use nalgebra::Matrix4;
use rcs_scene::{
    Camera, DisplayId, DisplayMask, DrawOrder, Encoding, Flip, Geometry, Image, Material, Ordered, PixelMap, Scene,
};

use self::cells::CellPipelines;
use self::device::Device;
use self::draw::{record, Draw};
use self::lines::LinePipelines;
use self::pipeline::{ByPass, Output, Pass};
use self::points::PointPipelines;
use self::readback::Arrival;
pub use self::stats::GpuStats;
use self::target::{Target, Targets};
use self::text::TextPipelines;
use self::triangles::TrianglePipelines;
use self::uniforms::Uniforms;
use crate::depths::{Drawn, ToMetres};
use crate::renderer::panic_text;
use crate::shading::to_light;
use crate::{DepthRequest, Depths, Finished, RenderError, Renderer, View};

/// Draws with wgpu.
#[derive(Debug)]
pub struct GpuRenderer {
    hardware_only: bool,
    name: String,
    gpu: Option<Gpu>,
}

/// All that lives on one device.
#[derive(Debug)]
struct Gpu {
    device: Device,
    uniforms: Uniforms,
    pipelines: Pipelines,
    order: DrawOrder,
    targets: Targets,
    /// The oldest first.
    in_flight: VecDeque<Submitted>,
    /// An image with its depths before a lens bends it.
    before_lens: Drawn,
}

/// The pipelines of all kinds of primitives.
#[derive(Debug)]
struct Pipelines {
    points: PointPipelines,
    lines: LinePipelines,
    triangles: TrianglePipelines,
    texts: TextPipelines,
    cells: CellPipelines,
}

/// An image that was submitted and not yet returned.
#[derive(Debug)]
struct Submitted {
    target: Target,
    /// Of each of its layers.
    arrivals: Vec<Arrival>,
    encoding: Encoding,
    lens: Option<LensView>,
    flip: Flip,
    to_metres: ToMetres,
}

/// The lens of an image.
#[derive(Debug)]
struct LensView {
    map: Arc<PixelMap>,
    background: [u8; 3],
}

/// One image is drawn while others are prepared and encoded; as many as a node usually has cameras.
const IMAGES_AT_ONCE: usize = 4;

/// The drawable at hand, and what all drawables of an image have in common.
struct DrawContext<'a> {
    device: &'a Device,
    uniforms: &'a mut Uniforms,
    camera: &'a Camera,
    /// From the view frame to wgpu's clip coordinates: depth 0 to w.
    clip_from_view: Matrix4<f64>,
    view_from_fixed: Matrix4<f64>,
    clip_from_fixed: Matrix4<f64>,
    /// For OpenGL's clip coordinates: depth −w to w.
    clip_from_fixed_gl: Matrix4<f64>,
    /// Of the drawable.
    fixed_from_object: Matrix4<f64>,
    /// Outputs of the drawable in each pass.
    outputs: ByPass<Output>,
}

impl GpuRenderer {
    /// Opens an adapter; `hardware_only` leaves software drivers out. `WGPU_BACKEND` (`vulkan`, `gl`) and
    /// `WGPU_ADAPTER_NAME` (a part of its name) narrow the choice.
    ///
    /// # Errors
    /// [`RenderError::NoAdapter`], or [`RenderError::Gpu`] when the only adapter does not work.
    pub fn new(hardware_only: bool) -> Result<Self, RenderError> {
        let gpu = Gpu::open(hardware_only)?;
        Ok(Self { hardware_only, name: gpu.device.name.clone(), gpu: Some(gpu) })
    }

    /// Counts and times since the device was opened; zeros while it is lost and not open again.
    pub fn stats(&self) -> GpuStats {
        self.gpu.as_ref().map(|gpu| gpu.device.stats()).unwrap_or_default()
    }

    /// Does something on the device, which is closed where that fails or panics.
    fn on<T>(&mut self, mut gpu: Gpu, work: impl FnOnce(&mut Gpu) -> Result<T, RenderError>) -> Result<T, RenderError> {
        let result = catch_unwind(AssertUnwindSafe(|| work(&mut gpu))).unwrap_or_else(|panic| {
            let reason = format!("panicked: {}", panic_text(panic.as_ref()));
            Err(RenderError::Gpu { adapter: self.name.clone(), reason })
        });
        if !matches!(result, Err(RenderError::Gpu { .. })) {
            self.gpu = Some(gpu);
        } else if gpu.device.is_hung.load(Ordering::Acquire) {
            // A queue that is dropped waits for all of its work.
            let closing = std::thread::Builder::new().name("gpu-close".to_owned()).spawn(move || drop(gpu));
            if let Err(error) = closing {
                log::warn!("{}: no thread to close it on: {error}", self.name);
            }
        }
        result
    }
}

impl Renderer for GpuRenderer {
    fn describe(&self) -> String {
        format!("gpu ({})", self.name)
    }

    fn images_at_once(&self) -> usize {
        IMAGES_AT_ONCE
    }

    fn takes_packed_points(&self) -> bool {
        true
    }

    fn can_upload(&self) -> bool {
        self.gpu.as_ref().is_some_and(|gpu| !gpu.in_flight.is_empty())
    }

    fn upload(&mut self, scene: &Scene, visible: &DisplayMask) {
        let Some(gpu) = self.gpu.take() else { return };
        let shown = |gpu: &mut Gpu| {
            let shown = scene.drawables.iter().filter(|drawable| visible.shows(drawable.display));
            shown.for_each(|drawable| gpu.pipelines.points.upload(&gpu.device, &drawable.geometry));
            Ok(())
        };
        if let Err(error) = self.on(gpu, shown) {
            log::warn!("{error}");
        }
    }

    fn submit_with_depths(&mut self, view: &View<'_>, request: &DepthRequest<'_>) -> Result<(), RenderError> {
        let gpu = match self.gpu.take() {
            Some(gpu) => gpu,
            None => Gpu::open(self.hardware_only)?,
        };
        gpu.device.name.clone_into(&mut self.name);
        self.on(gpu, |gpu| gpu.submit(view, request))
    }

    fn finish_with_depths(&mut self, image: &mut Image, depths: &mut Depths) -> Result<Finished, RenderError> {
        let Some(gpu) = self.gpu.take() else { return Ok(Finished::NoneInFlight) };
        self.on(gpu, |gpu| gpu.finish(image, depths))
    }

    fn forget_sizes(&mut self) {
        if let Some(gpu) = &mut self.gpu {
            gpu.targets.clear();
            gpu.before_lens = Drawn::default();
        }
    }
}

impl Gpu {
    fn open(hardware_only: bool) -> Result<Self, RenderError> {
        let device = Device::open(hardware_only)?;
        let uniforms = Uniforms::new(&device);
        // Compiling shaders is most of the time until the first image, so that all cores do.
        let layout = uniforms.layout();
        let flat = || (CellPipelines::new(&device, layout), TextPipelines::new(&device, layout));
        let ((points, lines), (triangles, (cells, texts))) = rayon::join(
            || rayon::join(|| PointPipelines::new(&device, layout), || LinePipelines::new(&device, layout)),
            || rayon::join(|| TrianglePipelines::new(&device, layout), flat),
        );
        device.check()?;
        let (targets, in_flight) = (Targets::default(), VecDeque::new());
        let (order, before_lens) = (DrawOrder::default(), Drawn::default());
        Ok(Self {
            device,
            uniforms,
            pipelines: Pipelines { points, lines, triangles, texts, cells },
            order,
            targets,
            in_flight,
            before_lens,
        })
    }

    fn submit(&mut self, view: &View<'_>, request: &DepthRequest<'_>) -> Result<(), RenderError> {
        let start = Instant::now();
        let (width_px, height_px) = (view.camera.width_px(), view.camera.height_px());
        let limit_px = self.device.limits.max_texture_dimension_2d;
        if width_px.max(height_px) > limit_px {
            let renderer = format!("gpu ({})", self.device.name);
            return Err(RenderError::TooLarge { width_px, height_px, limit_px, renderer });
        }
        let target = self.targets.take(&self.device, [width_px, height_px], request.wanted());
        let scene = view.scene.seen_from(view.camera);
        let draws = self.prepare(&View { scene: &scene, ..*view }, request);
        let prepared = Instant::now();

        let bind_group = self.uniforms.upload(&self.device);
        let instances = self.pipelines.triangles.upload_instances(&self.device);
        let mut encoder = self.device.wgpu.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for layer in target.layers() {
            let mut pass = target.begin(layer, &mut encoder, view.background);
            record(&draws, layer.pass, &mut pass, (bind_group, instances));
        }
        target.record_copies(&mut encoder);
        let submission = self.device.queue.submit([encoder.finish()]);
        self.device.check()?;
        let arrivals = target.layers().iter().map(|layer| layer.readback.map(submission.clone())).collect();
        self.device.check()?;
        let lens = view.camera.lens().map(|map| LensView { map: Arc::clone(map), background: view.background });
        let (flip, to_metres) = (view.camera.flip(), ToMetres::new(view.camera));
        self.in_flight.push_back(Submitted { target, arrivals, encoding: view.encoding, lens, flip, to_metres });
        self.device.count(|stats| {
            stats.images += 1;
            stats.draws += draws.len() as u64;
            stats.prepare += prepared.duration_since(start);
            stats.submit += prepared.elapsed();
        });
        Ok(())
    }

    fn finish(&mut self, image: &mut Image, depths: &mut Depths) -> Result<Finished, RenderError> {
        let Some(mut submitted) = self.in_flight.pop_front() else { return Ok(Finished::NoneInFlight) };
        let mut drawn = Drawn::in_memory_of(image, depths);
        if let Some(LensView { map, background }) = submitted.lens.take() {
            submitted.read(&self.device, Encoding::Rgba8, &mut self.before_lens)?;
            drawn.see_through(&map, &self.before_lens, background, submitted.encoding);
        } else {
            submitted.read(&self.device, submitted.encoding, &mut drawn)?;
        }
        drawn.flip(submitted.flip);
        drawn.swap(image, depths);
        self.targets.give_back(submitted.target);
        Ok(Finished::Drawn)
    }

    /// Uploads new geometries, drops dead ones, and lists the draws.
    fn prepare(&mut self, view: &View<'_>, request: &DepthRequest<'_>) -> Vec<Draw> {
        let Pipelines { points, lines, triangles, texts, cells } = &mut self.pipelines;
        points.forget_dead();
        lines.forget_dead();
        triangles.forget_dead();
        texts.forget_dead();
        cells.forget_dead();
        self.uniforms.clear();
        let camera = view.camera;
        let clip_from_view = depth_from_zero() * camera.clip_from_view();
        let view_from_fixed = camera.fixed_from_view().inverse().to_homogeneous();
        let mut context = DrawContext {
            device: &self.device,
            uniforms: &mut self.uniforms,
            camera,
            clip_from_view,
            view_from_fixed,
            clip_from_fixed: clip_from_view * view_from_fixed,
            clip_from_fixed_gl: camera.clip_from_view() * view_from_fixed,
            fixed_from_object: Matrix4::identity(),
            outputs: [None; 3],
        };
        let to_light = to_light(camera, view.scene.light.as_ref()).map(Into::into);
        self.pipelines.triangles.begin(&mut context, to_light);
        self.order.sort(view.scene, view.visible, &camera.eye());
        let mut draws = Vec::new();
        for ordered in self.order.of(view.scene) {
            context.fixed_from_object = ordered.drawable.fixed_from_object;
            context.outputs = outputs(request, ordered.drawable.display);
            self.pipelines.prepare(&mut context, &ordered, &mut draws);
        }
        draws
    }
}

impl Pipelines {
    /// Adds the draw of a drawable, or those of its solids.
    fn prepare(&mut self, context: &mut DrawContext<'_>, ordered: &Ordered<'_>, draws: &mut Vec<Draw>) {
        let Self { points, lines, triangles, texts, cells } = self;
        let draw = match &ordered.drawable.geometry {
            cloud @ (Geometry::Points(_) | Geometry::Packed(_)) => points.prepare(context, cloud).map(Draw::Instanced),
            Geometry::Lines(strips) => lines.prepare(context, strips).map(Draw::Instanced),
            Geometry::Ribbons(ribbons) => triangles.prepare_ribbons(context, ribbons).map(Draw::Triangles),
            Geometry::Mesh { mesh, material } => triangles.prepare_mesh(context, mesh, material).map(Draw::Triangles),
            Geometry::Text(text) => texts.prepare(context, text).map(Draw::Instanced),
            Geometry::Cells(sheet) => cells.prepare(context, sheet).map(Draw::Instanced),
            Geometry::Solids(solids) => {
                for solid in solids.as_slice().get(ordered.solids.clone()).unwrap_or(&[]) {
                    let Some(mesh) = solids.shapes().get(solid.shape()) else { continue };
                    context.fixed_from_object = solid.matrix();
                    let draw = triangles.prepare_mesh(context, mesh, &Material::lit(solid.color));
                    add(draws, draw.map(Draw::Triangles));
                }
                None
            }
            Geometry::Facing(_) => None,
        };
        add(draws, draw);
    }
}

impl Submitted {
    /// Waits for the image and its depths, and writes them as they were drawn.
    fn read(&mut self, device: &Device, encoding: Encoding, drawn: &mut Drawn) -> Result<(), RenderError> {
        let (size_px, to_metres) = (self.target.size_px(), self.to_metres);
        let Drawn { image, depths } = drawn;
        image.reset(size_px[0], size_px[1], encoding);
        depths.reset(self.target.wanted_depths(), size_px);
        let write_metres = |pixels: &[[u8; 4]], row: &mut [f32]| {
            for (metres, steps) in row.iter_mut().zip(pixels) {
                *metres = to_metres.metres((u32::from_le_bytes(*steps) & 0x00ff_ffff) as f32);
            }
        };
        for (layer, arrival) in self.target.layers().iter().zip(self.arrivals.drain(..)) {
            let depth = match layer.pass {
                Pass::Opaque => &mut depths.opaque,
                Pass::Objects => &mut depths.objects,
                Pass::Image => {
                    let write_row = |pixels: &[[u8; 4]], row: &mut [u8]| encoding.write_row(pixels, row);
                    layer.readback.read(device, arrival, &mut image.data, write_row)?;
                    continue;
                }
            };
            layer.readback.read(device, arrival, &mut depth.depths_m, write_metres)?;
        }
        Ok(())
    }
}

/// Adds a draw to an image's, or its instances to those of the last one.
fn add(draws: &mut Vec<Draw>, draw: Option<Draw>) {
    let is_joined = match (draws.last_mut(), &draw) {
        (Some(Draw::Triangles(last)), Some(Draw::Triangles(next))) => last.join(next),
        _ => false,
    };
    if !is_joined {
        draws.extend(draw);
    }
}

/// Outputs of a display's drawables in each pass.
fn outputs(request: &DepthRequest<'_>, display: DisplayId) -> ByPass<Output> {
    let object = request.objects_of.map(|displays| Output::ObjectDepth { is_listed: displays.shows(display) });
    [Some(Output::Color), request.opaque.then_some(Output::OpaqueDepth), object]
}

impl DrawContext<'_> {
    /// From the drawable's frame to wgpu's clip coordinates, computed in `f64`; the columns, as a shader takes them.
    fn clip_from_object(&self) -> [[f32; 4]; 4] {
        (self.clip_from_fixed * self.fixed_from_object).cast().into()
    }

    /// From the drawable's frame to the view frame, computed in `f64`.
    fn view_from_object(&self) -> Matrix4<f32> {
        (self.view_from_fixed * self.fixed_from_object).cast()
    }

    /// Pixels in a row and rows.
    fn size_px(&self) -> [f32; 2] {
        [self.camera.width_px() as f32, self.camera.height_px() as f32]
    }
}

/// From OpenGL's clip coordinates, depth −w to w, to wgpu's, depth 0 to w.
fn depth_from_zero() -> Matrix4<f64> {
    let mut matrix = Matrix4::identity();
    matrix[(2, 2)] = 0.5;
    matrix[(2, 3)] = 0.5;
    matrix
}

#[cfg(test)]
mod tests {
    use nalgebra::Isometry3;
    use rcs_scene::{DisplayMask, Intrinsics, Scene};

    use super::*;

    #[test]
    fn a_gpu_that_does_not_answer_is_an_error_and_the_next_image_is_drawn() {
        let camera = |side: u32| {
            let p = [10.0, 0.0, 4.0, 0.0, 0.0, 10.0, 3.0, 0.0, 0.0, 0.0, 1.0, 0.0];
            Camera::new(Intrinsics::from_p(side, side, &p).unwrap(), &Isometry3::identity(), 0.01)
        };
        let (scene, visible) = (Scene::default(), DisplayMask::all());
        let (large, small) = (camera(4096), camera(8));
        let view =
            View { scene: &scene, camera: &large, visible: &visible, background: [3, 2, 1], encoding: Encoding::Rgb8 };
        let mut renderer = GpuRenderer::new(false).unwrap();
        let mut image = Image::default();
        renderer.gpu.as_mut().unwrap().device.patience = std::time::Duration::ZERO;
        // One that is drawn at once is no proof.
        let mut draw = || {
            renderer.submit(&view).unwrap();
            renderer.finish(&mut image).err()
        };
        let error = (0..20).find_map(|_| draw()).unwrap();
        assert!(
            matches!(&error, RenderError::Gpu { reason, .. } if reason == "it has not answered for 0 s"),
            "{error}"
        );
        assert_eq!(renderer.finish(&mut image).unwrap(), Finished::NoneInFlight, "reported once");
        renderer.render(&View { camera: &small, ..view }, &mut image).unwrap();
        assert_eq!(image.data, [3, 2, 1].repeat(64));
    }

    #[test]
    fn a_lost_device_is_reported_once_and_the_next_image_is_drawn() {
        let p = [10.0, 0.0, 4.0, 0.0, 0.0, 10.0, 3.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        let camera = Camera::new(Intrinsics::from_p(8, 6, &p).unwrap(), &Isometry3::identity(), 0.01);
        let (scene, visible) = (Scene::default(), DisplayMask::all());
        let view =
            View { scene: &scene, camera: &camera, visible: &visible, background: [3, 2, 1], encoding: Encoding::Rgb8 };
        let is_lost = |result: &Result<_, RenderError>| matches!(result, Err(RenderError::Gpu { .. }));
        let mut renderer = GpuRenderer::new(false).unwrap();
        let lose = |renderer: &GpuRenderer| renderer.gpu.as_ref().unwrap().device.wgpu.destroy();
        let mut image = Image::default();

        renderer.submit(&view).unwrap();
        renderer.submit(&view).unwrap();
        lose(&renderer);
        // What was submitted before may still come back; then it is the next image that cannot be begun.
        let mut finished = 0;
        let error = loop {
            match renderer.finish(&mut image) {
                Ok(Finished::Drawn) => finished += 1,
                Ok(Finished::NoneInFlight) => break renderer.submit(&view),
                Err(error) => break Err(error),
            }
        };
        assert!(is_lost(&error), "{error:?} after {finished}");
        assert_eq!(renderer.finish(&mut image).unwrap(), Finished::NoneInFlight, "reported once");

        renderer.render(&view, &mut image).unwrap();
        assert_eq!(image.data, [3, 2, 1].repeat(48));

        renderer.submit(&view).unwrap();
        lose(&renderer);
        assert!(is_lost(&renderer.submit(&view)));
        assert_eq!(renderer.finish(&mut image).unwrap(), Finished::NoneInFlight, "reported once");
        renderer.submit(&view).unwrap();
        assert_eq!(renderer.finish(&mut image).unwrap(), Finished::Drawn);
        assert_eq!(image.data, [3, 2, 1].repeat(48));
    }
}
