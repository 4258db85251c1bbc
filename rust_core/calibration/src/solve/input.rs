//! The samples as the solver uses them: checked, sorted by scan, with what does not change computed once.

use std::ops::Range;

use nalgebra::{Point2, Point3, Vector3};

use super::noise::quantile;
use super::random::SplitMix64;
use super::{FocalLengths, Parameter, Refusal, SolveOptions};
use crate::{Lens, Sample};

/// Samples of one scan that a pose needs (three determine it, one chooses, two show whether it is right).
const NEEDED_FOR_POSE: usize = 6;
/// Samples of one scan that a lens needs: twice as many as determine it.
const NEEDED_FOR_LENS: usize = 12;
/// How far beside the picture's outermost pixels' borders a pixel is still noise: pixels, and deviations of its own.
const BESIDE_PX: f64 = 0.5;
const BESIDE: f64 = 2.0;
/// The share of samples that may lie farther outside, as gross errors.
const OUTSIDE: f64 = 0.002;
/// Points that are farther away, in the middle, are not given in metres: no depth camera sees so far.
const FARTHEST_M: f64 = 40.0;
/// Smaller deviations of pixels are not believed.
const LEAST_SIGMA_PX: f64 = 0.01;
/// The deviation of a depth about which nothing is known, at one metre: it grows with the square of the distance, as
/// that of cameras which triangulate. The solver measures the scale.
const SIGMA_AT_ONE_METRE_M: f64 = 0.001;
/// Samples that are summed in one go by one thread.
const CHUNK: usize = 4096;

/// A sample as the solver uses it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Observation {
    /// The projector pixel.
    pub(super) pixel: Point2<f64>,
    /// The point in the camera's optical frame, metres.
    pub(super) point: Point3<f64>,
    /// The camera's ray through the point, with z = 1: how the point moves with its depth.
    pub(super) ray: Vector3<f64>,
    /// Deviation of the pixel, of which the scale is not known.
    pub(super) sigma_px: f64,
    /// Deviation of the depth, of which the scale is not known.
    pub(super) sigma_m: f64,
    /// The index of the scan among all scans.
    pub(super) scan: usize,
    /// The index of the sample.
    pub(super) sample: usize,
}

/// Samples, sorted by scan.
#[derive(Debug, Clone)]
pub(super) struct Observations {
    /// All of them.
    pub(super) all: Vec<Observation>,
    /// The numbers of the scans, rising.
    pub(super) scans: Vec<u32>,
}

impl Observations {
    /// Checks samples and sorts them.
    pub(super) fn new(samples: &[Sample], size_px: [u32; 2]) -> Result<Self, Refusal> {
        for (sample, Sample { pixel, point, sigma_px, sigma_m, .. }) in samples.iter().enumerate() {
            let coordinates = pixel.coords.iter().chain(point.coords.iter()).chain([sigma_px, sigma_m]);
            if coordinates.into_iter().any(|coordinate| !coordinate.is_finite()) {
                return Err(Refusal::NotFinite { sample });
            }
            if *sigma_px < 0.0 || *sigma_m < 0.0 {
                return Err(Refusal::NegativeDeviation { sample });
            }
            if point.z <= 0.0 {
                return Err(Refusal::BehindCamera { sample });
            }
        }
        check_size(samples, size_px)?;
        let typical_m = quantile(&mut samples.iter().map(|sample| sample.point.z).collect::<Vec<_>>(), 0.5);
        if typical_m > FARTHEST_M {
            return Err(Refusal::NotMetres { typical_m });
        }
        let mut scans: Vec<u32> = samples.iter().map(|sample| sample.scan).collect();
        scans.sort_unstable();
        scans.dedup();
        let mut all: Vec<Observation> = samples
            .iter()
            .enumerate()
            .map(|(index, sample)| Observation {
                pixel: sample.pixel,
                point: sample.point,
                ray: sample.point.coords / sample.point.z,
                sigma_px: sample.sigma_px.max(LEAST_SIGMA_PX),
                sigma_m: if sample.sigma_m > 0.0 {
                    sample.sigma_m
                } else {
                    SIGMA_AT_ONE_METRE_M * sample.point.z * sample.point.z
                },
                scan: scans.partition_point(|scan| *scan < sample.scan),
                sample: index,
            })
            .collect();
        all.sort_by_key(|observation| observation.scan);
        Ok(Self { all, scans })
    }

    /// Refuses scans that have too few samples.
    pub(super) fn check_count(&self, lens_is_known: bool) -> Result<(), Refusal> {
        if self.scans.is_empty() {
            let needed = if lens_is_known { NEEDED_FOR_POSE } else { NEEDED_FOR_LENS };
            return Err(Refusal::TooFew { points: 0, needed, scan: 0 });
        }
        let largest = (0..self.scans.len()).max_by_key(|scan| self.range(*scan).len());
        for (scan, number) in self.scans.iter().enumerate() {
            // The lens comes from all scans, so one of them has to be large.
            let needed = if lens_is_known || largest != Some(scan) { NEEDED_FOR_POSE } else { NEEDED_FOR_LENS };
            let points = self.range(scan).len();
            if points < needed {
                return Err(Refusal::TooFew { points, needed, scan: *number });
            }
        }
        Ok(())
    }

    /// Where the samples of a scan are.
    pub(super) fn range(&self, scan: usize) -> Range<usize> {
        let from = self.all.partition_point(|observation| observation.scan < scan);
        let to = self.all.partition_point(|observation| observation.scan <= scan);
        from..to
    }

    /// Pieces of the samples, none of more than one scan, that are each summed by one thread.
    pub(super) fn chunks(&self) -> Vec<Range<usize>> {
        let mut chunks = Vec::new();
        for scan in 0..self.scans.len() {
            let range = self.range(scan);
            chunks.extend(range.clone().step_by(CHUNK).map(|from| from..(from + CHUNK).min(range.end)));
        }
        chunks
    }

    /// At most `most` samples of each scan, drawn evenly from their order, which mostly is that of the camera's pixels.
    pub(super) fn thinned(&self, most: usize, seed: u64) -> Self {
        let mut random = SplitMix64::new(seed, 0x7417);
        let mut all = Vec::new();
        for scan in 0..self.scans.len() {
            let scan = &self.all[self.range(scan)];
            if scan.len() <= most {
                all.extend_from_slice(scan);
                continue;
            }
            let step = scan.len() as f64 / most as f64;
            all.extend((0..most).map(|i| scan[(((i as f64 + random.unit()) * step) as usize).min(scan.len() - 1)]));
        }
        Self { all, scans: self.scans.clone() }
    }

    /// One scan for itself.
    pub(super) fn only(&self, scan: usize) -> Self {
        let mut all = self.all[self.range(scan)].to_vec();
        for observation in &mut all {
            observation.scan = 0;
        }
        Self { all, scans: vec![self.scans[scan]] }
    }

    /// The same with pixels mirrored along an axis of the picture (0: u, 1: v).
    pub(super) fn mirrored(&self, size_px: [u32; 2], axis: usize) -> Self {
        let mut mirrored = self.clone();
        for observation in &mut mirrored.all {
            observation.pixel[axis] = f64::from(size_px[axis]) - 1.0 - observation.pixel[axis];
        }
        mirrored
    }
}

fn check_size(samples: &[Sample], size_px: [u32; 2]) -> Result<(), Refusal> {
    let is_outside = |sample: &&Sample| {
        (0..2).any(|axis| {
            let beside = (-0.5 - sample.pixel[axis]).max(sample.pixel[axis] + 0.5 - f64::from(size_px[axis]));
            beside > BESIDE_PX + BESIDE * sample.sigma_px
        })
    };
    let outside = samples.iter().filter(is_outside).count();
    match samples.iter().find(is_outside) {
        Some(example) if outside as f64 > OUTSIDE * samples.len() as f64 => {
            Err(Refusal::OtherSize { outside, points: samples.len(), size_px, example: example.pixel.into() })
        }
        _ => Ok(()),
    }
}

/// Refuses options that contradict themselves or are no numbers.
pub(super) fn check_options(options: &SolveOptions) -> Result<(), Refusal> {
    let is_focal = |parameter: Parameter| matches!(parameter, Parameter::Fx | Parameter::Fy);
    for (i, (parameter, value)) in options.fixed.iter().enumerate() {
        if !value.is_finite() {
            return Err(Refusal::FixedNotFinite(*parameter));
        }
        if is_focal(*parameter) && *value <= 0.0 {
            return Err(Refusal::NegativeFocal(*value, *parameter));
        }
        for (earlier, other) in &options.fixed[..i] {
            let has_to_be_equal = earlier == parameter
                || (options.focal == FocalLengths::One && is_focal(*parameter) && is_focal(*earlier));
            if has_to_be_equal && other != value {
                return Err(Refusal::Contradiction(*earlier, *parameter));
            }
        }
    }
    for lens in options.initial.iter().chain(&options.known_lens) {
        check_lens(lens, options.size_px)?;
    }
    Ok(())
}

fn check_lens(lens: &Lens, size_px: [u32; 2]) -> Result<(), Refusal> {
    if lens.size_px != size_px {
        return Err(Refusal::OtherLens { lens_px: lens.size_px, size_px });
    }
    if lens.skew_px.iter().any(|skew| *skew != 0.0) {
        return Err(Refusal::Skewed { skew_px: lens.skew_px.into() });
    }
    let values = [lens.focal_px.x, lens.focal_px.y, lens.center_px.x, lens.center_px.y];
    for (value, parameter) in values.into_iter().zip(Parameter::ALL) {
        if !value.is_finite() {
            return Err(Refusal::FixedNotFinite(parameter));
        }
        if value <= 0.0 && matches!(parameter, Parameter::Fx | Parameter::Fy) {
            return Err(Refusal::NegativeFocal(value, parameter));
        }
    }
    Ok(())
}
