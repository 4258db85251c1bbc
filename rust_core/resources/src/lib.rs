//! Files that messages and configs name: `package://` addresses, meshes and their textures.
//!
//! [`PackageIndex`] finds files as rospack and resource_retriever do, within the limits of [`ResourceOptions`].
//! [`MeshStore`] loads each mesh once, on threads of its own if the caller cannot wait, as rviz draws it: rviz reads
//! meshes with the Assimp library, whose rules (normals, materials, triangulation) decide the image, so the readers
//! here follow Assimp 5.2 rather than the letter of the formats. Existing crates for STL, OBJ, COLLADA, PLY or glTF
//! follow other rules, and refuse files that robots come with.
//!
//! Loading a mesh: [`MeshStore`] → `import/stl|obj|collada|ply|gltf` (polygons and materials) → `import/process`
//! (triangles, normals, invalid data) → `assemble` (rviz's transforms and materials).
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

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
pub use files::ResourceOptions;
pub use loaded::{LoadedMesh, MeshMaterial, MeshPart};
pub use packages::PackageIndex;
pub use store::{yield_to_others, MeshStore, Retry};
pub use texture::warning_texture;
