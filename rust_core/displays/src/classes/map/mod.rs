//! `rviz/Map`: an occupancy grid as a rectangle of coloured cells.
//!
//! A map is shown as soon as it comes. It follows its frame, or with "Use Timestamp" stands where the frame was at its
//! stamp; while its frame is not known it lies at the fixed frame's origin, as in rviz. Of a map that changes in part
//! only the tiles that change are copied.

mod palette;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use nalgebra::{Isometry3, Matrix4, Vector3};
use rcs_messages::map_msgs::OccupancyGridUpdate;
use rcs_messages::{AnyMessage, MessageKind, OccupancyGrid, PlainTransform};
use rcs_rviz_config::MapSettings;
use rcs_scene::{Blending, CellSheet, Cells, DisplayId, Drawable, Geometry, Material, RenderGroup};
use rcs_transforms::Time;

use crate::framework::display::{Display, TopicRequest};
use crate::framework::message_display::InvalidFloats;
use crate::framework::world::{isometry, stamp};
use crate::parts::solids::drawable;
use crate::{Level, StatusText, Statuses, World};

/// Largest side of a map in cells: rviz cuts it into eight textures.
const MAX_SIDE: u32 = 65_536;

/// Largest number of cells for which memory is reserved without data.
const MAX_CELLS_WITHOUT_DATA: u64 = 1 << 26;

#[derive(Debug)]
pub(crate) struct MapDisplay {
    display: DisplayId,
    settings: MapSettings,
    /// The last valid map.
    shown: Option<Map>,
    /// No invalid map has come after it.
    is_latest: bool,
    /// The cells or their place changed since the last update.
    is_new: bool,
    drawables: Vec<Drawable>,
    statuses: Statuses,
}

#[derive(Clone, Debug)]
struct Map {
    frame: String,
    stamp: Time,
    frame_from_map: Isometry3<f64>,
    size: Vector3<f64>,
    cells: Arc<Cells>,
}

/// Reason why a map is not shown.
struct Refusal(String);

pub(crate) fn create(display: DisplayId, settings: &MapSettings) -> MapDisplay {
    let mut statuses = Statuses::default();
    statuses.set(Level::Warn, "Message", "No map received");
    if !settings.topic.is_empty() {
        statuses.set(Level::Ok, Statuses::TOPIC, "OK");
        statuses.set(Level::Ok, "Update Topic", "OK");
    }
    MapDisplay {
        display,
        settings: settings.clone(),
        shown: None,
        is_latest: false,
        is_new: false,
        drawables: Vec::new(),
        statuses,
    }
}

impl MapDisplay {
    fn take_map(&mut self, grid: &OccupancyGrid) {
        self.is_latest = false;
        // rviz waits for a map with cells.
        if grid.data().is_empty() {
            let (width, height) = (grid.info.width, grid.info.height);
            self.statuses.set(Level::Warn, "Map", format!("Map of {width}x{height} cells has no data"));
            return;
        }
        match Map::new(grid) {
            Ok(map) => {
                self.statuses.set(Level::Ok, "Message", "Map received");
                match data_fault(grid).or_else(|| size_fault(&map)) {
                    Some(fault) => self.statuses.set(Level::Error, "Map", fault),
                    None => self.statuses.set(Level::Ok, "Map", "Map OK"),
                }
                self.statuses.remove("Update");
                self.shown = Some(map);
                (self.is_latest, self.is_new) = (true, true);
            }
            Err(Refusal(text)) => self.statuses.set(Level::Error, "Map", text),
        }
    }

    fn take_update(&mut self, update: &OccupancyGridUpdate) {
        let Some(map) = self.shown.as_mut().filter(|_| self.is_latest) else { return };
        let ends_within = |begin: i32, length: u32, side: u32| {
            u32::try_from(begin).ok().and_then(|begin| begin.checked_add(length)).is_some_and(|end| end <= side)
        };
        let (width, height) = (map.cells.width(), map.cells.height());
        if !ends_within(update.x, update.width, width) || !ends_within(update.y, update.height, height) {
            self.statuses.set(Level::Error, "Update", "Update area outside of original map area.");
            return;
        }
        let count = u64::from(update.width) * u64::from(update.height);
        if count > update.data.len() as u64 {
            let text = format!(
                "Update data size doesn't match width*height: width = {}, height = {}, data size = {}",
                update.width,
                update.height,
                update.data.len()
            );
            self.statuses.set(Level::Error, "Update", text);
            return;
        }
        self.statuses.remove("Update");
        let values: Vec<u8> = update.data.iter().take(count as usize).map(|value| *value as u8).collect();
        let place = [update.x.unsigned_abs(), update.y.unsigned_abs()];
        // The renderer may still hold the old cells; only changed tiles are copied.
        let mut cells = Cells::clone(&map.cells);
        cells.write(place, update.width, &values);
        map.cells = Arc::new(cells);
        self.is_new = true;
    }

    /// Pose of a map's corner in the fixed frame.
    fn place(&self, map: &Map, world: &World<'_>) -> Result<Isometry3<f64>, StatusText> {
        let at_stamp = self.settings.use_timestamp.then(|| world.fixed_from(&map.frame, map.stamp).ok()).flatten();
        let fixed_from_frame = at_stamp.map_or_else(|| world.fixed_from_moving(&map.frame), Ok);
        fixed_from_frame.map(|fixed_from_frame| fixed_from_frame * map.frame_from_map).map_err(|_| {
            StatusText::about_frame(format!("No transform from [{}] to [{}]", map.frame, world.fixed_frame))
        })
    }

    fn drawable(&self, map: &Map, fixed_from_map: &Isometry3<f64>) -> Drawable {
        let MapSettings { alpha, palette: scheme, draw_behind, .. } = self.settings;
        let is_translucent = alpha < Material::OPAQUE_FROM_ALPHA || palette::always_blends(scheme);
        let sheet = CellSheet {
            cells: map.cells.clone(),
            palette: palette::palette(scheme),
            alpha,
            blending: if is_translucent { Blending::Alpha } else { Blending::Replace },
            depth_write: !is_translucent && !draw_behind,
        };
        let fixed_from_sheet = fixed_from_map.to_homogeneous() * Matrix4::new_nonuniform_scaling(&map.size);
        let group = if draw_behind { RenderGroup::Behind } else { RenderGroup::Main };
        Drawable { group, ..drawable(self.display, fixed_from_sheet, Geometry::Cells(sheet)) }
    }
}

impl Map {
    fn new(grid: &OccupancyGrid) -> Result<Self, Refusal> {
        let (width, height, resolution_m) = (grid.info.width, grid.info.height, grid.info.resolution);
        let frame_from_map = isometry(&PlainTransform::from(&grid.info.origin));
        let Some(frame_from_map) = frame_from_map.filter(|_| resolution_m.is_finite()) else {
            return Err(Refusal(InvalidFloats.to_string()));
        };
        let count = u64::from(width) * u64::from(height);
        if count == 0 {
            return Err(Refusal(format!("Map is zero-sized ({width}x{height})")));
        }
        if width.max(height) > MAX_SIDE {
            return Err(Refusal(format!("Map is too large ({width}x{height}), at most {MAX_SIDE} cells a side")));
        }
        if count > MAX_CELLS_WITHOUT_DATA.max(grid.data().len() as u64) {
            return Err(Refusal(data_fault(grid).unwrap_or_default()));
        }
        // Sizes in single precision, as rviz computes them.
        let size_m = [width, height].map(|cells| f64::from(cells as f32 * resolution_m));
        let frame = if grid.header.frame_id.is_empty() { "map" } else { &grid.header.frame_id };
        Ok(Self {
            frame: frame.to_owned(),
            stamp: stamp(&grid.header),
            frame_from_map,
            size: Vector3::new(size_m[0], size_m[1], 1.0),
            cells: Arc::new(Cells::new(width, height, grid.data())),
        })
    }
}

/// rviz's error for a map with more or less data than its size requires; it is shown all the same, with unknown cells
/// where data are missing.
fn data_fault(grid: &OccupancyGrid) -> Option<String> {
    let (width, height, actual) = (grid.info.width, grid.info.height, grid.data().len());
    (u64::from(width) * u64::from(height) != actual as u64).then(|| {
        format!("Data size doesn't match width*height: width = {width}, height = {height}, data size = {actual}")
    })
}

/// Error for a map whose cells have no extent; rviz shows nothing, without a word.
fn size_fault(map: &Map) -> Option<String> {
    (map.size.min() == 0.0).then(|| "Map has a resolution of 0 m, its cells are invisible.".to_owned())
}

impl Display for MapDisplay {
    fn topics(&self) -> Vec<TopicRequest> {
        let topic = &self.settings.topic;
        let map = TopicRequest::new(topic, MessageKind::OccupancyGrid, 1);
        let updates = map.as_ref().map(|map| TopicRequest {
            topic: format!("{topic}_updates"),
            kind: MessageKind::OccupancyGridUpdate,
            queue_size: map.queue_size,
        });
        map.into_iter().chain(updates).collect()
    }

    fn take(&mut self, message: &AnyMessage, _world: &World<'_>) {
        match message {
            AnyMessage::OccupancyGrid(grid) => self.take_map(grid),
            AnyMessage::OccupancyGridUpdate(update) => self.take_update(update),
            _ => {}
        }
    }

    fn update(&mut self, world: &World<'_>) -> bool {
        let Some(map) = &self.shown else { return false };
        let place = self.place(map, world);
        let fixed_from_map = *place.as_ref().unwrap_or(&Isometry3::identity());
        let drawable = self.drawable(map, &fixed_from_map);
        match place {
            Ok(_) => self.statuses.set(Level::Ok, Statuses::TRANSFORM, "Transform OK"),
            Err(text) => self.statuses.set(Level::Error, Statuses::TRANSFORM, text),
        }
        let has_moved = self.drawables.first().map(|shown| shown.fixed_from_object) != Some(drawable.fixed_from_object);
        if !has_moved && !self.is_new {
            return false;
        }
        self.is_new = false;
        self.drawables = vec![drawable];
        true
    }

    fn drawables(&self) -> &[Drawable] {
        &self.drawables
    }

    /// Keeps the map: rviz subscribes again and so gets a latched map once more, which is not sent here.
    fn reset(&mut self) {}

    fn statuses(&self) -> &Statuses {
        &self.statuses
    }
}
