//! Files that messages and configs name: `package://` addresses, meshes and their textures.
//!
//! [`PackageIndex`] finds files as rospack and resource_retriever do, [`ResourceOptions`] says which of them may be
//! read. [`MeshStore`] loads a mesh once and keeps it, on threads of its own if the caller cannot wait, in the form in
//! which rviz shows it: rviz reads meshes through the Assimp library, whose choices (which normals, which material, how
//! polygons are cut) decide the picture, so the readers here follow Assimp 5.2's rules rather than the letter of the
//! formats. That is why they are not existing crates for STL, OBJ, COLLADA, PLY or glTF: those read the formats well,
//! but another way, and refuse files that robots come with.
//!
//! The way of a mesh: [`MeshStore`] → `import/stl|obj|collada|ply|gltf` (the file into corners, polygons and
//! materials) → `import/process` (triangles, normals, invalid data) → `assemble` (rviz's placing of the parts and its
//! materials).
#![forbid(unsafe_code)]

mod assemble;
mod error;
mod files;
mod import;
mod loaded;
mod loader;
mod packages;
mod store;
mod texture;

pub use error::{MeshFault, ResourceError};
pub use files::{read_regular_file, ResourceOptions};
pub use loaded::{LoadedMesh, MeshMaterial, MeshPart};
pub use packages::PackageIndex;
pub use store::{yield_to_others, MeshStore, Retry};
pub use texture::warning_texture;
