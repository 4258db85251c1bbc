//! Images on surfaces: textures with the mipmaps that OpenGL drivers make.

use rcs_scene::{Filtering, Texture, Wrapping};

use super::device::Device;

/// A bind group with an image and the way it is read.
pub(super) fn upload(device: &Device, layout: &wgpu::BindGroupLayout, texture: &Texture) -> wgpu::BindGroup {
    let levels = levels(texture, device.limits.max_texture_dimension_2d);
    let format = wgpu::TextureFormat::Rgba8Unorm;
    let gpu_texture = device.texture("image", extent(&levels[0]), levels.len() as u32, format);
    for (mip_level, level) in (0..).zip(&levels) {
        let to = wgpu::TexelCopyTextureInfo { mip_level, ..gpu_texture.as_image_copy() };
        device.write_texture(to, bytemuck::cast_slice(&level.rgba), extent(level));
    }
    let filter = match texture.filtering {
        Filtering::Nearest => wgpu::FilterMode::Nearest,
        Filtering::Bilinear | Filtering::BilinearMipmap => wgpu::FilterMode::Linear,
    };
    let wrap = match texture.wrapping {
        Wrapping::Repeat => wgpu::AddressMode::Repeat,
        Wrapping::Clamp => wgpu::AddressMode::ClampToEdge,
    };
    let sampler = device.wgpu.create_sampler(&wgpu::SamplerDescriptor {
        address_mode_u: wrap,
        address_mode_v: wrap,
        mag_filter: filter,
        min_filter: filter,
        ..Default::default()
    });
    device.wgpu.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("image"),
        layout,
        entries: &[
            wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(
                    &gpu_texture.create_view(&wgpu::TextureViewDescriptor::default()),
                ),
            },
            wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::Sampler(&sampler) },
        ],
    })
}

/// The layout of [`upload`]'s bind groups.
pub(super) fn layout(device: &Device) -> wgpu::BindGroupLayout {
    device.wgpu.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("image"),
        entries: &[
            wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::FRAGMENT,
                ty: wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Float { filterable: true },
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                },
                count: None,
            },
            wgpu::BindGroupLayoutEntry {
                binding: 1,
                visibility: wgpu::ShaderStages::FRAGMENT,
                ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
                count: None,
            },
        ],
    })
}

fn extent(level: &Texture) -> wgpu::Extent3d {
    wgpu::Extent3d { width: level.width, height: level.height, depth_or_array_layers: 1 }
}

/// The image, halved until it fits, and its mipmaps where it is read with them.
fn levels(texture: &Texture, max_side: u32) -> Vec<Texture> {
    let mut level = texture.clone();
    (level.width, level.height) = (level.width.max(1), level.height.max(1));
    level.rgba.resize(level.width as usize * level.height as usize, [255; 4]);
    while level.width.max(level.height) > max_side {
        let Some(smaller) = level.halved() else { break };
        level = smaller;
    }
    let has_mipmaps = texture.filtering == Filtering::BilinearMipmap;
    std::iter::successors(Some(level), |last| has_mipmaps.then(|| last.halved()).flatten()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture(width: u32, height: u32, filtering: Filtering) -> Texture {
        let rgba = (0..width * height).map(|i| [i as u8 * 10; 4]).collect();
        Texture { width, height, rgba, filtering, wrapping: Wrapping::Repeat }
    }

    #[test]
    fn without_mipmaps_there_is_one_level_and_a_large_image_is_made_to_fit() {
        let levels = levels(&texture(5, 3, Filtering::Bilinear), 2);
        assert_eq!(levels.iter().map(|l| (l.width, l.height)).collect::<Vec<_>>(), [(2, 1)]);
    }

    #[test]
    fn missing_texels_are_white() {
        let mut texture = texture(2, 2, Filtering::Nearest);
        texture.rgba.truncate(1);
        assert_eq!(levels(&texture, 64)[0].rgba, [[0; 4], [255; 4], [255; 4], [255; 4]]);
    }
}
