//! `camera_stream render`: pictures and sequences of a bag, and the errors.

use rcs_tests::programs::{case, program, repository};
use rcs_tests::ros::{RosMaster, Running, PATIENCE};
use rcs_tests::ros_fixture::{config, CameraPub, CLOUD};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Runs `render` in a temporary folder.
struct Render {
    folder: tempfile::TempDir,
}

impl Render {
    fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn run(&self, arguments: &str) -> Output {
        let mut command = Command::new(program("camera_stream"));
        command.arg("render").args(arguments.split_whitespace()).args(["--renderer", "cpu"]);
        command.env_remove("ROS_PACKAGE_PATH").current_dir(self.folder.path()).output().unwrap()
    }

    /// Runs it successfully; it prints nothing.
    fn good(&self, arguments: &str) {
        let output = self.run(arguments);
        let printed = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{arguments}: {printed}");
        assert_eq!((&*printed, &*output.stdout), ("", &b""[..]), "{arguments}: nothing is printed on a pipe");
    }

    /// Runs it to a failure and returns the only line of its error output that is not a warning.
    fn bad(&self, arguments: &str) -> String {
        let output = self.run(arguments);
        let printed = String::from_utf8(output.stderr).unwrap();
        assert!(matches!(output.status.code(), Some(1 | 2)), "{arguments}: {:?} {printed}", output.status);
        let errors: Vec<&str> = printed.lines().filter(|line| !line.starts_with("[ WARN]")).collect();
        assert_eq!(errors.len(), 1, "{arguments}: {printed}");
        errors[0].to_owned()
    }

    fn pixel(&self, picture: &str, x: u32, y: u32) -> [u8; 3] {
        image::open(self.path(picture)).unwrap().to_rgb8().get_pixel(x, y).0
    }

    /// Makes a bag with Python: `bag`, and the helpers of `python_node.py`.
    fn bag(&self, name: &str, script: &str) {
        let helpers = include_str!("../../src/python_node.py").split("\nrospy.init_node").next().unwrap();
        let path = self.path(name);
        let script = format!(
            "{helpers}\nimport rosbag\nat = rospy.Time\nbag = rosbag.Bag('{}', 'w')\n{script}\nbag.close()\n",
            path.display()
        );
        let master = RosMaster::reserve().unwrap();
        let output = master.command("python3").args(["-c", &script]).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }

    /// A config `scene.rviz` with one camera, and `scene.bag`: red from 100 s, green from 101 s, blue from 102 s to
    /// 103 s.
    fn with_scene() -> Self {
        let render = Self::new();
        fs::write(render.path("scene.rviz"), config(&[CLOUD], &[CameraPub::default()])).unwrap();
        render.bag(
            "scene.bag",
            "bag.write('/tf_static', tf('map', 'eye'), at(100))\n\
             bag.write('/eye/camera_info', info(), at(100))\n\
             for secs, color in [(100, 0xff0000), (101, 0x00ff00), (102, 0x0000ff)]:\n\
             \x20   bag.write('/cloud', cloud(color), at(secs))\n\
             bag.write('/eye/camera_info', info(), at(103))",
        );
        render
    }
}

fn case_arguments(case: &Path) -> String {
    format!("-d {} --bag {}", case.join("scene.rviz").display(), case.join("scene.bag").display())
}

#[test]
fn the_end_of_the_bag_is_drawn_or_the_time_given_by_at() {
    let render = Render::with_scene();
    let (red, green, blue) = ([255, 0, 0], [0, 255, 0], [0, 0, 255]);
    let times =
        [("", blue), ("--at 0", red), ("--at 1.5", green), ("--at 102", blue), ("--at 1e9", blue), ("--at 1e20", blue)];
    for (at, color) in times {
        render.good(&format!("-d scene.rviz --bag scene.bag -o out.png {at}"));
        assert_eq!(render.pixel("out.png", 32, 24), color, "{at}");
    }
    for at in ["-1", "-1e20"] {
        let error = render.bad(&format!("-d scene.rviz --bag scene.bag -o out.png --at {at}"));
        assert!(error.contains("--at -1") && error.contains("the bag begins at 100"), "{error}");
    }
}

/// Such a program starts itself again with the folder for which graphics libraries look, and with the same arguments.
#[test]
fn without_a_runtime_folder_the_picture_is_drawn_all_the_same() {
    let render = Render::with_scene();
    let mut command = Command::new(program("camera_stream"));
    command.args(["render", "-d", "scene.rviz", "--bag", "scene.bag", "-o", "out.png", "--at", "0"]);
    let mut running = Running::start(command.env_remove("XDG_RUNTIME_DIR").current_dir(render.folder.path())).unwrap();
    let status = running.wait(PATIENCE);
    assert_eq!(status.and_then(|status| status.code()), Some(0), "{:?}", running.errors());
    assert_eq!(render.pixel("out.png", 32, 24), [255, 0, 0], "{:?}", running.errors());
}

#[test]
fn a_sequence_is_numbered_and_covers_the_bag() {
    let render = Render::with_scene();
    render.good("-d scene.rviz --bag scene.bag --frames new/folder --rate 2");
    let mut names: Vec<String> = fs::read_dir(render.path("new/folder"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, (0..7).map(|i| format!("frame_{i:06}.png")).collect::<Vec<_>>());
    let colors: Vec<[u8; 3]> = names.iter().map(|name| render.pixel(&format!("new/folder/{name}"), 32, 24)).collect();
    let (red, green, blue) = ([255, 0, 0], [0, 255, 0], [0, 0, 255]);
    assert_eq!(colors, [red, red, green, green, blue, blue, blue]);
    for rate in ["0", "-3", "NaN", "1e11", "1e300"] {
        let output = render.run(&format!("-d scene.rviz --bag scene.bag --frames folder --rate={rate}"));
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.contains("--rate"), "{error}");
    }
    render.bag("long.bag", "for secs in (1, 4000000000): bag.write('/eye/camera_info', info(), at(secs))");
    assert!(render.bad("-d scene.rviz --bag long.bag --frames folder").contains("--rate 30"));
    assert!(!render.path("folder").exists());
}

#[test]
fn one_of_several_cameras_is_chosen_by_name() {
    let render = Render::with_scene();
    let camera = |name, background| CameraPub { name, background, ..CameraPub::default() };
    let cameras = [camera("Left", "1; 2; 3"), camera("Right", "4; 5; 6")];
    fs::write(render.path("two.rviz"), config(&[], &cameras)).unwrap();
    render.good("-d two.rviz --bag scene.bag -o out.png --camera Right");
    assert_eq!(render.pixel("out.png", 0, 0), [4, 5, 6]);
    let error = render.bad("-d two.rviz --bag scene.bag -o out.png");
    assert!(error.contains("--camera") && error.contains("Left, Right"), "{error}");
    let error = render.bad("-d two.rviz --bag scene.bag -o out.png --camera Up");
    assert!(error.contains("Up") && error.contains("Left, Right"), "{error}");
    fs::write(render.path("none.rviz"), config(&[CLOUD], &[])).unwrap();
    assert!(render.bad("-d none.rviz --bag scene.bag -o out.png").contains("CameraPub"));
}

#[test]
fn errors_name_the_file_the_topic_or_the_frame() {
    let render = Render::with_scene();
    fs::write(render.path("broken.bag"), b"#ROSBAG V2.0\nand nothing more").unwrap();
    fs::write(render.path("text.bag"), b"no bag at all").unwrap();
    render.bag("no_camera.bag", "bag.write('/cloud', cloud(1), at(1))");
    render.bag("no_frame.bag", "bag.write('/eye/camera_info', info(), at(1))");
    render.bag(
        "bad_info.bag",
        "bag.write('/tf_static', tf('map', 'eye'), at(1))\nbag.write('/eye/camera_info', info(width=0), at(1))",
    );
    render.bag("empty.bag", "");
    let cases: [(&str, &[&str]); 12] = [
        ("-d scene.rviz --bag missing.bag -o out.png", &["missing.bag"]),
        ("-d missing.rviz --bag scene.bag -o out.png", &["missing.rviz"]),
        ("-d scene.rviz --bag broken.bag -o out.png", &["broken.bag"]),
        ("-d scene.rviz --bag text.bag -o out.png", &["text.bag"]),
        ("-d scene.rviz --bag empty.bag -o out.png", &["empty.bag"]),
        ("-d scene.rviz --bag no_camera.bag -o out.png", &["no_camera.bag", "/eye/camera_info"]),
        ("-d scene.rviz --bag no_frame.bag -o out.png", &["no_frame.bag", "eye", "map"]),
        ("-d scene.rviz --bag bad_info.bag -o out.png", &["bad_info.bag", "/eye/camera_info", "width"]),
        ("-d scene.rviz --bag scene.bag -o no/folder/out.png", &["no/folder/out.png"]),
        ("-d scene.rviz --bag scene.bag --frames scene.bag", &["scene.bag"]),
        ("-d scene.rviz --bag scene.bag -o out.png -f nowhere", &["eye", "nowhere"]),
        (
            "-d scene.rviz --bag scene.bag -o out.png --param robot_description=no.urdf",
            &["robot_description", "no.urdf"],
        ),
    ];
    for (arguments, words) in cases {
        let error = render.bad(arguments);
        assert!(words.iter().all(|word| error.contains(word)), "{arguments}: {error}");
        assert!(!render.path("out.png").exists(), "{arguments}: no picture of an error");
    }
}

#[test]
fn compressed_bags_are_read() {
    let render = Render::new();
    let case = case("pc2_flat_squares_rgb8");
    render.good(&format!("{} -o plain.png", case_arguments(&case)));
    let plain = fs::read(render.path("plain.png")).unwrap();
    let master = RosMaster::reserve().unwrap();
    for compression in ["bz2", "lz4"] {
        let bag = render.path(&format!("{compression}.bag"));
        fs::copy(case.join("scene.bag"), &bag).unwrap();
        let before = fs::metadata(&bag).unwrap().len();
        master.output("rosbag", &["compress", &format!("--{compression}"), "-q", bag.to_str().unwrap()]).unwrap();
        assert!(fs::metadata(&bag).unwrap().len() < before, "{compression}: it was compressed");
        render.good(&format!("-d {} --bag {} -o out.png", case.join("scene.rviz").display(), bag.display()));
        assert!(fs::read(render.path("out.png")).unwrap() == plain, "{compression}");
    }
}

#[test]
fn packages_of_meshes_are_found_in_the_package_path_of_the_command_line() {
    let render = Render::new();
    let case = case("marker_mesh_stl");
    let assets = repository().join("tests/conformance/assets");
    render.good(&format!("{} -o with.png --package-path {}", case_arguments(&case), assets.display()));
    let output = render.run(&format!("{} -o without.png", case_arguments(&case)));
    let warnings = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && warnings.contains("package://"), "a missing mesh is reported: {warnings}");
    assert!(fs::read(render.path("with.png")).unwrap() != fs::read(render.path("without.png")).unwrap());
}
