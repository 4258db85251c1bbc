//! Lines of one pixel, as OpenGL draws them: one pixel in every column of a flat line, in every row of a steep one.
//!
//! Each segment is an instance of a parallelogram that is one pixel high (or wide, when steep) and so covers exactly
//! those pixels. It is clipped before it is widened and its ends follow the diamond-exit rule, as in Mesa. Line
//! primitives would leave all that to the driver, and drivers choose differently.

use std::borrow::Cow;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use rcs_scene::{Blending, Lines};

use super::device::Device;
use super::draw::InstancedDraw;
use super::geometry::{is_finite, Instances};
use super::pipeline::{FixedState, PipelineSet, Program, Stages};
use super::DrawContext;
use crate::cache::Derived;

/// The pipelines, and the lines that are on the GPU.
#[derive(Debug)]
pub(super) struct LinePipelines {
    pipelines: PipelineSet,
    lines: Derived<Lines, Option<Instances>>,
}

/// A segment as the shader takes it.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Segment {
    start: [f32; 3],
    start_color: [u8; 4],
    end: [f32; 3],
    end_color: [u8; 4],
}

const STAGES: Stages = Stages {
    vertex: "vertex_line",
    fragment: "fragment_line",
    buffers: Cow::Borrowed(&[Some(wgpu::VertexBufferLayout {
        array_stride: size_of::<Segment>() as u64,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Unorm8x4, 2 => Float32x3, 3 => Unorm8x4],
    })]),
    topology: wgpu::PrimitiveTopology::TriangleStrip,
};

/// The shader's `Chain`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Chain {
    clip_from_object: [[f32; 4]; 4],
    size_px: [f32; 2],
    padding: [f32; 2],
}

impl LinePipelines {
    pub(super) fn new(device: &Device, uniforms: &wgpu::BindGroupLayout) -> Self {
        let program = Program::new(device, "lines", include_str!("lines.wgsl"), &[uniforms]);
        Self {
            pipelines: PipelineSet::new(device, &program, STAGES, [false, true].map(FixedState::plain)),
            lines: Derived::default(),
        }
    }

    pub(super) fn forget_dead(&mut self) {
        self.lines.forget_dead();
    }

    pub(super) fn prepare(&mut self, context: &mut DrawContext<'_>, lines: &Arc<Lines>) -> Option<InstancedDraw> {
        let device = context.device;
        let instances = self.lines.get(lines, |lines| upload(device, lines)).clone()?;
        let slot = context.uniforms.push(&Chain {
            clip_from_object: context.clip_from_object(),
            size_px: context.size_px(),
            padding: [0.0; 2],
        });
        let state = FixedState::plain(lines.blending == Blending::Alpha);
        let pipelines = self.pipelines.get(device, state, &context.outputs);
        Some(InstancedDraw { pipelines, slot, images: None, vertices: 4, instances: vec![instances] })
    }
}

fn upload(device: &Device, lines: &Lines) -> Option<Instances> {
    let segments: Vec<Segment> = lines
        .segments(0..lines.segment_count())
        .filter_map(|(start, end)| {
            let [a, b] = [lines.positions.get(start)?, lines.positions.get(end)?];
            (is_finite(a) && is_finite(b)).then(|| Segment {
                start: *a,
                start_color: lines.color(start),
                end: *b,
                end_color: lines.color(end),
            })
        })
        .collect();
    Instances::upload(device, "lines", &segments)
}
