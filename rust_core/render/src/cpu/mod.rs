//! The CPU renderer.
//!
//! An image is made in two steps, each spread over the cores:
//!
//! ```text
//! scene ─► plan ─► geometry ──────────► tile: bins ─► raster ─► paint ─► tile: band ─► image
//!          jobs    points, meshes,      primitives    edges,    colour   depth test,   encoded
//!                  instances, text:     sorted into   spans              blending      rows
//!                  to clip space        bands of rows
//!          └────── 1: for each job ────────────────┘  └────── 2: for each band ──────────────┘
//! ```
//!
//! 1. The scene is cut into jobs ([`plan`]). A job projects points, or transforms, lights and clips triangles and
//!    lines, drops what is out of view, and sorts the rest into the image's *bands*, a few dozen rows each
//!    ([`geometry`], [`tile::bins`]).
//! 2. Each band is drawn: whatever the jobs have sorted into it, job after job, so in the scene's order. [`raster`]
//!    finds the pixels of primitives, [`paint`] their colours, and [`tile::band`] tests and blends them. A band's
//!    colours and depths fit into a core's cache, belong to one thread, and are encoded into the image when the band
//!    is done. There is no frame buffer of the whole image, and no two threads write to the same pixel, so that the
//!    image does not depend on the number of threads.
//!
//! Opaque faces that lie over each other many times are drawn by their *ranks*, from near to far, instead of in their
//! order, so that those which others hide cost little ([`tile::near_to_far`], [`tile::hiz`]). The image is the same.
//! Translucent jobs are drawn in their order, between such runs.
//!
//! The result is what OpenGL draws with rviz's shaders on Mesa's software rasteriser; [`geometry::points`],
//! [`raster::triangle`] and [`raster::line`] describe how.
//!
//! All memory that grows with the scene is kept for the next image.

mod costs;
mod geometry;
mod paint;
mod plan;
mod raster;
mod renderer;
#[cfg(test)]
mod tests;
mod texture;
mod threads;
mod tile;

pub use self::renderer::{CpuRenderer, Culling};
