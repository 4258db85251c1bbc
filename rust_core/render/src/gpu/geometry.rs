//! Buffers of geometries: common parts.

/// No buffer is larger than this; larger geometries are split.
pub(super) const MAX_CHUNK_BYTES: usize = 32 << 20;

/// A vertex buffer of instances.
#[derive(Clone, Debug)]
pub(super) struct Instances {
    /// The buffer.
    pub(super) buffer: wgpu::Buffer,
    /// Their number.
    pub(super) count: u32,
}

/// True if all coordinates are finite.
pub(super) fn is_finite(position: &[f32; 3]) -> bool {
    position.iter().all(|c| c.is_finite())
}
