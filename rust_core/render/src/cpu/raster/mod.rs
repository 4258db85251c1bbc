//! From primitives to their pixels.

pub(super) mod clip;
pub(super) mod edges;
pub(super) mod line;
pub(super) mod quad;
pub(super) mod triangle;
