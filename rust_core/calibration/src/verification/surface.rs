//! Planar patches of the surface that the camera sees.
//!
//! On a plane, inverse depth is linear in the camera's pixels. So a plane through a window of inverse depths tells
//! where any camera ray or projector ray near it meets the surface.

use nalgebra::{Isometry3, Matrix2, Point2, Point3, Vector2};

use crate::points::{inverse_depths, DepthWindow};
use crate::Lens;

/// Maximum Newton steps towards the camera pixel that sees a projector pixel.
const STEPS: usize = 6;
/// Convergence limit, projector pixels.
const CONVERGED_PX: f64 = 1e-3;
/// Maximum anisotropy of projector pixels over camera pixels: slanted surfaces exceed it.
const MOST_ANISOTROPIC: f64 = 4.0;

/// Side of a cell, projector pixels.
const SHADOW_CELL_PX: f64 = 6.0;
/// Share of the depth by which an occluder in a neighbouring cell must be nearer.
const NEARER: f64 = 0.03;

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

/// Projector with the pose of its file.
#[derive(Debug, Clone, Copy)]
pub(super) struct PosedProjector {
    pub(super) lens: Lens,
    /// Pose, from the camera's optical frame.
    pub(super) from_camera: Isometry3<f64>,
}

impl PosedProjector {
    /// Projector pixel that should light a point of the camera's optical frame.
    pub(super) fn pixel(&self, point: &Point3<f64>) -> Option<Point2<f64>> {
        self.lens.project(&(self.from_camera * point))
    }

    /// Projector pixel that should light the point of a patch at a camera pixel.
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

/// Nearest depth in each cell of the projector's image.
#[derive(Debug, Clone)]
pub(super) struct ShadowMap {
    cells: [usize; 2],
    nearest_m: Vec<f64>,
}

impl ShadowMap {
    pub(super) fn new(surface: &DepthSurface, projector: &PosedProjector) -> Self {
        let cells = projector.lens.size_px.map(|side| (f64::from(side) / SHADOW_CELL_PX).ceil() as usize);
        let mut nearest_m = vec![f64::INFINITY; cells[0] * cells[1]];
        let [width, height] = surface.size();
        for index in 0..width * height {
            let Some(depth) = surface.depth_m(index) else { continue };
            let seen = Point2::new((index % width) as f64, (index / width) as f64);
            let Some(ray) = surface.camera.ray(seen) else { continue };
            let point = projector.from_camera * Point3::from(ray * depth);
            let cell = projector.lens.project(&point).and_then(|pixel| shadow_cell(pixel, cells));
            if let Some([column, row]) = cell {
                let nearest = &mut nearest_m[row * cells[0] + column];
                *nearest = nearest.min(point.z);
            }
        }
        Self { cells, nearest_m }
    }

    /// `true` if a pixel's light reaches a point of this depth from the projector, metres.
    pub(super) fn is_reached(&self, pixel: Point2<f64>, depth_m: f64) -> bool {
        let Some([column, row]) = shadow_cell(pixel, self.cells) else { return false };
        let columns = column.saturating_sub(1)..=(column + 1).min(self.cells[0] - 1);
        let mut rows = row.saturating_sub(1)..=(row + 1).min(self.cells[1] - 1);
        rows.all(|row| {
            let start = row * self.cells[0];
            let nearest = &self.nearest_m[start + columns.start()..=start + columns.end()];
            nearest.iter().all(|nearest| *nearest > (1.0 - NEARER) * depth_m)
        })
    }
}

fn shadow_cell(pixel: Point2<f64>, cells: [usize; 2]) -> Option<[usize; 2]> {
    let [column, row] = [pixel.x, pixel.y].map(|at| (at + 0.5) / SHADOW_CELL_PX);
    (column >= 0.0 && row >= 0.0 && column < cells[0] as f64 && row < cells[1] as f64)
        .then_some([column as usize, row as usize])
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

    #[test]
    fn a_thing_hides_the_wall_on_the_side_away_from_the_projector() {
        let camera = Lens::pinhole([160, 120], [140.0, 140.0], [79.5, 59.5]);
        // A wall at 2 m and before it, in the middle, a panel at 1 m. The projector is 0.3 m to the right.
        let is_panel = |index: usize| (70..90).contains(&(index % 160)) && (40..80).contains(&(index / 160));
        let depth_m: Vec<f32> = (0..160 * 120).map(|index| if is_panel(index) { 1.0 } else { 2.0 }).collect();
        let lens = Lens::pinhole([320, 240], [200.0, 200.0], [159.5, 119.5]);
        let projector = PosedProjector { lens, from_camera: Isometry3::translation(-0.3, 0.0, 0.0) };
        let shadow = ShadowMap::new(&DepthSurface::new(&camera, &depth_m), &projector);
        let is_reached = |point: Point3<f64>| {
            let pixel = projector.pixel(&point).unwrap();
            shadow.is_reached(pixel, point.z)
        };
        assert!(is_reached(Point3::new(0.0, 0.0, 1.0)) && is_reached(Point3::new(0.4, 0.0, 2.0)));
        // The line from the projector through the panel meets the wall from -0.44 m to -0.15 m.
        assert!(!is_reached(Point3::new(-0.3, 0.0, 2.0)) && is_reached(Point3::new(-0.6, 0.0, 2.0)));
        assert!(!shadow.is_reached(Point2::new(-9.0, 0.0), 1.0));
    }
}
