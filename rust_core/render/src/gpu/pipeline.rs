//! Pipelines: the parts common to all kinds of primitives, and the fixed state in which they differ.

use std::borrow::Cow;
use std::collections::HashMap;

use super::device::Device;
use crate::depths::least_object_alpha;
use crate::shading::with_shading;

/// The colour format of all pipelines.
pub(super) const COLOR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// The depth format of all pipelines.
pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth24Plus;

/// A shader and what it is bound to.
#[derive(Clone, Debug)]
pub(super) struct Program {
    label: &'static str,
    shader: wgpu::ShaderModule,
    layout: wgpu::PipelineLayout,
}

/// Which functions of a shader are used, and the vertices that the first one takes.
#[derive(Clone, Debug)]
pub(super) struct Stages {
    /// The vertex shader's name.
    pub(super) vertex: &'static str,
    /// The fragment shader's name.
    pub(super) fragment: &'static str,
    /// The vertex buffers.
    pub(super) buffers: Cow<'static, [Option<wgpu::VertexBufferLayout<'static>>]>,
    /// How vertices make triangles.
    pub(super) topology: wgpu::PrimitiveTopology,
}

/// How fragments are combined with the pixels, and which triangles are culled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct FixedState {
    pub(super) blended: bool,
    pub(super) depth: DepthUse,
    pub(super) cull: Option<wgpu::Face>,
    pub(super) bias: DepthBias,
}

/// Target of a pass over the drawables of an image; the passes follow one another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pass {
    Image,
    /// The depths of opaque surfaces.
    Opaque,
    /// The depths of listed displays.
    Objects,
}

/// Something for each [`Pass`] that a drawable has a part in, in their order.
pub(super) type ByPass<T> = [Option<T>; 3];

/// What fragments write.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Output {
    Color,
    /// The depth, where the depth buffer takes it, too.
    OpaqueDepth,
    /// The depth if their display is listed, else that of the far plane; where they are not too faint.
    ObjectDepth {
        is_listed: bool,
    },
}

/// How the depth buffer is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum DepthUse {
    TestAndWrite,
    Test,
    /// OpenGL does not write depth where it does not test it.
    Ignore,
}

/// How far a triangle is moved away from the eye.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct DepthBias {
    /// In smallest depth steps.
    pub(super) steps: i32,
    /// In the triangle's depth slopes.
    pub(super) slopes: i32,
}

/// The pipelines of one kind of primitive: those of the usual states from the start, others when they are first asked
/// for.
#[derive(Debug)]
pub(super) struct PipelineSet {
    program: Program,
    stages: Stages,
    built: HashMap<(FixedState, Output), wgpu::RenderPipeline>,
}

impl Program {
    /// A shader, with the constants and formulas of [`shading`](crate::shading) before it, whose functions are bound to
    /// groups of these layouts.
    pub(super) fn new(device: &Device, label: &'static str, wgsl: &str, groups: &[&wgpu::BindGroupLayout]) -> Self {
        let groups: Vec<_> = groups.iter().copied().map(Some).collect();
        let layout = device.wgpu.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(label),
            bind_group_layouts: &groups,
            immediate_size: 0,
        });
        let source = wgpu::ShaderSource::Wgsl((with_shading(wgsl) + include_str!("output.wgsl")).into());
        let shader = device.wgpu.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(label), source });
        Self { label, shader, layout }
    }
}

impl FixedState {
    /// Of what has no sides: either opaque, or blended and not hiding what comes after it.
    pub(super) const fn plain(blended: bool) -> Self {
        let depth = if blended { DepthUse::Test } else { DepthUse::TestAndWrite };
        Self { blended, depth, cull: None, bias: DepthBias { steps: 0, slopes: 0 } }
    }
}

impl PipelineSet {
    /// With the pipelines of these states.
    pub(super) fn new(
        device: &Device,
        program: &Program,
        stages: Stages,
        usual: impl IntoIterator<Item = FixedState>,
    ) -> Self {
        let mut set = Self { program: program.clone(), stages, built: HashMap::new() };
        for state in usual {
            set.get(device, state, &[Some(Output::Color), None, None]);
        }
        set
    }

    /// The pipelines of a state for these outputs.
    pub(super) fn get(
        &mut self,
        device: &Device,
        state: FixedState,
        outputs: &ByPass<Output>,
    ) -> ByPass<wgpu::RenderPipeline> {
        outputs.map(|output| {
            let output = output.filter(|output| output.is_written(state))?;
            let build = || build(device, (&self.program, &self.stages), state, output);
            Some(self.built.entry((state, output)).or_insert_with(build).clone())
        })
    }
}

impl Output {
    /// True if fragments in this state may write it.
    fn is_written(self, state: FixedState) -> bool {
        self != Self::OpaqueDepth || state.depth == DepthUse::TestAndWrite
    }

    /// Values for the constants of output.wgsl.
    fn constants(self, state: FixedState) -> [(&'static str, f64); 3] {
        let is_listed = self != Self::ObjectDepth { is_listed: false };
        let least_alpha = match self {
            // What is rounded to the least alpha has it.
            Self::ObjectDepth { is_listed } if state.blended => {
                (f64::from(least_object_alpha(is_listed)) - 0.5) / 255.0
            }
            _ => -1.0,
        };
        let flag = |set| f64::from(u8::from(set));
        let writes_depth = self != Self::Color;
        [("WRITES_DEPTH", flag(writes_depth)), ("IS_LISTED", flag(is_listed)), ("LEAST_ALPHA", least_alpha)]
    }
}

fn build(
    device: &Device,
    (program, stages): (&Program, &Stages),
    state: FixedState,
    output: Output,
) -> wgpu::RenderPipeline {
    let tested = state.depth != DepthUse::Ignore;
    device.count(|stats| stats.pipelines += 1);
    device.wgpu.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(program.label),
        layout: Some(&program.layout),
        vertex: wgpu::VertexState {
            module: &program.shader,
            entry_point: Some(stages.vertex),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &stages.buffers,
        },
        primitive: wgpu::PrimitiveState { topology: stages.topology, cull_mode: state.cull, ..Default::default() },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(state.depth == DepthUse::TestAndWrite),
            depth_compare: Some(if tested { wgpu::CompareFunction::LessEqual } else { wgpu::CompareFunction::Always }),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState {
                constant: state.bias.steps,
                slope_scale: state.bias.slopes as f32,
                clamp: 0.0,
            },
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &program.shader,
            entry_point: Some(stages.fragment),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: &output.constants(state),
                ..Default::default()
            },
            targets: &[Some(wgpu::ColorTargetState {
                format: COLOR_FORMAT,
                blend: state.blended.then_some(wgpu::BlendState::ALPHA_BLENDING),
                write_mask: wgpu::ColorWrites::ALL,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}
