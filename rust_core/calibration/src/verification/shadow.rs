//! ShadowMap map: depths from the projector by its file, in cells of its image.

use nalgebra::Point2;

use super::surface::{DepthSurface, PosedProjector};

/// Side of a cell, projector pixels.
const CELL_PX: f64 = 6.0;
/// Share of the depth by which an occluder in a neighbouring cell must be nearer.
const NEARER: f64 = 0.03;

/// Nearest depth in each cell of the projector's image.
#[derive(Debug, Clone)]
pub(super) struct ShadowMap {
    cells: [usize; 2],
    nearest_m: Vec<f64>,
}

impl ShadowMap {
    /// Builds the map from a surface.
    pub(super) fn new(surface: &DepthSurface, projector: &PosedProjector) -> Self {
        let cells = projector.lens.size_px.map(|side| (f64::from(side) / CELL_PX).ceil() as usize);
        let mut nearest_m = vec![f64::INFINITY; cells[0] * cells[1]];
        let [width, height] = surface.size();
        for index in 0..width * height {
            let Some(depth) = surface.depth_m(index) else { continue };
            let seen = Point2::new((index % width) as f64, (index / width) as f64);
            let Some(ray) = surface.camera.ray(seen) else { continue };
            let point = projector.from_camera * nalgebra::Point3::from(ray * depth);
            let cell = projector.lens.project(&point).and_then(|pixel| cell_of(pixel, cells));
            if let Some([column, row]) = cell {
                let nearest = &mut nearest_m[row * cells[0] + column];
                *nearest = nearest.min(point.z);
            }
        }
        Self { cells, nearest_m }
    }

    /// `true` if a pixel's light reaches a point of this depth from the projector, metres.
    pub(super) fn is_reached(&self, pixel: Point2<f64>, depth_m: f64) -> bool {
        let Some([column, row]) = cell_of(pixel, self.cells) else { return false };
        let columns = column.saturating_sub(1)..=(column + 1).min(self.cells[0] - 1);
        let mut rows = row.saturating_sub(1)..=(row + 1).min(self.cells[1] - 1);
        rows.all(|row| {
            let start = row * self.cells[0];
            let nearest = &self.nearest_m[start + columns.start()..=start + columns.end()];
            nearest.iter().all(|nearest| *nearest > (1.0 - NEARER) * depth_m)
        })
    }
}

fn cell_of(pixel: Point2<f64>, cells: [usize; 2]) -> Option<[usize; 2]> {
    let [column, row] = [pixel.x, pixel.y].map(|at| (at + 0.5) / CELL_PX);
    (column >= 0.0 && row >= 0.0 && column < cells[0] as f64 && row < cells[1] as f64)
        .then_some([column as usize, row as usize])
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Point3};

    use super::*;
    use crate::Lens;

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
