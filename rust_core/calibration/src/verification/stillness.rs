//! Motion while spots are shown, by their centroids.
//!
//! Each spot is lit in half of the images and has to be at the same place in all of them. A motion between two images
//! shifts all spots, or those in a part of the image, by the same step. Medians over many spots tell a step that is far
//! smaller than the noise of a single centroid.

use nalgebra::{Point2, Vector2};

use super::spots::SpotLight;
use crate::statistics::median;

/// Maximum distance of a single spot's centroids from their mean, camera pixels.
const STEADY_PX: f64 = 0.5;
/// Maximum share of an image's spots beyond that.
const MOST_UNSTEADY: f64 = 0.25;
/// Minimum number of spots to tell a motion by.
const LEAST_SPOTS: usize = 6;
/// Maximum median step: camera pixels, and standard deviations of the median.
const MOST_STEP_PX: f64 = 0.08;
const MOST_STEP_SIGMAS: f64 = 6.0;
/// Standard deviation of a median over that of a mean, and of a normal variable over its median absolute deviation.
const MEDIAN_OVER_MEAN: f64 = 1.2533;
const SIGMA_OVER_MAD: f64 = 1.4826;

/// `true` if a spot's centroids agree.
pub(super) fn is_steady(light: &SpotLight) -> bool {
    offsets(light).all(|(_, offset)| offset.norm() <= STEADY_PX)
}

/// Distance by which all spots or a part of them move among a number of images, camera pixels; `None` if they rest.
pub(super) fn motion_px(lights: &[&SpotLight], images: usize) -> Option<f64> {
    (1..images).find_map(|after| step_px(lights, after)).or_else(|| (0..images).find_map(|at| unsteady_px(lights, at)))
}

/// Offsets of a spot's centroid in each of its images from their mean, camera pixels.
fn offsets(light: &SpotLight) -> impl Iterator<Item = (usize, Vector2<f64>)> + '_ {
    let mean = mean(light, |_| true).unwrap_or(light.at);
    light.in_images.iter().map(move |(image, at)| (*image, at - mean))
}

/// Mean of a spot's centroids in some images.
fn mean(light: &SpotLight, is_meant: impl Fn(usize) -> bool) -> Option<Point2<f64>> {
    let places = || light.in_images.iter().filter(|(image, _)| is_meant(*image)).map(|(_, at)| at.coords);
    let count = places().count();
    (count > 0).then(|| Point2::from(places().sum::<Vector2<f64>>() / count as f64))
}

/// Step between the images before one and those from it on, of all spots or of those in a half of the image.
fn step_px(lights: &[&SpotLight], after: usize) -> Option<f64> {
    let step = |light: &&SpotLight| {
        let step = mean(light, |image| image >= after)? - mean(light, |image| image < after)?;
        Some((light.at, step))
    };
    let steps: Vec<(Point2<f64>, Vector2<f64>)> = lights.iter().filter_map(step).collect();
    let all: Vec<Vector2<f64>> = steps.iter().map(|(_, step)| *step).collect();
    let halves = [0, 1].into_iter().filter(|_| !steps.is_empty()).flat_map(|axis| {
        let middle = median(&mut steps.iter().map(|(at, _)| at[axis]).collect::<Vec<_>>());
        [false, true].map(|is_far| {
            let half = steps.iter().filter(|(at, _)| (at[axis] > middle) == is_far);
            half.map(|(_, step)| *step).collect::<Vec<_>>()
        })
    });
    std::iter::once(all).chain(halves).find_map(|steps| significant(&steps))
}

/// Length of the median step if it is longer than noise makes it.
fn significant(steps: &[Vector2<f64>]) -> Option<f64> {
    if steps.len() < LEAST_SPOTS {
        return None;
    }
    let [x, y] = [0, 1].map(|axis| {
        let mut values: Vec<f64> = steps.iter().map(|step| step[axis]).collect();
        let middle = median(&mut values);
        let sigma = SIGMA_OVER_MAD * median(&mut values.iter().map(|value| (value - middle).abs()).collect::<Vec<_>>());
        [middle, MEDIAN_OVER_MEAN * sigma / (steps.len() as f64).sqrt()]
    });
    let (px, sigma_px) = (x[0].hypot(y[0]), x[1].hypot(y[1]));
    (px > MOST_STEP_PX.max(MOST_STEP_SIGMAS * sigma_px)).then_some(px)
}

/// Median offset of the unsteady spots of an image, if there are many.
fn unsteady_px(lights: &[&SpotLight], image: usize) -> Option<f64> {
    let of_image: Vec<f64> = (lights.iter().flat_map(|light| offsets(light)))
        .filter_map(|(at, offset)| (at == image).then_some(offset.norm()))
        .collect();
    let mut far: Vec<f64> = of_image.iter().copied().filter(|px| *px > STEADY_PX).collect();
    (far.len() >= LEAST_SPOTS && far.len() as f64 > MOST_UNSTEADY * of_image.len() as f64).then(|| median(&mut far))
}
