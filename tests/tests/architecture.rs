//! Dependencies between the project's crates point downwards only.

use std::collections::BTreeSet;
use std::path::Path;

/// The crates from the bottom up, each with the outside crates that would give it a task that is not its own.
const LAYERS: [(&str, &[&str]); 12] = [
    ("scene", &["rosrust", "rosrust_msg", "rosbag", "wgpu", "winit"]),
    ("transforms", &["rosrust", "rosrust_msg", "rosbag", "wgpu", "winit"]),
    ("messages", &["rosbag", "wgpu", "winit"]),
    ("rviz_config", &["rosrust", "rosrust_msg", "rosbag", "wgpu", "winit"]),
    ("resources", &["rosrust", "rosrust_msg", "rosbag", "wgpu", "winit"]),
    ("displays", &["rosrust", "rosbag", "wgpu", "winit"]),
    ("render", &["rosrust", "rosrust_msg", "rosbag", "winit"]),
    ("files", &["rosrust", "rosbag", "wgpu", "winit"]),
    ("bag", &["rosrust", "wgpu", "winit"]),
    ("ros", &["rosbag", "wgpu", "winit"]),
    ("window", &["rosrust", "rosrust_msg", "rosbag", "wgpu"]),
    ("app", &["wgpu", "winit", "rosbag"]),
];

/// What may not be used although it is lower: the renderers know no messages, the displays no renderers, and so on.
const APART: [(&str, &[&str]); 6] = [
    ("rviz_config", &["scene", "transforms", "messages"]),
    ("render", &["transforms", "messages", "rviz_config", "resources", "displays"]),
    ("files", &["transforms", "rviz_config", "resources", "displays", "render"]),
    ("bag", &["scene", "transforms", "rviz_config", "resources", "displays", "render", "files"]),
    ("ros", &["scene", "transforms", "rviz_config", "resources", "displays", "render", "files", "bag"]),
    ("window", &["messages", "transforms", "rviz_config", "resources", "displays", "render", "bag", "ros"]),
];

/// The names of a crate's dependencies, its tests' not among them.
fn dependencies(name: &str) -> BTreeSet<String> {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR"));
    let manifest = tests.join("../rust_core").join(name).join("Cargo.toml");
    let text = std::fs::read_to_string(&manifest).unwrap_or_else(|error| panic!("{}: {error}", manifest.display()));
    let mut section = "";
    let mut found = BTreeSet::new();
    for line in text.lines() {
        if line.starts_with('[') {
            section = line;
        } else if section.ends_with("dependencies]") && !section.contains("dev-") {
            found.extend(line.split(['.', ' ', '=']).next().filter(|name| !name.is_empty()).map(str::to_owned));
        }
    }
    found
}

#[test]
fn dependencies_point_downwards_only() {
    for (level, (name, foreign)) in LAYERS.iter().enumerate() {
        let dependencies = dependencies(name);
        assert!(!dependencies.is_empty(), "{name} has no dependencies: is its manifest read?");
        let above: Vec<String> = LAYERS[level..].iter().map(|(above, _)| format!("rcs_{above}")).collect();
        for wrong in above.iter().map(String::as_str).chain(foreign.iter().copied()) {
            assert!(!dependencies.contains(wrong), "{name} depends on {wrong}");
        }
    }
    for (name, apart) in APART {
        let dependencies = dependencies(name);
        for wrong in apart {
            assert!(!dependencies.contains(&format!("rcs_{wrong}")), "{name} depends on rcs_{wrong}");
        }
    }
}

#[test]
fn every_folder_of_the_core_is_a_layer() {
    let core = Path::new(env!("CARGO_MANIFEST_DIR")).join("../rust_core");
    let folders: BTreeSet<String> = std::fs::read_dir(&core)
        .expect("rust_core is there")
        .filter_map(|entry| entry.ok().filter(|entry| entry.path().is_dir())?.file_name().into_string().ok())
        .collect();
    let layers: BTreeSet<String> = LAYERS.iter().map(|(name, _)| (*name).to_owned()).collect();
    assert_eq!(folders, layers);
}
