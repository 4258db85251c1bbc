//! Which cases there are and how near each must be.

use std::path::{Path, PathBuf};

/// A scene and the picture that rviz drew of it.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    pub(crate) name: String,
    pub(crate) folder: PathBuf,
    /// The lowest *close* score.
    pub(crate) min_close: f64,
    /// The camera to draw, where the config has several.
    pub(crate) camera: Option<String>,
    /// ROS parameters as `NAME=FILE`.
    pub(crate) params: Vec<String>,
}

/// A picture may differ in this share of its content: single pixels of rasterisation that lie farther than one away.
const MIN_CLOSE: f64 = 0.98;

/// Text may: glyphs may be rasterised differently, but not stand elsewhere or in another size or colour.
const MIN_CLOSE_TEXT: f64 = 0.90;

/// The cases whose picture is text, besides those that say so in their names.
const TEXT: [&str; 2] = ["tf_default", "interactive_marker"];

/// The repository's root.
pub(crate) fn repository() -> PathBuf {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR"));
    tests.parent().unwrap_or(tests).to_owned()
}

/// The folder with the cases, and with the package `conformance_assets`.
pub(crate) fn conformance() -> PathBuf {
    repository().join("tests/conformance")
}

/// All cases by name. Those that begin with `x_`, `y_` or `z_` were drawn by the same rviz for this project, to see more
/// values than the others do.
pub(crate) fn all() -> Vec<Case> {
    let folders = std::fs::read_dir(conformance().join("cases")).into_iter().flatten().flatten();
    let mut cases: Vec<Case> = folders
        .filter_map(|entry| {
            let name = entry.file_name().into_string().ok()?;
            let is_text = name.contains("text") || TEXT.contains(&name.as_str());
            let min_close = if is_text { MIN_CLOSE_TEXT } else { MIN_CLOSE };
            Some(Case {
                camera: camera(&entry.path()),
                params: params(&entry.path()),
                folder: entry.path(),
                min_close,
                name,
            })
        })
        .collect();
    cases.sort_by(|a, b| a.name.cmp(&b.name));
    assert!(!cases.is_empty(), "there are no cases below {}", conformance().display());
    cases
}

/// The parameters that `case.yaml` names: the indented lines below `params:`.
fn params(folder: &Path) -> Vec<String> {
    let about = std::fs::read_to_string(folder.join("case.yaml")).unwrap_or_default();
    let below = about.lines().skip_while(|line| *line != "params:").skip(1);
    let entries = below.map_while(|line| line.strip_prefix("  ")?.split_once(": "));
    entries.map(|(name, file)| format!("{name}={}", file.trim())).collect()
}

/// The camera that `case.yaml` names.
fn camera(folder: &Path) -> Option<String> {
    let about = std::fs::read_to_string(folder.join("case.yaml")).ok()?;
    about.lines().find_map(|line| Some(line.strip_prefix("camera: ")?.trim().to_owned()))
}
