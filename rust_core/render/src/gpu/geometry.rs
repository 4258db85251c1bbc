//! Buffers of geometries: common parts.

use bytemuck::Pod;
use rayon::prelude::*;

use super::device::Device;

/// A vertex buffer of instances.
#[derive(Clone, Debug)]
pub(super) struct Instances {
    /// The buffer.
    pub(super) buffer: wgpu::Buffer,
    /// Their number.
    pub(super) count: u32,
    /// Offsets of the first instance's values for each vertex buffer of a pipeline, bytes.
    pub(super) offsets: [u64; 2],
}

impl Instances {
    /// Uploads instances; `None` where there are none.
    pub(super) fn upload<T: Pod>(device: &Device, label: &str, all: &[T]) -> Option<Self> {
        let buffer = || device.buffer(label, wgpu::BufferUsages::VERTEX, bytemuck::cast_slice(all));
        (!all.is_empty()).then(|| Self { buffer: buffer(), count: all.len() as u32, offsets: [0; 2] })
    }
}

/// True if all coordinates are finite.
pub(super) fn is_finite(position: &[f32; 3]) -> bool {
    position.iter().all(|c| c.is_finite())
}

/// A vertex buffer of what is made of each of some things and its index. All cores write, `SHARE_BYTES` at a time.
pub(super) fn written<S: Sync, T: Pod + Send, const SHARE_BYTES: usize>(
    device: &Device,
    label: &str,
    from: &[S],
    make: impl Fn(usize, &S) -> T + Sync,
) -> wgpu::Buffer {
    let in_share = SHARE_BYTES / size_of::<T>();
    device.written_buffer(label, wgpu::BufferUsages::VERTEX, from.len() * size_of::<T>(), |memory| {
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
