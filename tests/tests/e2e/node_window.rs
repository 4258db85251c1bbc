//! `camera_stream --window`: a camera's picture on a monitor, in the node's own process.

use std::time::Duration;

use rcs_tests::python_node::PythonNode;
use rcs_tests::ros::{wait_until, RosMaster, PATIENCE};
use rcs_tests::ros_fixture::{config, CameraPub, RosFixture, CLOUD};

use crate::viewers::{fixture_with, saved, Screen};

/// A node with a window on this screen.
fn start(screen: &Screen, args: &[&str]) -> RosFixture {
    fixture_with(args, &[("DISPLAY", &screen.display), ("WAYLAND_DISPLAY", ""), ("WAYLAND_SOCKET", "")])
}

/// Whether the screen shows the camera's picture: its background, and the cloud.
fn has_picture(screen: &Screen) -> bool {
    let pixels = screen.pixels();
    let count = |color: [u8; 3]| pixels.chunks_exact(3).filter(|pixel| *pixel == color).count();
    count([10, 20, 200]) > 100 && count([255, 128, 0]) > 100
}

#[test]
fn the_window_shows_the_picture_without_subscribers_and_the_topic_has_the_same() {
    for args in [["--window", "auto"], ["_window:=0", "_set_mode:=false"], ["--window", "CameraPub=0"]] {
        let screen = Screen::start();
        let fixture = start(&screen, &args);
        assert!(wait_until(PATIENCE, || has_picture(&screen)), "{args:?}: {}", fixture.log());
        fixture.python("viewer = Viewer('/view/image')");
        fixture.wait_for("viewer.last is not None");
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("picture");
        let is_same = || saved(&fixture.python, &file) == screen.pixels();
        assert!(wait_until(PATIENCE, is_same), "each pixel is the topic's: {}", fixture.log());
        // Without a subscriber again, a change is on the screen.
        fixture.python("viewer.close()");
        fixture.python("latch('/cloud', cloud(0xff00ff, points=[(x / 3 - 1, 0, 3 + x / 9) for x in range(9)]))");
        let has_change = || screen.pixels().chunks_exact(3).any(|pixel| pixel == [255, 0, 255]);
        assert!(wait_until(PATIENCE, has_change), "{}", fixture.log());
    }
}

#[test]
fn the_window_turns_black_when_data_stop_and_keeps_what_is_current() {
    let screen = Screen::start();
    // Pictures are drawn only when triggered, so the window hears of none for long.
    let config = config(&[CLOUD], &[CameraPub { rate: "0", ..CameraPub::default() }]);
    let (master, environment) = (RosMaster::start().unwrap(), [("DISPLAY", screen.display.as_str())]);
    let python = PythonNode::start(&master, &[]).unwrap();
    let args = ["--window", "auto", "--stale-timeout", "1", "--stale-timeout", "/cloud=held"];
    let fixture = RosFixture::with_environment(master, python, &config, &args, &environment).unwrap();
    fixture.wait_for_log("drawing ").unwrap();
    fixture.python("latch('/tf_static', tf('map', 'eye'))");
    fixture.python("latch('/eye/camera_info', info(width=640, height=360, f=300))");
    let publisher = PythonNode::start(&fixture.master, &["__name:=publisher"]).unwrap();
    publisher.run("latch('/cloud', cloud(0xff0000))").unwrap();
    let has_cloud = || screen.pixels().chunks_exact(3).any(|pixel| pixel == [255, 0, 0]);
    let is_triggered = || fixture.python("trigger('/camera_trigger')[0]") == "True" && has_cloud();
    assert!(wait_until(PATIENCE, is_triggered), "{}", fixture.log());
    std::thread::sleep(Duration::from_millis(2500));
    assert!(has_cloud(), "{}", fixture.log());
    drop(publisher);
    assert!(wait_until(PATIENCE, || screen.pixels().iter().all(|level| *level == 0)), "{}", fixture.log());
}

#[test]
fn the_node_ends_and_takes_its_window_away() {
    for signal in ["TERM", "INT"] {
        let screen = Screen::start();
        let mut fixture = start(&screen, &["--window", "auto"]);
        assert!(wait_until(PATIENCE, || has_picture(&screen)), "{}", fixture.log());
        assert_eq!(fixture.node.end(signal).unwrap().code(), Some(0), "{}", fixture.log());
        assert!(wait_until(PATIENCE, || !has_picture(&screen)));
    }
}

#[test]
fn the_topics_go_on_when_the_x_server_dies_and_the_window_comes_back_with_it() {
    let mut screen = Screen::start();
    let fixture = start(&screen, &["--window", "auto"]);
    fixture.python("viewer = Viewer('/view/image')");
    assert!(wait_until(PATIENCE, || has_picture(&screen)), "{}", fixture.log());
    screen.kill();
    fixture.wait_for_log("the window is lost: X server").unwrap();
    fixture.pictures_go_on(30);
    screen.restart();
    assert!(wait_until(PATIENCE, || has_picture(&screen)), "{}", fixture.log());
    assert!(fixture.log().lines().all(|line| !line.contains("XIO")), "{}", fixture.log());
}

#[test]
fn a_window_whose_display_server_hangs_is_logged() {
    let screen = Screen::start();
    let fixture = start(&screen, &["--window", "auto"]);
    assert!(wait_until(PATIENCE, || has_picture(&screen)), "{}", fixture.log());
    screen.signal("STOP");
    let mut color = 0;
    let mut is_logged = || {
        color += 1;
        fixture.python(format!("latch('/cloud', cloud({color}))"));
        std::thread::sleep(Duration::from_millis(100));
        fixture.log().contains("showing a picture in the window of ")
    };
    assert!(wait_until(PATIENCE, &mut is_logged), "{}", fixture.log());
    assert!(fixture.log().contains(" s so far; the display server may not answer"), "{}", fixture.log());
    screen.signal("CONT");
    fixture.python("latch('/cloud', cloud(0xff8000))");
    assert!(wait_until(PATIENCE, || has_picture(&screen)), "{}", fixture.log());
}

#[test]
fn a_window_that_cannot_open_is_tried_again_and_the_topics_go_on() {
    let screen = Screen::start();
    let fixture = start(&screen, &["--window", "CameraPub=HDMI-9"]);
    fixture.wait_for_log("there is no monitor 'HDMI-9'; there are: 0: screen 640x360+0+0").unwrap();
    fixture.python("viewer = Viewer('/view/image')");
    fixture.pictures_go_on(30);
    let status = std::process::Command::new("xrandr")
        .args(["--setmonitor", "HDMI-9", "640/160x360/90+0+0", "none"])
        .env("DISPLAY", &screen.display)
        .status();
    assert!(status.unwrap().success());
    assert!(wait_until(PATIENCE, || has_picture(&screen)), "{}", fixture.log());
    assert_eq!(fixture.log_lines(&["there is no monitor"]), 1, "{}", fixture.log());
}

#[test]
fn a_key_closes_the_window_and_the_topics_go_on() {
    let screen = Screen::start();
    let fixture = start(&screen, &["--window", "auto"]);
    fixture.python("viewer = Viewer('/view/image')");
    assert!(wait_until(PATIENCE, || has_picture(&screen)), "{}", fixture.log());
    let closes = || {
        screen.press("q");
        fixture.log_lines(&["the window was closed; the topics go on"]) == 1
    };
    assert!(wait_until(PATIENCE, closes), "{}", fixture.log());
    fixture.pictures_go_on(30);
}

#[test]
fn a_window_for_no_camera_is_one_line() {
    let mut fixture = {
        let master = RosMaster::start().unwrap();
        let python = PythonNode::start(&master, &[]).unwrap();
        let camera = |name, image| CameraPub { name, image, ..CameraPub::default() };
        let cameras = [camera("Left", "/left/image"), camera("Right", "/right/image")];
        let config = config(&[], &cameras);
        RosFixture::with(master, python, &config, &["--window", "auto"]).unwrap()
    };
    assert_eq!(fixture.node.wait(PATIENCE).and_then(|status| status.code()), Some(1), "{}", fixture.log());
    let expected = "]: --window: which camera? Give CAMERA=MONITOR; there are: Left, Right";
    assert!(fixture.log().contains(expected), "{}", fixture.log());
}
