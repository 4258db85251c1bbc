//! `rviz/Map`: a `nav_msgs/OccupancyGrid` as a coloured rectangle.

use crate::section::Section;

/// How the values of a map's cells are coloured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MapPalette {
    /// From white (free) to black (occupied), unknown cells grey-green, illegal values in loud colours.
    #[default]
    Map,
    /// From blue to red, the costs 99 and 100 in loud colours, cost 0 invisible.
    Costmap,
    /// Each byte as a shade of grey.
    Raw,
}

const PALETTES: [(&str, MapPalette); 3] =
    [("map", MapPalette::Map), ("costmap", MapPalette::Costmap), ("raw", MapPalette::Raw)];

/// What rviz shows beside the map without taking it from the config.
const SHOWN_ONLY: [&str; 5] = ["Resolution", "Width", "Height", "Position", "Orientation"];

/// The properties of a Map display.
#[derive(Debug, Clone, PartialEq)]
pub struct MapSettings {
    /// Topic of `nav_msgs/OccupancyGrid`; empty when none is chosen. Changes of parts come on the topic of this name
    /// with `_updates` behind it, as `map_msgs/OccupancyGridUpdate`.
    pub topic: String,
    /// Opacity, 0 to 1.
    pub alpha: f32,
    /// How cells are coloured.
    pub palette: MapPalette,
    /// Whether the map is drawn before everything else, so that everything else is seen.
    pub draw_behind: bool,
    /// Whether the map stands where its frame was at its stamp, or where the frame is now.
    pub use_timestamp: bool,
}

impl Default for MapSettings {
    fn default() -> Self {
        MapSettings {
            topic: String::new(),
            alpha: 0.7,
            palette: MapPalette::Map,
            draw_behind: false,
            use_timestamp: false,
        }
    }
}

impl MapSettings {
    pub(crate) fn read(section: &mut Section<'_>) -> Self {
        let mut settings = MapSettings::default();
        section.text("Topic", &mut settings.topic);
        section.skip(&["Unreliable"]);
        section.float("Alpha", 0.0..=1.0, &mut settings.alpha);
        section.choice("Color Scheme", &PALETTES, &mut settings.palette);
        section.bool("Draw Behind", &mut settings.draw_behind);
        section.bool("Use Timestamp", &mut settings.use_timestamp);
        section.skip(&SHOWN_ONLY);
        settings
    }
}
