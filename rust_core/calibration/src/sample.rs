//! What a scan yields: which projector pixel lights which point.

use nalgebra::{Point2, Point3};

/// A projector pixel and the point in space that it lights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// The projector pixel (u, v), with fractions.
    pub pixel: Point2<f64>,
    /// The point, metres, in the optical frame of the camera that saw it.
    pub point: Point3<f64>,
    /// Which pose of the camera: samples of the same number were seen from the same place. The projector has not moved
    /// between them.
    pub scan: u32,
    /// Standard deviation of each of the pixel's coordinates, pixels. What counts is how they compare; the solver
    /// measures the common scale.
    pub sigma_px: f64,
    /// Standard deviation of the point's depth, metres; 0 if not known.
    pub sigma_m: f64,
}

impl Sample {
    /// The deviation of a pixel about which nothing is known.
    pub const SIGMA_PX: f64 = 0.3;

    /// A sample of scan 0 about whose errors nothing is known.
    pub fn new(pixel: Point2<f64>, point: Point3<f64>) -> Self {
        Self { pixel, point, scan: 0, sigma_px: Self::SIGMA_PX, sigma_m: 0.0 }
    }
}
