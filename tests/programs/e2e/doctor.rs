//! `camera_stream doctor`: each fault of the chain provoked, and a projection without any.

use rcs_tests::programs::{program, repository};
use rcs_tests::ros::{wait_until, RosMaster, PATIENCE};
use rcs_tests::ros_fixture::{config, master_and_python, CameraPub, RosFixture, Setup, CLOUD};
use std::path::Path;
use std::process::Command;

use crate::viewers::Screen;

/// The lines of a run and its exit status.
struct Run {
    lines: Vec<String>,
    errors: String,
    status: Option<i32>,
}

impl Run {
    /// Runs the doctor on a display.
    fn new(master: &RosMaster, display: Option<&str>, args: &[&str]) -> Self {
        let mut command = master.program("camera_stream");
        // roslaunch looks for the package's programs in a workspace.
        let space = tempfile::tempdir().unwrap();
        package_in(space.path(), &mut command);
        for variable in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET", "XAUTHORITY"] {
            command.env_remove(variable);
        }
        let output =
            command.envs(display.map(|display| ("DISPLAY", display))).arg("doctor").args(args).output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        let lines = text(&output.stdout).lines().map(str::to_owned).collect();
        Self { lines, errors: text(&output.stderr), status: output.status.code() }
    }

    /// Checks that a line begins with this text.
    #[track_caller]
    fn has(&self, beginning: &str) {
        let found = self.lines.iter().any(|line| line.starts_with(beginning));
        assert!(found, "no line '{beginning}' in\n{}\n{}", self.lines.join("\n"), self.errors);
    }

    #[track_caller]
    fn ended_with(&self, status: i32) {
        assert_eq!(self.status, Some(status), "{}\n{}", self.lines.join("\n"), self.errors);
    }
}

/// Makes a workspace with the package, and adds it to the paths of a program.
fn package_in(space: &Path, command: &mut Command) {
    let package = repository().join("ros_pkg");
    std::fs::create_dir(space.join("lib")).unwrap();
    let programs = program("camera_stream");
    std::os::unix::fs::symlink(programs.parent().unwrap(), space.join("lib/rviz_camera_stream")).unwrap();
    write(space, ".catkin", package.to_str().unwrap());
    let before = |path: &Path, variable: &str, default: &str| {
        let rest = std::env::var(variable).unwrap_or_else(|_| default.to_owned());
        format!("{}:{rest}", path.display())
    };
    command.env("ROS_PACKAGE_PATH", before(&package, "ROS_PACKAGE_PATH", "/usr/share"));
    command.env("CMAKE_PREFIX_PATH", before(space, "CMAKE_PREFIX_PATH", "/usr"));
}

fn write(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path.to_string_lossy().into_owned()
}

/// The name of the monitor that tests add.
const MONITOR: &str = "HDMI-9";

/// A node that shows its image on a monitor of its own.
fn projection(screen: &Screen) -> RosFixture {
    let mut xrandr = Command::new("xrandr");
    let added = xrandr.args(["--setmonitor", MONITOR, "640/160x360/90+0+0", "none"]).env("DISPLAY", &screen.display);
    assert!(added.status().unwrap().success());
    let args = ["--window", MONITOR, "--stale-timeout", "1"];
    let fixture = Setup::of(&[CLOUD]).args(&args).on_screen(&screen.display).start();
    fixture.python("place_camera(width=640, height=360, f=300); latch('/cloud', cloud(0xff0000))");
    fixture.python("clock = PublishRepeatedly(20, lambda i: tf('map', 'base', stamp=rospy.Time.now()), '/tf')");
    let is_lit = || screen.pixels().iter().any(|level| *level != 0);
    assert!(wait_until(PATIENCE, is_lit), "{}", fixture.log());
    fixture
}

fn set_exposure(fixture: &RosFixture, is_automatic: &str) {
    fixture.python(format!("rospy.set_param('/head_camera/driver/auto_exposure', {is_automatic})"));
}

#[test]
fn a_projection_that_is_well_has_no_fault() {
    let screen = Screen::start();
    let fixture = projection(&screen);
    set_exposure(&fixture, "False");
    let file = fixture.config_file();
    let file = file.to_str().unwrap();
    let args = ["-d", file, "--window", MONITOR, "--stale-timeout", "1", "--listen", "3"];
    let run = Run::new(&fixture.master, Some(&screen.display), &args);
    let lines = [
        "✓ distribution: ",
        "✓ master: http://127.0.0.1:",
        "✓ clocks: offsets of stamps: 127.0.0.1 ",
        "✓ camera_info: 640x360, frame eye",
        "✓ transform: map to eye, static",
        "✓ display Global Status: Fixed Frame: OK",
        "✓ display cloud: ",
        "✓ limit /cloud: latched: shown as long as its publisher runs",
        "✓ limit /eye/camera_info: latched",
        "✓ monitor: HDMI-9 640x360+0+0 virtual",
        "✓ window: over HDMI-9",
        "✓ display server: DISPLAY is :",
        "✓ image: ",
        "✓ exposure: locked: /head_camera/driver/auto_exposure is false",
    ];
    lines.iter().for_each(|line| run.has(line));
    assert_eq!(run.lines.len(), lines.len(), "{}", run.lines.join("\n"));
    run.ended_with(0);
    let of_running = Run::new(&fixture.master, Some(&screen.display), &["--listen", "3"]);
    of_running.ended_with(0);
    of_running.has("✓ window: over HDMI-9");
    // By a folder as `setup` writes it, whose launch file has the same node.
    let folder = tempfile::tempdir().unwrap();
    std::fs::copy(file, folder.path().join("scene.rviz")).unwrap();
    let launch = r#"<launch><include file="$(find rviz_camera_stream)/launch/projection.launch">
        <arg name="rviz_config" value="$(dirname)/scene.rviz"/>
        <arg name="viewer" value="window"/><arg name="monitor" value="HDMI-9"/><arg name="projector" value="none"/>
        <arg name="stale_timeouts" value="[{topic: /cloud, limit: held}]"/></include></launch>"#;
    write(folder.path(), "projection.launch", launch);
    let run = Run::new(&fixture.master, Some(&screen.display), &[folder.path().to_str().unwrap(), "--listen", "3"]);
    run.ended_with(0);
    run.has("✓ limit /cloud: held: shown as long as it has a publisher");
    run.has("✓ window: over HDMI-9");
    let left = fixture.master.output("rosparam", &["list"]).unwrap();
    assert!(!left.contains("_check_"), "{left}");
}

#[test]
fn faults_of_the_screen_and_the_camera_are_named() {
    let screen = Screen::start();
    let mut fixture = projection(&screen);
    set_exposure(&fixture, "True");
    let file = fixture.config_file();
    let file = file.to_str().unwrap();
    let run = |fixture: &RosFixture, display: Option<&str>, args: &[&str]| {
        let args = [&["-d", file, "--listen", "1"], args].concat();
        let run = Run::new(&fixture.master, display, &args);
        run.ended_with(1);
        run
    };
    let display = Some(screen.display.as_str());
    let wrong_monitor = run(&fixture, display, &["--window", "HDMI-7"]);
    wrong_monitor.has("✗ monitor: no monitor 'HDMI-7'; monitors: 0: screen 640x360+0+0");
    wrong_monitor.has("? window: ");
    wrong_monitor.has("✗ exposure: automatic: /head_camera/driver/auto_exposure is true; lock it before a scan: ");
    run(&fixture, display, &["--window", "screen"]).has("? monitor: screen 640x360+0+0: the only monitor; ");
    let without = run(&fixture, None, &["--window", MONITOR]);
    without.has("✗ display server: DISPLAY is not set; export DISPLAY=:0 XAUTHORITY=");
    without.has("? monitor: ");
    let wrong_display = run(&fixture, Some(":9999"), &["--window", MONITOR]);
    wrong_display.has("✗ display server: no window: DISPLAY :9999: ");
    assert!(run(&fixture, None, &[]).lines.iter().any(|line| line.starts_with("? display server: no window is asked")));
    // The window's node ends: there is neither a window nor an image.
    fixture.node.end("TERM").unwrap();
    let ended = run(&fixture, display, &["--viewer", "projector_window", "--monitor", MONITOR]);
    ended.has("✗ window: none over HDMI-9; start the launch file");
    ended.has("✗ image: nobody publishes /view/image; start camera_stream");
}

#[test]
fn faults_of_the_graph_are_named_with_what_to_do() {
    let (master, python) = master_and_python("");
    let folder = tempfile::tempdir().unwrap();
    let display = |name: &str| format!("{{Class: rviz/PointCloud2, Name: {name}, Enabled: true, Topic: /{name}}}");
    let displays = [display("detections"), display("wrong")];
    let displays: Vec<&str> = displays.iter().map(String::as_str).collect();
    let file = write(folder.path(), "scene.rviz", &config(&displays, &[CameraPub::default()]));
    let run = |listen: &str| {
        let run = Run::new(&master, None, &["-d", &file, "--stale-timeout", "1", "--listen", listen]);
        run.ended_with(1);
        run
    };
    let nothing = run("1");
    nothing.has("? clocks: ");
    nothing.has("✗ camera_info: No CameraInfo received on [/eye/camera_info]");
    nothing.has("? transform: ");
    nothing.has("✗ display Global Status: Fixed Frame: No TF data; start what publishes TF");
    nothing.has("? display detections: nobody publishes /detections yet; start its publisher, or correct the topic");
    nothing.has("? limit /detections: no message in 1 s, the limit is 1 s");
    nothing.has("✗ image: nobody publishes /view/image");
    nothing.has("? exposure: ");
    python.run("latch('/eye/camera_info', info(P=[0] * 12)); latch('/wrong', info())").unwrap();
    run("2").has("✗ camera_info: CameraInfo on [/eye/camera_info]: ");
    python.run("latch('/eye/camera_info', info()); latch('/tf_static', tf('map', 'wall'))").unwrap();
    python.run("PublishRepeatedly(0.5, lambda i: cloud(0xff0000, stamp=rospy.Time.now()), '/detections')").unwrap();
    let no_transform = run("6");
    no_transform.has("✗ transform: ");
    no_transform.has("✗ display wrong: Publisher: [/wrong] is published as sensor_msgs/CameraInfo");
    no_transform.has("✓ display detections: ");
    no_transform.has("✗ limit /detections: comes every 2");
    let late = "tf('map', 'eye', stamp=rospy.Time.now() - rospy.Duration(3))";
    python.run(format!("PublishRepeatedly(20, lambda i: {late}, '/tf')")).unwrap();
    python.run("silent = publisher('/view/image', Image, False)").unwrap();
    let stale = run("2");
    stale.has("✓ camera_info: 64x48, frame eye");
    stale.has("✗ transform: map to eye, up to 3");
    stale.has("✗ image: none on /view/image in 2 s, published by /python_node; ");
}

#[test]
fn a_wrong_clock_and_an_image_of_another_camera_are_named() {
    let (master, python) = master_and_python("");
    let folder = tempfile::tempdir().unwrap();
    let file = write(folder.path(), "scene.rviz", &config(&[CLOUD], &[CameraPub::default()]));
    let ahead = "tf('map', 'eye', stamp=rospy.Time.now() + rospy.Duration(4))";
    python.run(format!("PublishRepeatedly(20, lambda i: {ahead}, '/tf')")).unwrap();
    python.run("latch('/eye/camera_info', info()); latch('/cloud', cloud(0xff0000))").unwrap();
    let image = "Image(width=32, height=48, encoding='mono8', step=32, data=bytes(32 * 48))";
    python.run(format!("PublishRepeatedly(20, lambda i: {image}, '/view/image')")).unwrap();
    let run = Run::new(&master, None, &["-d", &file, "--listen", "2"]);
    run.ended_with(1);
    run.has("✗ clocks: stamps of /python_node, on this computer, are ");
    run.has("✗ camera_info: the image is 32x48, by the CameraInfo 64x48; ");
    run.has("✗ transform: map to eye, stamped ");
    run.has("✓ limit: none (stale_timeout)");
    run.has("? image: ");
}

#[test]
fn without_a_master_the_screen_is_checked_all_the_same() {
    let master = RosMaster::reserve().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = write(folder.path(), "scene.rviz", &config(&[CLOUD], &[CameraPub::default()]));
    let screen = Screen::start();
    let args = [&format!("rviz_config:={file}"), "monitor:=HDMI-7", "projector:=/a/projector.yaml"];
    let run = Run::new(&master, Some(&screen.display), &args);
    run.ended_with(2);
    run.has("✗ master: no ROS master at http://127.0.0.1:");
    run.has("✗ projector file: /a/projector.yaml is not there; calibrate (projector_calibrate), or name another file");
    run.has("? image: unknown without a master");
    assert!(run.lines.last().is_some_and(|line| line.starts_with("fix first: master: no ROS master at ")));
    run.has("✗ monitor: no monitor 'HDMI-7'; monitors: 0: screen 640x360+0+0");
    let other = [&format!("rviz_config:={file}"), "viewer:=image_view", "monitor:=HDMI-8"];
    Run::new(&master, Some(&screen.display), &other).has("✗ monitor: no monitor 'HDMI-8'; ");
    for wrong in [&["/nowhere"][..], &["-d", "/nowhere/scene.rviz"], &[], &["viewer:=other"], &["--listen", "-1"]] {
        let refused = Run::new(&master, None, wrong);
        refused.ended_with(2);
        assert!(refused.lines.is_empty() && !refused.errors.is_empty(), "{wrong:?}");
        assert!(!wrong.is_empty() || refused.errors.contains("start the projection (roslaunch "), "{}", refused.errors);
    }
}
