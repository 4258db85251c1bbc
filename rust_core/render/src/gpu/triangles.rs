//! Triangles: meshes, wide lines and text, with rviz's fixed-function materials.
//!
//! A mesh is indexed vertices on the GPU, made once. Wide lines are turned to the eye on the CPU and uploaded again
//! when the eye has moved. Each fixed state that materials ask for (blending, depth, culling, bias) is a pipeline of
//! its own; the rest is uniforms. Surfaces without a texture have a white one.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use nalgebra::{Matrix3, Matrix4, Point3};
use rcs_scene::{Blending, CullMode, Filtering, Lighting, Material, Mesh, Ribbons, Text, Texture, Vertex, Wrapping};

use super::device::Device;
use super::geometry::{is_finite, Derived, MAX_CHUNK_BYTES};
use super::pipeline::{DepthBias, DepthUse, FixedState, PipelineSet, Program, Stages};
use super::texture;
use super::uniforms::{Slot, Uniforms};
use super::{columns, Viewpoint};
use crate::shading::{normalizes_normals, view_from_normal};

/// The pipelines, and the meshes, texts and textures that are on the GPU.
#[derive(Debug)]
pub(super) struct TrianglePipelines {
    pipelines: PipelineSet,
    image_layout: wgpu::BindGroupLayout,
    white: wgpu::BindGroup,
    meshes: Derived<Mesh, Vec<Triangles>>,
    texts: Derived<Text, Vec<Triangles>>,
    ribbons: Derived<Ribbons, TurnedRibbons>,
    images: Derived<Texture, wgpu::BindGroup>,
}

/// Triangles in one picture.
pub(super) struct TrianglesDraw {
    pipeline: wgpu::RenderPipeline,
    image: wgpu::BindGroup,
    chunks: Vec<Triangles>,
    slot: Slot,
}

/// Indexed triangles on the GPU.
#[derive(Clone, Debug)]
struct Triangles {
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    index_count: u32,
}

/// Wide lines as they are seen from one place.
#[derive(Debug)]
struct TurnedRibbons {
    eye: Point3<f32>,
    chunks: Vec<Triangles>,
}

/// A vertex as the shader takes it.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct GpuVertex {
    position: [f32; 3],
    normal: [f32; 3],
    uv: [f32; 2],
    color: [u8; 4],
}

const STAGES: Stages = Stages {
    vertex: "vertex_triangle",
    fragment: "fragment_triangle",
    buffers: &[Some(wgpu::VertexBufferLayout {
        array_stride: size_of::<GpuVertex>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x2, 3 => Unorm8x4],
    })],
    topology: wgpu::PrimitiveTopology::TriangleList,
};

/// The shader's `Surface`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Surface {
    clip_from_object: [[f32; 4]; 4],
    view_from_normal: [[f32; 4]; 3],
    to_light: [f32; 3],
    _padding: f32,
    diffuse: [f32; 4],
    emissive: [f32; 3],
    flags: u32,
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
            meshes: Derived::new(),
            texts: Derived::new(),
            ribbons: Derived::new(),
            images: Derived::new(),
        }
    }

    pub(super) fn forget_dead(&mut self) {
        self.meshes.forget_dead();
        self.texts.forget_dead();
        self.ribbons.forget_dead();
        self.images.forget_dead();
    }

    pub(super) fn prepare_mesh(
        &mut self,
        device: &Device,
        uniforms: &mut Uniforms,
        viewpoint: &Viewpoint<'_>,
        fixed_from_object: &Matrix4<f64>,
        mesh: &Arc<Mesh>,
        material: &Material,
    ) -> Option<TrianglesDraw> {
        let chunks = self.meshes.get(mesh, |mesh| upload(device, mesh)).clone();
        let view_from_object = viewpoint.camera.view_from_object(fixed_from_object);
        let clip_from_object = viewpoint.clip_from_object(fixed_from_object);
        let linear = fixed_from_object.fixed_view::<3, 3>(0, 0).into_owned();
        let surface = surface(viewpoint, clip_from_object, &view_from_object, &linear, material);
        // Ogre turns the culling round for mirrored objects.
        let state = fixed_state(material, linear.determinant() < 0.0);
        self.draw(device, uniforms, chunks, &surface, state, material.texture.as_ref())
    }

    pub(super) fn prepare_text(
        &mut self,
        device: &Device,
        uniforms: &mut Uniforms,
        viewpoint: &Viewpoint<'_>,
        fixed_from_object: &Matrix4<f64>,
        text: &Arc<Text>,
    ) -> Option<TrianglesDraw> {
        let chunks = self.texts.get(text, |text| upload(device, text.mesh())).clone();
        let material = text.material();
        let view_from_object = viewpoint.camera.view_from_facing(fixed_from_object);
        let clip_from_object = columns(&(viewpoint.clip_from_view * view_from_object.cast()).cast());
        let surface = surface(viewpoint, clip_from_object, &view_from_object, &Matrix3::identity(), material);
        let state = fixed_state(material, false);
        self.draw(device, uniforms, chunks, &surface, state, material.texture.as_ref())
    }

    pub(super) fn prepare_ribbons(
        &mut self,
        device: &Device,
        uniforms: &mut Uniforms,
        viewpoint: &Viewpoint<'_>,
        fixed_from_object: &Matrix4<f64>,
        ribbons: &Arc<Ribbons>,
    ) -> Option<TrianglesDraw> {
        let eye = viewpoint.camera.eye_in_object(fixed_from_object);
        let turn = |ribbons: &Ribbons| TurnedRibbons { eye, chunks: upload(device, &ribbons.to_mesh(eye)) };
        let turned = self.ribbons.get(ribbons, turn);
        if turned.eye != eye {
            *turned = turn(ribbons);
        }
        let chunks = turned.chunks.clone();
        // The back is culled: where a sharp corner folds a ribbon over, the fold is not seen.
        let material = Material::unlit(ribbons.blending == Blending::Alpha);
        let view_from_object = viewpoint.camera.view_from_object(fixed_from_object);
        let clip_from_object = viewpoint.clip_from_object(fixed_from_object);
        let surface = surface(viewpoint, clip_from_object, &view_from_object, &Matrix3::identity(), &material);
        let mirrored = fixed_from_object.fixed_view::<3, 3>(0, 0).determinant() < 0.0;
        self.draw(device, uniforms, chunks, &surface, fixed_state(&material, mirrored), None)
    }

    fn draw(
        &mut self,
        device: &Device,
        uniforms: &mut Uniforms,
        chunks: Vec<Triangles>,
        surface: &Surface,
        state: FixedState,
        texture: Option<&Arc<Texture>>,
    ) -> Option<TrianglesDraw> {
        if chunks.is_empty() {
            return None;
        }
        let image = match texture {
            Some(texture) => {
                self.images.get(texture, |texture| texture::upload(device, &self.image_layout, texture)).clone()
            }
            None => self.white.clone(),
        };
        let pipeline = self.pipelines.get(device, state);
        Some(TrianglesDraw { pipeline, image, chunks, slot: uniforms.push(surface)? })
    }
}

impl TrianglesDraw {
    pub(super) fn record(&self, pass: &mut wgpu::RenderPass<'_>, uniforms: &wgpu::BindGroup) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, uniforms, &[self.slot.offset()]);
        pass.set_bind_group(1, &self.image, &[]);
        for chunk in &self.chunks {
            pass.set_vertex_buffer(0, chunk.vertices.slice(..));
            pass.set_index_buffer(chunk.indices.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..chunk.index_count, 0, 0..1);
        }
    }
}

/// The part of a material that belongs to a pipeline.
fn fixed_state(material: &Material, mirrored: bool) -> FixedState {
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
/// with both, and mirrored; and texts. Others get their pipeline when they are first seen.
fn usual_states() -> impl Iterator<Item = FixedState> {
    let depth_uses = [(false, DepthUse::TestAndWrite), (true, DepthUse::Test), (true, DepthUse::TestAndWrite)];
    let sides = [Some(wgpu::Face::Back), Some(wgpu::Face::Front), None];
    let state = |blended, depth, cull| FixedState { blended, depth, cull, bias: DepthBias::default() };
    let surfaces =
        sides.into_iter().flat_map(move |cull| depth_uses.map(|(blended, depth)| state(blended, depth, cull)));
    let text = FixedState { bias: DepthBias { steps: -1, slopes: -1 }, ..FixedState::plain(true) };
    let text_on_top = state(true, DepthUse::Ignore, None);
    surfaces.chain([text, text_on_top])
}

fn surface(
    viewpoint: &Viewpoint<'_>,
    clip_from_object: [[f32; 4]; 4],
    view_from_object: &Matrix4<f32>,
    fixed_from_object: &Matrix3<f64>,
    material: &Material,
) -> Surface {
    let view_from_normal = view_from_normal(&view_from_object.cast());
    let mut flags = 0;
    let normalizes = normalizes_normals(fixed_from_object);
    for (flag, set) in [(VERTEX_COLORS, material.vertex_colors), (NORMALIZE, normalizes)] {
        flags |= if set { flag } else { 0 };
    }
    let mut surface = Surface {
        clip_from_object,
        view_from_normal: [0, 1, 2].map(|i| {
            let [x, y, z] = [0, 1, 2].map(|row| view_from_normal[(row, i)]);
            [x, y, z, 0.0]
        }),
        to_light: viewpoint.to_light.unwrap_or_default(),
        _padding: 0.0,
        diffuse: [1.0; 4],
        emissive: [0.0; 3],
        flags,
    };
    if let Lighting::Lit { diffuse, emissive } = material.lighting {
        surface.flags |= LIT;
        surface.diffuse = diffuse.to_array();
        surface.emissive = [emissive.r, emissive.g, emissive.b];
    }
    surface
}

/// The drawable triangles of a mesh: those whose corners exist and are finite.
fn upload(device: &Device, mesh: &Mesh) -> Vec<Triangles> {
    let vertex = |vertex: &Vertex| GpuVertex {
        position: vertex.position,
        normal: if is_finite(&vertex.normal) { vertex.normal } else { [0.0; 3] },
        uv: vertex.uv.map(|c| if c.is_finite() { c } else { 0.0 }),
        color: vertex.color,
    };
    let drawable = |corners: &[u32]| {
        corners.iter().all(|&i| mesh.vertices.get(i as usize).is_some_and(|v| is_finite(&v.position)))
    };
    let triangles = mesh.indices.chunks_exact(3).filter(|corners| drawable(corners));
    let one_buffer = mesh.vertices.len() * size_of::<GpuVertex>() <= MAX_CHUNK_BYTES
        && mesh.indices.len() * size_of::<u32>() <= MAX_CHUNK_BYTES;
    if one_buffer {
        let vertices: Vec<GpuVertex> = mesh.vertices.iter().map(vertex).collect();
        let indices: Vec<u32> = triangles.flatten().copied().collect();
        return chunk(device, &vertices, &indices).into_iter().collect();
    }
    let corners: Vec<u32> = triangles.flatten().copied().collect();
    let corners_in_chunk = MAX_CHUNK_BYTES / size_of::<GpuVertex>() / 3 * 3;
    corners
        .chunks(corners_in_chunk)
        .filter_map(|corners| {
            let vertices: Vec<GpuVertex> =
                corners.iter().filter_map(|&i| mesh.vertices.get(i as usize)).map(vertex).collect();
            let indices: Vec<u32> = (0..vertices.len() as u32).collect();
            chunk(device, &vertices, &indices)
        })
        .collect()
}

fn chunk(device: &Device, vertices: &[GpuVertex], indices: &[u32]) -> Option<Triangles> {
    (!indices.is_empty()).then(|| Triangles {
        vertices: device.buffer("vertices", wgpu::BufferUsages::VERTEX, bytemuck::cast_slice(vertices)),
        indices: device.buffer("indices", wgpu::BufferUsages::INDEX, bytemuck::cast_slice(indices)),
        index_count: indices.len() as u32,
    })
}
