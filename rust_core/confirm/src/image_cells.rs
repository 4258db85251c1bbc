//! Cells of the finished image, after lens and flip, and the cells of the drawn image that they show.

use std::sync::Arc;

use rcs_scene::{Camera, Flip, MapRun, PixelMap};

use crate::cells::{cells_of, CELL_PX};
use crate::surface::Bounds;
use crate::tiles::{TileRange, Tiles, TILE_CELLS};

/// Fixed-point one of a [`PixelMap`]'s places.
const ONE: f64 = 65536.0;

/// An image cell that shows no cell of the drawn image.
const BESIDE: u32 = u32::MAX;

/// For each cell of the finished image, the cell of the drawn image that it shows.
#[derive(Debug)]
pub(crate) struct ImageCells {
    lens: Option<Arc<PixelMap>>,
    flip: Flip,
    drawn_px: [u32; 2],
    drawn_cells: Vec<u32>,
    /// For each tile of the finished image, the tiles of the drawn image that its cells show.
    drawn_tiles: Vec<TileRange>,
}

/// Width and height of a camera's finished image.
pub(crate) fn image_px(camera: &Camera) -> [u32; 2] {
    camera.lens().map_or([camera.width_px(), camera.height_px()], |lens| lens.size_px())
}

/// `true` if a camera's finished image is what was drawn.
pub(crate) fn is_as_drawn(camera: &Camera) -> bool {
    camera.lens().is_none() && camera.flip() == Flip::NONE
}

impl ImageCells {
    pub(crate) fn new(camera: &Camera) -> Self {
        let size_px = image_px(camera);
        let drawn_px = [camera.width_px(), camera.height_px()];
        let [columns, rows] = cells_of(size_px);
        let [drawn_columns, drawn_rows] = cells_of(drawn_px);
        let mut drawn_cells = Vec::with_capacity(columns * rows);
        let tile_columns = columns.div_ceil(TILE_CELLS);
        let mut drawn_tiles = vec![TileRange::EMPTY; tile_columns * rows.div_ceil(TILE_CELLS)];
        for row in 0..rows {
            let first = row as u32 * CELL_PX as u32;
            let last = (first + CELL_PX as u32 - 1).min(size_px[1] - 1);
            let places = [first, last].map(|row| places_of_row(camera, size_px, row));
            drawn_cells.extend((0..columns).map(|column| {
                let pixels = column * CELL_PX..((column + 1) * CELL_PX).min(size_px[0] as usize);
                let known = places.iter().flat_map(|row| &row[pixels.clone()]).flatten();
                let (sum, count) =
                    known.fold(([0.0; 2], 0.0), |([u, v], count), place| ([u + place[0], v + place[1]], count + 1.0));
                let [u, v] = sum.map(|sum| sum / count / CELL_PX as f64);
                let is_drawn = u >= 0.0 && v >= 0.0 && u < drawn_columns as f64 && v < drawn_rows as f64;
                if is_drawn {
                    let tile = &mut drawn_tiles[row / TILE_CELLS * tile_columns + column / TILE_CELLS];
                    *tile = tile.with(TileRange::between([u as f32, v as f32], [u as f32, v as f32]));
                    v as u32 * drawn_columns as u32 + u as u32
                } else {
                    BESIDE
                }
            }));
        }
        Self { lens: camera.lens().cloned(), flip: camera.flip(), drawn_px, drawn_cells, drawn_tiles }
    }

    /// `true` if these are the cells of the camera.
    pub(crate) fn are_of(&self, camera: &Camera) -> bool {
        let is_lens = match (&self.lens, camera.lens()) {
            (Some(own), Some(other)) => Arc::ptr_eq(own, other) || own == other,
            (None, None) => true,
            _ => false,
        };
        is_lens && self.flip == camera.flip() && self.drawn_px == [camera.width_px(), camera.height_px()]
    }

    /// Replaces a set by the tiles of the drawn image that tiles of the finished image show.
    pub(crate) fn see_tiles(&self, image: &Tiles, drawn: &mut Tiles) {
        drawn.reset(cells_of(self.drawn_px));
        let lit = self.drawn_tiles.iter().zip(image.flags()).filter(|(_, is_lit)| *is_lit);
        lit.for_each(|(range, _)| drawn.add(*range));
    }

    /// Writes the bounds of the finished image's cells.
    pub(crate) fn see(&self, drawn: &Bounds, size_px: [u32; 2], seen: &mut Bounds) {
        seen.fit(cells_of(size_px));
        let Bounds { nearest, farthest, .. } = seen;
        for ((from, nearest), farthest) in self.drawn_cells.iter().zip(nearest).zip(farthest) {
            let from = *from as usize;
            *nearest = drawn.nearest.get(from).copied().unwrap_or(f32::NAN);
            *farthest = drawn.farthest.get(from).copied().unwrap_or(f32::NAN);
        }
    }
}

/// Places in the drawn image, pixels from its edges, of the centres of a row of the finished image.
fn places_of_row(camera: &Camera, size_px: [u32; 2], row: u32) -> Vec<Option<[f64; 2]>> {
    let flip = camera.flip();
    let unflipped = flip.row(size_px[1] as usize, row as usize) as u32;
    let mut places = vec![None; size_px[0] as usize];
    match camera.lens() {
        None => (0..).zip(&mut places).for_each(|(column, place)| {
            *place = Some([f64::from(column) + 0.5, f64::from(unflipped) + 0.5]);
        }),
        Some(map) => {
            let (columns, runs) = map.runs(unflipped);
            let pixels = places.iter_mut().skip(columns.start as usize).take(columns.len());
            let seen = runs.flat_map(|run| {
                (0..MapRun::PIXELS as i32).map(move |i| [0, 1].map(|axis| run.place[axis] + i * run.step[axis]))
            });
            for (pixel, place) in pixels.zip(seen) {
                *pixel = Some(place.map(|place| f64::from(place) / ONE + 0.5));
            }
        }
    }
    if flip.is_left_right {
        places.reverse();
    }
    places
}
