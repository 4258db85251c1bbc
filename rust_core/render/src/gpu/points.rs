//! Point clouds: every point an instance of a triangle around its disc, of a square of four vertices, or of the visible
//! half of a box.
//!
//! A cloud's positions and its colours, the ones after the others as they come, are one vertex buffer that is made once
//! (several for millions of points); style, size and opacity are uniforms, so that changing them costs nothing. There
//! is a pipeline for each style, opaque and blended.
//!
//! Reproduces the shaders that rviz takes without geometry shaders, as it does on Mesa: squares turn to the eye around
//! the cloud's y axis, they are not parallel to the picture plane. GL 3.3 has no storage buffers, from
//! which a vertex could fetch its point.

use bytemuck::{Pod, Zeroable};
use nalgebra::{Matrix4, Vector3};
use rayon::prelude::*;
use rcs_scene::{Aabb, InFrustum, PointBuffer, PointColors, PointStyle, Points};

use super::device::Device;
use super::geometry::{is_finite, MAX_CHUNK_BYTES};
use super::pipeline::{ByPass, FixedState, PipelineSet, Program, Stages};
use super::uniforms::{Slot, Uniforms};
use super::Viewpoint;
use crate::cache::Derived;
use crate::shading::drawn_point_size_px;

/// The pipelines of all styles, and the clouds that are on the GPU.
#[derive(Debug)]
pub(super) struct PointPipelines {
    styles: Vec<StylePipelines>,
    clouds: Derived<PointBuffer, UploadedCloud>,
}

#[derive(Debug)]
struct StylePipelines {
    pipelines: PipelineSet,
    vertices: u32,
}

/// A cloud on the GPU.
#[derive(Debug, Default)]
struct UploadedCloud {
    bounds: Option<Aabb>,
    chunks: Vec<Chunk>,
}

/// Points on the GPU: all positions, then all colours.
#[derive(Clone, Debug)]
struct Chunk {
    buffer: wgpu::Buffer,
    count: u32,
}

/// One cloud in one picture.
pub(super) struct PointsDraw {
    pub(super) pipelines: ByPass<wgpu::RenderPipeline>,
    vertices: u32,
    chunks: Vec<Chunk>,
    slot: Slot,
}

/// Bytes of a point on the GPU.
const POSITION_BYTES: usize = size_of::<[f32; 3]>();
const COLOR_BYTES: usize = size_of::<[u8; 4]>();
const POINT_BYTES: usize = POSITION_BYTES + COLOR_BYTES;

/// A core writes so many points before it takes the next: few enough for its cache.
const POINTS_IN_SHARE: usize = 1 << 14;

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

/// Vertex shader, vertices of an instance and fragment shader of each style, in the order of [`style_index`].
const STYLES: [(&str, u32, &str); 6] = [
    ("vertex_sprite", 3, "fragment_sprite"),
    ("vertex_square", 4, "fragment_square"),
    ("vertex_square", 4, "fragment_flat"),
    ("vertex_disc", 3, "fragment_sphere"),
    ("vertex_box", 18, "fragment_box"),
    ("vertex_tile", 4, "fragment_square"),
];

const BUFFERS: &[Option<wgpu::VertexBufferLayout<'static>>] = &[
    Some(wgpu::VertexBufferLayout {
        array_stride: POSITION_BYTES as u64,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3],
    }),
    Some(wgpu::VertexBufferLayout {
        array_stride: COLOR_BYTES as u64,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &wgpu::vertex_attr_array![1 => Unorm8x4],
    }),
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
        let program = Program::new(device, "points", include_str!("points.wgsl"), &[uniforms]);
        let style = |(vertex, vertices, fragment)| {
            let is_strip = vertices <= 4;
            let stages = Stages {
                vertex,
                fragment,
                buffers: BUFFERS,
                topology: if is_strip {
                    wgpu::PrimitiveTopology::TriangleStrip
                } else {
                    wgpu::PrimitiveTopology::TriangleList
                },
            };
            let states = [false, true].map(FixedState::plain);
            StylePipelines { pipelines: PipelineSet::new(device, &program, stages, states), vertices }
        };
        let styles = STYLES.map(style).into();
        Self { styles, clouds: Derived::default() }
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
        let style = self.styles.get_mut(style_index(&points.style))?;
        let cloud = self.clouds.get(&points.buffer, |cloud| UploadedCloud::new(device, cloud));
        // As Ogre culls: the box lies along the fixed frame's axes, around the points without their size.
        let bounds = cloud.bounds?.transformed(fixed_from_object);
        if bounds.in_frustum(&viewpoint.clip_from_fixed_gl, 0.0) == InFrustum::Outside {
            return None;
        }
        let slot = uniforms.push(&constants(viewpoint, fixed_from_object, points))?;
        let pipelines = style.pipelines.get(device, FixedState::plain(points.blended), &viewpoint.outputs);
        let vertices = if shows_insides(points) { INSIDE_OUT_BOX_VERTICES } else { style.vertices };
        Some(PointsDraw { pipelines, vertices, chunks: cloud.chunks.clone(), slot })
    }
}

/// Vertices of a box that may show its far sides.
const INSIDE_OUT_BOX_VERTICES: u32 = 36;

/// True if boxes may be mirrored by a negative size, so that not only their near sides can be seen.
fn shows_insides(points: &Points) -> bool {
    match points.style {
        PointStyle::Boxes { size_m: [x, y, z] } => points.auto_size || x * y * z < 0.0,
        _ => false,
    }
}

impl PointsDraw {
    pub(super) fn record(&self, pass: &mut wgpu::RenderPass<'_>, uniforms: &wgpu::BindGroup) {
        pass.set_bind_group(0, uniforms, &[self.slot.offset()]);
        for chunk in &self.chunks {
            pass.set_vertex_buffer(0, chunk.buffer.slice(..chunk.positions_end()));
            pass.set_vertex_buffer(1, chunk.buffer.slice(chunk.positions_end()..));
            pass.draw(0..self.vertices, 0..chunk.count);
        }
    }
}

fn constants(viewpoint: &Viewpoint<'_>, fixed_from_object: &Matrix4<f64>, points: &Points) -> Cloud {
    let mut right = Vector3::zeros();
    let mut up_direction = Vector3::zeros();
    let size = match points.style {
        PointStyle::Points { diameter_px } => [drawn_point_size_px(diameter_px), 0.0, 0.0],
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

impl UploadedCloud {
    fn new(device: &Device, cloud: &PointBuffer) -> Self {
        let is_whole = cloud.positions.par_chunks(POINTS_IN_SHARE).all(|positions| positions.iter().all(is_finite));
        if !is_whole {
            return Self::new(device, &finite(cloud));
        }
        let shares = cloud.positions.par_chunks(POINTS_IN_SHARE);
        let bounds = shares.filter_map(|positions| Aabb::around(positions.iter().copied()));
        const POINTS_IN_CHUNK: usize = MAX_CHUNK_BYTES / POINT_BYTES;
        let chunks = cloud.positions.chunks(POINTS_IN_CHUNK).zip((0..).step_by(POINTS_IN_CHUNK));
        Self {
            bounds: bounds.reduce_with(Aabb::joined),
            chunks: chunks.map(|(positions, first)| Chunk::new(device, positions, &cloud.colors, first)).collect(),
        }
    }
}

impl Chunk {
    /// Uploads points, the first of which has the colour `first`. All cores write straight into the memory that the GPU
    /// fetches.
    fn new(device: &Device, positions: &[[f32; 3]], colors: &PointColors, first: usize) -> Self {
        let bytes = positions.len() * POINT_BYTES;
        let buffer = device.written_buffer("points", wgpu::BufferUsages::VERTEX, bytes, |memory| {
            let (to_positions, to_colors) = memory.split_at(size_of_val(positions));
            let (position_shares, last_positions) = to_positions.into_chunks::<{ POINTS_IN_SHARE * POSITION_BYTES }>();
            let (color_shares, last_colors) = to_colors.into_chunks::<{ POINTS_IN_SHARE * COLOR_BYTES }>();
            let shares: Vec<_> = position_shares.into_iter().zip(color_shares).collect();
            let (whole, last) = positions.as_chunks::<POINTS_IN_SHARE>();
            let whole = whole.par_iter().zip(shares).enumerate();
            whole.for_each(|(i, (from, (to_positions, to_colors)))| {
                write_share(from, colors, first + i * POINTS_IN_SHARE, to_positions.into(), to_colors.into());
            });
            write_share(last, colors, first + positions.len() - last.len(), last_positions, last_colors);
        });
        Self { buffer, count: positions.len() as u32 }
    }

    /// Offset of the colours.
    fn positions_end(&self) -> u64 {
        u64::from(self.count) * POSITION_BYTES as u64
    }
}

/// Writes positions and their colours, white where there are none.
fn write_share(
    positions: &[[f32; 3]],
    colors: &PointColors,
    first: usize,
    mut to_positions: wgpu::WriteOnly<'_, [u8]>,
    to_colors: wgpu::WriteOnly<'_, [u8]>,
) {
    to_positions.copy_from_slice(bytemuck::cast_slice(positions));
    let (mut to_colors, _) = to_colors.into_chunks::<COLOR_BYTES>();
    match colors {
        PointColors::Uniform(color) => to_colors.fill(*color),
        PointColors::PerPoint(colors) => {
            let colors = colors.get(first..).unwrap_or_default();
            let known = colors.get(..positions.len()).unwrap_or(colors);
            let (mut to_known, mut unknown) = to_colors.split_at(known.len());
            to_known.copy_from_slice(known);
            unknown.fill([255; COLOR_BYTES]);
        }
    }
}

/// The points whose positions are finite.
fn finite(cloud: &PointBuffer) -> PointBuffer {
    let points = cloud.positions.iter().enumerate().filter(|(_, position)| is_finite(position));
    let (positions, colors) = points.map(|(i, &position)| (position, cloud.colors.get(i))).unzip();
    PointBuffer { positions, colors: PointColors::PerPoint(colors) }
}
