//! Samples from decoded pixels and a depth image.
//!
//! Depth is smoothed by planes fitted to windows of inverse depth: on a plane in space, inverse depth is linear in the
//! camera's pixels, and a depth camera's noise, which grows with the squared depth, is uniform in it (Khoshelham,
//! Elberink, "Accuracy and resolution of Kinect depth data", 2012). Windows without a common plane contain a depth edge
//! and are dropped. The planes' bias on curved surfaces is corrected.

use nalgebra::{Point2, Point3};
use rayon::prelude::*;

use crate::plane::{means_around, robust_weight, PlaneSums};
use crate::statistics::median_f32;
use crate::{Decoded, Lens, Sample};

/// Half the width of a window, pixels.
const RADIUS: usize = 3;
const SIDE: usize = 2 * RADIUS + 1;
/// Half the width of the windows that the planes' bias is averaged over.
const BIAS_RADIUS: usize = 4;
/// Minimum share of inliers of a window's plane.
const LEAST_SHARE: f32 = 0.75;
/// Residual at which a depth's weight is halved, in multiples of the window's noise, which is at least this share of
/// the depth.
const HALF_WEIGHT_NOISE: f32 = 2.0;
const LEAST_NOISE_SHARE: f32 = 0.0005;
/// Maximum noise of a window without an edge: as a share of the depth, and as a multiple of the median noise.
const MOST_NOISE_SHARE: f32 = 0.01;
const MOST_NOISE: f32 = 3.0;
/// Number of correlated neighbouring depths that count as one measurement.
const CORRELATED: f32 = 4.0;

/// Mismatch between decoded pixels, depth image and camera info.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DepthImageError {
    /// Pixels of the depth image and of the camera images.
    #[error("the depth image has {0} pixels, the pictures have {1}")]
    Size(usize, usize),
    /// Sizes in the camera info and of the camera images.
    #[error("the camera info is for {}x{} pixels, the pictures have {}x{}", .0[0], .0[1], .1[0], .1[1])]
    Camera([u32; 2], [u32; 2]),
}

/// Samples for the decoded pixels that have a depth.
///
/// `depth_m` are depths along the camera's optical axis, registered to the camera images, row by row; values that are
/// not finite or not positive are missing. The samples are of scan 0, in pixel order.
///
/// # Errors
/// [`DepthImageError`]: sizes differ.
pub fn points(decoded: &Decoded, depth_m: &[f32], camera: &Lens) -> Result<Vec<Sample>, DepthImageError> {
    if depth_m.len() != decoded.pixels.len() {
        return Err(DepthImageError::Size(depth_m.len(), decoded.pixels.len()));
    }
    if camera.size_px != decoded.size_px {
        return Err(DepthImageError::Camera(camera.size_px, decoded.size_px));
    }
    let width = decoded.size_px[0] as usize;
    let inverse = inverse_depths(depth_m);
    let windows: Vec<Vec<(usize, DepthWindow)>> = (0..decoded.size_px[1] as usize)
        .into_par_iter()
        .map(|y| {
            let decoded = (0..width).filter(|x| decoded.pixels[y * width + x].is_decoded());
            decoded.filter_map(|x| Some((y * width + x, DepthWindow::new(&inverse, width, x, y)?))).collect()
        })
        .collect();
    let windows = windows.concat();
    let mut noises: Vec<f32> = windows.iter().map(|(_, window)| window.noise).collect();
    let typical_noise = median_f32(&mut noises);
    let mut residuals = vec![f32::NAN; inverse.len()];
    for (index, window) in windows.iter().filter(|(_, window)| window.is_whole) {
        residuals[*index] = inverse[*index] - window.inverse;
    }
    let bias = means_around(&residuals, width, BIAS_RADIUS);
    let sample = |(index, window): &(usize, DepthWindow)| {
        if window.noise > MOST_NOISE * typical_noise {
            return None;
        }
        let pixel = &decoded.pixels[*index];
        let ray = camera.ray(Point2::new((index % width) as f64, (index / width) as f64))?;
        let depth = 1.0 / f64::from(window.inverse + bias[*index]);
        let variance = 0.5 * (pixel.sigma[0].powi(2) + pixel.sigma[1].powi(2));
        Some(Sample {
            pixel: Point2::from(pixel.at.map(f64::from)),
            point: Point3::from(ray * depth),
            scan: 0,
            sigma_px: f64::from(variance.sqrt()),
            // Depths that rounding makes equal are no more certain than others.
            sigma_m: window.sigma_m(typical_noise, depth),
        })
    };
    Ok(windows.iter().filter_map(sample).collect())
}

/// Inverse depths, 1/m; 0 where the depth is not finite or not positive.
pub(crate) fn inverse_depths(depth_m: &[f32]) -> Vec<f32> {
    depth_m.iter().map(|depth| if depth.is_finite() && *depth > 0.0 { 1.0 / depth } else { 0.0 }).collect()
}

/// Plane fit to the inverse depths around a pixel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DepthWindow {
    /// Inverse depth at the pixel, 1/m.
    pub(crate) inverse: f32,
    /// Gradient of the inverse depth per pixel, to the right and down.
    pub(crate) by_px: [f32; 2],
    /// Standard deviation of `inverse` as a share of `noise`.
    sigma_per_noise: f32,
    /// Standard deviation of single pixels' inverse depths, 1/m.
    noise: f32,
    /// `true` if all pixels of the window are inliers: no edge is near.
    is_whole: bool,
}

impl DepthWindow {
    /// Standard deviation of the depth, metres, for a pixel noise of at least `least_noise`, 1/m.
    pub(crate) fn sigma_m(&self, least_noise: f32, depth_m: f64) -> f64 {
        f64::from(self.noise.max(least_noise) * self.sigma_per_noise) * depth_m * depth_m
    }

    /// Fits the window around a pixel; `None` where depths are missing or an edge is near.
    pub(crate) fn new(inverse: &[f32], width: usize, x: usize, y: usize) -> Option<Self> {
        let height = inverse.len() / width;
        if x < RADIUS || y < RADIUS || x + RADIUS >= width || y + RADIUS >= height {
            return None;
        }
        let own = inverse[y * width + x];
        if own <= 0.0 {
            return None;
        }
        let mut window = [[0.0_f32; 3]; SIDE * SIDE];
        let mut count = 0;
        for row in y - RADIUS..=y + RADIUS {
            for column in x - RADIUS..=x + RADIUS {
                let value = inverse[row * width + column];
                if value > 0.0 {
                    window[count] = [column as f32 - x as f32, row as f32 - y as f32, value - own];
                    count += 1;
                }
            }
        }
        let least = LEAST_SHARE * (SIDE * SIDE) as f32;
        if (count as f32) < least {
            return None;
        }
        let window = &window[..count];
        let first = window.iter().map(|entry| (robust_weight(1.0, entry[2] / (0.03 * own)), *entry));
        let mut plane = first.collect::<PlaneSums>().plane(4.0)?;
        let mut noise = 0.0;
        for _ in 0..3 {
            let mut distances = [0.0; SIDE * SIDE];
            distances.iter_mut().zip(window).for_each(|(distance, entry)| *distance = plane.residual(entry).abs());
            noise = 1.4826 * median_f32(&mut distances[..count]) + LEAST_NOISE_SHARE * own;
            let weight = |entry: &[f32; 3]| robust_weight(1.0, plane.residual(entry) / (HALF_WEIGHT_NOISE * noise));
            plane = window.iter().map(|entry| (weight(entry), *entry)).collect::<PlaneSums>().plane(4.0)?;
        }
        let on_plane = window.iter().filter(|entry| plane.residual(entry).abs() < 4.0 * noise).count();
        let is_whole = on_plane == SIDE * SIDE;
        if (on_plane as f32) < least || plane.at.abs() > 4.0 * noise || noise > MOST_NOISE_SHARE * own {
            return None;
        }
        let sigma_per_noise = (CORRELATED / plane.support).sqrt();
        Some(Self { inverse: own + plane.at, by_px: [plane.by_x, plane.by_y], sigma_per_noise, noise, is_whole })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DecodedPixel, Quality};

    const SIZE: [u32; 2] = [40, 30];

    fn decoded() -> Decoded {
        let pixel = |index: u32| DecodedPixel { at: [(index % SIZE[0]) as f32 * 2.0, 5.0], sigma: [0.1; 2] };
        let pixels = (0..SIZE[0] * SIZE[1]).map(pixel).collect();
        Decoded { size_px: SIZE, pixels, lit: 1200, quality: Quality::default() }
    }

    fn camera() -> Lens {
        Lens::pinhole(SIZE, [35.0, 35.0], [19.5, 14.5])
    }

    /// The depth of a slanted plane at each pixel.
    fn slanted() -> Vec<f32> {
        let depth = |index: u32| {
            let ray = camera().ray(Point2::new(f64::from(index % SIZE[0]), f64::from(index / SIZE[0]))).unwrap();
            (1.5 / (1.0 + 0.3 * ray.x)) as f32
        };
        (0..SIZE[0] * SIZE[1]).map(depth).collect()
    }

    #[test]
    fn points_of_a_plane_stay_on_it() {
        let samples = points(&decoded(), &slanted(), &camera()).unwrap();
        assert_eq!(samples.len(), 34 * 24);
        for sample in samples {
            let off = sample.point.z + 0.3 * sample.point.x - 1.5;
            assert!(off.abs() < 1e-5 && sample.sigma_m < 5e-4, "{off} {}", sample.sigma_m);
            assert_eq!(sample.pixel.y, 5.0);
        }
    }

    #[test]
    fn points_of_a_ball_stay_on_it() {
        // Of 1 m, so that windows of such large pixels see no edges. Planes alone would put it 13 mm too far off.
        let center = nalgebra::Vector3::new(0.0, 0.0, 3.0);
        let depth = |index: u32| {
            let ray = camera().ray(Point2::new(f64::from(index % SIZE[0]), f64::from(index / SIZE[0]))).unwrap();
            let (along, square) = (ray.dot(&center), ray.norm_squared());
            ((along - (along * along - square * 8.0).max(0.0).sqrt()) / square) as f32
        };
        let depth: Vec<f32> = (0..SIZE[0] * SIZE[1]).map(depth).collect();
        let off: Vec<f64> = (points(&decoded(), &depth, &camera()).unwrap().iter())
            .filter(|sample| sample.point.x.hypot(sample.point.y) < 0.3)
            .map(|sample| (sample.point.coords - center).norm() - 1.0)
            .collect();
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        assert!(off.len() > 20 && mean.abs() < 2e-3, "{} {mean}", off.len());
    }

    #[test]
    fn depth_near_edges_is_not_used() {
        let mut depth = slanted();
        for (index, depth) in depth.iter_mut().enumerate() {
            if index % 40 >= 20 {
                *depth += 0.2;
            }
        }
        depth[15 * 40 + 8] = 0.0;
        depth[15 * 40 + 9] = f32::NAN;
        let samples = points(&decoded(), &depth, &camera()).unwrap();
        assert!(!samples.iter().any(|sample| (18.0..=21.0).contains(&(sample.pixel.x / 2.0))));
        for sample in samples {
            let seen = camera().project(&sample.point).unwrap();
            let expected = depth[(seen.y.round() * 40.0 + seen.x.round()) as usize];
            assert!((sample.point.z - f64::from(expected)).abs() < 2e-3);
        }
    }

    #[test]
    fn other_sizes_are_refused() {
        let error = points(&decoded(), &[1.0; 7], &camera()).unwrap_err();
        assert_eq!(error, DepthImageError::Size(7, 1200));
        let camera = Lens { size_px: [80, 60], ..camera() };
        assert!(points(&decoded(), &slanted(), &camera).unwrap_err().to_string().contains("80x60"));
    }
}
