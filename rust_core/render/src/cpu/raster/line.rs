//! Lines of one pixel.
//!
//! A line has one pixel in each column (a flat one) or in each row (a steep one): the one whose centre is nearest to
//! it, of two equally near ones the upper or left. At its ends the diamond-exit rule decides: a pixel is drawn when
//! the line leaves the diamond around its centre, so that joined lines draw their common pixel once. Mesa's test for
//! that mirrors the slope in one case, which is repeated here.

use std::ops::Range;

use fearless_simd::prelude::*;
use fearless_simd::{dispatch, Simd};

use super::clip::{clip_line, ClipVertex};
use crate::cpu::tile::band::{Band, Mode};
use crate::cpu::tile::color::{pack, unorm8};
use crate::cpu::tile::lanes::{lane_indices, F, LANES};
use crate::cpu::tile::screen::{snap, Screen, FARTHEST, SUBPIXELS};

/// A line that is ready to be drawn. "Along" is the axis with one pixel a step: x for a flat line, y for a steep one.
#[derive(Clone, Copy, Debug)]
pub(in crate::cpu) struct Line {
    steep: bool,
    /// The first pixel along and the one after the last.
    first: i32,
    after: i32,
    /// Snapped ends, `[along, across]`, the first with the smaller along.
    ends: [[i32; 2]; 2],
    /// The first row that it touches and the one after the last.
    pub rows: (i32, i32),
    mode: Mode,
    begin: End,
    end: End,
}

/// The values that are interpolated between the ends.
#[derive(Clone, Copy, Debug)]
struct End {
    /// Window coordinate along, from the first pixel's centre.
    along: f32,
    depth: f32,
    inverse_w: f32,
    color: [f32; 4],
}

/// Clips a line and makes it ready; `None` where nothing is to be drawn.
pub(in crate::cpu) fn set_up(a: ClipVertex, b: ClipVertex, mode: Mode, screen: &Screen) -> Option<Line> {
    let (a, b) = clip_line(a, b)?;
    let window = |v: &ClipVertex| {
        let inverse_w = 1.0 / v.position[3];
        [screen.x(v.position[0] * inverse_w), screen.y(v.position[1] * inverse_w)]
    };
    let (at_a, at_b) = (window(&a), window(&b));
    let delta = [at_b[0] - at_a[0], at_b[1] - at_a[1]];
    if !(delta[0].is_finite() && delta[1].is_finite()) || (delta[0] == 0.0 && delta[1] == 0.0) {
        return None;
    }
    let steep = delta[1].abs() > delta[0].abs();
    let axis = usize::from(steep);
    let (first, last) = diamond_exit(at_a, at_b, axis);
    let forward = delta[axis] > 0.0;
    let end = |v: &ClipVertex, at: [f32; 2]| End {
        along: at[axis] - 0.5,
        depth: (v.position[2] / v.position[3] * 0.5 + 0.5) * FARTHEST,
        inverse_w: 1.0 / v.position[3],
        color: v.color,
    };
    let (a_end, b_end) = (end(&a, at_a), end(&b, at_b));
    let place = |at: [f32; 2]| [snap(at[axis]), snap(at[1 - axis])];
    let (begin, end, ends) =
        if forward { (a_end, b_end, [place(at_a), place(at_b)]) } else { (b_end, a_end, [place(at_b), place(at_a)]) };
    if ends[0][0] >= ends[1][0] {
        return None;
    }
    let limit = [screen.width_px, screen.height_px][axis] as i32;
    let (first, after) = (first.max(0), (last + 1).min(limit));
    let mut line = Line { steep, first, after, ends, rows: (first, after), mode, begin, end };
    if !steep {
        let (a, b) = (line.across(first), line.across(after - 1));
        line.rows = (a.min(b).max(0), (a.max(b) + 1).min(screen.height_px as i32));
    }
    (first < after && line.rows.0 < line.rows.1).then_some(line)
}

/// The first and the last pixel along an axis of a line from `a` to `b`, in the order of the axis.
fn diamond_exit(a: [f32; 2], b: [f32; 2], axis: usize) -> (i32, i32) {
    let direction = |i: usize| if b[i] < a[i] { -1.0 } else { 1.0 };
    let (along, across) = (direction(axis), direction(1 - axis));
    let slope = ((b[1 - axis] - a[1 - axis]) / (b[axis] - a[axis])).abs();
    // Distance past the pixel's centre, seen in the line's direction.
    let past = |at: [f32; 2]| {
        let offset = |i: usize| at[i] - at[i].floor() - 0.5;
        (offset(axis) * along, offset(1 - axis) * across)
    };
    let reaches_the_diamond = |(u, v): (f32, f32)| (v + u * slope).abs() < 0.5;
    let (u, v) = past(a);
    let draws_first = u.abs() + v.abs() < 0.5 || (u < 0.0 && (v <= 0.0 || reaches_the_diamond((u, v))));
    let (u, v) = past(b);
    let draws_last = u.abs() + v.abs() >= 0.5 && u >= 0.0 && (v > 0.0 || reaches_the_diamond((u, v)));
    let (cell_a, cell_b) = (a[axis].floor() as i32, b[axis].floor() as i32);
    if along > 0.0 {
        (cell_a + i32::from(!draws_first), cell_b - i32::from(!draws_last))
    } else {
        (cell_b + i32::from(!draws_last), cell_a - i32::from(!draws_first))
    }
}

impl Line {
    /// The pixel across at a pixel along.
    fn across(&self, along: i32) -> i32 {
        Across::new(&self.ends, along).across as i32
    }

    /// The steps along whose pixels lie in the rows of a band; for a flat line, about.
    fn steps(&self, band: &Band<'_>) -> Range<i32> {
        if self.steep {
            return band.rows(self.first, self.after);
        }
        if self.rows.0 >= band.first_row && self.rows.1 <= band.end_row {
            return self.first..self.after;
        }
        let [[a0, c0], [a1, c1]] = self.ends.map(|end| end.map(f64::from));
        if (c1 - c0).abs() < 1.0 {
            return self.first..self.after;
        }
        // Where the line crosses the band's borders, and a few pixels more.
        let scale = f64::from(SUBPIXELS);
        let along = |row: i32| (a0 + (f64::from(row) * scale - c0) * (a1 - a0) / (c1 - c0)) / scale;
        let (one, other) = (along(band.first_row - 1), along(band.end_row));
        let (low, high) = (one.min(other) - 2.0, one.max(other) + 3.0);
        self.first.max(low as i32)..self.after.min(high as i32)
    }

    /// Draws the rows of a band.
    pub(in crate::cpu) fn draw(&self, band: &mut Band<'_>) {
        dispatch!(band.simd_level, simd => self.draw_by_lanes(simd, band));
    }

    #[inline(always)]
    fn draw_by_lanes<S: Simd>(&self, simd: S, band: &mut Band<'_>) {
        // Of one colour at both ends.
        let single = self.begin.color.iter().zip(&self.end.color).all(|(a, b)| a == b);
        let single = single.then(|| self.begin.color.map(unorm8));
        let steps = self.steps(band);
        match single.filter(|_| self.mode == Mode::OPAQUE && !band.has_objects()).map(pack) {
            Some(color) if self.steep => self.draw_plain::<S, true>(simd, steps, color, band),
            Some(color) => self.draw_plain::<S, false>(simd, steps, color, band),
            None => self.draw_any(simd, steps, single, band),
        }
    }

    /// Draws an opaque line of one colour. `STEEP` is whether it is steep.
    #[inline(always)]
    fn draw_plain<S: Simd, const STEEP: bool>(&self, simd: S, steps: Range<i32>, color: u32, band: &mut Band<'_>) {
        let mut across = Across::new(&self.ends, steps.start);
        let (along, across_from) = if STEEP { (band.first_row, 0) } else { (0, band.first_row) };
        let pixels = band.pixels();
        let (along_stride, across_stride, limit) =
            if STEEP { (pixels.stride, 1, pixels.width) } else { (1, pixels.stride, pixels.rows) };
        let len = pixels.color.len().min(pixels.depth.len());
        let (colors, behind) = (&mut pixels.color[..len], &mut pixels.depth[..len]);
        for begin in steps.clone().step_by(LANES) {
            let (_, depths) = self.at(simd, begin);
            // NaN is not drawn.
            let depths = depths.simd_le(FARTHEST).select(depths, F::splat(simd, f32::INFINITY)).to_array();
            let mut place = (begin - along) as usize * along_stride;
            for depth in depths.into_iter().take((steps.end - begin) as usize) {
                let across = (across.step() - across_from) as u32 as usize;
                let at = place + across * across_stride;
                place += along_stride;
                // What is negative is too large as well.
                if across >= limit || at >= len {
                    continue;
                }
                // Which are seen is hard to predict: each is written, many as they are, and no comparison decides, of
                // which the compiler would make a branch. Of numbers that are not negative, the larger one has the
                // larger bits. What is there may be negative by rounding, and any such number hides the line; zero is
                // added so that -0 becomes 0.
                let (depth, there) = (depth.to_bits() as i32, behind[at].to_bits() as i32);
                let nearest = ((behind[at] + 0.0).to_bits() as i32).max(-1);
                let is_hidden = (nearest - depth) >> 31;
                behind[at] = f32::from_bits((depth ^ ((depth ^ there) & is_hidden)) as u32);
                colors[at] = color ^ ((color ^ colors[at]) & is_hidden as u32);
            }
        }
    }

    /// Draws any line; `single` is its colour if it has but one.
    #[inline(always)]
    fn draw_any<S: Simd>(&self, simd: S, steps: Range<i32>, single: Option<[u8; 4]>, band: &mut Band<'_>) {
        let mut across = Across::new(&self.ends, steps.start);
        for begin in steps.clone().step_by(LANES) {
            let (t, depths) = self.at(simd, begin);
            let (t, depths) = (t.to_array(), depths.to_array());
            for (lane, along) in (begin..steps.end).take(LANES).enumerate() {
                let across = across.step();
                let (x, y) = if self.steep { (across, along) } else { (along, across) };
                let Some(pixel) = band.pixel(x, y) else { continue };
                if self.mode.depth_test && depths[lane] > *pixel.depth {
                    continue;
                }
                let color = single.unwrap_or_else(|| self.color(t[lane]));
                pixel.write_fragment(depths[lane], color, self.mode);
            }
        }
    }

    /// Of several pixels along the share of the way and the depth.
    #[inline(always)]
    fn at<S: Simd>(&self, simd: S, begin: i32) -> (F<S>, F<S>) {
        let length = (self.end.along - self.begin.along).max(f32::MIN_POSITIVE);
        let t = (lane_indices(simd).to_float::<F<S>>() + begin as f32 - self.begin.along) / length;
        let depths = t * (self.end.depth - self.begin.depth) + self.begin.depth;
        // NaN stays.
        let depths = depths.simd_le(0.0).select(F::splat(simd, 0.0), depths);
        let depths = depths.simd_gt(FARTHEST).select(F::splat(simd, FARTHEST), depths);
        (t, depths)
    }

    /// The colour at a share of the way.
    fn color(&self, t: f32) -> [u8; 4] {
        let (begin_w, end_w) = (self.begin.inverse_w, self.end.inverse_w);
        let least_w = 0.5 * begin_w.min(end_w);
        let mix = |a: f32, b: f32| a + (b - a) * t;
        // A line that runs towards the eye within a pixel could be extended past it.
        let w = 1.0 / mix(begin_w, end_w).max(least_w);
        [0, 1, 2, 3].map(|i| {
            let (a, b) = (self.begin.color[i], self.end.color[i]);
            unorm8(if a == b { a } else { mix(a * begin_w, b * end_w) * w })
        })
    }
}

/// The pixel across at a pixel along: the smallest whole number not below a quotient whose dividend grows by the same
/// from pixel to pixel. The division is done once.
struct Across {
    across: i64,
    /// The rest of the division, negated: from 0 to before the divisor.
    rest: i64,
    divisor: i64,
    step: i64,
    rest_step: i64,
}

impl Across {
    #[inline]
    fn new(ends: &[[i32; 2]; 2], along: i32) -> Self {
        let [[a0, c0], [a1, c1]] = ends.map(|end| end.map(i64::from));
        let (length, subpixels) = ((a1 - a0).max(1), i64::from(SUBPIXELS));
        let doubled = (2 * c0 - subpixels) * length + 2 * (i64::from(along) * subpixels - a0) * (c1 - c0);
        let divisor = 2 * subpixels * length;
        let growth = 2 * subpixels * (c1 - c0);
        Self {
            across: -(-doubled).div_euclid(divisor),
            rest: (-doubled).rem_euclid(divisor),
            divisor,
            step: -(-growth).div_euclid(divisor),
            rest_step: (-growth).rem_euclid(divisor),
        }
    }

    /// The pixel across, and goes on to the next pixel along.
    #[inline(always)]
    fn step(&mut self) -> i32 {
        let across = self.across;
        self.across += self.step;
        self.rest += self.rest_step;
        if self.rest >= self.divisor {
            self.rest -= self.divisor;
            self.across -= 1;
        }
        across as i32
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::cpu::tile::band::BandBuffers;

    #[test]
    fn the_pixel_across_is_that_of_a_division_at_each_step() {
        let mut state = 1_u32;
        let mut next = |limit: i32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as i32 % limit - limit / 3
        };
        for _ in 0..2000 {
            let begin = [next(200_000), next(200_000)];
            let ends = [begin, [begin[0] + next(150_000).abs(), begin[1] + next(300_000)]];
            let first = next(700);
            let mut across = Across::new(&ends, first);
            for along in first..first + 300 {
                assert_eq!(across.step(), Across::new(&ends, along).step());
            }
        }
    }

    /// A band's colours and depths.
    fn contents(band: &Band<'_>) -> (Vec<[u8; 4]>, Vec<u32>) {
        let depths = band.depth_rows().flatten().map(|depth| depth.to_bits());
        (band.pixel_rows().flatten().copied().collect(), depths.collect())
    }

    fn place() -> impl Strategy<Value = [f32; 3]> {
        [-2.5..2.5_f32, -2.5..2.5, -0.9..0.9]
    }

    /// Depths that faces may have left, some of them below 0 by rounding.
    fn depths_there() -> impl Strategy<Value = Vec<f32>> {
        let depth = prop_oneof![Just(0.0_f32), Just(-0.0), -2.0..2.0_f32, 0.0..FARTHEST, Just(FARTHEST)];
        proptest::collection::vec(depth, 1..200)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn plain_lines_are_hidden_as_any_others(
            ends in ([-1.0..1.0_f32, -1.0..1.0], [-1.0..1.0_f32, -1.0..1.0]),
            z in prop_oneof![Just([-1.0_f32; 2]), [-1.0..-0.999_f32, -1.0..-0.999], [-1.2..1.2_f32, -1.2..1.2]],
            there in depths_there(),
        ) {
            let screen = Screen::new(70, 50, 1);
            let [mut plain, mut any] = [(); 2].map(|()| BandBuffers::default());
            let [mut plain, mut any] = [&mut plain, &mut any].map(|buffers| buffers.begin(&screen, 0, 7, false));
            for band in [&mut plain, &mut any] {
                let depths = band.pixels().depth;
                depths.iter_mut().zip(there.iter().cycle()).for_each(|(depth, there)| *depth = *there);
            }
            let vertex = |[x, y]: [f32; 2], z| ClipVertex { position: [x, y, z, 1.0], color: [1.0; 4], uv: [0.0; 2] };
            let line = set_up(vertex(ends.0, z[0]), vertex(ends.1, z[1]), Mode::OPAQUE, &screen);
            if let Some(line) = line {
                line.draw(&mut plain);
                let steps = line.steps(&any);
                dispatch!(screen.simd_level, simd => line.draw_any(simd, steps, Some([255; 4]), &mut any));
            }
            prop_assert_eq!(contents(&plain), contents(&any));
        }

        #[test]
        fn plain_lines_are_drawn_as_any_others(
            lines in proptest::collection::vec((place(), place(), 0.5..4.0_f32), 1..12),
            index in 0..3_usize,
        ) {
            let screen = Screen::new(70, 150, 1);
            let [mut plain, mut any] = [(); 2].map(|()| BandBuffers::default());
            let [mut plain, mut any] = [&mut plain, &mut any].map(|buffers| buffers.begin(&screen, index, 7, false));
            // Each twice: of equal depths the later one is seen.
            for (number, &([ax, ay, az], [bx, by, bz], w)) in (1..).zip(lines.iter().chain(&lines)) {
                let color = [number as f32 / 24.0; 4];
                let vertex = |position| ClipVertex { position, color, uv: [0.0; 2] };
                let ends = [vertex([ax, ay, az, 1.0]), vertex([bx * w, by * w, bz * w, w])];
                let Some(line) = set_up(ends[0], ends[1], Mode::OPAQUE, &screen) else { continue };
                line.draw(&mut plain);
                let steps = line.steps(&any);
                dispatch!(screen.simd_level, simd => line.draw_any(simd, steps, Some(color.map(unorm8)), &mut any));
            }
            prop_assert_eq!(contents(&plain), contents(&any));
        }
    }
}
