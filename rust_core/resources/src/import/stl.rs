//! STL, binary and text.
//!
//! As in Assimp: a file is binary when its size matches the triangle count in its header, even if the header begins
//! with "solid"; the normals are the file's, one for each face, unless one of them is zero or not a number; colours are
//! not used. Each `solid` of a text file is a part. Beyond Assimp, bytes after a binary file's last triangle are
//! ignored.

use super::{
    imported::{Faces, Imported, Polygons},
    lenient_float::three,
};
use crate::MeshFault;

const HEADER_BYTES: usize = 84;
const FACE_BYTES: usize = 50;

/// Reads an STL file.
pub(super) fn read(bytes: &[u8]) -> Result<Imported, MeshFault> {
    let announced = announced_faces(bytes);
    let needed = announced.map(|faces| HEADER_BYTES as u64 + u64::from(faces) * FACE_BYTES as u64);
    let size = bytes.len() as u64;
    if needed == Some(size) {
        return read_binary(bytes);
    }
    let text = rcs_text::decode(bytes);
    if is_text(text.as_bytes()) {
        return read_text(&text);
    }
    match (announced, needed) {
        (Some(0), _) | (None, _) | (_, None) => Err(MeshFault::NotStl),
        (Some(_), Some(needed)) if needed < size => {
            log::debug!("{} bytes after the last triangle of an STL file are ignored", size - needed);
            read_binary(bytes)
        }
        (Some(announced), Some(_)) => {
            Err(MeshFault::TruncatedStl { announced, present: (size - HEADER_BYTES as u64) / FACE_BYTES as u64 })
        }
    }
}

/// The triangle count of a binary file's header.
fn announced_faces(bytes: &[u8]) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(80..HEADER_BYTES)?.try_into().ok()?))
}

/// `true` for a beginning of text: "solid" without a NUL after it.
fn is_text(bytes: &[u8]) -> bool {
    let start = bytes.trim_ascii_start();
    start.starts_with(b"solid") && !start.iter().take(500).any(|&byte| byte == 0)
}

fn read_binary(bytes: &[u8]) -> Result<Imported, MeshFault> {
    let faces = announced_faces(bytes).ok_or(MeshFault::NotStl)? as usize;
    if faces == 0 {
        return Err(MeshFault::Empty);
    }
    let body = bytes.get(HEADER_BYTES..).ok_or(MeshFault::NotStl)?;
    let mut mesh = Polygons {
        positions: Vec::with_capacity(3 * faces.min(body.len() / FACE_BYTES)),
        normals: Vec::with_capacity(faces.min(body.len() / FACE_BYTES)),
        faces: Faces::Triangles,
        ..Polygons::default()
    };
    for face in body.chunks_exact(FACE_BYTES).take(faces) {
        let mut vectors = face.chunks_exact(12).map(|vector| {
            let mut numbers = vector.chunks_exact(4).map(|b| b.try_into().map_or(f32::NAN, f32::from_le_bytes));
            [(); 3].map(|()| numbers.next().unwrap_or(f32::NAN))
        });
        let normal = vectors.next().unwrap_or([0.0; 3]);
        mesh.positions.extend(vectors.take(3));
        mesh.normals.push(normal);
    }
    Ok(Imported::untransformed(vec![mesh], Vec::new()))
}

fn read_text(text: &str) -> Result<Imported, MeshFault> {
    let mut solids = Vec::new();
    let mut solid = empty_solid();
    let mut normal = [0.0; 3];
    // Corners of the current facet.
    let mut corners: Vec<[f32; 3]> = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let mut words = line.split_ascii_whitespace().peekable();
        // Several statements may stand on one line.
        while let Some(word) = words.next() {
            let bad = |what: &str| MeshFault::Line { line: number + 1, what: what.to_owned() };
            match word {
                "facet" => {
                    normal = [0.0; 3];
                    if words.next_if_eq(&"normal").is_some() {
                        normal = three(&mut words).ok_or_else(|| bad("a facet normal of three numbers is expected"))?;
                    }
                    corners.clear();
                }
                "vertex" => {
                    let corner = three(&mut words).ok_or_else(|| bad("a vertex of three numbers is expected"))?;
                    corners.push(corner);
                    if corners.len() == 3 {
                        solid.positions.append(&mut corners);
                        solid.normals.push(normal);
                    } else if corners.len() > 3 {
                        return Err(bad("a facet has more than three vertices"));
                    }
                }
                "endsolid" => {
                    if !solid.positions.is_empty() {
                        solids.push(std::mem::replace(&mut solid, empty_solid()));
                    }
                    skip_name(&mut words);
                }
                "solid" => skip_name(&mut words),
                _ => {}
            }
        }
    }
    if !solid.positions.is_empty() {
        solids.push(solid);
    }
    Ok(Imported::untransformed(solids, Vec::new()))
}

/// Skips a solid's name, which may be any words, up to the statement after it on the same line.
fn skip_name<'a>(words: &mut std::iter::Peekable<impl Iterator<Item = &'a str>>) {
    while words.next_if(|word| !matches!(*word, "facet" | "solid")).is_some() {}
}

fn empty_solid() -> Polygons {
    Polygons { faces: Faces::Triangles, ..Polygons::default() }
}
