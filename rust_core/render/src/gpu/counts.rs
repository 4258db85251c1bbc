//! How much a picture has in it for a GPU: what is placed by itself, and primitives, wherever they are.
//!
//! The CPU renderer finds out first what may be seen of thousands of markers or millions of points, and takes a tenth
//! of a second for the largest scenes on two cores. A GPU goes through all of it for each picture. What it does fast
//! are many vertices of few things; a solid of some hundred vertices took an H200 3 µs.

use rcs_scene::{Drawable, Geometry};

use crate::View;

/// What is in a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Counts {
    /// Drawables, and solids of those that have many.
    pub(super) things: usize,
    /// What a software driver has to do for primitives, as many points: Mesa's takes 0.2 µs for one.
    pub(super) work: usize,
}

/// A triangle or a glyph takes as long as so many points.
const POINTS_A_TRIANGLE: usize = 2;
/// And a line.
const POINTS_A_LINE: usize = 4;

impl Counts {
    /// Those of all that a view shows.
    pub(super) fn of(view: &View<'_>) -> Self {
        let shown = view.scene.drawables.iter().filter(|drawable| view.visible.shows(drawable.display));
        shown.fold(Self::default(), |sum, drawable| sum.with(drawable))
    }

    fn with(self, drawable: &Drawable) -> Self {
        let triangles = |count: usize| POINTS_A_TRIANGLE * count;
        let (things, work) = match &drawable.geometry {
            Geometry::Points(points) => (1, points.buffer.positions.len()),
            Geometry::Lines(lines) => (1, POINTS_A_LINE * lines.segment_count()),
            Geometry::Mesh { mesh, .. } => (1, triangles(mesh.indices.len() / 3)),
            Geometry::Ribbons(ribbons) => (1, triangles(ribbons.chains.iter().map(|chain| 2 * chain.len()).sum())),
            Geometry::Text(text) => (1, triangles(text.glyphs().len())),
            Geometry::Solids(solids) => {
                let of_shapes: Vec<usize> = solids.shapes().iter().map(|shape| shape.indices.len() / 3).collect();
                let of_solid = |shape: usize| of_shapes.get(shape).copied().unwrap_or_default();
                (solids.len(), triangles(solids.as_slice().iter().map(|solid| of_solid(solid.shape())).sum()))
            }
            Geometry::Cells(_) | Geometry::Facing(_) => (1, 0),
        };
        Self { things: self.things + things, work: self.work + work }
    }
}
