//! Meshes by address, each loaded once.
//!
//! rviz keeps a loaded mesh for as long as it runs and so does this; a failure is kept too, so that a marker that is
//! published ten times a second does not read and report a missing file ten times a second.

use std::{
    collections::HashMap,
    fs,
    path::Path,
    sync::{Arc, Mutex, OnceLock, PoisonError},
};

use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use crate::{assemble, import, LoadedMesh, MeshFault, PackageIndex, ResourceError};

type Slot = Arc<OnceLock<Result<Arc<LoadedMesh>, ResourceError>>>;

/// A cache of meshes. Cheap to share between threads: a thread that needs a mesh which another is loading waits for
/// that mesh only.
///
/// ```
/// use rcs_resources::{MeshStore, PackageIndex, ResourceError};
///
/// let store = MeshStore::new(PackageIndex::from_env(&[]));
/// match store.get("package://no_such_package/arm.stl") {
///     Ok(mesh) => println!("{} parts", mesh.parts.len()),
///     Err(ResourceError::NoSuchPackage { package, .. }) => assert_eq!(package, "no_such_package"),
///     Err(error) => panic!("{error}"),
/// }
/// ```
#[derive(Debug)]
pub struct MeshStore {
    packages: PackageIndex,
    slots: Mutex<HashMap<String, Slot>>,
}

impl MeshStore {
    /// An empty store that finds packages through `packages`.
    pub fn new(packages: PackageIndex) -> Self {
        Self { packages, slots: Mutex::default() }
    }

    /// The packages that addresses are resolved with.
    pub fn packages(&self) -> &PackageIndex {
        &self.packages
    }

    /// The mesh at a `package://` or `file://` address; the same address gives the same meshes and textures, or the
    /// same error. What is wrong with it but not fatal is logged once, when it is loaded, and kept in
    /// [`LoadedMesh::warnings`].
    ///
    /// # Errors
    /// Any [`ResourceError`].
    pub fn get(&self, url: &str) -> Result<Arc<LoadedMesh>, ResourceError> {
        let slot = {
            let mut slots = self.slots.lock().unwrap_or_else(PoisonError::into_inner);
            match slots.get(url) {
                Some(slot) => Arc::clone(slot),
                None => Arc::clone(slots.entry(url.to_owned()).or_default()),
            }
        };
        let load = || {
            let mesh = load(&self.packages.resolve(url)?)?;
            for warning in &mesh.warnings {
                log::warn!("mesh {url}: {warning}");
            }
            Ok(Arc::new(mesh))
        };
        slot.get_or_init(load).clone()
    }

    /// Loads meshes on all processors. [`MeshStore::get`] then returns each of them, or its error, at once.
    pub fn load_all<'a>(&self, urls: impl IntoIterator<Item = &'a str>) {
        let mut urls: Vec<&str> = urls.into_iter().collect();
        urls.sort_unstable();
        urls.dedup();
        // The results are kept in the store.
        urls.par_iter().for_each(|url| drop(self.get(url)));
    }
}

/// Reads a mesh file and the textures that it names.
fn load(path: &Path) -> Result<LoadedMesh, ResourceError> {
    let format = import::Format::from_path(path)?;
    let bytes = fs::read(path).map_err(|source| ResourceError::io(path, source))?;
    let imported = import::import(format, &bytes, path)
        .map_err(|fault| ResourceError::BadMesh { path: path.to_owned(), fault })?;
    let mesh = assemble::assemble(&imported, path);
    if mesh.parts.is_empty() {
        return Err(ResourceError::BadMesh { path: path.to_owned(), fault: MeshFault::Empty });
    }
    Ok(mesh)
}
