//! Checked samples, sorted by scan.

use std::ops::Range;

use nalgebra::{Point2, Point3, Vector3};

use super::random::SplitMix64;
use super::{FocalLengths, Parameter, Refusal, SolveOptions};
use crate::statistics::median;
use crate::{Lens, Sample};

/// Minimum samples for a pose (three determine it, one disambiguates, two verify).
const NEEDED_FOR_POSE: usize = 6;
/// Minimum samples of a scan for a lens: twice as many as determine it.
const NEEDED_FOR_LENS: usize = 12;
/// Tolerance for pixels outside of the image: pixels, and deviations of the pixel.
const BESIDE_PX: f64 = 0.5;
const BESIDE: f64 = 2.0;
/// Maximum share of samples farther outside, as gross errors.
const OUTSIDE: f64 = 0.002;
/// Maximum median depth of depth cameras: larger ones are not in metres.
const FARTHEST_M: f64 = 40.0;
/// Lower bound of pixel deviations.
const LEAST_SIGMA_PX: f64 = 0.01;
/// Default depth deviation at 1 m, growing with the squared distance, as that of triangulating cameras. The solver
/// estimates the scale.
const SIGMA_AT_ONE_METRE_M: f64 = 0.001;
/// Samples summed by one task.
const CHUNK: usize = 4096;

/// Checked sample.
#[derive(Debug, Clone, Copy)]
pub(super) struct Observation {
    pub(super) pixel: Point2<f64>,
    /// Point in the camera's optical frame, metres.
    pub(super) point: Point3<f64>,
    /// Camera ray through the point, with z = 1: derivative of the point by its depth.
    pub(super) ray: Vector3<f64>,
    /// Pixel deviation, up to scale.
    pub(super) sigma_px: f64,
    /// Depth deviation, up to scale.
    pub(super) sigma_m: f64,
    pub(super) scan: usize,
    pub(super) sample: usize,
}

/// Observations, sorted by scan.
#[derive(Debug, Clone)]
pub(super) struct Observations {
    pub(super) all: Vec<Observation>,
    /// Rising scan numbers.
    pub(super) scans: Vec<u32>,
}

impl Observations {
    /// Checks samples and sorts them.
    pub(super) fn new(samples: &[Sample], size_px: [u32; 2]) -> Result<Self, Refusal> {
        for (sample, Sample { pixel, point, sigma_px, sigma_m, .. }) in samples.iter().enumerate() {
            let coordinates = pixel.coords.iter().chain(point.coords.iter()).chain([sigma_px, sigma_m]);
            if coordinates.into_iter().any(|coordinate| !coordinate.is_finite()) {
                return Err(Refusal::NotFinite(sample));
            }
            if *sigma_px < 0.0 || *sigma_m < 0.0 {
                return Err(Refusal::NegativeDeviation(sample));
            }
            if point.z <= 0.0 {
                return Err(Refusal::BehindCamera(sample));
            }
        }
        check_size(samples, size_px)?;
        let typical_m = median(&mut samples.iter().map(|sample| sample.point.z).collect::<Vec<_>>());
        if typical_m > FARTHEST_M {
            return Err(Refusal::NotMetres(typical_m));
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

    /// Refuses scans with too few samples.
    pub(super) fn check_count(&self, lens_is_known: bool) -> Result<(), Refusal> {
        if self.scans.is_empty() {
            let needed = if lens_is_known { NEEDED_FOR_POSE } else { NEEDED_FOR_LENS };
            return Err(Refusal::TooFew { points: 0, needed, scan: 0 });
        }
        let largest = (0..self.scans.len()).max_by_key(|scan| self.range(*scan).len());
        for (scan, number) in self.scans.iter().enumerate() {
            // The lens comes from all scans, so one large scan suffices.
            let needed = if lens_is_known || largest != Some(scan) { NEEDED_FOR_POSE } else { NEEDED_FOR_LENS };
            let points = self.range(scan).len();
            if points < needed {
                return Err(Refusal::TooFew { points, needed, scan: *number });
            }
        }
        Ok(())
    }

    /// Depths of a scan's points from the camera, metres.
    pub(super) fn depths(&self, scan: usize) -> Vec<f64> {
        self.all[self.range(scan)].iter().map(|observation| observation.point.z).collect()
    }

    pub(super) fn range(&self, scan: usize) -> Range<usize> {
        let from = self.all.partition_point(|observation| observation.scan < scan);
        let to = self.all.partition_point(|observation| observation.scan <= scan);
        from..to
    }

    /// Index ranges within scans, each summed by one task.
    pub(super) fn chunks(&self) -> Vec<Range<usize>> {
        let mut chunks = Vec::new();
        for scan in 0..self.scans.len() {
            let range = self.range(scan);
            chunks.extend(range.clone().step_by(CHUNK).map(|from| from..(from + CHUNK).min(range.end)));
        }
        chunks
    }

    /// Draws at most `most` observations of each scan, evenly in their order, which mostly is that of the camera's
    /// pixels.
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

    pub(super) fn only(&self, scan: usize) -> Self {
        let mut all = self.all[self.range(scan)].to_vec();
        for observation in &mut all {
            observation.scan = 0;
        }
        Self { all, scans: vec![self.scans[scan]] }
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

/// Refuses options that contradict each other or are not finite.
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
