//! The command `./demo`: it shows the sample scene and leaves no process behind however it ends.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;
use std::time::Duration;

use rcs_tests::programs::repository;
use rcs_tests::ros::{wait_until, Running, PATIENCE};
use rcs_tests::ros_fixture::{Setup, CLOUD};

use crate::files::pixels;
use crate::{bash, bash_command, printed_by, processors, succeed};

/// Processes that have this in their environment.
fn processes_with(environment: &str) -> Vec<String> {
    let mut found = Vec::new();
    for entry in fs::read_dir("/proc").unwrap().filter_map(Result::ok) {
        // A process may end meanwhile, and those of other users cannot be read.
        let Ok(variables) = fs::read(entry.path().join("environ")) else { continue };
        if String::from_utf8_lossy(&variables).split('\0').any(|variable| variable == environment) {
            let command = fs::read(entry.path().join("cmdline")).unwrap_or_default();
            found.push(String::from_utf8_lossy(&command).replace('\0', " "));
        }
    }
    found
}

fn master_of(printed: &str) -> String {
    let line = printed.lines().find_map(|line| line.strip_prefix("master: "));
    format!("ROS_MASTER_URI={}", line.unwrap_or_else(|| panic!("no master: {printed}")))
}

/// Runs the demo to its end. Returns the image that it saved and what it printed.
fn show(folder: &Path, arguments: &str) -> (PathBuf, String) {
    let _processors = processors();
    let file = folder.join("shown.png");
    let printed = succeed(&format!("./demo --seconds 1 --renderer cpu --output {} {arguments}", file.display()));
    assert_eq!(printed.lines().last(), file.to_str(), "{printed}");
    assert_eq!(processes_with(&master_of(&printed)), Vec::<String>::new());
    (file, printed)
}

#[test]
fn the_projector_shows_what_the_bag_shows_pixel_for_pixel() {
    let folder = tempfile::tempdir().unwrap();
    // Twice: the first run leaves nothing that hinders the second.
    for _ in 0..2 {
        let (shown, printed) = show(folder.path(), "");
        assert!(pixels(&shown) == pixels(&repository().join("docs/images/demo.png")), "{printed}");
        for measured in ["picture: 1280x800 rgb8 on /proj_view/image, ", "latency: "] {
            assert!(printed.contains(measured), "{printed}");
        }
    }
}

#[test]
fn image_view_shows_the_scene_though_not_pixel_for_pixel() {
    let folder = tempfile::tempdir().unwrap();
    let (shown, printed) = show(folder.path(), "--viewer image_view");
    let (width, height, shown) = pixels(&shown);
    assert_eq!((width, height), (1280, 800));
    let (_, _, published) = pixels(&repository().join("docs/images/demo.png"));
    // The object to grasp and the path, which nothing else on the screen resembles.
    for colour in [[115, 210, 22], [0, 0, 255]] {
        let count = |pixels: &[u8]| pixels.chunks_exact(3).filter(|pixel| *pixel == colour).count() as f64;
        let share = count(&shown) / count(&published);
        assert!((0.5..1.0).contains(&share), "{colour:?}: {share} of what was published; {printed}");
    }
}

#[test]
fn the_papers_turret_lights_the_object_to_grasp() {
    let folder = tempfile::tempdir().unwrap();
    let (shown, printed) = show(folder.path(), "--paper");
    let (width, height, pixels) = pixels(&shown);
    assert_eq!((width, height), (2560, 800), "{printed}");
    assert!(printed.contains("picture: 1280x800 rgb8 on /proj_view/image, "), "{printed}");
    assert!(!printed.contains("latency: "), "of a cloud that the scene replaces: {printed}");
    // Green in the spectator's half, and in the middle of the projector's.
    let is_green = |u: usize, v: usize| pixels[(v * 2560 + u) * 3..][..3] == [115, 210, 22];
    assert!((0..800).any(|v| (0..1280).any(|u| is_green(u, v))), "{printed}");
    assert!((380..420).any(|v| (1820..2020).any(|u| is_green(u, v))), "{printed}");
}

#[test]
fn a_hand_in_the_light_is_lit_only_without_a_surface() {
    let folder = tempfile::tempdir().unwrap();
    let (shown, printed) = show(folder.path(), "--confirm");
    let (width, height, pixels) = pixels(&shown);
    assert_eq!((width, height), (2560, 800), "{printed}");
    // Skin in white light, in each half; white objects remain in both.
    let count = |color: [u8; 3], columns: std::ops::Range<usize>| {
        let rows = pixels.chunks_exact(2560 * 3);
        rows.flat_map(|row| row[3 * columns.start..3 * columns.end].chunks_exact(3))
            .filter(|pixel| *pixel == color)
            .count()
    };
    let [left, right] = [0..1280, 1280..2560].map(|half| count([216, 158, 127], half));
    assert!(left > 5000 && right * 100 < left, "{left} and {right} pixels; {printed}");
    let [left, right] = [0..1280, 1280..2560].map(|half| count([216, 216, 216], half));
    assert!(right * 4 > left && left > 50_000, "{left} and {right} pixels; {printed}");
}

#[test]
fn the_latency_of_clouds_that_another_node_replaces_is_not_measured() {
    let fixture = Setup::of(&[CLOUD]).start();
    fixture.python("place_camera(width=640, height=480, f=500.0)");
    fixture.python(
        "edge = cloud(0xff0000, points=[(0, 0.3, 1)]); repeated = PublishRepeatedly(20, lambda i: edge, '/cloud')",
    );
    let measure = "scripts/measure --image /view/image --cloud /cloud --seconds 0.5 --clouds 4";
    let measure = || bash(&format!("ROS_MASTER_URI={} {measure}", fixture.master.uri()));
    let output = measure();
    let printed = printed_by(&output);
    assert!(!output.status.success() && !printed.contains("latency: "), "{printed}");
    let reason = printed.lines().last().unwrap();
    assert!(reason.starts_with("measure: /") && reason.ends_with(" publishes clouds on /cloud, too"), "{printed}");
    // A latched cloud is replaced by no other.
    fixture.python("repeated.stop(); repeated.out.unregister(); publishers.clear(); latch('/cloud', edge)");
    let printed = printed_by(&measure());
    assert!(printed.contains("latency: ") && printed.ends_with("(4 clouds)\n"), "{printed}");
}

/// Interrupts the demo once it has printed `when`.
fn interrupt(when: &str, signal: &str, status: i32) {
    // A process group of its own, as a terminal gives it, with Ctrl-C in effect.
    let script = "exec python3 -c 'import os, signal, sys
os.setsid(); signal.signal(signal.SIGINT, signal.SIG_DFL); os.execv(sys.argv[1], sys.argv[1:])' ./demo --seconds 3";
    let mut demo = Running::start(&mut bash_command(script)).unwrap();
    // The demo may have to wait for another build.
    let seen = wait_until(Duration::from_secs(600), || demo.count(when) > 0 || demo.wait(Duration::ZERO).is_some());
    let printed = demo.lines().join("\n");
    assert!(seen && demo.count(when) > 0, "{printed}\n{}", demo.errors().join("\n"));
    succeed(&format!("kill -{signal} -- -{}", demo.id()));
    let ended = demo.wait(PATIENCE);
    assert_eq!(ended.and_then(|ended| ended.code()), Some(status), "{printed}");
    assert_eq!(processes_with(&master_of(&printed)), Vec::<String>::new());
}

#[test]
fn ctrl_c_leaves_no_process_behind() {
    interrupt("master: ", "INT", 130);
    interrupt("screen: ", "INT", 130);
    interrupt("viewer: ", "INT", 130);
    interrupt("viewer: ", "TERM", 143);
}

/// A run that fails: its status and its last line on standard error.
fn failure(script: &str) -> (Option<i32>, String) {
    let output: Output = bash(script);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success(), "{}", printed_by(&output));
    (output.status.code(), errors.lines().last().unwrap_or_default().to_owned())
}

#[test]
fn unusable_arguments_are_reported() {
    for (arguments, word) in [
        ("--viewer mirror", "--viewer mirror: must be projector_window or image_view"),
        ("--renderer voodoo", "--renderer voodoo: must be auto, cpu or gpu"),
        ("--seconds soon", "--seconds soon: must be a number"),
        ("--output", "--output needs a value"),
        ("--fast", "unknown option '--fast'"),
        ("--paper --offline", "--paper excludes --offline and --calibrate"),
        ("--paper --confirm", "--confirm excludes --offline, --calibrate and --paper"),
    ] {
        let (status, line) = failure(&format!("./demo {arguments}"));
        assert_eq!(status, Some(2), "{arguments}");
        assert!(line.starts_with("demo: ") && line.contains(word), "{line}");
    }
}

#[test]
fn a_part_that_fails_is_named_with_its_log() {
    // A roscore that dies at once: it imports this module instead of its own.
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("roslaunch.py"), "raise SystemExit('the disk is full')\n").unwrap();
    let (status, line) = failure(&format!("PYTHONPATH={} ./demo", folder.path().display()));
    assert_eq!(status, Some(1));
    assert!(line.contains("roscore ended: the disk is full (log: "), "{line}");
    let log = line.split("(log: ").nth(1).and_then(|rest| rest.strip_suffix(')')).unwrap();
    assert!(fs::read_to_string(log).unwrap().contains("the disk is full"));
    fs::remove_dir_all(Path::new(log).parent().unwrap()).unwrap();
}
