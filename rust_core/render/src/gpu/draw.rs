//! The draws of an image, recorded once for each of its passes.

use super::geometry::Instances;
use super::pipeline::{ByPass, Pass};
use super::triangles::TrianglesDraw;

/// Instances of a few vertices each, such as points or the glyphs of a text, in one image.
pub(super) struct InstancedDraw {
    pub(super) pipelines: ByPass<wgpu::RenderPipeline>,
    /// The offset of its constants among the uniforms.
    pub(super) slot: u32,
    pub(super) images: Option<wgpu::BindGroup>,
    /// Vertices of an instance.
    pub(super) vertices: u32,
    pub(super) instances: Vec<Instances>,
}

/// One drawable in one image.
pub(super) enum Draw {
    Instanced(InstancedDraw),
    Triangles(TrianglesDraw),
}

impl Draw {
    fn pipelines(&self) -> &ByPass<wgpu::RenderPipeline> {
        match self {
            Self::Instanced(draw) => &draw.pipelines,
            Self::Triangles(draw) => &draw.pipelines,
        }
    }
}

impl InstancedDraw {
    fn record(&self, pass: &mut wgpu::RenderPass<'_>, uniforms: &wgpu::BindGroup) {
        pass.set_bind_group(0, uniforms, &[self.slot]);
        if let Some(images) = &self.images {
            pass.set_bind_group(1, images, &[]);
        }
        for instances in &self.instances {
            for (slot, offset) in (0..).zip(instances.offsets) {
                pass.set_vertex_buffer(slot, instances.buffer.slice(offset..));
            }
            pass.draw(0..self.vertices, 0..instances.count);
        }
    }
}

/// Records those of the draws that have a part in a pass.
pub(super) fn record(
    draws: &[Draw],
    kind: Pass,
    pass: &mut wgpu::RenderPass<'_>,
    (uniforms, instances): (&wgpu::BindGroup, &wgpu::Buffer),
) {
    let (mut last_pipeline, mut previous) = (None, None);
    for draw in draws {
        let Some(pipeline) = &draw.pipelines()[kind as usize] else { continue };
        if last_pipeline.replace(pipeline) != Some(pipeline) {
            pass.set_pipeline(pipeline);
        }
        match draw {
            Draw::Instanced(draw) => draw.record(pass, uniforms),
            Draw::Triangles(draw) => draw.record(pass, uniforms, instances, previous),
        }
        previous = match draw {
            Draw::Triangles(draw) => Some(draw),
            _ => None,
        };
    }
}
