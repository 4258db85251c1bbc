//! Text: each glyph is an instance of a quad, cut out of the texture of all glyphs.
//!
//! The glyphs of a text go to the GPU once, 32 bytes each; where the text stands and its colour are uniforms. Its
//! fixed state is that of its material, as for other triangles.

use std::borrow::Cow;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use rcs_scene::{glyph_atlas, Text};

use super::device::Device;
use super::draw::InstancedDraw;
use super::geometry::Instances;
use super::pipeline::{DepthBias, DepthUse, FixedState, PipelineSet, Program, Stages};
use super::triangles::fixed_state;
use super::{texture, DrawContext};
use crate::cache::Derived;

/// The pipelines, and the texts that are on the GPU.
#[derive(Debug)]
pub(super) struct TextPipelines {
    pipelines: PipelineSet,
    image_layout: wgpu::BindGroupLayout,
    /// The texture of all glyphs, uploaded with the first text.
    atlas: Option<wgpu::BindGroup>,
    texts: Derived<Text, Option<Instances>>,
}

/// A glyph as the shader takes it.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct GpuGlyph {
    /// Left, top, right and bottom.
    edges_m: [f32; 4],
    uv: [f32; 4],
}

const STAGES: Stages = Stages {
    vertex: "vertex_text",
    fragment: "fragment_text",
    buffers: Cow::Borrowed(&[Some(wgpu::VertexBufferLayout {
        array_stride: size_of::<GpuGlyph>() as u64,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &wgpu::vertex_attr_array![0 => Float32x4, 1 => Float32x4],
    })]),
    topology: wgpu::PrimitiveTopology::TriangleStrip,
};

/// The shader's `Caption`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Caption {
    clip_from_text: [[f32; 4]; 4],
    color: [f32; 4],
}

impl TextPipelines {
    pub(super) fn new(device: &Device, uniforms: &wgpu::BindGroupLayout) -> Self {
        let image_layout = texture::layout(device);
        let program = Program::new(device, "text", include_str!("text.wgsl"), &[uniforms, &image_layout]);
        let plain = FixedState { bias: DepthBias { steps: -1, slopes: -1 }, ..FixedState::plain(true) };
        let on_top = FixedState { depth: DepthUse::Ignore, ..FixedState::plain(true) };
        Self {
            pipelines: PipelineSet::new(device, &program, STAGES, [plain, on_top]),
            image_layout,
            atlas: None,
            texts: Derived::default(),
        }
    }

    pub(super) fn forget_dead(&mut self) {
        self.texts.forget_dead();
    }

    pub(super) fn prepare(&mut self, context: &mut DrawContext<'_>, text: &Arc<Text>) -> Option<InstancedDraw> {
        let device = context.device;
        let instances = self.texts.get(text, |text| upload(device, text)).clone()?;
        let view_from_text = context.camera.view_from_facing(&context.fixed_from_object);
        let slot = context.uniforms.push(&Caption {
            clip_from_text: (context.clip_from_view * view_from_text.cast()).cast().into(),
            color: text.color().map(|channel| f32::from(channel) / 255.0),
        });
        let upload = || texture::upload(device, &self.image_layout, glyph_atlas().texture());
        let images = Some(self.atlas.get_or_insert_with(upload).clone());
        let state = fixed_state(text.material(), false);
        let pipelines = self.pipelines.get(device, state, &context.outputs);
        Some(InstancedDraw { pipelines, slot, images, vertices: 4, instances: vec![instances] })
    }
}

/// The glyphs whose edges are finite.
fn upload(device: &Device, text: &Text) -> Option<Instances> {
    let glyph = |glyph: &rcs_scene::Glyph| {
        let bottom_m = glyph.top_m - text.height_m();
        let edges_m = [glyph.left_m, glyph.top_m, glyph.right_m, bottom_m];
        edges_m.iter().all(|edge| edge.is_finite()).then(|| GpuGlyph { edges_m, uv: glyph.uv() })
    };
    let glyphs: Vec<GpuGlyph> = text.glyphs().iter().filter_map(glyph).collect();
    Instances::upload(device, "text", &glyphs)
}
