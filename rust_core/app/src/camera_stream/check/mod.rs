//! `camera_stream check`: which parts of a config are understood and drawn.

pub mod live;
mod node_name;

use std::io::{self, Write};

use rcs_rviz_config::{Config, DisplaySettings};

/// Prints each display and each finding; `fixed_frame` overrides the config's. Returns whether all was understood.
///
/// # Errors
/// When the output cannot be written.
pub fn print(config: &Config, fixed_frame: Option<&str>, out: &mut dyn Write) -> io::Result<bool> {
    writeln!(out, "{}: fixed frame {}", config.source, fixed_frame.unwrap_or(&config.global.fixed_frame))?;
    for placed in config.placed_displays() {
        let display = placed.display;
        let drawn = match (&display.settings, placed.enabled) {
            (_, false) => "disabled",
            (DisplaySettings::CameraPub(_), _) => "camera",
            (DisplaySettings::Group(_), _) => "group",
            (DisplaySettings::Image(_) | DisplaySettings::Camera(_), _) => "window only",
            (DisplaySettings::NotDrawn { known: true, .. }, _) => "not drawn yet",
            (DisplaySettings::NotDrawn { known: false, .. }, _) => "not drawn: unknown class",
            _ => "drawn",
        };
        let class = if display.class.is_empty() { "(no class)" } else { &display.class };
        write!(out, "  line {:>4}  {:<28}  {:<14}  {}", display.line, class, drawn, placed.path.join(" / "))?;
        match display.topic() {
            Some(topic) => writeln!(out, "  {topic}")?,
            None => writeln!(out)?,
        }
    }
    for finding in &config.findings {
        writeln!(out, "{}: {finding}", config.source)?;
    }
    Ok(!config.findings.iter().any(rcs_rviz_config::Finding::is_not_understood))
}
