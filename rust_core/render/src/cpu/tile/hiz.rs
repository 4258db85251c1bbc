//! Hierarchical z: how far away a band's pixels are already covered, by tile and by block of tiles.
//!
//! Thousands of faces may lie over each other on the image, such as a depth camera's cloud right before the lens.
//! Before its fragments are tested one by one, a face is compared with tiles of [`TILE_PX`] × [`TILE_PX`] pixels and
//! blocks of [`BLOCK_PX`] × [`BLOCK_PX`]:
//!
//! ```text
//! block, 32×32 px          tile, 8×8 px             pixels
//! ┌──┬──┬──┬──┐            ┌────────┐
//! │  │  │  │  │ ─ seen ──► │ bound  │ ─ seen ──►   depth test, then the tile's bound from the depths
//! ├──┼──┼──┼──┤            └────────┘              stored there, and the block's from its tiles
//! └──┴──┴──┴──┘
//! ```
//!
//! A cell (tile or block) keeps the largest depth of its pixels and a plane that none of them lies behind. The plane is
//! there because of faces that turn to the eye: neighbours differ by less than each of them changes over a tile, so
//! that the largest depth alone hides none of them. Both hold for good, as depths only decrease while a band is drawn.
//!
//! A face is hidden in a cell where it lies behind the cell's bound by more than both can be off: depths of fragments
//! are rounded, so that a plane comes with a bound of that, its `noise`. Of exactly equal depths the face of the higher
//! rank wins, so that a cell knows the lowest rank of its pixels. Which pixels are drawn is not changed by any of this,
//! only how many are tested.

use fearless_simd::prelude::*;
use fearless_simd::Simd;

use super::lanes::{inlined, wide_indices, WideF, WideU, WIDE};
use super::screen::{Area, DepthPlane, FARTHEST, TILE_PX};

/// Side of a block in pixels.
const BLOCK_PX: i32 = 32;

/// Tiles on a side of a block.
const TILES: i32 = BLOCK_PX / TILE_PX;

/// Tiles of a block.
const TILES_OF_BLOCK: usize = (TILES * TILES) as usize;

const _: () = assert!(TILES.count_ones() == 1 && TILES_OF_BLOCK == WIDE);

/// A face in the depth test of cells.
#[derive(Clone, Copy, Debug)]
pub(in crate::cpu) struct Face {
    /// Bound of its depths.
    pub plane: DepthPlane,
    /// Its place in the order of drawing.
    pub rank: u32,
    /// Its pixels, which lie in the band.
    pub area: Area,
}

/// A block of a band.
#[derive(Clone, Copy, Debug)]
pub(in crate::cpu) struct Block {
    row: i32,
    column: i32,
}

/// The bounds of cells of one size.
#[derive(Debug, Default)]
struct Level {
    side_px: i32,
    /// The plane at the cell's middle, in two parts whose sum has more digits than one; infinite where there is none.
    middle: Vec<f32>,
    rest: Vec<f32>,
    dx: Vec<f32>,
    dy: Vec<f32>,
    noise: Vec<f32>,
    /// The largest depth of the cell's pixels; infinite where it is not known.
    farthest: Vec<f32>,
    /// The lowest rank of its pixels.
    rank: Vec<u32>,
}

/// The bounds of a band's tiles and blocks.
#[derive(Debug, Default)]
pub(in crate::cpu) struct Hiz {
    /// Tiles of a block lie side by side, row by row.
    tiles: Level,
    blocks: Level,
    /// Blocks from row to row: behind each row there is room for those that are compared together.
    stride: usize,
    band: Area,
}

/// The numbers from `begin` on, which must exist.
#[inline(always)]
fn load<S: Simd>(simd: S, all: &[f32], begin: usize) -> WideF<S> {
    let numbers = all.get(begin..).and_then(<[f32]>::first_chunk);
    numbers.map_or(WideF::splat(simd, 0.0), |numbers| WideF::load_array_ref(simd, numbers))
}

/// The distances from the middles of cells to the first and to the last of these pixels that are theirs.
#[inline(always)]
fn within<S: Simd>(middles: WideF<S>, [begin, end]: [i32; 2], half: f32) -> [WideF<S>; 2] {
    [(begin as f32 - middles).max(-half), ((end - 1) as f32 - middles).min(half)]
}

/// The numbers of the bits that are set, from the lowest on.
#[inline(always)]
fn bits(mut set: u32) -> impl Iterator<Item = u32> {
    std::iter::from_fn(
        #[inline(always)]
        move || {
            let bit = (set != 0).then(|| set.trailing_zeros());
            set &= set.wrapping_sub(1);
            bit
        },
    )
}

/// The smallest number that is not below this one.
fn not_below(exact: f64) -> f32 {
    let rounded = exact as f32;
    if f64::from(rounded) < exact {
        rounded.next_up()
    } else {
        rounded
    }
}

impl Level {
    /// Forgets all, and has this number of cells.
    fn reset(&mut self, side_px: i32, count: usize) {
        self.side_px = side_px;
        for numbers in [&mut self.rest, &mut self.dx, &mut self.dy, &mut self.noise] {
            numbers.clear();
            numbers.resize(count, 0.0);
        }
        for numbers in [&mut self.middle, &mut self.farthest] {
            numbers.clear();
            numbers.resize(count, f32::INFINITY);
        }
        self.rank.clear();
        self.rank.resize(count, 0);
    }

    /// From the middle of a cell to the middle of its last pixel.
    #[inline(always)]
    fn half(&self) -> f32 {
        (self.side_px - 1) as f32 * 0.5
    }

    /// The cells among [`WIDE`] from `begin` on, given their middles, in which something of a face may be seen.
    #[inline(always)]
    fn visible<S: Simd>(&self, simd: S, face: &Face, begin: usize, [x, y]: [WideF<S>; 2]) -> u32 {
        let Face { plane, rank, area } = face;
        let columns = within(x, [area.left, area.right], self.half());
        let rows = within(y, [area.top, area.bottom], self.half());
        let touched = columns[0].simd_le(columns[1]) & rows[0].simd_le(rows[1]);
        let numbers = inlined(
            #[inline(always)]
            |all: &[f32]| load(simd, all, begin),
        );
        let ranks = self.rank.get(begin..).and_then(<[u32]>::first_chunk);
        let is_earlier = ranks.map_or(WideU::splat(simd, 0), |ranks| WideU::load_array_ref(simd, ranks)).simd_gt(*rank);
        let apart = plane.at - numbers(&self.middle);
        let (right, down) = ((x - plane.x) * plane.dx, (y - plane.y) * plane.dy);
        let (dx, dy) = (plane.dx - numbers(&self.dx), plane.dy - numbers(&self.dy));
        // Where the planes are nearest to each other.
        let (along_row, along_column) = ((dx * columns[0]).min(dx * columns[1]), (dy * rows[0]).min(dy * rows[1]));
        let behind = (apart + (right + down)) + ((along_row + along_column) - numbers(&self.rest));
        // Beside the planes' noise, that of the sums here.
        let sums = (apart.abs() + (right.abs() + down.abs())) + (along_row.abs() + along_column.abs());
        let unsure = sums * (1.0 / (1 << 20) as f32);
        let unsure = unsure + (numbers(&self.noise) + plane.noise);
        let is_hidden = behind.simd_gt(unsure) | (behind.simd_ge(unsure) & is_earlier);
        // The plane of a steep face leads far before it, but nothing of the face is nearer than its nearest corner.
        let (least, farthest) = (WideF::splat(simd, plane.least), numbers(&self.farthest));
        let is_hidden = is_hidden | least.simd_gt(farthest) | (least.simd_ge(farthest) & is_earlier);
        touched.to_bitmask() as u32 & !(is_hidden.to_bitmask() as u32)
    }

    /// The most that a cell's depths are above a plane of these slopes that has depth 0 in the cell's middle.
    fn bound_along(&self, cell: usize, [dx, dy]: [f64; 2]) -> f64 {
        let slopes = (f64::from(self.dx[cell]) - dx).abs() + (f64::from(self.dy[cell]) - dy).abs();
        let middle = f64::from(self.middle[cell]) + f64::from(self.rest[cell]);
        middle + slopes * f64::from(self.half()) + f64::from(self.noise[cell])
    }

    /// Takes a plane that no pixel of a cell lies behind, given the cell's middle, if it is nearer than the known one.
    /// Returns true if it is.
    fn offer(&mut self, plane: &DepthPlane, rank: u32, cell: usize, [x, y]: [f64; 2]) -> bool {
        let value = plane.value(x, y);
        let slopes = f64::from(plane.dx.abs()) + f64::from(plane.dy.abs());
        let extent = slopes * f64::from(self.half()) + f64::from(plane.noise);
        // Depths are clamped outside of these, so that a plane says less about them.
        if !(value - extent > 0.0 && value + extent < f64::from(FARTHEST)) {
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
        self.farthest[cell] = not_below(value + extent);
        true
    }
}

impl Hiz {
    /// Forgets all, for the pixels of a band.
    pub(in crate::cpu) fn reset(&mut self, band: Area) {
        self.stride = (band.right as usize).div_ceil(BLOCK_PX as usize) + WIDE;
        let rows = ((band.bottom - band.top) as usize).div_ceil(BLOCK_PX as usize);
        self.blocks.reset(BLOCK_PX, self.stride * rows);
        self.tiles.reset(TILE_PX, self.stride * rows * TILES_OF_BLOCK);
        self.band = band;
    }

    /// The blocks that an area touches: [`WIDE`] side by side, by the first of them.
    #[inline(always)]
    pub(in crate::cpu) fn blocks(&self, area: Area) -> impl Iterator<Item = Block> + use<> {
        let [top, bottom] = [area.top, area.bottom - 1].map(|y| (y - self.band.top) / BLOCK_PX);
        let [left, right] = [area.left, area.right - 1].map(|x| x / BLOCK_PX);
        let rows = if area.is_empty() { 0..0 } else { top..bottom + 1 };
        rows.flat_map(move |row| (left..=right).step_by(WIDE).map(move |column| Block { row, column }))
    }

    /// The blocks among [`WIDE`] side by side in which something of a face may be seen, given the first.
    #[inline(always)]
    pub(in crate::cpu) fn visible_blocks<S: Simd>(
        &self,
        simd: S,
        face: &Face,
        first: Block,
    ) -> impl Iterator<Item = Block> + use<S> {
        let half = self.blocks.half();
        let y = WideF::splat(simd, (self.band.top + first.row * BLOCK_PX) as f32 + half);
        let x = wide_indices(simd).to_float::<WideF<S>>() * BLOCK_PX as f32 + ((first.column * BLOCK_PX) as f32 + half);
        let seen = self.blocks.visible(simd, face, self.place(first), [x, y]);
        bits(seen).map(move |bit| Block { column: first.column + bit as i32, ..first })
    }

    /// The tiles of a block in which something of a face may be seen, counted row by row.
    #[inline(always)]
    pub(in crate::cpu) fn visible_tiles<S: Simd>(
        &self,
        simd: S,
        face: &Face,
        block: Block,
    ) -> impl Iterator<Item = u32> + use<S> {
        let half = self.tiles.half();
        let lane = wide_indices(simd);
        let [right, down] = [lane & (TILES - 1), lane >> TILES.ilog2()];
        let x = right.to_float::<WideF<S>>() * TILE_PX as f32 + ((block.column * BLOCK_PX) as f32 + half);
        let y = down.to_float::<WideF<S>>() * TILE_PX as f32 + ((self.band.top + block.row * BLOCK_PX) as f32 + half);
        bits(self.tiles.visible(simd, face, self.place(block) * TILES_OF_BLOCK, [x, y]))
    }

    /// The index of a block.
    #[inline(always)]
    fn place(&self, block: Block) -> usize {
        block.row as usize * self.stride + block.column as usize
    }

    /// The pixels of a block's tile.
    #[inline(always)]
    pub(in crate::cpu) fn area(&self, block: Block, tile: u32) -> Area {
        let (row, column) = (tile as i32 / TILES, tile as i32 % TILES);
        let (left, top) =
            (block.column * BLOCK_PX + column * TILE_PX, self.band.top + block.row * BLOCK_PX + row * TILE_PX);
        Area { left, right: (left + TILE_PX).min(self.band.right), top, bottom: (top + TILE_PX).min(self.band.bottom) }
    }

    /// Takes a plane that no pixel of a tile lies behind, and the lowest rank of these. Returns true if it is nearer
    /// than the known one.
    pub(in crate::cpu) fn offer(&mut self, block: Block, tile: u32, plane: &DepthPlane, rank: u32) -> bool {
        let area = self.area(block, tile);
        let middle = [area.left, area.top].map(|first| f64::from(first) + f64::from(self.tiles.half()));
        let cell = self.place(block) * TILES_OF_BLOCK + tile as usize;
        self.tiles.offer(plane, rank, cell, middle)
    }

    /// Bounds a block by the bounds of its tiles: by one depth for all, or by a plane of these changes to the right and
    /// down.
    pub(in crate::cpu) fn join(&mut self, block: Block, [dx, dy]: [f32; 2]) {
        let (mut farthest, mut first_rank, mut at_middle) = (0.0_f32, u32::MAX, 0.0_f64);
        let slopes = [dx, dy].map(f64::from);
        let first = [block.column * BLOCK_PX, self.band.top + block.row * BLOCK_PX];
        let tiles_to = |end: i32, first: i32| ((end - first).min(BLOCK_PX) + TILE_PX - 1) / TILE_PX;
        let (columns, rows) = (tiles_to(self.band.right, first[0]), tiles_to(self.band.bottom, first[1]));
        let begin = self.place(block) * TILES_OF_BLOCK;
        for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
            let tile = begin + (row * TILES + column) as usize;
            farthest = farthest.max(self.tiles.farthest[tile]);
            first_rank = first_rank.min(self.tiles.rank[tile]);
            let [right, down] = [column, row].map(|i| f64::from((2 * i + 1 - TILES) * TILE_PX) * 0.5);
            let bound = self.tiles.bound_along(tile, slopes);
            at_middle = at_middle.max(bound - (slopes[0] * right + slopes[1] * down));
        }
        let middle = first.map(|first| f64::from(first) + f64::from(self.blocks.half()));
        let mut plane = DepthPlane::level(farthest);
        if at_middle < f64::from(farthest) {
            let [x, y] = middle.map(|at| at as f32);
            plane = DepthPlane { at: not_below(at_middle), dx, dy, x, y, ..plane };
        }
        self.blocks.offer(&plane, first_rank, self.place(block), middle);
    }
}
