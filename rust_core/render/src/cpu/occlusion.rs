//! What hides what: how far away a band's pixels are already covered, by tile and by block of tiles.
//!
//! Thousands of faces may lie over each other on the picture, such as a depth camera's cloud right before the lens. To
//! test each of their fragments against the depth buffer would take seconds; here a face is compared with whole tiles
//! of [`TILE_PX`] × [`TILE_PX`] pixels and blocks of [`BLOCK_PX`] × [`BLOCK_PX`]. A cell (tile or block) keeps the
//! plane of depths of one face that covered it: no pixel of the cell is farther away than that, because depths only
//! ever decrease while a band is drawn. Planes, not the largest depth: neighbouring faces that turn to the eye differ
//! by less than each of them changes over a tile.
//!
//! A face is hidden in a cell where its own plane lies behind the cell's by more than both can be off: the depths of
//! fragments are rounded, so that a plane comes with a bound of that, its `noise`. Planes of constant depth are exact.
//! Of exactly equal depths the later face in the order of drawing wins; faces have a rank by which a cell knows.
//!
//! Which fragments are drawn is not changed by any of this, only how many are looked at.

use fearless_simd::prelude::*;
use fearless_simd::Simd;

use super::band::Band;
use super::cells::{half, not_below, Cells};
use super::lanes::{inlined, wide_indices, WideF, LANES, WIDE};

/// Side of a tile in pixels: a window's.
pub(super) const TILE_PX: i32 = LANES as i32;

/// Side of a block in pixels.
pub(super) const BLOCK_PX: i32 = 32;

/// The depths of a face's fragments: `at` at pixel (x, y) and its change to the right and down; each may be off by
/// `noise`.
#[derive(Clone, Copy, Debug)]
pub(super) struct DepthPlane {
    /// The depth at the place.
    pub at: f32,
    pub dx: f32,
    pub dy: f32,
    pub x: f32,
    pub y: f32,
    pub noise: f32,
    /// No fragment is nearer than this, wherever the plane leads outside of the face; may be infinitely negative.
    pub least: f32,
}

impl DepthPlane {
    /// The same depth everywhere.
    pub(super) fn level(at: f32) -> Self {
        Self { at, dx: 0.0, dy: 0.0, x: 0.0, y: 0.0, noise: 0.0, least: at }
    }

    /// At a place, exactly.
    pub(super) fn value(&self, x: f64, y: f64) -> f64 {
        f64::from(self.at) + f64::from(self.dx) * (x - f64::from(self.x)) + f64::from(self.dy) * (y - f64::from(self.y))
    }
}

/// The most that a sum or product of at most this magnitude is rounded by.
#[inline(always)]
pub(super) fn rounding(magnitude: f32) -> f32 {
    // Half of the place value of the last of 24 bits.
    const HALF_LAST_BIT: f32 = 1.0 / (1 << 24) as f32;
    f32::from_bits(magnitude.abs().to_bits() & 0x7f80_0000) * HALF_LAST_BIT
}

/// What is known of a tile's pixels after a face was drawn there.
#[derive(Clone, Copy, Debug)]
pub(super) enum Drawn {
    /// No more than before.
    Nothing,
    /// The face covers all of them.
    Covered,
    /// None of them is farther away than this, and the lowest of their ranks.
    Partly { bound: DepthPlane, first_rank: u32 },
}

/// A band's tiles and blocks.
#[derive(Debug, Default)]
pub(super) struct Occluders {
    /// Those of a block one after the other, row by row.
    tiles: Cells,
    /// Two rows of them at a time, from the left: the upper and the lower one of each column.
    blocks: Cells,
    /// Columns of blocks: behind each row there is room for a window's.
    stride: usize,
    width: i32,
    first_row: i32,
    end_row: i32,
    /// No pixel of the band is farther away.
    farthest: f32,
    /// How many faces may come before that is asked again.
    until_asked: u32,
    /// Memory for the tiles of a face.
    listed: Vec<SeenTiles>,
}

/// Pixels from left to before right and from top to before bottom.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Area {
    pub left: i32,
    pub right: i32,
    pub top: i32,
    pub bottom: i32,
}

/// A block or a tile of a band.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Cell {
    row: i32,
    column: i32,
}

impl Cell {
    /// The block of this bit of those from this one on.
    #[inline(always)]
    fn block(self, bit: u32) -> Self {
        Self { row: self.row + bit as i32 % BLOCK_ROWS, column: self.column + bit as i32 / BLOCK_ROWS }
    }
}

/// The tiles of a block in which something may be seen: a bit for each, row by row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SeenTiles {
    block: Cell,
    tiles: u32,
}

impl SeenTiles {
    /// The tile of this bit.
    #[inline(always)]
    fn tile(&self, bit: u32) -> Cell {
        let (row, column) = (bit as i32 / TILES, bit as i32 % TILES);
        Cell { row: self.block.row * TILES + row, column: self.block.column * TILES + column }
    }
}

impl Occluders {
    /// Forgets all, for a band of these rows.
    pub(super) fn reset(&mut self, width: i32, first_row: i32, end_row: i32) {
        self.stride = (width as usize).div_ceil(BLOCK_PX as usize) + BLOCK_COLUMNS as usize;
        let rows = ((end_row - first_row) as usize).div_ceil(BLOCK_PX as usize);
        let blocks = self.stride * rows.next_multiple_of(BLOCK_ROWS as usize);
        self.blocks.reset(blocks);
        self.tiles.reset(blocks * TILES_OF_BLOCK);
        (self.width, self.first_row, self.end_row) = (width, first_row, end_row);
        (self.farthest, self.until_asked) = (f32::INFINITY, Self::FACES_TO_ASK);
    }

    /// After so many faces it is asked again how far away the whole band is covered.
    const FACES_TO_ASK: u32 = 64;

    /// Whether nothing is seen in the whole band of what is no nearer than this.
    #[inline]
    pub(super) fn hides_from(&mut self, nearest: f32) -> bool {
        match self.until_asked.checked_sub(1) {
            Some(left) => self.until_asked = left,
            None => (self.farthest, self.until_asked) = (self.farthest(), Self::FACES_TO_ASK),
        }
        nearest > self.farthest
    }

    /// The pixels of a cell.
    fn area(&self, cell: Cell, side: i32) -> Area {
        let (left, top) = (cell.column * side, self.first_row + cell.row * side);
        Area { left, right: (left + side).min(self.width), top, bottom: (top + side).min(self.end_row) }
    }

    /// The place of a block among the blocks.
    #[inline(always)]
    fn place(&self, block: Cell) -> usize {
        let (rows, row) = (block.row / BLOCK_ROWS, block.row % BLOCK_ROWS);
        (rows as usize * self.stride + block.column as usize) * BLOCK_ROWS as usize + row as usize
    }

    /// The place of a tile among the tiles.
    #[inline(always)]
    fn place_of_tile(&self, tile: Cell) -> usize {
        let block = Cell { row: tile.row / TILES, column: tile.column / TILES };
        self.place(block) * TILES_OF_BLOCK + (tile.row % TILES * TILES + tile.column % TILES) as usize
    }

    /// The middle of a cell.
    fn middle(&self, cell: Cell, side: i32) -> [f64; 2] {
        let area = [cell.column * side, self.first_row + cell.row * side];
        area.map(|first| f64::from(first) + f64::from(half(side)))
    }

    /// The largest depth in the whole band; infinite where that is not known.
    pub(super) fn farthest(&self) -> f32 {
        let columns = (self.width + BLOCK_PX - 1) / BLOCK_PX;
        let rows = (self.end_row - self.first_row + BLOCK_PX - 1) / BLOCK_PX;
        let blocks = (0..rows).flat_map(|row| (0..columns).map(move |column| Cell { row, column }));
        blocks.map(|block| self.blocks.farthest[self.place(block)]).fold(0.0, f32::max)
    }

    /// Whether nothing is seen of a face within an area, which lies in the band.
    #[inline(always)]
    pub(super) fn hides<S: Simd>(&self, simd: S, plane: &DepthPlane, rank: u32, area: Area) -> bool {
        let [top, bottom] = [area.top, area.bottom - 1].map(|y| (y - self.first_row) / BLOCK_PX);
        let [left, right] = [area.left, area.right - 1].map(|x| x / BLOCK_PX);
        for row in (top - top % BLOCK_ROWS..=bottom).step_by(BLOCK_ROWS as usize) {
            for column in (left..=right).step_by(BLOCK_COLUMNS as usize) {
                let first = Cell { row, column };
                let mut seen = self.seen_blocks(simd, plane, rank, area, first);
                while seen != 0 {
                    let block = first.block(seen.trailing_zeros());
                    seen &= seen - 1;
                    if self.seen_tiles(simd, plane, rank, area, block).tiles != 0 {
                        return false;
                    }
                }
            }
        }
        true
    }

    /// In which of [`WIDE`] blocks from this one on something of a face may be seen.
    #[inline(always)]
    fn seen_blocks<S: Simd>(&self, simd: S, plane: &DepthPlane, rank: u32, area: Area, first: Cell) -> u32 {
        const HALF: f32 = half(BLOCK_PX);
        let lane = wide_indices(simd);
        let [right, down] = [lane >> BLOCK_ROWS.ilog2(), lane & (BLOCK_ROWS - 1)];
        let x = right.to_float::<WideF<S>>() * BLOCK_PX as f32 + ((first.column * BLOCK_PX) as f32 + HALF);
        let y = down.to_float::<WideF<S>>() * BLOCK_PX as f32 + ((self.first_row + first.row * BLOCK_PX) as f32 + HALF);
        let (columns, rows) = (within(x, [area.left, area.right], HALF), within(y, [area.top, area.bottom], HALF));
        let touched = columns[0].simd_le(columns[1]) & rows[0].simd_le(rows[1]);
        self.blocks.seen(simd, plane, rank, self.place(first), [x, y], [columns, rows]) & touched.to_bitmask() as u32
    }

    /// The tiles of a block in which something of a face may be seen.
    #[inline(always)]
    fn seen_tiles<S: Simd>(&self, simd: S, plane: &DepthPlane, rank: u32, area: Area, block: Cell) -> SeenTiles {
        let (first_column, first_row) = (block.column * BLOCK_PX, self.first_row + block.row * BLOCK_PX);
        let tile = inlined(
            #[inline(always)]
            |pixel: i32, first: i32| ((pixel - first) / TILE_PX).clamp(0, TILES - 1),
        );
        let [left, right] = [tile(area.left, first_column), tile(area.right - 1, first_column)];
        let [top, bottom] = [tile(area.top, first_row), tile(area.bottom - 1, first_row)];
        // A bit for each tile of the area.
        let columns = ((2u32 << right) - (1 << left)) * 0x1111;
        let rows = (1u32 << ((bottom + 1) * TILES)) - (1 << (top * TILES));
        let wanted = columns & rows;
        let (middles, within) = self.tiles_of(simd, area, block);
        let tiles = wanted & self.tiles.seen(simd, plane, rank, self.place(block) * TILES_OF_BLOCK, middles, within);
        SeenTiles { block, tiles }
    }

    /// Those of some tiles in which something of a face may be seen that ends where a limit is positive: given the
    /// middles of some tiles, `limit` gives its values there and its changes to the right and down.
    #[inline(always)]
    pub(super) fn seen_within<S: Simd>(
        &self,
        simd: S,
        plane: &DepthPlane,
        area: Area,
        SeenTiles { block, tiles }: SeenTiles,
        limit: impl Fn([WideF<S>; 2]) -> [WideF<S>; 3],
    ) -> SeenTiles {
        let (middles, within) = self.tiles_of(simd, area, block);
        let begin = self.place(block) * TILES_OF_BLOCK;
        let seen = self.tiles.seen_within(simd, plane, begin, middles, within, limit(middles));
        SeenTiles { block, tiles: tiles & seen }
    }

    /// The middles of a block's tiles, and how far from these the pixels of an area are.
    #[inline(always)]
    fn tiles_of<S: Simd>(&self, simd: S, area: Area, block: Cell) -> ([WideF<S>; 2], [[WideF<S>; 2]; 2]) {
        const HALF: f32 = half(TILE_PX);
        let (first_column, first_row) = (block.column * BLOCK_PX, self.first_row + block.row * BLOCK_PX);
        let lane = wide_indices(simd);
        let [right, down] = [lane & (TILES - 1), lane >> TILES.ilog2()];
        let x = right.to_float::<WideF<S>>() * TILE_PX as f32 + (first_column as f32 + HALF);
        let y = down.to_float::<WideF<S>>() * TILE_PX as f32 + (first_row as f32 + HALF);
        ([x, y], [within(x, [area.left, area.right], HALF), within(y, [area.top, area.bottom], HALF)])
    }

    /// Takes what is known of a block's tiles for the block: one depth for all, or a plane of these changes to the
    /// right and down.
    fn join_tiles(&mut self, block: Cell, [dx, dy]: [f32; 2]) {
        let (mut farthest, mut first_rank) = (0.0_f32, u32::MAX);
        let mut at_middle = 0.0_f64;
        let slopes = [dx, dy].map(f64::from);
        let middle = f64::from(TILES - 1) * 0.5;
        let begin = self.place(block) * TILES_OF_BLOCK;
        let area = self.area(block, BLOCK_PX);
        let (columns, rows) =
            ((area.right - area.left + TILE_PX - 1) / TILE_PX, (area.bottom - area.top + TILE_PX - 1) / TILE_PX);
        for row in 0..rows {
            for column in 0..columns {
                let tile = begin + (row * TILES + column) as usize;
                farthest = farthest.max(self.tiles.farthest[tile]);
                first_rank = first_rank.min(self.tiles.rank[tile]);
                let [right, down] = [column, row].map(|i| (f64::from(i) - middle) * f64::from(TILE_PX));
                let bound = self.tiles.bound_along(tile, slopes, half(TILE_PX));
                at_middle = at_middle.max(bound - (slopes[0] * right + slopes[1] * down));
            }
        }
        let mut plane = DepthPlane::level(farthest);
        if at_middle < f64::from(farthest) {
            let [x, y] = self.middle(block, BLOCK_PX).map(|at| at as f32);
            plane = DepthPlane { at: not_below(at_middle), dx, dy, x, y, ..plane };
        }
        self.offer(&plane, first_rank, block);
    }

    /// Offers a plane to a block.
    fn offer(&mut self, plane: &DepthPlane, rank: u32, block: Cell) -> bool {
        let (at, middle) = (self.place(block), self.middle(block, BLOCK_PX));
        self.blocks.offer(plane, rank, at, middle, half(BLOCK_PX))
    }

    /// Offers a plane to a tile.
    fn offer_to_tile(&mut self, plane: &DepthPlane, rank: u32, tile: Cell) -> bool {
        let (at, middle) = (self.place_of_tile(tile), self.middle(tile, TILE_PX));
        self.tiles.offer(plane, rank, at, middle, half(TILE_PX))
    }

    /// Looks again at the tiles of an area in which something was drawn.
    #[inline(always)]
    pub(super) fn look<S: Simd>(&mut self, simd: S, band: &Band<'_>, area: Area) {
        let block_rows = (area.top - self.first_row) / BLOCK_PX..=(area.bottom - 1 - self.first_row) / BLOCK_PX;
        for row in block_rows {
            for column in area.left / BLOCK_PX..=(area.right - 1) / BLOCK_PX {
                let block = Cell { row, column };
                let mut is_nearer = false;
                for tile in tiles_within(self.area(block, BLOCK_PX), area, self.first_row) {
                    let drawn = band.farthest(simd, self.area(tile, TILE_PX), [0.0; 2]);
                    if let Drawn::Partly { bound, first_rank } = drawn {
                        is_nearer |= self.offer_to_tile(&bound, first_rank, tile);
                    }
                }
                if is_nearer {
                    self.join_tiles(block, [0.0; 2]);
                }
            }
        }
    }

    /// Draws a face within an area: `draw` is given the pixels of each tile of which something may be seen, and says
    /// what is known of them then. `covers` says whether the face covers other pixels. These tiles are found here,
    /// unless they are [known](Self::list_seen).
    #[inline(always)]
    pub(super) fn draw<S: Simd>(
        &mut self,
        simd: S,
        plane: &DepthPlane,
        rank: u32,
        (area, tiles): (Area, Option<&[SeenTiles]>),
        draw: impl FnMut(Area) -> Drawn,
        covers: impl Fn(Area) -> bool,
    ) {
        if area.left >= area.right || area.top >= area.bottom {
            return;
        }
        let mut listed = std::mem::take(&mut self.listed);
        // No closure, which would be compiled for the oldest processor.
        let tiles = match tiles {
            Some(tiles) => tiles,
            None => {
                listed.clear();
                self.list_seen(simd, plane, rank, area, &mut listed);
                &listed
            }
        };
        self.draw_listed(plane, rank, tiles, draw, covers);
        self.listed = listed;
    }

    /// Lists the tiles of an area, which lies in the band, where something of a face may be seen: those of a block one
    /// after the other.
    #[inline(always)]
    pub(super) fn list_seen<S: Simd>(
        &self,
        simd: S,
        plane: &DepthPlane,
        rank: u32,
        area: Area,
        list: &mut Vec<SeenTiles>,
    ) {
        let [top, bottom] = [area.top, area.bottom - 1].map(|y| (y - self.first_row) / BLOCK_PX);
        let [left, right] = [area.left, area.right - 1].map(|x| x / BLOCK_PX);
        for row in (top - top % BLOCK_ROWS..=bottom).step_by(BLOCK_ROWS as usize) {
            for column in (left..=right).step_by(BLOCK_COLUMNS as usize) {
                let first = Cell { row, column };
                let mut seen = self.seen_blocks(simd, plane, rank, area, first);
                while seen != 0 {
                    let block = first.block(seen.trailing_zeros());
                    seen &= seen - 1;
                    let of_block = self.seen_tiles(simd, plane, rank, area, block);
                    if of_block.tiles != 0 {
                        list.push(of_block);
                    }
                }
            }
        }
    }

    /// As [`draw`](Self::draw), where the tiles are known.
    #[inline(always)]
    pub(super) fn draw_listed(
        &mut self,
        plane: &DepthPlane,
        rank: u32,
        tiles: &[SeenTiles],
        mut draw: impl FnMut(Area) -> Drawn,
        covers: impl Fn(Area) -> bool,
    ) {
        // What is drawn is compiled for this place, so that no closure may come between.
        for of_block in tiles {
            let (mut is_drawn, mut left) = (false, of_block.tiles);
            while left != 0 {
                let tile = of_block.tile(left.trailing_zeros());
                left &= left - 1;
                is_drawn |= self.draw_tile(plane, rank, tile, &mut draw);
            }
            if is_drawn {
                self.join(plane, rank, of_block.block, &covers);
            }
        }
    }

    /// Draws a face in a tile. Returns whether what is known of the tile is nearer then.
    #[inline(always)]
    fn draw_tile(&mut self, plane: &DepthPlane, rank: u32, tile: Cell, draw: &mut impl FnMut(Area) -> Drawn) -> bool {
        match draw(self.area(tile, TILE_PX)) {
            Drawn::Nothing => false,
            Drawn::Covered => self.offer_to_tile(plane, rank, tile),
            Drawn::Partly { bound, first_rank } => self.offer_to_tile(&bound, first_rank, tile),
        }
    }

    /// Takes what is known of a block's tiles for the block, after a face was drawn there.
    #[inline(always)]
    fn join(&mut self, plane: &DepthPlane, rank: u32, block: Cell, covers: &impl Fn(Area) -> bool) {
        if covers(self.area(block, BLOCK_PX)) {
            self.offer(plane, rank, block);
        } else {
            self.join_tiles(block, [plane.dx, plane.dy]);
        }
    }
}

/// How far from the middles of some cells the first and the last of these pixels are that are theirs.
#[inline(always)]
fn within<S: Simd>(middles: WideF<S>, [begin, end]: [i32; 2], half: f32) -> [WideF<S>; 2] {
    [(begin as f32 - middles).max(-half), ((end - 1) as f32 - middles).min(half)]
}

/// The tiles of a block that an area touches.
fn tiles_within(block: Area, area: Area, first_row: i32) -> impl Iterator<Item = Cell> {
    let tiles = |begin: i32, end: i32| begin / TILE_PX..=(end - 1) / TILE_PX;
    let rows = tiles(area.top.max(block.top) - first_row, area.bottom.min(block.bottom) - first_row);
    let columns = tiles(area.left.max(block.left), area.right.min(block.right));
    rows.flat_map(move |row| columns.clone().map(move |column| Cell { row, column }))
}

/// Tiles on a side of a block.
const TILES: i32 = BLOCK_PX / TILE_PX;

/// Tiles of a block.
const TILES_OF_BLOCK: usize = (TILES * TILES) as usize;

const _: () = assert!(TILES.count_ones() == 1 && TILES_OF_BLOCK == WIDE);

/// Rows of blocks that are looked at together.
const BLOCK_ROWS: i32 = 2;

/// Columns of blocks that are looked at together.
const BLOCK_COLUMNS: i32 = WIDE as i32 / BLOCK_ROWS;
