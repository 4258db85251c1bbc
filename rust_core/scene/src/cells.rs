//! A rectangle of small equal cells, each with a value that a palette colours (an occupancy grid).
//!
//! Reproduces what rviz's Map display draws with its `rviz/Indexed8BitImage` material: a flat rectangle whose texture
//! holds one byte a cell, looked up in a palette of 256 colours, without any filtering. The cells are kept in tiles, so
//! that changing some of them copies (and uploads to a GPU) only their tiles.

use std::sync::{Arc, OnceLock};

use crate::Blending;

/// Cells on a side of a tile; the tiles of the last column and row may be smaller.
pub const TILE_SIDE: u32 = 1024;

/// Value of cells that were never set: unknown in an occupancy grid.
pub const UNSET_CELL: u8 = 255;

/// The values of a rectangle of cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Cells {
    width: u32,
    height: u32,
    /// Row by row, in each tile the cells row by row.
    tiles: Vec<Arc<Vec<u8>>>,
}

/// A tile with its place, in cells.
#[derive(Clone, Copy, Debug)]
pub struct CellTile<'a> {
    /// Cells on the left of it.
    pub x: u32,
    /// Cells in front of it in the columns.
    pub y: u32,
    /// Its cells in a row.
    pub width: u32,
    /// Its rows.
    pub height: u32,
    /// The values, row by row.
    pub values: &'a Arc<Vec<u8>>,
}

fn full_blank_tile() -> Arc<Vec<u8>> {
    static BLANK: OnceLock<Arc<Vec<u8>>> = OnceLock::new();
    BLANK.get_or_init(|| Arc::new(vec![UNSET_CELL; (TILE_SIDE * TILE_SIDE) as usize])).clone()
}

impl Cells {
    /// Cells with these values, row by row; cells past the end of `values` are unset, and surplus values are
    /// ignored. Takes memory for `values`, and a little for each [`TILE_SIDE`]² cells beyond.
    pub fn new(width: u32, height: u32, values: &[u8]) -> Self {
        let mut tiles = Vec::with_capacity(width.div_ceil(TILE_SIDE) as usize * height.div_ceil(TILE_SIDE) as usize);
        for y in (0..height).step_by(TILE_SIDE as usize) {
            for x in (0..width).step_by(TILE_SIDE as usize) {
                let (tile_width, tile_height) = (TILE_SIDE.min(width - x) as usize, TILE_SIDE.min(height - y) as usize);
                let count = tile_width * tile_height;
                let begin = y as usize * width as usize + x as usize;
                if begin >= values.len() && count == (TILE_SIDE * TILE_SIDE) as usize {
                    tiles.push(full_blank_tile());
                    continue;
                }
                let mut tile = Vec::with_capacity(count);
                for row in 0..tile_height {
                    let begin = (begin + row * width as usize).min(values.len());
                    let end = (begin + tile_width).min(values.len());
                    tile.extend_from_slice(values.get(begin..end).unwrap_or_default());
                    tile.resize((row + 1) * tile_width, UNSET_CELL);
                }
                tiles.push(Arc::new(tile));
            }
        }
        Self { width, height, tiles }
    }

    /// Cells in a row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The value of a cell; unset outside.
    #[inline]
    pub fn get(&self, x: u32, y: u32) -> u8 {
        if x >= self.width || y >= self.height {
            return UNSET_CELL;
        }
        let (column, row) = (x / TILE_SIDE, y / TILE_SIDE);
        let tile = self.tiles.get((row * self.width.div_ceil(TILE_SIDE) + column) as usize);
        let tile_width = TILE_SIDE.min(self.width - column * TILE_SIDE);
        let place = (y % TILE_SIDE) * tile_width + x % TILE_SIDE;
        tile.and_then(|tile| tile.get(place as usize)).copied().unwrap_or(UNSET_CELL)
    }

    /// Replaces a rectangle of `width` cells a row from the cell (x, y) on by `values`, row by row; cells outside
    /// are ignored. Only the tiles that are touched are copied where they are shared.
    pub fn write(&mut self, [x, y]: [u32; 2], width: u32, values: &[u8]) {
        let columns = self.width.div_ceil(TILE_SIDE);
        for (row, values) in values.chunks_exact(width.max(1) as usize).enumerate() {
            let Some(y) = u32::try_from(row).ok().and_then(|row| y.checked_add(row)).filter(|y| *y < self.height)
            else {
                break;
            };
            let (mut x, mut values) = (x, values);
            while x < self.width && !values.is_empty() {
                let column = x / TILE_SIDE;
                let tile_width = TILE_SIDE.min(self.width - column * TILE_SIDE);
                let in_tile = x % TILE_SIDE;
                let (here, rest) = values.split_at(((tile_width - in_tile) as usize).min(values.len()));
                let place = ((y % TILE_SIDE) * tile_width + in_tile) as usize;
                let tile = self.tiles.get_mut((y / TILE_SIDE * columns + column) as usize).map(Arc::make_mut);
                if let Some(cells) = tile.and_then(|tile| tile.get_mut(place..place + here.len())) {
                    cells.copy_from_slice(here);
                }
                x += here.len() as u32;
                values = rest;
            }
        }
    }

    /// The tiles, row by row.
    pub fn tiles(&self) -> impl Iterator<Item = CellTile<'_>> + '_ {
        let columns = self.width.div_ceil(TILE_SIDE).max(1);
        self.tiles.iter().zip(0..).map(move |(values, index)| {
            let (x, y) = (index % columns * TILE_SIDE, index / columns * TILE_SIDE);
            CellTile { x, y, width: TILE_SIDE.min(self.width - x), height: TILE_SIDE.min(self.height - y), values }
        })
    }
}

/// Cells and their material: over the square from (0, 0) to (1, 1) of the plane z = 0 of the object's frame, the first
/// row along its x axis. Both sides are visible.
#[derive(Clone, Debug)]
pub struct CellSheet {
    /// The values.
    pub cells: Arc<Cells>,
    /// The colour of each value, red first.
    pub palette: Arc<[[u8; 4]; 256]>,
    /// Opacity of 0 to 1, multiplied with each colour's own.
    pub alpha: f32,
    /// Combination with the pixels behind it.
    pub blending: Blending,
    /// `true` if it occludes drawables that come later and are farther away.
    pub depth_write: bool,
}

impl CellSheet {
    /// Smallest depth steps by which it is moved back, so that drawables in the same plane are visible.
    pub const DEPTH_STEPS_BACK: f32 = 16.0;

    /// Corners of its two triangles.
    pub const TRIANGLES: [[[f32; 2]; 3]; 2] =
        [[[0.0, 0.0], [1.0, 1.0], [0.0, 1.0]], [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]];
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_across_tiles_are_found_and_replaced() {
        let (width, height) = (TILE_SIDE + 3, 2 * TILE_SIDE + 1);
        let value = |x: u32, y: u32| (x * 7 + y * 13) as u8;
        let values: Vec<u8> = (0..height).flat_map(|y| (0..width).map(move |x| value(x, y))).collect();
        let mut cells = Cells::new(width, height, &values);
        let before = cells.clone();
        for (x, y) in [(0, 0), (TILE_SIDE - 1, 5), (TILE_SIDE, 5), (width - 1, height - 1), (2, TILE_SIDE)] {
            assert_eq!(cells.get(x, y), value(x, y), "{x} {y}");
        }
        cells.write([TILE_SIDE - 1, TILE_SIDE - 1], 2, &[1, 2, 3, 4]);
        let written = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| cells.get(TILE_SIDE - 1 + x, TILE_SIDE - 1 + y));
        assert_eq!(written, [1, 2, 3, 4]);
        let shared = before.tiles().zip(cells.tiles()).filter(|(a, b)| Arc::ptr_eq(a.values, b.values)).count();
        assert_eq!(shared, 2, "the two tiles of the last row were not touched");
        assert_eq!(cells.tiles().map(|tile| tile.values.len()).sum::<usize>(), (width * height) as usize);
        cells.write([width - 1, height - 1], 2, &[9, 8, 7, 6]);
        assert_eq!(cells.get(width - 1, height - 1), 9);
        assert_eq!(cells.get(width, 0), UNSET_CELL);
    }

    #[test]
    fn cells_without_a_value_are_unset_and_take_little_memory() {
        let cells = Cells::new(30 * TILE_SIDE, 30 * TILE_SIDE, &[1, 2]);
        assert_eq!([cells.get(1, 0), cells.get(2, 0), cells.get(29 * TILE_SIDE, 5000)], [2, UNSET_CELL, UNSET_CELL]);
        let [a, b] = [900 - 1, 900 - 2].map(|i| cells.tiles().nth(i).unwrap().values.clone());
        assert!(Arc::ptr_eq(&a, &b));
    }
}
