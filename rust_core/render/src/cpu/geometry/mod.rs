//! From the scene to primitives on the image.

pub(super) mod instances;
pub(super) mod lighting;
pub(super) mod meshes;
pub(super) mod points;
pub(super) mod vertices;
