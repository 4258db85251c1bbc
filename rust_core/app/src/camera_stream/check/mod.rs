//! `camera_stream check`: which parts of a config are understood and drawn.

mod cameras;
pub mod live;
mod node_name;
mod table;

use std::io::{self, Write};

use rcs_rviz_config::{Config, PlacedDisplay, Role};

/// Prints each display, what keeps the cameras from publishing, and each finding; `fixed_frame` overrides the config's.
/// Returns whether all is well: notes, which change no picture, do not matter.
///
/// # Errors
/// When the output cannot be written.
pub fn print(config: &Config, fixed_frame: Option<&str>, out: &mut dyn Write) -> io::Result<bool> {
    writeln!(out, "{}: fixed frame {}", config.source, fixed_frame.unwrap_or(&config.global.fixed_frame))?;
    let row = |placed: &PlacedDisplay<'_>| {
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
        let (line, path) = (format!("line {:>4}", display.line), placed.path.join(" / "));
        [line, class.to_owned(), drawn.to_owned(), path, display.topic().unwrap_or_default().to_owned()]
    };
    let rows: Vec<[String; 5]> = config.placed_displays().iter().map(row).collect();
    table::print(&rows, "  ", out)?;
    print_findings(config, out)
}

/// Prints what keeps the cameras from publishing, and each finding. Returns whether there is nothing but notes.
fn print_findings(config: &Config, out: &mut dyn Write) -> io::Result<bool> {
    let problems = cameras::problems(config);
    for problem in &problems {
        writeln!(out, "{}: {problem}", config.source)?;
    }
    for finding in &config.findings {
        writeln!(out, "{}: {finding}", config.source)?;
    }
    Ok(problems.is_empty() && config.findings.iter().all(|finding| finding.is_note))
}
