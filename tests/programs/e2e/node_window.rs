//! `camera_stream --window`: a camera's image on a monitor, in the node's own process.

use std::process::Command;
use std::time::Duration;

use rcs_tests::python_node::PythonNode;
use rcs_tests::ros::{wait_until, PATIENCE};
use rcs_tests::ros_fixture::{CameraPub, RosFixture, Setup, CLOUD};

use crate::viewers::{saved, set_up, show_scene, Screen};

type Scenario = fn(&mut RosFixture, &mut Screen);

/// Nodes with a window: their arguments, and the scenarios of each one after the other, the last of which ends it.
const NODES: [(&[&str], &[Scenario]); 3] = [
    (
        &["--window", "auto"],
        &[
            the_window_shows_the_image_without_subscribers_and_the_topic_has_the_same,
            a_window_whose_display_server_hangs_is_logged,
            the_topics_go_on_when_the_x_server_dies_and_the_window_comes_back_with_it,
            |fixture, screen| the_node_ends_and_takes_its_window_away(fixture, screen, "TERM"),
        ],
    ),
    (
        &["_window:=0", "_set_mode:=false"],
        &[the_window_shows_the_image_without_subscribers_and_the_topic_has_the_same, |fixture, screen| {
            the_node_ends_and_takes_its_window_away(fixture, screen, "INT")
        }],
    ),
    (
        &["--window", "CameraPub=0"],
        &[
            the_window_shows_the_image_without_subscribers_and_the_topic_has_the_same,
            a_key_closes_the_window_and_the_topics_go_on,
        ],
    ),
];

#[test]
fn a_camera_has_a_window_in_its_node() {
    for (args, scenarios) in NODES {
        let mut screen = Screen::start();
        let mut fixture = set_up().args(args).on_screen(&screen.display).start();
        for scenario in scenarios {
            show_scene(&fixture);
            fixture.python("viewer = Viewer('/view/image')");
            assert!(wait_until(PATIENCE, || has_image(&screen)), "{args:?}: {}", fixture.log());
            scenario(&mut fixture, &mut screen);
        }
    }
}

/// Whether the screen shows the camera's image: its background, and the cloud.
fn has_image(screen: &Screen) -> bool {
    let pixels = screen.pixels();
    let count = |color: [u8; 3]| pixels.chunks_exact(3).filter(|pixel| *pixel == color).count();
    count([10, 20, 200]) > 100 && count([255, 128, 0]) > 100
}

fn the_window_shows_the_image_without_subscribers_and_the_topic_has_the_same(
    fixture: &mut RosFixture,
    screen: &mut Screen,
) {
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

fn the_node_ends_and_takes_its_window_away(fixture: &mut RosFixture, screen: &Screen, signal: &str) {
    assert_eq!(fixture.node.end(signal).unwrap().code(), Some(0), "{}", fixture.log());
    assert!(wait_until(PATIENCE, || !has_image(screen)));
}

fn the_topics_go_on_when_the_x_server_dies_and_the_window_comes_back_with_it(
    fixture: &mut RosFixture,
    screen: &mut Screen,
) {
    screen.kill();
    fixture.wait_for_log("the window is lost: X server").unwrap();
    fixture.images_go_on(30);
    screen.restart();
    assert!(wait_until(PATIENCE, || has_image(screen)), "{}", fixture.log());
    assert!(fixture.log().lines().all(|line| !line.contains("XIO")), "{}", fixture.log());
}

fn a_window_whose_display_server_hangs_is_logged(fixture: &mut RosFixture, screen: &mut Screen) {
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
    assert!(wait_until(PATIENCE, || has_image(screen)), "{}", fixture.log());
}

fn a_key_closes_the_window_and_the_topics_go_on(fixture: &mut RosFixture, screen: &mut Screen) {
    let closes = || {
        screen.press("q");
        fixture.log_lines(&["the window was closed; the topics go on"]) == 1
    };
    assert!(wait_until(PATIENCE, closes), "{}", fixture.log());
    fixture.images_go_on(30);
}

#[test]
fn the_window_turns_black_when_data_stop_and_keeps_what_is_current() {
    let screen = Screen::start();
    // Images are drawn only when triggered, so the window hears of none for long.
    let setup = Setup::with_cameras(&[CLOUD], &[CameraPub { rate: "0", ..CameraPub::default() }]);
    let args = ["--window", "auto", "--stale-timeout", "1", "--stale-timeouts", "/cloud=held"];
    let fixture = setup.args(&args).on_screen(&screen.display).start();
    fixture.python("place_camera(width=640, height=360, f=300)");
    let publisher = PythonNode::start(&fixture.master, &["__name:=publisher"]).unwrap();
    publisher.run("latch('/cloud', cloud(0xff0000))").unwrap();
    let has_cloud = || screen.pixels().chunks_exact(3).any(|pixel| pixel == [255, 0, 0]);
    let is_triggered = || fixture.python("trigger('/camera_trigger')[0]") == "True" && has_cloud();
    assert!(wait_until(PATIENCE, is_triggered), "{}", fixture.log());
    std::thread::sleep(Duration::from_millis(2500));
    assert!(has_cloud(), "{}", fixture.log());
    drop(publisher);
    assert!(wait_until(PATIENCE, || is_black(&screen)), "{}", fixture.log());
}

#[test]
fn a_window_that_cannot_open_is_tried_again_and_the_topics_go_on() {
    let screen = Screen::start();
    let fixture = set_up().args(&["--window", "CameraPub=HDMI-9"]).on_screen(&screen.display).start();
    show_scene(&fixture);
    fixture.wait_for_log("no monitor 'HDMI-9'; monitors: 0: screen 640x360+0+0").unwrap();
    fixture.python("viewer = Viewer('/view/image')");
    fixture.images_go_on(30);
    let status = Command::new("xrandr")
        .args(["--setmonitor", "HDMI-9", "640/160x360/90+0+0", "none"])
        .env("DISPLAY", &screen.display)
        .status();
    assert!(status.unwrap().success());
    assert!(wait_until(PATIENCE, || has_image(&screen)), "{}", fixture.log());
    assert_eq!(fixture.log_lines(&["no monitor 'HDMI-9'"]), 1, "{}", fixture.log());
}

#[test]
fn a_window_for_no_camera_is_one_line() {
    let camera = |name, image| CameraPub { name, image, ..CameraPub::default() };
    let cameras = [camera("Left", "/left/image"), camera("Right", "/right/image")];
    let mut fixture = Setup::with_cameras(&[], &cameras).args(&["--window", "auto"]).launch();
    assert_eq!(fixture.node.wait(PATIENCE).and_then(|status| status.code()), Some(1), "{}", fixture.log());
    let expected = "]: window: name one of the cameras, CAMERA=MONITOR; cameras: Left, Right";
    assert!(fixture.log().contains(expected), "{}", fixture.log());
}

/// A node with a window, its camera, and `points` of a wall that fills the view.
fn wall(screen: &Screen, args: &[&str]) -> RosFixture {
    let fixture = Setup::of(&[CLOUD]).args(&["--window", "auto"]).args(args).on_screen(&screen.display).start();
    fixture.python("place_camera(width=640, height=360, f=300)");
    fixture.python("points = [(x / 2, y / 2, 2) for x in range(-6, 7) for y in range(-4, 5)]");
    fixture
}

fn level_at(screen: &Screen, [u, v]: [usize; 2]) -> [u8; 3] {
    let pixels = screen.pixels();
    let at = 3 * (640 * v + u);
    [pixels[at], pixels[at + 1], pixels[at + 2]]
}

fn is_black(screen: &Screen) -> bool {
    screen.pixels().iter().all(|level| *level == 0)
}

const RED: [u8; 3] = [255, 0, 0];
const BLUE: [u8; 3] = [0, 0, 255];

#[test]
fn data_that_go_stale_beat_a_pause_and_do_not_end_a_test_image() {
    let screen = Screen::start();
    let fixture = wall(&screen, &["--stale-timeout", "1"]);
    let publisher = PythonNode::start(&fixture.master, &["__name:=publisher"]).unwrap();
    publisher.run("points = [(x / 2, y / 2, 2) for x in range(-6, 7) for y in range(-4, 5)]").unwrap();
    publisher.run("color = [0xff0000]").unwrap();
    publisher
        .run("PublishRepeatedly(20, lambda i: cloud(color[0], points=points, stamp=rospy.Time.now()), '/cloud')")
        .unwrap();
    assert!(wait_until(PATIENCE, || level_at(&screen, [320, 180]) == RED), "{}", fixture.log());
    screen.press_until_logged(&fixture, "p", "pause on by key p");
    publisher.run("color[0] = 0x0000ff").unwrap();
    std::thread::sleep(Duration::from_millis(1500));
    assert_eq!(level_at(&screen, [320, 180]), RED, "it is paused while data are current");
    drop(publisher);
    assert!(wait_until(PATIENCE, || is_black(&screen)), "{}", fixture.log());
    screen.press_until_logged(&fixture, "t", "test picture ");
    assert!(wait_until(PATIENCE, || !is_black(&screen)), "one can focus without data");
    std::thread::sleep(Duration::from_millis(1500));
    assert!(!is_black(&screen));
}

#[test]
fn keep_out_frames_and_their_absence_beat_pauses_and_test_images() {
    let screen = Screen::start();
    let fixture = wall(&screen, &["--keep-out", "head=0.2"]);
    let tracker = PythonNode::start(&fixture.master, &["__name:=tracker"]).unwrap();
    tracker.run("x = [0.5]").unwrap();
    tracker
        .run("PublishRepeatedly(20, lambda i: tf('map', 'head', (x[0], 0, 1), stamp=rospy.Time.now()), '/tf')")
        .unwrap();
    fixture.python("latch('/cloud', cloud(0xff0000, points=points))");
    // At 1 m, half a metre is 150 pixels.
    let (right, left, above) = ([470, 180], [170, 180], [320, 30]);
    let sees = |expected: [[u8; 3]; 3]| [right, left, above].map(|at| level_at(&screen, at)) == expected;
    assert!(wait_until(PATIENCE, || sees([[0; 3], RED, RED])), "{}", fixture.log());
    screen.press_until_logged(&fixture, "p", "pause on by key p");
    fixture.python("latch('/cloud', cloud(0x0000ff, points=points))");
    tracker.run("x[0] = -0.5").unwrap();
    assert!(wait_until(PATIENCE, || sees([RED, [0; 3], RED])), "the scene is held, and the head is masked where it is");
    // The test image has light there.
    screen.press_until_logged(&fixture, "t", "test picture ");
    let black_pixels = |half: usize| {
        let pixels = screen.pixels();
        let near = |index: usize| {
            let (u, v) = ((index % 640) as i64, (index / 640) as i64);
            (u - if half == 0 { 170 } else { 470 }).pow(2) + (v - 180).pow(2) < 55 * 55
        };
        let inside = pixels.chunks_exact(3).enumerate().filter(|(index, _)| near(*index));
        let lit = inside.filter(|(_, pixel)| pixel.iter().any(|level| *level > 0)).count();
        (lit, pixels.iter().any(|level| *level > 0))
    };
    assert!(wait_until(PATIENCE, || black_pixels(0) == (0, true) && black_pixels(1).0 > 0), "{}", fixture.log());
    tracker.run("x[0] = 0.5").unwrap();
    assert!(wait_until(PATIENCE, || black_pixels(1) == (0, true) && black_pixels(0).0 > 0), "{}", fixture.log());
    drop(tracker);
    assert!(wait_until(PATIENCE, || is_black(&screen)), "nobody knows where the head is: {}", fixture.log());
    screen.press_until_logged(&fixture, "p", "pause off by key p");
    std::thread::sleep(Duration::from_millis(500));
    assert!(is_black(&screen));
}

#[test]
fn a_mask_that_closes_beats_a_pause() {
    let screen = Screen::start();
    let fixture = wall(&screen, &["--mask-topic", "/mask"]);
    fixture.python("latch('/cloud', cloud(0xff0000, points=points))");
    fixture.python("level = [255]");
    fixture.python(
        "def mask():\n    m = Image(width=2, height=1, step=2, encoding='mono8', data=bytes([255, level[0]]))\n    \
         m.header.stamp = rospy.Time.now()\n    return m",
    );
    fixture.python("PublishRepeatedly(20, lambda i: mask(), '/mask')");
    let sees = |expected: [[u8; 3]; 2]| [[160, 180], [480, 180]].map(|at| level_at(&screen, at)) == expected;
    assert!(wait_until(PATIENCE, || sees([RED, RED])), "{}", fixture.log());
    screen.press_until_logged(&fixture, "space", "pause on by key p");
    fixture.python("latch('/cloud', cloud(0x0000ff, points=points)); level[0] = 0");
    assert!(wait_until(PATIENCE, || sees([RED, [0; 3]])), "{}", fixture.log());
    fixture.python("level[0] = 255");
    assert!(wait_until(PATIENCE, || sees([RED, RED])), "{}", fixture.log());
    screen.press_until_logged(&fixture, "space", "pause off by key p");
    assert!(wait_until(PATIENCE, || sees([BLUE, BLUE])), "{}", fixture.log());
}
