//! `projector_calibrate scan` on topics and of bags: a Python node is a projector that lights a wall, and the camera
//! that sees it.

use nalgebra::UnitQuaternion;
use rcs_bag::Bag;
use rcs_calibration::patterns::gray_code;
use rcs_calibration::Lens;
use rcs_files::capture::{Capture, FrameMotion};
use rcs_files::projector::{ProjectorFile, StaticFrame};
use rcs_messages::std_msgs::Header;
use rcs_messages::tf2_msgs::TFMessage;
use rcs_messages::{Image, Time};
use rcs_test_support::{BagWriter, McapWriter};
use rcs_tests::programs::program;
use rcs_tests::ros::{wait_until, RosMaster, Running, PATIENCE};
use rcs_tests::ros_fixture::master_and_python;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;

/// Shows `/projector/patterns` on a wall and sees it with a camera of 160×120 pixels. Camera pixel (x, y) is lit by
/// projector pixel (0.7 x + 4, 0.6 y + 2); `mirrored` shows the image mirrored. `packed` publishes compressed images.
const ROBOT: &str = include_str!("projector_scan.py");

/// The scan with more arguments.
fn scan(master: &RosMaster, folder: &Path, arguments: &[&str]) -> Running {
    let mut command = master.program("projector_calibrate");
    command.args(["scan", "--size", "128x80", "--show-on", "/projector/patterns", "-o"]);
    Running::start(command.arg(folder).args(arguments)).unwrap()
}

#[test]
fn a_scan_on_topics_is_written_and_can_be_decoded() {
    let (master, python) = master_and_python(ROBOT);
    let folder = tempfile::tempdir().unwrap();
    let preview = folder.path().join("preview.png");
    python.run(WATCH_PREVIEW).unwrap();
    let mut scan =
        scan(&master, &folder.path().join("scan"), &["--frames", "2", "--preview", preview.to_str().unwrap()]);
    let status = scan.wait(3 * PATIENCE).unwrap();
    assert_eq!(status.code(), Some(0), "{:?}", scan.errors());
    let capture = Capture::read(&folder.path().join("scan")).unwrap();
    assert_eq!((capture.projector_size_px, capture.image_size_px()), ([128, 80], [160, 120]));
    assert_eq!((capture.images.len(), capture.camera_frame_id.as_str()), (2 + 2 * 14, "head_camera_optical"));
    assert!(capture.depth_m.unwrap().iter().all(|depth| (depth - 1.2).abs() < 1e-4));
    assert_eq!(image::image_dimensions(&preview).unwrap(), (160, 120));
    assert!(scan.errors().iter().any(|line| line.contains("light is seen after")), "{:?}", scan.errors());
    // Nothing is decoded before both axes had stripes; in the end, the colours are those of the file.
    assert_eq!(python.run("first[0]").unwrap(), "0");
    assert!(python.wait_for(PATIENCE, "shares and shares[-1] > 0.8 and max(shares[:-1]) > 0.8"));
}

/// A description and TF like Fetch's, above the camera of [`ROBOT`].
const FRAMES: &str = r#"
rospy.set_param('robot_description', """<robot name="r"><link name="base_link"/><link name="torso"/><link name="mount"/>
    <link name="head"/>
    <joint name="bracket" type="fixed"><parent link="torso"/><child link="mount"/><origin xyz="0 0 0.5"/></joint>
    <joint name="lift" type="prismatic"><parent link="base_link"/><child link="torso"/>
      <limit lower="0" upper="1" effort="1" velocity="1"/></joint>
    <joint name="pan" type="continuous"><parent link="torso"/><child link="head"/></joint></robot>""")
latch('/tf_static', tf('head', 'head_camera_optical', (0, 0, 0.1)))
def move():
    while not rospy.is_shutdown():
        for parent, child, xyz in [('odom', 'base_link', (9, 0, 0)), ('base_link', 'torso', (0, 0, 0.4)),
                                   ('torso', 'head', (0.2, 0, 0))]:
            publisher('/tf', TFMessage, False).publish(tf(parent, child, xyz, stamp=rospy.Time.now()))
        time.sleep(0.05)
threading.Thread(target=move, daemon=True).start()
"#;

#[test]
fn solve_knows_the_robot_of_the_scan_and_refuses_to_guess_its_parent() {
    let (master, _python) = master_and_python(format!("{ROBOT}{FRAMES}"));
    let folder = tempfile::tempdir().unwrap();
    let mut scan = scan(&master, &folder.path().join("scan"), &["--frames", "1"]);
    assert_eq!(scan.wait(3 * PATIENCE).unwrap().code(), Some(0), "{:?}", scan.errors());
    let robot = Capture::read(&folder.path().join("scan")).unwrap().robot;
    let joints: Vec<_> = robot.frames.iter().map(|above| (above.motion, above.joint.as_deref())).collect();
    let expected = [
        (FrameMotion::Fixed, None),
        (FrameMotion::Continuous, Some("pan")),
        (FrameMotion::Prismatic, Some("lift")),
        (FrameMotion::Moving, None),
    ];
    assert_eq!(joints, expected);
    assert!(robot.description.is_some_and(|urdf| urdf.contains("bracket")));

    let solve = |arguments: &[&str]| {
        let mut command = Command::new(program("projector_calibrate"));
        command.current_dir(&folder).env("ROS_MASTER_URI", "http://localhost:1");
        command.args(["solve", "scan", "--size", "128x80", "-o", "projector.yaml"]).args(arguments);
        let output = command.output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let (code, errors) = solve(&[]);
    assert_eq!((code, errors.lines().count()), (Some(1), 1), "{errors}");
    let refusal =
        "the joints lift, pan move between head_camera_optical and base_link: choose --parent FRAME (where the \
                   projector is mounted: base_link, torso, head) or --in-camera-frame";
    assert!(errors.contains(refusal), "{errors}");
    let (code, errors) = solve(&["--parent", "gripper"]);
    assert!(code == Some(1) && errors.contains("head_camera_optical, head, torso, base_link, odom"), "{errors}");
    assert_eq!(solve(&["--parent", "mount", "--in-camera-frame"]).0, Some(2));
    // A flat wall does not determine a lens: both get as far as the points.
    for arguments in [&["--parent", "mount"][..], &["--in-camera-frame"]] {
        let (code, errors) = solve(arguments);
        assert!(!errors.contains("choose") && !errors.contains("TF"), "{code:?} {errors}");
    }
}

/// Keeps the share of coloured pixels of each preview, and what the first one says.
const WATCH_PREVIEW: &str = "
shares, first = [], []
def watch(message):
    assert (message.width, message.height, message.encoding, message.step) == (160, 120, 'rgb8', 480)
    assert message.header.frame_id == 'head_camera_optical'
    colours = bytes(message.data)
    first.append(max(colours)) if not first else None
    shares.append(sum(1 for i in range(2, len(colours), 3) if colours[i]) / (160 * 120))
preview = rospy.Subscriber('/projector_calibrate/preview', Image, watch)
";

#[test]
fn compressed_topics_are_scanned() {
    let (master, _python) = master_and_python(format!("{ROBOT}\npacked = True"));
    let folder = tempfile::tempdir().unwrap();
    let image = ["--image", "/head_camera/rgb/image_raw/compressed"];
    let depth = ["--depth", "/head_camera/depth_registered/image_raw/compressedDepth"];
    let mut scan = scan(&master, &folder.path().join("scan"), &[image, depth, ["--frames", "2"]].concat());
    assert_eq!(scan.wait(3 * PATIENCE).unwrap().code(), Some(0), "{:?}", scan.errors());
    let capture = Capture::read(&folder.path().join("scan")).unwrap();
    assert_eq!((capture.images.len(), capture.image_size_px()), (2 + 2 * 14, [160, 120]));
    assert!(capture.depth_m.unwrap().iter().all(|depth| (depth - 1.2).abs() < 1e-4));
}

/// The scan of a bag, without a master.
fn scan_bag(folder: &Path, bag: &str, arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(program("projector_calibrate"));
    command.current_dir(folder).env("ROS_MASTER_URI", "http://localhost:1");
    command.args(["scan", "--size", "128x80", "-o", "scan", "--bag"]).args(bag.split(' ')).args(arguments);
    let output = command.output().unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn a_scan_that_rosbag_recorded_is_scanned_again() {
    let (master, python) = master_and_python(ROBOT);
    let folder = tempfile::tempdir().unwrap();
    let mut record = master.command("rosbag");
    record.current_dir(&folder).args(["record", "--bz2", "-O", "recorded.bag", "/projector/patterns"]);
    record.args(["/head_camera/rgb/image_raw", "/head_camera/rgb/camera_info"]);
    let record = Running::start(record.arg("/head_camera/depth_registered/image_raw")).unwrap();
    assert!(
        python.wait_for(PATIENCE, "publisher('/head_camera/rgb/image_raw', Image, False).get_num_connections() > 0")
    );
    // More images than are needed: a busy machine records some of them late.
    let mut live = scan(&master, &folder.path().join("live"), &["--frames", "6"]);
    assert_eq!(live.wait(3 * PATIENCE).unwrap().code(), Some(0), "{:?}", live.errors());
    record.signal("INT");
    // The recorder, a process of its own, gives the file its name when it is whole.
    assert!(wait_until(PATIENCE, || folder.path().join("recorded.bag").exists()), "{:?}", record.errors());

    let shown = ["--show-on", "/projector/patterns", "--frames", "2"];
    let (code, errors) = scan_bag(folder.path(), "recorded.bag", &shown);
    assert_eq!(code, Some(0), "{errors}");
    let [live, again] = ["live", "scan"].map(|name| Capture::read(&folder.path().join(name)).unwrap());
    assert_eq!((again.camera, again.depth_m), (live.camera, live.depth_m));
    for image in &live.images {
        assert!(again.images.contains(image), "{:?}", image.pattern);
    }
}

/// A transform of 1 m along x.
fn placed(parent: &str, child: &str, stamp: Time) -> TFMessage {
    let (parent, child) = (parent.to_owned(), child.to_owned());
    let frame = StaticFrame { parent, child, translation_m: [1.0, 0.0, 0.0], rotation: UnitQuaternion::identity() };
    TFMessage { transforms: vec![frame.to_message(stamp)] }
}

/// Writes a bag in which `projector_calibrate show --seconds 1 --pause 0.5` lights the wall of [`ROBOT`], at 10 Hz.
fn write_show(path: &Path) {
    let (projector, [width, height]) = ([128, 80], [160_u32, 120]);
    let mut writer = BagWriter::create(path).unwrap();
    let info =
        ProjectorFile::from_lens(&Lens::pinhole([width, height], [130.0; 2], [79.5, 59.5]), "camera").camera_info;
    writer.write("/camera/camera_info", true, Time { sec: 100, nsec: 0 }, &info).unwrap();
    writer.write("/tf_static", true, Time { sec: 100, nsec: 0 }, &placed("head", "camera", Time::default())).unwrap();
    let field = |pixel: u32| if (pixel % 128 / 8 + pixel / 128 / 8).is_multiple_of(2) { 255 } else { 0 };
    let checkerboard: Vec<u8> = (0..128 * 80).map(field).collect();
    let dark = vec![0; 128 * 80];
    let mut slides: Vec<(Vec<u8>, u32)> = vec![(dark.clone(), 20)];
    for pattern in gray_code(projector) {
        slides.extend([(checkerboard.clone(), 5), (pattern.image(projector), 10)]);
    }
    slides.extend([(checkerboard, 5), (dark, 20)]);
    let mut frame = 0_u32;
    for (shown, frames) in slides {
        let lit_by = |x: u32, y: u32| {
            (0.6 * f64::from(y) + 2.0).round() as u32 * 128 + (0.7 * f64::from(x) + 4.0).round() as u32
        };
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let grey: Vec<u8> = pixels.map(|(x, y)| 30 + (u32::from(shown[lit_by(x, y) as usize]) * 3 / 5) as u8).collect();
        let grey = Arc::new(grey);
        for _ in 0..frames {
            let time = Time::from_nanos(100_000_000_000 + i64::from(frame) * 100_000_000);
            let header = Header { stamp: time, frame_id: "camera".to_owned(), ..Header::default() };
            let image = Image::new(header.clone(), [width, height], "mono8", width, Arc::clone(&grey));
            writer.write("/camera/image", false, time, &image).unwrap();
            let depth = Arc::new(1200_u16.to_le_bytes().repeat((width * height) as usize));
            let depth = Image::new(header, [width, height], "16UC1", 2 * width, depth);
            writer.write("/tf", false, time, &placed("base", "head", time)).unwrap();
            if frame.is_multiple_of(5) {
                writer.write("/camera/depth", false, time, &depth).unwrap();
            }
            frame += 1;
        }
    }
    writer.finish().unwrap();
}

#[test]
fn a_show_that_was_recorded_is_scanned_without_a_master() {
    let folder = tempfile::tempdir().unwrap();
    write_show(&folder.path().join("show.bag"));
    let topics = ["--image", "/camera/image", "--camera-info", "/camera/camera_info", "--depth", "camera/depth"];
    let (code, errors) = scan_bag(folder.path(), "show.bag", &topics);
    assert_eq!(code, Some(0), "{errors}");
    assert!(errors.contains("30 patterns are seen from 2."), "{errors}");
    let capture = Capture::read(&folder.path().join("scan")).unwrap();
    assert_eq!((capture.images.len(), capture.camera_frame_id.as_str()), (30, "camera"));
    assert!(capture.depth_m.iter().flatten().all(|depth| (depth - 1.2).abs() < 1e-4));
    let motions: Vec<_> = capture.robot.frames.iter().map(|above| (&*above.frame.parent, above.motion)).collect();
    assert_eq!(motions, [("head", FrameMotion::Fixed), ("base", FrameMotion::Moving)]);

    let refused = |arguments: &[&str], expected: i32, words: &[&str]| {
        let (code, errors) = scan_bag(folder.path(), "show.bag", &[&topics, arguments].concat());
        assert_eq!((code, errors.lines().count()), (Some(expected), 1), "{errors}");
        assert!(words.iter().all(|word| errors.contains(word)), "{errors}");
    };
    refused(&["--step", "2"], 1, &["30 pictures are seen between the checkerboards", "there are"]);
    refused(&["--start", "20"], 1, &["between the checkerboards"]);
    refused(&["--show-on", "/projector/patterns"], 2, &["/projector/patterns", "/camera/image"]);

    // In two parts.
    let show = Bag::open(folder.path().join("show.bag")).unwrap();
    let all: Vec<_> = show.messages(|_| true).map(Result::unwrap).collect();
    let (first, second) = all.split_at(all.len() / 2);
    for (name, part) in [("2.mcap", second), ("1.mcap", first)] {
        let mut writer = McapWriter::create(folder.path().join(name), 1 << 20).unwrap();
        for message in part {
            let (topic, ros_type) = (&message.connection.topic, &message.connection.ros_type);
            writer.write(topic, ros_type, "ros1", message.time, &message.bytes).unwrap();
        }
        writer.finish().unwrap();
    }
    let (code, errors) = scan_bag(folder.path(), "2.mcap 1.mcap", &topics);
    assert_eq!(code, Some(0), "{errors}");
    assert_eq!(Capture::read(&folder.path().join("scan")).unwrap().images, capture.images);

    fs::write(folder.path().join("broken.bag"), "#ROSBAG V2.0\n").unwrap();
    let (code, errors) = scan_bag(folder.path(), "broken.bag", &topics);
    assert_eq!((code, errors.lines().count()), (Some(2), 1), "{errors}");
}

#[test]
fn a_mirrored_projector_is_refused_and_nothing_is_written() {
    let (master, _python) = master_and_python(format!("{ROBOT}\nmirrored = True"));
    let folder = tempfile::tempdir().unwrap();
    let mut scan = scan(&master, &folder.path().join("scan"), &[]);
    assert_eq!(scan.wait(3 * PATIENCE).unwrap().code(), Some(1), "{:?}", scan.errors());
    assert!(scan.errors().iter().any(|line| line.contains("mirrored")), "{:?}", scan.errors());
    assert!(!folder.path().join("scan").exists());
}

#[test]
fn a_silent_topic_is_named() {
    let (master, _python) = master_and_python(format!("{ROBOT}\nlatch('/points', cloud(0xff0000))"));
    let folder = tempfile::tempdir().unwrap();
    for (topic, reason) in [
        ("/nobody/depth", "nothing was received on /nobody/depth within 10 s: nobody publishes it"),
        ("/depth_registered/image_raw", "did you mean /head_camera/depth_registered/image_raw?"),
        ("/points", "/python_node publishes it as sensor_msgs/PointCloud2, not as sensor_msgs/Image"),
    ] {
        let mut scan = scan(&master, &folder.path().join("scan"), &["--depth", topic]);
        assert_eq!(scan.wait(3 * PATIENCE).unwrap().code(), Some(2), "{:?}", scan.errors());
        let errors = scan.errors();
        assert!(errors.iter().any(|line| line.contains(reason)), "{reason}: {errors:?}");
        let known = "  /head_camera/depth_registered/image_raw  sensor_msgs/Image  /python_node";
        assert!(errors.iter().any(|line| line == known), "{errors:?}");
    }
}

#[test]
fn without_a_master_or_a_place_to_write_nothing_begins() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        let mut command = Command::new(program("projector_calibrate"));
        command.current_dir(&folder).env("ROS_MASTER_URI", "http://localhost:1").env_remove("DISPLAY");
        let output = command.args(["scan", "--size", "128x80", "-o"]).args(arguments).output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    // Without a display there would be no window.
    for arguments in [&["scan"][..], &["scan", "--show-on", "/projector/patterns"]] {
        let (code, errors) = run(arguments);
        assert_eq!((code, errors.lines().count()), (Some(2), 1), "{errors}");
        assert!(errors.contains("no ROS master at http://localhost:1") && errors.contains("start roscore"), "{errors}");
    }
    // Nobody may make files there.
    let (code, errors) = run(&["/proc/scan"]);
    assert_eq!((code, errors.lines().count()), (Some(2), 1), "{errors}");
    assert!(errors.contains("/proc/scan: cannot be written"), "{errors}");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 0);
}

/// After half of the patterns, the camera's images come at another period.
const CHANGE_PERIOD: &str = "
def change(message):
    global period
    if len(shares) == 15:
        period = next_period
    shares.append(message.header.seq)
shares = []
changing = rospy.Subscriber('/projector_calibrate/preview', Image, change)
";

#[test]
fn a_scan_that_ends_early_is_kept_beside_the_complete_one() {
    let (master, python) = master_and_python(ROBOT);
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("scan");
    let mut complete = scan(&master, &output, &["--frames", "1"]);
    assert_eq!(complete.wait(3 * PATIENCE).unwrap().code(), Some(0), "{:?}", complete.errors());
    let before = Capture::read(&output).unwrap();
    python.run(CHANGE_PERIOD).unwrap();

    // Slow enough to be interrupted, and silent.
    for (next_period, signal, code, reason) in
        [("1", Some("INT"), 130, "interrupted"), ("1000", None, 2, "/python_node publishes it and sends nothing")]
    {
        let _ = fs::remove_dir_all(output.join("incomplete"));
        python.run(format!("period, next_period = 0.05, {next_period}; shares.clear()")).unwrap();
        let mut scan = scan(&master, &output, &["--frames", "1"]);
        assert!(python.wait_for(PATIENCE, "len(shares) > 15"), "{:?}", scan.errors());
        signal.into_iter().for_each(|signal| scan.signal(signal));
        assert_eq!(scan.wait(3 * PATIENCE).unwrap().code(), Some(code), "{:?}", scan.errors());
        let errors = scan.errors();
        assert!(errors.iter().any(|line| line.contains("written, incomplete: ")), "{errors:?}");
        assert!(errors.iter().any(|line| line.contains(reason)), "{errors:?}");
        assert_eq!(Capture::read(&output).unwrap(), before);
        let kept = Capture::read(&output.join("incomplete")).unwrap();
        assert!((10..30).contains(&kept.images.len()), "{}", kept.images.len());
    }
}
