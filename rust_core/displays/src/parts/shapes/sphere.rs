//! The sphere: an icosahedron with its poles on the z axis, each face divided into 36 by equal angles.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;
use rcs_scene::{Mesh, Vertex};

const ROWS: usize = 6;
const RADIUS: f64 = 0.5;

/// rviz's sphere: a normal at each corner that is the mean of its faces' normals, weighted by their angles there.
pub(super) fn sphere() -> Mesh {
    let mut places: HashMap<[i64; 3], u32> = HashMap::new();
    let mut directions: Vec<Vector3<f64>> = Vec::new();
    let mut indices = Vec::new();
    for [apex, left, right] in faces() {
        let mut corner = |row: usize, column: usize| {
            let direction = if row == 0 {
                apex
            } else {
                let ends = [left, right].map(|end| between(apex, end, row as f64 / ROWS as f64));
                between(ends[0], ends[1], column as f64 / row as f64)
            };
            let key = direction.map(|c| (c * 1e6).round() as i64).into();
            *places.entry(key).or_insert_with(|| {
                directions.push(direction);
                directions.len() as u32 - 1
            })
        };
        for row in 0..ROWS {
            for column in 0..=row {
                indices.extend([corner(row, column), corner(row + 1, column), corner(row + 1, column + 1)]);
                if column < row {
                    indices.extend([corner(row, column), corner(row + 1, column + 1), corner(row, column + 1)]);
                }
            }
        }
    }
    let mut normals = vec![Vector3::zeros(); directions.len()];
    for face in indices.chunks_exact(3) {
        let corners = [face[0], face[1], face[2]].map(|i| directions[i as usize]);
        for i in 0..3 {
            let (a, b) = (corners[(i + 1) % 3] - corners[i], corners[(i + 2) % 3] - corners[i]);
            normals[face[i] as usize] += a.cross(&b).normalize() * a.angle(&b);
        }
    }
    let vertices = directions.iter().zip(&normals).map(|(direction, normal)| Vertex {
        uv: [(0.5 + direction.y.atan2(direction.x) / TAU) as f32, (direction.z.acos() / PI) as f32],
        ..Vertex::new((direction * RADIUS).cast().into(), normal.normalize().cast().into())
    });
    Mesh { vertices: vertices.collect(), indices }
}

/// The twenty faces, counter-clockwise from outside, the corner first from which the rows are counted.
fn faces() -> Vec<[Vector3<f64>; 3]> {
    let at =
        |polar: f64, azimuth: f64| Vector3::new(polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos());
    let tilt = 2.0_f64.atan();
    let upper = |k: usize| at(tilt, TAU * k as f64 / 5.0);
    let lower = |k: usize| at(PI - tilt, TAU * (k as f64 + 0.5) / 5.0);
    let (north, south) = (Vector3::z(), -Vector3::z());
    (0..5)
        .flat_map(|k| {
            [
                [north, upper(k), upper(k + 1)],
                [south, lower(k + 1), lower(k)],
                [lower(k), upper(k + 1), upper(k)],
                [upper(k + 1), lower(k), lower(k + 1)],
            ]
        })
        .collect()
}

/// Direction at a share of the arc between two.
fn between(from: Vector3<f64>, to: Vector3<f64>, share: f64) -> Vector3<f64> {
    let angle = from.angle(&to);
    if angle < 1e-9 {
        return from;
    }
    ((from * ((1.0 - share) * angle).sin() + to * (share * angle).sin()) / angle.sin()).normalize()
}
