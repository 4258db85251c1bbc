//! Compares the depths of what is to be lit with the bounds of the measured surface, cell by cell.

use fearless_simd::{dispatch, Level};

use crate::cells::{cells_of, window, WindowScratch, CELL_PX};
use crate::hold_times::Disagreement;
use crate::surface::Bounds;
use crate::tiles::Tiles;
use crate::{ObjectDepths, Shares, Unseen};

/// Cells by which the measured edge of an object may lie beside its own, more than the margin: noise moves it by some
/// pixels of the depth image.
const EDGE_CELLS: usize = 3;

/// Result of a cell, by the measured surface.
#[derive(Debug)]
struct Verdict;

impl Verdict {
    /// No listed display lights it.
    const UNLIT: u8 = 0;
    const CONFIRMED: u8 = 1;
    const BLOCKED: u8 = 2;
    const GONE: u8 = 3;
    const UNSEEN: u8 = 4;
}

/// The comparison of an image; keeps its memory.
#[derive(Debug, Default)]
pub(crate) struct Comparison {
    size: [usize; 2],
    /// Depths of the nearest and the farthest object in a cell, metres; infinite and −infinite without one.
    nearest: Vec<f32>,
    farthest: Vec<f32>,
    /// Pixels with an object.
    counts: Vec<u8>,
    verdicts: Vec<u8>,
    /// 1 where something is in the way, or next to that.
    in_the_way: Vec<u8>,
    /// 1 where neither the cell nor any cell around is confirmed: more than an edge disagrees.
    insides: Vec<u8>,
    disagreements: Vec<u8>,
    depth_scratch: WindowScratch<f32>,
    flag_scratch: WindowScratch<u8>,
}

impl Comparison {
    /// Takes the objects of an image.
    pub(crate) fn take(&mut self, objects: &ObjectDepths<'_>) {
        self.size = cells_of(objects.size_px);
        let count = self.size[0] * self.size[1];
        for (plane, empty) in [(&mut self.nearest, f32::INFINITY), (&mut self.farthest, f32::NEG_INFINITY)] {
            plane.clear();
            plane.resize(count, empty);
        }
        let flags = [&mut self.in_the_way, &mut self.insides, &mut self.disagreements];
        for plane in [&mut self.counts, &mut self.verdicts].into_iter().chain(flags) {
            plane.clear();
            plane.resize(count, 0);
        }
        dispatch!(Level::new(), _simd => self.reduce(objects));
    }

    #[inline(always)]
    fn reduce(&mut self, objects: &ObjectDepths<'_>) {
        let (width, columns) = (objects.size_px[0] as usize, self.size[0]);
        if width == 0 {
            return;
        }
        for (y, depths) in objects.depths_m.chunks_exact(width).enumerate() {
            let begin = y / CELL_PX * columns;
            let nearest = &mut self.nearest[begin..begin + columns];
            let farthest = &mut self.farthest[begin..begin + columns];
            let counts = &mut self.counts[begin..begin + columns];
            let (pairs, rest) = depths.as_chunks::<CELL_PX>();
            for (((pair, nearest), farthest), count) in
                pairs.iter().zip(&mut *nearest).zip(&mut *farthest).zip(&mut *counts)
            {
                for depth in pair {
                    add(*depth, nearest, farthest, count);
                }
            }
            if let ([depth], [.., nearest], [.., farthest], [.., count]) = (rest, nearest, farthest, counts) {
                add(*depth, nearest, farthest, count);
            }
        }
    }

    /// Finds the tiles with an object, and those at most `margin` cells away.
    pub(crate) fn lit_tiles(&self, margin: usize, tiles: &mut Tiles) {
        tiles.take(&self.counts, self.size, margin);
    }

    /// Compares with a surface of the same size. What is in the way grows by `margin` cells.
    pub(crate) fn compare(&mut self, surface: &Bounds, margin: usize) {
        dispatch!(Level::new(), _simd => self.judge(surface, margin));
    }

    #[inline(always)]
    fn judge(&mut self, surface: &Bounds, margin: usize) {
        let bounds = surface.nearest.iter().zip(&surface.farthest);
        let objects = self.nearest.iter().zip(&self.farthest).zip(&self.counts);
        for ((verdict, ((nearest, farthest), count)), (near, far)) in self.verdicts.iter_mut().zip(objects).zip(bounds)
        {
            let seen = if *farthest > *far {
                Verdict::BLOCKED
            } else if *nearest < *near {
                Verdict::GONE
            } else {
                Verdict::CONFIRMED
            };
            let lit = if near.is_nan() { Verdict::UNSEEN } else { seen };
            *verdict = if *count == 0 { Verdict::UNLIT } else { lit };
        }
        // At the edge of an object its own surface is before that of the objects behind it: nothing is in their way.
        // What is nearer than all objects around it is.
        let min = |one: f32, other: f32| if one < other { one } else { other };
        window(&mut self.nearest, self.size[0], margin + EDGE_CELLS, f32::INFINITY, &mut self.depth_scratch, min);
        for ((flag, nearest), far) in self.in_the_way.iter_mut().zip(&self.nearest).zip(&surface.farthest) {
            *flag = u8::from(*far < *nearest) & u8::from(*nearest < f32::INFINITY);
        }
        window(&mut self.in_the_way, self.size[0], margin, 0, &mut self.flag_scratch, u8::max);
    }

    /// Reasons for which cells are dark, see [`Disagreement`].
    pub(crate) fn disagreements(&mut self, unseen: Unseen) -> &[u8] {
        let confirmed_unseen = match unseen {
            Unseen::Dark => Verdict::CONFIRMED,
            Unseen::Light => Verdict::UNSEEN,
        };
        dispatch!(Level::new(), _simd => self.find_disagreements(confirmed_unseen));
        &self.disagreements
    }

    #[inline(always)]
    fn find_disagreements(&mut self, confirmed_unseen: u8) {
        let is_confirmed = |verdict: u8| verdict == Verdict::CONFIRMED || verdict == confirmed_unseen;
        // An edge moves with the noise, an inside does not.
        self.insides.iter_mut().zip(&self.verdicts).for_each(|(to, verdict)| *to = u8::from(!is_confirmed(*verdict)));
        window(&mut self.insides, self.size[0], EDGE_CELLS, 1, &mut self.flag_scratch, u8::min);
        let cells = self.verdicts.iter().zip(&self.in_the_way).zip(&self.insides);
        for (disagreement, ((verdict, in_the_way), inside)) in self.disagreements.iter_mut().zip(cells) {
            let agrees = is_confirmed(*verdict) && *in_the_way == 0;
            let other = if agrees { Disagreement::NONE } else { Disagreement::SOME };
            let lit = if *inside != 0 { Disagreement::WIDE } else { other };
            *disagreement = if *verdict == Verdict::UNLIT { Disagreement::NONE } else { lit };
        }
    }

    /// Shares of the pixels with an object.
    pub(crate) fn shares(&self) -> Shares {
        let pixels = dispatch!(Level::new(), _simd => self.count_verdicts());
        let all = pixels.iter().sum::<u64>().max(1) as f64;
        let share = |verdict: u8| pixels[usize::from(verdict)] as f64 / all;
        Shares {
            confirmed: share(Verdict::CONFIRMED),
            blocked: share(Verdict::BLOCKED),
            gone: share(Verdict::GONE),
            unseen: share(Verdict::UNSEEN),
        }
    }

    /// Pixels with an object, by the verdict of their cell.
    #[inline(always)]
    fn count_verdicts(&self) -> [u64; 5] {
        let mut pixels = [0; 5];
        let width = self.size[0].max(1);
        // Rows, so that 32 bits suffice for the sums.
        for (verdicts, counts) in self.verdicts.chunks(width).zip(self.counts.chunks(width)) {
            for (verdict, sum) in (0..).zip(&mut pixels) {
                let counts = verdicts.iter().zip(counts);
                let row: u32 = counts.map(|(own, count)| if *own == verdict { u32::from(*count) } else { 0 }).sum();
                *sum += u64::from(row);
            }
        }
        pixels
    }
}

#[inline(always)]
fn add(depth: f32, nearest: &mut f32, farthest: &mut f32, count: &mut u8) {
    // False for NaN.
    *nearest = if depth < *nearest { depth } else { *nearest };
    *farthest = if depth > *farthest { depth } else { *farthest };
    *count += u8::from(!depth.is_nan());
}

/// Levels of the mask: 0 for pixels with an object whose cell has to wait, and without one if `is_strict`.
pub(crate) fn mask_levels(objects: &ObjectDepths<'_>, waits: &[u8]) -> Vec<u8> {
    let mut levels = vec![0; objects.size_px[0] as usize * objects.size_px[1] as usize];
    dispatch!(Level::new(), _simd => write_levels(objects, waits, &mut levels));
    levels
}

#[inline(always)]
fn write_levels(objects: &ObjectDepths<'_>, waits: &[u8], levels: &mut [u8]) {
    let (width, columns) = (objects.size_px[0] as usize, cells_of(objects.size_px)[0]);
    let unlit = if objects.is_strict { 0 } else { 255 };
    let level = |depth: f32, wait: u8| {
        let lit = if wait == 0 { 255 } else { 0 };
        if depth.is_nan() {
            unlit
        } else {
            lit
        }
    };
    if width == 0 {
        return;
    }
    let rows = objects.depths_m.chunks_exact(width).zip(levels.chunks_exact_mut(width));
    for (y, (depths, levels)) in rows.enumerate() {
        let begin = y / CELL_PX * columns;
        let waits = &waits[begin..begin + columns];
        let ((depths, last_depth), (levels, last_level)) =
            (depths.as_chunks::<CELL_PX>(), levels.as_chunks_mut::<CELL_PX>());
        for ((depths, levels), wait) in depths.iter().zip(levels).zip(waits) {
            *levels = depths.map(|depth| level(depth, *wait));
        }
        if let ([depth], [to], [.., wait]) = (last_depth, last_level, waits) {
            *to = level(*depth, *wait);
        }
    }
}
