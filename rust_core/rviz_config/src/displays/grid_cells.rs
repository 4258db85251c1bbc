//! `rviz/GridCells`: the cells of a `nav_msgs/GridCells` as flat tiles of one colour.

use crate::section::Section;

/// The properties of a GridCells display.
#[derive(Debug, Clone, PartialEq)]
pub struct GridCellsSettings {
    /// Topic of `nav_msgs/GridCells`; empty when none is chosen.
    pub topic: String,
    /// Whether UDP is preferred.
    pub unreliable: bool,
    /// How many messages may wait for their transform.
    pub queue_size: u32,
    /// Colour of the cells, as red, green and blue.
    pub color: [u8; 3],
    /// Opacity, 0 to 1.
    pub alpha: f32,
}

impl Default for GridCellsSettings {
    fn default() -> Self {
        GridCellsSettings { topic: String::new(), unreliable: false, queue_size: 10, color: [25, 255, 0], alpha: 1.0 }
    }
}

impl GridCellsSettings {
    pub(crate) fn read(section: &mut Section<'_>) -> Self {
        let mut settings = GridCellsSettings::default();
        section.text("Topic", &mut settings.topic);
        section.bool("Unreliable", &mut settings.unreliable);
        section.count("Queue Size", 0, &mut settings.queue_size);
        section.color("Color", &mut settings.color);
        section.float("Alpha", 0.0..=1.0, &mut settings.alpha);
        settings
    }
}
