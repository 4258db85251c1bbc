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
use super::lanes::{inlined, lane_indices, load, F, LANES, U};
use super::screen::FARTHEST;

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
    fn value(&self, x: f64, y: f64) -> f64 {
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

/// Cells of one size.
#[derive(Debug, Default)]
struct Level {
    side: f32,
    /// The band's first row.
    first_row: f32,
    /// Cells from row to row.
    stride: usize,
    /// The plane at the cell's middle, in two parts whose sum has more digits than one; infinite where there is none.
    middle: Vec<f32>,
    rest: Vec<f32>,
    dx: Vec<f32>,
    dy: Vec<f32>,
    noise: Vec<f32>,
    rank: Vec<u32>,
}

impl Level {
    fn reset(&mut self, side: i32, width_px: i32, rows: i32, first_row: i32) {
        (self.side, self.first_row) = (side as f32, first_row as f32);
        // Behind each row of cells there is room for a window's.
        self.stride = (width_px as usize).div_ceil(side as usize) + LANES;
        let cells = self.stride * (rows as usize).div_ceil(side as usize);
        for numbers in [&mut self.rest, &mut self.dx, &mut self.dy, &mut self.noise] {
            numbers.clear();
            numbers.resize(cells, 0.0);
        }
        self.middle.clear();
        self.middle.resize(cells, f32::INFINITY);
        self.rank.clear();
        self.rank.resize(cells, 0);
    }

    /// In which of [`LANES`] cells from `column` on something of a face may be seen.
    #[inline(always)]
    fn seen<S: Simd>(&self, simd: S, plane: &DepthPlane, rank: u32, row: i32, column: i32) -> u32 {
        let begin = row as usize * self.stride + column as usize;
        let numbers = inlined(
            #[inline(always)]
            |all: &[f32]| load(simd, all, begin),
        );
        let half = (self.side - 1.0) * 0.5;
        let y = self.first_row + row as f32 * self.side + half - plane.y;
        let x = lane_indices(simd).to_float::<F<S>>() * self.side + (column as f32 * self.side + half - plane.x);
        let apart = plane.at - numbers(&self.middle);
        let (right, down) = (x * plane.dx, plane.dy * y);
        let (cell_dx, cell_dy) = (numbers(&self.dx), numbers(&self.dy));
        let slopes = (plane.dx - cell_dx).abs() + (plane.dy - cell_dy).abs();
        let behind = (apart + (right + down)) - (numbers(&self.rest) + slopes * half);
        // Beside the planes' noise, that of the sums here.
        let unsure = (apart.abs() + (right.abs() + down.abs()) + slopes * half) * (1.0 / (1 << 20) as f32);
        let unsure = unsure + (numbers(&self.noise) + plane.noise);
        let ranks = self.rank.get(begin..).and_then(<[u32]>::first_chunk);
        let is_earlier = ranks.map_or(U::splat(simd, 0), |ranks| U::load_array_ref(simd, ranks)).simd_gt(rank);
        let is_hidden = behind.simd_gt(unsure) | (behind.simd_ge(unsure) & is_earlier);
        // The plane of a steep face leads far before it, but nothing of the face is nearer than its nearest corner.
        let reach = (cell_dx.abs() + cell_dy.abs()) * half + (numbers(&self.noise) + numbers(&self.rest).abs());
        let behind = plane.least - (numbers(&self.middle) + reach);
        let zero = F::splat(simd, 0.0);
        let unsure = reach.simd_gt(0.0).select(reach * (1.0 / (1 << 20) as f32) + 4.0, zero);
        let is_hidden = is_hidden | behind.simd_gt(unsure) | (behind.simd_ge(unsure) & is_earlier);
        !(is_hidden.to_bitmask() as u32) & ((1 << LANES) - 1)
    }

    /// The largest depth in a cell, and a rank that none is below of pixels of this depth.
    fn bound(&self, row: i32, column: i32) -> (f64, u32) {
        let cell = row as usize * self.stride + column as usize;
        let half = f64::from(self.side - 1.0) * 0.5;
        let slopes = f64::from(self.dx[cell].abs()) + f64::from(self.dy[cell].abs());
        let middle = f64::from(self.middle[cell]) + f64::from(self.rest[cell]);
        (middle + slopes * half + f64::from(self.noise[cell]), self.rank[cell])
    }

    /// The largest of what a cell's depths are above a plane of these slopes that has depth 0 in the cell's middle.
    fn bound_along(&self, row: i32, column: i32, [dx, dy]: [f64; 2]) -> f64 {
        let cell = row as usize * self.stride + column as usize;
        let half = f64::from(self.side - 1.0) * 0.5;
        let slopes = (f64::from(self.dx[cell]) - dx).abs() + (f64::from(self.dy[cell]) - dy).abs();
        let middle = f64::from(self.middle[cell]) + f64::from(self.rest[cell]);
        middle + slopes * half + f64::from(self.noise[cell])
    }

    /// Takes the plane of a face that covers a cell, if it is nearer than the one that is there; says whether it is.
    fn offer(&mut self, plane: &DepthPlane, rank: u32, row: i32, column: i32) -> bool {
        let cell = row as usize * self.stride + column as usize;
        let half = f64::from(self.side - 1.0) * 0.5;
        let x = f64::from(column) * f64::from(self.side) + half;
        let y = f64::from(self.first_row) + f64::from(row) * f64::from(self.side) + half;
        let value = plane.value(x, y);
        let reach = (f64::from(plane.dx.abs()) + f64::from(plane.dy.abs())) * half + f64::from(plane.noise);
        // Depths are clamped outside of these, so that a plane says less about them.
        if !(value - reach > 0.0 && value + reach < f64::from(FARTHEST)) {
            return false;
        }
        let Some(middle) = self.middle.get_mut(cell) else { return false };
        let known = f64::from(*middle) + f64::from(self.rest[cell]) + f64::from(self.noise[cell]);
        let offered = value + f64::from(plane.noise);
        if offered > known || (offered == known && rank <= self.rank[cell]) {
            return false;
        }
        *middle = value as f32;
        self.rest[cell] = (value - f64::from(*middle)) as f32;
        (self.dx[cell], self.dy[cell]) = (plane.dx, plane.dy);
        (self.noise[cell], self.rank[cell]) = (plane.noise, rank);
        true
    }
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
    tiles: Level,
    blocks: Level,
    width: i32,
    first_row: i32,
    end_row: i32,
    /// No pixel of the band is farther away.
    farthest: f32,
    /// How many faces may come before that is asked again.
    until_asked: u32,
    /// Memory for the tiles of a face.
    listed: Vec<Cell>,
}

/// Pixels from left to before right and from top to before bottom.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Area {
    pub left: i32,
    pub right: i32,
    pub top: i32,
    pub bottom: i32,
}

/// A cell of which something may be seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Cell {
    row: i32,
    column: i32,
}

impl Cell {
    /// The block that a tile is in.
    fn block(self) -> Self {
        Self { row: self.row / TILES, column: self.column / TILES }
    }
}

impl Occluders {
    /// Forgets all, for a band of these rows.
    pub(super) fn reset(&mut self, width: i32, first_row: i32, end_row: i32) {
        self.tiles.reset(TILE_PX, width, end_row - first_row, first_row);
        self.blocks.reset(BLOCK_PX, width, end_row - first_row, first_row);
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
            None => (self.farthest, self.until_asked) = ((self.farthest() as f32).next_up(), Self::FACES_TO_ASK),
        }
        nearest > self.farthest
    }

    /// The pixels of a cell.
    fn area(&self, cell: Cell, side: i32) -> Area {
        let (left, top) = (cell.column * side, self.first_row + cell.row * side);
        Area { left, right: (left + side).min(self.width), top, bottom: (top + side).min(self.end_row) }
    }

    /// The largest depth in the whole band; infinite where that is not known.
    pub(super) fn farthest(&self) -> f64 {
        let columns = (self.width + BLOCK_PX - 1) / BLOCK_PX;
        let rows = (self.end_row - self.first_row + BLOCK_PX - 1) / BLOCK_PX;
        let cells = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
        cells.map(|(row, column)| self.blocks.bound(row, column).0).fold(0.0, f64::max)
    }

    /// Whether nothing is seen of a face within an area, which lies in the band.
    #[inline(always)]
    pub(super) fn hides<S: Simd>(&self, simd: S, plane: &DepthPlane, rank: u32, area: Area) -> bool {
        let [top, bottom] = [area.top, area.bottom - 1].map(|y| (y - self.first_row) / BLOCK_PX);
        let [left, right] = [area.left, area.right - 1].map(|x| x / BLOCK_PX);
        for row in top..=bottom {
            for column in (left..=right).step_by(LANES) {
                let mut seen = self.blocks.seen(simd, plane, rank, row, column) & up_to(right - column);
                while seen != 0 {
                    let block = Cell { row, column: column + seen.trailing_zeros() as i32 };
                    seen &= seen - 1;
                    if self.seen_tiles(simd, plane, rank, area, block) != [0; TILES as usize] {
                        return false;
                    }
                }
            }
        }
        true
    }

    /// The tiles of a block, row by row, in which something of a face may be seen.
    #[inline(always)]
    fn seen_tiles<S: Simd>(
        &self,
        simd: S,
        plane: &DepthPlane,
        rank: u32,
        area: Area,
        block: Cell,
    ) -> [u32; TILES as usize] {
        let mut seen = [0; TILES as usize];
        let column = block.column * TILES;
        let [left, right] = [area.left, area.right - 1].map(|x| x / TILE_PX - column);
        let [top, bottom] = [area.top, area.bottom - 1].map(|y| (y - self.first_row) / TILE_PX - block.row * TILES);
        let columns = up_to(right.min(TILES - 1)) & !(up_to(left - 1));
        for row in top.max(0)..=bottom.min(TILES - 1) {
            seen[row as usize] = columns & self.tiles.seen(simd, plane, rank, block.row * TILES + row, column);
        }
        seen
    }

    /// Takes what is known of a block's tiles for the block: one depth for all, or a plane of these changes to the
    /// right and down.
    fn join_tiles(&mut self, block: Cell, [dx, dy]: [f32; 2]) {
        let (mut farthest, mut first_rank) = (0.0_f64, u32::MAX);
        let mut at_middle = 0.0_f64;
        let slopes = [dx, dy].map(f64::from);
        let middle = f64::from(TILES - 1) * 0.5;
        let area = self.area(block, BLOCK_PX);
        let (columns, rows) =
            ((area.right - area.left + TILE_PX - 1) / TILE_PX, (area.bottom - area.top + TILE_PX - 1) / TILE_PX);
        for row in (block.row * TILES..).take(rows as usize) {
            for column in (block.column * TILES..).take(columns as usize) {
                let (bound, rank) = self.tiles.bound(row, column);
                (farthest, first_rank) = (farthest.max(bound), first_rank.min(rank));
                let tiles = [column - block.column * TILES, row - block.row * TILES].map(|i| f64::from(i) - middle);
                let [right, down] = tiles.map(|tiles| tiles * f64::from(TILE_PX));
                let bound = self.tiles.bound_along(row, column, slopes) - (slopes[0] * right + slopes[1] * down);
                at_middle = at_middle.max(bound);
            }
        }
        // To a number that is not smaller.
        let mut plane = DepthPlane::level((farthest as f32).next_up());
        if at_middle < farthest {
            let half = (BLOCK_PX - 1) as f32 * 0.5;
            let (left, top) = (block.column * BLOCK_PX, self.first_row + block.row * BLOCK_PX);
            let at = (at_middle as f32).next_up();
            plane = DepthPlane { at, dx, dy, x: left as f32 + half, y: top as f32 + half, ..plane };
        }
        self.blocks.offer(&plane, first_rank, block.row, block.column);
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
                        is_nearer |= self.tiles.offer(&bound, first_rank, tile.row, tile.column);
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
        (area, tiles): (Area, Option<&[Cell]>),
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
    pub(super) fn list_seen<S: Simd>(&self, simd: S, plane: &DepthPlane, rank: u32, area: Area, list: &mut Vec<Cell>) {
        let [top, bottom] = [area.top, area.bottom - 1].map(|y| (y - self.first_row) / BLOCK_PX);
        let [left, right] = [area.left, area.right - 1].map(|x| x / BLOCK_PX);
        for row in top..=bottom {
            for column in (left..=right).step_by(LANES) {
                let mut seen = self.blocks.seen(simd, plane, rank, row, column) & up_to(right - column);
                while seen != 0 {
                    let block = Cell { row, column: column + seen.trailing_zeros() as i32 };
                    seen &= seen - 1;
                    for (i, tiles) in self.seen_tiles(simd, plane, rank, area, block).into_iter().enumerate() {
                        let mut tiles = tiles;
                        while tiles != 0 {
                            let column = block.column * TILES + tiles.trailing_zeros() as i32;
                            tiles &= tiles - 1;
                            list.push(Cell { row: row * TILES + i as i32, column });
                        }
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
        tiles: &[Cell],
        mut draw: impl FnMut(Area) -> Drawn,
        covers: impl Fn(Area) -> bool,
    ) {
        // What is drawn is compiled for this place, so that no closure may come between.
        for of_block in tiles.chunk_by(|a, b| a.block() == b.block()) {
            let mut is_drawn = false;
            for tile in of_block {
                is_drawn |= self.draw_tile(plane, rank, *tile, &mut draw);
            }
            if let (true, Some(tile)) = (is_drawn, of_block.first()) {
                self.join(plane, rank, tile.block(), &covers);
            }
        }
    }

    /// Draws a face in a tile. Returns whether what is known of the tile is nearer then.
    #[inline(always)]
    fn draw_tile(&mut self, plane: &DepthPlane, rank: u32, tile: Cell, draw: &mut impl FnMut(Area) -> Drawn) -> bool {
        match draw(self.area(tile, TILE_PX)) {
            Drawn::Nothing => false,
            Drawn::Covered => self.tiles.offer(plane, rank, tile.row, tile.column),
            Drawn::Partly { bound, first_rank } => self.tiles.offer(&bound, first_rank, tile.row, tile.column),
        }
    }

    /// Takes what is known of a block's tiles for the block, after a face was drawn there.
    #[inline(always)]
    fn join(&mut self, plane: &DepthPlane, rank: u32, block: Cell, covers: &impl Fn(Area) -> bool) {
        if covers(self.area(block, BLOCK_PX)) {
            self.blocks.offer(plane, rank, block.row, block.column);
        } else {
            self.join_tiles(block, [plane.dx, plane.dy]);
        }
    }
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

/// Bits up to this one, which may be -1 for none, of those that there are lanes.
#[inline(always)]
fn up_to(bit: i32) -> u32 {
    match bit {
        ..0 => 0,
        bit if bit >= LANES as i32 - 1 => (1 << LANES) - 1,
        bit => (2 << bit) - 1,
    }
}
