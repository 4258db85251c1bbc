//! Lines of one pixel, as OpenGL draws them (`OT_LINE_LIST`, `OT_LINE_STRIP` in Ogre).

use std::ops::Range;

use crate::Blending;

/// Order in which the vertices of [`Lines`] are joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineTopology {
    /// Vertices 0–1, 2–3, 4–5 …
    List,
    /// Vertices 0–1–2–3 …
    Strip,
}

/// Lines one pixel wide, unlit.
#[derive(Clone, Debug, PartialEq)]
pub struct Lines {
    /// Positions in metres in the object's frame.
    pub positions: Vec<[f32; 3]>,
    /// One colour a vertex, red first, interpolated along a line; or a single one for all.
    pub colors: Vec<[u8; 4]>,
    /// Order in which the vertices are joined.
    pub topology: LineTopology,
    /// Combination with the pixels behind them.
    pub blending: Blending,
}

impl Lines {
    /// The colour of a vertex: its own, or the only one; white where there is none.
    pub fn color(&self, index: usize) -> [u8; 4] {
        self.colors.get(index).or_else(|| self.colors.first()).copied().unwrap_or([255; 4])
    }

    /// Number of lines.
    pub fn segment_count(&self) -> usize {
        match self.topology {
            LineTopology::List => self.positions.len() / 2,
            LineTopology::Strip => self.positions.len().saturating_sub(1),
        }
    }

    /// The pairs of vertex indices that some of the lines join.
    pub fn segments(&self, range: Range<usize>) -> impl Iterator<Item = (usize, usize)> {
        let stride = match self.topology {
            LineTopology::List => 2,
            LineTopology::Strip => 1,
        };
        let end = range.end.min(self.segment_count());
        (range.start..end).map(move |i| (i * stride, i * stride + 1))
    }
}
