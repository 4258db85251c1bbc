//! `camera_stream check`: which parts of a config are understood and drawn.

pub mod live;
mod node_name;

use std::io::{self, Write};

use rcs_rviz_config::{Config, Role};

/// Prints each display and each finding; `fixed_frame` overrides the config's. Returns whether all was understood.
///
/// # Errors
/// When the output cannot be written.
pub fn print(config: &Config, fixed_frame: Option<&str>, out: &mut dyn Write) -> io::Result<bool> {
    writeln!(out, "{}: fixed frame {}", config.source, fixed_frame.unwrap_or(&config.global.fixed_frame))?;
    for placed in config.placed_displays() {
        let display = placed.display;
        let drawn = match (display.settings.role(), placed.enabled) {
            (_, false) => "disabled",
            (Role::Camera, _) => "camera",
            (Role::Group, _) => "group",
            (Role::Window, _) => "window only",
            (Role::Unknown, _) => "not drawn: unknown class",
            (Role::Scene, _) => "drawn",
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
    Ok(config.findings.is_empty())
}
