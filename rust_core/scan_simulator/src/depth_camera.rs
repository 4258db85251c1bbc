//! Depth image of a camera like the first Kinect, registered to the colour image.
//!
//! It measures disparities between an infrared projector and its camera, 7.5 cm apart, in eighths of a pixel; so noise
//! and quantisation grow with the squared depth (Khoshelham, Elberink: "Accuracy and resolution of Kinect depth data",
//! 2012). At edges depths come from nearby pixels or are missing, as in the shadow of the infrared light. Errors of the
//! registration at edges are not modelled.

use std::f64::consts::TAU;

use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

use crate::{Random, View};

/// Baseline of the infrared projector, metres, along x.
const BASELINE_M: f64 = 0.075;
/// Range of depths, metres.
const RANGE_M: std::ops::Range<f64> = 0.5..6.5;
/// Minimum cosine of the angle of incidence.
const GRAZING: f64 = 0.17;
/// Maximum relative depth difference of neighbours on one surface.
const EDGE: f64 = 0.03;
/// Number of waves of a smooth error.
const WAVES: usize = 6;

/// Depth camera with its errors.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthCamera {
    /// Focal length of the infrared camera times the baseline, pixels times metres.
    pub disparity_px_m: f64,
    /// Disparity step, pixels; 0 for none.
    pub step_px: f64,
    /// Noise: standard deviation at 1 m, metres; it grows with the square of depth.
    pub noise_m: f64,
    /// Lateral error at edges: standard deviation, pixels.
    pub lateral_px: f64,
    /// Probability that a pixel next to an edge has no depth.
    pub missing_at_edges: f64,
    /// Number of averaged depth images.
    pub frames: u32,
    /// Error that is equal in all frames.
    pub smooth_error: Option<SmoothError>,
    /// Seed of the noise.
    pub seed: u64,
}

/// Depth error that changes slowly over the image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SmoothError {
    /// Root mean square at 1 m, metres; it grows with the square of depth.
    pub rms_m: f64,
    /// Seed of the error: a camera keeps its own.
    pub seed: u64,
}

impl DepthCamera {
    /// Kinect's camera.
    pub fn kinect(seed: u64) -> Self {
        Self {
            disparity_px_m: 575.0 * BASELINE_M,
            step_px: 0.125,
            noise_m: 0.0014,
            lateral_px: 0.8,
            missing_at_edges: 0.7,
            frames: 1,
            smooth_error: None,
            seed,
        }
    }

    /// Camera without errors but rounding to 0.1 mm.
    pub fn ideal() -> Self {
        Self { step_px: 0.0, noise_m: 0.0, lateral_px: 0.0, missing_at_edges: 0.0, ..Self::kinect(0) }
    }

    /// Depth image of a view, row by row: metres along the optical axis, rounded to 0.1 mm, 0 where missing in more
    /// than half of the frames.
    pub fn capture(&self, view: &View) -> Vec<f32> {
        self.average(&self.reachable(view), view.size_px(), 0)
    }

    /// Depth images one after another, each like [`Self::capture`] with noise of its own, from a number on.
    pub fn stream(&self, view: &View, first: u32, count: u32) -> Vec<Vec<f32>> {
        let reach = self.reachable(view);
        (first..first + count).map(|image| self.average(&reach, view.size_px(), image * self.frames.max(1))).collect()
    }

    /// Mean of the frames from a number on.
    fn average(&self, reach: &[Option<Reached>], size_px: [u32; 2], first: u32) -> Vec<f32> {
        let [width, height] = size_px.map(|size| size as usize);
        let smooth = self.smooth_error.map(|error| error.waves());
        let mut sums = vec![(0.0_f64, 0_u32); width * height];
        for frame in first..first + self.frames.max(1) {
            let noise = self.noise(frame, width, height);
            sums.par_chunks_mut(width).enumerate().for_each(|(v, sums)| {
                let mut random = Random::new(&[self.seed, u64::from(frame), v as u64, 0x4a49_5454]);
                for (u, sum) in sums.iter_mut().enumerate() {
                    let beside =
                        |at: usize, last: usize, by: f64| (at as f64 + by).round().clamp(0.0, last as f64) as usize;
                    let (du, dv) = (self.lateral_px * random.normal(), self.lateral_px * random.normal());
                    let is_missing = random.happens(self.missing_at_edges);
                    let source = beside(v, height - 1, dv) * width + beside(u, width - 1, du);
                    let (own, other) = (reach[v * width + u], reach[source]);
                    // The lateral error matters at edges only.
                    let Some(reached) = (if own.is_some_and(|own| !own.is_edge) { own } else { other }) else {
                        continue;
                    };
                    if reached.is_edge && is_missing {
                        continue;
                    }
                    let z = reached.depth_m;
                    let mut error_m = noise[v * width + u] * self.noise_m;
                    if let Some(waves) = &smooth {
                        error_m += waves.at(u as f64 / width as f64, v as f64 / width as f64);
                    }
                    sum.0 += self.quantised(z + error_m * z * z);
                    sum.1 += 1;
                }
            });
        }
        let half = self.frames.div_ceil(2).max(1);
        let encoded = |(sum, count): &(f64, u32)| {
            if *count < half {
                return 0.0;
            }
            (sum / f64::from(*count) * 1e4).round().clamp(0.0, f64::from(u16::MAX)) as f32 * 1e-4
        };
        sums.iter().map(encoded).collect()
    }

    /// Depth of the nearest disparity step.
    fn quantised(&self, depth_m: f64) -> f64 {
        if self.step_px <= 0.0 || depth_m <= 0.0 {
            return depth_m;
        }
        let steps = (self.disparity_px_m / (depth_m * self.step_px)).round().max(1.0);
        self.disparity_px_m / (steps * self.step_px)
    }

    /// Depths of the pixels that the infrared light reaches.
    fn reachable(&self, view: &View) -> Vec<Option<Reached>> {
        let width = view.size_px()[0] as usize;
        let sights = view.sights();
        let room_from_camera = view.rig().room_from_camera;
        let infrared = room_from_camera * Point3::new(-BASELINE_M, 0.0, 0.0);
        let is_ideal = self.lateral_px == 0.0 && self.missing_at_edges == 0.0;
        let reached = |index: usize| {
            let sight = sights[index]?;
            let depth_m = sight.point.z;
            if is_ideal {
                return Some(Reached { depth_m, is_edge: false });
            }
            let ray: Vector3<f64> = sight.point.coords.normalize();
            let is_seen = RANGE_M.contains(&depth_m) && -sight.normal.dot(&ray) > GRAZING && !sight.is_infrared_black;
            if !is_seen || view.room().is_blocked(&infrared, &(room_from_camera * sight.point)) {
                return None;
            }
            let (u, v) = (index % width, index / width);
            let near = [(u > 1, -2), (u + 2 < width, 2), (v > 1, -2 * width as isize), (v > 0, -(width as isize))];
            let more = [(u > 0, -1), (u + 1 < width, 1), (true, width as isize), (true, 2 * width as isize)];
            let is_edge = near.into_iter().chain(more).filter(|(is_inside, _)| *is_inside).any(|(_, step)| {
                let neighbour = index.checked_add_signed(step).and_then(|index| sights.get(index)).copied().flatten();
                neighbour.is_some_and(|neighbour| (neighbour.point.z / depth_m - 1.0).abs() > EDGE)
            });
            Some(Reached { depth_m, is_edge })
        };
        (0..sights.len()).into_par_iter().map(reached).collect()
    }

    /// Normal deviates that are correlated between neighbouring pixels, as correlation windows overlap.
    fn noise(&self, frame: u32, width: usize, height: usize) -> Vec<f64> {
        if self.noise_m == 0.0 {
            return vec![0.0; width * height];
        }
        let row = |v: usize| {
            let mut random = Random::new(&[self.seed, u64::from(frame), v as u64, 0x4445_5054]);
            (0..width + 2).map(move |_| random.normal())
        };
        let rows: Vec<Vec<f64>> = (0..height + 2).into_par_iter().map(|v| row(v).collect()).collect();
        let mut noise = vec![0.0; width * height];
        noise.par_chunks_mut(width).enumerate().for_each(|(v, noise)| {
            for (u, value) in noise.iter_mut().enumerate() {
                let sum: f64 = rows[v..v + 3].iter().flat_map(|row| &row[u..u + 3]).sum();
                *value = sum / 3.0;
            }
        });
        noise
    }
}

/// Pixel that the infrared light reaches.
#[derive(Debug, Clone, Copy)]
struct Reached {
    depth_m: f64,
    /// `true` if a surface of another depth is within two pixels.
    is_edge: bool,
}

/// Sum of slow waves.
struct Waves {
    /// Waves in u and v, per image width, and a phase, radians.
    waves: [(f64, f64, f64); WAVES],
    amplitude_m: f64,
}

impl SmoothError {
    fn waves(&self) -> Waves {
        let random = &mut Random::new(&[self.seed, 0x534d_4f4f]);
        let mut wave = || (random.uniform(-8.0, 8.0), random.uniform(-8.0, 8.0), random.uniform(0.0, TAU));
        Waves { waves: std::array::from_fn(|_| wave()), amplitude_m: self.rms_m * (2.0 / WAVES as f64).sqrt() }
    }
}

impl Waves {
    /// Error at 1 m, metres, at a place in image widths.
    fn at(&self, u: f64, v: f64) -> f64 {
        self.amplitude_m * self.waves.iter().map(|(by_u, by_v, phase)| (by_u * u + by_v * v + phase).sin()).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Rig, Room};

    fn wall(distance_m: f64) -> View {
        let mut rig = Rig::random(1);
        rig.room_from_camera = nalgebra::Isometry3::identity();
        View::new(&Room::wall(distance_m, [0.0, 0.0]), &rig)
    }

    fn deviation(view: &View, camera: &DepthCamera) -> (f64, f64) {
        let depths = camera.capture(view);
        let errors = depths
            .iter()
            .zip(view.sights())
            .filter(|(depth, _)| **depth > 0.0)
            .map(|(depth, sight)| f64::from(*depth) - sight.as_ref().map_or(f64::NAN, |sight| sight.point.z));
        let errors: Vec<f64> = errors.collect();
        assert!(errors.len() > 250_000, "{}", errors.len());
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let squares = errors.iter().map(|error| (error - mean).powi(2)).sum::<f64>();
        (mean, (squares / errors.len() as f64).sqrt())
    }

    #[test]
    fn noise_grows_with_the_square_of_depth() {
        for distance in [0.8, 1.3, 2.0] {
            let (mean, rms) = deviation(&wall(distance), &DepthCamera::kinect(1));
            let squared = distance * distance;
            // The step of depth, evenly distributed, adds to the noise.
            let step: f64 = 0.125 / (575.0 * 0.075) * squared;
            let expected = ((0.0014 * squared).powi(2) + step * step / 12.0).sqrt();
            assert!((rms / expected - 1.0).abs() < 0.15, "{distance} m: {rms} instead of {expected}");
            assert!(mean.abs() < 0.3 * expected, "{distance} m: {mean}");
        }
    }

    #[test]
    fn averaging_helps_against_noise_but_not_against_a_smooth_error() {
        let view = wall(1.0);
        let many = DepthCamera { frames: 16, ..DepthCamera::kinect(2) };
        assert!(deviation(&view, &many).1 < 0.45 * deviation(&view, &DepthCamera::kinect(2)).1);
        let smooth = DepthCamera { smooth_error: Some(SmoothError { rms_m: 0.004, seed: 3 }), ..many };
        let (mean, rms) = deviation(&view, &smooth);
        assert!((0.0015..0.007).contains(&rms.hypot(mean)), "{mean} {rms}");
        assert!(deviation(&view, &DepthCamera::ideal()).1 < 4e-5);
    }

    #[test]
    fn depths_are_missing_at_edges() {
        for seed in 0..3 {
            let view = View::new(&Room::cluttered(seed), &Rig::random(seed));
            let depths = DepthCamera::kinect(seed).capture(&view);
            assert!(depths == DepthCamera::kinect(seed).capture(&view));
            let missing = depths.iter().filter(|depth| **depth == 0.0).count() as f64 / depths.len() as f64;
            assert!((0.01..0.35).contains(&missing), "seed {seed}: {missing}");
        }
    }
}
