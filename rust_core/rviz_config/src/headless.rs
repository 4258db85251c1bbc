//! Drawing a config without rviz: differences between the node and rviz, and the command that starts the node.
//!
//! The launch file is the package's own `projection.launch`, with its additions to rviz's image switched off.

use crate::config::{Config, PlacedDisplay};
use crate::displays::{CameraPubSettings, DisplaySettings};
use crate::problems::camera_problems;

/// One line for each display or setting that the node does not draw as rviz does, in the words of `camera_stream
/// check`, without notes.
///
/// ```
/// let text = "
/// Visualization Manager:
///   Displays:
///   - {Class: rviz_camera_stream/CameraPub, Name: c, Enabled: true, Image Topic: /i, Camera Info Topic: /c}
///   - {Class: my_plugins/Robots, Name: robots, Enabled: true, Topic: /robots}
/// ";
/// let config = rcs_rviz_config::parse(text, "scene.rviz")?;
/// let report = rcs_rviz_config::headless::report(&config);
/// assert_eq!(report.len(), 1);
/// assert!(report[0].starts_with("line 5: Displays / robots: unknown class my_plugins/Robots"));
/// # Ok::<(), rcs_rviz_config::ConfigError>(())
/// ```
pub fn report(config: &Config) -> Vec<String> {
    let findings = config.findings.iter().filter(|finding| !finding.is_note);
    let mut lines: Vec<String> = camera_problems(config);
    lines.extend(findings.map(ToString::to_string));
    lines.extend(settings_not_followed(config));
    lines
}

/// The roslaunch command that draws the config as rviz does, without rviz: its images on their topics, and no window.
///
/// ```
/// let config = rcs_rviz_config::parse("Visualization Manager: {}", "/home/me/my scene.rviz")?;
/// assert_eq!(
///     rcs_rviz_config::headless::launch_line(&config),
///     "roslaunch rviz_camera_stream projection.launch 'rviz_config:=\"/home/me/my scene.rviz\"' projector:=none \
///      sample_scene:=false viewer:=none projection:=rviz undistort:=false stale_timeout:=none stale_timeouts:=none"
/// );
/// # Ok::<(), rcs_rviz_config::ConfigError>(())
/// ```
pub fn launch_line(config: &Config) -> String {
    // roslaunch splits the node's arguments as a shell does, after this shell has.
    let argument = for_shell(&format!("rviz_config:={}", for_roslaunch(&config.source)));
    let cameras = enabled_cameras(config);
    let projection = if cameras.iter().any(|(.., camera)| camera.is_exact) { "exact" } else { "rviz" };
    let undistort = cameras.iter().any(|(.., camera)| camera.undistort);
    format!(
        "roslaunch rviz_camera_stream projection.launch {argument} projector:=none sample_scene:=false viewer:=none \
         projection:={projection} undistort:={undistort} stale_timeout:=none stale_timeouts:=none"
    )
}

/// The cameras that publish, with their lines and paths.
fn enabled_cameras<'a>(config: &'a Config) -> Vec<(usize, String, &'a CameraPubSettings)> {
    let placed = config.placed_displays().into_iter().filter(|placed| placed.enabled);
    let camera = |placed: PlacedDisplay<'a>| match &placed.display.settings {
        DisplaySettings::CameraPub(settings) => Some((placed.display.line, placed.path.join(" / "), settings)),
        _ => None,
    };
    placed.filter_map(camera).collect()
}

/// Settings of the plugin's cameras that the node does not follow, a line each.
fn settings_not_followed(config: &Config) -> Vec<String> {
    let cameras = enabled_cameras(config);
    let mut lines = Vec::new();
    for (line, path, camera) in &cameras {
        let differs =
            |value: fn(&CameraPubSettings) -> bool| cameras.iter().any(|(.., other)| value(other)) != value(camera);
        if differs(|camera| camera.is_exact) || differs(|camera| camera.undistort) {
            lines.push(format!(
                "line {line}: {path}: Projection and Undistort are those of other cameras, because the node has one \
                 setting for all; start one node for each"
            ));
        }
        if !camera.depth_topic.is_empty() {
            lines.push(format!(
                "line {line}: {path} / Depth Topic: the node publishes depths on the topic depth in the namespace of the \
                 image topic; remap that to {}",
                camera.depth_topic
            ));
        }
    }
    lines
}

/// `true` for a word that needs no quotes.
fn is_plain(word: &str) -> bool {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "/._-:=+,@%~".contains(c);
    !word.is_empty() && word.chars().all(is_plain)
}

/// Quotes a word for roslaunch's splitting of arguments.
fn for_roslaunch(word: &str) -> String {
    if is_plain(word) {
        return word.to_owned();
    }
    let escaped: String =
        word.chars().flat_map(|c| "\\\"".contains(c).then_some('\\').into_iter().chain([c])).collect();
    format!("\"{escaped}\"")
}

/// Quotes a word for a POSIX shell.
fn for_shell(word: &str) -> String {
    if is_plain(word) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn config(cameras: &[&str]) -> Config {
        let camera = |(at, rest): (usize, &&str)| {
            format!(
                "  - {{Class: rviz_camera_stream/CameraPub, Name: c{at}, Enabled: true, Image Topic: /c{at}/i, \
                 Camera Info Topic: /c{at}/info{rest}}}\n"
            )
        };
        let cameras: String = cameras.iter().enumerate().map(camera).collect();
        crate::parse(&format!("Visualization Manager:\n  Displays:\n{cameras}"), "/a/b.rviz").unwrap()
    }

    #[test]
    fn a_config_of_the_old_plugin_needs_no_report() {
        let config = config(&["", ", Headless Twin: /tmp/twin.rviz, Projection: rviz, Undistort: false"]);
        assert_eq!(report(&config), Vec::<String>::new());
        let line = launch_line(&config);
        assert!(
            line.contains(" rviz_config:=/a/b.rviz ") && line.contains("projection:=rviz undistort:=false"),
            "{line}"
        );
    }

    #[test]
    fn what_the_plugin_does_is_asked_of_the_node() {
        let config = config(&[", Projection: exact", ", Projection: exact"]);
        assert_eq!(report(&config), Vec::<String>::new());
        assert!(launch_line(&config).contains("projection:=exact undistort:=false"));
        let config = self::config(&[", Undistort: true, Depth Topic: /depth", ""]);
        assert!(launch_line(&config).contains("projection:=rviz undistort:=true"));
        let found = report(&config);
        assert!(
            found[0].starts_with("line 3: c0 / Depth Topic: ") && found[0].ends_with("remap that to /depth"),
            "{found:?}"
        );
        assert!(found[1].starts_with("line 4: c1: Projection and Undistort are those of other cameras"), "{found:?}");
        assert_eq!(found.len(), 2);
    }

    #[test]
    fn a_path_is_one_word_to_the_shell_and_to_roslaunch() {
        for (path, expected) in [
            ("/a/b.rviz", "rviz_config:=/a/b.rviz"),
            ("/a b/$c.rviz", "'rviz_config:=\"/a b/$c.rviz\"'"),
            ("/it's", "'rviz_config:=\"/it'\\''s\"'"),
            ("/a\"b\\c", "'rviz_config:=\"/a\\\"b\\\\c\"'"),
            ("", "'rviz_config:=\"\"'"),
        ] {
            assert_eq!(for_shell(&format!("rviz_config:={}", for_roslaunch(path))), expected);
        }
    }
}
