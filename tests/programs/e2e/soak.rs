//! `./soak`, for half a minute: it holds, it notices what is wrong, and it ends with everything that it started.

use rcs_tests::programs::{program, repository};
use rcs_tests::ros::{wait_until, Running, PATIENCE};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

/// Longer than any gap on a slow machine that does something else, too.
const GAP_LIMIT_SECS: &str = "20";
/// Image checks wait for frames to disappear and for slow machines.
const LIMIT: Duration = Duration::from_secs(1500);

fn soak(report: &Path, hours: &str, more: &[&str]) -> Running {
    let mut command = Command::new(repository().join("soak"));
    command.arg("--programs").arg(program("camera_stream").parent().unwrap()).arg("--report").arg(report);
    Running::start(command.args(["--hours", hours, "--gap-limit", GAP_LIMIT_SECS]).args(more)).unwrap()
}

/// What the run printed, and the end of its report.
fn printed(soak: &Running, report: &Path) -> String {
    let page = fs::read_to_string(report.join("report.md")).unwrap_or_default();
    [soak.lines().join("\n"), soak.errors().join("\n"), page].join("\n---\n")
}

#[test]
fn half_a_minute_of_faults_costs_neither_images_nor_connections() {
    let folder = tempfile::tempdir().unwrap();
    let report = folder.path().join("report");
    let mut soak = soak(&report, "0.008", &["--seed", "11"]);
    let status = soak.wait(LIMIT);
    assert!(status.is_some_and(|status| status.success()), "{status:?}: {}", printed(&soak, &report));
    let page = fs::read_to_string(report.join("report.md")).unwrap();
    assert!(page.contains("everything held") && page.contains(" 0 different"), "{page}");
    assert!(report.join("faults.log").is_file());
    println!("{}", soak.lines().join("\n"));
}

/// The processes that a process has started, by the beginning of their names.
fn children(parent: u32, name: &str) -> Vec<PathBuf> {
    let processes = fs::read_dir("/proc").unwrap().flatten().map(|entry| entry.path());
    let is_child = |process: &PathBuf| {
        let stat = fs::read_to_string(process.join("stat")).unwrap_or_default();
        let parent = format!(" {parent} ");
        stat.contains(&format!("({name}")) && stat.rsplit(')').next().is_some_and(|rest| rest[2..].starts_with(&parent))
    };
    processes.filter(is_child).collect()
}

#[test]
#[ignore = "a soak: ./test full"]
fn images_that_stop_are_found_and_an_interrupted_run_leaves_a_report_and_no_process() {
    let folder = tempfile::tempdir().unwrap();
    let report = folder.path().join("report");
    let mut soak = soak(&report, "1", &["--seed", "1", "--only", "viewer_slow"]);
    let has_printed = |text: &str| soak.count(text) > 0;
    let is_checked = || has_printed("picture check 1: equal");
    assert!(wait_until(LIMIT, is_checked), "{}", printed(&soak, &report));
    let started = [children(soak.id(), "camera_stream"), children(soak.id(), "python3")].concat();
    assert_eq!(children(soak.id(), "camera_stream").len(), 1);
    assert!(started.len() >= 5, "the node, its viewers, three publishers: {started:?}");
    let node = started[0].file_name().unwrap().to_owned();
    let signal = |name: &str| assert!(Command::new("kill").arg(name).arg(&node).status().unwrap().success());
    signal("-STOP");
    let is_found = wait_until(PATIENCE, || has_printed("no picture since "));
    signal("-CONT");
    assert!(is_found, "{}", printed(&soak, &report));
    assert!(wait_until(PATIENCE, || has_printed("no picture for ")), "{}", printed(&soak, &report));
    soak.signal("INT");
    let status = soak.wait(LIMIT).unwrap();
    assert_eq!(status.code(), Some(130), "{}", printed(&soak, &report));
    assert!(fs::read_to_string(report.join("report.md")).unwrap().contains("no picture for "));
    let left: Vec<_> = started.iter().filter(|process| process.exists()).collect();
    assert!(left.is_empty(), "{left:?}");
}
