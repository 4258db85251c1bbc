//! Subscribers of the image: ROS's tools and the projector's window.

use rcs_tests::programs::{program, repository};
use rcs_tests::python_node::PythonNode;
use rcs_tests::ros::{wait_until, RosMaster, Running, PATIENCE};
use rcs_tests::ros_fixture::{master_and_python, CameraPub, RosFixture, Setup, CLOUD};
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

const WIDTH_PX: usize = 640;
const HEIGHT_PX: usize = 360;

/// A node with an image of that size: a scene with something of every colour.
pub(crate) fn set_up<'a>() -> Setup<'a> {
    let grid = "{Class: rviz/Grid, Name: grid, Enabled: true, Color: 20; 200; 90, Plane: XY}";
    Setup::with_cameras(&[CLOUD, grid], &[CameraPub { background: "10; 20; 200", ..CameraPub::default() }])
}

/// Publishes the scene and its camera.
pub(crate) fn show_scene(fixture: &RosFixture) {
    fixture.python("latch('/tf_static', tf('map', 'eye', q=(0.2, 0.1, 0, 0.95 ** 0.5)))");
    fixture.python(format!("latch('/eye/camera_info', info(width={WIDTH_PX}, height={HEIGHT_PX}, f=300))"));
    fixture.python("latch('/cloud', cloud(0xff8000, points=[(x / 3 - 1, 0, 3 + x / 9) for x in range(9)]))");
}

/// What subscribes to the image of one node, the last of which ends the node.
const SCENARIOS: [fn(&RosFixture, &Screen); 6] = [
    rostopic_sees_the_image_its_rate_and_its_type,
    rosbag_records_the_image_as_it_was_sent,
    a_window_that_fails_unregisters_its_node,
    the_projectors_window_shows_the_image_pixel_for_pixel_over_the_whole_screen,
    image_views_window_is_kept_full_screen_over_the_monitor,
    the_projectors_window_becomes_black_when_the_node_is_killed,
];

/// Scenarios of the projector's window, which shows images that a test publishes.
const SCENARIOS_OF_A_WINDOW: [fn(&RosMaster, &PythonNode, &Screen); 3] = [
    black_images_and_none_beat_a_pause_of_the_projectors_window,
    the_projectors_window_waits_for_its_monitor,
    // Its parameter stays.
    the_projectors_window_reads_compressed_images,
];

#[test]
fn the_image_of_a_node_is_seen_recorded_and_shown() {
    let (screen, fixture) = (Screen::start(), set_up().start());
    show_scene(&fixture);
    SCENARIOS.iter().for_each(|scenario| scenario(&fixture, &screen));
}

#[test]
fn the_projectors_window_shows_what_is_published() {
    let (screen, master) = (Screen::start(), RosMaster::start().unwrap());
    let python = PythonNode::start(&master, &[]).unwrap();
    SCENARIOS_OF_A_WINDOW.iter().for_each(|scenario| scenario(&master, &python, &screen));
}

fn rostopic_sees_the_image_its_rate_and_its_type(fixture: &RosFixture, _: &Screen) {
    let printed = fixture.master.output("rostopic", &["type", "/view/image"]).unwrap();
    assert_eq!(printed.trim(), "sensor_msgs/Image");
    let printed = fixture.master.output("rostopic", &["echo", "-n1", "--noarr", "/view/image"]).unwrap();
    for line in ["frame_id: \"eye\"", "height: 360", "width: 640", "encoding: \"rgb8\"", "step: 1920"] {
        assert!(printed.contains(line), "{line}: {printed}");
    }
    let printed = fixture.master.output("rostopic", &["echo", "-n1", "/view/camera_info"]).unwrap();
    assert!(printed.contains("frame_id: \"eye\"") && printed.contains("distortion_model"), "{printed}");
    let hz = Running::start(fixture.master.command("rostopic").args(["hz", "-w", "30", "/view/image"])).unwrap();
    assert!(hz.line_with("average rate: ").is_some(), "{:?} {:?}", hz.lines(), hz.errors());
}

fn rosbag_records_the_image_as_it_was_sent(fixture: &RosFixture, _: &Screen) {
    let folder = tempfile::tempdir().unwrap();
    let bag = folder.path().join("recorded.bag");
    let mut command = fixture.master.command("rosbag");
    let mut recorder =
        Running::start(command.args(["record", "-l", "5", "-O"]).arg(&bag).args(["/view/image", "/view/camera_info"]))
            .unwrap();
    assert!(recorder.wait(PATIENCE).is_some(), "{:?} {:?}", recorder.lines(), recorder.errors());
    fixture.python("import rosbag");
    fixture.python(format!("messages = list(rosbag.Bag('{}').read_messages())", bag.display()));
    let all = "sorted({(m.topic, m.message.width, m.message.height, m.message.header.frame_id) for m in messages})";
    let expected = "[('/view/camera_info', 640, 360, 'eye'), ('/view/image', 640, 360, 'eye')]";
    assert_eq!(fixture.python(all), expected);
}

/// How long an X server may take to start; mostly it is a tenth of a second.
const SERVER_PATIENCE: Duration = Duration::from_secs(60);

/// An X server with a window manager, and the pixels of its screen.
pub(crate) struct Screen {
    pub(crate) display: String,
    folder: tempfile::TempDir,
    _manager: Running,
    server: Running,
}

impl Screen {
    /// A screen of 640×360 pixels.
    pub(crate) fn start() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let server = Self::started(folder.path());
        let display = format!(":{}", server.lines()[0].trim());
        let manager = Running::start(Command::new("openbox").env("DISPLAY", &display)).unwrap();
        let is_managed =
            || Command::new("wmctrl").arg("-m").env("DISPLAY", &display).output().unwrap().status.success();
        assert!(wait_until(PATIENCE, is_managed), "{:?}", manager.errors());
        Self { display, folder, _manager: manager, server }
    }

    /// An X server that has printed its display. One that hangs while it starts, which was seen once, is replaced.
    fn started(folder: &Path) -> Running {
        let mut reports = Vec::new();
        for _ in 0..3 {
            let mut server = Self::server(folder, &["-displayfd", "1"]);
            if wait_until(SERVER_PATIENCE, || !server.lines().is_empty()) {
                return server;
            }
            let of_process = |name: &str| fs::read_to_string(format!("/proc/{}/{name}", server.id()));
            let state = ["stat", "wchan", "syscall"].map(of_process);
            let children = Command::new("ps").args(["-o", "args", "--ppid", &server.id().to_string()]).output();
            reports.push(format!("{:?} {state:?} {children:?} {:?}", server.wait(Duration::ZERO), server.errors()));
            eprintln!("Xvfb hangs: {}", reports.join("; "));
        }
        panic!("Xvfb does not start: {reports:?}");
    }

    fn server(folder: &Path, args: &[&str]) -> Running {
        let mut command = Command::new("Xvfb");
        // No window needs OpenGL. Without clients it goes on.
        command.args(["-extension", "GLX", "-noreset"]).args(args).args([
            "-screen",
            "0",
            &format!("{WIDTH_PX}x{HEIGHT_PX}x24"),
            "-nolisten",
            "tcp",
        ]);
        Running::start(command.arg("-fbdir").arg(folder)).unwrap()
    }

    /// Kills the X server.
    pub(crate) fn kill(&mut self) {
        self.server.signal("KILL");
        assert!(self.server.wait(PATIENCE).is_some());
    }

    /// Sends a signal to the X server.
    pub(crate) fn signal(&self, name: &str) {
        self.server.signal(name);
    }

    /// Starts another X server on the same display, without a window manager.
    pub(crate) fn restart(&mut self) {
        self.server = Self::server(self.folder.path(), &[&self.display]);
    }

    /// Presses a key, by its name in X11.
    pub(crate) fn press(&self, key: &str) {
        let status = Command::new("xdotool").args(["key", key]).env("DISPLAY", &self.display).status().unwrap();
        assert!(status.success(), "xdotool: {status}");
    }

    /// Presses a key, again if nobody has heard it, until the log of the node says so.
    pub(crate) fn press_until_logged(&self, fixture: &RosFixture, key: &str, logged: &str) {
        let before = fixture.log_lines(&[logged]);
        let is_pressed = || {
            self.press(key);
            wait_until(Duration::from_secs(5), || fixture.log_lines(&[logged]) > before)
        };
        assert!(wait_until(PATIENCE, is_pressed), "{}", fixture.log());
    }

    /// The screen's pixels, three bytes each: the server keeps them in a file in xwd's format.
    pub(crate) fn pixels(&self) -> Vec<u8> {
        let xwd = fs::read(self.folder.path().join("Xvfb_screen0")).unwrap();
        let word = |index: usize| u32::from_be_bytes(xwd[index * 4..index * 4 + 4].try_into().unwrap()) as usize;
        // Words of XWDFileHeader: size of the header, width, height, bits a pixel, bytes a line, colours.
        let (header, bits, line, colors) = (word(0), word(11), word(12), word(19));
        assert_eq!((word(4), word(5), bits), (WIDTH_PX, HEIGHT_PX, 32));
        let rows = xwd[header + colors * 12..].chunks_exact(line).take(HEIGHT_PX);
        rows.flat_map(|row| row[..WIDTH_PX * 4].chunks_exact(4).flat_map(|p| [p[2], p[1], p[0]])).collect()
    }
}

/// Starts the window on a screen.
pub(crate) fn window(master: &RosMaster, screen: &Screen, args: &[&str]) -> Running {
    let mut command = master.program("projector_window");
    command.env("DISPLAY", &screen.display).env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    Running::start(command.args(args)).unwrap()
}

pub(crate) fn saved(python: &PythonNode, file: &Path) -> Vec<u8> {
    python.run(format!("viewer.save('{}')", file.display())).unwrap();
    fs::read(file).unwrap()
}

fn the_projectors_window_shows_the_image_pixel_for_pixel_over_the_whole_screen(fixture: &RosFixture, screen: &Screen) {
    let screenshot = screen.folder.path().join("screenshot.png");
    let mut window =
        window(&fixture.master, screen, &["image:=/view/image", "--screenshot", screenshot.to_str().unwrap()]);
    fixture.python("viewer = Viewer('/view/image')");
    fixture.wait_for(
        "viewer.last is not None and len({i[6] for i in viewer.images[-10:]}) == 1 and len(viewer.images) > 20",
    );
    let file = screen.folder.path().join("picture");
    let is_shown = || saved(&fixture.python, &file) == screen.pixels();
    assert!(wait_until(PATIENCE, is_shown), "{:?}", window.errors());
    let image = saved(&fixture.python, &file);
    for color in [[10, 20, 200], [255, 128, 0]] {
        assert!(image.chunks_exact(3).filter(|pixel| *pixel == color).count() > 100, "{color:?} is in the picture");
    }
    // A changed scene is shown at once.
    fixture.python("latch('/cloud', cloud(0xff00ff, points=[(x / 3 - 1, 0, 3 + x / 9) for x in range(9)]))");
    fixture.wait_for("bytes([255, 0, 255]) * 9 in viewer.last.data");
    assert!(wait_until(PATIENCE, is_shown), "{:?}", window.errors());
    assert!(image::open(&screenshot).unwrap().to_rgb8().into_raw().len() == WIDTH_PX * HEIGHT_PX * 3);
    assert_eq!(window.end("TERM").unwrap().code(), Some(0), "{:?}", window.errors());
}

fn the_projectors_window_waits_for_its_monitor(master: &RosMaster, python: &PythonNode, screen: &Screen) {
    python.run("latch('/pixel', Image(width=1, height=1, encoding='mono8', step=1, data=bytes([255])))").unwrap();
    let mut shown = window(master, screen, &["image:=/pixel", "--monitor", "HDMI-9"]);
    shown.wait_for_error(&["no monitor 'HDMI-9'; monitors: 0: screen"]);
    let mut xrandr = Command::new("xrandr");
    xrandr.args(["--setmonitor", "HDMI-9", "640/160x360/90+0+0", "none"]).env("DISPLAY", &screen.display);
    assert!(xrandr.status().unwrap().success());
    assert!(wait_until(PATIENCE, || screen.pixels()[..3] == [255; 3]), "{:?}", shown.errors());
    assert_eq!(shown.end("TERM").unwrap().code(), Some(0), "{:?}", shown.errors());
}

fn a_window_that_fails_unregisters_its_node(fixture: &RosFixture, screen: &Screen) {
    let nodes = || fixture.master.output("rosnode", &["list"]).unwrap();
    let mut window =
        window(&fixture.master, screen, &["image:=/view/image", "--screenshot", "/nowhere/at/all/screenshot.png"]);
    let status = window.wait(PATIENCE);
    assert_eq!(status.and_then(|status| status.code()), Some(1), "{:?}", window.errors());
    assert!(
        window.errors().iter().any(|line| line.contains("/nowhere/at/all/screenshot.png")),
        "{:?}",
        window.errors()
    );
    assert!(!nodes().contains("projector_window"), "{}", nodes());
    let info = fixture.master.output("rostopic", &["info", "/view/image"]).unwrap();
    assert!(!info.contains("projector_window"), "{info}");
}

#[test]
fn windows_on_an_x_server_that_hangs_end_and_unregister() {
    let screen = Screen::start();
    let (master, _python) =
        master_and_python("latch('/image', Image(width=1, height=1, encoding='mono8', step=1, data=b'x'))");
    let mut shown = window(&master, &screen, &["image:=/image"]);
    let placed = window(&master, &screen, &["--place", "none such"]);
    let mut command = Command::new(program("projector_calibrate"));
    command.args(["show", "--test", "grid"]).env("DISPLAY", &screen.display);
    let calibration = Running::start(command.env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET")).unwrap();
    let nodes = || master.output("rosnode", &["list"]).unwrap();
    assert!(wait_until(PATIENCE, || nodes().contains("projector_window")), "{:?}", shown.errors());
    let has_light = || screen.pixels().iter().any(|level| *level > 0);
    assert!(wait_until(PATIENCE, has_light), "{:?}", calibration.errors());
    screen.signal("STOP");
    // Each asks the server for something meanwhile.
    std::thread::sleep(Duration::from_secs(3));
    for mut program in [placed, calibration] {
        assert_eq!(program.end("TERM").unwrap().code(), Some(0), "{:?}", program.errors());
    }
    assert_eq!(shown.end("TERM").unwrap().code(), Some(0), "{:?}", shown.errors());
    assert!(!nodes().contains("projector_window"), "{}", nodes());
    screen.signal("CONT");
}

fn the_projectors_window_becomes_black_when_the_node_is_killed(fixture: &RosFixture, screen: &Screen) {
    let has_light = || screen.pixels().chunks_exact(3).any(|pixel| pixel == [10, 20, 200]);
    assert!(wait_until(PATIENCE, || !has_light()), "the windows of before are gone");
    let window = window(&fixture.master, screen, &["image:=/view/image", "_stale_timeout:=1.0"]);
    assert!(wait_until(PATIENCE, has_light), "{:?}", window.errors());
    fixture.node.signal("KILL");
    assert!(wait_until(PATIENCE, || screen.pixels().iter().all(|value| *value == 0)), "{:?}", window.errors());
    window.wait_for_error(&["the window is black"]);
}

fn black_images_and_none_beat_a_pause_of_the_projectors_window(
    master: &RosMaster,
    python: &PythonNode,
    screen: &Screen,
) {
    python
        .run(
            "level = [b'\\xff']\ndef picture(): return Image(width=640, height=360, encoding='mono8', step=640, \
             data=level[0] * 640 * 360)\nstream = PublishRepeatedly(20, lambda i: picture(), '/image')",
        )
        .unwrap();
    let window = window(master, screen, &["image:=/image", "--stale-timeout", "1"]);
    let level = || screen.pixels()[0];
    assert!(wait_until(PATIENCE, || level() == 255), "{:?}", window.errors());
    let log = || window.lines().join(" ") + &window.errors().join(" ");
    let is_paused = || {
        screen.press("p");
        wait_until(Duration::from_secs(5), || log().contains("paused until key p"))
    };
    assert!(wait_until(PATIENCE, is_paused), "{}", log());
    let send = |byte: &str| python.run(format!("level[0] = b'\\x{byte}'; time.sleep(0.5)")).unwrap();
    send("40");
    assert_eq!(level(), 255, "it is paused");
    send("00");
    assert!(wait_until(PATIENCE, || level() == 0), "{}", log());
    send("80");
    assert!(wait_until(PATIENCE, || level() == 255), "what was held is back");
    python.run("stream.stop()").unwrap();
    assert!(wait_until(PATIENCE, || level() == 0), "{}", log());
}

fn the_projectors_window_reads_compressed_images(master: &RosMaster, python: &PythonNode, screen: &Screen) {
    let window = window(master, screen, &["image:=/photos", "_image_transport:=compressed"]);
    python.run("import io; from PIL import Image as Photo; from sensor_msgs.msg import CompressedImage").unwrap();
    python.run(format!("photo = Photo.linear_gradient('L').resize(({WIDTH_PX}, {HEIGHT_PX})).convert('RGB')")).unwrap();
    let send = |format: &str, photo: &str| {
        let code = format!(
            "packed = io.BytesIO(); {photo}.save(packed, '{format}'); latch('/photos/compressed', \
             CompressedImage(format='rgb8; {format} compressed bgr8', data=packed.getvalue()))"
        );
        python.run(code).unwrap();
    };
    let bytes = |photo: &str| {
        let file = screen.folder.path().join("photo");
        python.run(format!("open('{}', 'wb').write({photo}.tobytes())", file.display())).unwrap();
        fs::read(file).unwrap()
    };
    send("png", "photo");
    let gradient = bytes("photo");
    assert!(wait_until(PATIENCE, || screen.pixels() == gradient), "{:?}", window.errors());
    send("jpeg", "photo.transpose(Photo.FLIP_TOP_BOTTOM)");
    let flipped = bytes("photo.transpose(Photo.FLIP_TOP_BOTTOM)");
    let is_near = |pixels: &[u8]| pixels.iter().zip(&flipped).all(|(shown, sent)| shown.abs_diff(*sent) <= 4);
    assert!(wait_until(PATIENCE, || is_near(&screen.pixels())), "{:?}", window.errors());
    python.run("latch('/photos/compressed', CompressedImage(format='jpeg', data=b'no picture'))").unwrap();
    window.wait_for_error(&["/photos/compressed: an image of an unknown format"]);
}

fn image_views_window_is_kept_full_screen_over_the_monitor(fixture: &RosFixture, screen: &Screen) {
    const TITLE: &str = "picture of the projector";
    let mut command = fixture.master.environment(Command::new(repository().join("ros_pkg/nodes/image_view_anywhere")));
    command.env("DISPLAY", &screen.display).args(["image:=/view/image", &format!("_window_name:={TITLE}")]);
    let viewer = Running::start(&mut command).unwrap();
    let keeper = window(&fixture.master, screen, &["--place", TITLE, "--monitor", "0"]);
    let wmctrl = |args: &[&str]| {
        let output = Command::new("wmctrl").args(args).env("DISPLAY", &screen.display).output().unwrap();
        String::from_utf8(output.stdout).unwrap()
    };
    // Window, desktop, left, top, width, height, host, title.
    let place = || {
        let windows = wmctrl(&["-l", "-G"]);
        let line = windows.lines().find(|line| line.ends_with(TITLE))?.to_owned();
        Some(line.split_whitespace().skip(2).take(4).map(str::to_owned).collect::<Vec<_>>().join(" "))
    };
    let covers = || place().as_deref() == Some("0 0 640 360");
    assert!(wait_until(PATIENCE, covers), "{:?} {:?} {:?}", place(), keeper.errors(), viewer.errors());
    let has_image = || screen.pixels().chunks_exact(3).any(|pixel| pixel == [10, 20, 200]);
    assert!(wait_until(PATIENCE, has_image), "{:?}", viewer.errors());
    wmctrl(&["-r", TITLE, "-b", "remove,fullscreen"]);
    wmctrl(&["-r", TITLE, "-e", "0,30,30,200,150"]);
    assert!(wait_until(PATIENCE, covers), "it is put back: {:?} {:?}", place(), keeper.errors());
}
