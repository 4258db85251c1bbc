//! Correspondences of a scan: projector pixels and the points that they light.

use nalgebra::{Point2, Point3};

/// Projector pixel and the point in space that it lights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Subpixel projector coordinates (u, v).
    pub pixel: Point2<f64>,
    /// Point in the observing camera's optical frame, metres.
    pub point: Point3<f64>,
    /// Number of the camera pose. Samples of one number were observed from one pose; the projector moves between none.
    pub scan: u32,
    /// Standard deviation of each pixel coordinate, pixels. Only ratios matter: the solver estimates the common scale.
    pub sigma_px: f64,
    /// Standard deviation of the depth, metres; 0 if unknown.
    pub sigma_m: f64,
}

impl Sample {
    /// Default pixel deviation.
    pub const SIGMA_PX: f64 = 0.3;

    /// Creates a sample of scan 0 with the default pixel deviation and an unknown depth deviation.
    pub fn new(pixel: Point2<f64>, point: Point3<f64>) -> Self {
        Self { pixel, point, scan: 0, sigma_px: Self::SIGMA_PX, sigma_m: 0.0 }
    }
}
