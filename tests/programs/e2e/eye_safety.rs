//! `~mask_topic`, `~keep_out`: where there must be no light, and none at all while that is not known.

use std::process::Command;

use rcs_tests::golden::GoldenCase;
use rcs_tests::programs::program;
use rcs_tests::python_node::PythonNode;
use rcs_tests::ros::PATIENCE;
use rcs_tests::ros_fixture::{config, CameraPub, RosFixture, Setup, CLOUD};

/// A wall of red before the whole view.
const WALL: &str =
    "latch('/cloud', cloud(0xff0000, points=[(0.5 * x, 0.5 * y, 2) for x in range(-5, 6) for y in range(-5, 6)]))";
const ALL_RED: &str = "bytes(viewer.last.data) == b'\\xff\\0\\0' * 64 * 48";
const ALL_BLACK: &str = "viewer.last and max(viewer.last.data) == 0";

/// A mask of the image's size that is dark on the right of this column.
const MASK: &str = "
def mask(column, encoding='mono8'):
    message = Image(width=64, height=48, step=64, encoding=encoding)
    message.header.stamp = rospy.Time.now()
    message.data = bytes([255] * column + [0] * (64 - column)) * 48
    return message
def only_right_of(column):
    rows = [bytes(viewer.last.data[192 * v : 192 * (v + 1)]) for v in range(48)]
    return all(row == b'\\xff\\0\\0' * column + b'\\0' * 3 * (64 - column) for row in rows)
";

fn fixture(args: &[&str]) -> RosFixture {
    let fixture = Setup::of(&[CLOUD]).args(args).start();
    fixture.python("viewer = Viewer('/view/image')");
    fixture.python("place_camera()");
    fixture.python(WALL);
    fixture.python(MASK);
    fixture
}

#[test]
fn without_a_current_mask_all_is_black_and_with_one_only_what_it_allows_is_lit() {
    let fixture = fixture(&["_mask_topic:=/mask", "_stale_note:=true", "_stale_timeout:=0.5"]);
    fixture.wait_for(format!("{ALL_BLACK} and len(viewer.images) > 5"));
    fixture.wait_for_log("the picture is black: no mask on /mask").unwrap();
    let node = PythonNode::start(&fixture.master, &["__name:=masks"]).unwrap();
    node.run(MASK).unwrap();
    node.run("PublishRepeatedly(20, lambda i: mask(40), '/mask')").unwrap();
    fixture.wait_for("viewer.last and only_right_of(40)");
    drop(node);
    // No note either: it is light, too.
    fixture.wait_for(ALL_BLACK);
    fixture.wait_for_log("the picture is black: mask on /mask from /masks: no data of the last 0.5 s").unwrap();
    fixture.python("repeated = PublishRepeatedly(20, lambda i: mask(20), '/mask')");
    std::thread::sleep(std::time::Duration::from_millis(1000));
    assert_eq!(fixture.python(ALL_BLACK), "True", "one of two trackers is dead");
    let node = PythonNode::start(&fixture.master, &["__name:=masks"]).unwrap();
    node.run(MASK).unwrap();
    node.run("PublishRepeatedly(20, lambda i: mask(5), '/mask')").unwrap();
    fixture.wait_for("only_right_of(5)");
    let silent = PythonNode::start(&fixture.master, &["__name:=silent"]).unwrap();
    silent.run("publisher('/mask', Image, False)").unwrap();
    fixture.wait_for(ALL_BLACK);
    fixture.wait_for_log("the picture is black: no mask on /mask from /silent yet").unwrap();
}

#[test]
fn the_last_mask_holds_where_none_is_required_and_one_that_is_none_is_dark() {
    let fixture = fixture(&["--mask-topic", "CameraPub=/mask", "--no-mask-required"]);
    fixture.wait_for(format!("viewer.last and {ALL_RED}"));
    fixture.python("send('/mask', mask(33))");
    fixture.wait_for("only_right_of(33)");
    std::thread::sleep(std::time::Duration::from_millis(1200));
    assert_eq!(fixture.python("only_right_of(33)"), "True");
    fixture.python("send('/mask', mask(10, 'rgb8'))");
    fixture.wait_for_log("mask on /mask: its encoding is rgb8, not mono8").unwrap();
    fixture.wait_for(ALL_BLACK);
    fixture.python("send('/mask', mask(33))");
    fixture.wait_for("only_right_of(33)");
}

#[test]
fn no_light_falls_around_a_keep_out_frame_wherever_it_goes_and_none_at_all_while_that_is_unknown() {
    let fixture = fixture(&["--keep-out", "head=0.2"]);
    fixture.wait_for(format!("{ALL_BLACK} and len(viewer.images) > 5"));
    fixture.wait_for_log("the picture is black: keep-out frame head: its place is not known").unwrap();
    fixture.python("place = [0.3]");
    let node = PythonNode::start(&fixture.master, &["__name:=tracker"]).unwrap();
    node.run("place = [0.3]").unwrap();
    node.run("PublishRepeatedly(20, lambda i: tf('map', 'head', (place[0], 0, 1), stamp=rospy.Time.now()), '/tf')")
        .unwrap();
    // At 1 m, the middle is 15 pixels to the right of the image's and the radius is 10 pixels.
    let dark = "viewer.pixel(47, 24) == (0, 0, 0) and viewer.pixel(38, 24) == (0, 0, 0)";
    let lit = "viewer.pixel(34, 24) == (255, 0, 0) and viewer.pixel(60, 24) == (255, 0, 0)";
    let above_and_below = "viewer.pixel(47, 10) == viewer.pixel(47, 38) == (255, 0, 0)";
    fixture.wait_for(format!("viewer.last and {dark} and {lit} and {above_and_below}"));
    node.run("place[0] = -0.3").unwrap();
    fixture.wait_for("viewer.pixel(17, 24) == (0, 0, 0) and viewer.pixel(47, 24) == (255, 0, 0)");
    drop(node);
    fixture.wait_for(ALL_BLACK);
    fixture.wait_for_log("the picture is black: head: no transform of the last 1 s").unwrap();
}

#[test]
fn a_frame_that_is_not_required_stays_dark_where_it_was_last_in_the_light_of_the_cameras_p() {
    let fixture = fixture(&["--keep-out", "head=0.2", "--no-mask-required"]);
    // Light is flatter than rviz's image, whose pixels are square.
    fixture.python("latch('/eye/camera_info', info(P=[50, 0, 32, 0, 0, 25, 24, 0, 0, 0, 1, 0]))");
    fixture.wait_for(format!("viewer.last and {ALL_RED}"));
    fixture.python("send('/tf', tf('map', 'head', (0.3, 0, 1), stamp=rospy.Time.now()))");
    let dark = "viewer.pixel(47, 24) == viewer.pixel(38, 24) == viewer.pixel(47, 20) == (0, 0, 0)";
    let lit = "viewer.pixel(34, 24) == viewer.pixel(47, 16) == viewer.pixel(47, 32) == (255, 0, 0)";
    fixture.wait_for(format!("viewer.last and {dark} and {lit}"));
    std::thread::sleep(std::time::Duration::from_millis(1200));
    fixture.python("viewer.forget()");
    fixture.wait_for(format!("len(viewer.images) > 2 and {dark} and {lit}"));
}

#[test]
fn where_the_lens_is_unknown_nothing_is_lit_around_keep_out_frames() {
    let fixture = fixture(&["--keep-out", "head=0.2"]);
    fixture.python(
        "latch('/tf_static', TFMessage(tf('map', 'eye').transforms + tf('map', 'head', (0.3, 0, 1)).transforms))",
    );
    let dark = "viewer.pixel(47, 24) == (0, 0, 0) and viewer.pixel(34, 24) == (255, 0, 0)";
    fixture.wait_for(format!("viewer.last and {dark}"));
    fixture.python("latch('/eye/camera_info', info(D=[0.1, 0, 0, 0, 0], distortion_model='unheard_of'))");
    fixture.wait_for(ALL_BLACK);
    fixture.wait_for_log("where the lens sends light around keep-out frames is not known").unwrap();
    fixture.python("latch('/eye/camera_info', info(D=[0.01, 0, 0, 0, 0], distortion_model='plumb_bob'))");
    fixture.wait_for(dark);
}

/// Two cameras that are called `cam` and `other`, or anything else.
fn two_cameras(name: &'static str) -> String {
    let camera = |name, image| CameraPub { name, image, ..CameraPub::default() };
    config(&[CLOUD], &[camera(name, "/view/image"), camera("other", "/other/image")])
}

#[test]
fn a_rule_for_a_camera_that_the_config_does_not_have_is_refused_with_the_cameras() {
    let values = [
        ("mask_topic", "camm=/people"),
        ("mask", "camm=/mask.png"),
        ("blend", "camm=/nowhere/run=3/left.png"),
        ("orientation", "camm=180"),
        ("window", "camm=auto"),
    ];
    for (name, value) in values {
        for (args, expected_status) in [
            (vec![format!("--{}", name.replace('_', "-")), value.to_owned()], 2),
            (vec![format!("_{name}:={value}")], 1),
        ] {
            let args: Vec<_> = args.iter().map(String::as_str).collect();
            let mut fixture = Setup::with_config(two_cameras("cam")).args(&args).launch();
            let status = fixture.node.wait(PATIENCE).and_then(|status| status.code());
            assert_eq!(status, Some(expected_status), "{args:?}: {}", fixture.log());
            let names = ["cam, other", "camm"];
            assert_eq!(fixture.log_lines(&names), 1, "{args:?}: {}", fixture.log());
        }
    }
}

#[test]
fn check_and_render_refuse_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let GoldenCase { config: scene, bag } = GoldenCase::new("pc2_flat_squares_rgb8", folder.path()).unwrap();
    let image = folder.path().join("picture.png");
    let mut render = Command::new(program("camera_stream"));
    render.args(["render", "--renderer", "cpu", "--orientation", "camm=90", "-d"]).arg(&scene);
    render.arg("--bag").arg(bag).arg("-o").arg(&image);
    let mut check = Command::new(program("camera_stream"));
    check.args(["check", "--mask-topic", "camm=/people"]).arg(&scene);
    for (mut command, status) in [(render, 1), (check, 2)] {
        let output = command.output().unwrap();
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(status), "{error}");
        assert!(error.contains("the config has no camera 'camm'; cameras: "), "{error}");
    }
    assert!(!image.exists());
}

#[test]
fn a_file_with_the_sign_in_its_path_is_no_camera() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run=3");
    std::fs::create_dir(&run).unwrap();
    let weights = run.join("left.png");
    image::GrayImage::from_fn(64, 48, |u, _| image::Luma([if u < 32 { 255 } else { 0 }])).save(&weights).unwrap();
    for value in [weights.display().to_string(), format!("CameraPub={}", weights.display())] {
        let fixture = fixture(&["--blend", &value]);
        fixture.wait_for("viewer.last and only_right_of(32)");
    }
}

#[test]
fn after_a_reload_that_leaves_a_name_unmatched_every_camera_is_dark_until_the_names_fit_again() {
    let args = ["--mask-topic", "cam=/mask", "--no-mask-required", "--stale-note"];
    let fixture = Setup::with_config(two_cameras("cam")).args(&args).start();
    fixture.python("monitor()");
    fixture.python("viewer, other = Viewer('/view/image'), Viewer('/other/image')");
    fixture.python("place_camera()");
    fixture.python(WALL);
    let lit = "viewer.middle() == other.middle() == (255, 0, 0)";
    fixture.wait_for(lit);
    fixture.rewrite(&two_cameras("camm"));
    let dark = "max(viewer.last.data) == max(other.last.data) == 0";
    fixture.wait_for(dark);
    fixture
        .wait_for_log("all cameras are dark: the config has no camera for mask_topic cam; cameras: camm, other")
        .unwrap();
    for entry in ["camm", "other", "Global Status"] {
        fixture.wait_for(format!("level('camera_stream: {entry}') == 2"));
    }
    fixture.wait_for("'no camera for mask_topic cam' in message('camera_stream: other')");
    fixture.python("viewer.forget()");
    fixture.wait_for(format!("len(viewer.images) > 5 and {dark}"));
    fixture.rewrite(&two_cameras("cam"));
    fixture.wait_for(lit);
    // It shares its display namespace with the other one, which is a warning.
    fixture.wait_for("max(level('camera_stream: ' + name) for name in ('cam', 'other', 'Global Status')) < 2");
}
