//! From imported meshes to drawable parts, as in rviz's mesh loader.
//!
//! Each instance of a mesh becomes a part, transformed by its nodes; normals are transformed by the same matrix, not by
//! the inverse transpose, so they are wrong under uneven scales, and normalized. Materials are opaque, with the diffuse
//! texture once for every texture of any kind that the file names.

use std::{
    collections::HashMap,
    hash::{BuildHasher, RandomState},
    sync::Arc,
};

use hashbrown::HashTable;
use nalgebra::{Matrix4, Vector3};
use rcs_scene::{Mesh, Rgba, Texture, Vertex};

use crate::{
    import::{normalized, process, Imported, MaterialSpec, MeshSource, PrimitiveMesh, Triangulation},
    texture::{self, layered},
    warning_texture, LoadedMesh, MeshMaterial, MeshPart, ResourceError,
};

/// OpenGL's initial normal, for a mesh (of lines or points) without normals.
const UNSET_NORMAL: [f32; 3] = [0.0, 0.0, 1.0];
/// Most texels of all textures of a mesh, 512 MB; further textures are left out.
const MAX_TEXELS: usize = 128 << 20;
/// Most textures of a mesh.
const MAX_TEXTURES: usize = 1000;

/// Makes the parts of a mesh; textures are searched for beside it.
pub(crate) fn assemble(imported: Imported, source: MeshSource<'_>) -> LoadedMesh {
    let Imported { meshes, materials: specs, placed, images, passed_over } = imported;
    let mut textures = MeshTextures { source, images, loaded: HashMap::new(), texels: 0, warnings: Vec::new() };
    let passed_over =
        passed_over.into_iter().map(|fault| ResourceError::PassedOver { path: source.path.to_owned(), fault });
    textures.warnings.extend(passed_over);
    let mut materials: HashMap<usize, MeshMaterial> = HashMap::new();
    let mut triangulation = Triangulation::new();
    let mut uses: HashMap<usize, usize> = HashMap::new();
    for placed in &placed {
        *uses.entry(placed.mesh).or_default() += 1;
    }
    let mut meshes: Vec<_> = meshes.into_iter().map(|polygons| (polygons.material, Some(polygons))).collect();
    let mut processed: HashMap<usize, Vec<PrimitiveMesh>> = HashMap::new();
    let mut parts = Vec::new();
    for placed in &placed {
        let Some((material_index, polygons)) = meshes.get_mut(placed.mesh) else { continue };
        let spec = specs.get(*material_index);
        let material = materials
            .entry(*material_index)
            .or_insert_with(|| spec.map_or(MeshMaterial::none(), |spec| material(spec, &mut textures)));
        let flat = spec.is_some_and(|spec| spec.flat);
        if let Some(polygons) = polygons.take() {
            processed.insert(placed.mesh, process(polygons, &mut triangulation));
        }
        let is_last = uses.get_mut(&placed.mesh).is_none_or(|left| {
            *left -= 1;
            *left == 0
        });
        for triangles in processed.get(&placed.mesh).map(Vec::as_slice).unwrap_or_default() {
            if let Some(mut mesh) = place(triangles, &placed.object_from_mesh, flat) {
                if placed.is_turned {
                    mesh.indices.as_chunks_mut::<3>().0.iter_mut().for_each(|triangle| triangle.swap(1, 2));
                }
                parts.push(MeshPart { mesh: Arc::new(mesh), material: material.clone() });
            }
        }
        // Frees the memory of a large mesh early.
        if is_last {
            processed.remove(&placed.mesh);
        }
    }
    LoadedMesh { parts, warnings: textures.warnings }
}

/// The triangles in the file's frame; `None` when the transform makes them infinite.
fn place(triangles: &PrimitiveMesh, object_from_mesh: &Matrix4<f32>, flat: bool) -> Option<Mesh> {
    let rotation = object_from_mesh.fixed_view::<3, 3>(0, 0).into_owned();
    let moved = *object_from_mesh != Matrix4::identity();
    let position = |i: usize| -> Option<[f32; 3]> {
        let &position = triangles.positions.get(i)?;
        Some(if moved {
            (rotation * Vector3::from(position) + object_from_mesh.fixed_view::<3, 1>(0, 3)).into()
        } else {
            position
        })
    };
    let normal = |i: usize| -> [f32; 3] {
        let normal = match triangles.normal(i) {
            Some(&normal) if moved => normalized((rotation * Vector3::from(normal)).into()),
            Some(&normal) => normalized(normal),
            None => UNSET_NORMAL,
        };
        if normal.iter().all(|component| component.is_finite()) {
            normal
        } else {
            [0.0; 3]
        }
    };
    let uv = |i: usize| triangles.uvs.get(i).copied().unwrap_or_default();
    let count = triangles.positions.len();
    if !(0..count).filter_map(position).flatten().all(f32::is_finite) {
        return None;
    }

    let mut welded = Welded::default();
    let indices = if flat {
        let corners = 0..triangles.indices.as_ref().map_or(count, Vec::len) / 3 * 3;
        let corner = |i: usize| match &triangles.indices {
            Some(indices) => indices.get(i).map(|&index| index as usize),
            None => Some(i),
        };
        let mut indices = Vec::with_capacity(corners.len());
        for first in corners.step_by(3) {
            let face = [first, first + 1, first + 2].map(|i| corner(i).filter(|&i| i < count));
            let [Some(a), Some(b), Some(c)] = face else { continue };
            // The normal of the last corner, as in OpenGL's flat shading.
            let normal = normal(c);
            for i in [a, b, c] {
                indices.push(welded.add(Vertex { uv: uv(i), ..Vertex::new(position(i)?, normal) }));
            }
        }
        indices
    } else {
        let mut new_index = Vec::with_capacity(count);
        for i in 0..count {
            new_index.push(welded.add(Vertex { uv: uv(i), ..Vertex::new(position(i)?, normal(i)) }));
        }
        match &triangles.indices {
            Some(indices) => indices.iter().filter_map(|&i| new_index.get(i as usize).copied()).collect(),
            None => new_index,
        }
    };
    Some(Mesh { vertices: welded.into_vertices(), indices })
}

/// Unique vertices. In a detailed mesh five corners in six equal another one, and each vertex is transformed for every
/// image.
#[derive(Default)]
struct Welded {
    vertices: Vec<Vertex>,
    /// Indices of the vertices by their contents, without a second copy of these.
    numbers: HashTable<u32>,
    hasher: RandomState,
}

impl Welded {
    /// The index of a vertex, which is added if it is new.
    fn add(&mut self, vertex: Vertex) -> u32 {
        let Self { vertices, numbers, hasher } = self;
        let key = bits(&vertex);
        let key_of = |&number: &u32| vertices.get(number as usize).map(bits);
        let rehash = |number: &u32| hasher.hash_one(key_of(number));
        let new = vertices.len() as u32;
        let number = *numbers
            .entry(hasher.hash_one(Some(key)), |number| key_of(number) == Some(key), rehash)
            .or_insert(new)
            .get();
        if number == new {
            vertices.push(vertex);
        }
        number
    }

    fn into_vertices(self) -> Vec<Vertex> {
        let mut vertices = self.vertices;
        drop(self.numbers);
        vertices.shrink_to_fit();
        vertices
    }
}

/// The contents of a vertex for comparison, without its colour, which is always white.
fn bits(vertex: &Vertex) -> [u32; 8] {
    let ([x, y, z], [nx, ny, nz], [u, v]) = (vertex.position, vertex.normal, vertex.uv);
    [x, y, z, nx, ny, nz, u, v].map(f32::to_bits)
}

fn material(spec: &MaterialSpec, textures: &mut MeshTextures<'_>) -> MeshMaterial {
    let color = |[r, g, b]: [f32; 3]| Rgba::new(r, g, b, 1.0);
    let texture = (spec.texture_count > 0).then(|| textures.get(&spec.diffuse_texture, spec.texture_count));
    MeshMaterial { embedded: true, diffuse: color(spec.diffuse), emissive: color(spec.emissive), texture }
}

/// The textures beside a mesh or in its file, each loaded once.
struct MeshTextures<'a> {
    source: MeshSource<'a>,
    /// Embedded images by name.
    images: HashMap<String, Vec<u8>>,
    /// Textures by name and number of layers.
    loaded: HashMap<(String, usize), Arc<Texture>>,
    /// Number of texels of all.
    texels: usize,
    warnings: Vec<ResourceError>,
}

impl MeshTextures<'_> {
    /// The texture of that name in `times` layers, or Ogre's warning texture and a warning.
    fn get(&mut self, name: &str, times: usize) -> Arc<Texture> {
        if let Some(texture) = self.loaded.get(&(name.to_owned(), times)) {
            return Arc::clone(texture);
        }
        let texture = match times {
            0 | 1 => self.load(name).unwrap_or_else(|error| {
                self.warnings.push(error);
                warning_texture()
            }),
            _ => {
                let single = self.get(name, 1);
                self.count(&single, name).map(|()| layered(&single, times)).unwrap_or_else(|error| {
                    self.warnings.push(error);
                    warning_texture()
                })
            }
        };
        self.loaded.insert((name.to_owned(), times), Arc::clone(&texture));
        texture
    }

    fn load(&mut self, name: &str) -> Result<Arc<Texture>, ResourceError> {
        let MeshSource { path, options } = self.source;
        if name.is_empty() {
            return Err(ResourceError::NoDiffuseTexture(path.to_owned()));
        }
        if self.texels >= MAX_TEXELS || self.loaded.len() >= MAX_TEXTURES {
            return Err(self.too_many(name));
        }
        if let Some(image) = self.images.get(name) {
            let texture = texture::from_bytes(image, &path.join(name))?;
            self.count(&texture, name)?;
            return Ok(texture);
        }
        let mut file = self.source.beside(name);
        if !file.is_file() {
            let decoded = self.source.beside(&percent_encoding::percent_decode_str(name).decode_utf8_lossy());
            if decoded.is_file() {
                file = decoded;
            }
        }
        let texture = texture::load(options, &file)?;
        self.count(&texture, name)?;
        Ok(texture)
    }

    /// Counts a texture's texels against the limit.
    fn count(&mut self, texture: &Texture, name: &str) -> Result<(), ResourceError> {
        if self.texels + texture.rgba.len() > MAX_TEXELS {
            self.texels = MAX_TEXELS;
            return Err(self.too_many(name));
        }
        self.texels += texture.rgba.len();
        Ok(())
    }

    fn too_many(&self, name: &str) -> ResourceError {
        let mesh = self.source.path.display();
        let reason = format!("{mesh} has more than {MAX_TEXTURES} textures, or more than {MAX_TEXELS} pixels in them");
        ResourceError::BadImage { path: name.into(), reason }
    }
}
