//! The pixels of a band: what is at the bottom of the renderer, and the tests that fragments have to pass.

pub(super) mod band;
pub(super) mod bins;
pub(super) mod color;
pub(super) mod hiz;
pub(super) mod lanes;
pub(super) mod near_to_far;
pub(super) mod screen;
