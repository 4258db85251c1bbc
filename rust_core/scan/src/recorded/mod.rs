//! A scan that was recorded: a bag has the camera's topics while someone showed the patterns.
//!
//! 1. All pictures are looked at for changes ([`timeline`]), and which of them show which pattern is found out
//!    ([`sequence`]).
//! 2. Those are averaged, and depth with them.
//! 3. What a live scan checks is checked of them: light, exposure, rest, orientation; then they are decoded.

pub mod bag_footage;
mod by_marks;
mod by_order;
mod by_topic;
pub mod footage;
mod pairs;
pub(crate) mod sequence;
mod timeline;

use std::collections::BTreeMap;
use std::ops::Range;

use rcs_calibration::patterns::Pattern;
use rcs_files::capture::PatternPicture;

use crate::compare::Change;
use crate::depth_average::DepthAverage;
use crate::failure::{check_size, ScanFailure};
use crate::finish::{check_keystone, check_orientation, Scanned, Seen};
use crate::light::{average, Light, MOST_CHANGE};
use crate::session::ScanEvent;
use footage::Footage;
use sequence::Sequence;
pub use sequence::SequenceError;
use timeline::Timeline;

/// So many stretches for a pattern, and so many more, are too many to be looked through.
const MOST_STRETCHES: [usize; 2] = [4, 200];
/// The exposure may differ by this share between white and black and any stripes.
const MOST_EXPOSURE: f64 = 0.12;

/// What was shown, and how it is to be averaged.
pub struct RecordedOptions {
    /// The projector's width and height, pixels.
    pub projector_px: [u32; 2],
    /// The patterns in the order in which they were shown, white and black among them. With the times of a topic, any
    /// order.
    pub patterns: Vec<Pattern>,
    /// Pictures that each is the mean of, at least 1.
    pub frames: usize,
}

/// Scans a recording.
///
/// # Errors
/// [`ScanFailure`]: the first thing that would make a calibration wrong, or what cannot be read.
pub fn scan(
    footage: &dyn Footage,
    options: &RecordedOptions,
    observe: &mut dyn FnMut(ScanEvent<'_>),
) -> Result<Scanned, ScanFailure> {
    let timeline = Timeline::read(footage)?;
    let sequence = find(footage, &timeline, options)?;
    observe(ScanEvent::Note(&describe(&sequence, &timeline)));
    let means = Means::read(footage, &sequence, options.frames)?;
    let pictures: Vec<PatternPicture> = (sequence.shown.iter())
        .map(|(pattern, pictures)| PatternPicture { pattern: *pattern, grey: means.of(pictures) })
        .collect();
    let light = check(footage, &timeline, &sequence, &means, &pictures)?;
    let mut warn = |warning: &str| observe(ScanEvent::Warning(warning));
    light.warnings().iter().for_each(|warning| warn(warning));
    let lens = footage.lens();
    check_orientation(&pictures, &light, lens.size_px, options.projector_px, &footage.name(), &mut warn)?;
    let depth = footage.has_depth().then(|| average_depth(footage, &timeline, &sequence)).transpose()?;
    if let Some(depth) = &depth {
        check_keystone(&pictures, depth, &lens, options.projector_px, &mut warn)?;
    }
    let seen = Seen {
        projector_px: options.projector_px,
        lens,
        frame_id: footage.frame_id(),
        pictures,
        light: &light,
        depth: depth.as_ref(),
        is_whole: true,
    };
    let scanned = seen.finish(&mut warn)?;
    // Nobody watched black and white coming up, where a camera that adapts would have been seen.
    let change = scanned.decoded.quality.exposure_change;
    if change > MOST_EXPOSURE {
        return Err(ScanFailure::Unsteady { change });
    }
    Ok(scanned)
}

/// Finds the patterns by their topic, else by the marks between them, else by their order.
fn find(footage: &dyn Footage, timeline: &Timeline, options: &RecordedOptions) -> Result<Sequence, ScanFailure> {
    let patterns = &options.patterns;
    let known: Vec<(Vec<u8>, Pattern)> =
        patterns.iter().map(|pattern| (pattern.picture(options.projector_px), *pattern)).collect();
    let recognise = |picture: &[u8]| known.iter().find(|(known, _)| known == picture).map(|(_, pattern)| *pattern);
    if let Some(shown) = footage.shown(&recognise)? {
        return Ok(by_topic::find(timeline, &shown, patterns)?);
    }
    let stretches = timeline.stretches();
    let [for_each, more] = MOST_STRETCHES;
    if stretches.len() > for_each * patterns.len() + more {
        return Err(SequenceError::Restless { count: stretches.len(), patterns: patterns.len() }.into());
    }
    let found = by_marks::find(timeline, &stretches, patterns);
    Ok(found.unwrap_or_else(|| by_order::find(timeline, &stretches, patterns))?)
}

fn describe(sequence: &Sequence, timeline: &Timeline) -> String {
    let Range { start, end } = extent(sequence);
    let [from, to] = [start, end].map(|picture| timeline.time(picture).as_secs_f64());
    let count = sequence.shown.len();
    let delay = sequence.delay.map_or(String::new(), |delay| format!(", {} ms after showing", delay.as_millis()));
    format!("{count} patterns are seen from {from:.1} s to {to:.1} s of the recording{delay}")
}

/// From the first picture that is used to the last.
fn extent(sequence: &Sequence) -> Range<usize> {
    let used = || sequence.shown.iter().map(|(_, pictures)| pictures);
    let start = used().map(|pictures| pictures.start).min().unwrap_or_default();
    start..used().map(|pictures| pictures.end).max().unwrap_or_default()
}

/// The last pictures of a stretch.
fn averaged(pictures: &Range<usize>, frames: usize) -> Range<usize> {
    pictures.end.saturating_sub(frames.max(1)).max(pictures.start)..pictures.end
}

/// The means of the stretches of a sequence, by their first pictures.
struct Means(BTreeMap<usize, Vec<u8>>);

impl Means {
    fn read(footage: &dyn Footage, sequence: &Sequence, frames: usize) -> Result<Self, ScanFailure> {
        let alike = sequence.alike.iter().flatten();
        let stretches: Vec<&Range<usize>> = sequence.shown.iter().map(|(_, pictures)| pictures).chain(alike).collect();
        let owner: BTreeMap<usize, usize> = (stretches.iter())
            .flat_map(|pictures| averaged(pictures, frames).map(|picture| (picture, pictures.start)))
            .collect();
        let camera_px = footage.lens().size_px;
        let mut taken: BTreeMap<usize, Vec<Vec<u8>>> = BTreeMap::new();
        let mut means = BTreeMap::new();
        footage.pictures(&|picture| owner.contains_key(&picture), &mut |picture, _, size_px, grey| {
            check_size("picture", size_px, grey.len(), camera_px)?;
            if let Some(start) = owner.get(&picture) {
                taken.entry(*start).or_default().push(grey);
                // The stretch is over: its pictures need no memory any more.
                if owner.get(&(picture + 1)) != Some(start) {
                    means.extend(taken.remove(start).map(|taken| (*start, average(taken.iter()))));
                }
            }
            Ok(())
        })?;
        Ok(Self(means))
    }

    fn of(&self, pictures: &Range<usize>) -> Vec<u8> {
        self.0.get(&pictures.start).cloned().unwrap_or_default()
    }
}

/// Checks light, exposure and rest.
fn check(
    footage: &dyn Footage,
    timeline: &Timeline,
    sequence: &Sequence,
    means: &Means,
    pictures: &[PatternPicture],
) -> Result<Light, ScanFailure> {
    let patterns: Vec<Pattern> = pictures.iter().map(|picture| picture.pattern).collect();
    let find = |wanted| sequence.shown.iter().find(|(pattern, _)| *pattern == wanted).map(|(_, pictures)| pictures);
    let (Some(white), Some(black)) = (find(Pattern::White), find(Pattern::Black)) else {
        let missing = if find(Pattern::White).is_none() { "the white picture" } else { "the black picture" };
        return Err(rcs_calibration::DecodeError::Missing(missing).into());
    };
    let noise = timeline.noise(white).max(timeline.noise(black));
    let (camera_px, screen) = (footage.lens().size_px, footage.name());
    let light = Light::of_pictures(&means.of(black), &means.of(white), camera_px, noise, &screen);
    let light = light.map_err(|failure| match failure {
        // Something has changed in the pictures.
        ScanFailure::NoLight { .. } => SequenceError::NotWhite.into(),
        failure => failure,
    })?;
    let levels = [white, black].map(|pictures| timeline.level(pictures.end - 1));
    let all = sequence.shown.iter().map(|(_, pictures)| pictures).chain(sequence.alike.iter().flatten());
    let change = all.map(|pictures| drift(timeline, pictures)).fold(0.0, f64::max) / (levels[0] - levels[1]).max(1.0);
    if change > MOST_CHANGE {
        return Err(ScanFailure::Unsteady { change });
    }
    if let Some([early, late]) = &sequence.alike {
        Change::between(&means.of(early), &means.of(late), &light.lit, noise).check()?;
    }
    let looks: Vec<Vec<u8>> = pictures.iter().map(|picture| at(&picture.grey, &light.lit)).collect();
    let looks: Vec<&[u8]> = looks.iter().map(Vec::as_slice).collect();
    pairs::check(&patterns, &looks)?;
    Ok(light)
}

fn at(grey: &[u8], pixels: &[usize]) -> Vec<u8> {
    pixels.iter().map(|pixel| grey[*pixel]).collect()
}

/// By how many levels brightness changes in a stretch once it has had time to settle.
fn drift(timeline: &Timeline, pictures: &Range<usize>) -> f64 {
    let settled = pictures.start + pictures.len() / 3;
    (timeline.level(pictures.end - 1) - timeline.level(settled)).abs()
}

/// The mean depth during the scan.
fn average_depth(footage: &dyn Footage, timeline: &Timeline, sequence: &Sequence) -> Result<DepthAverage, ScanFailure> {
    let [width, height] = footage.lens().size_px;
    let mut average = DepthAverage::new(width as usize * height as usize);
    let Range { start, end } = extent(sequence);
    footage.depths(timeline.time(start)..timeline.time(end), &mut |depth| {
        check_size("depth image", depth.size_px, depth.depth_m.len(), [width, height])?;
        average.add(&depth);
        Ok(())
    })?;
    Ok(average)
}
