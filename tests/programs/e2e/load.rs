//! Heavy scenes and floods of messages: calls, signals and images go on, and memory is bounded.

use rcs_tests::ros::{wait_until, PATIENCE};
use rcs_tests::ros_fixture::{config, CameraPub, RosFixture, Setup, CLOUD};
use std::fs;
use std::time::{Duration, Instant};

use crate::frame_rate::at_most;

/// Half transparent, so that each of its squares is seen and has to be drawn.
pub(crate) const FILM: &str =
    "{Class: rviz/PointCloud2, Name: film, Enabled: true, Topic: /film, Style: Flat Squares, \
     Size (m): 4, Color Transformer: RGB8, Position Transformer: XYZ, Queue Size: 10, Alpha: 0.5, Decay Time: 0}";
const FRAMES: &str = "{Class: rviz/TF, Name: frames, Enabled: true, Frame Timeout: 2}";

/// Collects the node's diagnostics, and has a viewer that has seen the cloud.
pub(crate) fn watched(fixture: &RosFixture) {
    fixture.python("monitor()");
    fixture.python("place_camera()");
    fixture.python("latch('/cloud', cloud(0xff0000)); viewer = Viewer('/view/image')");
    fixture.wait_for("viewer.middle() == (255, 0, 0)");
}

/// Python that makes messages of many things.
pub(crate) const LOAD: &str = include_str!("load.py");

/// A value of the node's process in `/proc`, such as `VmRSS` in kB.
pub(crate) fn of_process(fixture: &RosFixture, name: &str) -> u64 {
    let status = fs::read_to_string(format!("/proc/{}/status", fixture.node.id())).unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(':')).unwrap();
    line.split_whitespace().next().unwrap().parse().unwrap()
}

/// Sends messages of two places in turn, which are written only once.
pub(crate) fn in_turn(rate_hz: u32, topic: &str, make: &str, count: usize) -> String {
    format!(
        "repeated = globals().get('repeated', []) + [PublishRepeatedly({rate_hz}, \
             lambda i, both=[written({make}({count}, shift)) for shift in (0, 0.03)]: both[i % 2], '{topic}')]"
    )
}

pub(crate) fn drawn(fixture: &RosFixture) -> u64 {
    fixture.python("values('camera_stream: CameraPub')['frames drawn']").parse().unwrap()
}

#[test]
fn calls_signals_and_images_go_on_while_a_image_takes_long() {
    let mut fixture = Setup::of(&[CLOUD, FILM]).start();
    watched(&fixture);
    fixture
        .python("from dynamic_reconfigure.client import Client; c = Client('/camera_stream/CameraPub', timeout=300)");
    // 20,000 half transparent squares of 67 million pixels each take minutes.
    fixture.python("latch('/film', cloud(0x0000ff, points=[(0, 0, 1 + z / 20000) for z in range(20000)]))");
    fixture.wait_for("viewer.middle() != (255, 0, 0)");
    fixture.python("latch('/eye/camera_info', info(width=8192, height=8192, f=9000.0))");
    fixture.wait_for("'drawing camera CameraPub' in (message('camera_stream: Scene') or '')");
    fixture.images_go_on(30);
    for call in ["trigger('/camera_trigger')", "c.update_configuration({'near_clip': 0.02})"] {
        let asked = Instant::now();
        fixture.python(call);
        println!("{call} is answered after {:.3?}", asked.elapsed());
    }
    fixture.rewrite(&config(&[CLOUD], &[CameraPub::default()]));
    let answer = fixture.python("trigger('/camera_stream/reload_config')");
    let is_late = |text: &str| text.contains("applied after the picture") || text.contains("nothing changed");
    assert!(answer.starts_with("(True") && is_late(&answer), "{answer}");
    assert_eq!(fixture.python("viewer.last.width"), "64", "the long picture is still being drawn");
    let status = fixture.node.end("TERM").unwrap();
    assert!(status.success(), "{status}");
}

#[test]
fn a_slow_image_is_reported_with_the_display_that_costs_most() {
    let fixture = Setup::of(&[CLOUD, FILM]).start();
    watched(&fixture);
    fixture.python("latch('/eye/camera_info', info(width=2048, height=2048, f=2200.0))");
    let slow = || fixture.log_lines(&["WARN", "camera CameraPub: a picture took", "s for display film"]);
    // As many squares as it takes, of one colour after the other.
    let is_reported = [(300, 2), (1500, 1), (7500, 2), (37_500, 1)].into_iter().any(|(count, channel)| {
        let points = format!("[(0, 0, 1 + z / {count}) for z in range({count})]");
        fixture.python(format!("latch('/film', cloud(0xff0000 >> 8 * {channel}, points={points}))"));
        fixture.wait_for(format!("viewer.middle()[{channel}] > 200"));
        wait_until(Duration::from_secs(1), || slow() > 0)
    });
    assert!(is_reported, "{}", fixture.log());
    fixture.wait_for("'a picture took' in values('camera_stream: CameraPub').get('Speed', '')");
    println!("{}", fixture.python("values('camera_stream: CameraPub')['Speed']"));
}

#[test]
fn changes_that_a_camera_does_not_show_make_no_image_and_others_no_more_than_the_global_rate() {
    let camera = |name, image, namespace| CameraPub { name, image, namespace, ..CameraPub::default() };
    let both = config(&[CLOUD, FRAMES], &[camera("CameraPub", "/view/image", ""), camera("All", "/all/image", "all")]);
    // The first camera does not show the frames.
    let text = both.replacen("Visibility: {Value: true}", "Visibility: {Value: true, frames: false}", 1);
    let fixture = Setup::with_config(text).start();
    watched(&fixture);
    fixture.python("all_shown = Viewer('/all/image')");
    fixture.python("moving = lambda i: tf('map', 'hand', xyz=(0, i * 1e-3, 2), stamp=rospy.Time.now())");
    for changes_hz in [100, 300] {
        fixture.python(format!("all_shown.forget(); repeated = PublishRepeatedly({changes_hz}, moving, '/tf')"));
        fixture.wait_for("len({i[6] for i in all_shown.images}) > 3");
        fixture.python("viewer.forget(); all_shown.forget(); arrays.clear()");
        fixture.wait_for("len(arrays) > 1");
        let before = drawn(&fixture);
        fixture.python("all_shown.forget()");
        fixture.wait_for("len(all_shown.images) > 120 and len(arrays) > 5");
        at_most(&fixture, "all_shown", 30.0);
        assert_eq!(drawn(&fixture), before, "the camera that does not show the frames draws nothing");
        fixture.python("repeated.stop()");
    }
}

#[test]
fn made_up_frames_are_bounded_and_the_robots_go_on() {
    let fixture = Setup::of(&[CLOUD, FRAMES]).start();
    watched(&fixture);
    fixture.python("moving = lambda i: tf('map', 'hand', xyz=(0, i * 1e-3, 2), stamp=rospy.Time.now())");
    fixture.python("repeated = PublishRepeatedly(30, moving, '/tf')");
    fixture.images_go_on(60);
    fixture.python("repeated.stop()");
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
    assert_eq!(fixture.log_lines(&["WARN", "beyond the limit of 5000 frames"]), 1, "{}", fixture.log());
    // The robot's own frames go on. Those that were made up are too old for the display after 2 s.
    fixture.python("repeated = PublishRepeatedly(30, moving, '/tf')");
    fixture.wait_for("values('camera_stream: CameraPub').get('size') == '64x48'");
    std::thread::sleep(Duration::from_secs(3));
    fixture.images_go_on(60);
    print_rate(&fixture, "afterwards");
}

#[test]
fn each_cause_is_logged_once_a_second_with_a_count() {
    let markers = "{Class: rviz/MarkerArray, Name: markers, Enabled: true, Marker Topic: /markers}";
    let fixture = Setup::of(&[CLOUD, markers]).start();
    watched(&fixture);
    let before = fixture.node.errors().len();
    fixture.python("from visualization_msgs.msg import Marker, MarkerArray");
    fixture.python("bad = [Marker(ns='bad', id=i, action=7) for i in range(3)]");
    fixture.python("for marker in bad: marker.header.frame_id = 'map'");
    fixture.python("begun = time.time(); repeated = PublishRepeatedly(100, lambda i: MarkerArray(bad), '/markers')");
    fixture.wait_for("time.time() > begun + 4");
    let lines = fixture.node.errors().split_off(before);
    let secs: f64 = fixture.python("time.time() - begun").parse().unwrap();
    println!("{} lines in {secs:.1} s of 300 bad markers a second", lines.len());
    assert!((lines.len() as f64) < 2.0 * secs + 6.0, "{}", fixture.log());
    let counted = |text: &str| fixture.log_lines(&[text, "more like this before"]);
    assert!(wait_until(PATIENCE, || counted("unknown action 7") > 1), "{}", fixture.log());
    // Each marker with a status of its own.
    fixture.python("repeated.stop()");
    fixture.python(
        "import itertools; numbers = itertools.count()\n\
         def lost(i):\n    number = next(numbers)\n    marker = Marker(ns='made_up_%d' % number, id=number, type=1)\n    \
             marker.header.frame_id = 'lost'\n    marker.scale.x = marker.scale.y = marker.scale.z = marker.color.a = 1\n    \
             return MarkerArray([marker])",
    );
    let before = fixture.node.errors().len();
    fixture.python("begun = time.time(); repeated = PublishRepeatedly(100, lost, '/markers')");
    fixture.wait_for("time.time() > begun + 6");
    let lines = fixture.node.errors().split_off(before);
    let secs: f64 = fixture.python("time.time() - begun").parse().unwrap();
    println!("{} lines in {secs:.1} s of 100 made-up markers a second in a missing frame", lines.len());
    assert!((lines.len() as f64) < 2.0 * secs + 6.0, "{}", fixture.log());
    assert!(wait_until(PATIENCE, || counted("made_up_") > 0), "{}", fixture.log());
}

/// Shows an image of this size and then a small one. The node may keep `kept_mb` megabytes.
fn memory_is_given_back_after(width: u32, height: u32, arguments: &[&str], kept_mb: u64) {
    let fixture = Setup::of(&[CLOUD]).args(arguments).start();
    watched(&fixture);
    let before = of_process(&fixture, "VmRSS");
    fixture.python(format!("latch('/eye/camera_info', info(width={width}, height={height}, f=9000.0))"));
    fixture.wait_for(format!("viewer.last.width == {width}"));
    let most = of_process(&fixture, "VmHWM");
    fixture.python("latch('/eye/camera_info', info())");
    fixture.wait_for("viewer.last.width == 64");
    fixture.images_go_on(10);
    let is_small = || of_process(&fixture, "VmRSS") < before + (kept_mb << 10);
    assert!(wait_until(PATIENCE, is_small), "{} kB, {before} kB before", of_process(&fixture, "VmRSS"));
    println!("{} MB, at most {} MB, then {} MB", before >> 10, most >> 10, of_process(&fixture, "VmRSS") >> 10);
}

#[test]
#[ignore = "a figure of memory: ./test full"]
fn a_huge_image_gives_its_memory_back() {
    memory_is_given_back_after(16384, 16384, &[], 40);
}

/// Its colours, its depths and the copy that is read back have 72 MB each.
#[test]
#[ignore = "a figure of memory: ./test full"]
fn a_large_image_of_the_gpu_gives_its_memory_back() {
    memory_is_given_back_after(6000, 3000, &["--renderer", "gpu"], 60);
}

#[test]
#[ignore = "a figure of memory: ./test full"]
fn large_images_and_depths_leave_no_memory_behind() {
    let fixture = Setup::of(&[CLOUD]).start();
    watched(&fixture);
    let before = of_process(&fixture, "VmRSS");
    // Of 15 and 20 MB.
    let come_and_go = |times: u32| {
        for _ in 0..times {
            fixture.python("latch('/eye/camera_info', info(width=5000, height=1000, f=4000.0))");
            fixture.wait_for("viewer.last.width == 5000");
            fixture.python("latch('/eye/camera_info', info())");
            fixture.wait_for("viewer.last.width == 64");
        }
    };
    come_and_go(4);
    let is_small = || of_process(&fixture, "VmRSS") < before + (12 << 10);
    let kept = || format!("{} kB, {before} kB before", of_process(&fixture, "VmRSS"));
    assert!(wait_until(PATIENCE, is_small), "{}", kept());
    println!("{}", kept());
    fixture
        .python("depths = rospy.Subscriber('/view/depth', Image, lambda depth: None, queue_size=1, buff_size=1 << 24)");
    come_and_go(2);
    fixture.python("depths.unregister()");
    fixture.python("latch('/cloud', cloud(0x00ff00))");
    fixture.wait_for("viewer.middle() == (0, 255, 0)");
    assert!(wait_until(PATIENCE, is_small), "with depths {}", kept());
    println!("with depths {}", kept());
}

#[test]
#[ignore = "a figure of memory: ./test full"]
fn a_huge_message_leaves_no_memory_behind_once_it_is_unused() {
    let fixture = Setup::of(&[CLOUD]).start();
    watched(&fixture);
    let before = of_process(&fixture, "VmRSS");
    // One point and 64 MB that no field is in.
    fixture.python(
        "huge = cloud(0x00ff00); huge.data += bytes(64 << 20); huge.point_step = huge.row_step = len(huge.data)\n\
         latch('/cloud', huge)",
    );
    fixture.wait_for("viewer.middle() == (0, 255, 0)");
    fixture.python("latch('/cloud', cloud(0x0000ff))");
    fixture.wait_for("viewer.middle() == (0, 0, 255)");
    let most = of_process(&fixture, "VmHWM");
    // As on a robot, whose transforms come all the time.
    fixture.python("repeated = PublishRepeatedly(10, lambda i: tf('map', 'wheel'), '/tf')");
    let is_small = || of_process(&fixture, "VmRSS") < before + (12 << 10);
    let now =
        || format!("{} MB, at most {} MB, then {} MB", before >> 10, most >> 10, of_process(&fixture, "VmRSS") >> 10);
    assert!(wait_until(PATIENCE, is_small), "{}", now());
    println!("{}", now());
    assert!(most > before + (60 << 10), "there was nothing to give back: {}", now());
}

#[test]
#[ignore = "a figure of memory: ./test full"]
fn a_hundred_thousand_markers_give_their_memory_back() {
    let markers = "{Class: rviz/MarkerArray, Name: markers, Enabled: true, Marker Topic: /markers}";
    let fixture = Setup::of(&[CLOUD, markers]).start();
    watched(&fixture);
    fixture.python(LOAD);
    let before = of_process(&fixture, "VmRSS");
    fixture.python("send('/markers', cubes(100000, 0))");
    fixture.wait_for("max(viewer.last.data[1::3]) > 50");
    let most = of_process(&fixture, "VmHWM");
    fixture.python("send('/markers', MarkerArray([Marker(action=Marker.DELETEALL)]))");
    fixture.wait_for("max(viewer.last.data[1::3]) == 0");
    let gone = Instant::now();
    let is_small = || of_process(&fixture, "VmRSS") < before + (12 << 10);
    assert!(wait_until(PATIENCE, is_small), "{} kB, {before} kB before", of_process(&fixture, "VmRSS"));
    println!("given back after {:.1} s", gone.elapsed().as_secs_f64());
    println!("{} MB, at most {} MB, then {} MB", before >> 10, most >> 10, of_process(&fixture, "VmRSS") >> 10);
    assert!(most < 300 << 10, "{most} kB");
}

/// Without a new image for longer than this, beside what takes long to draw, they have stopped: ten times what a slow
/// machine needs.
pub(crate) const LONGEST_GAP_SECS: f64 = 60.0;

#[test]
#[ignore = "a load: ./test full"]
fn images_of_another_display_go_on_while_a_large_array_is_placed() {
    let markers = "{Class: rviz/MarkerArray, Name: markers, Enabled: true, Marker Topic: /markers}";
    for kind in ["SPHERE", "ARROW", "TEXT_VIEW_FACING"] {
        let fixture = Setup::of(&[CLOUD, markers]).start();
        watched(&fixture);
        fixture.python(LOAD);
        fixture.python(CAMERA);
        fixture.python(format!("array = crowd(100000, Marker.{kind})"));
        fixture.python("clouds = PublishRepeatedly(30, lambda i: cloud(0x010000 * (i % 250 + 1)), '/cloud')");
        fixture.python("viewer.forget()");
        fixture.wait_for("len(viewer.images) > 60");
        let before = fixture.python("longest_gap()");
        let memory = of_process(&fixture, "VmRSS");
        for _ in 0..2 {
            fixture.python("viewer.forget(); send('/markers', array)");
            fixture.wait_for("viewer.last and max(viewer.last.data[1::3]) > 0");
            fixture.python("shown = len(viewer.images)");
            fixture.wait_for("len(viewer.images) > shown + 10");
            let gap = fixture.python("longest_gap()");
            println!("{kind}: at most {gap} s between pictures, {before} s before");
            assert!(gap.parse::<f64>().unwrap() < LONGEST_GAP_SECS, "{kind}: {gap} s without a new picture");
            fixture.python("send('/markers', MarkerArray([Marker(action=Marker.DELETEALL)]))");
            fixture.wait_for("max(viewer.last.data[1::3]) == 0");
        }
        let most = of_process(&fixture, "VmHWM");
        let grown_mb = || of_process(&fixture, "VmRSS").saturating_sub(memory) >> 10;
        let is_given_back = wait_until(PATIENCE, || grown_mb() < 20);
        println!("{kind}: {} MB, at most {} MB, then {} MB more", memory >> 10, most >> 10, grown_mb());
        assert!(is_given_back, "{kind}: {} MB more than before", grown_mb());
        assert!(most < 350 << 10, "{kind}: {most} kB");
    }
}

/// Two cores draw 640×480 and send it while Python makes and receives it.
pub(crate) const CAMERA: &str = "latch('/eye/camera_info', info(width=640, height=480, f=500.0))";

/// Receives images for three seconds and prints their rate.
fn print_rate(fixture: &RosFixture, what: &str) {
    fixture.python("viewer.forget(); begun = time.time()");
    fixture.wait_for("time.time() > begun + 3 and len(viewer.images) > 10");
    println!("{what}: {} pictures a second", fixture.python("len(viewer.images) / (time.time() - begun)"));
}

#[test]
#[ignore = "a load: ./test full"]
fn forty_displays_that_all_change_are_drawn() {
    let classes = [
        ("PointCloud2, Style: Flat Squares, Size (m): 0.01, Topic", "points", 5000),
        ("MarkerArray, Marker Topic", "cubes", 50),
        ("Path, Pose Style: Axes, Length: 0.03, Radius: 0.003, Topic", "path", 50),
        ("PoseArray, Shape: Arrow (3D), Topic", "poses", 50),
    ];
    let displays: Vec<String> = (0..40)
        .map(|i| {
            let (class, make, _) = classes[i % 4];
            format!("{{Class: rviz/{class}: /{make}_{i}, Name: display {i}, Enabled: true}}")
        })
        .collect();
    let displays: Vec<&str> = [CLOUD].into_iter().chain(displays.iter().map(String::as_str)).collect();
    let fixture = Setup::of(&displays).start();
    watched(&fixture);
    fixture.python(LOAD);
    fixture.python(CAMERA);
    for i in 0..40 {
        let (_, make, count) = classes[i % 4];
        fixture.python(in_turn(5, &format!("/{make}_{i}"), make, count));
    }
    fixture.wait_for("viewer.last.width == 640 and len({i[6] for i in viewer.images}) > 3");
    print_rate(&fixture, "40 displays, 200 messages a second");
    let errors = fixture.python("[key for key, text in values('camera_stream: CameraPub').items() if 'rror' in text]");
    assert_eq!(errors, "[]");
}

#[test]
#[ignore = "a load: ./test full"]
fn a_thousand_markers_that_change_a_hundred_times_a_second_are_drawn() {
    let markers = "{Class: rviz/MarkerArray, Name: markers, Enabled: true, Marker Topic: /markers}";
    let fixture = Setup::of(&[CLOUD, markers]).start();
    watched(&fixture);
    fixture.python(LOAD);
    fixture.python(CAMERA);
    let before = of_process(&fixture, "VmRSS");
    fixture.python(in_turn(100, "/markers", "cubes", 1000));
    fixture.wait_for("viewer.last.width == 640 and len({i[6] for i in viewer.images}) > 3");
    print_rate(&fixture, "1,000 markers at 100 Hz");
    let grown_mb = of_process(&fixture, "VmRSS").saturating_sub(before) >> 10;
    println!("{grown_mb} MB more");
    assert!(grown_mb < 60, "{grown_mb} MB");
    // The last state is shown.
    fixture.python("repeated[0].stop()");
    fixture.python(
        "everywhere = Marker(header=Header(frame_id='map'), ns='many', id=0, type=Marker.POINTS, \
         pose=Pose(orientation=Quaternion(0, 0, 0, 1)), scale=Vector3(1, 1, 0), points=[Point(0, 0, 1)], \
         color=ColorRGBA(0, 0, 1, 1))",
    );
    fixture.python("send('/markers', MarkerArray([everywhere])); sent = time.time()");
    fixture.wait_for("viewer.middle() == (0, 0, 255)");
    println!("the last change is seen after {} s", fixture.python("time.time() - sent"));
}
