//! Triangles: meshes, many solids, and wide lines, with rviz's fixed-function materials.
//!
//! A mesh is indexed vertices on the GPU, made once. Wide lines are turned to the eye on the CPU and uploaded again
//! when the eye has moved. Each fixed state that materials ask for (blending, depth, culling, bias) is a pipeline of
//! its own. The rest (where a mesh stands, its colours) makes an instance of it, and all instances of an image are in
//! one buffer: neighbours that share mesh, state and texture are drawn in one call. Surfaces without a texture have a
//! white one.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use nalgebra::{Matrix3, Point3};
use rcs_scene::{Blending, CullMode, Filtering, Lighting, Material, Mesh, Ribbons, Texture, Wrapping};

use super::device::Device;
use super::mesh::{upload, GpuVertex, Triangles};
use super::pipeline::{ByPass, DepthBias, DepthUse, FixedState, PipelineSet, Program, Stages};
use super::texture;
use super::DrawContext;
use crate::cache::Derived;
use crate::shading::{normalizes_normals, view_from_normal};

/// The pipelines, and the meshes and textures that are on the GPU.
#[derive(Debug)]
pub(super) struct TrianglePipelines {
    pipelines: PipelineSet,
    image_layout: wgpu::BindGroupLayout,
    white: wgpu::BindGroup,
    meshes: Derived<Mesh, Option<Triangles>>,
    ribbons: Derived<Ribbons, TurnedRibbons>,
    images: Derived<Texture, wgpu::BindGroup>,
    /// Instances of this image.
    instances: Vec<Instance>,
    instance_buffer: wgpu::Buffer,
    /// The light's offset among the uniforms.
    light: u32,
}

/// Instances of a mesh that are drawn together.
pub(super) struct TrianglesDraw {
    pub(super) pipelines: ByPass<wgpu::RenderPipeline>,
    image: wgpu::BindGroup,
    triangles: Triangles,
    instances: Range<u32>,
    light: u32,
}

/// Wide lines as they are seen from one place.
#[derive(Debug)]
struct TurnedRibbons {
    eye: Point3<f32>,
    triangles: Option<Triangles>,
}

/// A mesh's place and colours as the shader takes them.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Instance {
    clip_from_object: [[f32; 4]; 4],
    view_from_normal: [[f32; 3]; 3],
    diffuse: [f32; 4],
    emissive: [f32; 3],
    flags: u32,
}

const STAGES: Stages = Stages {
    vertex: "vertex_triangle",
    fragment: "fragment_triangle",
    buffers: Cow::Borrowed(&[
        Some(wgpu::VertexBufferLayout {
            array_stride: size_of::<GpuVertex>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &GpuVertex::ATTRIBUTES,
        }),
        Some(wgpu::VertexBufferLayout {
            array_stride: size_of::<Instance>() as u64,
            step_mode: wgpu::VertexStepMode::Instance,
            attributes: &wgpu::vertex_attr_array![
                4 => Float32x4, 5 => Float32x4, 6 => Float32x4, 7 => Float32x4,
                8 => Float32x3, 9 => Float32x3, 10 => Float32x3,
                11 => Float32x4, 12 => Float32x3, 13 => Uint32,
            ],
        }),
    ]),
    topology: wgpu::PrimitiveTopology::TriangleList,
};

/// The shader's `Light`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Light {
    to_light: [f32; 3],
    padding: f32,
}

/// The flags of a surface, which are written into the shader's text.
const LIT: u32 = 1;
const VERTEX_COLORS: u32 = 2;
const NORMALIZE: u32 = 4;

impl TrianglePipelines {
    pub(super) fn new(device: &Device, uniforms: &wgpu::BindGroupLayout) -> Self {
        let image_layout = texture::layout(device);
        let flags = [("LIT", LIT), ("VERTEX_COLORS", VERTEX_COLORS), ("NORMALIZE", NORMALIZE)];
        let constants: String = flags.map(|(name, bit)| format!("const {name}: u32 = {bit}u;\n")).concat();
        let text = constants + include_str!("triangles.wgsl");
        let program = Program::new(device, "triangles", &text, &[uniforms, &image_layout]);
        let white = Texture {
            width: 1,
            height: 1,
            rgba: vec![[255; 4]],
            filtering: Filtering::Nearest,
            wrapping: Wrapping::Clamp,
        };
        Self {
            white: texture::upload(device, &image_layout, &white),
            pipelines: PipelineSet::new(device, &program, STAGES, usual_states()),
            image_layout,
            meshes: Derived::default(),
            ribbons: Derived::default(),
            images: Derived::default(),
            instances: Vec::new(),
            instance_buffer: device.empty_buffer(
                "instances",
                wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
                256 * size_of::<Instance>(),
            ),
            light: 0,
        }
    }

    pub(super) fn forget_dead(&mut self) {
        self.meshes.forget_dead();
        self.ribbons.forget_dead();
        self.images.forget_dead();
    }

    /// Begins an image.
    pub(super) fn begin(&mut self, context: &mut DrawContext<'_>, to_light: Option<[f32; 3]>) {
        self.instances.clear();
        self.light = context.uniforms.push(&Light { to_light: to_light.unwrap_or_default(), padding: 0.0 });
    }

    /// Uploads the image's instances.
    pub(super) fn upload_instances(&mut self, device: &Device) -> &wgpu::Buffer {
        device.rewrite(&mut self.instance_buffer, bytemuck::cast_slice(&self.instances));
        &self.instance_buffer
    }

    pub(super) fn prepare_mesh(
        &mut self,
        context: &DrawContext<'_>,
        mesh: &Arc<Mesh>,
        material: &Material,
    ) -> Option<TrianglesDraw> {
        let triangles = self.meshes.get(mesh, |mesh| upload(context.device, mesh)).clone()?;
        Some(self.draw(context, triangles, material))
    }

    pub(super) fn prepare_ribbons(
        &mut self,
        context: &DrawContext<'_>,
        ribbons: &Arc<Ribbons>,
    ) -> Option<TrianglesDraw> {
        let eye = context.camera.eye_in_object(&context.fixed_from_object);
        let turn = |ribbons: &Ribbons| TurnedRibbons { eye, triangles: upload(context.device, &ribbons.to_mesh(eye)) };
        let turned = self.ribbons.get(ribbons, turn);
        if turned.eye != eye {
            *turned = turn(ribbons);
        }
        let triangles = turned.triangles.clone()?;
        // The back is culled: where a sharp corner folds a ribbon over, the fold is not seen.
        Some(self.draw(context, triangles, &Material::unlit(ribbons.blending == Blending::Alpha)))
    }

    fn draw(&mut self, context: &DrawContext<'_>, triangles: Triangles, material: &Material) -> TrianglesDraw {
        let upload = |texture: &Texture| texture::upload(context.device, &self.image_layout, texture);
        let image = match &material.texture {
            Some(texture) => self.images.get(texture, upload).clone(),
            None => self.white.clone(),
        };
        let (instance, is_mirrored) = instance_of_mesh(context, material);
        // Ogre turns the culling round for mirrored objects.
        let state = fixed_state(material, is_mirrored);
        let pipelines = self.pipelines.get(context.device, state, &context.outputs);
        let first = self.instances.len() as u32;
        self.instances.push(instance);
        TrianglesDraw { pipelines, image, triangles, instances: first..first + 1, light: self.light }
    }
}

impl TrianglesDraw {
    /// Takes the instances of the next draw into this one, where all else is the same.
    pub(super) fn join(&mut self, next: &Self) -> bool {
        let is_same = self.triangles == next.triangles && self.shares_state(next);
        let is_next = is_same && self.instances.end == next.instances.start;
        if is_next {
            self.instances.end = next.instances.end;
        }
        is_next
    }

    fn shares_state(&self, other: &Self) -> bool {
        self.pipelines == other.pipelines && self.image == other.image
    }

    /// Draws after another draw of triangles, or after something else.
    pub(super) fn record(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        uniforms: &wgpu::BindGroup,
        instances: &wgpu::Buffer,
        previous: Option<&Self>,
    ) {
        if previous.is_none() {
            pass.set_bind_group(0, uniforms, &[self.light]);
            pass.set_vertex_buffer(1, instances.slice(..));
        }
        if previous.is_none_or(|previous| !self.shares_state(previous)) {
            pass.set_bind_group(1, &self.image, &[]);
        }
        if previous.is_none_or(|previous| self.triangles != previous.triangles) {
            pass.set_vertex_buffer(0, self.triangles.vertices.slice(..));
            pass.set_index_buffer(self.triangles.indices.slice(..), wgpu::IndexFormat::Uint32);
        }
        pass.draw_indexed(0..self.triangles.index_count, 0, self.instances.clone());
    }
}

/// The part of a material that belongs to a pipeline.
pub(super) fn fixed_state(material: &Material, mirrored: bool) -> FixedState {
    let cull = match (material.cull, mirrored) {
        (CullMode::None, _) => None,
        (CullMode::Back, false) | (CullMode::Front, true) => Some(wgpu::Face::Back),
        (CullMode::Front, false) | (CullMode::Back, true) => Some(wgpu::Face::Front),
    };
    let depth = match (material.depth_test, material.depth_write) {
        (true, true) => DepthUse::TestAndWrite,
        (true, false) => DepthUse::Test,
        (false, _) => DepthUse::Ignore,
    };
    let towards_eye = if depth == DepthUse::Ignore { 0 } else { material.depth_bias.round() as i32 };
    let away = towards_eye.saturating_neg();
    let bias = DepthBias { steps: away, slopes: away };
    FixedState { blended: material.blending == Blending::Alpha, depth, cull, bias }
}

/// The states of all materials that displays have: opaque, translucent and painted over, of surfaces with one side,
/// with both, and mirrored. Others get their pipeline when they are first seen.
fn usual_states() -> impl Iterator<Item = FixedState> {
    let depth_uses = [(false, DepthUse::TestAndWrite), (true, DepthUse::Test), (true, DepthUse::TestAndWrite)];
    let sides = [Some(wgpu::Face::Back), Some(wgpu::Face::Front), None];
    let state = |blended, depth, cull| FixedState { blended, depth, cull, bias: DepthBias::default() };
    sides.into_iter().flat_map(move |cull| depth_uses.map(|(blended, depth)| state(blended, depth, cull)))
}

/// A mesh at its place, and whether it is mirrored there.
fn instance_of_mesh(context: &DrawContext<'_>, material: &Material) -> (Instance, bool) {
    let linear: Matrix3<f64> = context.fixed_from_object.fixed_view::<3, 3>(0, 0).into_owned();
    let mut flags = 0;
    for (flag, set) in [(VERTEX_COLORS, material.vertex_colors), (NORMALIZE, normalizes_normals(&linear))] {
        flags |= if set { flag } else { 0 };
    }
    let mut instance = Instance {
        clip_from_object: context.clip_from_object(),
        view_from_normal: view_from_normal(&context.view_from_object().cast()).into(),
        diffuse: [1.0; 4],
        emissive: [0.0; 3],
        flags,
    };
    if let Lighting::Lit { diffuse, emissive } = material.lighting {
        instance.flags |= LIT;
        instance.diffuse = diffuse.to_array();
        instance.emissive = [emissive.r, emissive.g, emissive.b];
    }
    (instance, linear.determinant() < 0.0)
}
