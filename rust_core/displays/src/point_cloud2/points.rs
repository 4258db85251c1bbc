//! A cloud's bytes as positions and colours.

use rcs_messages::PointCloud2;
use rcs_scene::{PointBuffer, PointColors};

use super::color::{Coloring, PointColor};
use super::fields::Layout;

/// Reads the points whose position is finite.
pub(crate) fn read(cloud: &PointCloud2, layout: &Layout, coloring: &Coloring<'_>) -> PointBuffer {
    let mut positions = Vec::with_capacity(layout.point_count);
    let mut points: Vec<&[u8]> = Vec::new();
    let needs_bytes = coloring.needs_bytes();
    if needs_bytes {
        points.reserve(layout.point_count);
    }
    let [x, y, z] = &layout.position;
    for point in cloud.data().chunks_exact(layout.point_step.max(1)) {
        let position = [x, y, z].map(|channel| f32::from_bits(channel.bits(point, cloud.is_bigendian)));
        if position.iter().all(|value| value.is_finite()) {
            positions.push(position);
            if needs_bytes {
                points.push(point);
            }
        }
    }
    let colors = match coloring.prepare(layout, cloud.is_bigendian, &points, &positions) {
        PointColor::Uniform(color) => PointColors::Uniform(color),
        PointColor::PerPoint(colors) => PointColors::PerPoint(colors),
    };
    PointBuffer { positions, colors }
}
