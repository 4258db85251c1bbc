//! Planar patches of the surface that the camera sees.
//!
//! On a plane, inverse depth is linear in the camera's pixels. So a plane through a window of inverse depths tells where
//! any camera ray or projector ray near it meets the surface.

use nalgebra::{Isometry3, Matrix2, Point2, Point3, Vector2};

use crate::points::{inverse_depths, DepthWindow};
use crate::Lens;

/// Maximum Newton steps towards the camera pixel that sees a projector pixel.
const STEPS: usize = 6;
/// Convergence limit, projector pixels.
const CONVERGED_PX: f64 = 1e-3;
/// Maximum anisotropy of projector pixels over camera pixels: slanted surfaces exceed it.
const MOST_ANISOTROPIC: f64 = 4.0;

/// Depth image as a surface.
#[derive(Debug, Clone)]
pub(super) struct DepthSurface {
    /// Camera lens, of the depth image's size.
    pub(super) camera: Lens,
    /// Inverse depths, 1/m, row by row; 0 where missing.
    inverse: Vec<f32>,
}

impl DepthSurface {
    /// Creates the surface from depths along the optical axis, metres.
    pub(super) fn new(camera: &Lens, depth_m: &[f32]) -> Self {
        Self { camera: *camera, inverse: inverse_depths(depth_m) }
    }

    /// Width and height, pixels.
    pub(super) fn size(&self) -> [usize; 2] {
        self.camera.size_px.map(|side| side as usize)
    }

    /// Depth of a pixel by its index, metres.
    pub(super) fn depth_m(&self, index: usize) -> Option<f64> {
        let inverse = self.inverse.get(index).copied().filter(|inverse| *inverse > 0.0)?;
        Some(1.0 / f64::from(inverse))
    }

    /// Patch around a pixel; `None` where depths are missing or an edge is near.
    pub(super) fn patch(&self, x: usize, y: usize) -> Option<Patch> {
        let [width, height] = self.size();
        if x >= width || y >= height {
            return None;
        }
        let window = DepthWindow::new(&self.inverse, width, x, y)?;
        Some(Patch {
            middle: Point2::new(x as f64, y as f64),
            inverse: f64::from(window.inverse),
            by_px: Vector2::from(window.by_px.map(f64::from)),
        })
    }

    /// Patch around the nearest pixel.
    pub(super) fn patch_near(&self, place: Point2<f64>) -> Option<Patch> {
        let (x, y) = (place.x.round(), place.y.round());
        (x >= 0.0 && y >= 0.0).then(|| self.patch(x as usize, y as usize))?
    }
}

/// Planar patch of the surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Patch {
    /// Camera pixel in its centre.
    pub(super) middle: Point2<f64>,
    /// Inverse depth at the centre, 1/m.
    inverse: f64,
    /// Gradient of the inverse depth per pixel, to the right and down.
    by_px: Vector2<f64>,
}

impl Patch {
    /// Point seen by a camera pixel, in the camera's optical frame, metres.
    pub(super) fn point(&self, camera: &Lens, pixel: Point2<f64>) -> Option<Point3<f64>> {
        let inverse = self.inverse + self.by_px.dot(&(pixel - self.middle));
        (inverse > 0.0).then(|| camera.ray(pixel).map(|ray| Point3::from(ray / inverse)))?
    }
}

/// PosedProjector with the pose of its file.
#[derive(Debug, Clone, Copy)]
pub(super) struct PosedProjector {
    /// Lens.
    pub(super) lens: Lens,
    /// Pose, from the camera's optical frame.
    pub(super) from_camera: Isometry3<f64>,
}

impl PosedProjector {
    /// PosedProjector pixel that should light a point of the camera's optical frame.
    pub(super) fn pixel(&self, point: &Point3<f64>) -> Option<Point2<f64>> {
        self.lens.project(&(self.from_camera * point))
    }

    /// PosedProjector pixel that should light the point of a patch at a camera pixel.
    pub(super) fn pixel_of(&self, patch: &Patch, camera: &Lens, seen: Point2<f64>) -> Option<Point2<f64>> {
        self.pixel(&patch.point(camera, seen)?)
    }

    /// Derivatives of projector pixels by camera pixels on a patch; `None` at grazing angles of camera or projector.
    pub(super) fn by_camera_px(&self, patch: &Patch, camera: &Lens, seen: Point2<f64>) -> Option<Matrix2<f64>> {
        let half = [Vector2::new(0.5, 0.0), Vector2::new(0.0, 0.5)];
        let [right, down] = half.map(|step| {
            let (after, before) =
                (self.pixel_of(patch, camera, seen + step)?, self.pixel_of(patch, camera, seen - step)?);
            Some(after - before)
        });
        let jacobian = Matrix2::from_columns(&[right?, down?]);
        let scales = jacobian.singular_values();
        let is_open = jacobian.determinant() > 0.0 && scales.max() < MOST_ANISOTROPIC * scales.min();
        is_open.then_some(jacobian)
    }

    /// Camera pixel that should see a projector pixel's light on a patch.
    pub(super) fn seen_at(&self, patch: &Patch, camera: &Lens, pixel: Point2<f64>) -> Option<Point2<f64>> {
        let mut seen = patch.middle;
        for _ in 0..STEPS {
            let off = pixel - self.pixel_of(patch, camera, seen)?;
            if off.norm() < CONVERGED_PX {
                return Some(seen);
            }
            seen += self.by_camera_px(patch, camera, seen)?.try_inverse()? * off;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_projectors_pixel_is_seen_where_its_light_meets_the_surface() {
        let camera = Lens::pinhole([160, 120], [140.0, 140.0], [79.5, 59.5]);
        // A slanted plane: z = 1.5 + 0.3 x.
        let depth_of = |index: usize| {
            let ray = camera.ray(Point2::new((index % 160) as f64, (index / 160) as f64)).unwrap();
            (1.5 / (1.0 - 0.3 * ray.x)) as f32
        };
        let depth_m: Vec<f32> = (0..160 * 120).map(depth_of).collect();
        let surface = DepthSurface::new(&camera, &depth_m);
        let lens = Lens::pinhole([640, 400], [700.0, 700.0], [320.0, 200.0]);
        let projector = PosedProjector { lens, from_camera: Isometry3::translation(-0.2, 0.05, 0.0) };
        let patch = surface.patch_near(Point2::new(90.4, 60.0)).unwrap();
        let pixel = projector.pixel_of(&patch, &camera, Point2::new(91.3, 58.6)).unwrap();
        let seen = projector.seen_at(&patch, &camera, pixel).unwrap();
        assert!((seen - Point2::new(91.3, 58.6)).norm() < 1e-3, "{seen}");
        let point = patch.point(&camera, seen).unwrap();
        assert!((point.z - 0.3 * point.x - 1.5).abs() < 1e-4, "{point}");
        assert!(surface.patch(0, 0).is_none() && surface.patch_near(Point2::new(-5.0, 3.0)).is_none());
    }
}
