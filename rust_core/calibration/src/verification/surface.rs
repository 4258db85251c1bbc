//! The surface that the camera sees, in flat pieces.
//!
//! On a plane, inverse depth is linear in the camera's pixels. So the plane through a window of inverse depths tells
//! where any pixel near it meets the surface, and where a projector pixel's light does.

use nalgebra::{Isometry3, Matrix2, Point2, Point3, Vector2};

use crate::points::{inverse_depths, Window};
use crate::Lens;

/// Steps towards the camera pixel where a projector's pixel is seen.
const STEPS: usize = 6;
/// The projector's pixels are met this well.
const MET_PX: f64 = 1e-3;
/// The projector's picture must not be squeezed more than this in any direction: the surface is seen at a slant.
const MOST_SQUEEZED: f64 = 4.0;

/// A depth image as a surface.
#[derive(Debug, Clone)]
pub(super) struct Surface {
    /// The camera, whose pictures have the size of the depth image.
    pub(super) camera: Lens,
    /// Inverse depths, 1/m, row by row; 0 where there is none.
    inverse: Vec<f32>,
}

impl Surface {
    /// The surface of a depth image, metres along the view.
    pub(super) fn new(camera: &Lens, depth_m: &[f32]) -> Self {
        Self { camera: *camera, inverse: inverse_depths(depth_m) }
    }

    /// Width and height, pixels.
    pub(super) fn size(&self) -> [usize; 2] {
        self.camera.size_px.map(|side| side as usize)
    }

    /// The depth of a pixel by its index, metres.
    pub(super) fn depth_m(&self, index: usize) -> Option<f64> {
        let inverse = self.inverse.get(index).copied().filter(|inverse| *inverse > 0.0)?;
        Some(1.0 / f64::from(inverse))
    }

    /// The flat piece around a pixel; none where depths are missing or an edge is near.
    pub(super) fn patch(&self, x: usize, y: usize) -> Option<Patch> {
        let [width, height] = self.size();
        if x >= width || y >= height {
            return None;
        }
        let window = Window::new(&self.inverse, width, x, y)?;
        Some(Patch {
            middle: Point2::new(x as f64, y as f64),
            inverse: f64::from(window.inverse),
            by_px: Vector2::from(window.by_px.map(f64::from)),
        })
    }

    /// The flat piece around a place, by its nearest pixel.
    pub(super) fn patch_near(&self, place: Point2<f64>) -> Option<Patch> {
        let (x, y) = (place.x.round(), place.y.round());
        (x >= 0.0 && y >= 0.0).then(|| self.patch(x as usize, y as usize))?
    }
}

/// A flat piece of the surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Patch {
    /// The camera pixel in its middle.
    pub(super) middle: Point2<f64>,
    /// The inverse depth there, 1/m.
    inverse: f64,
    /// By how much it grows from pixel to pixel, to the right and down.
    by_px: Vector2<f64>,
}

impl Patch {
    /// What a camera pixel sees of it: a point in the camera's optical frame, metres.
    pub(super) fn point(&self, camera: &Lens, pixel: Point2<f64>) -> Option<Point3<f64>> {
        let inverse = self.inverse + self.by_px.dot(&(pixel - self.middle));
        (inverse > 0.0).then(|| camera.ray(pixel).map(|ray| Point3::from(ray / inverse)))?
    }
}

/// A projector where its file says that it is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Projector {
    /// Its lens.
    pub(super) lens: Lens,
    /// Takes points of the camera's optical frame to the projector's.
    pub(super) from_camera: Isometry3<f64>,
}

impl Projector {
    /// The projector pixel that should light a point of the camera's optical frame.
    pub(super) fn pixel(&self, point: &Point3<f64>) -> Option<Point2<f64>> {
        self.lens.project(&(self.from_camera * point))
    }

    /// The projector pixel for what a camera pixel sees of a patch.
    pub(super) fn pixel_of(&self, patch: &Patch, camera: &Lens, seen: Point2<f64>) -> Option<Point2<f64>> {
        self.pixel(&patch.point(camera, seen)?)
    }

    /// Projector pixels by camera pixels around a place of a patch; none where the surface is nearly seen from its
    /// edge, by the camera or by the projector.
    pub(super) fn by_camera_px(&self, patch: &Patch, camera: &Lens, seen: Point2<f64>) -> Option<Matrix2<f64>> {
        let half = [Vector2::new(0.5, 0.0), Vector2::new(0.0, 0.5)];
        let [right, down] = half.map(|step| {
            let (after, before) =
                (self.pixel_of(patch, camera, seen + step)?, self.pixel_of(patch, camera, seen - step)?);
            Some(after - before)
        });
        let jacobian = Matrix2::from_columns(&[right?, down?]);
        let stretched = jacobian.singular_values();
        let is_open = jacobian.determinant() > 0.0 && stretched.max() < MOST_SQUEEZED * stretched.min();
        is_open.then_some(jacobian)
    }

    /// The camera pixel at which the light of a projector pixel should be seen on a patch.
    pub(super) fn seen_at(&self, patch: &Patch, camera: &Lens, pixel: Point2<f64>) -> Option<Point2<f64>> {
        let mut seen = patch.middle;
        for _ in 0..STEPS {
            let off = pixel - self.pixel_of(patch, camera, seen)?;
            if off.norm() < MET_PX {
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
        let surface = Surface::new(&camera, &depth_m);
        let lens = Lens::pinhole([640, 400], [700.0, 700.0], [320.0, 200.0]);
        let projector = Projector { lens, from_camera: Isometry3::translation(-0.2, 0.05, 0.0) };
        let patch = surface.patch_near(Point2::new(90.4, 60.0)).unwrap();
        let pixel = projector.pixel_of(&patch, &camera, Point2::new(91.3, 58.6)).unwrap();
        let seen = projector.seen_at(&patch, &camera, pixel).unwrap();
        assert!((seen - Point2::new(91.3, 58.6)).norm() < 1e-3, "{seen}");
        let point = patch.point(&camera, seen).unwrap();
        assert!((point.z - 0.3 * point.x - 1.5).abs() < 1e-4, "{point}");
        assert!(surface.patch(0, 0).is_none() && surface.patch_near(Point2::new(-5.0, 3.0)).is_none());
    }
}
