//! Buffers of geometries: common parts.

use bytemuck::Pod;
use rayon::prelude::*;

use super::device::Device;

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

/// A buffer of what is made of each of some things and its index. All cores write, `SHARE_BYTES` at a time.
pub(super) fn written<S: Sync, T: Pod + Send, const SHARE_BYTES: usize>(
    device: &Device,
    label: &str,
    usage: wgpu::BufferUsages,
    from: &[S],
    make: impl Fn(usize, &S) -> T + Sync,
) -> wgpu::Buffer {
    let in_share = SHARE_BYTES / size_of::<T>();
    device.written_buffer(label, usage, from.len() * size_of::<T>(), |memory| {
        let (shares, mut rest) = memory.into_chunks::<SHARE_BYTES>();
        let shares: Vec<_> = shares.into_iter().collect();
        let make_share = |(share, from): (usize, &[S]), made: &mut Vec<T>| {
            made.clear();
            made.extend((share * in_share..).zip(from).map(|(i, from)| make(i, from)));
        };
        let (whole, mut last) = (from.par_chunks_exact(in_share), Vec::new());
        make_share((shares.len(), whole.remainder()), &mut last);
        whole.enumerate().zip(shares).for_each_init(Vec::new, |made, (from, to)| {
            make_share(from, made);
            wgpu::WriteOnly::from(to).copy_from_slice(bytemuck::cast_slice(made));
        });
        rest.copy_from_slice(bytemuck::cast_slice(&last));
    })
}
