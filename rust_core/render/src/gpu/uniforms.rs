//! The constants of a picture's drawables: one buffer of equal slots, bound with a dynamic offset.
//!
//! Every kind of primitive has a struct of its own in its slot, so that one bind group layout serves all pipelines.

use bytemuck::{Pod, Zeroable};

use super::device::Device;

/// Bytes of a slot; the alignment that WebGL 2 asks for.
const SLOT_BYTES: usize = 256;

/// The place of a drawable's constants.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slot(u32);

impl Slot {
    /// The dynamic offset in bytes.
    pub(super) fn offset(self) -> u32 {
        self.0
    }
}

/// The buffer, and its content in this picture.
#[derive(Debug)]
pub(super) struct Uniforms {
    layout: wgpu::BindGroupLayout,
    content: Vec<u8>,
    max_bytes: usize,
    buffer: wgpu::Buffer,
    bind_group: wgpu::BindGroup,
}

impl Uniforms {
    pub(super) fn new(device: &Device) -> Self {
        let layout = device.wgpu().create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
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
        let (buffer, bind_group) = allocate(device, &layout, 64 * SLOT_BYTES);
        let max_bytes = usize::try_from(device.limits().max_buffer_size).unwrap_or(usize::MAX).min(u32::MAX as usize);
        Self { layout, content: Vec::new(), max_bytes, buffer, bind_group }
    }

    /// The layout of the bind group, number 0 of every pipeline.
    pub(super) fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    /// Begins a picture.
    pub(super) fn clear(&mut self) {
        self.content.clear();
    }

    /// Adds a drawable's constants, at most a slot's bytes; `None` when there are too many drawables.
    pub(super) fn push<T: Pod + Zeroable>(&mut self, constants: &T) -> Option<Slot> {
        const { assert!(size_of::<T>() <= SLOT_BYTES) };
        let offset = self.content.len();
        if offset + SLOT_BYTES > self.max_bytes {
            return None;
        }
        self.content.extend_from_slice(bytemuck::bytes_of(constants));
        self.content.resize(offset + SLOT_BYTES, 0);
        Some(Slot(u32::try_from(offset).ok()?))
    }

    /// Uploads them.
    pub(super) fn upload(&mut self, device: &Device) -> &wgpu::BindGroup {
        if self.content.len() as u64 > self.buffer.size() {
            let bytes = self.content.len().next_power_of_two().min(self.max_bytes);
            (self.buffer, self.bind_group) = allocate(device, &self.layout, bytes);
        }
        if !self.content.is_empty() {
            device.queue().write_buffer(&self.buffer, 0, &self.content);
        }
        &self.bind_group
    }
}

fn allocate(device: &Device, layout: &wgpu::BindGroupLayout, bytes: usize) -> (wgpu::Buffer, wgpu::BindGroup) {
    let buffer = device.wgpu().create_buffer(&wgpu::BufferDescriptor {
        label: Some("uniforms"),
        size: bytes as u64,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let bind_group = device.wgpu().create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("uniforms"),
        layout,
        entries: &[wgpu::BindGroupEntry {
            binding: 0,
            resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer: &buffer,
                offset: 0,
                size: wgpu::BufferSize::new(SLOT_BYTES as u64),
            }),
        }],
    });
    (buffer, bind_group)
}
