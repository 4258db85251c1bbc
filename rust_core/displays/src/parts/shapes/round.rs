//! Cylinder and cone: forty segments around the y axis.

use std::f32::consts::TAU;

use nalgebra::Vector3;
use rcs_scene::{Mesh, Vertex};

const SEGMENTS: u32 = 40;
const RADIUS: f32 = 0.5;

fn angle(segment: f32) -> f32 {
    TAU * segment / SEGMENTS as f32
}

fn ring(segment: f32, y: f32) -> [f32; 3] {
    let angle = angle(segment);
    [RADIUS * angle.cos(), y, RADIUS * angle.sin()]
}

/// Texture coordinate at the end of a segment; it begins at three quarters.
fn around(segment: u32) -> f32 {
    ((segment + SEGMENTS * 3 / 4 + 1) % SEGMENTS) as f32 / SEGMENTS as f32
}

/// A disc at a height, facing up or down (`up` is 1 or −1). rviz gives it the texture's edge row.
fn cap(mesh: &mut Mesh, y: f32, up: f32) {
    let base = mesh.vertices.len() as u32;
    let v = y + 0.5;
    mesh.vertices.push(Vertex { uv: [0.5, v], ..Vertex::new([0.0, y, 0.0], [0.0, up, 0.0]) });
    for segment in 0..SEGMENTS {
        let (here, next) = (base + 1 + 2 * segment, base + 2 + 2 * segment);
        let ends = [(segment, around(segment) - 1.0 / SEGMENTS as f32), (segment + 1, around(segment))];
        mesh.vertices
            .extend(ends.map(|(end, u)| Vertex { uv: [u, v], ..Vertex::new(ring(end as f32, y), [0.0, up, 0.0]) }));
        mesh.indices.extend(if up > 0.0 { [base, next, here] } else { [base, here, next] });
    }
}

/// Smooth around, with flat caps. The diagonal of a side's quad falls from its top to the next one's bottom.
pub(super) fn cylinder() -> Mesh {
    let mut mesh = Mesh::default();
    cap(&mut mesh, -0.5, -1.0);
    cap(&mut mesh, 0.5, 1.0);
    let base = mesh.vertices.len() as u32;
    for segment in 0..=SEGMENTS {
        let segment = segment as f32;
        let angle = angle(segment);
        let (normal, u) = ([angle.cos(), 0.0, angle.sin()], 0.75 + segment / SEGMENTS as f32);
        for y in [-0.5, 0.5] {
            mesh.vertices.push(Vertex { uv: [u, y + 0.5], ..Vertex::new(ring(segment, y), normal) });
        }
    }
    for segment in 0..SEGMENTS {
        let [bottom, top, next_bottom, next_top] = [0, 1, 2, 3].map(|i| base + 2 * segment + i);
        mesh.indices.extend([top, next_bottom, bottom, top, next_top, next_bottom]);
    }
    mesh
}

/// Smooth around the base; each side triangle has a normal of its own at the apex.
pub(super) fn cone() -> Mesh {
    let mut mesh = Mesh::default();
    cap(&mut mesh, -0.5, -1.0);
    let slope = |angle: f32, outwards: f32| {
        Vector3::new(outwards * angle.cos(), 1.0, outwards * angle.sin()).normalize().into()
    };
    // The normal of the flat triangle between two segments: the base's edge is nearer to the axis than the circle.
    let face_outwards = 2.0 / (angle(0.5).cos());
    for segment in 0..SEGMENTS {
        let base = mesh.vertices.len() as u32;
        let (here, middle, next) = (segment as f32, segment as f32 + 0.5, segment as f32 + 1.0);
        mesh.vertices.extend([
            Vertex::new([0.0, 0.5, 0.0], slope(angle(middle), face_outwards)),
            Vertex::new(ring(next, -0.5), slope(angle(next), 2.0)),
            Vertex::new(ring(here, -0.5), slope(angle(here), 2.0)),
        ]);
        mesh.indices.extend([base, base + 1, base + 2]);
    }
    mesh
}
