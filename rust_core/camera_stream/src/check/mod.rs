//! `camera_stream check`: the parts of a config that are understood and drawn.

pub(crate) mod live;
pub(crate) mod observed;
pub(crate) mod session;
mod table;

use std::io::{self, Write};

use rcs_rviz_config::{camera_problems, setting_problems, Config, PlacedDisplay, Role};

/// Prints each display, each problem and each finding; `fixed_frame` overrides the config's.
/// Returns `true` if there are no problems: notes, which change no image, do not matter.
///
/// # Errors
/// The output cannot be written. A closed pipe, as of `head`, is no error.
pub(crate) fn print(config: &Config, fixed_frame: Option<&str>, out: &mut dyn Write) -> io::Result<bool> {
    match print_all(config, fixed_frame, out) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(true),
        result => result,
    }
}

fn print_all(config: &Config, fixed_frame: Option<&str>, out: &mut dyn Write) -> io::Result<bool> {
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

/// Prints problems of cameras and settings, and each finding. Returns `true` if there are only notes.
fn print_findings(config: &Config, out: &mut dyn Write) -> io::Result<bool> {
    let problems = problems(config);
    for (problem, _) in &problems {
        writeln!(out, "{}: {problem}", config.source)?;
    }
    Ok(problems.iter().all(|(_, is_note)| *is_note))
}

/// Problems of cameras and settings and findings of a config, each with `true` for a note, which changes no image.
pub(crate) fn problems(config: &Config) -> Vec<(String, bool)> {
    let cameras = camera_problems(config).into_iter().map(|problem| (problem.to_string(), false));
    let settings = setting_problems(config).into_iter().map(|problem| (problem.to_string(), problem.is_note));
    let findings = config.findings.iter().map(|finding| (finding.to_string(), finding.is_note));
    cameras.chain(settings).chain(findings).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_display_of_another_package_is_reported_with_its_plugin_and_the_ways_out() {
        let text = "Visualization Manager:\n  Displays:\n  \
                    - {Class: rviz_camera_stream/CameraPub, Name: c, Enabled: true, Image Topic: /i, Camera Info Topic: /c}\n  \
                    - {Class: octomap_rviz_plugin/OccupancyGrid, Name: map, Enabled: true, Octomap Topic: /octomap}\n";
        let config = rcs_rviz_config::parse(text, "a.rviz").unwrap();
        let mut out = Vec::new();
        assert!(!print(&config, None, &mut out).unwrap(), "something is wrong");
        let out = String::from_utf8(out).unwrap();
        assert!(out.contains("octomap_rviz_plugin/OccupancyGrid  not drawn: unknown class  map"), "{out}");
        let last = out.lines().last().unwrap_or_default();
        assert!(last.starts_with(
            "a.rviz: line 4: Displays / map: unknown class octomap_rviz_plugin/OccupancyGrid, which needs a plugin of the \
             package octomap_rviz_plugins (it shows /octomap): draw it in rviz with the CameraPub plugin, or show \
             octomap_server's occupied_cells_vis_array (rviz/MarkerArray)"
        ), "{last}");
        // It is a note, which changes no image, where it is disabled.
        let config =
            rcs_rviz_config::parse(&text.replace("map, Enabled: true", "map, Enabled: false"), "a.rviz").unwrap();
        assert!(print(&config, None, &mut Vec::new()).unwrap());
    }
}
