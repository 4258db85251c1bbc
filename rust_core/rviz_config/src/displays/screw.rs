//! `rviz/WrenchStamped`, `rviz/TwistStamped`, `rviz/AccelStamped`: an arrow for the linear part, an arrow and a circle
//! around it for the angular part.

use crate::section::{Properties, Section, ANY, MAX_HISTORY};

properties! {
    /// The properties of a display of screws. Opacity, scales and width have no bounds in rviz.
    pub struct ScrewSettings {
        /// Topic of the messages; empty when none is chosen.
        topic: String = String::new() => topic("Topic");
        /// Most messages that wait for their transform.
        queue_size: u32 = 10 => count("Queue Size", 0);
        /// Colour of the linear part (force), as red, green and blue.
        linear_color: [u8; 3] = [204, 51, 51];
        /// Colour of the angular part (torque), as red, green and blue.
        angular_color: [u8; 3] = [204, 204, 51];
        /// Opacity of all; 1 is opaque.
        alpha: f32 = 1.0 => float("Alpha", ANY);
        /// Metres of the linear arrow's shaft for each unit of the message.
        linear_scale: f32 = 2.0;
        /// Metres of the angular arrow's shaft for each unit of the message.
        angular_scale: f32 = 2.0;
        /// Thickness of arrows and circle in metres; a shaft's diameter is a tenth of it.
        width_m: f32 = 0.5 => float("Arrow Width", ANY);
        /// Number of the latest messages that are drawn, 1 to 100,000.
        history_length: u32 = 1 => count_in("History Length", 1..=MAX_HISTORY);
        /// `true` to leave out a part that would be no longer than the width.
        hide_small_values: bool = true => bool("Hide Small Values");
    }
}

impl ScrewSettings {
    /// Reads the properties of a wrench, whose parts are called Force and Torque.
    pub(crate) fn read_wrench(section: &mut Section<'_>) -> Self {
        Self::read_parts(section, ["Force Color", "Force Arrow Scale"], ["Torque Color", "Torque Arrow Scale"])
    }

    /// Reads the properties of a motion, whose parts are called Linear and Angular.
    pub(crate) fn read_motion(section: &mut Section<'_>) -> Self {
        Self::read_parts(section, ["Linear Color", "Linear Arrow Scale"], ["Angular Color", "Angular Arrow Scale"])
    }

    fn read_parts(section: &mut Section<'_>, linear: [&str; 2], angular: [&str; 2]) -> Self {
        let mut settings = Self::read(section);
        section.color(linear[0], &mut settings.linear_color);
        section.float(linear[1], ANY, &mut settings.linear_scale);
        section.color(angular[0], &mut settings.angular_color);
        section.float(angular[1], ANY, &mut settings.angular_scale);
        settings
    }
}
