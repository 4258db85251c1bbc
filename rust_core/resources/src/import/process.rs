//! Assimp's processing of a mesh after reading, for the flags that rviz sets.
//!
//! In this order: v of the texture coordinates is flipped to point down; polygons are cut into triangles; points, lines
//! and triangles of one mesh become separate meshes; coordinates that are not numbers, or all equal, are dropped, and
//! so are all normals of a mesh if one of them is zero or not a number; triangles without normals get face normals
//! (`aiProcess_GenNormals` does not smooth; a shared vertex has the last face's). Vertices are never merged.

use super::{
    imported::{Faces, Polygons},
    triangulate::Triangulation,
    vectors::{cross, minus, normalized},
};

/// A mesh of one kind of primitive.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PrimitiveMesh {
    pub(crate) positions: Vec<[f32; 3]>,
    /// Normals of the positions or, without indices, of the triangles; may be empty for points and lines.
    pub(crate) normals: Vec<[f32; 3]>,
    /// Texture coordinates of the positions, v down; may be empty.
    pub(crate) uvs: Vec<[f32; 2]>,
    /// Three for each triangle; `None` for the positions in their order. For points and lines too, because rviz passes
    /// all indices to Ogre, which draws triangles.
    pub(crate) indices: Option<Vec<u32>>,
}

impl PrimitiveMesh {
    /// The normal of a corner.
    pub(crate) fn normal(&self, corner: usize) -> Option<&[f32; 3]> {
        self.normals.get(if self.indices.is_some() { corner } else { corner / 3 })
    }
}

/// A mesh as Assimp passes it to rviz: up to three meshes of points, lines and triangles. `triangulation` is shared by
/// all meshes of the file.
pub(crate) fn process(polygons: Polygons, triangulation: &mut Triangulation) -> Vec<PrimitiveMesh> {
    let face_sizes = match &polygons.faces {
        Faces::Sizes(face_sizes) => face_sizes,
        Faces::Triangles => return finish(whole(polygons, None), true).into_iter().collect(),
    };
    let mut by_kind: [Vec<u32>; 3] = Default::default();
    let [points, lines, triangles] = &mut by_kind;
    let mut start = 0_usize;
    let (mut face, mut corners) = (Vec::new(), Vec::new());
    for &size in face_sizes {
        let end = start + size as usize;
        face.clear();
        match &polygons.corners {
            Some(shared) => face.extend_from_slice(shared.get(start..end).unwrap_or_default()),
            None if end <= polygons.positions.len() => face.extend(start as u32..end as u32),
            None => {}
        }
        match face.as_slice() {
            [] => {}
            [_] => points.extend(&face),
            [_, _] => lines.extend(&face),
            [_, _, _] => triangles.extend(&face),
            _ => {
                corners.clear();
                corners.extend(face.iter().filter_map(|&corner| polygons.positions.get(corner as usize)));
                let corner = |number: u32| face.get(number as usize).copied().unwrap_or_default();
                triangulation.cut(&corners, |triangle| triangles.extend(triangle.map(corner)));
            }
        }
        start = end;
    }
    let kinds = by_kind.iter().filter(|indices| !indices.is_empty()).count();
    let mut by_kind = by_kind.into_iter().enumerate().filter(|(_, indices)| !indices.is_empty());
    if kinds == 1 {
        let only = by_kind.next().map(|(kind, indices)| finish(whole(polygons, Some(indices)), kind == 2));
        return only.flatten().into_iter().collect();
    }
    by_kind.filter_map(|(kind, indices)| finish(unshared(&polygons, &indices), kind == 2)).collect()
}

/// All vertices, with the sharing of the file and the triangulation.
fn whole(polygons: Polygons, indices: Option<Vec<u32>>) -> PrimitiveMesh {
    let Polygons { positions, normals, mut uvs, .. } = polygons;
    uvs.iter_mut().for_each(|uv| *uv = flipped(*uv));
    PrimitiveMesh { positions, normals, uvs, indices }
}

/// The corners of some faces, with a vertex for each index.
fn unshared(polygons: &Polygons, indices: &[u32]) -> PrimitiveMesh {
    fn pick<T: Copy>(values: &[T], indices: &[u32]) -> Vec<T> {
        indices.iter().filter_map(|&i| values.get(i as usize).copied()).collect()
    }
    PrimitiveMesh {
        positions: pick(&polygons.positions, indices),
        normals: pick(&polygons.normals, indices),
        uvs: pick(&polygons.uvs, indices).into_iter().map(flipped).collect(),
        indices: Some((0..indices.len() as u32).collect()),
    }
}

fn flipped([u, v]: [f32; 2]) -> [f32; 2] {
    [u, 1.0 - v]
}

/// Drops invalid data and makes normals; `None` when nothing is left.
fn finish(mut mesh: PrimitiveMesh, is_triangles: bool) -> Option<PrimitiveMesh> {
    let count = mesh.positions.len();
    let used = match &mesh.indices {
        None => Used::All,
        Some(indices) => {
            let mut used = vec![false; count];
            for &index in indices {
                *used.get_mut(index as usize)? = true;
            }
            Used::Some(used)
        }
    };
    if !is_valid(&mesh.positions, &used, Demand::Different) {
        return None;
    }
    if mesh.uvs.len() != count || !is_valid(&mesh.uvs, &used, Demand::Different) {
        mesh.uvs = Vec::new();
    }
    let normal_count = if mesh.indices.is_some() { count } else { count / 3 };
    if mesh.normals.len() != normal_count || (is_triangles && !is_valid(&mesh.normals, &used, Demand::NonZero)) {
        mesh.normals = Vec::new();
    }
    if mesh.normals.is_empty() && is_triangles {
        mesh.normals = face_normals(&mesh);
    }
    // Of points and lines the last few may not make a triangle.
    let corners = match &mut mesh.indices {
        Some(indices) => {
            indices.truncate(indices.len() / 3 * 3);
            indices.len()
        }
        None => count,
    };
    (corners > 0).then_some(mesh)
}

/// The corners that a mesh uses.
enum Used {
    All,
    Some(Vec<bool>),
}

impl Used {
    fn contains(&self, corner: usize) -> bool {
        match self {
            Self::All => true,
            Self::Some(used) => used.get(corner).is_some_and(|used| *used),
        }
    }
}

/// Requirement on vectors in addition to being finite.
#[derive(Clone, Copy, PartialEq)]
enum Demand {
    /// Not all are equal.
    Different,
    /// None is zero.
    NonZero,
}

fn is_valid<const N: usize>(vectors: &[[f32; N]], used: &Used, demand: Demand) -> bool {
    let mut previous: Option<&[f32; N]> = None;
    let mut all_same = true;
    let mut count = 0_usize;
    for (corner, vector) in vectors.iter().enumerate() {
        if used.contains(corner) {
            count += 1;
            if vector.iter().any(|component| !component.is_finite()) {
                return false;
            }
            if demand == Demand::NonZero && vector.iter().all(|&component| component == 0.0) {
                return false;
            }
            all_same &= previous.is_none_or(|previous| previous == vector);
        }
        previous = Some(vector);
    }
    demand != Demand::Different || count < 2 || !all_same
}

/// The normal of each face at its corners; a shared corner has the last face's.
fn face_normals(mesh: &PrimitiveMesh) -> Vec<[f32; 3]> {
    let normal = |a, b, c| normalized(cross(minus(b, a), minus(c, a)));
    let Some(indices) = &mesh.indices else {
        let faces = mesh.positions.chunks_exact(3);
        return faces.map(|face| if let [a, b, c] = face { normal(a, b, c) } else { [0.0; 3] }).collect();
    };
    let mut normals = vec![[0.0; 3]; mesh.positions.len()];
    for face in indices.chunks_exact(3) {
        let corner = |i: usize| face.get(i).and_then(|&index| mesh.positions.get(index as usize));
        let (Some(a), Some(b), Some(c)) = (corner(0), corner(1), corner(2)) else { continue };
        let normal = normal(a, b, c);
        for &index in face {
            if let Some(slot) = normals.get_mut(index as usize) {
                *slot = normal;
            }
        }
    }
    normals
}
