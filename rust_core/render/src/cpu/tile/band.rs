//! The pixels of one band of rows: colour and depth, and how fragments are tested and blended.
//!
//! A worker draws one band after another into the same two buffers, which stay in its core's cache; a finished band
//! goes to the image at once, so that no frame buffer of the whole image exists. Colours are 8-bit and every
//! blend rounds, with the arithmetic of Mesa's rasteriser.

use std::ops::Range;

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd};

use super::color::{blend, blend_lanes};
pub(in crate::cpu) use super::color::{pack, unorm8};
use super::hiz::{Face, Hiz};
use super::lanes::{lane_indices, F, LANES, M, U};
use super::screen::{rounding, Area, DepthPlane, Screen, FARTHEST, TILE_PX};
use crate::depths::least_object_alpha;

/// How fragments are combined with the pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::cpu) struct Mode {
    /// `colour · alpha + behind · (1 − alpha)`, else the colour replaces.
    pub blend: bool,
    /// A nearer pixel hides the fragment.
    pub depth_test: bool,
    /// The fragment's depth is kept.
    pub depth_write: bool,
}

impl Mode {
    /// Hides what is behind.
    pub(in crate::cpu) const OPAQUE: Self = Self { blend: false, depth_test: true, depth_write: true };
    /// Blends with what is behind and leaves its depth.
    pub(in crate::cpu) const TRANSLUCENT: Self = Self { blend: true, depth_test: true, depth_write: false };

    /// One of the two.
    pub(in crate::cpu) const fn new(blend: bool) -> Self {
        if blend {
            Self::TRANSLUCENT
        } else {
            Self::OPAQUE
        }
    }

    /// The least alpha from which a fragment of a listed display is the pixel's object, or one of another display
    /// replaces it.
    #[inline(always)]
    fn least_object_alpha(self, is_listed: bool) -> u8 {
        if self.blend {
            least_object_alpha(is_listed)
        } else {
            0
        }
    }
}

/// The buffers that a worker keeps.
#[derive(Debug, Default)]
pub(in crate::cpu) struct BandBuffers {
    color: Vec<u32>,
    depth: Vec<f32>,
    object: Vec<f32>,
    rank: Vec<u32>,
    hiz: Hiz,
}

impl BandBuffers {
    /// The band of this index, cleared; with the depths of objects, if these are wanted.
    pub(in crate::cpu) fn begin(
        &mut self,
        screen: &Screen,
        index: usize,
        background: u32,
        has_objects: bool,
    ) -> Band<'_> {
        let first_row = index * screen.band_rows();
        let rows = screen.band_rows().min((screen.height_px as usize).saturating_sub(first_row));
        let width = screen.width_px as usize;
        let stride = width + LANES;
        self.color.clear();
        self.color.resize(stride * rows, background);
        self.depth.clear();
        self.depth.resize(stride * rows, FARTHEST);
        self.object.clear();
        self.object.resize(if has_objects { stride * rows } else { 0 }, FARTHEST);
        Band {
            width: width as i32,
            first_row: first_row as i32,
            end_row: (first_row + rows) as i32,
            simd_level: screen.simd_level,
            stride,
            color: &mut self.color,
            depth: &mut self.depth,
            objects: has_objects.then_some(ObjectDepths { depths: self.object.as_mut_slice(), is_listed: false }),
            ranks: &mut self.rank,
            hiz: &mut self.hiz,
            rank: IN_ORDER,
            next_rank: IN_ORDER,
        }
    }
}

/// The rank of faces that are drawn in their order.
const IN_ORDER: u32 = 0;

/// A band that is being drawn.
///
/// Faces are drawn in their order, or in any order by their ranks: of equal depths the higher rank wins then, and what
/// is hidden is looked for before it is drawn.
#[derive(Debug)]
pub(in crate::cpu) struct Band<'a> {
    /// Pixels in a row.
    pub width: i32,
    /// The band's first row in the image.
    pub first_row: i32,
    /// The row after its last.
    pub end_row: i32,
    /// The instruction set that loops over pixels use.
    pub simd_level: Level,
    /// Pixels from row to row: behind each row there is room for what sticks out of it.
    stride: usize,
    color: &'a mut [u32],
    depth: &'a mut [f32],
    /// Present where the depths of objects are wanted.
    objects: Option<ObjectDepths<&'a mut [f32]>>,
    /// The rank of the face that each pixel shows, from the first run of ranks on.
    ranks: &'a mut Vec<u32>,
    hiz: &'a mut Hiz,
    /// The rank of what is drawn.
    rank: u32,
    /// The first rank that is free.
    next_rank: u32,
}

/// The depths of the objects that pixels show.
#[derive(Debug)]
struct ObjectDepths<D> {
    depths: D,
    /// `true` while objects are drawn.
    is_listed: bool,
}

/// A band's pixels: that in row `y` of the band and column `x` is at `y · stride + x`.
#[derive(Debug)]
pub(in crate::cpu) struct Pixels<'a> {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub rows: usize,
    /// From row to row.
    pub stride: usize,
    /// Their colours.
    pub color: &'a mut [u32],
    /// Their depths.
    pub depth: &'a mut [f32],
}

impl Band<'_> {
    /// The part of a range of image rows that lies in this band.
    #[inline]
    pub(in crate::cpu) fn rows(&self, begin: i32, end: i32) -> Range<i32> {
        begin.max(self.first_row)..end.min(self.end_row)
    }

    /// Its pixels in the image.
    #[inline(always)]
    pub(in crate::cpu) fn area(&self) -> Area {
        Area { left: 0, right: self.width, top: self.first_row, bottom: self.end_row }
    }

    /// One pixel, if it is one of the band's.
    #[inline(always)]
    pub(in crate::cpu) fn pixel(&mut self, x: i32, y: i32) -> Option<BandPixel<'_>> {
        // Negative values wrap to large ones and fail the same check.
        let (x, row) = (x as u32, (y - self.first_row) as u32);
        if x >= self.width as u32 || row >= (self.end_row - self.first_row) as u32 {
            return None;
        }
        let at = row as usize * self.stride + x as usize;
        let objects = self.objects.as_mut().and_then(|objects| objects.part(at, 1));
        Some(BandPixel { color: self.color.get_mut(at)?, depth: self.depth.get_mut(at)?, objects })
    }

    /// All of them.
    #[inline(always)]
    pub(in crate::cpu) fn pixels(&mut self) -> Pixels<'_> {
        let rows = (self.end_row - self.first_row) as usize;
        Pixels { width: self.width as usize, rows, stride: self.stride, color: self.color, depth: self.depth }
    }

    /// [`LANES`] pixels from `begin` on of each row of a range. All must be the band's.
    #[inline(always)]
    pub(in crate::cpu) fn for_windows(&mut self, rows: Range<i32>, begin: i32, mut work: impl FnMut(Window<'_>)) {
        let Some(down) = (rows.end - rows.start).checked_sub(1).filter(|down| *down >= 0) else { return };
        let has_more = self.has_more();
        let start = (rows.start - self.first_row) as usize * self.stride + begin as usize;
        let range = start..start + down as usize * self.stride + LANES;
        let (Some(colors), Some(depths)) = (self.color.get_mut(range.clone()), self.depth.get_mut(range.clone()))
        else {
            return;
        };
        let pixels = (colors, depths, self.stride);
        if !has_more {
            return each_window(
                pixels,
                #[inline(always)]
                |_, colors, depths| work(Window { colors, depths, more: None }),
            );
        }
        each_window(
            pixels,
            #[inline(always)]
            |at, colors, depths| {
                let more = More::new(self.rank, self.ranks, &mut self.objects, start + at);
                work(Window { colors, depths, more: Some(more) });
            },
        );
    }

    /// [`LANES`] pixels of a row of the band; those behind its last are of no use.
    #[inline(always)]
    pub(in crate::cpu) fn window(&mut self, x: i32, y: i32) -> Option<Window<'_>> {
        let (has_more, at) = (self.has_more(), (y - self.first_row) as usize * self.stride + x as usize);
        let colors = self.color.get_mut(at..at + LANES)?.first_chunk_mut()?;
        let depths = self.depth.get_mut(at..at + LANES)?.first_chunk_mut()?;
        let more = has_more.then(|| More::new(self.rank, self.ranks, &mut self.objects, at));
        Some(Window { colors, depths, more })
    }

    /// True if more than colours and depths are kept.
    #[inline(always)]
    fn has_more(&self) -> bool {
        self.rank != IN_ORDER || self.objects.is_some()
    }

    /// Draws what is an object, or is none, from now on.
    pub(in crate::cpu) fn set_listed(&mut self, is_listed: bool) {
        self.objects.iter_mut().for_each(|objects| objects.is_listed = is_listed);
    }

    /// True if the depths of objects are wanted.
    pub(in crate::cpu) fn has_objects(&self) -> bool {
        self.objects.is_some()
    }

    /// Begins a run of faces that are drawn by ranks: of this number, from the returned one on. `None` where there are
    /// no more of them.
    pub(in crate::cpu) fn begin_ranks(&mut self, count: usize) -> Option<u32> {
        if self.next_rank == IN_ORDER {
            self.hiz.reset(self.area());
            self.ranks.clear();
            self.ranks.resize(self.color.len(), IN_ORDER);
            self.next_rank = IN_ORDER + 1;
        }
        let first = self.next_rank;
        self.next_rank = first.checked_add(u32::try_from(count).ok()?)?;
        Some(first)
    }

    /// Draws by a rank of the run from now on.
    #[inline(always)]
    pub(in crate::cpu) fn set_rank(&mut self, rank: u32) {
        self.rank = rank;
    }

    /// Draws in order from now on.
    pub(in crate::cpu) fn end_ranks(&mut self) {
        self.rank = IN_ORDER;
    }

    /// True if faces are drawn by their ranks.
    #[inline(always)]
    pub(in crate::cpu) fn is_ranked(&self) -> bool {
        self.rank != IN_ORDER
    }

    /// Draws the tiles in which something of a face of the present rank may be seen. `draw` returns true where
    /// something is.
    #[inline(always)]
    pub(in crate::cpu) fn draw_visible<S: Simd>(
        &mut self,
        simd: S,
        plane: DepthPlane,
        area: Area,
        mut draw: impl FnMut(&mut Self, Area) -> bool,
    ) {
        let (face, slopes) = (Face { plane, rank: self.rank, area }, [plane.dx, plane.dy]);
        for first in self.hiz.blocks(area) {
            for block in self.hiz.visible_blocks(simd, &face, first) {
                let mut is_nearer = false;
                for tile in self.hiz.visible_tiles(simd, &face, block) {
                    let pixels = self.hiz.area(block, tile);
                    if draw(self, pixels) {
                        if let Some((bound, rank)) = self.farthest(simd, pixels, slopes) {
                            is_nearer |= self.hiz.offer(block, tile, &bound, rank);
                        }
                    }
                }
                if is_nearer {
                    self.hiz.join(block, slopes);
                }
            }
        }
    }

    /// A bound of a tile's depths, as one depth or as a plane of these changes to the right and down, and the lowest
    /// rank in it; `None` where pixels are outside of the image.
    #[inline(always)]
    fn farthest<S: Simd>(&self, simd: S, tile: Area, [dx, dy]: [f32; 2]) -> Option<(DepthPlane, u32)> {
        let mut farthest = F::splat(simd, 0.0);
        let mut above = F::splat(simd, 0.0);
        let mut first_rank = U::splat(simd, u32::MAX);
        if tile.right - tile.left < TILE_PX {
            return None;
        }
        let mut at = (tile.top - self.first_row) as usize * self.stride + tile.left as usize;
        let right = lane_indices(simd).to_float::<F<S>>() * dx;
        for row in 0..tile.bottom - tile.top {
            let depths = F::load_array_ref(simd, self.depth.get(at..)?.first_chunk()?);
            farthest = farthest.max(depths);
            above = above.max(depths - (right + row as f32 * dy));
            first_rank = first_rank.min(U::load_array_ref(simd, self.ranks.get(at..)?.first_chunk()?));
            at += self.stride;
        }
        // Of numbers that are not negative, the larger one has the larger bits.
        let greatest =
            |numbers: F<S>| f32::from_bits(numbers.to_array().map(f32::to_bits).into_iter().fold(0, u32::max));
        let (farthest, above) = (greatest(farthest), greatest(above));
        let mut bound = DepthPlane::level(farthest);
        // A plane, where it is finite and less at the tile's middle.
        let extent = (dx.abs() + dy.abs()) * (TILE_PX - 1) as f32;
        if above + (dx + dy) * ((TILE_PX - 1) as f32 * 0.5) < farthest && extent < FARTHEST {
            let noise = 1.01 * (3.0 * rounding(extent) + rounding(FARTHEST + extent));
            bound = DepthPlane { at: above, dx, dy, x: tile.left as f32, y: tile.top as f32, noise, ..bound };
        }
        Some((bound, first_rank.to_array().into_iter().fold(u32::MAX, u32::min)))
    }

    /// The finished rows, from the top.
    pub(in crate::cpu) fn pixel_rows(&self) -> impl Iterator<Item = &[[u8; 4]]> + '_ {
        let width = self.width as usize;
        self.color.chunks_exact(self.stride).map(move |row| bytemuck::cast_slice(&row[..width]))
    }

    /// The depths of each row.
    pub(in crate::cpu) fn depth_rows(&self) -> impl Iterator<Item = &[f32]> + '_ {
        let width = self.width as usize;
        self.depth.chunks_exact(self.stride).map(move |row| &row[..width])
    }

    /// The depths of each row's objects; no rows where these are not wanted.
    pub(in crate::cpu) fn object_rows(&self) -> impl Iterator<Item = &[f32]> + '_ {
        let width = self.width as usize;
        let depths = self.objects.as_ref().map_or(&[][..], |objects| &*objects.depths);
        depths.chunks_exact(self.stride).map(move |row| &row[..width])
    }
}

/// Passes on [`LANES`] pixels at the beginning of each row, with the place of the first.
#[inline(always)]
fn each_window(
    (colors, depths, stride): (&mut [u32], &mut [f32], usize),
    mut work: impl FnMut(usize, &mut [u32; LANES], &mut [f32; LANES]),
) {
    let mut at = 0;
    while let (Some(colors), Some(depths)) = (colors.get_mut(at..at + LANES), depths.get_mut(at..at + LANES)) {
        let (Some(colors), Some(depths)) = (colors.first_chunk_mut(), depths.first_chunk_mut()) else { return };
        work(at, colors, depths);
        at += stride;
    }
}

/// [`LANES`] pixels side by side.
#[derive(Debug)]
pub(in crate::cpu) struct Window<'a> {
    colors: &'a mut [u32; LANES],
    depths: &'a mut [f32; LANES],
    more: Option<More<'a>>,
}

/// What only some images keep for [`LANES`] pixels.
#[derive(Debug)]
struct More<'a> {
    /// Present while faces are drawn by their ranks.
    ranks: Option<&'a mut [u32; LANES]>,
    rank: u32,
    /// Present where the depths of objects are wanted.
    objects: Option<ObjectDepths<&'a mut [f32]>>,
}

impl<'a> More<'a> {
    #[inline(always)]
    fn new(rank: u32, ranks: &'a mut [u32], objects: &'a mut Option<ObjectDepths<&mut [f32]>>, at: usize) -> Self {
        let ranks = if rank == IN_ORDER { None } else { ranks.get_mut(at..) };
        let objects = objects.as_mut().and_then(|objects| objects.part(at, LANES));
        Self { ranks: ranks.and_then(|ranks| ranks.first_chunk_mut()), rank, objects }
    }
}

impl ObjectDepths<&mut [f32]> {
    #[inline(always)]
    fn part(&mut self, at: usize, count: usize) -> Option<ObjectDepths<&mut [f32]>> {
        Some(ObjectDepths { depths: self.depths.get_mut(at..at + count)?, is_listed: self.is_listed })
    }

    /// Takes the depths of those fragments that win and are opaque enough. Not a part of each loop over pixels: few
    /// images want these depths.
    #[inline(never)]
    fn take(self, wins: u64, depths: &[f32], colors: &[u32], mode: Mode) {
        let least_alpha = mode.least_object_alpha(self.is_listed);
        for (lane, (object, (depth, color))) in self.depths.iter_mut().zip(depths.iter().zip(colors)).enumerate() {
            if wins >> lane & 1 == 1 && color.to_ne_bytes()[3] >= least_alpha {
                *object = if self.is_listed { *depth } else { FARTHEST };
            }
        }
    }
}

impl Window<'_> {
    /// Tests and blends fragments side by side, those whose mask is set. `shade` is called only where some of them are
    /// seen; it returns which of these are really covered, and their colours. Returns true if some are.
    ///
    /// The nearer fragment wins, of equal depths the later one; where there are ranks, that of the higher rank.
    #[inline(always)]
    pub(in crate::cpu) fn write_fragments<S: Simd>(
        self,
        mask: M<S>,
        depths: F<S>,
        mode: Mode,
        shade: impl FnOnce(M<S>) -> (M<S>, U<S>),
    ) -> bool {
        let simd = depths.token();
        let behind = F::load_array_ref(simd, self.depths);
        // NaN is in front of nothing.
        let mut wins = if mode.depth_test { mask & depths.simd_le(behind) } else { mask };
        if let Some(More { ranks: Some(ranks), rank, .. }) = &self.more {
            wins &= depths.simd_lt(behind) | U::load_array_ref(simd, *ranks).simd_le(*rank);
        }
        if !wins.any_true() {
            return false;
        }
        let (wins, colors) = shade(wins);
        if let Some(More { ranks, rank, objects }) = self.more {
            if let Some(ranks) = ranks {
                wins.select(U::splat(simd, rank), U::load_array_ref(simd, ranks)).store_array(ranks);
            }
            if let Some(objects) = objects {
                objects.take(wins.to_bitmask(), &depths.to_array(), &colors.to_array(), mode);
            }
        }
        if mode.depth_write {
            wins.select(depths, behind).store_array(self.depths);
        }
        let there = U::load_array_ref(simd, self.colors);
        let colors = if mode.blend { blend_lanes(there, colors) } else { colors };
        wins.select(colors, there).store_array(self.colors);
        wins.any_true()
    }
}

/// One pixel.
#[derive(Debug)]
pub(in crate::cpu) struct BandPixel<'a> {
    color: &'a mut u32,
    /// Its depth.
    pub depth: &'a mut f32,
    objects: Option<ObjectDepths<&'a mut [f32]>>,
}

impl BandPixel<'_> {
    /// Tests a fragment against the pixel and writes or blends it.
    #[inline]
    pub(in crate::cpu) fn write_fragment(self, depth: f32, color: [u8; 4], mode: Mode) {
        // NaN is not drawn.
        if mode.depth_test && (depth > *self.depth || depth.is_nan()) {
            return;
        }
        // As most of a glyph's pixels, which stay as they are.
        if mode == Mode::TRANSLUCENT && color[3] == 0 {
            return;
        }
        if mode.depth_write {
            *self.depth = depth;
        }
        if let Some(objects) = self.objects {
            objects.take(1, &[depth], &[pack(color)], mode);
        }
        *self.color = if mode.blend { blend(*self.color, color) } else { pack(color) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_equal_depths_the_later_wins_and_translucent_ones_leave_the_depth() {
        let mut buffers = BandBuffers::default();
        let screen = Screen::new(2, 1, 1);
        let mut band = buffers.begin(&screen, 0, pack([9, 9, 9, 255]), false);
        let mut put = |x: i32, depth: f32, level: u8, mode: Mode| {
            if let Some(pixel) = band.pixel(x, 0) {
                pixel.write_fragment(depth, [level, level, level, 255], mode);
            }
        };
        put(0, 500.0, 1, Mode::OPAQUE);
        put(0, 500.0, 2, Mode::OPAQUE);
        put(0, 501.0, 3, Mode::OPAQUE);
        put(1, 100.0, 7, Mode::TRANSLUCENT);
        put(1, 200.0, 8, Mode::OPAQUE);
        put(2, 0.0, 9, Mode::OPAQUE);
        put(-1, 0.0, 9, Mode::OPAQUE);
        let levels: Vec<_> = band.pixel_rows().flatten().map(|pixel| pixel[0]).collect();
        assert_eq!(levels, [2, 8]);
    }
}
