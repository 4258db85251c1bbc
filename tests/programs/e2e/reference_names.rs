//! The topics and services that `docs/reference/nodes.md` lists for a node are those that the master has of it.

use std::collections::BTreeSet;
use std::fs;
use std::time::Duration;

use rcs_tests::programs::repository;
use rcs_tests::python_node::PythonNode;
use rcs_tests::ros::{wait_until, RosMaster, Running, PATIENCE};
use rcs_tests::ros_fixture::{config, CameraPub, CLOUD};

/// Python that lists what the master has of a node, without what all nodes have.
const NAMES_OF: &str = "
import rosgraph
def names_of(node):
    kinds = zip(('publishes', 'subscribes', 'service'), rosgraph.Master('/reference').getSystemState())
    names = {word + ' ' + name for word, kind in kinds for name, nodes in kind if node in nodes}
    everybody = {'publishes /rosout', 'service ' + node + '/get_loggers', 'service ' + node + '/set_logger_level'}
    return sorted(names - everybody)
";

/// Names of a node on the page, as `publishes /topic`, with names in place of the placeholders.
fn listed(node: &str, names: &[(&str, &str)]) -> BTreeSet<String> {
    let page = fs::read_to_string(repository().join("docs/reference/nodes.md")).unwrap();
    let section = page.split(&format!("\n## `{node}`\n")).nth(1).unwrap().split("\n## ").next().unwrap().to_owned();
    let mut found = BTreeSet::new();
    for line in section.lines() {
        let cells: Vec<&str> = line.split('|').collect();
        let usage = cells.get(1).copied().unwrap_or_default();
        if !["publishes", "subscribes", "service", "settings"].contains(&usage) {
            continue;
        }
        for name in cells[2].split(", ").map(|name| name.trim_matches('`')) {
            let name = names.iter().find(|(placeholder, _)| *placeholder == name).map_or(name, |(_, name)| name);
            let name = name.replace('~', &format!("/{node}/"));
            let name = name.trim_end_matches('/');
            if usage == "settings" {
                // What dynamic_reconfigure's servers have.
                found.insert(format!("publishes {name}/parameter_descriptions"));
                found.insert(format!("publishes {name}/parameter_updates"));
                found.insert(format!("service {name}/set_parameters"));
            } else {
                found.insert(format!("{usage} {name}"));
            }
        }
    }
    found
}

/// Runs a node once with each line of arguments, until the master has what the page lists, and compares both. `names`
/// are those that take the place of the page's placeholders, and `before` is Python that runs first.
fn check(node: &str, lines: &[&[&str]], names: &[(&str, &str)], before: &str) {
    let (master, listed) = (RosMaster::start().unwrap(), listed(node, names));
    let python = PythonNode::start(&master, &[]).unwrap();
    python.run(NAMES_OF).unwrap();
    python.run(before).unwrap();
    let advertised = || -> BTreeSet<String> {
        let names = python.run(format!("'\\n'.join(names_of('/{node}'))")).unwrap();
        names.lines().map(str::to_owned).collect()
    };
    let mut seen = BTreeSet::new();
    let mut running: Vec<Running> = Vec::new();
    for (index, arguments) in lines.iter().enumerate() {
        drop(running.pop());
        let mut command = master.program(node);
        running.push(Running::start(command.args(*arguments)).unwrap());
        let is_last = index + 1 == lines.len();
        let (mut last, mut unchanged) = (BTreeSet::new(), 0);
        wait_until(PATIENCE, || {
            let now = advertised();
            seen.extend(now.iter().cloned());
            unchanged = if now.is_empty() || now != last { 0 } else { unchanged + 1 };
            last = now;
            std::thread::sleep(Duration::from_millis(500));
            // Of a line that is followed by another, the names are complete when none comes any more.
            listed.is_subset(&seen) || (!is_last && unchanged >= 4)
        });
    }
    let log: Vec<String> = running.iter().flat_map(Running::errors).collect();
    assert_eq!(seen, listed, "{node}: what the master has, and what docs/reference/nodes.md lists\n{}", log.join("\n"));
}

#[test]
fn small_nodes_advertise_what_their_reference_lists() {
    let file = |path: &str| repository().join(path).display().to_string();
    check("projector", &[&[&file("config/projector.yaml")]], &[], "");
    check("publish_cloud", &[&[&file("config/demo/clusters.pcd")]], &[("cloud", "/cloud")], "");
    check("nav_path_markers", &[&[]], &[], "");
}

#[test]
fn nodes_with_a_target_advertise_what_their_reference_lists() {
    let target = ["--target-cloud", "/cup"];
    check("line_of_sight", &[&target], &[("TARGET", "/cup")], "");
    let trajectory = [&target[..], &["--command", "trajectory"]].concat();
    check("turret_aim", &[&target, &trajectory], &[("TARGET", "/cup")], "");
}

#[test]
fn camera_stream_advertises_what_its_reference_lists() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.rviz").display().to_string();
    let camera = CameraPub { namespace: "view", ..CameraPub::default() };
    fs::write(&file, config(&[CLOUD], &[camera])).unwrap();
    let masks = ["--mask-topic", "/mask", "--surface", "/surface/image"];
    let arguments = [&["-d", &file, "--renderer", "cpu", "--orientation", "90"], &masks[..]].concat();
    let names = [
        ("IMAGE", "/view/image"),
        ("IMAGE/compressed", "/view/image/compressed"),
        ("camera_info beside IMAGE", "/view/camera_info"),
        ("depth beside IMAGE", "/view/depth"),
        ("shown beside IMAGE", "/view/shown"),
        ("confirmed beside IMAGE", "/view/confirmed"),
        ("INFO", "/eye/camera_info"),
        ("MASK", "/mask"),
        ("SURFACE", "/surface/image"),
        ("camera_info beside SURFACE", "/surface/camera_info"),
        ("topics of the displays", "/cloud"),
        ("NAMESPACE/camera_trigger", "/view/camera_trigger"),
        ("~CAMERA", "/camera_stream/CameraPub"),
    ];
    // The frame of turned images is published with the first of them.
    let before = "place_camera(); viewer = Viewer('/view/image')
latch('/surface/image', Image())";
    check("camera_stream", &[&arguments], &names, before);
}
