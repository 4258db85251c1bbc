//! Detection of wrong images: a lagging camera, or an image taken twice, puts another pattern's image in a pattern's
//! place, and each wrong bit mirrors a part of the code.
//!
//! An image is wrong if
//! - it and its inverse are dark, or lit, in the same places ([`ImageCheck::unpaired`]);
//! - its stripes have the edges of another bit ([`ImageCheck::repeated`]): only one bit of a Gray code changes at an
//!   edge, several only at depth edges;
//! - it is lit and dark where another bit is, and one of both is fine ([`ImageCheck::alike`]);
//! - coordinates fold back along its edges ([`folded`]), which no surface causes: a projector's image has the same
//!   orientation everywhere.

use super::channels::{AxisChannels, Channels, StripeChannel};
use super::light_images::LightImages;
use super::response::CLIPPED_FROM;
use super::DecodedPixel;
use crate::patterns::{Axis, Stripes};

/// Maximum number of sampled pixels.
const SAMPLED: usize = 150_000;
/// Shares of the projector's light below and above which a pixel is certainly dark or lit.
const DARK: f32 = 0.2;
const LIT: f32 = 0.85;
/// Maximum noise of sampled pixels, as a share of the projector's light.
const MOST_NOISE: f32 = 0.05;
/// Maximum share of pixels that are equal in stripes and in their inverse.
const MANY_UNPAIRED: f64 = 0.15;
/// Maximum mean difference of equal images, as a share of the projector's light.
const SAME: f32 = 0.04;
/// Minimum difference of a certain bit, as a share of white minus black.
const CERTAIN: f32 = 0.35;
/// Distance of the pixels between which edges are detected, camera pixels.
const EDGE_REACH: usize = 3;
/// Maximum rate of edges between these pixels; finer stripes do not show where surfaces end.
const MANY_EDGES: f64 = 0.35;
/// Minimum number of edges that two bits share, and minimum ratio to the bits' own edges.
const LEAST_SHARED: u32 = 100;
const SHARED_TO_ALONE: u32 = 2;
/// First fine bit: from here on, different bits agree at half of the pixels, like noise.
const FIRST_FINE_BIT: usize = 4;
/// Minimum agreement of equal bits where both are certain, and minimum share of such pixels.
const AGREEING: f64 = 0.9;
const COMPARABLE: f64 = 0.05;
/// Number of pixels for comparing bits.
const COMPARED: usize = 20_000;
/// Minimum share of a bit's edges that finer bits confirm, and minimum share at which these are certain.
const MOST_OF: f64 = 0.75;
const KNOWN: f64 = 0.3;
/// Minimum number of folds along a bit's edges, and minimum ratio to edges without a fold.
const LEAST_FOLDS: u32 = 30;
const FOLDS_TO_PASSES: u32 = 2;
/// Distance of the slopes on both sides of an edge, and half their length, camera pixels.
const SIDE: usize = 4;
const HALF_SLOPE: usize = 2;
/// Minimum width of stripes whose folds are detectable, projector pixels.
const LEAST_WIDTH_PX: f64 = 16.0;

/// Image that shows another pattern than listed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WrongImage {
    /// Listed stripes.
    pub stripes: Stripes,
    /// Fault.
    pub fault: ImageFault,
}

/// Fault of an image. Numbers are indices of images.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImageFault {
    /// The first image is a copy of the second.
    Copy([usize; 2]),
    /// The images are not each other's inverse.
    NoInverse([usize; 2]),
    /// Stripes and inverse show another bit.
    Shows([usize; 2], Stripes),
    /// Two bits' images show the same bit; which one is unknown.
    Alike([usize; 2], Stripes),
    /// Stripes and inverse lack the bit's edges.
    NoEdges([usize; 2]),
}

impl WrongImage {
    /// Describes the fault with the images' names.
    pub fn describe(&self, name: impl Fn(usize) -> String) -> String {
        let said = bit_of(&self.stripes);
        let (ImageFault::Copy(images)
        | ImageFault::NoInverse(images)
        | ImageFault::Shows(images, _)
        | ImageFault::Alike(images, _)
        | ImageFault::NoEdges(images)) = self.fault;
        let [one, other] = images.map(name);
        let fault = match &self.fault {
            ImageFault::Copy(_) => format!("{one} shows the same as {other}, not the stripes of {said}"),
            ImageFault::NoInverse(_) => {
                format!("{one} and {other} are not each other's inverse, as those of {said} are")
            }
            ImageFault::Shows(_, shown) => {
                format!("{one} and {other} show the stripes of {}, not of {said}", bit_of(shown))
            }
            ImageFault::Alike(_, also) => {
                format!("{one} and {other} show the same, not the stripes of {said} and of {}", bit_of(also))
            }
            ImageFault::NoEdges(_) => {
                format!("{one} and {other} do not show the stripes of {said}: the decoded coordinates reverse at their edges")
            }
        };
        format!("{fault}: the camera lagged, or a picture was taken twice; show each pattern longer, and scan again")
    }
}

fn bit_of(stripes: &Stripes) -> String {
    format!("bit {} along {}", stripes.bit, stripes.axis.name())
}

fn pair(channel: &StripeChannel) -> [usize; 2] {
    [channel.lit, channel.inverse]
}

/// Check of a scan for wrong images.
pub(super) struct ImageCheck<'a> {
    pub(super) light: &'a LightImages<'a>,
    /// Standard deviations of the pixels' differences, as shares of the projector's light.
    pub(super) noise: &'a [f32],
}

impl ImageCheck<'_> {
    pub(super) fn wrong_image(&self) -> Option<WrongImage> {
        self.unpaired().or_else(|| self.repeated()).or_else(|| self.alike())
    }

    /// Indices of at most [`SAMPLED`] pixels with little noise.
    fn sample(&self) -> Vec<usize> {
        let is_clear = |pixel: &usize| self.noise[*pixel] < MOST_NOISE;
        let clear: Vec<usize> = (0..self.noise.len()).filter(is_clear).collect();
        clear.iter().copied().step_by(clear.len().div_ceil(SAMPLED).max(1)).collect()
    }

    /// Light of an image at a pixel: 0 for black, 1 for white.
    fn share(&self, image: usize, pixel: usize) -> f32 {
        let Channels { white, black, .. } = *self.light.channels;
        let [white, black] = [white, black].map(|image| self.light.at(image, pixel));
        (self.light.at(image, pixel) - black) / (white - black)
    }

    /// Finds stripes that do not match their inverse.
    fn unpaired(&self) -> Option<WrongImage> {
        let sample = self.sample();
        let is_same = |channel: &StripeChannel, pixel: usize| {
            let shares = pair(channel).map(|image| self.share(image, pixel));
            let is_clipped = [channel.lit, channel.inverse, self.light.channels.white]
                .iter()
                .any(|image| self.light.images.levels[*image][pixel] >= CLIPPED_FROM);
            shares.iter().all(|share| *share < DARK) || (!is_clipped && shares.iter().all(|share| *share > LIT))
        };
        let worst = self.light.channels.axes.iter().flat_map(|axis| &axis.all).map(|channel| {
            let same = sample.iter().filter(|pixel| is_same(channel, **pixel)).count();
            (same as f64 / sample.len().max(1) as f64, channel)
        });
        let (share, channel) = worst.max_by(|one, other| one.0.total_cmp(&other.0))?;
        (share > MANY_UNPAIRED).then(|| {
            let twins = pair(channel).map(|image| self.twin(image, channel, &sample).map(|twin| [image, twin]));
            let fault = match twins {
                [Some(copy), None] | [None, Some(copy)] => ImageFault::Copy(copy),
                _ => ImageFault::NoInverse(pair(channel)),
            };
            WrongImage { stripes: channel.stripes, fault }
        })
    }

    /// Equal image of another pair.
    fn twin(&self, image: usize, channel: &StripeChannel, sample: &[usize]) -> Option<usize> {
        let every = (sample.len() / 5000).max(1);
        let difference = |other: usize| {
            let pixels = sample.iter().step_by(every);
            let sum: f32 = pixels.map(|pixel| (self.share(image, *pixel) - self.share(other, *pixel)).abs()).sum();
            sum * every as f32 / sample.len().max(1) as f32
        };
        let others = (0..self.light.images.levels.len()).filter(|other| !pair(channel).contains(other));
        let nearest = others.map(|other| (difference(other), other)).min_by(|one, other| one.0.total_cmp(&other.0))?;
        (nearest.0 < SAME).then_some(nearest.1)
    }

    /// Bits of both axes, each axis from the coarsest on.
    fn bits(&self) -> Vec<&StripeChannel> {
        let axes = self.light.channels.axes.iter();
        axes.flat_map(|axis| &axis.all[..axis.code_bits]).take(u64::BITS as usize).collect()
    }

    /// Finds two bits, at least one of them fine, that are lit and dark in the same places.
    fn alike(&self) -> Option<WrongImage> {
        let bits = self.bits();
        let axes = self.light.channels.axes.iter();
        let fine: Vec<bool> = axes.flat_map(|axis| (0..axis.code_bits).map(|bit| bit >= FIRST_FINE_BIT)).collect();
        let sample = self.sample();
        let signs: Vec<[u64; 2]> = (sample.iter().step_by(sample.len().div_ceil(COMPARED).max(1)))
            .map(|pixel| self.signs(&bits, *pixel))
            .collect();
        let pairs = (0..bits.len()).flat_map(|one| (one + 1..bits.len()).map(move |other| [one, other]));
        let agreeing = pairs.filter(|pair| pair.iter().any(|bit| fine[*bit])).filter_map(|[one, other]| {
            let both = 1 << one | 1 << other;
            let has = |signs: u64| signs & both == both;
            let (mut certain, mut same) = (0_u32, 0_u32);
            for [lit, dark] in &signs {
                certain += u32::from(has(lit | dark));
                same += u32::from(has(*lit) || has(*dark));
            }
            let is_comparable = f64::from(certain) > COMPARABLE * signs.len() as f64;
            (is_comparable && f64::from(same) > AGREEING * f64::from(certain)).then_some((same, one, other))
        });
        let (_, one, other) = agreeing.max()?;
        let images = [bits[one].lit, bits[other].lit];
        Some(WrongImage { stripes: bits[one].stripes, fault: ImageFault::Alike(images, bits[other].stripes) })
    }

    /// Finds bits with the same edges.
    fn repeated(&self) -> Option<WrongImage> {
        let bits = self.bits();
        let pairs = self.pixel_pairs(&bits);
        let is_wide = |bit: &usize| {
            let [edges, certain] = pairs.iter().fold([0_u32; 2], |[edges, certain], pair| {
                let edge = (pair.edges >> bit & 1) as u32;
                [edges + edge, certain + edge + ((pair.held[0] | pair.held[1]) >> bit & 1) as u32]
            });
            f64::from(edges) < MANY_EDGES * f64::from(certain)
        };
        let wide = (0..bits.len()).filter(is_wide).fold(0_u64, |wide, bit| wide | 1 << bit);
        let mut alone = vec![0_u32; bits.len()];
        let mut shared = vec![0_u32; bits.len() * bits.len()];
        for pair in &pairs {
            let edges = pair.edges & wide;
            let first = edges.trailing_zeros() as usize;
            match edges.count_ones() {
                1 => alone[first] += 1,
                2 => shared[first * bits.len() + (u64::BITS - 1 - edges.leading_zeros()) as usize] += 1,
                _ => {}
            }
        }
        let shared = (0..shared.len()).filter_map(|index| {
            let (one, other, count) = (index / bits.len(), index % bits.len(), shared[index]);
            let is_shared = count >= LEAST_SHARED && count > SHARED_TO_ALONE * (alone[one] + alone[other]);
            is_shared.then_some((count, one, other))
        });
        let (_, one, other) = shared.max()?;
        let both = 1 << one | 1 << other;
        let events: Vec<&PixelPair> = pairs.iter().filter(|pair| pair.edges & wide == both).collect();
        Some(match [one, other].map(|bit| edges_fit(&bits, &events, bit, both)) {
            [Some(true), Some(false) | None] | [None, Some(false)] => shows(bits[other], bits[one]),
            [Some(false) | None, Some(true)] | [Some(false), None] => shows(bits[one], bits[other]),
            _ => {
                let alike = [bits[one].lit, bits[other].lit];
                WrongImage { stripes: bits[one].stripes, fault: ImageFault::Alike(alike, bits[other].stripes) }
            }
        })
    }

    /// Bits at pairs of near pixels.
    fn pixel_pairs(&self, bits: &[&StripeChannel]) -> Vec<PixelPair> {
        let width = self.light.images.size_px[0] as usize;
        let reach = [EDGE_REACH, EDGE_REACH * width];
        let mut pairs = Vec::new();
        for pixel in self.sample() {
            let mut here = None;
            for (along, by) in reach.into_iter().enumerate() {
                let is_inside = along == 1 || pixel % width + EDGE_REACH < width;
                if !is_inside || self.noise.get(pixel + by).is_none_or(|noise| *noise >= MOST_NOISE) {
                    continue;
                }
                let [lit, dark] = *here.get_or_insert_with(|| self.signs(bits, pixel));
                let [other_lit, other_dark] = self.signs(bits, pixel + by);
                let edges = (lit & other_dark) | (dark & other_lit);
                pairs.push(PixelPair { edges, held: [lit & other_lit, dark & other_dark] });
            }
        }
        pairs
    }

    /// Bits that are certainly lit at a pixel, and those that are certainly dark.
    fn signs(&self, bits: &[&StripeChannel], pixel: usize) -> [u64; 2] {
        let Channels { white, black, .. } = *self.light.channels;
        let limit = CERTAIN * (self.light.at(white, pixel) - self.light.at(black, pixel));
        let mut signs = [0; 2];
        for (bit, channel) in bits.iter().enumerate() {
            let difference = self.light.at(channel.lit, pixel) - self.light.at(channel.inverse, pixel);
            if difference.abs() > limit {
                signs[usize::from(difference < 0.0)] |= 1 << bit;
            }
        }
        signs
    }
}

/// Tests whether edges are those of a bit: there, the next finer bit is lit, and the one after it dark. `None` if these
/// bits are uncertain.
fn edges_fit(bits: &[&StripeChannel], events: &[&PixelPair], bit: usize, without: u64) -> Option<bool> {
    let is_finer = |finer: &usize| {
        bits.get(*finer).is_some_and(|next| next.stripes.axis == bits[bit].stripes.axis) && without >> finer & 1 == 0
    };
    let (next, after) = (Some(bit + 1).filter(is_finer), Some(bit + 2).filter(is_finer));
    let holds = |pair: &PixelPair, bit: usize| [0, 1].map(|state| pair.held[state] >> bit & 1 == 1);
    let (mut fit, mut known) = (0_u32, 0_u32);
    for pair in events {
        let [lit, _] = next.map_or([true, false], |next| holds(pair, next));
        let [_, dark] = after.map_or([false, true], |after| holds(pair, after));
        let is_known = [next, after].into_iter().flatten().all(|bit| holds(pair, bit).contains(&true));
        known += u32::from(is_known);
        fit += u32::from(is_known && lit && dark);
    }
    let is_conclusive = (next.is_some() || after.is_some()) && f64::from(known) > KNOWN * events.len() as f64;
    is_conclusive.then(|| f64::from(fit) > MOST_OF * f64::from(known))
}

fn shows(said: &StripeChannel, shown: &StripeChannel) -> WrongImage {
    WrongImage { stripes: said.stripes, fault: ImageFault::Shows(pair(said), shown.stripes) }
}

/// Bits at two near pixels.
struct PixelPair {
    /// Bits that are lit at one and dark at the other.
    edges: u64,
    /// Bits that are lit at both, and those that are dark at both.
    held: [u64; 2],
}

/// Finds a bit along whose edges coordinates fold back.
pub(super) fn folded(pixels: &[DecodedPixel], width: usize, channels: &Channels) -> Option<WrongImage> {
    let margin = (SIDE + HALF_SLOPE) * (width + 1);
    let mut counts = channels.axes.each_ref().map(|axis| vec![FoldCounts::default(); axis.code_bits]);
    for index in margin..pixels.len().saturating_sub(margin) {
        if !pixels[index - SIDE].is_decoded() && !pixels[index - SIDE * width].is_decoded() {
            continue;
        }
        for along in 0..2 {
            for axis in Axis::ALL {
                if let Some(slopes) = SlopePair::new(pixels, width, index, along, axis) {
                    slopes.count(&channels.axes[axis.index()], &mut counts[axis.index()]);
                }
            }
        }
    }
    let bits = channels.axes.iter().zip(&counts).flat_map(|(axis, counts)| axis.all.iter().zip(counts));
    let is_folded = |folds: &FoldCounts| folds.back >= LEAST_FOLDS && folds.back > FOLDS_TO_PASSES * folds.on;
    let (channel, _) = bits.filter(|(_, folds)| is_folded(folds)).max_by_key(|(_, folds)| folds.back)?;
    Some(WrongImage { stripes: channel.stripes, fault: ImageFault::NoEdges(pair(channel)) })
}

/// Numbers of edges of a bit at which coordinates fold back, and at which they go on.
#[derive(Debug, Clone, Copy, Default)]
struct FoldCounts {
    back: u32,
    on: u32,
}

/// Two slopes of the coordinates that meet at a place.
struct SlopePair {
    /// Coordinate of the place, projector pixels.
    at: f32,
    /// Change of the coordinate over half the distance to either side, projector pixels.
    reach: f32,
    is_back: bool,
}

impl SlopePair {
    /// `None` where the surface is not continuous.
    fn new(pixels: &[DecodedPixel], width: usize, index: usize, along: usize, axis: Axis) -> Option<Self> {
        let by = SIDE * [1, width][along];
        let slope = |index: usize, axis: usize| {
            [1, width].map(|by| pixels[index + HALF_SLOPE * by].at[axis] - pixels[index - HALF_SLOPE * by].at[axis])
        };
        let (axis, other) = (axis.index(), 1 - axis.index());
        let (before, after) = (slope(index - by, axis), slope(index + by, axis));
        let length = before[0].hypot(before[1]);
        if length <= 1.0 || before[along].abs() <= 0.5 * length {
            return None;
        }
        let sum = (before[0] + after[0]).hypot(before[1] + after[1]);
        let difference = (before[0] - after[0]).hypot(before[1] - after[1]);
        let is_back = sum < 0.4 * length;
        let (other_before, other_after) = (slope(index - by, other), slope(index + by, other));
        let other_difference = (other_before[0] - other_after[0]).hypot(other_before[1] - other_after[1]);
        let goes_on = other_difference < 0.4 * other_before[0].hypot(other_before[1]);
        let meets = [
            pixels[index - by].at[axis] + before[along] * SIDE as f32 / (2 * HALF_SLOPE) as f32,
            pixels[index + by].at[axis] - after[along] * SIDE as f32 / (2 * HALF_SLOPE) as f32,
        ];
        let does_meet = (meets[0] - meets[1]).abs() < 1.0 + 0.5 * length;
        let is_one = goes_on && does_meet && (is_back || difference < 0.4 * length);
        is_one.then_some(Self { at: 0.5 * (meets[0] + meets[1]), reach: (0.5 * length).max(1.0), is_back })
    }

    fn count(&self, channels: &AxisChannels, counts: &mut [FoldCounts]) {
        let sides = [self.at - self.reach, self.at + self.reach].map(|at| at.round().max(0.0) as u32);
        for (channel, folds) in channels.all.iter().zip(counts) {
            let stripes = &channel.stripes;
            if stripes.width_px() < LEAST_WIDTH_PX.max(f64::from(4.0 * self.reach)) {
                break;
            }
            if stripes.is_lit(sides[0]) != stripes.is_lit(sides[1]) {
                *(if self.is_back { &mut folds.back } else { &mut folds.on }) += 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patterns::gray_code;

    const SIDE: usize = 80;

    /// Slanted surface, decoded with a lost bit: where its stripes are lit, columns are mirrored about the edge before.
    fn surface(lost: Option<Stripes>) -> Vec<DecodedPixel> {
        let pixel = |index: usize| {
            let (x, y) = ((index % SIDE) as f32, (index / SIDE) as f32);
            let (mut u, v) = (20.3 + 2.0 * x + 0.2 * y, 10.6 + 1.8 * y - 0.1 * x);
            if let Some(stripes) = lost.filter(|stripes| stripes.is_lit(u.round() as u32)) {
                // The bit's stripes begin in the middle of a block of their width.
                let block = stripes.width_px() as f32;
                u = (2.0 * ((u + 0.5) / block).floor() + 1.0) * block - 1.0 - u;
            }
            DecodedPixel { at: [u, v], sigma: [0.1; 2] }
        };
        (0..SIDE * SIDE).map(pixel).collect()
    }

    #[test]
    fn a_lost_bit_folds_coordinates_back_along_its_edges() {
        let channels = Channels::new(&gray_code([256, 256])).unwrap();
        assert_eq!(folded(&surface(None), SIDE, &channels), None);
        for bit in [1, 2] {
            let channel = &channels.axes[0].all[bit];
            let found = folded(&surface(Some(channel.stripes)), SIDE, &channels);
            assert_eq!(found.map(|found| found.stripes), Some(channel.stripes), "{bit}");
            assert_eq!(found.map(|found| found.fault), Some(ImageFault::NoEdges(pair(channel))));
        }
    }
}
