//! The picture on the GPU, and the way back to memory.
//!
//! The colour is plain 8 bits (rviz knows no gamma), the depth is OpenGL's usual 24 bits. The picture comes back in
//! bands of rows, since a picture of 16384×16384 is larger than a buffer may be; the usual sizes are one band.

use rcs_scene::Picture;

use super::device::Device;
use crate::RenderError;

/// The colour format of all pipelines.
pub(super) const COLOR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// The depth format of all pipelines.
pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth24Plus;

const PIXEL_BYTES: u32 = 4;
const MAX_BAND_BYTES: u32 = 64 << 20;

/// What is drawn on.
#[derive(Debug)]
pub(super) struct Target {
    width_px: u32,
    height_px: u32,
    color: wgpu::Texture,
    color_view: wgpu::TextureView,
    depth_view: wgpu::TextureView,
    band: wgpu::Buffer,
    band_rows: u32,
    band_step: u32,
}

impl Target {
    pub(super) fn new(device: &Device, width_px: u32, height_px: u32) -> Self {
        let texture = |format, usage| {
            device.wgpu().create_texture(&wgpu::TextureDescriptor {
                label: Some("picture"),
                size: wgpu::Extent3d { width: width_px, height: height_px, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
                view_formats: &[],
            })
        };
        let color = texture(COLOR_FORMAT, wgpu::TextureUsages::COPY_SRC);
        let depth = texture(DEPTH_FORMAT, wgpu::TextureUsages::empty());
        let band_step = (width_px * PIXEL_BYTES).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let band_rows = (MAX_BAND_BYTES / band_step).clamp(1, height_px);
        let band = device.wgpu().create_buffer(&wgpu::BufferDescriptor {
            label: Some("picture rows"),
            size: u64::from(band_step) * u64::from(band_rows),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        Self {
            width_px,
            height_px,
            color_view: color.create_view(&wgpu::TextureViewDescriptor::default()),
            depth_view: depth.create_view(&wgpu::TextureViewDescriptor::default()),
            color,
            band,
            band_rows,
            band_step,
        }
    }

    /// Pixels in a row and rows.
    pub(super) fn size_px(&self) -> (u32, u32) {
        (self.width_px, self.height_px)
    }

    /// Begins to draw on an empty picture.
    pub(super) fn begin<'e>(&self, encoder: &'e mut wgpu::CommandEncoder, background: [u8; 3]) -> wgpu::RenderPass<'e> {
        let [r, g, b] = background.map(|c| f64::from(c) / 255.0);
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("picture"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.color_view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a: 1.0 }),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth_view,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Discard }),
                stencil_ops: None,
            }),
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        })
    }

    /// Carries out what was recorded and writes the picture, which has this target's size.
    pub(super) fn read(
        &self,
        device: &Device,
        encoder: wgpu::CommandEncoder,
        picture: &mut Picture,
    ) -> Result<(), RenderError> {
        let mut recorded = Some(encoder);
        let (step, encoding) = (picture.step(), picture.encoding);
        let bands = picture.data.chunks_mut((step * self.band_rows as usize).max(1));
        for (first_row, band) in (0..self.height_px).step_by(self.band_rows as usize).zip(bands) {
            let mut encoder = recorded
                .take()
                .unwrap_or_else(|| device.wgpu().create_command_encoder(&wgpu::CommandEncoderDescriptor::default()));
            let rows = self.band_rows.min(self.height_px - first_row);
            self.copy_rows(&mut encoder, first_row, rows);
            device.queue().submit([encoder.finish()]);
            let bytes = self.map(device, rows)?;
            for (row, cells) in
                band.chunks_exact_mut(step).zip(bytes.chunks_exact(self.band_step as usize)).map(|(a, b)| (b, a))
            {
                let pixels = row.get(..(self.width_px * PIXEL_BYTES) as usize).unwrap_or_default();
                encoding.write_row(bytemuck::cast_slice(pixels), cells);
            }
            drop(bytes);
            self.band.unmap();
        }
        Ok(())
    }

    fn copy_rows(&self, encoder: &mut wgpu::CommandEncoder, first_row: u32, rows: u32) {
        encoder.copy_texture_to_buffer(
            wgpu::TexelCopyTextureInfo {
                texture: &self.color,
                mip_level: 0,
                origin: wgpu::Origin3d { x: 0, y: first_row, z: 0 },
                aspect: wgpu::TextureAspect::All,
            },
            wgpu::TexelCopyBufferInfo {
                buffer: &self.band,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(self.band_step),
                    rows_per_image: None,
                },
            },
            wgpu::Extent3d { width: self.width_px, height: rows, depth_or_array_layers: 1 },
        );
    }

    fn map(&self, device: &Device, rows: u32) -> Result<wgpu::BufferView, RenderError> {
        device.check()?;
        let slice = self.band.slice(..u64::from(self.band_step) * u64::from(rows));
        let (sender, receiver) = std::sync::mpsc::channel();
        slice.map_async(wgpu::MapMode::Read, move |result| {
            // Nobody waits any more when the poll below has failed.
            let _ = sender.send(result);
        });
        device.wgpu().poll(wgpu::PollType::wait_indefinitely()).map_err(|error| device.error(error.to_string()))?;
        device.check()?;
        match receiver.try_recv() {
            Ok(Ok(())) => slice.get_mapped_range().map_err(|error| device.error(error.to_string())),
            Ok(Err(error)) => Err(device.error(error.to_string())),
            Err(_) => Err(device.error("the picture did not come back")),
        }
    }
}
