//! `rviz/GridCells`: flat tiles of one colour.
//!
//! The cells stand where their frame was at the message's stamp. rviz puts the cloud of tiles into Ogre's queue twice,
//! once itself and once through its parts, so that translucent cells are drawn over themselves.

use std::sync::Arc;

use nalgebra::{Isometry3, Point3};
use rcs_messages::geometry_msgs::Point;
use rcs_messages::nav_msgs::GridCells;
use rcs_messages::{AnyMessage, MessageKind};
use rcs_rviz_config::PlainColorSettings;
use rcs_scene::{DisplayId, Drawable, Geometry, Material, PointBuffer, PointColors, PointStyle, Points, Rgba};
use rcs_transforms::Time;

use crate::framework::display::{Display, TopicRequest};
use crate::framework::message_display::InvalidFloats;
use crate::framework::waiting_messages::WaitingMessages;
use crate::parts::bounds::middle;
use crate::parts::cloud::max_points;
use crate::parts::solids::drawable;
use crate::{Level, Statuses, World};

#[derive(Debug)]
pub(crate) struct GridCellsDisplay {
    display: DisplayId,
    settings: PlainColorSettings,
    incoming: WaitingMessages<GridCells>,
    drawables: Vec<Drawable>,
    statuses: Statuses,
}

pub(crate) fn create(display: DisplayId, settings: &PlainColorSettings) -> GridCellsDisplay {
    GridCellsDisplay {
        display,
        incoming: WaitingMessages::new(settings.queue_size),
        settings: settings.clone(),
        drawables: Vec::new(),
        statuses: Statuses::default(),
    }
}

impl GridCellsDisplay {
    /// Drawables of the cells; none, with a status, if a number is NaN or infinite.
    fn tiles(&mut self, cells: &GridCells, fixed_from_cells: &Isometry3<f64>) -> Vec<Drawable> {
        let is_finite = |cell: &Point| [cell.x, cell.y, cell.z].iter().all(|value| value.is_finite());
        let size_m = [cells.cell_width, cells.cell_height];
        if !size_m.iter().all(|side| side.is_finite()) || !cells.cells.iter().all(is_finite) {
            self.statuses.set(Level::Error, Statuses::TOPIC, InvalidFloats.to_string());
            return Vec::new();
        }
        for (side_m, name) in size_m.iter().zip(["width", "height"]).rev() {
            if *side_m == 0.0 {
                let text = format!("Cell {name} is zero, cells will be invisible.");
                self.statuses.set(Level::Error, Statuses::TOPIC, text);
            }
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
        drawables
    }

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

impl Display for GridCellsDisplay {
    fn topics(&self) -> Vec<TopicRequest> {
        let settings = &self.settings;
        TopicRequest::new(&settings.topic, MessageKind::GridCells, settings.queue_size).into_iter().collect()
    }

    fn take(&mut self, message: &AnyMessage, _world: &World<'_>) {
        if let AnyMessage::GridCells(cells) = message {
            self.incoming.push(&cells.header, cells.clone(), &mut self.statuses);
        }
    }

    fn is_waiting(&self, stamp: Time) -> bool {
        self.incoming.is_waiting(stamp)
    }

    fn update(&mut self, world: &World<'_>) -> bool {
        let newest = self.incoming.take_ready(world, &mut self.statuses).pop();
        let placed = newest.and_then(|cells| Some((world.fixed_from_header(&cells.header).ok()?, cells)));
        let Some((fixed_from_cells, cells)) = placed else { return false };
        self.drawables = self.tiles(&cells, &fixed_from_cells);
        true
    }

    fn drawables(&self) -> &[Drawable] {
        &self.drawables
    }

    fn reset(&mut self) {
        self.incoming.clear();
        self.drawables.clear();
        self.statuses.clear();
    }

    fn statuses(&self) -> &Statuses {
        &self.statuses
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(width: f32, height: f32, x: f64) -> GridCells {
        let cells = vec![Point { x, y: 2.0, z: 3.0 }, Point::default()];
        GridCells { cell_width: width, cell_height: height, cells, ..GridCells::default() }
    }

    fn topic_status(display: &GridCellsDisplay) -> Option<&str> {
        let (_, status) = display.statuses.iter().find(|(name, _)| *name == Statuses::TOPIC)?;
        Some(&status.text)
    }

    #[test]
    fn cells_without_finite_positions_or_without_size_are_reported_as_in_rviz() {
        let mut display = create(0, &PlainColorSettings::default());
        let here = Isometry3::identity();
        assert_eq!(display.tiles(&cells(0.1, 0.2, 1.0), &here).len(), 1);
        assert_eq!(topic_status(&display), None);
        for (width, height, x) in [(0.1, 0.2, f64::NAN), (f32::INFINITY, 0.2, 1.0), (0.1, f32::NAN, 1.0)] {
            assert_eq!(display.tiles(&cells(width, height, x), &here).len(), 0);
            let text = "Message contained invalid floating point values (nans or infs)";
            assert_eq!(topic_status(&display), Some(text));
        }
        for (width, height, name) in [(0.0, 0.2, "width"), (0.1, 0.0, "height"), (0.0, 0.0, "width")] {
            assert_eq!(display.tiles(&cells(width, height, 1.0), &here).len(), 1);
            let text = format!("Cell {name} is zero, cells will be invisible.");
            assert_eq!(topic_status(&display), Some(text.as_str()));
        }
    }

    #[test]
    fn translucent_cells_are_drawn_twice() {
        let mut display = create(0, &PlainColorSettings { alpha: 0.5, ..PlainColorSettings::default() });
        assert_eq!(display.tiles(&cells(0.1, 0.2, 1.0), &Isometry3::identity()).len(), 2);
    }
}
