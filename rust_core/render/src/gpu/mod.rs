//! The GPU renderer: the same picture as the CPU's, drawn with wgpu.
//!
//! ```text
//! device     an adapter (Vulkan before GL, hardware before software) and what it complains of
//! points     ┐ one file for each kind of primitive, with a shader of the same name: an immutable set of pipelines,
//! lines      │ made when the device is opened, and the draw data of one drawable in one picture
//! triangles  │
//! cells      ┘
//! geometry   buffers and textures that live as long as the scene's `Arc` they were made from
//! texture    images with their mipmaps
//! uniforms   the constants of all drawables of a picture, in one buffer with dynamic offsets
//! target     the picture on the GPU and the way back
//! ```
//!
//! It stays within WebGL 2's limits (no storage buffers, no compute), so that GL 3.3-class graphics do. Depth is
//! OpenGL's, moved from −1…1 to wgpu's 0…1. A device that is lost or out of memory is given up with an error, and the
//! next picture opens it anew.

mod cells;
mod device;
mod geometry;
mod lines;
mod points;
mod target;
mod texture;
mod triangles;
mod uniforms;

use nalgebra::Matrix4;
use rcs_scene::{Camera, DrawOrder, Drawable, Geometry, Picture};

use self::cells::{CellPipelines, CellsDraw};
use self::device::Device;
use self::lines::{LinePipelines, LinesDraw};
use self::points::{PointPipelines, PointsDraw};
use self::target::Target;
use self::triangles::{TrianglePipelines, TrianglesDraw};
use self::uniforms::Uniforms;
use crate::{RenderError, Renderer, View};

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
    points: PointPipelines,
    lines: LinePipelines,
    triangles: TrianglePipelines,
    cells: CellPipelines,
    target: Option<Target>,
    order: DrawOrder,
}

/// One drawable in one picture.
enum Draw {
    Points(PointsDraw),
    Lines(LinesDraw),
    Triangles(TrianglesDraw),
    Cells(CellsDraw),
}

/// What all drawables of a picture have in common.
struct Viewpoint<'a> {
    camera: &'a Camera,
    /// From the view frame to wgpu's clip coordinates: depth 0 to w.
    clip_from_view: Matrix4<f64>,
    /// Unit vector towards the light, in the view frame.
    to_light: Option<[f32; 3]>,
}

impl GpuRenderer {
    /// Opens an adapter; `hardware_only` leaves software drivers out. `WGPU_BACKEND` (`vulkan`, `gl`) and
    /// `WGPU_ADAPTER_NAME` (a part of its name) narrow the choice.
    ///
    /// # Errors
    /// [`RenderError::NoAdapter`], or [`RenderError::Gpu`] when the only adapter does not work.
    pub fn new(hardware_only: bool) -> Result<Self, RenderError> {
        let gpu = Gpu::open(hardware_only)?;
        Ok(Self { hardware_only, name: gpu.device.name().to_owned(), gpu: Some(gpu) })
    }
}

impl Renderer for GpuRenderer {
    fn describe(&self) -> String {
        format!("gpu ({})", self.name)
    }

    fn render(&mut self, view: &View<'_>, picture: &mut Picture) -> Result<(), RenderError> {
        let mut gpu = match self.gpu.take() {
            Some(gpu) => gpu,
            None => Gpu::open(self.hardware_only)?,
        };
        gpu.device.name().clone_into(&mut self.name);
        let result = gpu.render(view, picture);
        if !matches!(result, Err(RenderError::Gpu { .. })) {
            self.gpu = Some(gpu);
        }
        result
    }
}

impl Gpu {
    fn open(hardware_only: bool) -> Result<Self, RenderError> {
        let device = Device::open(hardware_only)?;
        let uniforms = Uniforms::new(&device);
        let points = PointPipelines::new(&device, uniforms.layout());
        let lines = LinePipelines::new(&device, uniforms.layout());
        let triangles = TrianglePipelines::new(&device, uniforms.layout());
        let cells = CellPipelines::new(&device, uniforms.layout());
        device.check()?;
        Ok(Self { device, uniforms, points, lines, triangles, cells, target: None, order: DrawOrder::default() })
    }

    fn render(&mut self, view: &View<'_>, picture: &mut Picture) -> Result<(), RenderError> {
        let (width_px, height_px) = (view.camera.width_px(), view.camera.height_px());
        let limit_px = self.device.limits().max_texture_dimension_2d;
        if width_px.max(height_px) > limit_px {
            let renderer = format!("gpu ({})", self.device.name());
            return Err(RenderError::TooLarge { width_px, height_px, limit_px, renderer });
        }
        let target = match self.target.take() {
            Some(target) if target.size_px() == (width_px, height_px) => target,
            _ => Target::new(&self.device, width_px, height_px),
        };

        let scene = view.scene.seen_from(view.camera);
        let draws = self.prepare(&View { scene: &scene, ..*view });
        let bind_group = self.uniforms.upload(&self.device);
        let mut encoder = self.device.wgpu().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = target.begin(&mut encoder, view.background);
            for draw in &draws {
                match draw {
                    Draw::Points(draw) => draw.record(&mut pass, bind_group),
                    Draw::Lines(draw) => draw.record(&mut pass, bind_group),
                    Draw::Triangles(draw) => draw.record(&mut pass, bind_group),
                    Draw::Cells(draw) => draw.record(&mut pass, bind_group),
                }
            }
        }
        picture.reset(width_px, height_px, view.encoding);
        target.read(&self.device, encoder, picture)?;
        self.target = Some(target);
        self.device.check()
    }

    /// Uploads what is new, forgets what is gone, and lists what there is to draw.
    fn prepare(&mut self, view: &View<'_>) -> Vec<Draw> {
        self.points.forget_dead();
        self.lines.forget_dead();
        self.triangles.forget_dead();
        self.cells.forget_dead();
        self.uniforms.clear();
        let camera = view.camera;
        let viewpoint = Viewpoint {
            camera,
            clip_from_view: depth_from_zero() * camera.clip_from_view(),
            to_light: view.scene.light.map(|light| {
                let to_light = camera.fixed_from_view().inverse_transform_vector(&-light.direction);
                to_light.cast::<f32>().into()
            }),
        };
        let mut order = std::mem::take(&mut self.order);
        order.sort(view.scene, view.visible, &camera.eye());
        let draws = order.of(view.scene).filter_map(|drawable| self.prepare_one(&viewpoint, drawable)).collect();
        self.order = order;
        draws
    }

    fn prepare_one(&mut self, viewpoint: &Viewpoint<'_>, drawable: &Drawable) -> Option<Draw> {
        let (device, uniforms) = (&self.device, &mut self.uniforms);
        let placement = &drawable.fixed_from_object;
        match &drawable.geometry {
            Geometry::Points(points) => {
                self.points.prepare(device, uniforms, viewpoint, placement, points).map(Draw::Points)
            }
            Geometry::Lines(lines) => {
                self.lines.prepare(device, uniforms, viewpoint, placement, lines).map(Draw::Lines)
            }
            Geometry::Ribbons(ribbons) => {
                self.triangles.prepare_ribbons(device, uniforms, viewpoint, placement, ribbons).map(Draw::Triangles)
            }
            Geometry::Mesh { mesh, material } => {
                self.triangles.prepare_mesh(device, uniforms, viewpoint, placement, mesh, material).map(Draw::Triangles)
            }
            Geometry::Text(text) => {
                self.triangles.prepare_text(device, uniforms, viewpoint, placement, text).map(Draw::Triangles)
            }
            Geometry::Cells(sheet) => {
                self.cells.prepare(device, uniforms, viewpoint, placement, sheet).map(Draw::Cells)
            }
            Geometry::Facing(_) => None,
        }
    }
}

impl Viewpoint<'_> {
    /// From the fixed frame to wgpu's clip coordinates.
    fn clip_from_fixed(&self) -> Matrix4<f64> {
        self.clip_from_view * self.camera.fixed_from_view().inverse().to_homogeneous()
    }

    /// From an object's frame to wgpu's clip coordinates, computed in `f64`.
    fn clip_from_object(&self, fixed_from_object: &Matrix4<f64>) -> [[f32; 4]; 4] {
        columns(&(self.clip_from_fixed() * fixed_from_object).cast())
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

/// A matrix as a shader takes it.
fn columns(matrix: &Matrix4<f32>) -> [[f32; 4]; 4] {
    (*matrix).into()
}
