//! Heavy scenes and floods of messages: calls, signals and pictures go on, and memory is bounded.

use crate::diagnostics::MONITOR;
use rcs_tests::ros::{wait_until, PATIENCE};
use rcs_tests::ros_fixture::{config, CameraPub, RosFixture, CLOUD};
use std::fs;
use std::time::{Duration, Instant};

/// Half transparent, so that each of its squares is seen and has to be drawn.
const FILM: &str = "{Class: rviz/PointCloud2, Name: film, Enabled: true, Topic: /film, Style: Flat Squares, \
     Size (m): 4, Color Transformer: RGB8, Position Transformer: XYZ, Queue Size: 10, Alpha: 0.5, Decay Time: 0}";
const FRAMES: &str = "{Class: rviz/TF, Name: frames, Enabled: true, Frame Timeout: 2}";

/// Collects the node's diagnostics, and has a viewer that has seen the cloud.
fn watched(fixture: &RosFixture) {
    fixture.python("topic = '/diagnostics'");
    fixture.python(MONITOR);
    fixture.python("latch('/tf_static', tf('map', 'eye')); latch('/eye/camera_info', info())");
    fixture.python("latch('/cloud', cloud(0xff0000)); viewer = Viewer('/view/image')");
    fixture.wait_for("viewer.middle() == (255, 0, 0)");
}

/// A value of the node's process in `/proc`, such as `VmRSS` in kB.
fn of_process(fixture: &RosFixture, name: &str) -> u64 {
    let status = fs::read_to_string(format!("/proc/{}/status", fixture.node.id())).unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(':')).unwrap();
    line.split_whitespace().next().unwrap().parse().unwrap()
}

fn drawn(fixture: &RosFixture) -> u64 {
    fixture.python("values('camera_stream: CameraPub')['frames drawn']").parse().unwrap()
}

#[test]
fn calls_signals_and_pictures_go_on_while_a_picture_takes_long() {
    let mut fixture = RosFixture::start(&config(&[CLOUD, FILM], &[CameraPub::default()]), &[]).unwrap();
    watched(&fixture);
    fixture.python("from dynamic_reconfigure.client import Client; c = Client('/camera_stream/CameraPub', timeout=30)");
    // 700 half transparent squares of 67 million pixels each take many seconds.
    fixture.python("latch('/film', cloud(0x0000ff, points=[(0, 0, 1 + z / 1000) for z in range(700)]))");
    fixture.wait_for("viewer.middle() != (255, 0, 0)");
    fixture.python("latch('/eye/camera_info', info(width=8192, height=8192, f=9000.0))");
    fixture.wait_for("'drawing camera CameraPub' in (message('camera_stream: Scene') or '')");
    fixture.pictures_go_on(30, Duration::from_millis(200));
    assert_eq!(fixture.python("viewer.last.width"), "64", "the picture before");
    let timed = "def timed(call):\n    begun = time.time(); call(); return time.time() - begun";
    fixture.python(timed);
    for call in ["trigger('/camera_trigger')", "c.update_configuration({'near_clip': 0.02})"] {
        let secs: f64 = fixture.python(format!("timed(lambda: {call})")).parse().unwrap();
        println!("{call} is answered after {secs:.3} s");
        assert!(secs < 0.3, "{call}: {secs} s");
    }
    fixture.rewrite(&config(&[CLOUD], &[CameraPub::default()]));
    let answer = fixture.python("trigger('/camera_stream/reload_config')");
    let is_late = |text: &str| text.contains("applied after the picture") || text.contains("nothing changed");
    assert!(answer.starts_with("(True") && is_late(&answer), "{answer}");
    assert_eq!(fixture.python("viewer.last.width"), "64", "the long picture is still being drawn");
    let asked = Instant::now();
    fixture.node.signal("TERM");
    let status = fixture.node.wait(PATIENCE).unwrap();
    println!("ended after {:.2} s", asked.elapsed().as_secs_f64());
    assert!(status.success() && asked.elapsed() < Duration::from_secs(2), "{status} after {:?}", asked.elapsed());
}

#[test]
fn a_slow_picture_is_reported_with_the_display_that_costs_most() {
    let fixture = RosFixture::start(&config(&[CLOUD, FILM], &[CameraPub::default()]), &[]).unwrap();
    watched(&fixture);
    fixture.python("latch('/eye/camera_info', info(width=2048, height=2048, f=2200.0))");
    let slow = || fixture.log_lines(&["WARN", "camera CameraPub: a picture took", "s for display film"]);
    // As many squares as it takes.
    let is_reported = [200, 1000, 5000, 25_000].into_iter().any(|count| {
        let points = format!("[(0, 0, 1 + z / {count}) for z in range({count})]");
        fixture.python(format!("latch('/film', cloud(0x0000ff, points={points}))"));
        wait_until(Duration::from_secs(10), || slow() == 1)
    });
    assert!(is_reported, "{}", fixture.log());
    fixture.wait_for("'a picture took' in values('camera_stream: CameraPub').get('Speed', '')");
    println!("{}", fixture.python("values('camera_stream: CameraPub')['Speed']"));
}

#[test]
fn changes_that_a_camera_does_not_show_make_no_picture_and_others_no_more_than_the_global_rate() {
    let camera = |name, image, namespace| CameraPub { name, image, namespace, ..CameraPub::default() };
    let both = config(&[CLOUD, FRAMES], &[camera("CameraPub", "/view/image", ""), camera("All", "/all/image", "all")]);
    // The first camera does not show the frames.
    let text = both.replacen("Visibility: {Value: true}", "Visibility: {Value: true, frames: false}", 1);
    let fixture = RosFixture::start(&text, &[]).unwrap();
    watched(&fixture);
    fixture.python("all_shown = Viewer('/all/image')");
    fixture.python("moving = lambda i: tf('map', 'hand', xyz=(0, i * 1e-3, 2), stamp=rospy.Time.now())");
    fixture.python("repeated = PublishRepeatedly(100, moving, '/tf')");
    fixture.wait_for("len({i[6] for i in all_shown.images}) > 3");
    fixture.python("viewer.forget(); all_shown.forget(); arrays.clear()");
    fixture.wait_for("len(arrays) > 1");
    let before = drawn(&fixture);
    fixture.python("begun = time.time(); all_shown.forget()");
    fixture.wait_for("len(all_shown.images) > 120 and len(arrays) > 5");
    let rate: f64 = fixture.python("len(all_shown.images) / (time.time() - begun)").parse().unwrap();
    println!("{rate:.1} pictures a second of a scene that changes 100 times");
    assert!((25.0..31.0).contains(&rate), "{rate} pictures a second");
    assert_eq!(drawn(&fixture), before, "the camera that does not show the frames draws nothing");
}

#[test]
fn made_up_frames_are_bounded_and_forgotten() {
    let fixture = RosFixture::start(&config(&[CLOUD, FRAMES], &[CameraPub::default()]), &[]).unwrap();
    watched(&fixture);
    let before = of_process(&fixture, "VmRSS");
    fixture.python(
        "import itertools; numbers = itertools.count()\n\
         def made_up(i):\n    now = rospy.Time.now()\n    \
             return TFMessage([tf('map', 'box_%d' % next(numbers), xyz=(i % 7, i % 5, 90), stamp=now).transforms[0] \
             for _ in range(200)])\n\
         repeated = PublishRepeatedly(10, made_up, '/tf')",
    );
    fixture.wait_for("next(numbers) > 20000");
    fixture.python("repeated.stop()");
    let grown_kb = of_process(&fixture, "VmRSS").saturating_sub(before);
    println!("20,000 frames: {} MB more", grown_kb / 1024);
    assert!(grown_kb < 300 << 10, "{grown_kb} kB");
    assert_eq!(fixture.log_lines(&["WARN", "more than 1000 frames"]), 1, "{}", fixture.log());
    // The robot's own frames go on. Those that were made up are too old for the display after 2 s.
    fixture.python("moving = lambda i: tf('map', 'hand', xyz=(0, i * 1e-3, 2), stamp=rospy.Time.now())");
    fixture.python("repeated = PublishRepeatedly(30, moving, '/tf')");
    fixture.wait_for("values('camera_stream: CameraPub').get('size') == '64x48'");
    std::thread::sleep(Duration::from_secs(3));
    fixture.python("viewer.forget(); begun = time.time()");
    fixture.wait_for("len(viewer.images) > 60");
    let rate: f64 = fixture.python("len(viewer.images) / (time.time() - begun)").parse().unwrap();
    println!("{rate:.1} pictures a second afterwards");
    assert!(rate > 25.0, "{rate} pictures a second");
}

#[test]
fn each_cause_is_logged_once_a_second_with_a_count() {
    let markers = "{Class: rviz/MarkerArray, Name: markers, Enabled: true, Marker Topic: /markers}";
    let fixture = RosFixture::start(&config(&[CLOUD, markers], &[CameraPub::default()]), &[]).unwrap();
    watched(&fixture);
    let before = fixture.node.errors().len();
    fixture.python("from visualization_msgs.msg import Marker, MarkerArray");
    fixture.python("bad = [Marker(ns='bad', id=i, action=7) for i in range(3)]");
    fixture.python("for marker in bad: marker.header.frame_id = 'map'");
    fixture.python("begun = time.time(); repeated = PublishRepeatedly(100, lambda i: MarkerArray(bad), '/markers')");
    fixture.wait_for("time.time() > begun + 4");
    let secs: f64 = fixture.python("time.time() - begun").parse().unwrap();
    let lines = fixture.node.errors().split_off(before);
    println!("{} lines in {secs:.1} s of 300 bad markers a second", lines.len());
    assert!((lines.len() as f64) < 2.0 * secs + 6.0, "{}", fixture.log());
    let counted = || fixture.log_lines(&["there is no action 7", "more like this before"]);
    assert!(wait_until(PATIENCE, || counted() > 1), "{}", fixture.log());
}

#[test]
fn a_huge_picture_gives_its_memory_back() {
    let fixture = RosFixture::start(&config(&[CLOUD], &[CameraPub::default()]), &[]).unwrap();
    watched(&fixture);
    let before = of_process(&fixture, "VmRSS");
    fixture.python("latch('/eye/camera_info', info(width=8192, height=8192, f=9000.0))");
    fixture.wait_for("viewer.last.width == 8192");
    let huge = of_process(&fixture, "VmHWM");
    fixture.python("latch('/eye/camera_info', info())");
    fixture.wait_for("viewer.last.width == 64");
    fixture.pictures_go_on(10, Duration::from_millis(500));
    let is_small = || of_process(&fixture, "VmRSS") < before + (40 << 10);
    assert!(wait_until(PATIENCE, is_small), "{} kB, {before} kB before", of_process(&fixture, "VmRSS"));
    println!("{} MB, at most {} MB, then {} MB", before >> 10, huge >> 10, of_process(&fixture, "VmRSS") >> 10);
}
