//! `rviz/GridCells`: flat tiles of one colour.
//!
//! The cells stand where their frame was at the message's stamp. rviz puts the cloud of tiles into Ogre's queue twice,
//! once itself and once through its parts, so that translucent cells are drawn over themselves.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3};
use rcs_messages::geometry_msgs::Point;
use rcs_messages::nav_msgs::GridCells;
use rcs_messages::point_xyz;
use rcs_rviz_config::PlainColorSettings;
use rcs_scene::{DisplayId, Drawable, Geometry, Material, PointBuffer, PointColors, PointStyle, Points, Rgba};

use crate::framework::message_display::{DrawResult, InvalidFloats, MessageDisplay, MessageVisual};
use crate::framework::world::all_finite;
use crate::parts::bounds::middle;
use crate::parts::cloud::max_points;
use crate::parts::solids::drawable;

#[derive(Debug)]
pub(crate) struct GridCellsVisual {
    display: DisplayId,
    settings: PlainColorSettings,
}

pub(crate) fn create(display: DisplayId, settings: &PlainColorSettings) -> MessageDisplay<GridCellsVisual> {
    let visual = GridCellsVisual { display, settings: settings.clone() };
    MessageDisplay::new(&settings.topic, settings.queue_size, Some(1), visual)
}

impl GridCellsVisual {
    fn piece(&self, cells: &[Point], style: PointStyle, fixed_from_cells: &Isometry3<f64>) -> Drawable {
        let positions: Vec<[f32; 3]> =
            cells.iter().map(|cell| [cell.x, cell.y, cell.z].map(|value| value as f32)).collect();
        let sort_point = Point3::from(middle(positions.iter().copied())).cast();
        let color = Rgba::from_rgb8(self.settings.color, 1.0).to_rgba8();
        let points = Points {
            buffer: Arc::new(PointBuffer { positions, colors: PointColors::Uniform(color) }),
            style,
            alpha: self.settings.alpha,
            blended: self.settings.alpha < Material::OPAQUE_FROM_ALPHA,
            auto_size: false,
        };
        Drawable { sort_point, ..drawable(self.display, fixed_from_cells.to_homogeneous(), Geometry::Points(points)) }
    }
}

impl MessageVisual for GridCellsVisual {
    type Message = GridCells;

    fn draw(&mut self, cells: &GridCells, fixed_from_cells: &Isometry3<f64>) -> DrawResult {
        let is_finite = |cell: &Point| all_finite(&point_xyz(cell));
        let size_m = [cells.cell_width, cells.cell_height];
        if !size_m.iter().all(|side| side.is_finite()) || !cells.cells.iter().all(is_finite) {
            return Err(InvalidFloats);
        }
        let mut drawables = Vec::new();
        let style = PointStyle::Tiles { size_m, normal: [0.0, 0.0, 1.0], up: [0.0, 1.0, 0.0] };
        for piece in cells.cells.chunks(max_points(&style)) {
            let drawable = self.piece(piece, style, fixed_from_cells);
            if drawable.geometry.is_translucent() {
                drawables.push(drawable.clone());
            }
            drawables.push(drawable);
        }
        Ok(Some(drawables))
    }

    fn instead(&self, _next_to_go: &[Drawable]) -> Option<Vec<Drawable>> {
        Some(Vec::new())
    }

    fn fault(&self, cells: &GridCells) -> Option<String> {
        let sides = [(cells.cell_width, "width"), (cells.cell_height, "height")];
        let (_, name) = sides.into_iter().find(|(side_m, _)| *side_m == 0.0)?;
        Some(format!("Cell {name} is zero, cells will be invisible."))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(width: f32, height: f32, x: f64) -> GridCells {
        let cells = vec![Point { x, y: 2.0, z: 3.0 }, Point::default()];
        GridCells { cell_width: width, cell_height: height, cells, ..GridCells::default() }
    }

    fn visual(alpha: f32) -> GridCellsVisual {
        GridCellsVisual { display: 0, settings: PlainColorSettings { alpha, ..PlainColorSettings::default() } }
    }

    fn count(visual: &mut GridCellsVisual, cells: &GridCells) -> Result<usize, InvalidFloats> {
        Ok(visual.draw(cells, &Isometry3::identity())?.unwrap().len())
    }

    #[test]
    fn cells_without_finite_positions_or_without_size_are_reported_as_in_rviz() {
        let mut visual = visual(1.0);
        assert_eq!(count(&mut visual, &cells(0.1, 0.2, 1.0)), Ok(1));
        assert_eq!(visual.fault(&cells(0.1, 0.2, 1.0)), None);
        let nan = f32::NAN;
        for (width, height, x) in [(0.1, 0.2, f64::NAN), (0.1, 0.2, 1e39), (f32::INFINITY, 0.2, 1.0), (0.1, nan, 1.0)] {
            assert_eq!(count(&mut visual, &cells(width, height, x)), Err(InvalidFloats));
        }
        assert_eq!(visual.instead(&[]).map(|left| left.len()), Some(0), "nothing stays");
        for (width, height, name) in [(0.0, 0.2, "width"), (0.1, 0.0, "height"), (0.0, 0.0, "width")] {
            assert_eq!(count(&mut visual, &cells(width, height, 1.0)), Ok(1));
            let text = format!("Cell {name} is zero, cells will be invisible.");
            assert_eq!(visual.fault(&cells(width, height, 1.0)), Some(text));
        }
    }
}
