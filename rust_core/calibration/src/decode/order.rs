//! Whether each picture shows the stripes that it is said to show. A camera that lags, or a picture that is taken
//! twice, puts another pattern's picture in its place, and each bit that is read wrongly mirrors a part of the code.
//!
//! Four things convict a picture:
//! - It and its inverse are dark, or lit, in the same places ([`unpaired`]).
//! - Its stripes have their edges where another bit's have them ([`repeated`]). Of a Gray code's bits, only one changes
//!   along a line; several change only where one surface ends before another.
//! - It is lit and dark where another bit is, nearly everywhere, and one of both is so fine that stripes of another
//!   width cannot be ([`alike`]).
//! - Coordinates turn back along the lines of its edges ([`turned`]). Seen from in front, no surface does that: a
//!   projector's picture has the same orientation everywhere on it.

use super::channels::{AxisChannels, Channel, Channels};
use super::response::Response;
use super::{DecodedPixel, Pictures};
use crate::patterns::{Axis, Stripes};

/// The level from which on a pixel may be clipped.
const CLIPPED_FROM: u8 = 254;
/// Pixels that are looked at.
const LOOKED_AT: usize = 150_000;
/// A pixel is dark or lit for sure below and above these shares of the projector's light; white is 1.
const DARK: f32 = 0.2;
const LIT: f32 = 0.85;
/// Pixels whose noise is larger do not count, as a share of the projector's light.
const MOST_NOISE: f32 = 0.05;
/// The share of pixels that are the same in stripes and in their inverse from which on these are no pair.
const MANY_UNPAIRED: f64 = 0.15;
/// Pictures whose light differs by less than this share of the projector's, in the mean, are the same.
const SAME: f32 = 0.04;
/// A stripe is read for sure if it is so bright or dark: 1 is as white and black are.
const CERTAIN: f32 = 0.35;
/// How far apart pixels are between which stripes may have an edge, camera pixels.
const EDGE_REACH: usize = 3;
/// Stripes with an edge between more of these pixels are too fine to tell where surfaces end.
const MANY_EDGES: f64 = 0.35;
/// Edges that two bits share, and how many times more these are than each bit's own, from which on they convict.
const LEAST_SHARED: u32 = 100;
const SHARED_TO_ALONE: u32 = 2;
/// Bits from this one on have so many stripes that another bit agrees with them at half of the pixels.
const FIRST_FINE_BIT: usize = 4;
/// Two bits are the same picture if they agree at this share of the pixels where both are certain, which have to be
/// this share of the pixels that are looked at.
const AGREEING: f64 = 0.9;
const COMPARABLE: f64 = 0.05;
/// Pixels at which bits are compared.
const COMPARED: usize = 20_000;
/// Edges are a bit's if finer bits say so at this share of them, of which they have to be seen at this share.
const MOST_OF: f64 = 0.75;
const KNOWN: f64 = 0.3;
/// Places where coordinates turn back along the lines of a bit, and how many times more there are than places where
/// they go on.
const LEAST_TURNS: u32 = 30;
const TURNS_TO_PASSES: u32 = 2;
/// How far from a line both sides are looked at, and half the length of a slope, camera pixels.
const SIDE: usize = 4;
const HALF_SLOPE: usize = 2;
/// Stripes along whose edges that can be seen are at least so wide, projector pixels.
const LEAST_WIDTH_PX: f64 = 16.0;

/// A picture that does not show what it is said to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WrongPicture {
    /// The stripes that it is said to show.
    pub stripes: Stripes,
    /// The fault.
    pub fault: PictureFault,
}

/// A picture's fault. All numbers are indices of pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PictureFault {
    /// The first one shows what the second one shows.
    Copy([usize; 2]),
    /// Both should be each other's inverse.
    NoInverse([usize; 2]),
    /// Both, stripes and inverse, show other stripes' bit.
    Shows([usize; 2], Stripes),
    /// Both show the same stripes, and it is not known which of both.
    Alike([usize; 2], Stripes),
    /// Both, stripes and inverse, do not change where they should.
    NoEdges([usize; 2]),
}

impl WrongPicture {
    /// Describes the fault with the pictures' names.
    pub fn describe(&self, name: impl Fn(usize) -> String) -> String {
        let said = bit_of(&self.stripes);
        let fault = match &self.fault {
            PictureFault::Copy([one, other]) => {
                format!("{} shows the same as {}, not the stripes of {said}", name(*one), name(*other))
            }
            PictureFault::NoInverse([one, other]) => {
                format!("{} and {} are not each other's inverse, as those of {said} are", name(*one), name(*other))
            }
            PictureFault::Shows([one, other], shown) => {
                format!("{} and {} show the stripes of {}, not of {said}", name(*one), name(*other), bit_of(shown))
            }
            PictureFault::Alike([one, other], also) => {
                format!(
                    "{} and {} show the same, not the stripes of {said} and of {}",
                    name(*one),
                    name(*other),
                    bit_of(also)
                )
            }
            PictureFault::NoEdges([one, other]) => format!(
                "{} and {} do not show the stripes of {said}: the code turns back where these have their edges",
                name(*one),
                name(*other)
            ),
        };
        format!("{fault}: the camera lagged, or a picture was taken twice; show each pattern longer, and scan again")
    }
}

fn bit_of(stripes: &Stripes) -> String {
    format!("bit {} along {}", stripes.bit, stripes.axis.name())
}

fn pair(channel: &Channel) -> [usize; 2] {
    [channel.lit, channel.inverse]
}

/// What decides on pictures' order: pictures in linear light.
pub(super) struct Order<'a> {
    pub(super) pictures: &'a Pictures<'a>,
    pub(super) channels: &'a Channels,
    pub(super) response: &'a Response,
    /// For each pixel the standard deviation of its differences, as a share of the projector's light.
    pub(super) noise: &'a [f32],
}

impl Order<'_> {
    /// The first picture that others convict.
    pub(super) fn wrong_picture(&self) -> Option<WrongPicture> {
        self.unpaired().or_else(|| self.repeated()).or_else(|| self.alike())
    }

    /// Indices of pixels that see clearly, at most [`LOOKED_AT`] of them.
    fn sample(&self) -> Vec<usize> {
        let is_clear = |pixel: &usize| self.noise[*pixel] < MOST_NOISE;
        let clear: Vec<usize> = (0..self.noise.len()).filter(is_clear).collect();
        clear.iter().copied().step_by(clear.len().div_ceil(LOOKED_AT).max(1)).collect()
    }

    fn light(&self, picture: usize, pixel: usize) -> f32 {
        self.response.light(self.pictures.levels[picture][pixel])
    }

    /// The light of a picture at a pixel: 0 is as black is, 1 as white.
    fn share(&self, picture: usize, pixel: usize) -> f32 {
        let [white, black] = [self.channels.white, self.channels.black].map(|picture| self.light(picture, pixel));
        (self.light(picture, pixel) - black) / (white - black)
    }

    /// Stripes that are no pair with their inverse.
    fn unpaired(&self) -> Option<WrongPicture> {
        let sample = self.sample();
        let is_same = |channel: &Channel, pixel: usize| {
            let shares = pair(channel).map(|picture| self.share(picture, pixel));
            let is_clipped = [channel.lit, channel.inverse, self.channels.white]
                .iter()
                .any(|picture| self.pictures.levels[*picture][pixel] >= CLIPPED_FROM);
            shares.iter().all(|share| *share < DARK) || (!is_clipped && shares.iter().all(|share| *share > LIT))
        };
        let worst = self.channels.axes.iter().flat_map(|axis| &axis.all).map(|channel| {
            let same = sample.iter().filter(|pixel| is_same(channel, **pixel)).count();
            (same as f64 / sample.len().max(1) as f64, channel)
        });
        let (share, channel) = worst.max_by(|one, other| one.0.total_cmp(&other.0))?;
        (share > MANY_UNPAIRED).then(|| {
            let twins = pair(channel).map(|picture| self.twin(picture, channel, &sample).map(|twin| [picture, twin]));
            let fault = match twins {
                [Some(copy), None] | [None, Some(copy)] => PictureFault::Copy(copy),
                _ => PictureFault::NoInverse(pair(channel)),
            };
            WrongPicture { stripes: channel.stripes, fault }
        })
    }

    /// Another picture that is the same and not of this pair.
    fn twin(&self, picture: usize, channel: &Channel, sample: &[usize]) -> Option<usize> {
        let every = (sample.len() / 5000).max(1);
        let difference = |other: usize| {
            let pixels = sample.iter().step_by(every);
            let sum: f32 = pixels.map(|pixel| (self.share(picture, *pixel) - self.share(other, *pixel)).abs()).sum();
            sum * every as f32 / sample.len().max(1) as f32
        };
        let others = (0..self.pictures.levels.len()).filter(|other| !pair(channel).contains(other));
        let nearest = others.map(|other| (difference(other), other)).min_by(|one, other| one.0.total_cmp(&other.0))?;
        (nearest.0 < SAME).then_some(nearest.1)
    }

    /// The bits of both axes, each axis from the coarsest on.
    fn bits(&self) -> Vec<&Channel> {
        self.channels.axes.iter().flat_map(|axis| &axis.all[..axis.code_bits]).take(u64::BITS as usize).collect()
    }

    /// Two bits that are lit and dark in the same places, at least one of them a fine one.
    fn alike(&self) -> Option<WrongPicture> {
        let bits = self.bits();
        let fine = self.channels.axes.iter().flat_map(|axis| (0..axis.code_bits).map(|bit| bit >= FIRST_FINE_BIT));
        let fine: Vec<bool> = fine.collect();
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
        let pictures = [bits[one].lit, bits[other].lit];
        Some(WrongPicture { stripes: bits[one].stripes, fault: PictureFault::Alike(pictures, bits[other].stripes) })
    }

    /// Bits whose stripes have the same edges.
    fn repeated(&self) -> Option<WrongPicture> {
        let bits = self.bits();
        let steps = self.steps(&bits);
        let is_wide = |bit: &usize| {
            let [edges, seen] = steps.iter().fold([0_u32; 2], |[edges, seen], step| {
                let edge = (step.edges >> bit & 1) as u32;
                [edges + edge, seen + edge + ((step.held[0] | step.held[1]) >> bit & 1) as u32]
            });
            f64::from(edges) < MANY_EDGES * f64::from(seen)
        };
        let wide = (0..bits.len()).filter(is_wide).fold(0_u64, |wide, bit| wide | 1 << bit);
        let mut alone = vec![0_u32; bits.len()];
        let mut shared = vec![0_u32; bits.len() * bits.len()];
        for step in &steps {
            let edges = step.edges & wide;
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
        let events: Vec<&Step> = steps.iter().filter(|step| step.edges & wide == both).collect();
        Some(match [one, other].map(|bit| edges_fit(&bits, &events, bit, both)) {
            [Some(true), Some(false) | None] | [None, Some(false)] => shows(bits[other], bits[one]),
            [Some(false) | None, Some(true)] | [Some(false), None] => shows(bits[one], bits[other]),
            _ => {
                let alike = [bits[one].lit, bits[other].lit];
                WrongPicture { stripes: bits[one].stripes, fault: PictureFault::Alike(alike, bits[other].stripes) }
            }
        })
    }

    /// What stripes do between pixels that are near each other.
    fn steps(&self, bits: &[&Channel]) -> Vec<Step> {
        let width = self.pictures.size_px[0] as usize;
        let reach = [EDGE_REACH, EDGE_REACH * width];
        let mut steps = Vec::new();
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
                steps.push(Step { edges, held: [lit & other_lit, dark & other_dark] });
            }
        }
        steps
    }

    /// The bits that are lit for sure at a pixel, and those that are dark.
    fn signs(&self, bits: &[&Channel], pixel: usize) -> [u64; 2] {
        let [white, black] = [self.channels.white, self.channels.black].map(|picture| self.light(picture, pixel));
        let limit = CERTAIN * (white - black);
        let mut signs = [0; 2];
        for (bit, channel) in bits.iter().enumerate() {
            let difference = self.light(channel.lit, pixel) - self.light(channel.inverse, pixel);
            if difference.abs() > limit {
                signs[usize::from(difference < 0.0)] |= 1 << bit;
            }
        }
        signs
    }
}

/// Whether edges are where a bit has them: there, the next finer bit is lit, and the one after it dark. None if these
/// bits tell nothing.
fn edges_fit(bits: &[&Channel], events: &[&Step], bit: usize, without: u64) -> Option<bool> {
    let is_finer = |finer: &usize| {
        bits.get(*finer).is_some_and(|next| next.stripes.axis == bits[bit].stripes.axis) && without >> finer & 1 == 0
    };
    let (next, after) = (Some(bit + 1).filter(is_finer), Some(bit + 2).filter(is_finer));
    let holds = |step: &Step, bit: usize| [0, 1].map(|state| step.held[state] >> bit & 1 == 1);
    let (mut fit, mut seen) = (0_u32, 0_u32);
    for step in events {
        let [lit, _] = next.map_or([true, false], |next| holds(step, next));
        let [_, dark] = after.map_or([false, true], |after| holds(step, after));
        let is_known = [next, after].into_iter().flatten().all(|bit| holds(step, bit).contains(&true));
        seen += u32::from(is_known);
        fit += u32::from(is_known && lit && dark);
    }
    let tells = (next.is_some() || after.is_some()) && f64::from(seen) > KNOWN * events.len() as f64;
    tells.then(|| f64::from(fit) > MOST_OF * f64::from(seen))
}

fn shows(said: &Channel, shown: &Channel) -> WrongPicture {
    WrongPicture { stripes: said.stripes, fault: PictureFault::Shows(pair(said), shown.stripes) }
}

/// Two pixels that are near each other.
struct Step {
    /// The bits that are lit at one and dark at the other.
    edges: u64,
    /// The bits that are lit at both, and those that are dark at both.
    held: [u64; 2],
}

/// A bit along whose edges coordinates turn back.
pub(super) fn turned(pixels: &[DecodedPixel], width: usize, channels: &Channels) -> Option<WrongPicture> {
    let margin = (SIDE + HALF_SLOPE) * (width + 1);
    let mut counts = channels.axes.each_ref().map(|axis| vec![Turns::default(); axis.code_bits]);
    for index in margin..pixels.len().saturating_sub(margin) {
        if !pixels[index - SIDE].is_decoded() && !pixels[index - SIDE * width].is_decoded() {
            continue;
        }
        for along in 0..2 {
            for axis in Axis::ALL {
                if let Some(place) = Place::new(pixels, width, index, along, axis) {
                    place.count(&channels.axes[axis.index()], &mut counts[axis.index()]);
                }
            }
        }
    }
    let bits = channels.axes.iter().zip(&counts).flat_map(|(axis, counts)| axis.all.iter().zip(counts));
    let is_turned = |turns: &Turns| turns.back >= LEAST_TURNS && turns.back > TURNS_TO_PASSES * turns.on;
    let (channel, _) = bits.filter(|(_, turns)| is_turned(turns)).max_by_key(|(_, turns)| turns.back)?;
    Some(WrongPicture { stripes: channel.stripes, fault: PictureFault::NoEdges(pair(channel)) })
}

/// How often coordinates turn back at the edges of a bit's stripes, and how often they go on.
#[derive(Debug, Clone, Copy, Default)]
struct Turns {
    back: u32,
    on: u32,
}

/// A place between two slopes that meet.
struct Place {
    /// The coordinate there, projector pixels.
    at: f32,
    /// By how much it changes over half the distance to either side, projector pixels.
    reach: f32,
    is_back: bool,
}

impl Place {
    /// None where the surface does not go on.
    fn new(pixels: &[DecodedPixel], width: usize, index: usize, along: usize, axis: Axis) -> Option<Self> {
        let by = SIDE * [1, width][along];
        let slope = |index: usize, axis: usize| {
            [1, width].map(|by| pixels[index + HALF_SLOPE * by].at[axis] - pixels[index - HALF_SLOPE * by].at[axis])
        };
        let (axis, other) = (axis.index(), 1 - axis.index());
        let (before, after) = (slope(index - by, axis), slope(index + by, axis));
        let length = before[0].hypot(before[1]);
        let is_seen = length > 1.0 && before[along].abs() > 0.5 * length;
        if !is_seen {
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

    fn count(&self, channels: &AxisChannels, counts: &mut [Turns]) {
        let sides = [self.at - self.reach, self.at + self.reach].map(|at| at.round().max(0.0) as u32);
        for (channel, turns) in channels.all.iter().zip(counts) {
            let stripes = &channel.stripes;
            if stripes.width_px() < LEAST_WIDTH_PX.max(f64::from(4.0 * self.reach)) {
                break;
            }
            if stripes.is_lit(sides[0]) != stripes.is_lit(sides[1]) {
                *(if self.is_back { &mut turns.back } else { &mut turns.on }) += 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patterns::gray_code;

    const SIDE: usize = 80;

    /// A slanted surface whose columns a code says that has lost a bit: where the stripes of this bit are lit, columns
    /// are those on the other side of the line before them.
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
    fn a_bit_that_is_lost_turns_coordinates_back_along_its_lines() {
        let channels = Channels::new(&gray_code([256, 256])).unwrap();
        assert_eq!(turned(&surface(None), SIDE, &channels), None);
        for bit in [1, 2] {
            let channel = &channels.axes[0].all[bit];
            let found = turned(&surface(Some(channel.stripes)), SIDE, &channels);
            assert_eq!(found.map(|found| found.stripes), Some(channel.stripes), "{bit}");
            assert_eq!(found.map(|found| found.fault), Some(PictureFault::NoEdges(pair(channel))));
        }
    }
}
