//! Drawing opaque faces not in their order.
//!
//! Where many opaque faces follow each other, their order matters only for equal depths, so that they may come in any
//! order if each pixel knows the *rank* of the face that it shows: its place in the order of drawing. Faces that lie
//! over each other a thousandfold are drawn in an order of their own: after a few of them each part of the picture is
//! covered by one that is nearer than most, and the [`Occluders`] hide the others.
//!
//! They come from near to far, and of equally near ones the last comes first. Tilted ones may each be nearer than those
//! before it wherever they lie over each other, so a few scattered ones come before all others. Solids made of meshes
//! come scattered.
//!
//! A face that has exactly the corners of one with a higher rank is not drawn at all.

use super::band::Band;
use super::occlusion::{Occluders, SeenTiles};
use super::screen::{Screen, SUBPIXELS};
use super::triangles::Corner;

/// What a worker keeps for drawing faces by their ranks.
#[derive(Debug, Default)]
pub(super) struct RankedScratch {
    pub occluders: Occluders,
    /// The faces of a run, in their order and [`CHUNK`] at a time: a job, and where a chunk begins in what the job
    /// lists for the band.
    pub chunks: Vec<[u32; 2]>,
    /// The places of the chunks, in the order of drawing.
    pub order: Vec<u32>,
    /// How near each chunk is.
    keys: Vec<f32>,
    /// How many chunks are about as near, and then where they begin in the order.
    counts: Vec<u32>,
    /// The triangles that were drawn last, by their corners.
    pub recent_triangles: Recent<12>,
    /// The points that were drawn last, by their positions.
    pub recent_points: Recent<3>,
    /// Memory for the triangles of a face, and for the tiles in which something of it may be seen.
    pub cut: Vec<[Corner; 3]>,
    pub tiles: Vec<SeenTiles>,
    /// The first rank that is free in this band.
    next_rank: u32,
}

impl RankedScratch {
    /// Begins a band.
    pub(super) fn begin(&mut self) {
        self.next_rank = 0;
    }

    /// So many ranks, in a band of these rows: the first one; `None` where there are too many.
    pub(super) fn take_ranks(&mut self, count: usize, width: i32, [first_row, end_row]: [i32; 2]) -> Option<u32> {
        if self.next_rank == 0 {
            self.occluders.reset(width, first_row, end_row);
            // Pixels have none at first.
            self.next_rank = 1;
        }
        let first = self.next_rank;
        self.next_rank = first.checked_add(u32::try_from(count).ok()?)?;
        self.recent_triangles.begin();
        self.recent_points.begin();
        Some(first)
    }
}

impl RankedScratch {
    /// Lists the chunks of a run, given what each job lists for the band, in a scattered order. Returns the first of
    /// their ranks; `None` where there are too many.
    pub(super) fn list_chunks<'n>(
        &mut self,
        numbers: impl Fn(usize) -> &'n [u32],
        jobs: usize,
        band: &Band<'_>,
    ) -> Option<u32> {
        self.chunks.clear();
        for job in 0..jobs {
            let begins = (0..numbers(job).len()).step_by(CHUNK);
            self.chunks.extend(begins.map(|begin| [job as u32, begin as u32]));
        }
        self.order.clear();
        self.order.extend(scattered(self.chunks.len()).map(|at| at as u32));
        self.take_ranks(self.chunks.len() * CHUNK, band.width, [band.first_row, band.end_row])
    }

    /// Puts the chunks in another order, given how near what the jobs list is, smaller numbers for what is nearer: at
    /// first a few scattered ones, which are drawn twice; then all, the near ones first, and of those that are about as
    /// near the last one.
    pub(super) fn order_chunks<'n>(
        &mut self,
        numbers: impl Fn(usize) -> &'n [u32],
        nearness: impl Fn(usize, u32) -> f32,
    ) {
        const SCATTERED: usize = 32;
        const BUCKETS: usize = 1024;
        self.keys.clear();
        for &[job, begin] in &self.chunks {
            let chunk = numbers(job as usize).get(begin as usize..).unwrap_or(&[]);
            let nearness = |least: f32, &number: &u32| least.min(nearness(job as usize, number));
            self.keys.push(chunk.iter().take(CHUNK).fold(f32::INFINITY, nearness));
        }
        let (keys, count) = (&self.keys, self.chunks.len());
        let finite = || keys.iter().copied().filter(|key| key.is_finite());
        let (low, high) = (finite().fold(f32::INFINITY, f32::min), finite().fold(f32::NEG_INFINITY, f32::max));
        let per_step = if high > low { (BUCKETS - 1) as f32 / (high - low) } else { 0.0 };
        // What is not finite comes last, or first.
        let bucket = |key: f32| if key == f32::INFINITY { BUCKETS - 1 } else { ((key - low) * per_step) as usize };
        let bucket = |key: f32| bucket(key).min(BUCKETS - 1);
        self.counts.clear();
        self.counts.resize(BUCKETS + 1, 0);
        for &key in keys {
            self.counts[bucket(key) + 1] += 1;
        }
        let first = count / SCATTERED;
        self.counts[0] = first as u32;
        for i in 0..BUCKETS {
            self.counts[i + 1] += self.counts[i];
        }
        self.order.truncate(first);
        self.order.resize(first + count, 0);
        for (at, &key) in keys.iter().enumerate().rev() {
            let next = &mut self.counts[bucket(key)];
            self.order[*next as usize] = at as u32;
            *next += 1;
        }
    }

    /// As [`Self::take_ranks`], but where there are too many, all ranks are free again: whatever a band shows was drawn
    /// before. `None` only for more than there are at all.
    pub(super) fn begin_again_for(&mut self, count: usize, band: &mut Band<'_>) -> Option<u32> {
        let rows = [band.first_row, band.end_row];
        self.take_ranks(count, band.width, rows).or_else(|| {
            self.begin();
            band.forget_ranks();
            self.take_ranks(count, band.width, rows)
        })
    }
}

/// So many neighbouring faces of a list are drawn one after the other: their memory comes together.
pub(super) const CHUNK: usize = 8;

/// What a job lists in the chunk at this place of a run, and the ranks. The last is the first: of neighbours, too, it
/// is the most likely to hide the others.
#[inline]
pub(super) fn in_chunk<'n>(
    numbers: impl Fn(usize) -> &'n [u32],
    [job, begin]: [u32; 2],
    first_rank: u32,
    at: usize,
) -> impl Iterator<Item = (u32, u32)> + 'n {
    let chunk = numbers(job as usize).get(begin as usize..).unwrap_or(&[]);
    let first_rank = first_rank + (at * CHUNK) as u32;
    chunk.iter().take(CHUNK).enumerate().rev().map(move |(i, &number)| (number, first_rank + i as u32))
}

/// How much a job has to draw.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Load {
    /// Pixels, counted as often as they are covered; about.
    pub pixels: u64,
    /// Faces.
    pub faces: u64,
    /// Some have to be drawn in their order.
    pub in_order: bool,
}

/// How large a face is in the picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    /// About as many of the picture's pixels as it covers.
    pub pixels: u64,
    /// Whether it covers hardly any tile.
    pub is_thin: bool,
}

impl Extent {
    /// Of a triangle between columns and rows of pixels, the second ones excluded, and with twice its area in snapped
    /// places.
    #[inline]
    pub(super) fn of_triangle(
        (left, right): (i32, i32),
        (top, bottom): (i32, i32),
        doubled_area: i64,
        screen: &Screen,
    ) -> Self {
        const THIN_PX: i64 = 32;
        let longest = i64::from((right - left).max(bottom - top));
        let doubled_px = doubled_area.abs() / i64::from(SUBPIXELS * SUBPIXELS);
        let width = right.min(screen.width_px as i32) - left.max(0);
        let height = bottom.min(screen.height_px as i32) - top.max(0);
        let in_picture = width.max(0) as u64 * height.max(0) as u64;
        Self { pixels: in_picture.min(doubled_px as u64) / 2, is_thin: doubled_px < longest * THIN_PX }
    }
}

impl Load {
    /// Adds a face. Thin ones, such as wide lines, cover no tiles: where they prevail, their order is kept.
    #[inline]
    pub(super) fn add(&mut self, face: Extent) {
        if !face.is_thin {
            self.pixels += face.pixels;
        }
        self.faces += 1;
    }

    /// Whether faces of some size lie over each other many times.
    pub(super) fn is_heavy(&self, screen: &Screen) -> bool {
        const MANY_TIMES: u64 = 16;
        const FACE_PX: u64 = 256;
        let picture_px = u64::from(screen.width_px) * u64::from(screen.height_px);
        self.pixels > MANY_TIMES * picture_px && self.pixels > FACE_PX * self.faces
    }

    /// Both.
    pub(super) fn and(self, other: Self) -> Self {
        Self {
            pixels: self.pixels + other.pixels,
            faces: self.faces + other.faces,
            in_order: self.in_order || other.in_order,
        }
    }
}

/// The numbers below `count`, each once, in an order that looks random.
pub(super) fn scattered(count: usize) -> impl Iterator<Item = usize> {
    // Each step can be undone within so many bits, so that no number comes twice.
    let bits = usize::BITS - count.saturating_sub(1).leading_zeros();
    let (mask, shift) = ((1usize << bits) - 1, bits.div_ceil(2));
    let mixed = move |number: usize| {
        let mut number = number;
        for factor in [0x9e37_79b1, 0x85eb_ca6b, 0xc2b2_ae35] {
            number = number.wrapping_mul(factor) & mask;
            number ^= number >> shift;
        }
        number
    };
    (0..1usize << bits).map(mixed).filter(move |number| *number < count)
}

/// What identifies a face among those of its run: numbers that say where its corners are.
pub(super) type FaceKey<const N: usize> = [u32; N];

/// The faces that were drawn last.
#[derive(Debug, Default)]
pub(super) struct Recent<const N: usize> {
    /// Each with its rank; none where that is 0.
    entries: Vec<(FaceKey<N>, u32)>,
}

impl<const N: usize> Recent<N> {
    const SIZE: usize = 1024;

    fn begin(&mut self) {
        self.entries.clear();
        self.entries.resize(Self::SIZE, ([0; N], 0));
    }

    /// Whether the same face was drawn with a higher rank; else this one is kept.
    #[inline]
    pub(super) fn covers(&mut self, key: &FaceKey<N>, rank: u32) -> bool {
        let mix = |hash: u32, number: &u32| (hash ^ number).wrapping_mul(0x9e37_79b1).rotate_left(15);
        let hash = key.iter().fold(0, mix) as usize;
        let Some((known, known_rank)) = self.entries.get_mut(hash % Self::SIZE) else { return false };
        if *known_rank > rank && known == key {
            return true;
        }
        (*known, *known_rank) = (*key, rank);
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scattered_order_has_every_number_once() {
        for count in [0, 1, 2, 3, 10, 100, 1024, 9973] {
            let mut all: Vec<_> = scattered(count).collect();
            all.sort_unstable();
            assert!(all.into_iter().eq(0..count), "{count}");
        }
    }

    #[test]
    fn a_face_is_covered_by_the_same_one_with_a_higher_rank() {
        let mut recent = Recent::<12>::default();
        recent.begin();
        let key = |number: u32| [number; 12];
        assert!(!recent.covers(&key(1), 5));
        assert!(recent.covers(&key(1), 4) && !recent.covers(&key(2), 4));
        assert!(!recent.covers(&key(1), 6) && recent.covers(&key(1), 5));
        recent.begin();
        assert!(!recent.covers(&key(1), 3));
    }
}
