//! The draws of a picture, recorded once for each of its passes.

use super::cells::CellsDraw;
use super::lines::LinesDraw;
use super::pipeline::{ByPass, Pass};
use super::points::PointsDraw;
use super::text::TextDraw;
use super::triangles::TrianglesDraw;

/// One drawable in one picture.
pub(super) enum Draw {
    Points(PointsDraw),
    Lines(LinesDraw),
    Triangles(TrianglesDraw),
    Text(TextDraw),
    Cells(CellsDraw),
}

impl Draw {
    fn pipelines(&self) -> &ByPass<wgpu::RenderPipeline> {
        match self {
            Self::Points(draw) => &draw.pipelines,
            Self::Lines(draw) => &draw.pipelines,
            Self::Triangles(draw) => &draw.pipelines,
            Self::Text(draw) => &draw.pipelines,
            Self::Cells(draw) => &draw.pipelines,
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
            Draw::Points(draw) => draw.record(pass, uniforms),
            Draw::Lines(draw) => draw.record(pass, uniforms),
            Draw::Triangles(draw) => draw.record(pass, uniforms, instances, previous),
            Draw::Text(draw) => draw.record(pass, uniforms),
            Draw::Cells(draw) => draw.record(pass, uniforms),
        }
        previous = match draw {
            Draw::Triangles(draw) => Some(draw),
            _ => None,
        };
    }
}
