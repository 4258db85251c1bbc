//! The image on the GPU.
//!
//! The colour is plain 8 bits (rviz does not correct gamma), the depth is OpenGL's usual 24 bits. Every image in
//! flight has a target of its own; a finished image's target is reused for the next of its size. Depths that are
//! wanted are drawn on textures like the image's: WebGL 2 does not read depth buffers back.

use super::device::Device;
use super::pipeline::{Pass, COLOR_FORMAT, DEPTH_FORMAT};
use super::readback::Readback;

/// Images without use after which a target is dropped.
const KEPT_FOR_IMAGES: u64 = 64;

/// The textures that one image is drawn on, and the buffers that it is read back through.
#[derive(Debug)]
pub(super) struct Target {
    size_px: [u32; 2],
    wanted_depths: [bool; 2],
    depth_view: wgpu::TextureView,
    /// The image, then the depths that are wanted.
    layers: Vec<Layer>,
}

/// What one pass is drawn on and read back through.
#[derive(Debug)]
pub(super) struct Layer {
    pub(super) pass: Pass,
    pub(super) readback: Readback,
    texture: wgpu::Texture,
    view: wgpu::TextureView,
}

/// The targets that are not in use.
#[derive(Debug, Default)]
pub(super) struct Targets {
    /// With the number of the image that last used it.
    free: Vec<(Target, u64)>,
    images: u64,
}

impl Targets {
    /// A target for the next image, of this width and height, with the opaque surfaces' depths or those of objects.
    pub(super) fn take(&mut self, device: &Device, size_px: [u32; 2], wanted_depths: [bool; 2]) -> Target {
        self.images += 1;
        let oldest = self.images.saturating_sub(KEPT_FOR_IMAGES);
        self.free.retain(|(_, used)| *used >= oldest);
        let is_alike = |target: &Target| target.size_px == size_px && target.wanted_depths == wanted_depths;
        match self.free.iter().position(|(target, _)| is_alike(target)) {
            Some(index) => self.free.swap_remove(index).0,
            None => Target::new(device, size_px, wanted_depths),
        }
    }

    /// Drops all.
    pub(super) fn clear(&mut self) {
        self.free.clear();
    }

    /// Takes a target back whose image is finished.
    pub(super) fn give_back(&mut self, target: Target) {
        self.free.push((target, self.images));
    }
}

impl Target {
    fn new(device: &Device, size_px: [u32; 2], wanted_depths: [bool; 2]) -> Self {
        device.count(|stats| stats.targets += 1);
        let [width, height] = size_px;
        let texture = |format, usage| {
            device.wgpu.create_texture(&wgpu::TextureDescriptor {
                label: Some("picture"),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
                view_formats: &[],
            })
        };
        let layer = |pass| {
            let texture = texture(COLOR_FORMAT, wgpu::TextureUsages::COPY_SRC);
            let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
            Layer { pass, readback: Readback::new(device, width, height), texture, view }
        };
        let depths = [Pass::Opaque, Pass::Objects].into_iter().zip(wanted_depths);
        let depths = depths.filter_map(|(pass, is_wanted)| is_wanted.then_some(pass));
        let depth = texture(DEPTH_FORMAT, wgpu::TextureUsages::empty());
        Self {
            size_px,
            wanted_depths,
            depth_view: depth.create_view(&wgpu::TextureViewDescriptor::default()),
            layers: std::iter::once(Pass::Image).chain(depths).map(layer).collect(),
        }
    }

    /// Pixels in a row and rows.
    pub(super) fn size_px(&self) -> [u32; 2] {
        self.size_px
    }

    /// Which depths it has.
    pub(super) fn wanted_depths(&self) -> [bool; 2] {
        self.wanted_depths
    }

    /// The image, then the depths that are wanted.
    pub(super) fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// Begins to draw on an empty layer.
    pub(super) fn begin<'e>(
        &self,
        layer: &Layer,
        encoder: &'e mut wgpu::CommandEncoder,
        background: [u8; 3],
    ) -> wgpu::RenderPass<'e> {
        // White is the depth of the far plane.
        let background = if layer.pass == Pass::Image { background } else { [255; 3] };
        let [r, g, b] = background.map(|c| f64::from(c) / 255.0);
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("picture"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &layer.view,
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

    /// Records the copies of all layers into the readback buffers.
    pub(super) fn record_copies(&self, encoder: &mut wgpu::CommandEncoder) {
        self.layers.iter().for_each(|layer| layer.readback.record(encoder, &layer.texture));
    }
}
