//! The dead-man's switch of the node's window and of the projector's window: the projector becomes black also when the
//! program hangs or is killed.

use std::fs;
use std::os::unix::process::CommandExt;
use std::process::Command;
use std::time::{Duration, Instant};

use rcs_tests::ros::{wait_until, Running, PATIENCE};
use rcs_tests::ros_fixture::{master_and_python, RosFixture};

use crate::viewers::{set_up, show_scene, Screen};

/// The darkest level of a lit pixel here.
const LIT: u8 = 10;

fn is_black(screen: &Screen) -> bool {
    screen.pixels().iter().all(|level| *level < LIT)
}

/// A node whose window shows a scene without an age, on a white desktop.
fn start(screen: &Screen) -> RosFixture {
    let white = Command::new("xsetroot").args(["-solid", "white", "-display", &screen.display]).status().unwrap();
    assert!(white.success());
    let fixture = set_up().args(&["--window", "auto"]).on_screen(&screen.display).start();
    show_scene(&fixture);
    assert!(wait_until(PATIENCE, || has_image(screen)), "{}", fixture.log());
    fixture
}

fn has_image(screen: &Screen) -> bool {
    screen.pixels().chunks_exact(3).filter(|pixel| *pixel == [255, 128, 0]).count() > 100
}

/// The black window's process of a program.
fn child_of(program: &Running) -> Option<u32> {
    let parent = program.id().to_string();
    let output = Command::new("pgrep").args(["-P", &parent, "black-window"]).output().unwrap();
    String::from_utf8(output.stdout).unwrap().trim().parse().ok()
}

fn is_running(pid: u32) -> bool {
    fs::read_to_string(format!("/proc/{pid}/comm")).is_ok_and(|name| name.trim() == "black-window")
}

#[test]
fn a_stopped_node_is_covered_by_black_until_it_goes_on() {
    let screen = Screen::start();
    let fixture = start(&screen);
    fixture.node.signal("STOP");
    assert!(wait_until(PATIENCE, || is_black(&screen)), "{}", fixture.log());
    fixture.node.signal("CONT");
    assert!(wait_until(PATIENCE, || has_image(&screen)), "{}", fixture.log());
    // The window still has the keyboard.
    screen.press_until_logged(&fixture, "b", "by key b");
}

#[test]
fn a_killed_node_leaves_black_not_the_desktop() {
    let screen = Screen::start();
    let fixture = start(&screen);
    let child = child_of(&fixture.node).unwrap();
    fixture.node.signal("KILL");
    assert!(wait_until(PATIENCE, || !has_image(&screen)), "{}", fixture.log());
    let mut died: Option<Instant> = None;
    while died.is_none_or(|at| at.elapsed() < Duration::from_secs(2)) {
        assert!(is_black(&screen), "{}", fixture.log());
        died = died.or_else(|| fixture.log().contains("the program has died: black until").then(Instant::now));
    }
    let is_closed = || {
        screen.press("Escape");
        !is_running(child)
    };
    assert!(wait_until(PATIENCE, is_closed), "{}", fixture.log());
    assert!(wait_until(PATIENCE, || !is_black(&screen)));
}

#[test]
fn a_node_that_ends_takes_its_black_window_away() {
    for signal in ["TERM", "INT"] {
        let screen = Screen::start();
        let mut fixture = start(&screen);
        let child = child_of(&fixture.node).unwrap();
        assert_eq!(fixture.node.end(signal).unwrap().code(), Some(0), "{}", fixture.log());
        assert!(wait_until(PATIENCE, || !is_running(child) && !is_black(&screen)), "{}", fixture.log());
        assert!(!fixture.log().contains("black"), "{}", fixture.log());
    }
}

#[test]
fn ctrl_c_ends_the_projectors_window_and_its_black_one() {
    let screen = Screen::start();
    let (master, _python) =
        master_and_python("latch('/image', Image(width=1, height=1, encoding='mono8', step=1, data=b'x'))");
    let mut command = master.program("projector_window");
    command.env("DISPLAY", &screen.display).env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    let mut window = Running::start(command.arg("image:=/image").process_group(0)).unwrap();
    assert!(wait_until(PATIENCE, || screen.pixels()[0] == b'x'), "{:?}", window.errors());
    let child = child_of(&window).unwrap();
    let group = format!("-{}", window.id());
    assert!(Command::new("kill").args(["-INT", "--", &group]).status().unwrap().success());
    assert_eq!(window.wait(PATIENCE).and_then(|status| status.code()), Some(0), "{:?}", window.errors());
    assert!(wait_until(PATIENCE, || !is_running(child)), "{:?}", window.errors());
}
