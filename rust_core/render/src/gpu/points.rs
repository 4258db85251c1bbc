//! Point clouds: every point an instance of a square of four vertices, or of the visible half of a box.
//!
//! A cloud's positions and colours lie interleaved in vertex buffers that are made once; style, size and opacity are
//! uniforms, so that changing them costs nothing. There is a pipeline for each style, opaque and blended.
//!
//! Reproduces the shaders that rviz takes without geometry shaders, as it does on Mesa: squares turn to the eye around
//! the cloud's y axis, they are not parallel to the picture plane. Storage buffers, from which a vertex could fetch its
//! point, are not to be had in GL 3.3.

use bytemuck::{Pod, Zeroable};
use nalgebra::{Matrix4, Vector3};
use rcs_scene::{PointBuffer, PointStyle, Points};

use super::device::Device;
use super::geometry::{is_finite, Derived, Instances, MAX_CHUNK_BYTES};
use super::target::{COLOR_FORMAT, DEPTH_FORMAT};
use super::uniforms::{Slot, Uniforms};
use super::Viewpoint;
use crate::bounds::Bounds;

/// The pipelines of all styles, and the clouds that are on the GPU.
#[derive(Debug)]
pub(super) struct PointPipelines {
    styles: Vec<StylePipelines>,
    clouds: Derived<PointBuffer, UploadedCloud>,
}

#[derive(Debug)]
struct StylePipelines {
    opaque: wgpu::RenderPipeline,
    blended: wgpu::RenderPipeline,
    vertices: u32,
}

/// A cloud on the GPU.
#[derive(Debug)]
struct UploadedCloud {
    bounds: Option<Bounds>,
    chunks: Vec<Instances>,
}

/// One cloud in one picture.
pub(super) struct PointsDraw {
    pipeline: wgpu::RenderPipeline,
    vertices: u32,
    chunks: Vec<Instances>,
    slot: Slot,
}

/// A point as the shader takes it.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Point {
    position: [f32; 3],
    color: [u8; 4],
}

/// The shader's `Cloud`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Cloud {
    clip_from_object: [[f32; 4]; 4],
    eye: [f32; 3],
    auto_size: f32,
    size: [f32; 3],
    alpha: f32,
    right: [f32; 4],
    up: [f32; 4],
    size_px: [f32; 2],
    padding: [f32; 2],
}

/// OpenGL draws no smaller point than a pixel, and Mesa's software rasteriser no larger one than this.
const SMALLEST_SPRITE_PX: f32 = 1.0;
const LARGEST_SPRITE_PX: f32 = 255.0;

/// Vertex shader, vertices of an instance and fragment shader of each style, in the order of [`style_index`].
const STYLES: [(&str, u32, &str); 6] = [
    ("vertex_sprite", 4, "fragment_sprite"),
    ("vertex_square", 4, "fragment_square"),
    ("vertex_square", 4, "fragment_flat"),
    ("vertex_disc", 3, "fragment_sphere"),
    ("vertex_box", 18, "fragment_box"),
    ("vertex_tile", 4, "fragment_square"),
];

fn style_index(style: &PointStyle) -> usize {
    match style {
        PointStyle::Points { .. } => 0,
        PointStyle::Squares { .. } => 1,
        PointStyle::FlatSquares { .. } => 2,
        PointStyle::Spheres { .. } => 3,
        PointStyle::Boxes { .. } => 4,
        PointStyle::Tiles { .. } => 5,
    }
}

impl PointPipelines {
    pub(super) fn new(device: &Device, uniforms: &wgpu::BindGroupLayout) -> Self {
        let shader = device.wgpu().create_shader_module(wgpu::include_wgsl!("points.wgsl"));
        let layout = device.wgpu().create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("points"),
            bind_group_layouts: &[Some(uniforms)],
            immediate_size: 0,
        });
        let styles = STYLES
            .iter()
            .map(|&style| StylePipelines {
                opaque: pipeline(device, &shader, &layout, style, false),
                blended: pipeline(device, &shader, &layout, style, true),
                vertices: style.1,
            })
            .collect();
        Self { styles, clouds: Derived::new() }
    }

    pub(super) fn forget_dead(&mut self) {
        self.clouds.forget_dead();
    }

    pub(super) fn prepare(
        &mut self,
        device: &Device,
        uniforms: &mut Uniforms,
        viewpoint: &Viewpoint<'_>,
        fixed_from_object: &Matrix4<f64>,
        points: &Points,
    ) -> Option<PointsDraw> {
        let style = self.styles.get(style_index(&points.style))?;
        let cloud = self.clouds.get(&points.buffer, |cloud| UploadedCloud {
            bounds: Bounds::around(&cloud.positions),
            chunks: upload(device, cloud),
        });
        if !cloud.bounds?.may_be_seen(viewpoint.camera, fixed_from_object) {
            return None;
        }
        let chunks = cloud.chunks.clone();
        let slot = uniforms.push(&constants(viewpoint, fixed_from_object, points))?;
        let pipeline = if points.blended { &style.blended } else { &style.opaque }.clone();
        let vertices = if shows_insides(points) { INSIDE_OUT_BOX_VERTICES } else { style.vertices };
        Some(PointsDraw { pipeline, vertices, chunks, slot })
    }
}

/// Vertices of a box that may show its far sides.
const INSIDE_OUT_BOX_VERTICES: u32 = 36;

/// Whether boxes may be mirrored by a negative size, so that not only their near sides can be seen.
fn shows_insides(points: &Points) -> bool {
    match points.style {
        PointStyle::Boxes { size_m: [x, y, z] } => points.auto_size || x * y * z < 0.0,
        _ => false,
    }
}

impl PointsDraw {
    pub(super) fn record(&self, pass: &mut wgpu::RenderPass<'_>, uniforms: &wgpu::BindGroup) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, uniforms, &[self.slot.offset()]);
        for chunk in &self.chunks {
            pass.set_vertex_buffer(0, chunk.buffer.slice(..));
            pass.draw(0..self.vertices, 0..chunk.count);
        }
    }
}

fn constants(viewpoint: &Viewpoint<'_>, fixed_from_object: &Matrix4<f64>, points: &Points) -> Cloud {
    let mut right = Vector3::zeros();
    let mut up_direction = Vector3::zeros();
    let size = match points.style {
        PointStyle::Points { diameter_px } => [diameter_px.clamp(SMALLEST_SPRITE_PX, LARGEST_SPRITE_PX), 0.0, 0.0],
        PointStyle::Squares { size_m: [width, height] } | PointStyle::Spheres { size_m: [width, height] } => {
            [width, height, 0.0]
        }
        PointStyle::FlatSquares { side_m } => [side_m; 3],
        PointStyle::Boxes { size_m } => size_m,
        PointStyle::Tiles { size_m, normal, up } => {
            up_direction = Vector3::from(up);
            right = up_direction.cross(&Vector3::from(normal));
            [size_m[0], size_m[1], 0.0]
        }
    };
    let with_zero = |v: Vector3<f32>| [v.x, v.y, v.z, 0.0];
    Cloud {
        clip_from_object: viewpoint.clip_from_object(fixed_from_object),
        eye: viewpoint.camera.eye_in_object(fixed_from_object).coords.into(),
        auto_size: f32::from(u8::from(points.auto_size)),
        size,
        alpha: points.alpha,
        right: with_zero(right),
        up: with_zero(up_direction),
        size_px: viewpoint.size_px(),
        padding: [0.0; 2],
    }
}

fn upload(device: &Device, cloud: &PointBuffer) -> Vec<Instances> {
    let points_in_chunk = MAX_CHUNK_BYTES / size_of::<Point>();
    let mut chunks = Vec::new();
    for (i, positions) in cloud.positions.chunks(points_in_chunk).enumerate() {
        let first = i * points_in_chunk;
        let points: Vec<Point> = positions
            .iter()
            .enumerate()
            .filter(|(_, position)| is_finite(position))
            .map(|(i, &position)| Point { position, color: cloud.colors.get(first + i) })
            .collect();
        if !points.is_empty() {
            let buffer = device.buffer("points", wgpu::BufferUsages::VERTEX, bytemuck::cast_slice(&points));
            chunks.push(Instances { buffer, count: points.len() as u32 });
        }
    }
    chunks
}

fn pipeline(
    device: &Device,
    shader: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    (vertex, vertices, fragment): (&str, u32, &str),
    blended: bool,
) -> wgpu::RenderPipeline {
    let topology =
        if vertices <= 4 { wgpu::PrimitiveTopology::TriangleStrip } else { wgpu::PrimitiveTopology::TriangleList };
    device.wgpu().create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("points"),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module: shader,
            entry_point: Some(vertex),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: size_of::<Point>() as u64,
                step_mode: wgpu::VertexStepMode::Instance,
                attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Unorm8x4],
            })],
        },
        primitive: wgpu::PrimitiveState { topology, ..Default::default() },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(!blended),
            depth_compare: Some(wgpu::CompareFunction::LessEqual),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: shader,
            entry_point: Some(fragment),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format: COLOR_FORMAT,
                blend: blended.then_some(wgpu::BlendState::ALPHA_BLENDING),
                write_mask: wgpu::ColorWrites::ALL,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}
