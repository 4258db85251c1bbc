//! Tiles: squares of cells, coarse enough to tell quickly which part of the surface light may meet.

use crate::cells::{window, WindowScratch};

/// Side of a tile, cells.
pub(crate) const TILE_CELLS: usize = 8;

/// Rectangle of tiles: its first and its last column and row. An empty one has its last before its first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TileRange {
    columns: [u32; 2],
    rows: [u32; 2],
}

impl TileRange {
    /// No tile.
    pub(crate) const EMPTY: Self = Self { columns: [u32::MAX, 0], rows: [u32::MAX, 0] };

    /// The tiles between two places, in cells from the image's left and upper edge. Empty if they are not ordered.
    #[inline(always)]
    pub(crate) fn between(least: [f32; 2], most: [f32; 2]) -> Self {
        if !(least[0] <= most[0] && least[1] <= most[1] && most[0] >= 0.0 && most[1] >= 0.0) {
            return Self::EMPTY;
        }
        let tile = |place: f32| (place / TILE_CELLS as f32) as u32;
        Self { columns: [tile(least[0]), tile(most[0])], rows: [tile(least[1]), tile(most[1])] }
    }

    /// The smallest range with both.
    pub(crate) fn with(self, other: Self) -> Self {
        let join = |own: [u32; 2], other: [u32; 2]| [own[0].min(other[0]), own[1].max(other[1])];
        Self { columns: join(self.columns, other.columns), rows: join(self.rows, other.rows) }
    }
}

/// Set of an image's tiles.
#[derive(Debug, Default)]
pub(crate) struct Tiles {
    /// Columns and rows.
    size: [usize; 2],
    /// 1 for each tile that is in it, row by row.
    flags: Vec<u8>,
    scratch: WindowScratch<u8>,
}

impl Tiles {
    /// Empties the set. `cells` are the columns and rows of the image's cells.
    pub(crate) fn reset(&mut self, cells: [usize; 2]) {
        self.size = cells.map(|side| side.div_ceil(TILE_CELLS));
        self.flags.clear();
        self.flags.resize(self.size[0] * self.size[1], 0);
    }

    /// Replaces the set by the tiles with a cell that is not 0, and at least those at most `margin` cells away.
    pub(crate) fn take(&mut self, cells: &[u8], size: [usize; 2], margin: usize) {
        self.reset(size);
        if size[0] == 0 {
            return;
        }
        for (y, row) in cells.chunks_exact(size[0]).enumerate() {
            let begin = y / TILE_CELLS * self.size[0];
            for (flag, cells) in self.flags[begin..].iter_mut().zip(row.chunks(TILE_CELLS)) {
                *flag |= u8::from(cells.iter().fold(0, |any, cell| any | cell) != 0);
            }
        }
        window(&mut self.flags, self.size[0], margin.div_ceil(TILE_CELLS), 0, &mut self.scratch, u8::max);
    }

    /// Adds the tiles of a range that the image has.
    pub(crate) fn add(&mut self, range: TileRange) {
        if let Some([columns, rows]) = self.clipped(range) {
            for row in rows {
                self.flags[row * self.size[0]..][columns.clone()].fill(1);
            }
        }
    }

    /// `true` if a tile of a range is in the set.
    pub(crate) fn meets(&self, range: TileRange) -> bool {
        let Some([columns, mut rows]) = self.clipped(range) else { return false };
        rows.any(|row| self.flags[row * self.size[0]..][columns.clone()].contains(&1))
    }

    /// `true` for each tile that is in the set, row by row.
    pub(crate) fn flags(&self) -> impl Iterator<Item = bool> + '_ {
        self.flags.iter().map(|flag| *flag != 0)
    }

    /// Columns and rows of a range that are in the image; `None` if none are.
    fn clipped(&self, TileRange { columns, rows }: TileRange) -> Option<[std::ops::Range<usize>; 2]> {
        let clip = |[first, last]: [u32; 2], side: usize| {
            let range = first as usize..(last as usize + 1).min(side);
            (!range.is_empty()).then_some(range)
        };
        Some([clip(columns, self.size[0])?, clip(rows, self.size[1])?])
    }
}
