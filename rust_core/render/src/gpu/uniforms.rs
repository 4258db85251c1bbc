//! The constants of an image's drawables: one buffer of equal slots, bound with a dynamic offset.
//!
//! Every kind of primitive has a struct of its own in its slot, so that one bind group layout serves all pipelines.

use bytemuck::{Pod, Zeroable};

use super::device::Device;

/// Bytes of a slot; the alignment that WebGL 2 asks for.
const SLOT_BYTES: usize = 256;

/// The buffer, and its content in this image. The CPU draws images of too many drawables, so that it stays small.
#[derive(Debug)]
pub(super) struct Uniforms {
    layout: wgpu::BindGroupLayout,
    content: Vec<u8>,
    buffer: wgpu::Buffer,
    bind_group: wgpu::BindGroup,
}

impl Uniforms {
    pub(super) fn new(device: &Device) -> Self {
        let layout = device.wgpu.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("uniforms"),
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Uniform,
                    has_dynamic_offset: true,
                    min_binding_size: wgpu::BufferSize::new(SLOT_BYTES as u64),
                },
                count: None,
            }],
        });
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let buffer = device.empty_buffer("uniforms", usage, 64 * SLOT_BYTES);
        let bind_group = bind_group(device, &layout, &buffer);
        Self { layout, content: Vec::new(), buffer, bind_group }
    }

    /// The layout of the bind group, number 0 of every pipeline.
    pub(super) fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    /// Begins an image.
    pub(super) fn clear(&mut self) {
        self.content.clear();
    }

    /// Adds a drawable's constants, at most a slot's bytes. Returns their dynamic offset.
    pub(super) fn push<T: Pod + Zeroable>(&mut self, constants: &T) -> u32 {
        const { assert!(size_of::<T>() <= SLOT_BYTES) };
        let offset = self.content.len();
        self.content.extend_from_slice(bytemuck::bytes_of(constants));
        self.content.resize(offset + SLOT_BYTES, 0);
        offset as u32
    }

    /// Uploads them.
    pub(super) fn upload(&mut self, device: &Device) -> &wgpu::BindGroup {
        if device.rewrite(&mut self.buffer, &self.content) {
            self.bind_group = bind_group(device, &self.layout, &self.buffer);
        }
        &self.bind_group
    }
}

fn bind_group(device: &Device, layout: &wgpu::BindGroupLayout, buffer: &wgpu::Buffer) -> wgpu::BindGroup {
    let size = wgpu::BufferSize::new(SLOT_BYTES as u64);
    device.wgpu.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("uniforms"),
        layout,
        entries: &[wgpu::BindGroupEntry {
            binding: 0,
            resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: 0, size }),
        }],
    })
}
