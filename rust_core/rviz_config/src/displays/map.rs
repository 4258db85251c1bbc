//! `rviz/Map`: a `nav_msgs/OccupancyGrid` as a coloured rectangle.

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

properties! {
    /// The properties of a Map display.
    pub struct MapSettings {
        /// Topic of `nav_msgs/OccupancyGrid`; empty when none is chosen. Changes of parts come on the topic of this
        /// name with `_updates` behind it, as `map_msgs/OccupancyGridUpdate`.
        topic: String = String::new() => topic("Topic");
        /// Opacity, 0 to 1.
        alpha: f32 = 0.7 => float("Alpha", 0.0..=1.0);
        /// How cells are coloured.
        palette: MapPalette = MapPalette::Map => choice("Color Scheme", &PALETTES);
        /// `true` if the map is drawn before, and so behind, everything else.
        draw_behind: bool = false => bool("Draw Behind");
        /// `true` for the pose of the map's frame at its stamp, else the latest.
        use_timestamp: bool = false => bool("Use Timestamp");
    }
    // Values of the message, which rviz displays beside the properties.
    skip ["Resolution", "Width", "Height", "Position", "Orientation"];
}
