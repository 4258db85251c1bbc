//! Reading a picture back: from the GPU's texture through mapped memory into a message's bytes.
//!
//! The copy on the GPU is part of the picture's commands. Its memory is mapped when these are submitted and is ready
//! with their end, so that this one submission is all that has to be waited for. The rows there are 256-byte-aligned
//! RGBA; all cores encode them, each byte read once.
//!
//! The memory is cut into bands of rows, since a picture of 16384×16384 is larger than a buffer may be; the usual sizes
//! are one band.

use std::sync::mpsc::{sync_channel, Receiver};
use std::time::Instant;

use rayon::prelude::*;

use super::device::Device;
use crate::RenderError;

const PIXEL_BYTES: u32 = 4;
const MAX_BAND_BYTES: u32 = 64 << 20;

/// The fewest bytes for a core: a smaller share is copied before another core has woken up.
const MIN_SHARE_BYTES: usize = 128 << 10;

/// The memory for one picture.
#[derive(Debug)]
pub(super) struct Readback {
    width_px: u32,
    step: u32,
    bands: Vec<Band>,
}

#[derive(Debug)]
struct Band {
    buffer: wgpu::Buffer,
    first_row: u32,
    rows: u32,
}

/// A picture that is being read back.
#[derive(Debug)]
pub(super) struct Arrival {
    submission: wgpu::SubmissionIndex,
    mapped: Receiver<Result<(), wgpu::BufferAsyncError>>,
}

impl Readback {
    pub(super) fn new(device: &Device, width_px: u32, height_px: u32) -> Self {
        let step = (width_px * PIXEL_BYTES).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let band_rows = (MAX_BAND_BYTES / step).clamp(1, height_px.max(1));
        let bands = (0..height_px).step_by(band_rows as usize).map(|first_row| {
            let rows = band_rows.min(height_px - first_row);
            let buffer = device.wgpu().create_buffer(&wgpu::BufferDescriptor {
                label: Some("picture rows"),
                size: u64::from(step) * u64::from(rows),
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            });
            Band { buffer, first_row, rows }
        });
        Self { width_px, step, bands: bands.collect() }
    }

    /// Records the copy out of the picture's texture.
    pub(super) fn record(&self, encoder: &mut wgpu::CommandEncoder, picture: &wgpu::Texture) {
        for band in &self.bands {
            encoder.copy_texture_to_buffer(
                wgpu::TexelCopyTextureInfo {
                    texture: picture,
                    mip_level: 0,
                    origin: wgpu::Origin3d { x: 0, y: band.first_row, z: 0 },
                    aspect: wgpu::TextureAspect::All,
                },
                wgpu::TexelCopyBufferInfo {
                    buffer: &band.buffer,
                    layout: wgpu::TexelCopyBufferLayout {
                        offset: 0,
                        bytes_per_row: Some(self.step),
                        rows_per_image: None,
                    },
                },
                wgpu::Extent3d { width: self.width_px, height: band.rows, depth_or_array_layers: 1 },
            );
        }
    }

    /// Maps the memory, once the commands with the copy are submitted.
    pub(super) fn map(&self, submission: wgpu::SubmissionIndex) -> Arrival {
        let (sender, mapped) = sync_channel(self.bands.len());
        for band in &self.bands {
            let sender = sender.clone();
            band.buffer.map_async(wgpu::MapMode::Read, .., move |result| {
                // The receiver is gone when the picture was dropped in flight.
                let _ = sender.send(result);
            });
        }
        Arrival { submission, mapped }
    }

    /// Waits for a picture and writes it row by row to `rest`, which has its rows without padding.
    pub(super) fn read<T: Send>(
        &self,
        device: &Device,
        arrival: Arrival,
        mut rest: &mut [T],
        write_row: impl Fn(&[[u8; 4]], &mut [T]) + Sync,
    ) -> Result<(), RenderError> {
        let start = Instant::now();
        device.wait(arrival.submission)?;
        for _ in &self.bands {
            match arrival.mapped.try_recv() {
                Ok(Ok(())) => {}
                Ok(Err(error)) => return Err(device.error(error.to_string())),
                Err(_) => return Err(device.error("the picture did not come back")),
            }
        }
        let arrived = Instant::now();
        let step = rest.len() / self.bands.iter().map(|band| band.rows as usize).sum::<usize>().max(1);
        for band in &self.bands {
            let Some((rows, below)) = rest.split_at_mut_checked(step * band.rows as usize) else { break };
            rest = below;
            let memory = band.buffer.get_mapped_range(..).map_err(|error| device.error(error.to_string()))?;
            rows.par_chunks_exact_mut(step)
                .zip(memory.par_chunks_exact(self.step as usize))
                .with_min_len(MIN_SHARE_BYTES.div_ceil(step * size_of::<T>()))
                .for_each(|(row, memory)| {
                    let pixels = memory.get(..(self.width_px * PIXEL_BYTES) as usize).unwrap_or_default();
                    write_row(bytemuck::cast_slice(pixels), row);
                });
            drop(memory);
            band.buffer.unmap();
        }
        device.count(|stats| {
            stats.wait += arrived.duration_since(start);
            stats.copy += arrived.elapsed();
        });
        Ok(())
    }
}
