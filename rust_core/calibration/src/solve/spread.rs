//! Spatial spread of the samples: flatness of the scene, and covered area of the image.

use nalgebra::{Point2, Point3, Vector3};

use super::random::SplitMix64;
use crate::statistics::median;

/// Maximum distance of a plane's points, as a share of their depth: more than depth cameras' errors.
const THICKNESS: f64 = 0.012;
/// Minimum share of points off the largest plane of a scene that is not flat.
const OFF_PLANE: f64 = 0.04;
/// Number of tried planes.
const PLANES: usize = 200;
/// Points of a piece of the image, and minimum number of pieces.
const OF_PIECE: usize = 16;
const PIECES: usize = 40;
/// Maximum number of points for trying planes.
const TRIED: usize = 500;

/// Plane that most points lie on: the points p with `normal` · p = `offset`.
pub(crate) struct LargestPlane {
    pub(crate) normal: Vector3<f64>,
    /// Metres.
    pub(crate) offset: f64,
    /// Share of the points.
    pub(crate) share: f64,
}

impl LargestPlane {
    /// Finds the plane among at least four points.
    pub(crate) fn find(points: &[Point3<f64>], seed: u64) -> Option<Self> {
        let mut random = SplitMix64::new(seed, 0x91a7);
        let few: Vec<Point3<f64>> = if points.len() <= TRIED {
            points.to_vec()
        } else {
            (0..TRIED).map(|_| points[random.below(points.len())]).collect()
        };
        let mut best = None;
        for _ in 0..if few.len() < 4 { 0 } else { PLANES } {
            let [a, b, c] = random.distinct::<3>(few.len()).map(|i| few[i]);
            let Some(normal) = (b - a).cross(&(c - a)).try_normalize(1e-9) else { continue };
            let (normal, offset) = refined(&few, normal, normal.dot(&a.coords));
            let share = share_on(&few, &normal, offset);
            if best.as_ref().is_none_or(|best: &Self| share > best.share) {
                best = Some(Self { normal, offset, share });
            }
        }
        best
    }

    /// The plane fitted to all points near it.
    pub(crate) fn refined(self, points: &[Point3<f64>]) -> Self {
        let (normal, offset) = refined(points, self.normal, self.offset);
        Self { normal, offset, share: share_on(points, &normal, offset) }
    }
}

/// Share of points off the largest plane.
pub(super) fn off_plane(points: &[Point3<f64>], seed: u64) -> f64 {
    LargestPlane::find(points, seed).map_or(0.0, |plane| 1.0 - plane.share)
}

/// Share of pieces of the image off the largest plane, each piece by its median depth, which suppresses noise. `None`
/// for too few points.
pub(super) fn pieces_off_plane(points: &[Point3<f64>], pixels: &[Point2<f64>], seed: u64) -> Option<f64> {
    if points.len() < PIECES * OF_PIECE {
        return None;
    }
    let sorted_by = |indices: &mut [usize], axis: usize| {
        indices.sort_unstable_by(|a, b| pixels[*a][axis].total_cmp(&pixels[*b][axis]));
    };
    // Strips of columns, divided into pieces of equal numbers of points.
    let mut indices: Vec<usize> = (0..points.len()).collect();
    sorted_by(&mut indices, 0);
    let pieces = points.len() / OF_PIECE;
    let strips = (pieces as f64).sqrt() as usize;
    let mut middles = Vec::with_capacity(pieces);
    for strip in indices.chunks_mut(points.len().div_ceil(strips)) {
        sorted_by(strip, 1);
        for piece in strip.chunks_mut(OF_PIECE) {
            // The point at the median inverse depth on the mean ray.
            let count = piece.len() as f64;
            let mean = piece.iter().fold(Vector3::zeros(), |sum, i| sum + points[*i].coords / points[*i].z) / count;
            let mut depths: Vec<f64> = piece.iter().map(|i| 1.0 / points[*i].z).collect();
            middles.push(Point3::from(mean / median(&mut depths)));
        }
    }
    Some(off_plane(&middles, seed))
}

/// `true` if a scene with this share of points off its largest plane is flat.
pub(super) fn is_flat(off_plane: f64) -> bool {
    off_plane < OFF_PLANE
}

fn is_on(point: &Point3<f64>, normal: &Vector3<f64>, offset: f64) -> bool {
    (normal.dot(&point.coords) - offset).abs() < THICKNESS * point.z
}

fn share_on(points: &[Point3<f64>], normal: &Vector3<f64>, offset: f64) -> f64 {
    points.iter().filter(|point| is_on(point, normal, offset)).count() as f64 / points.len() as f64
}

/// Least-squares plane through the points near a plane.
fn refined(points: &[Point3<f64>], mut normal: Vector3<f64>, mut offset: f64) -> (Vector3<f64>, f64) {
    let side = if normal.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
    let first = normal.cross(&side).normalize();
    let second = normal.cross(&first);
    let mut matrix = nalgebra::Matrix3::zeros();
    let mut right = Vector3::zeros();
    for point in points.iter().filter(|point| is_on(point, &normal, offset)) {
        let row = Vector3::new(first.dot(&point.coords), second.dot(&point.coords), 1.0);
        matrix += row * row.transpose();
        right += row * normal.dot(&point.coords);
    }
    if let Some(fit) = matrix.cholesky().map(|cholesky| cholesky.solve(&right)) {
        let tilted = normal - first * fit.x - second * fit.y;
        let length = tilted.norm();
        if length.is_finite() && length > 0.0 {
            (normal, offset) = (tilted / length, fit.z / length);
        }
    }
    (normal, offset)
}

/// Area of the pixels' convex hull as a share of the image (Andrew's monotone chain, 1979).
pub(super) fn outline_share(pixels: &[Point2<f64>], size_px: [u32; 2]) -> f64 {
    let mut sorted = pixels.to_vec();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let half = |pixels: &mut dyn Iterator<Item = &Point2<f64>>| {
        let mut chain: Vec<Point2<f64>> = Vec::new();
        for pixel in pixels {
            while let [.., before, last] = chain.as_slice() {
                if (last - before).perp(&(pixel - before)) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(*pixel);
        }
        chain.pop();
        chain
    };
    let mut outline = half(&mut sorted.iter());
    outline.extend(half(&mut sorted.iter().rev()));
    let area: f64 = (0..outline.len()).map(|i| outline[i].coords.perp(&outline[(i + 1) % outline.len()].coords)).sum();
    (0.5 * area.abs() / (f64::from(size_px[0]) * f64::from(size_px[1]))).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wall_is_flat_with_noise_and_a_wall_with_a_box_is_not() {
        let mut random = SplitMix64::new(3, 0);
        let mut wall: Vec<Point3<f64>> = (0..2000)
            .map(|_| {
                let (x, y) = (random.unit() - 0.5, random.unit() - 0.5);
                Point3::new(x, y, 1.5 + 0.4 * x + 0.004 * (random.unit() - 0.5))
            })
            .collect();
        assert!(is_flat(off_plane(&wall, 0)));
        for point in wall.iter_mut().take(200) {
            point.z -= 0.2;
        }
        assert!(!is_flat(off_plane(&wall, 0)));
        assert!(is_flat(off_plane(&wall[..3], 0)));
    }

    #[test]
    fn the_outline_of_a_quarter_is_a_quarter() {
        let pixels: Vec<_> = (0..=10)
            .flat_map(|i| (0..=10).map(move |j| Point2::new(64.0 * f64::from(i), 40.0 * f64::from(j))))
            .collect();
        assert!((outline_share(&pixels, [1280, 800]) - 0.25).abs() < 1e-9);
        assert_eq!(outline_share(&pixels[..5], [1280, 800]), 0.0);
        assert_eq!(outline_share(&[], [1280, 800]), 0.0);
    }
}
