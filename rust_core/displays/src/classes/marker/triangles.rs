//! TRIANGLE_LIST: triangles that are seen from both sides.
//!
//! In one colour they are lit, each by the normal of its winding, whichever side is visible. With a colour for each
//! vertex or each triangle they are not lit. Blending follows rviz: with colours of vertices the vertices' alpha
//! decides, else the marker's, although both are multiplied.
//!
//! A list that is sent again with as many points keeps the vertex format that it began with: if that had no colours,
//! those that come later are not shown, and the triangles are white.

use std::sync::Arc;

use nalgebra::{Matrix4, Vector3};
use rcs_messages::std_msgs::ColorRGBA;
use rcs_messages::visualization_msgs::Marker;
use rcs_scene::{CullMode, Material, Mesh, Vertex};

use super::message_fields::{point_colors, position, rgba, scale};
use super::primitive::Primitive;

/// State of a triangle list between messages.
#[derive(Clone, Debug, Default)]
pub(super) struct TriangleMarker {
    points: usize,
    colored: bool,
}

impl TriangleMarker {
    pub(super) fn primitives(&mut self, marker: &Marker) -> Vec<Primitive> {
        if self.points != marker.points.len() {
            self.points = marker.points.len();
            self.colored = !marker.colors.is_empty();
        }
        primitives(marker, self.colored)
    }
}

/// All triangles with finite corners.
fn primitives(marker: &Marker, colored: bool) -> Vec<Primitive> {
    let vertex_colors = point_colors(marker);
    let face_colors = (marker.colors.len() == marker.points.len() / 3).then_some(&marker.colors);
    let color = |face: usize, corner: usize| {
        let own = match (vertex_colors, face_colors) {
            (Some(colors), _) => colors.get(3 * face + corner),
            (None, Some(colors)) => colors.get(face),
            (None, None) => None,
        };
        own.filter(|_| colored).map_or([255; 4], |own| rgba(own).with_alpha(marker.color.a * own.a).to_rgba8())
    };
    let mut vertices = Vec::with_capacity(marker.points.len());
    for (face, points) in marker.points.chunks_exact(3).enumerate() {
        let corners = [0, 1, 2].map(|i| Vector3::from(position(&points[i])));
        let across = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        if !corners.iter().chain([&across]).all(|vector| vector.iter().all(|value| value.is_finite())) {
            continue;
        }
        let normal = across.try_normalize(f32::MIN_POSITIVE).unwrap_or_default().into();
        for (i, corner) in corners.into_iter().enumerate() {
            vertices.push(Vertex { color: color(face, i), ..Vertex::new(corner.into(), normal) });
        }
    }
    let blends = |color: &ColorRGBA| color.a < Material::OPAQUE_FROM_ALPHA;
    let is_translucent = vertex_colors.map_or(blends(&marker.color), |colors| colors.iter().any(blends));
    let material = if vertex_colors.is_some() || face_colors.is_some() {
        Material::unlit(is_translucent)
    } else {
        Material::lit(rgba(&marker.color))
    };
    let mesh = Mesh { indices: (0..vertices.len() as u32).collect(), vertices };
    let marker_from_triangles = Matrix4::new_nonuniform_scaling(&scale(marker).into());
    vec![Primitive::mesh(marker_from_triangles, Arc::new(mesh), Material { cull: CullMode::None, ..material })]
}
