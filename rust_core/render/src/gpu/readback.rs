//! Reading an image back: from the GPU's texture through mapped memory into a message's bytes.
//!
//! The copy on the GPU is part of the image's commands. Its memory is mapped when these are submitted and is ready
//! with their end, so that this one submission is all that has to be waited for. The rows there are 256-byte-aligned
//! RGBA; all cores encode them, each byte read once.

use std::sync::mpsc::{sync_channel, Receiver};
use std::time::Instant;

use rayon::prelude::*;

use super::device::Device;
use crate::RenderError;

const PIXEL_BYTES: u32 = 4;

/// The fewest bytes for a core: a smaller share is copied before another core has woken up.
const MIN_SHARE_BYTES: usize = 128 << 10;

/// The memory for one image.
#[derive(Debug)]
pub(super) struct Readback {
    width_px: u32,
    step: u32,
    buffer: wgpu::Buffer,
}

/// An image that is being read back.
#[derive(Debug)]
pub(super) struct Arrival {
    submission: wgpu::SubmissionIndex,
    mapped: Receiver<Result<(), wgpu::BufferAsyncError>>,
}

impl Readback {
    pub(super) fn new(device: &Device, width_px: u32, height_px: u32) -> Self {
        let step = (width_px * PIXEL_BYTES).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
        let buffer = device.empty_buffer("picture rows", usage, step as usize * height_px as usize);
        Self { width_px, step, buffer }
    }

    /// Records the copy out of the image's texture.
    pub(super) fn record(&self, encoder: &mut wgpu::CommandEncoder, image: &wgpu::Texture) {
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(self.step), rows_per_image: None };
        encoder.copy_texture_to_buffer(
            image.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &self.buffer, layout },
            image.size(),
        );
    }

    /// Maps the memory, once the commands with the copy are submitted.
    pub(super) fn map(&self, submission: wgpu::SubmissionIndex) -> Arrival {
        let (sender, mapped) = sync_channel(1);
        self.buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            // The receiver is gone when the image was dropped in flight.
            let _ = sender.send(result);
        });
        Arrival { submission, mapped }
    }

    /// Waits for an image and writes it row by row to `rows`, which has its rows without padding.
    pub(super) fn read<T: Send>(
        &self,
        device: &Device,
        arrival: Arrival,
        rows: &mut [T],
        write_row: impl Fn(&[[u8; 4]], &mut [T]) + Sync,
    ) -> Result<(), RenderError> {
        let start = Instant::now();
        device.wait(arrival.submission)?;
        match arrival.mapped.try_recv() {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Err(device.error(error.to_string())),
            Err(_) => return Err(device.error("the picture did not come back")),
        }
        let arrived = Instant::now();
        let memory = self.buffer.get_mapped_range(..).map_err(|error| device.error(error.to_string()))?;
        let step = (rows.len() * self.step as usize / memory.len()).max(1);
        rows.par_chunks_exact_mut(step)
            .zip(memory.par_chunks_exact(self.step as usize))
            .with_min_len(MIN_SHARE_BYTES.div_ceil(step * size_of::<T>()))
            .for_each(|(row, memory)| {
                let pixels = memory.get(..(self.width_px * PIXEL_BYTES) as usize).unwrap_or_default();
                write_row(bytemuck::cast_slice(pixels), row);
            });
        drop(memory);
        self.buffer.unmap();
        device.count(|stats| {
            stats.wait += arrived.duration_since(start);
            stats.copy += arrived.elapsed();
        });
        Ok(())
    }
}
