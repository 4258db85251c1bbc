//! Blending weights of several projectors on one surface.
//!
//! For each pixel of a projector, a cloud gives the lit point ([`surface`]); the other projectors' lenses and poses
//! tell which of them light it, too, and with which pixels. A pixel's strength falls with the squared distance from
//! each edge of the image, and the weight is the strength over the sum of all strengths. So weights add up to one in
//! linear light, and fall to zero at a projector's edge without a kink, which the eye would see as a line.
//!
//! Black pixels leak light, most where many projectors overlap. The lift is how much of one projector's leak each has
//! to add, so that black is everywhere as bright as where most overlap.

mod surface;
#[cfg(test)]
mod tests;

use nalgebra::{Isometry3, Point2, Point3};
use rayon::prelude::*;

use self::surface::LitSurface;
use crate::Lens;

/// Tolerance of the depth test against a projector's surface, as a share of the depth: the cloud's errors.
const BEHIND_SURFACE: f64 = 0.05;

/// Minimum strength factor, at the image's edge: it is divided by.
const LEAST_INSIDE: f64 = 1e-4;

/// Projector with its pose.
#[derive(Debug, Clone, Copy)]
pub struct PlacedProjector {
    /// Lens.
    pub lens: Lens,
    /// Pose, from the cloud's frame to the projector's optical frame.
    pub projector_from_cloud: Isometry3<f64>,
}

/// Blending weights of one projector.
#[derive(Debug, Clone, PartialEq)]
pub struct BlendWeights {
    /// Image width and height, pixels.
    pub size_px: [u32; 2],
    /// Factors of the linear light, 0 to 1, row by row.
    pub weights: Vec<f32>,
    /// Light to add to black, in multiples of one projector's leak, row by row.
    pub lifts: Vec<f32>,
    /// Share of the pixels whose point another projector lights, too.
    pub overlap: f64,
    /// Share of the image in which the cloud has points; elsewhere the surface is extrapolated.
    pub seen: f64,
}

/// Blending is impossible.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BlendProblem {
    /// Fewer than two projectors.
    #[error("blending needs two projectors or more")]
    TooFew,
    /// No point of the cloud is in the light.
    #[error("no point of the cloud is in the light of projector {number}: check its pose and the cloud's frame")]
    Dark {
        /// Number of the projector, from 1.
        number: usize,
    },
}

/// Computes the weights of projectors that light the surface of a cloud, in their order. Points that are not finite are
/// ignored.
///
/// # Errors
/// See [`BlendProblem`].
pub fn blend_weights(projectors: &[PlacedProjector], cloud: &[Point3<f64>]) -> Result<Vec<BlendWeights>, BlendProblem> {
    if projectors.len() < 2 {
        return Err(BlendProblem::TooFew);
    }
    let cloud: Vec<Point3<f64>> = cloud.iter().filter(|point| point.iter().all(|x| x.is_finite())).copied().collect();
    let lit = |(index, projector): (usize, &PlacedProjector)| {
        let surface = LitSurface::new(&projector.lens, &projector.projector_from_cloud, &cloud);
        Ok(Lit { projector: *projector, surface: surface.ok_or(BlendProblem::Dark { number: index + 1 })? })
    };
    let lit = projectors.iter().enumerate().map(lit).collect::<Result<Vec<_>, _>>()?;
    let shares: Vec<Vec<Share>> = (0..lit.len()).map(|index| shares(&lit, index)).collect();
    let most = shares.iter().flatten().map(|share| share.count).max().unwrap_or(1);
    let weights = |(lit, shares): (&Lit, Vec<Share>)| BlendWeights {
        size_px: lit.projector.lens.size_px,
        weights: shares.iter().map(|share| share.weight).collect(),
        lifts: shares.iter().map(|share| f32::from(most - share.count) / f32::from(share.count)).collect(),
        overlap: shares.iter().filter(|share| share.count > 1).count() as f64 / shares.len().max(1) as f64,
        seen: lit.surface.observed_share(),
    };
    Ok(lit.iter().zip(shares).map(weights).collect())
}

/// Projector with the surface that it lights.
struct Lit {
    projector: PlacedProjector,
    surface: LitSurface,
}

#[derive(Debug, Clone, Copy)]
struct Share {
    weight: f32,
    /// Number of projectors that light the point, this one included.
    count: u8,
}

/// Weights of all pixels of a projector.
fn shares(all: &[Lit], index: usize) -> Vec<Share> {
    let Some(own) = all.get(index) else { return Vec::new() };
    let [width, height] = own.projector.lens.size_px;
    let cloud_from_projector = own.projector.projector_from_cloud.inverse();
    let others: Vec<&Lit> = all.iter().enumerate().filter(|(other, _)| *other != index).map(|(_, lit)| lit).collect();
    let share = |pixel: Point2<f64>| {
        // Pixels without a ray light nothing.
        let Some(ray) = own.projector.lens.ray(pixel) else { return Share { weight: 0.0, count: 1 } };
        let point = cloud_from_projector * Point3::from(ray * own.surface.depth_m(pixel));
        let strength = own.strength(pixel);
        let (mut sum, mut count) = (strength, 1);
        for other in others.iter().filter_map(|other| other.strength_at(&point)) {
            sum += other;
            count += 1;
        }
        Share { weight: if count > 1 { (strength / sum) as f32 } else { 1.0 }, count }
    };
    let rows = (0..height).into_par_iter();
    rows.flat_map_iter(|row| (0..width).map(move |column| (column, row)))
        .map(|(column, row)| share(Point2::new(f64::from(column), f64::from(row))))
        .collect()
}

impl Lit {
    /// Strength of a pixel before normalisation: near zero at the edge.
    fn strength(&self, pixel: Point2<f64>) -> f64 {
        let [width, height] = self.projector.lens.size_px.map(f64::from);
        // From 0 at both ends of a side to 1 in its middle.
        let inside = |at: f64, side: f64| (4.0 * (at + 0.5) * (side - 0.5 - at) / (side * side)).max(LEAST_INSIDE);
        (inside(pixel.x, width) * inside(pixel.y, height)).powi(2)
    }

    /// Strength of the pixel that lights a point of the cloud's frame; `None` if none does.
    fn strength_at(&self, point: &Point3<f64>) -> Option<f64> {
        let point = self.projector.projector_from_cloud * point;
        let pixel = self.projector.lens.project(&point).filter(|pixel| self.projector.lens.contains(*pixel))?;
        // Occluded by a nearer surface.
        (point.z <= self.surface.depth_m(pixel) * (1.0 + BEHIND_SURFACE)).then(|| self.strength(pixel))
    }
}
