//! Drops pixels that see two surfaces or mostly stray light.

use rayon::prelude::*;

use super::axis::WORST_SIGMA_PX;
use super::bleeding::SURFACE_STEP_PX;
use super::DecodedPixel;

/// Minimum number of the eight neighbours that are decoded and on the pixel's surface.
const LEAST_NEIGHBOURS: usize = 6;
/// Standard deviation of the camera's blur, including its pixels' extent, camera pixels.
const CAMERA_BLUR_PX: f32 = 0.8;
/// Minimum light as a share of the brightest pixel near; darker ones mostly see its stray light.
const STRAY_LIGHT: f32 = 0.15;
/// Reach of stray light, camera pixels.
const STRAY_REACH: usize = 8;

/// Drops pixels at the margins of surfaces, which see two surfaces, or light and shadow.
pub(super) fn without_margins(pixels: &[DecodedPixel], width: usize) -> Vec<DecodedPixel> {
    let height = pixels.len() / width.max(1);
    let is_kept = |x: usize, y: usize| {
        let pixel = pixels[y * width + x];
        if x == 0 || y == 0 || x + 1 >= width || y + 1 >= height {
            return false;
        }
        let is_of_surface = |other: &DecodedPixel| {
            let far = [0, 1].map(|axis| (other.at[axis] - pixel.at[axis]).abs() < SURFACE_STEP_PX);
            far[0] && far[1]
        };
        let around = (y - 1..=y + 1).flat_map(|row| &pixels[row * width + x - 1..row * width + x + 2]);
        // The pixel itself counts, too.
        around.filter(|other| is_of_surface(other)).count() > LEAST_NEIGHBOURS
    };
    let mut kept = pixels.to_vec();
    kept.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        for (x, pixel) in row.iter_mut().enumerate() {
            if !is_kept(x, y) {
                *pixel = DecodedPixel::NONE;
            }
        }
    });
    kept
}

/// Adds the pull of the camera's blur towards brighter neighbours, the blur's variance times the relative gradient, to
/// the deviations. Drops uncertain pixels, and dark ones that mostly see stray light.
pub(super) fn without_bleeding(pixels: &[DecodedPixel], amplitudes: &[f32], width: usize) -> Vec<DecodedPixel> {
    let brightest = brightest_around(amplitudes, width);
    let mut kept = pixels.to_vec();
    kept.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        for (x, pixel) in row.iter_mut().enumerate().filter(|(_, pixel)| pixel.is_decoded()) {
            if amplitudes[y * width + x] < STRAY_LIGHT * brightest[y * width + x] {
                *pixel = DecodedPixel::NONE;
                continue;
            }
            // Decoded pixels are not at the image's edge.
            let index = y * width + x;
            let sides = [[index - 1, index + 1], [index - width, index + width]];
            for axis in 0..2 {
                let pulled = sides.iter().map(|[before, after]| {
                    let gradient = (amplitudes[*after] - amplitudes[*before]) / (2.0 * amplitudes[index]);
                    let (here, before, after) = (pixels[index].at, pixels[*before].at, pixels[*after].at);
                    let step = match (before[axis].is_nan(), after[axis].is_nan()) {
                        (false, false) => (after[axis] - before[axis]) / 2.0,
                        (true, false) => after[axis] - here[axis],
                        (false, true) => here[axis] - before[axis],
                        (true, true) => 0.0,
                    };
                    CAMERA_BLUR_PX.powi(2) * gradient * step
                });
                let pulled: f32 = pulled.sum();
                pixel.sigma[axis] = pixel.sigma[axis].hypot(pulled);
            }
            if pixel.sigma.iter().any(|sigma| *sigma > WORST_SIGMA_PX) {
                *pixel = DecodedPixel::NONE;
            }
        }
    });
    kept
}

/// Maximum amplitude within [`STRAY_REACH`] of each pixel, along rows and columns.
fn brightest_around(amplitudes: &[f32], width: usize) -> Vec<f32> {
    let mut along_rows = vec![0.0; amplitudes.len()];
    along_rows.par_chunks_mut(width).zip(amplitudes.par_chunks(width)).for_each(|(brightest, row)| {
        for (x, brightest) in brightest.iter_mut().enumerate() {
            let near = &row[x.saturating_sub(STRAY_REACH)..(x + STRAY_REACH + 1).min(width)];
            *brightest = near.iter().copied().fold(0.0, f32::max);
        }
    });
    let height = amplitudes.len() / width.max(1);
    let mut brightest = vec![0.0_f32; amplitudes.len()];
    brightest.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        for near in y.saturating_sub(STRAY_REACH)..(y + STRAY_REACH + 1).min(height) {
            let other = &along_rows[near * width..][..width];
            row.iter_mut().zip(other).for_each(|(brightest, other)| *brightest = brightest.max(*other));
        }
    });
    brightest
}
