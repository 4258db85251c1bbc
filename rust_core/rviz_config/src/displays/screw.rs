//! `rviz/WrenchStamped`, `rviz/TwistStamped`, `rviz/AccelStamped`: an arrow for the linear part, an arrow and a circle
//! around it for the angular part.

use crate::section::{Section, ANY, MAX_HISTORY};

/// The properties of a display of screws. Opacity, scales and width have no bounds in rviz.
#[derive(Debug, Clone, PartialEq)]
pub struct ScrewSettings {
    /// Topic of the messages; empty when none is chosen.
    pub topic: String,
    /// How many messages may wait for their transform.
    pub queue_size: u32,
    /// Colour of the linear part (force), as red, green and blue.
    pub linear_color: [u8; 3],
    /// Colour of the angular part (torque), as red, green and blue.
    pub angular_color: [u8; 3],
    /// Opacity of all; 1 is opaque.
    pub alpha: f32,
    /// Metres of the linear arrow's shaft for each unit of the message.
    pub linear_scale: f32,
    /// Metres of the angular arrow's shaft for each unit of the message.
    pub angular_scale: f32,
    /// How thick arrows and circle are; a shaft's diameter is a tenth of it.
    pub width_m: f32,
    /// How many of the latest messages are shown, 1 to 100000.
    pub history_length: u32,
    /// Whether a part is left out that would be no longer than the width.
    pub hide_small_values: bool,
}

impl Default for ScrewSettings {
    fn default() -> Self {
        ScrewSettings {
            topic: String::new(),
            queue_size: 10,
            linear_color: [204, 51, 51],
            angular_color: [204, 204, 51],
            alpha: 1.0,
            linear_scale: 2.0,
            angular_scale: 2.0,
            width_m: 0.5,
            history_length: 1,
            hide_small_values: true,
        }
    }
}

impl ScrewSettings {
    /// Reads the properties of a wrench, whose parts are called Force and Torque.
    pub(crate) fn read_wrench(section: &mut Section<'_>) -> Self {
        Self::read(section, ["Force Color", "Force Arrow Scale"], ["Torque Color", "Torque Arrow Scale"])
    }

    /// Reads the properties of a motion, whose parts are called Linear and Angular.
    pub(crate) fn read_motion(section: &mut Section<'_>) -> Self {
        Self::read(section, ["Linear Color", "Linear Arrow Scale"], ["Angular Color", "Angular Arrow Scale"])
    }

    fn read(section: &mut Section<'_>, linear: [&str; 2], angular: [&str; 2]) -> Self {
        let mut settings = ScrewSettings::default();
        section.subscription(&mut settings.topic, 0, &mut settings.queue_size);
        let [color, scale] = linear;
        section.color(color, &mut settings.linear_color);
        section.float(scale, ANY, &mut settings.linear_scale);
        let [color, scale] = angular;
        section.color(color, &mut settings.angular_color);
        section.float(scale, ANY, &mut settings.angular_scale);
        section.float("Alpha", ANY, &mut settings.alpha);
        section.float("Arrow Width", ANY, &mut settings.width_m);
        section.count_in("History Length", 1..=MAX_HISTORY, &mut settings.history_length);
        section.bool("Hide Small Values", &mut settings.hide_small_values);
        settings
    }
}
