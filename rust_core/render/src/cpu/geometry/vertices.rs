//! The corners of triangles on their way to the image: transformed and, where a triangle may be seen, lit.

use rcs_scene::{Material, Vertex};

use super::lighting::vertex_color;
use crate::cpu::paint::Surface;
use crate::cpu::raster::clip::{ClipVertex, Outside};
use crate::cpu::raster::triangle::{self, Corner};
use crate::cpu::tile::band::Band;
use crate::cpu::tile::screen::{ObjectTransform, Screen, ScreenPosition};

/// Vertices that triangles name by their indices, their keys, and their way to the image.
pub(in crate::cpu) struct Source<'a> {
    pub vertices: &'a [Vertex],
    pub material: &'a Material,
    pub transform: &'a ObjectTransform,
    pub surface: &'a Surface,
    pub screen: &'a Screen,
}

/// The part of a triangle that may be seen.
pub(in crate::cpu) enum InView {
    Nothing,
    /// All of it, with its corners at these positions.
    Whole([ScreenPosition; 3]),
    /// It has to be cut.
    Crossing,
}

/// The memory of a thread that draws triangles right from their vertices.
#[derive(Debug, Default)]
pub(in crate::cpu) struct VertexScratch {
    pub cache: VertexCache,
    corners: Vec<Corner>,
}

impl VertexScratch {
    /// The vertices of another source follow.
    pub(in crate::cpu) fn clear(&mut self) {
        self.cache.clear();
        self.corners.clear();
    }
}

impl Source<'_> {
    /// The rows that a triangle may be seen in; they may reach out of the image.
    pub(in crate::cpu) fn rows(&self, keys: [u32; 3], cache: &mut VertexCache) -> Option<(i32, i32)> {
        match self.look(keys, cache) {
            InView::Nothing => None,
            InView::Whole(positions) => Some(triangle::rows(positions.each_ref())),
            InView::Crossing => {
                let mut rows = None;
                self.cut(keys, |corners| {
                    let of_part = triangle::rows(corners.each_ref().map(|corner| &corner.position));
                    rows = joined(rows, Some(of_part));
                });
                rows
            }
        }
    }

    /// Draws the rows of a band.
    pub(in crate::cpu) fn draw(&self, keys: [u32; 3], scratch: &mut VertexScratch, band: &mut Band<'_>) {
        let VertexScratch { cache, corners } = scratch;
        match self.look(keys, cache) {
            InView::Nothing => {}
            InView::Whole(positions) => {
                let indices = cache.indices(keys, &positions, self, corners);
                triangle::draw(indices.map(|index| &corners[index as usize]), self.surface, band);
            }
            InView::Crossing => self.cut(keys, |corners| triangle::draw(corners.each_ref(), self.surface, band)),
        }
    }

    /// As [`draw`](Self::draw), of two triangles that share an edge.
    pub(in crate::cpu) fn draw_pair(&self, pair: [[u32; 3]; 2], scratch: &mut VertexScratch, band: &mut Band<'_>) {
        let VertexScratch { cache, corners } = scratch;
        let [InView::Whole(one), InView::Whole(other)] = pair.map(|keys| self.look(keys, cache)) else {
            return pair.into_iter().for_each(|keys| self.draw(keys, scratch, band));
        };
        let one = cache.indices(pair[0], &one, self, corners);
        let other = cache.indices(pair[1], &other, self, corners);
        let pair = [one, other].map(|triangle| triangle.map(|index| &corners[index as usize]));
        triangle::draw_pair(pair, self.surface, band);
    }

    /// Finds what of a triangle may be seen. Its corners have no need of light for that.
    #[inline]
    pub(in crate::cpu) fn look(&self, [a, b, c]: [u32; 3], cache: &mut VertexCache) -> InView {
        let mut place = |key| cache.place(key, self);
        let (Some((a, out_a)), Some((b, out_b)), Some((c, out_c))) = (place(a), place(b), place(c)) else {
            return InView::Nothing;
        };
        if out_a.view & out_b.view & out_c.view != 0 {
            InView::Nothing
        } else if out_a.guard | out_b.guard | out_c.guard != 0 {
            InView::Crossing
        } else if triangle::may_be_seen([&a, &b, &c], self.surface, self.screen) {
            InView::Whole([a, b, c])
        } else {
            InView::Nothing
        }
    }

    /// Clips a triangle that reaches far out of the image, and passes on the parts that are to be drawn.
    pub(in crate::cpu) fn cut(&self, keys: [u32; 3], out: impl FnMut(&[Corner; 3])) {
        let vertex = |key: u32| {
            let vertex = self.vertices.get(key as usize)?;
            let color = vertex_color(self.material, self.transform, vertex);
            Some(ClipVertex { position: self.transform.clip(vertex.position), color, uv: vertex.uv })
        };
        if let [Some(a), Some(b), Some(c)] = keys.map(vertex) {
            triangle::cut([&a, &b, &c], self.surface, self.screen, out);
        }
    }
}

/// The rows of both.
pub(in crate::cpu) fn joined(one: Option<(i32, i32)>, other: Option<(i32, i32)>) -> Option<(i32, i32)> {
    match (one, other) {
        (Some((begin, end)), Some((from, to))) => Some((begin.min(from), end.max(to))),
        (one, other) => one.or(other),
    }
}

/// The last transformed vertices, so that a vertex that neighbouring triangles share is computed once.
#[derive(Debug)]
pub(in crate::cpu) struct VertexCache {
    entries: [CachedVertex; Self::SIZE],
    generation: u64,
}

#[derive(Clone, Copy, Debug, Default)]
struct CachedVertex {
    /// Of the present source where it is that of the cache.
    generation: u64,
    key: u32,
    /// Its index among the corners: it is one, with its colour, from the first triangle on that may be seen. Of a
    /// detailed mesh most vertices never are.
    index: Option<u32>,
    outside: Outside,
    position: ScreenPosition,
}

impl Default for VertexCache {
    fn default() -> Self {
        Self { entries: [CachedVertex::default(); Self::SIZE], generation: 0 }
    }
}

impl VertexCache {
    const SIZE: usize = 256;

    /// The vertices of another source follow.
    pub(in crate::cpu) fn clear(&mut self) {
        self.generation += 1;
    }

    /// Position of a vertex, if the source has it.
    #[inline]
    fn place(&mut self, key: u32, source: &Source<'_>) -> Option<(ScreenPosition, Outside)> {
        let entry = &mut self.entries[key as usize % Self::SIZE];
        if (entry.generation, entry.key) != (self.generation, key) {
            let position = source.transform.clip(source.vertices.get(key as usize)?.position);
            let (outside, position) = (Outside::new(position), ScreenPosition::new(position, source.screen));
            *entry = CachedVertex { generation: self.generation, key, index: None, outside, position };
        }
        Some((entry.position, entry.outside))
    }

    /// Indices of a triangle's vertices among the corners, given their positions.
    #[inline]
    pub(in crate::cpu) fn indices(
        &mut self,
        keys: [u32; 3],
        positions: &[ScreenPosition; 3],
        source: &Source<'_>,
        corners: &mut Vec<Corner>,
    ) -> [u32; 3] {
        [0, 1, 2].map(|i| {
            let key = keys[i];
            let entry = &mut self.entries[key as usize % Self::SIZE];
            // Another vertex of the same triangle may have taken its place.
            let is_there = (entry.generation, entry.key) == (self.generation, key);
            if let Some(index) = entry.index.filter(|_| is_there) {
                return index;
            }
            let index = corners.len() as u32;
            corners.push(source.vertices.get(key as usize).map_or_else(Corner::default, |vertex| {
                let color = vertex_color(source.material, source.transform, vertex);
                Corner { position: positions[i], color, uv: vertex.uv }
            }));
            if is_there {
                entry.index = Some(index);
            }
            index
        })
    }
}
