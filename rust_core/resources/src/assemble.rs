//! From imported meshes to drawable parts, as in rviz's mesh loader.
//!
//! Each mesh of each node becomes a part, placed by the nodes' transforms; normals are turned by the same matrix and
//! made unit length (not by the inverse transpose, so they lean under uneven scales); materials get half the ambient
//! colour and the diffuse texture once for every texture that the file names, of whatever kind; they are opaque.

use std::{collections::HashMap, path::Path, sync::Arc};

use nalgebra::{Matrix4, Point3, Vector3};
use rcs_scene::{Mesh, Rgba, Texture, Vertex};

use crate::{
    import::{normalized, process, Imported, MaterialSpec, Triangles},
    load_texture,
    texture::layered,
    warning_texture, LoadedMesh, MeshMaterial, MeshPart, ResourceError,
};

/// OpenGL's normal where a mesh (of lines or points) sends none: the initial one, which is never set.
const UNSET_NORMAL: [f32; 3] = [0.0, 0.0, 1.0];

/// Makes the parts of a mesh; textures are searched for beside `path`.
pub(crate) fn assemble(imported: &Imported, path: &Path) -> LoadedMesh {
    let mut textures = Textures { path, loaded: HashMap::new(), warnings: Vec::new() };
    let mut materials: HashMap<usize, MeshMaterial> = HashMap::new();
    let mut processed: HashMap<usize, Vec<Triangles>> = HashMap::new();
    let mut parts = Vec::new();
    for placed in &imported.placed {
        let Some(polygons) = imported.meshes.get(placed.mesh) else { continue };
        let spec = imported.materials.get(polygons.material);
        let material = materials
            .entry(polygons.material)
            .or_insert_with(|| spec.map_or(MeshMaterial::none(), |spec| material(spec, &mut textures)));
        let flat = spec.is_some_and(|spec| spec.flat);
        for triangles in processed.entry(placed.mesh).or_insert_with(|| process(polygons)) {
            if let Some(mesh) = place(triangles, &placed.object_from_mesh, flat) {
                parts.push(MeshPart { mesh: Arc::new(mesh), material: material.clone() });
            }
        }
    }
    LoadedMesh { parts, warnings: textures.warnings }
}

/// The triangles in the file's frame; `None` when the transform sends them to infinity.
fn place(triangles: &Triangles, object_from_mesh: &Matrix4<f32>, flat: bool) -> Option<Mesh> {
    let rotation = object_from_mesh.fixed_view::<3, 3>(0, 0).into_owned();
    let moved = *object_from_mesh != Matrix4::identity();
    let mut vertices = Vec::with_capacity(triangles.positions.len());
    for (i, &position) in triangles.positions.iter().enumerate() {
        let position = if moved {
            (rotation * Vector3::from(position) + object_from_mesh.fixed_view::<3, 1>(0, 3)).into()
        } else {
            position
        };
        let normal = match triangles.normals.get(i) {
            Some(&normal) if moved => normalized((rotation * Vector3::from(normal)).into()),
            Some(&normal) => normalized(normal),
            None => UNSET_NORMAL,
        };
        let normal = if normal.iter().all(|component| component.is_finite()) { normal } else { [0.0; 3] };
        let uv = triangles.uvs.get(i).copied().unwrap_or_default();
        vertices.push(Vertex { uv, ..Vertex::new(position, normal) });
    }
    if vertices.iter().any(|vertex| !Point3::from(vertex.position).iter().all(|x| x.is_finite())) {
        return None;
    }
    let mesh = Mesh { vertices, indices: triangles.indices.clone() };
    Some(welded(&if flat { flat_shaded(&mesh) } else { mesh }))
}

/// The same triangles with each vertex only once. Nothing of that is seen, but a detailed mesh has five corners in six
/// that are the same as another one, and all are transformed for every picture.
fn welded(mesh: &Mesh) -> Mesh {
    let mut numbers: HashMap<[u32; 8], u32> = HashMap::with_capacity(mesh.vertices.len() / 4);
    let mut vertices = Vec::new();
    let new_index: Vec<u32> = mesh
        .vertices
        .iter()
        .map(|vertex| {
            let ([x, y, z], [nx, ny, nz], [u, v]) = (vertex.position, vertex.normal, vertex.uv);
            *numbers.entry([x, y, z, nx, ny, nz, u, v].map(f32::to_bits)).or_insert_with(|| {
                vertices.push(*vertex);
                vertices.len() as u32 - 1
            })
        })
        .collect();
    let indices = mesh.indices.iter().filter_map(|&index| new_index.get(index as usize).copied()).collect();
    Mesh { vertices, indices }
}

/// Each triangle with one normal, that of its last corner, which is the one that OpenGL's flat shading takes.
fn flat_shaded(mesh: &Mesh) -> Mesh {
    let vertices: Vec<Vertex> =
        mesh.triangles().flat_map(|[a, b, c]| [a, b, c].map(|corner| Vertex { normal: c.normal, ..*corner })).collect();
    Mesh { indices: (0..vertices.len() as u32).collect(), vertices }
}

fn material(spec: &MaterialSpec, textures: &mut Textures<'_>) -> MeshMaterial {
    let color = |[r, g, b]: [f32; 3]| Rgba::new(r, g, b, 1.0);
    let texture = (spec.texture_count > 0).then(|| layered(&textures.get(&spec.diffuse_texture), spec.texture_count));
    MeshMaterial {
        embedded: true,
        diffuse: color(spec.diffuse),
        ambient: color(spec.ambient.map(|channel| channel * 0.5)),
        specular: color(spec.specular),
        shininess: spec.shininess,
        emissive: color(spec.emissive),
        texture,
    }
}

/// The textures beside a mesh, each loaded once.
struct Textures<'a> {
    path: &'a Path,
    loaded: HashMap<String, Arc<Texture>>,
    warnings: Vec<ResourceError>,
}

impl Textures<'_> {
    /// The texture of that name, or Ogre's warning texture and a warning.
    fn get(&mut self, name: &str) -> Arc<Texture> {
        if let Some(texture) = self.loaded.get(name) {
            return Arc::clone(texture);
        }
        let texture = self.load(name).unwrap_or_else(|error| {
            self.warnings.push(error);
            warning_texture()
        });
        self.loaded.insert(name.to_owned(), Arc::clone(&texture));
        texture
    }

    fn load(&self, name: &str) -> Result<Arc<Texture>, ResourceError> {
        if name.is_empty() {
            return Err(ResourceError::NoDiffuseTexture { path: self.path.to_owned() });
        }
        // rviz puts a slash between the two, so an absolute name is searched for beside the mesh as well.
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let file = folder.join(name.trim_start_matches('/'));
        if !file.is_file() {
            let decoded = percent_encoding::percent_decode_str(name).decode_utf8_lossy();
            let decoded = folder.join(decoded.trim_start_matches('/'));
            if decoded.is_file() {
                return load_texture(&decoded);
            }
        }
        load_texture(&file)
    }
}
