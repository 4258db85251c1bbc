//! Simulated scenes with known lens, pose and errors: a depth camera of 640×480 pixels sees objects before a wall.

use nalgebra::{Isometry3, Point2, Point3, Vector2, Vector3};

use crate::solve::random::SplitMix64;
use crate::{Distortion, Lens, Sample};

/// Focal length of the depth camera, pixels.
const CAMERA_FOCAL_PX: f64 = 525.0;

/// Simulation of scans.
#[derive(Debug, Clone)]
pub(crate) struct Simulation {
    pub(crate) lens: Lens,
    /// Camera poses, one for each scan.
    pub(crate) projector_from_camera: Vec<Isometry3<f64>>,
    /// Distance of samples, camera pixels.
    pub(crate) step_px: usize,
    pub(crate) noise_px: f64,
    /// Independent depth errors at 1 m, growing with the squared distance.
    pub(crate) depth_noise_m: f64,
    /// Smooth depth errors at 1 m, growing with the squared distance.
    pub(crate) smooth_depth_m: f64,
    /// Reach of smooth errors, camera pixels.
    pub(crate) smooth_px: f64,
    /// Share of samples with random pixels.
    pub(crate) gross: f64,
    pub(crate) is_flat: bool,
    pub(crate) seed: u64,
}

impl Simulation {
    pub(crate) fn new(seed: u64) -> Self {
        Self {
            lens: pinhole(),
            projector_from_camera: vec![pose(seed)],
            step_px: 6,
            noise_px: 0.2,
            depth_noise_m: 0.001,
            smooth_depth_m: 0.0,
            smooth_px: 50.0,
            gross: 0.0,
            is_flat: false,
            seed,
        }
    }

    pub(crate) fn with_distortion(mut self, coefficients: [f64; 5]) -> Self {
        self.lens.distortion = Distortion::plumb_bob(coefficients);
        self
    }

    pub(crate) fn samples(&self) -> Vec<Sample> {
        let mut samples = Vec::new();
        for scan in 0..self.projector_from_camera.len() {
            self.add_scan(scan, &mut samples);
        }
        samples
    }

    fn add_scan(&self, scan: usize, samples: &mut Vec<Sample>) {
        let mut random = SplitMix64::new(self.seed, 100 + scan as u64);
        let objects = Objects::new(&mut random, self.is_flat);
        let smooth = SmoothField::new(&mut random, self.smooth_px);
        let pose = self.projector_from_camera[scan];
        for v in (0..480).step_by(self.step_px) {
            for u in (0..640).step_by(self.step_px) {
                let ray = Vector3::new((u as f64 - 319.5) / CAMERA_FOCAL_PX, (v as f64 - 239.5) / CAMERA_FOCAL_PX, 1.0);
                let depth = objects.depth(ray.xy());
                let true_point = Point3::from(ray * depth);
                let Some(pixel) = self.lens.project(&(pose * true_point)).filter(|pixel| self.lens.contains(*pixel))
                else {
                    continue;
                };
                let error = depth
                    * depth
                    * (self.depth_noise_m * normal(&mut random) + self.smooth_depth_m * smooth.at(u as f64, v as f64));
                let mut pixel = pixel + Vector2::new(normal(&mut random), normal(&mut random)) * self.noise_px;
                if random.unit() < self.gross {
                    pixel = Point2::new(1280.0 * random.unit() - 0.5, 800.0 * random.unit() - 0.5);
                }
                samples.push(Sample {
                    scan: scan as u32,
                    sigma_px: 0.3,
                    sigma_m: 0.001 * depth * depth,
                    ..Sample::new(pixel, Point3::from(ray * (depth + error)))
                });
            }
        }
    }

    /// RMS projection error over the image and depths from 0.6 to 2 m, pixels.
    pub(crate) fn projection_error_px(&self, lens: &Lens, projector_from_camera: &Isometry3<f64>) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for place in 0..99 {
            let pixel =
                Point2::new(1280.0 * f64::from(place % 11) / 10.0 - 0.5, 800.0 * f64::from(place / 11) / 8.0 - 0.5);
            let ray = self.lens.ray(pixel).unwrap();
            for depth in [0.6, 1.0, 1.5, 2.0] {
                let point = self.projector_from_camera[0].inverse() * Point3::from(ray * depth);
                sum += (lens.project(&(projector_from_camera * point)).unwrap() - pixel).norm_squared();
                count += 1.0;
            }
        }
        (sum / count).sqrt()
    }
}

/// Projector that throws upwards: its principal point is below the image.
pub(crate) fn pinhole() -> Lens {
    Lens::pinhole([1280, 800], [1410.0, 1400.0], [645.0, 817.0])
}

/// Random camera pose beside the projector.
pub(crate) fn pose(seed: u64) -> Isometry3<f64> {
    let mut random = SplitMix64::new(seed, 7);
    let mut around = |value: f64, by: f64| value + by * (2.0 * random.unit() - 1.0);
    let camera_in_projector = Vector3::new(around(0.25, 0.1), around(-0.1, 0.1), around(0.0, 0.05));
    // The image lies above the axis, so the camera looks up a little less than the light goes.
    let turn = Vector3::new(around(0.26, 0.04), around(-0.12, 0.05), around(0.0, 0.03));
    Isometry3::new(camera_in_projector, turn)
}

/// Standard normal deviate (Box and Muller).
pub(crate) fn normal(random: &mut SplitMix64) -> f64 {
    let (radius, angle) = ((1.0 - random.unit()).ln(), random.unit());
    (-2.0 * radius).sqrt() * (std::f64::consts::TAU * angle).cos()
}

/// Boxes before a wall, by their depths in the camera's image.
struct Objects {
    wall: Vector3<f64>,
    boxes: Vec<(Vector2<f64>, Vector2<f64>, f64, f64)>,
}

impl Objects {
    fn new(random: &mut SplitMix64, is_flat: bool) -> Self {
        let mut around = |value: f64, by: f64| value + by * (2.0 * random.unit() - 1.0);
        let wall = Vector3::new(around(0.1, 0.15), around(0.0, 0.15), around(1.75, 0.15));
        let count = if is_flat { 0 } else { 14 };
        let boxes = (0..count)
            .map(|_| {
                let center = Vector2::new(around(0.0, 0.55), around(0.0, 0.4));
                let half = Vector2::new(around(0.11, 0.05), around(0.1, 0.05));
                (center, half, around(1.1, 0.45), around(0.0, 0.6))
            })
            .collect();
        Self { wall, boxes }
    }

    fn depth(&self, ray: Vector2<f64>) -> f64 {
        let mut depth = self.wall.z / (1.0 + self.wall.x * ray.x + self.wall.y * ray.y);
        for (center, half, near, tilt) in &self.boxes {
            let place = (ray - center).component_div(half);
            if place.x.abs() < 1.0 && place.y.abs() < 1.0 {
                depth = depth.min(near + tilt * half.x * place.x + 0.05 * place.y * place.y);
            }
        }
        depth
    }
}

/// Random field of variance 1 with Gaussian correlation: random waves.
struct SmoothField(Vec<(Vector2<f64>, f64)>);

impl SmoothField {
    fn new(random: &mut SplitMix64, reach_px: f64) -> Self {
        let wave = |_| (Vector2::new(normal(random), normal(random)) / reach_px, random.unit() * std::f64::consts::TAU);
        Self((0..60).map(wave).collect())
    }

    fn at(&self, u: f64, v: f64) -> f64 {
        let sum: f64 = self.0.iter().map(|(wave, phase)| (wave.x * u + wave.y * v + phase).cos()).sum();
        sum * (2.0 / self.0.len() as f64).sqrt()
    }
}
