//! A scan that was recorded: a bag has the camera's topics while someone showed the patterns.
//!
//! 1. All frames are searched for changes ([`timeline`]), and for the patterns ([`sequence`]).
//! 2. The frames of each pattern are averaged, and so is depth.
//! 3. The checks of a live scan follow (light, exposure, motion, orientation), and the decoding.

mod by_marks;
mod by_order;
mod by_topic;
mod footage;
mod images;
mod pairs;
pub(crate) mod sequence;
mod timeline;

use std::collections::BTreeMap;
use std::ops::Range;

use rcs_calibration::patterns::Pattern;
use rcs_files::capture::PatternImage;

use crate::compare::ImageChange;
use crate::depth_average::DepthAverage;
use crate::failure::{check_size, ScanFailure};
use crate::finish::{check_keystone, check_orientation, ScanImages, ScanResult};
use crate::light::{average, Illumination};
use crate::robot::captured_robot;
use crate::session::ScanEvent;
pub use footage::BagFootage;
pub use images::ImageSet;
use sequence::PatternSequence;
pub use sequence::PatternSequenceError;
use timeline::Timeline;

/// Most segments: a number for each pattern, and a number.
const MAX_SEGMENTS: [usize; 2] = [4, 200];
/// Limit of the difference in exposure between white and black and any stripes, as a share.
const MAX_EXPOSURE: f64 = 0.12;

/// Options of the scan of a recording.
pub struct RecordedOptions {
    /// The projector's width and height, pixels.
    pub projector_px: [u32; 2],
    /// The patterns in the order in which they were shown, or in any if the bag has their topic; white and black are
    /// among them.
    pub patterns: Vec<Pattern>,
    /// Frames that each image is the mean of, at least 1.
    pub frames: usize,
}

/// Scans a recording.
///
/// # Errors
/// [`ScanFailure`]: the first thing that would make a calibration wrong, or an unreadable message.
pub fn scan(
    footage: &BagFootage,
    options: &RecordedOptions,
    observe: &mut dyn FnMut(ScanEvent<'_>),
) -> Result<ScanResult, ScanFailure> {
    let timeline = Timeline::read(footage)?;
    let sequence = find(footage, &timeline, options)?;
    observe(ScanEvent::Note(&describe(&sequence, &timeline)));
    let means = SegmentMeans::read(footage, &sequence, options.frames)?;
    let images: Vec<PatternImage> = (sequence.shown.iter())
        .map(|(pattern, frames)| PatternImage { pattern: *pattern, grey: means.of(frames) })
        .collect();
    let light = check(footage, &timeline, &sequence, &means, &images)?;
    let mut warn = |warning: &str| observe(ScanEvent::Warning(warning));
    light.warn(&mut warn);
    let lens = footage.lens;
    check_orientation(&images, &light, lens.size_px, options.projector_px, &mut warn)?;
    let depth = footage.has_depth().then(|| average_depth(footage, &timeline, &sequence)).transpose()?;
    if let Some(depth) = &depth {
        check_keystone(&images, depth, &lens, options.projector_px, &mut warn)?;
    }
    let images = ScanImages {
        projector_px: options.projector_px,
        lens,
        frame_id: footage.frame_id.clone(),
        images,
        light: &light,
        depth: depth.as_ref(),
        ended: None,
    };
    let mut scanned = images.finish(&mut warn)?;
    // A camera that adapts its exposure would have been noticed live, when black and white alternate.
    let change = scanned.decoded.quality.exposure_change;
    if change > MAX_EXPOSURE {
        return Err(ScanFailure::Unsteady(change));
    }
    let transforms = footage.transforms(timeline.time(extent(&sequence).end))?;
    scanned.capture.robot = captured_robot(&transforms, &footage.frame_id, None);
    Ok(scanned)
}

/// Finds the patterns by their topic, else by the checkerboards between them, else by their order.
fn find(footage: &BagFootage, timeline: &Timeline, options: &RecordedOptions) -> Result<PatternSequence, ScanFailure> {
    let patterns = &options.patterns;
    let known: Vec<(Vec<u8>, Pattern)> =
        patterns.iter().map(|pattern| (pattern.image(options.projector_px), *pattern)).collect();
    let recognise = |image: &[u8]| known.iter().find(|(known, _)| known == image).map(|(_, pattern)| *pattern);
    if let Some(shown) = footage.shown(&recognise)? {
        return Ok(by_topic::find(timeline, &shown, patterns)?);
    }
    let segments = timeline.segments();
    let [for_each, more] = MAX_SEGMENTS;
    if segments.len() > for_each * patterns.len() + more {
        return Err(PatternSequenceError::Restless { count: segments.len(), patterns: patterns.len() }.into());
    }
    let found = by_marks::find(timeline, &segments, patterns);
    Ok(found.unwrap_or_else(|| by_order::find(timeline, &segments, patterns))?)
}

fn describe(sequence: &PatternSequence, timeline: &Timeline) -> String {
    let Range { start, end } = extent(sequence);
    let [from, to] = [start, end].map(|frame| timeline.time(frame).as_secs_f64());
    let count = sequence.shown.len();
    let delay = sequence.delay.map_or(String::new(), |delay| format!(", {} ms after showing", delay.as_millis()));
    format!("{count} patterns are seen from {from:.1} s to {to:.1} s of the recording{delay}")
}

/// From the first frame of a pattern to the last.
fn extent(sequence: &PatternSequence) -> Range<usize> {
    let used = || sequence.shown.iter().map(|(_, frames)| frames);
    let start = used().map(|frames| frames.start).min().unwrap_or_default();
    start..used().map(|frames| frames.end).max().unwrap_or_default()
}

/// The frames of each pattern, and those of a repeated image.
fn segments(sequence: &PatternSequence) -> impl Iterator<Item = &Range<usize>> {
    sequence.shown.iter().map(|(_, frames)| frames).chain(sequence.repeated.iter().flatten())
}

/// The mean of the last frames of each segment of a sequence, by its first frame.
struct SegmentMeans(BTreeMap<usize, Vec<u8>>);

impl SegmentMeans {
    fn read(footage: &BagFootage, sequence: &PatternSequence, count: usize) -> Result<Self, ScanFailure> {
        let last = |frames: &Range<usize>| frames.end.saturating_sub(count.max(1)).max(frames.start)..frames.end;
        let owner: BTreeMap<usize, usize> =
            segments(sequence).flat_map(|frames| last(frames).map(|frame| (frame, frames.start))).collect();
        let camera_px = footage.lens.size_px;
        let mut taken: BTreeMap<usize, Vec<Vec<u8>>> = BTreeMap::new();
        let mut means = BTreeMap::new();
        footage.frames(&|frame| owner.contains_key(&frame), &mut |frame, _, size_px, grey| {
            check_size("picture", size_px, grey.len(), camera_px)?;
            if let Some(start) = owner.get(&frame) {
                taken.entry(*start).or_default().push(grey);
                // After the segment, its frames need no memory any more.
                if owner.get(&(frame + 1)) != Some(start) {
                    means.extend(taken.remove(start).map(|taken| (*start, average(taken.iter()))));
                }
            }
            Ok(())
        })?;
        Ok(Self(means))
    }

    fn of(&self, frames: &Range<usize>) -> Vec<u8> {
        self.0.get(&frames.start).cloned().unwrap_or_default()
    }
}

/// Checks light and motion, and the exposure by a repeated image.
fn check(
    footage: &BagFootage,
    timeline: &Timeline,
    sequence: &PatternSequence,
    means: &SegmentMeans,
    images: &[PatternImage],
) -> Result<Illumination, ScanFailure> {
    let patterns: Vec<Pattern> = images.iter().map(|image| image.pattern).collect();
    let find = |wanted| sequence.shown.iter().find(|(pattern, _)| *pattern == wanted).map(|(_, frames)| frames);
    let (Some(white), Some(black)) = (find(Pattern::White), find(Pattern::Black)) else {
        let missing = if find(Pattern::White).is_none() { "the white picture" } else { "the black picture" };
        return Err(rcs_calibration::DecodeError::Missing(missing).into());
    };
    let noise = timeline.noise(white).max(timeline.noise(black));
    let camera_px = footage.lens.size_px;
    let light = Illumination::of_images(&means.of(black), &means.of(white), camera_px, noise, &footage.name);
    let light = light.map_err(|failure| match failure {
        // The frames do change.
        ScanFailure::NoLight { .. } => PatternSequenceError::NotWhite.into(),
        failure => failure,
    })?;
    if let Some([early, late]) = &sequence.repeated {
        ImageChange::between(&means.of(early), &means.of(late), &light.lit, noise).check()?;
    }
    let at_lit = |image: &PatternImage| light.lit.iter().map(|pixel| image.grey[*pixel]).collect();
    let lit: Vec<Vec<u8>> = images.iter().map(at_lit).collect();
    let lit: Vec<&[u8]> = lit.iter().map(Vec::as_slice).collect();
    pairs::check(&patterns, &lit)?;
    Ok(light)
}

/// The mean depth during the scan.
fn average_depth(
    footage: &BagFootage,
    timeline: &Timeline,
    sequence: &PatternSequence,
) -> Result<DepthAverage, ScanFailure> {
    let [width, height] = footage.lens.size_px;
    let mut average = DepthAverage::new(width as usize * height as usize);
    let Range { start, end } = extent(sequence);
    footage.depths(timeline.time(start)..timeline.time(end), &mut |depth| {
        check_size("depth image", depth.size_px, depth.depth_m.len(), [width, height])?;
        average.add(&depth);
        Ok(())
    })?;
    Ok(average)
}
