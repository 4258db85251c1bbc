//! Faces of a primitive, by its mode, as in Assimp: faces with an invalid vertex index are dropped.

use crate::import::imported::strip_triangles;

/// The corners of all faces, and the number of corners of each face.
pub(super) type FaceCorners = (Vec<u32>, Vec<u32>);

/// The faces of a primitive of that mode: points (0), lines (1, 2, 3) or triangles (all others).
pub(super) fn faces(mode: u32, indices: &[u32], vertex_count: usize) -> FaceCorners {
    let mut faces: FaceCorners = Default::default();
    let mut add = |face: &[u32]| {
        if face.iter().all(|&corner| (corner as usize) < vertex_count) {
            faces.0.extend_from_slice(face);
            faces.1.push(face.len() as u32);
        }
    };
    match mode {
        0 => indices.chunks_exact(1).for_each(add),
        1 => indices.chunks_exact(2).for_each(add),
        2 | 3 => {
            indices.windows(2).for_each(&mut add);
            if let (2, [first, .., last]) = (mode, indices) {
                add(&[*last, *first]);
            }
        }
        5 => strip_triangles(indices).for_each(|face| add(&face)),
        6 => {
            if let [centre, rim @ ..] = indices {
                for edge in rim.windows(2) {
                    if let &[a, b] = edge {
                        add(&[*centre, a, b]);
                    }
                }
            }
        }
        _ => indices.chunks_exact(3).for_each(add),
    }
    faces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_mode_makes_its_faces() {
        let of = |mode| faces(mode, &[0, 1, 2, 3, 4], 5);
        assert_eq!(of(0), (vec![0, 1, 2, 3, 4], vec![1; 5]));
        assert_eq!(of(1), (vec![0, 1, 2, 3], vec![2; 2]));
        assert_eq!(of(2), (vec![0, 1, 1, 2, 2, 3, 3, 4, 4, 0], vec![2; 5]));
        assert_eq!(of(3), (vec![0, 1, 1, 2, 2, 3, 3, 4], vec![2; 4]));
        assert_eq!(of(4), (vec![0, 1, 2], vec![3]));
        assert_eq!(of(5), (vec![0, 1, 2, 2, 1, 3, 2, 3, 4], vec![3; 3]));
        assert_eq!(of(6), (vec![0, 1, 2, 0, 2, 3, 0, 3, 4], vec![3; 3]));
    }

    #[test]
    fn faces_with_a_vertex_that_does_not_exist_are_dropped() {
        assert_eq!(faces(4, &[0, 1, 2, 2, 3, 4], 4), (vec![0, 1, 2], vec![3]));
        for mode in 0..8 {
            for count in 0..3 {
                faces(mode, &[7; 3][..count], 0);
            }
        }
    }
}
