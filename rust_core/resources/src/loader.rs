//! Loads one mesh or texture, on the calling thread.

use std::{
    panic::{catch_unwind, AssertUnwindSafe},
    path::Path,
    sync::{Arc, Mutex},
};

use rcs_process::lock;
use rcs_scene::Texture;

use crate::{
    assemble,
    files::FileStamp,
    import::{self, MeshFormat, MeshSource},
    texture, LoadedMesh, MeshFault, MeshPart, PackageIndex, ResourceError, ResourceOptions,
};

/// Files of at least this size are loaded one at a time, so that their memory does not add up.
const LARGE_FILE_BYTES: u64 = 32 << 20;

/// The kind of a resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum ResourceKind {
    Mesh,
    Texture,
}

/// A resource by its address.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct ResourceKey {
    pub(crate) kind: ResourceKind,
    pub(crate) url: String,
}

/// A resource that is loaded.
#[derive(Clone, Debug)]
pub(crate) enum Resource {
    Mesh(Arc<LoadedMesh>),
    Texture(Arc<Texture>),
}

impl Resource {
    /// Memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let of_texture = |texture: &Texture| size_of_val(texture.rgba.as_slice());
        match self {
            Self::Mesh(mesh) => {
                let of_mesh = |part: &MeshPart| {
                    size_of_val(part.mesh.vertices.as_slice()) + size_of_val(part.mesh.indices.as_slice())
                };
                let texture = |part: &MeshPart| part.material.texture.as_deref().map_or(0, of_texture);
                mesh.parts.iter().map(|part| of_mesh(part) + texture(part)).sum()
            }
            Self::Texture(texture) => of_texture(texture),
        }
    }

    /// `true` if nothing but the store holds it.
    pub(crate) fn is_unused(&self) -> bool {
        match self {
            // A marker holds the mesh; a robot's link holds parts of it.
            Self::Mesh(mesh) => {
                Arc::strong_count(mesh) == 1 && mesh.parts.iter().all(|part| Arc::strong_count(&part.mesh) == 1)
            }
            Self::Texture(texture) => Arc::strong_count(texture) == 1,
        }
    }
}

/// Result of loading a resource.
pub(crate) type Outcome = Result<Resource, ResourceError>;

/// Finds and reads files.
#[derive(Debug)]
pub(crate) struct Loader {
    pub(crate) packages: PackageIndex,
    pub(crate) options: ResourceOptions,
    large_file: Mutex<()>,
}

impl Loader {
    pub(crate) fn new(packages: PackageIndex, options: ResourceOptions) -> Self {
        Self { packages, options, large_file: Mutex::default() }
    }

    /// Loads a resource. Returns it with its file's stamp from before reading; `None` if the stamp is that of the last
    /// failure.
    pub(crate) fn load(&self, key: &ResourceKey, failed: Option<FileStamp>) -> Option<(Outcome, Option<FileStamp>)> {
        let path = match self.packages.resolve(&key.url) {
            Ok(path) => path,
            Err(error) => return Some((Err(error), None)),
        };
        let stamp = FileStamp::of(&path);
        if failed.is_some() && failed == stamp {
            return None;
        }
        let is_large = stamp.is_some_and(|stamp| stamp.size() >= LARGE_FILE_BYTES);
        let _one_at_a_time = is_large.then(|| lock(&self.large_file));
        let load = || match key.kind {
            ResourceKind::Mesh => self.mesh(&key.url, &path).map(|mesh| Resource::Mesh(Arc::new(mesh))),
            ResourceKind::Texture => texture::load(&self.options, &path).map(Resource::Texture),
        };
        // Unwind safe: a partial result is dropped.
        let outcome =
            catch_unwind(AssertUnwindSafe(load)).unwrap_or_else(|_| Err(ResourceError::ReaderFailed(key.url.clone())));
        Some((outcome, stamp))
    }

    /// Reads a mesh file and its textures.
    fn mesh(&self, url: &str, path: &Path) -> Result<LoadedMesh, ResourceError> {
        let bad = |fault| ResourceError::BadMesh { path: path.to_owned(), fault };
        let format = MeshFormat::from_path(path)?;
        let source = MeshSource { path, options: &self.options };
        let bytes = self.options.read(path)?;
        let imported = import::import(format, &bytes, source).map_err(bad)?;
        drop(bytes);
        let mesh = assemble::assemble(imported, source);
        if mesh.parts.is_empty() {
            return Err(bad(MeshFault::Empty));
        }
        for warning in &mesh.warnings {
            log::warn!("mesh {url}: {warning}");
        }
        Ok(mesh)
    }
}
