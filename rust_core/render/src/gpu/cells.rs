//! Cells: a rectangle with a byte a cell in an array texture, coloured by a palette in the shader.
//!
//! A tile of the cells is a part of a layer. Where the cells of a display change, the old ones have been dropped by
//! then; their texture is reused, and only the tiles that changed are uploaded.

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::{Arc, Weak};

use bytemuck::{Pod, Zeroable};
use rcs_scene::{Blending, CellSheet, CellTile, Cells, TILE_SIDE};

use super::device::Device;
use super::draw::InstancedDraw;
use super::geometry::Instances;
use super::pipeline::{DepthBias, DepthUse, FixedState, PipelineSet, Program, Stages};
use super::DrawContext;
use crate::cache::Derived;

/// The pipelines, and the cells and palettes that are on the GPU.
#[derive(Debug)]
pub(super) struct CellPipelines {
    pipelines: PipelineSet,
    content_layout: wgpu::BindGroupLayout,
    corners: wgpu::Buffer,
    values: HashMap<usize, Uploaded>,
    palettes: Derived<[[u8; 4]; 256], wgpu::TextureView>,
}

const STAGES: Stages = Stages {
    vertex: "vertex_cells",
    fragment: "fragment_cells",
    buffers: Cow::Borrowed(&[Some(wgpu::VertexBufferLayout {
        array_stride: size_of::<[f32; 2]>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x2],
    })]),
    topology: wgpu::PrimitiveTopology::TriangleList,
};

fn fixed_state(blended: bool, depth_write: bool) -> FixedState {
    FixedState {
        blended,
        depth: if depth_write { DepthUse::TestAndWrite } else { DepthUse::Test },
        cull: None,
        bias: DepthBias { steps: CellSheet::DEPTH_STEPS_BACK as i32, slopes: 0 },
    }
}

/// The values of cells on the GPU.
#[derive(Debug)]
struct Uploaded {
    /// Keeps the address from being used again.
    cells: Weak<Cells>,
    /// The cells were dropped when the last image began.
    was_dead: bool,
    /// The tiles in the texture.
    tiles: Vec<Weak<Vec<u8>>>,
    texture: wgpu::Texture,
    layers: Layers,
}

/// How cells are spread over the layers of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Layers {
    /// Cells in a row, rows.
    size: [u32; 2],
    /// Cells on a side of a layer; a multiple of the tiles' side.
    side: u32,
    /// Layers side by side.
    columns: u32,
    count: u32,
}

/// The shader's `Sheet`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Sheet {
    clip_from_object: [[f32; 4]; 4],
    size: [f32; 2],
    layer_side: u32,
    layer_columns: u32,
    alpha: f32,
    padding: [f32; 3],
}

impl Layers {
    /// With the smallest layers that are not too many; `None` for no cells, and where the device has no room for so
    /// many.
    fn of(cells: &Cells, limits: &wgpu::Limits) -> Option<Self> {
        let (width, height) = (cells.width(), cells.height());
        let sides = (1..=limits.max_texture_dimension_2d / TILE_SIDE).map(|tiles| tiles * TILE_SIDE);
        let layers = sides.map(|side| {
            let (columns, rows) = (width.div_ceil(side), height.div_ceil(side));
            Self { size: [width, height], side, columns, count: columns.saturating_mul(rows) }
        });
        let mut fitting = layers.filter(|layers| (1..=limits.max_texture_array_layers).contains(&layers.count));
        fitting.next()
    }

    /// A layer's width and height in cells.
    fn extent(&self) -> [u32; 2] {
        self.size.map(|side| side.min(self.side))
    }

    /// Position of a tile: x, y and layer.
    fn place(&self, tile: &CellTile<'_>) -> wgpu::Origin3d {
        let layer = tile.y / self.side * self.columns + tile.x / self.side;
        wgpu::Origin3d { x: tile.x % self.side, y: tile.y % self.side, z: layer }
    }
}

impl Uploaded {
    fn new(device: &Device, cells: &Arc<Cells>) -> Option<Self> {
        let layers = Layers::of(cells, &device.limits)?;
        let [width, height] = layers.extent();
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: layers.count };
        let texture = device.texture("cells", size, 1, wgpu::TextureFormat::R8Uint);
        Some(Self { cells: Arc::downgrade(cells), was_dead: false, tiles: Vec::new(), texture, layers })
    }

    /// Uploads the tiles that are not on the GPU yet.
    fn fill(&mut self, device: &Device, cells: &Arc<Cells>) {
        let mut before = std::mem::take(&mut self.tiles).into_iter();
        for tile in cells.tiles() {
            let known = before.next().is_some_and(|known| known.as_ptr() == Arc::as_ptr(tile.values));
            if !known {
                let origin = self.layers.place(&tile);
                let to = wgpu::TexelCopyTextureInfo { origin, ..self.texture.as_image_copy() };
                let size = wgpu::Extent3d { width: tile.width, height: tile.height, depth_or_array_layers: 1 };
                device.write_texture(to, tile.values, size);
            }
            self.tiles.push(Arc::downgrade(tile.values));
        }
        self.cells = Arc::downgrade(cells);
        self.was_dead = false;
    }
}

impl CellPipelines {
    pub(super) fn new(device: &Device, uniforms: &wgpu::BindGroupLayout) -> Self {
        let content_layout = content_layout(device);
        let program = Program::new(device, "cells", include_str!("cells.wgsl"), &[uniforms, &content_layout]);
        let states = [(false, false), (false, true), (true, false), (true, true)];
        let states = states.map(|(blended, depth_write)| fixed_state(blended, depth_write));
        let corners = bytemuck::cast_slice(&CellSheet::TRIANGLES);
        Self {
            pipelines: PipelineSet::new(device, &program, STAGES, states),
            content_layout,
            corners: device.buffer("corners of cells", wgpu::BufferUsages::VERTEX, corners),
            values: HashMap::new(),
            palettes: Derived::default(),
        }
    }

    /// Drops the textures whose cells were gone at the last call; those gone since then may be reused.
    pub(super) fn forget_dead(&mut self) {
        self.palettes.forget_dead();
        self.values.retain(|_, uploaded| {
            let is_dead = uploaded.cells.strong_count() == 0;
            !(is_dead && std::mem::replace(&mut uploaded.was_dead, is_dead))
        });
    }

    pub(super) fn prepare(&mut self, context: &mut DrawContext<'_>, sheet: &CellSheet) -> Option<InstancedDraw> {
        let device = context.device;
        let (values, layers) = self.values(device, &sheet.cells)?;
        let palette = self.palettes.get(&sheet.palette, |palette| upload_palette(device, palette));
        let content = device.wgpu.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("cells"),
            layout: &self.content_layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&values) },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(palette) },
            ],
        });
        let slot = context.uniforms.push(&Sheet {
            clip_from_object: context.clip_from_object(),
            size: layers.size.map(|side| side as f32),
            layer_side: layers.side,
            layer_columns: layers.columns,
            alpha: sheet.alpha,
            padding: [0.0; 3],
        });
        let state = fixed_state(sheet.blending == Blending::Alpha, sheet.depth_write);
        let pipelines = self.pipelines.get(device, state, &context.outputs);
        let instances = vec![Instances { buffer: self.corners.clone(), count: 1, offsets: [0; 2] }];
        Some(InstancedDraw { pipelines, slot, images: Some(content), vertices: 6, instances })
    }

    /// The texture with the values of cells.
    fn values(&mut self, device: &Device, cells: &Arc<Cells>) -> Option<(wgpu::TextureView, Layers)> {
        let address = Arc::as_ptr(cells) as usize;
        if !self.values.contains_key(&address) {
            let layers = Layers::of(cells, &device.limits)?;
            let left_over = |(address, uploaded): (&usize, &Uploaded)| {
                (uploaded.cells.strong_count() == 0 && uploaded.layers == layers).then_some(*address)
            };
            let left_over = self.values.iter().find_map(left_over).and_then(|address| self.values.remove(&address));
            let mut uploaded = match left_over {
                Some(uploaded) => uploaded,
                None => Uploaded::new(device, cells)?,
            };
            uploaded.fill(device, cells);
            self.values.insert(address, uploaded);
        }
        let uploaded = self.values.get(&address)?;
        let view = uploaded.texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        Some((view, uploaded.layers))
    }
}

fn upload_palette(device: &Device, palette: &[[u8; 4]; 256]) -> wgpu::TextureView {
    let size = wgpu::Extent3d { width: 256, height: 1, depth_or_array_layers: 1 };
    let texture = device.texture("palette", size, 1, wgpu::TextureFormat::Rgba8Unorm);
    device.write_texture(texture.as_image_copy(), bytemuck::cast_slice(palette), size);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

fn content_layout(device: &Device) -> wgpu::BindGroupLayout {
    let texture = |binding, sample_type, view_dimension| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Texture { sample_type, view_dimension, multisampled: false },
        count: None,
    };
    device.wgpu.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("cells"),
        entries: &[
            texture(0, wgpu::TextureSampleType::Uint, wgpu::TextureViewDimension::D2Array),
            texture(1, wgpu::TextureSampleType::Float { filterable: false }, wgpu::TextureViewDimension::D2),
        ],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_are_as_small_as_their_number_allows() {
        let limits = wgpu::Limits::downlevel_webgl2_defaults();
        let of = |width, height, max_side| {
            let limits = wgpu::Limits { max_texture_dimension_2d: max_side, ..limits.clone() };
            Layers::of(&Cells::new(width, height, &[]), &limits).map(|layers| (layers.side, layers.count))
        };
        assert_eq!(of(60, 40, 2048), Some((1024, 1)));
        assert_eq!(of(8000, 8000, 2048), Some((1024, 64)));
        assert_eq!(of(16385, 16385, 2048), Some((2048, 81)));
        assert_eq!(of(65536, 65536, 2048), None);
        assert_eq!(of(65536, 65536, 16384), Some((4096, 256)));
        assert_eq!(of(0, 40, 2048), None);
    }
}
