//! POINTS, CUBE_LIST and SPHERE_LIST: point clouds.
//!
//! Points are rviz's squares, cubes its boxes and spheres its shaded discs, all of one size. rviz puts such a cloud
//! into Ogre's queue twice, once itself and once through its parts, so that a translucent list is drawn over itself.
//! The marker's alpha counts twice within each drawing: it is in the points' colours and the whole cloud's.

use std::sync::Arc;

use rcs_messages::visualization_msgs::Marker;
use rcs_scene::{Geometry, Material, PointBuffer, PointColors, PointStyle, Points};

use super::message_fields::{point_colors, position, rgba, scale};
use super::primitive::Primitive;
use crate::parts::cloud::max_points;

/// The cloud of the finite points, in rviz's pieces.
pub(super) fn primitives(marker: &Marker) -> Vec<Primitive> {
    let Some(style) = style(marker) else { return Vec::new() };
    let max_points = max_points(&style);
    let colors = point_colors(marker);
    let whole_color = rgba(&marker.color);
    let (alpha, blended) = match colors {
        Some(colors) => (1.0, colors.iter().any(|color| color.a != 1.0)),
        None => (whole_color.a, whole_color.a < Material::OPAQUE_FROM_ALPHA),
    };
    let mut parts = Vec::new();
    for (chunk, points) in marker.points.chunks(max_points).enumerate() {
        let first = chunk * max_points;
        let mut positions = Vec::with_capacity(points.len());
        let mut point_colors = Vec::new();
        for (i, point) in points.iter().enumerate() {
            let position = position(point);
            if position.iter().all(|value| value.is_finite()) {
                positions.push(position);
                point_colors
                    .extend(colors.and_then(|colors| colors.get(first + i)).map(|color| rgba(color).to_rgba8()));
            }
        }
        let sorted_by = positions.clone();
        let colors = match colors {
            Some(_) => PointColors::PerPoint(point_colors),
            None => PointColors::Uniform(whole_color.to_rgba8()),
        };
        let buffer = Arc::new(PointBuffer { positions, colors });
        let part = Primitive::sorted_by_middle(
            sorted_by,
            Geometry::Points(Points { buffer, style, alpha, blended, auto_size: false }),
        );
        if blended {
            parts.push(part.clone());
        }
        parts.push(part);
    }
    parts
}

/// Style of the points. `None` for squares and discs that one negative side turns away from the eye.
fn style(marker: &Marker) -> Option<PointStyle> {
    let size_m = scale(marker).map(|side| side as f32);
    if u8::try_from(marker.type_) == Ok(Marker::CUBE_LIST) {
        return Some(PointStyle::Boxes { size_m });
    }
    let [width_m, height_m, _] = size_m;
    let is_turned_away = width_m * height_m < 0.0;
    let size_m = [width_m.abs(), height_m.abs()];
    (!is_turned_away).then_some(if u8::try_from(marker.type_) == Ok(Marker::SPHERE_LIST) {
        PointStyle::Spheres { size_m }
    } else {
        PointStyle::Squares { size_m }
    })
}
