//! Point clouds: every point an instance of a triangle around its disc, of a square of four vertices, or of the visible
//! half of a box.
//!
//! A cloud's points, each a position and a colour, are one vertex buffer that is made once, or several where they are
//! more than 128 MiB; style, size and opacity are uniforms, so that changing them costs nothing. Packed points are the
//! bytes of their message: the shader decodes the colours. It drops points whose position is not finite. There is a
//! pipeline for each style, opaque and blended; other strides than that of decoded points get theirs when they are
//! first seen.
//!
//! Reproduces the shaders that rviz takes without geometry shaders, as it does on Mesa: squares turn to the eye around
//! the cloud's y axis, they are not parallel to the image plane. GL 3.3 has no storage buffers, from
//! which a vertex could fetch its point.

use std::borrow::Cow;
use std::collections::HashMap;

use bytemuck::{Pod, Zeroable};
use nalgebra::{Isometry3, Vector3};
use rayon::prelude::*;
use rcs_scene::{Aabb, Geometry, InFrustum, PackedColors, PackedPoints, PointBuffer, PointLook, PointStyle};

use super::device::Device;
use super::draw::InstancedDraw;
use super::geometry::{written, Instances};
use super::pipeline::{FixedState, PipelineSet, Program, Stages};
use super::DrawContext;
use crate::cache::Derived;
use crate::shading::drawn_point_size_px;

/// The pipelines of all styles, and the clouds.
#[derive(Debug)]
pub(super) struct PointPipelines {
    program: Program,
    /// By style and stride.
    pipelines: HashMap<(usize, u64), PipelineSet>,
    clouds: UploadedClouds,
}

/// The clouds that are on the GPU.
#[derive(Debug, Default)]
struct UploadedClouds {
    decoded: Derived<PointBuffer, UploadedCloud>,
    packed: Derived<PackedPoints, UploadedCloud>,
}

/// A cloud on the GPU.
#[derive(Debug)]
struct UploadedCloud {
    bounds: Option<Aabb>,
    /// The points, with the offsets of position and colour.
    instances: Vec<Instances>,
    stride: u64,
}

/// A decoded point on the GPU.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct GpuPoint {
    position: [f32; 3],
    color: [u8; 4],
}

/// The stride of decoded points.
const POINT_BYTES: usize = size_of::<GpuPoint>();

/// No buffer is larger: half of what every WebGPU device takes.
const MOST_BYTES: usize = 128 << 20;

/// Points that a core takes at a time: few enough for its cache.
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
    range_m: [f32; 2],
    rainbow: [f32; 4],
    color: u32,
    color_rule: u32,
    padding: [u32; 2],
}

/// The shader's rules of colours.
const RGBA: u32 = 0;
const BGR: u32 = 1;
const UNIFORM: u32 = 2;
const RAINBOW: u32 = 3;

/// Vertex shader, vertices of an instance and fragment shader of each style, in the order of [`style_index`].
const STYLES: [(&str, u32, &str); 6] = [
    ("vertex_sprite", 3, "fragment_sprite"),
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
        let program = Program::new(device, "points", include_str!("points.wgsl"), &[uniforms]);
        let usual = |style| {
            let states = [false, true].map(FixedState::plain);
            let stride = POINT_BYTES as u64;
            ((style, stride), PipelineSet::new(device, &program, stages(style, stride), states))
        };
        let pipelines = (0..STYLES.len()).map(usual).collect();
        Self { program, pipelines, clouds: UploadedClouds::default() }
    }

    pub(super) fn forget_dead(&mut self) {
        self.clouds.decoded.forget_dead();
        self.clouds.packed.forget_dead();
    }

    /// Uploads a geometry if it is a cloud.
    pub(super) fn upload(&mut self, device: &Device, geometry: &Geometry) {
        self.clouds.get(device, geometry);
    }

    /// `None` for what is no cloud or is not seen.
    pub(super) fn prepare(&mut self, context: &mut DrawContext<'_>, geometry: &Geometry) -> Option<InstancedDraw> {
        let device = context.device;
        let (look, colors) = match geometry {
            Geometry::Points(points) => (points.look(), None),
            Geometry::Packed(packed) => (packed.look(), Some(*packed.colors())),
            _ => return None,
        };
        let cloud = self.clouds.get(device, geometry)?;
        // As Ogre culls: the box lies along the fixed frame's axes, around the points without their size.
        let bounds = cloud.bounds?.transformed(&context.fixed_from_object);
        if bounds.in_frustum(&context.clip_from_fixed_gl, 0.0) == InFrustum::Outside {
            return None;
        }
        let constants = constants(context, look, colors);
        let slot = context.uniforms.push(&constants);
        let (style, stride) = (style_index(&look.style), cloud.stride);
        let new = || PipelineSet::new(device, &self.program, stages(style, stride), []);
        let set = self.pipelines.entry((style, stride)).or_insert_with(new);
        let pipelines = set.get(device, FixedState::plain(look.blended), &context.outputs);
        let vertices = if shows_insides(look) { INSIDE_OUT_BOX_VERTICES } else { STYLES[style].1 };
        Some(InstancedDraw { pipelines, slot, images: None, vertices, instances: cloud.instances.clone() })
    }
}

impl UploadedClouds {
    /// A cloud, uploaded now if it is not yet; `None` for another geometry.
    fn get(&mut self, device: &Device, geometry: &Geometry) -> Option<&UploadedCloud> {
        match geometry {
            Geometry::Points(points) => {
                Some(self.decoded.get(&points.buffer, |cloud| UploadedCloud::new(device, cloud)))
            }
            Geometry::Packed(packed) => Some(self.packed.get(packed, |cloud| UploadedCloud::packed(device, cloud))),
            _ => None,
        }
    }
}

fn stages(style: usize, stride: u64) -> Stages {
    let (vertex, vertices, fragment) = STYLES[style];
    let is_strip = vertices <= 4;
    let topology =
        if is_strip { wgpu::PrimitiveTopology::TriangleStrip } else { wgpu::PrimitiveTopology::TriangleList };
    let buffer = |attributes: &'static [wgpu::VertexAttribute]| {
        Some(wgpu::VertexBufferLayout { array_stride: stride, step_mode: wgpu::VertexStepMode::Instance, attributes })
    };
    // Each from where it begins.
    let position = buffer(&wgpu::vertex_attr_array![0 => Float32x3]);
    let color = buffer(&wgpu::vertex_attr_array![1 => Unorm8x4]);
    Stages { vertex, fragment, buffers: Cow::Owned(vec![position, color]), topology }
}

/// Vertices of a box that may show its far sides.
const INSIDE_OUT_BOX_VERTICES: u32 = 36;

/// True if boxes may be mirrored by a negative size, so that not only their near sides can be seen.
fn shows_insides(look: PointLook) -> bool {
    match look.style {
        PointStyle::Boxes { size_m: [x, y, z] } => look.auto_size || x * y * z < 0.0,
        _ => false,
    }
}

fn constants(context: &DrawContext<'_>, look: PointLook, colors: Option<PackedColors>) -> Cloud {
    let mut right = Vector3::zeros();
    let mut up_direction = Vector3::zeros();
    let size = match look.style {
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
    let (color_rule, color, rainbow, range_m) = match colors {
        None => (RGBA, 0, [0.0; 4], [0.0; 2]),
        Some(PackedColors::Rgb { .. }) => (BGR, 0, [0.0; 4], [0.0; 2]),
        Some(PackedColors::Uniform(color)) => (UNIFORM, u32::from_le_bytes(color), [0.0; 4], [0.0; 2]),
        Some(PackedColors::Axis(rainbow)) => {
            let fixed_from_object = rainbow.fixed_from_object.unwrap_or_else(Isometry3::identity).to_homogeneous();
            let row = [0, 1, 2, 3].map(|column| fixed_from_object[(rainbow.axis, column)]);
            (RAINBOW, 0, row, [rainbow.min_m, rainbow.range_m])
        }
    };
    Cloud {
        clip_from_object: context.clip_from_object(),
        eye: context.camera.eye_in_object(&context.fixed_from_object).coords.into(),
        auto_size: f32::from(u8::from(look.auto_size)),
        size,
        alpha: look.alpha,
        right: with_zero(right),
        up: with_zero(up_direction),
        size_px: context.size_px(),
        range_m,
        rainbow,
        color,
        color_rule,
        padding: [0; 2],
    }
}

impl UploadedCloud {
    fn new(device: &Device, cloud: &PointBuffer) -> Self {
        let shares = cloud.positions.par_chunks(POINTS_IN_SHARE);
        let bounds = shares.filter_map(|positions| Aabb::around(positions.iter().copied())).reduce_with(Aabb::joined);
        const POINTS_IN_BUFFER: usize = MOST_BYTES / POINT_BYTES;
        let upload = |(first, positions): (usize, &[[f32; 3]])| {
            let point = |i, &position: &_| GpuPoint { position, color: cloud.colors.get(first + i) };
            let buffer = written::<_, _, { POINTS_IN_SHARE * POINT_BYTES }>(device, "points", positions, point);
            Instances { buffer, count: positions.len() as u32, offsets: [0, size_of::<[f32; 3]>() as u64] }
        };
        let parts = (0..).step_by(POINTS_IN_BUFFER).zip(cloud.positions.chunks(POINTS_IN_BUFFER));
        Self { bounds, instances: parts.map(upload).collect(), stride: POINT_BYTES as u64 }
    }

    /// Uploads a message's bytes as they are.
    fn packed(device: &Device, cloud: &PackedPoints) -> Self {
        let (stride, position) = (cloud.stride(), cloud.position_offset());
        let color = if let PackedColors::Rgb { offset } = *cloud.colors() { offset } else { position };
        let upload = |bytes: &[u8]| Instances {
            buffer: device.buffer("points", wgpu::BufferUsages::VERTEX, bytes),
            count: (bytes.len() / stride) as u32,
            offsets: [position as u64, color as u64],
        };
        let instances = cloud.bytes().chunks(MOST_BYTES / stride * stride).map(upload).collect();
        Self { bounds: cloud.bounds(), instances, stride: stride as u64 }
    }
}
