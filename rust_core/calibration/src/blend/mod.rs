//! The shares that several projectors have of the light on one surface.
//!
//! For each pixel of a projector, a cloud says which point it lights ([`surface`]); the other projectors' lenses and
//! poses say which of them light that point, too, and where in each one's picture it is. A projector's strength falls
//! with the square of the distance from each of its picture's edges, and its weight is its strength over the sum of
//! those of all: so weights add up to one in linear light, a projector's falls to nothing at its edge, and it does so
//! without a kink, which the eye would see as a line.
//!
//! Where the picture is black, each projector still leaks light, and where several overlap, more of it. The lift says
//! how much of the leak of one projector each has to add, so that black is everywhere as bright as where most overlap.

mod surface;
#[cfg(test)]
mod tests;

use nalgebra::{Isometry3, Point2, Point3};
use rayon::prelude::*;

use self::surface::LitSurface;
use crate::Lens;

/// How much farther away than its surface a point may be, to be lit by a projector: the cloud's errors.
const BEHIND_SURFACE: f64 = 0.05;

/// What counts as inside of the picture at its very edge, so that there is something to divide by.
const LEAST_INSIDE: f64 = 1e-4;

/// A projector where it stands.
#[derive(Debug, Clone, Copy)]
pub struct PlacedProjector {
    /// Its lens.
    pub lens: Lens,
    /// From the cloud's frame to its optical frame.
    pub projector_from_cloud: Isometry3<f64>,
}

/// The share of a projector.
#[derive(Debug, Clone, PartialEq)]
pub struct BlendWeights {
    /// Width and height of its picture.
    pub size_px: [u32; 2],
    /// What its light is multiplied by, 0 to 1, row by row; linear.
    pub weights: Vec<f32>,
    /// How many times the leaked light of one projector it has to add.
    pub lifts: Vec<f32>,
    /// The share of its pixels that another projector lights, too.
    pub overlap: f64,
    /// The share of its picture in which the cloud has points; elsewhere, the surface is guessed.
    pub seen: f64,
}

/// Why there are no weights.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BlendProblem {
    /// There is only one projector, or none.
    #[error("blending needs two projectors or more")]
    TooFew,
    /// No point of the cloud is in the light.
    #[error("no point of the cloud is in the light of projector {number}: check its pose and the cloud's frame")]
    Dark {
        /// Which one, counted from 1.
        number: usize,
    },
}

/// The shares of projectors that light the surface of a cloud, in their order. Points that are not finite are left out.
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
        seen: lit.surface.seen_share(),
    };
    Ok(lit.iter().zip(shares).map(weights).collect())
}

/// A projector and what it lights.
struct Lit {
    projector: PlacedProjector,
    surface: LitSurface,
}

/// What a pixel has of the light on its point.
#[derive(Debug, Clone, Copy)]
struct Share {
    weight: f32,
    /// How many projectors light the point, this one included.
    count: u8,
}

/// The shares of all pixels of a projector.
fn shares(all: &[Lit], index: usize) -> Vec<Share> {
    let Some(own) = all.get(index) else { return Vec::new() };
    let [width, height] = own.projector.lens.size_px;
    let cloud_from_projector = own.projector.projector_from_cloud.inverse();
    let others: Vec<&Lit> = all.iter().enumerate().filter(|(other, _)| *other != index).map(|(_, lit)| lit).collect();
    let share = |pixel: Point2<f64>| {
        // What the lens sends nowhere is of no use to anybody.
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
    /// How strong the light of a pixel in the picture may be, before that of others is known: nothing at the edge.
    fn strength(&self, pixel: Point2<f64>) -> f64 {
        let [width, height] = self.projector.lens.size_px.map(f64::from);
        // From 0 at both ends of a side to 1 in its middle.
        let inside = |at: f64, side: f64| (4.0 * (at + 0.5) * (side - 0.5 - at) / (side * side)).max(LEAST_INSIDE);
        (inside(pixel.x, width) * inside(pixel.y, height)).powi(2)
    }

    /// That of the pixel that lights a point of the cloud's frame; none where none does.
    fn strength_at(&self, point: &Point3<f64>) -> Option<f64> {
        let point = self.projector.projector_from_cloud * point;
        let pixel = self.projector.lens.project(&point).filter(|pixel| self.projector.lens.contains(*pixel))?;
        // In the shadow of something nearer.
        (point.z <= self.surface.depth_m(pixel) * (1.0 + BEHIND_SURFACE)).then(|| self.strength(pixel))
    }
}
