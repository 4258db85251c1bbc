//! LINE_STRIP and LINE_LIST: ribbons that face the eye, `scale.x` wide.
//!
//! The marker's alpha decides whether they blend; with an opaque marker the alpha of the points has no effect. The
//! other two scales have none either.

use std::sync::Arc;

use rcs_messages::visualization_msgs::Marker;
use rcs_scene::{Blending, Geometry, Material, RibbonElement, Ribbons};

use super::message_fields::{is_finite_color, point_colors, position, rgba};
use super::primitive::Primitive;

/// Elements of one chain of rviz; a longer strip has gaps between its chains.
const MAX_ELEMENTS: usize = 65536 / 4;

/// One line through all finite points.
pub(super) fn strip(marker: &Marker) -> Vec<Primitive> {
    let colors = point_colors(marker);
    let finite = |(i, element): (usize, RibbonElement)| {
        let color = colors.and_then(|colors| colors.get(i));
        (element.position.iter().all(|value| value.is_finite()) && color.is_none_or(is_finite_color)).then_some(element)
    };
    let elements: Vec<RibbonElement> = elements(marker).enumerate().filter_map(finite).collect();
    if elements.len() < marker.points.len() {
        let left_out = marker.points.len() - elements.len();
        log::warn!("marker {}/{}: {left_out} points or colors are not finite", marker.ns, marker.id);
    }
    elements.chunks(MAX_ELEMENTS).map(|chain| primitive(marker, vec![chain.to_vec()])).collect()
}

/// One line from each point to the next, then from the third to the fourth and so on.
pub(super) fn list(marker: &Marker) -> Vec<Primitive> {
    let elements: Vec<RibbonElement> = elements(marker).collect();
    let finite = |line: &&[RibbonElement]| line.iter().flat_map(|e| e.position).all(f32::is_finite);
    let lines: Vec<&[RibbonElement]> = elements.chunks_exact(2).filter(finite).collect();
    lines
        .chunks(MAX_ELEMENTS / 2)
        .map(|lines| primitive(marker, lines.iter().map(|line| line.to_vec()).collect()))
        .collect()
}

fn elements(marker: &Marker) -> impl Iterator<Item = RibbonElement> + '_ {
    let colors = point_colors(marker);
    marker.points.iter().enumerate().map(move |(i, point)| {
        let color = colors.and_then(|colors| colors.get(i)).unwrap_or(&marker.color);
        RibbonElement { position: position(point), color: rgba(color).to_rgba8() }
    })
}

fn primitive(marker: &Marker, chains: Vec<Vec<RibbonElement>>) -> Primitive {
    let is_translucent = marker.color.a < Material::OPAQUE_FROM_ALPHA;
    let blending = if is_translucent { Blending::Alpha } else { Blending::Replace };
    let positions: Vec<[f32; 3]> = chains.iter().flatten().map(|element| element.position).collect();
    let ribbons = Ribbons { chains, width_m: marker.scale.x as f32, blending };
    Primitive::sorted_by_middle(positions, Geometry::Ribbons(Arc::new(ribbons)))
}
