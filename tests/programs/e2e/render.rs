//! `camera_stream render`: images and sequences of a bag, and the errors.

use rcs_tests::golden::GoldenCase;
use rcs_tests::programs::{program, repository};
use rcs_tests::ros::{RosMaster, Running, PATIENCE};
use rcs_tests::ros_fixture::{config, CameraPub, CLOUD};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Runs `render` in a temporary folder.
pub(crate) struct Render {
    folder: tempfile::TempDir,
}

impl Render {
    fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn run(&self, arguments: &str) -> Output {
        let mut command = Command::new(program("camera_stream"));
        command.arg("render").args(arguments.split_whitespace()).args(["--renderer", "cpu"]);
        command.env_remove("ROS_PACKAGE_PATH").current_dir(self.folder.path()).output().unwrap()
    }

    /// Runs it successfully; it prints what is written, and nothing else.
    pub(crate) fn good(&self, arguments: &str) -> String {
        let output = self.run(arguments);
        let printed = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{arguments}: {printed}");
        assert_eq!(printed, "", "{arguments}: on a pipe there is no progress");
        let printed = String::from_utf8(output.stdout).unwrap();
        assert!(printed.starts_with("written: ") && printed.lines().count() == 1, "{arguments}: {printed}");
        printed
    }

    /// Runs it to a failure and returns the only line of its error output that is not a warning.
    pub(crate) fn bad(&self, arguments: &str) -> String {
        let output = self.run(arguments);
        let printed = String::from_utf8(output.stderr).unwrap();
        assert!(matches!(output.status.code(), Some(1 | 2)), "{arguments}: {:?} {printed}", output.status);
        let errors: Vec<&str> = printed.lines().filter(|line| !line.starts_with("[ WARN]")).collect();
        assert_eq!(errors.len(), 1, "{arguments}: {printed}");
        errors[0].to_owned()
    }

    pub(crate) fn pixel(&self, image: &str, x: u32, y: u32) -> [u8; 3] {
        image::open(self.path(image)).unwrap().to_rgb8().get_pixel(x, y).0
    }

    /// Makes a bag with Python: `bag`, and the helpers of `python_node.py`.
    pub(crate) fn bag(&self, name: &str, script: &str) {
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
    pub(crate) fn with_scene() -> Self {
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

fn case_arguments(case: &GoldenCase) -> String {
    format!("-d {} --bag {}", case.config.display(), case.bag.display())
}

#[test]
fn the_end_of_the_bag_is_drawn_or_the_time_given_by_at() {
    let render = Render::with_scene();
    let (red, green, blue) = ([255, 0, 0], [0, 255, 0], [0, 0, 255]);
    let times = [("", blue), ("--at 0", red), ("--at 1.5", green), ("--at 102", blue), ("--at 3", blue)];
    for (at, color) in times {
        render.good(&format!("-d scene.rviz --bag scene.bag -o out.png {at}"));
        assert_eq!(render.pixel("out.png", 32, 24), color, "{at}");
    }
    for at in ["3.5", "104", "1e9", "1e20"] {
        let error = render.bad(&format!("-d scene.rviz --bag scene.bag -o out.png --at {at}"));
        assert!(error.contains(&format!("--at {}", at.parse::<f64>().unwrap())), "{error}");
        assert!(error.contains("the bag ends 3 s after its first message"), "{error}");
    }
    for at in ["-1", "-1e20"] {
        let error = render.bad(&format!("-d scene.rviz --bag scene.bag -o out.png --at {at}"));
        assert!(error.contains("--at -1") && error.contains("the bag begins at 100"), "{error}");
    }
}

/// Such a program sets the folder for which graphics libraries look.
#[test]
fn without_a_runtime_folder_the_image_is_drawn_all_the_same() {
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
    let printed = render.good("-d scene.rviz --bag scene.bag --sequence new/folder --rate 2");
    assert_eq!(printed, "written: 7 pictures, new/folder/frame_000000.png to frame_000006.png\n");
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
        let output = render.run(&format!("-d scene.rviz --bag scene.bag --sequence folder --rate={rate}"));
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.contains("--rate"), "{error}");
    }
    render.bag("long.bag", "for secs in (1, 4000000000): bag.write('/eye/camera_info', info(), at(secs))");
    assert!(render.bad("-d scene.rviz --bag long.bag --sequence folder").contains("--rate 30"));
    assert!(!render.path("folder").exists());
}

/// The colours of the images in a folder, in the order of their names.
pub(crate) fn colors(render: &Render, folder: &str) -> Vec<[u8; 3]> {
    let entries = fs::read_dir(render.path(folder)).unwrap().map(|entry| entry.unwrap().file_name());
    let mut names: Vec<String> = entries.map(|name| name.into_string().unwrap()).collect();
    names.sort();
    names.iter().map(|name| render.pixel(&format!("{folder}/{name}"), 32, 24)).collect()
}

#[test]
fn a_part_of_the_bag_is_a_sequence() {
    let render = Render::with_scene();
    let (red, green, blue) = ([255, 0, 0], [0, 255, 0], [0, 0, 255]);
    let parts: [(&str, &[[u8; 3]]); 5] = [
        ("--at 1.5", &[green]),
        ("--start 1", &[green, green, blue, blue, blue]),
        ("--end 101", &[red, red, green]),
        ("--start 0.5 --end 1.5", &[red, green, green]),
        ("--start 2.5 --end 60", &[blue, blue]),
    ];
    for (part, expected) in parts {
        render.good(&format!("-d scene.rviz --bag scene.bag --sequence part --rate 2 --overwrite {part}"));
        assert_eq!(colors(&render, "part"), expected, "{part}");
    }
    for (part, word) in [("--start 4", "--start 4: the bag ends"), ("--start 2 --end 1", "--end is before --start")] {
        let error = render.bad(&format!("-d scene.rviz --bag scene.bag --sequence none {part}"));
        assert!(error.contains(word), "{error}");
        assert!(!render.path("none").exists());
    }
}

#[test]
fn a_sequence_begins_when_its_camera_appears() {
    let render = Render::with_scene();
    render.bag(
        "late.bag",
        "at = rospy.Time.from_sec\n\
         bag.write('/cloud', cloud(0xff0000), at(100))\n\
         bag.write('/tf_static', tf('map', 'eye'), at(100.010))\n\
         bag.write('/eye/camera_info', info(), at(100.015))\n\
         bag.write('/cloud', cloud(0x00ff00), at(100.5))\n\
         bag.write('/cloud', cloud(0x00ff00), at(101.015))",
    );
    render.good("-d scene.rviz --bag late.bag --sequence late --rate 2");
    let output = render.run("-d scene.rviz --bag late.bag --sequence fast --rate 100");
    let printed = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && printed.contains("0.015 s later"), "{printed}");
    assert_eq!(colors(&render, "late"), [[255, 0, 0], [0, 255, 0], [0, 255, 0]]);
    // One moment is what was asked for. The error says from when on there is an image, and leaves no folder.
    for target in ["-o out.png", "--sequence none"] {
        let error = render.bad(&format!("-d scene.rviz --bag late.bag {target} --at 0"));
        assert!(error.contains("/eye/camera_info") && error.contains("(--at 0.015)"), "{error}");
        assert!(!error.contains("may not exist") && !render.path("none").exists(), "{error}");
    }
    render.good("-d scene.rviz --bag late.bag -o out.png --at 0.015");
}

#[test]
fn an_earlier_sequence_is_replaced_only_if_asked_for() {
    let render = Render::with_scene();
    render.good("-d scene.rviz --bag scene.bag --sequence folder --rate 2");
    let error = render.bad("-d scene.rviz --bag scene.bag --sequence folder --rate 1");
    assert!(error.contains("has 7 pictures") && error.contains("--overwrite"), "{error}");
    assert_eq!(colors(&render, "folder").len(), 7);
    render.good("-d scene.rviz --bag scene.bag --sequence folder --rate 1 --overwrite");
    assert_eq!(colors(&render, "folder").len(), 4);
}

#[test]
fn the_ending_of_a_image_is_its_format() {
    let render = Render::with_scene();
    render.good("-d scene.rviz --bag scene.bag -o out.jpg");
    let jpeg = fs::read(render.path("out.jpg")).unwrap();
    assert_eq!(image::guess_format(&jpeg).unwrap(), image::ImageFormat::Jpeg);
    let [red, green, blue] = render.pixel("out.jpg", 32, 24);
    assert!(red < 20 && green < 20 && blue > 235, "{red} {green} {blue}");
    for name in ["out.bmp", "out"] {
        let output = render.run(&format!("-d scene.rviz --bag scene.bag -o {name}"));
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.contains(".png, .jpg or .jpeg"), "{error}");
    }
}

#[test]
fn a_projectors_file_replaces_camera_info_and_frames() {
    let render = Render::with_scene();
    let file = "frame_id: lamp\nwidth: 32\nheight: 24\nK: [25, 0, 16, 0, 25, 12, 0, 0, 1]\n\
                frames: [{parent: map, child: lamp}]\n";
    fs::write(render.path("lamp.yaml"), file).unwrap();
    render.bag(
        "cloud.bag",
        "bag.write('/cloud', cloud(0xff0000), at(100))\nbag.write('/cloud', cloud(0xff0000), at(101))",
    );
    render.good("-d scene.rviz --bag cloud.bag --projector lamp.yaml -o out.png");
    assert_eq!(image::image_dimensions(render.path("out.png")).unwrap(), (32, 24));
    assert_eq!(render.pixel("out.png", 16, 12), [255, 0, 0]);
    // The bag has a CameraInfo of 64x48 pixels.
    render.good("-d scene.rviz --bag scene.bag --projector lamp.yaml --sequence all --rate 1");
    assert_eq!(image::image_dimensions(render.path("all/frame_000003.png")).unwrap(), (32, 24));
    fs::write(render.path("nowhere.yaml"), file.replace("frame_id: lamp\n", "")).unwrap();
    let error = render.bad("-d scene.rviz --bag cloud.bag --projector nowhere.yaml -o out.png");
    assert!(error.contains("nowhere.yaml") && error.contains("frame_id"), "{error}");
    assert!(render.bad("-d scene.rviz --bag cloud.bag --projector no.yaml -o out.png").contains("no.yaml"));
}

/// A program `ffmpeg` in a folder of its own: it writes its arguments and its standard input into the last argument's
/// file, with `before` and `after` around that.
fn fake_ffmpeg(render: &Render, before: &str, after: &str) -> PathBuf {
    use std::os::unix::fs::PermissionsExt;
    let folder = render.path("bin");
    fs::create_dir_all(&folder).unwrap();
    let program = folder.join("ffmpeg");
    let script = format!(
        "#!/bin/bash\n[[ $1 == -version ]] && exit 0\n{before}\nout=${{@: -1}}; out=${{out#file:}}\n\
         {{ printf '%s\\n' \"$@\" END; cat; }} >\"$out\"\n{after}\n"
    );
    fs::write(&program, script).unwrap();
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
    folder
}

/// Runs `render` with programs from this folder before all others, or from this folder alone.
fn run_with_path(render: &Render, arguments: &str, folder: &Path, alone: bool) -> Output {
    let mut command = Command::new(program("camera_stream"));
    let path = if alone { folder.display().to_string() } else { format!("{}:/usr/bin:/bin", folder.display()) };
    command.arg("render").args(arguments.split_whitespace()).args(["--renderer", "cpu"]);
    command.env_remove("ROS_PACKAGE_PATH").env("PATH", path).current_dir(render.folder.path()).output().unwrap()
}

#[test]
fn a_video_is_what_ffmpeg_makes_of_the_images() {
    let render = Render::with_scene();
    let folder = fake_ffmpeg(&render, "", "");
    let arguments = "-d scene.rviz --bag scene.bag --video out.mp4 --rate 2";
    let output = run_with_path(&render, arguments, &folder, false);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let video = fs::read(render.path("out.mp4")).unwrap();
    let end = video.windows(5).position(|bytes| bytes == b"\nEND\n").unwrap() + 5;
    let given = String::from_utf8(video[..end].to_vec()).unwrap();
    for words in ["-f\nrawvideo\n-pixel_format\nrgb24\n-video_size\n64x48\n-framerate\n2\n-i\n", "-pix_fmt\nyuv420p\n"]
    {
        assert!(given.contains(words), "{given}");
    }
    let frames: Vec<&[u8]> = video[end..].chunks(64 * 48 * 3).collect();
    assert_eq!(frames.len(), 7);
    let middle = (24 * 64 + 32) * 3;
    assert_eq!([frames[0], frames[6]].map(|frame| frame[middle..middle + 3].to_vec()), [[255, 0, 0], [0, 0, 255]]);
}

#[test]
fn a_video_that_fails_leaves_no_file() {
    let render = Render::with_scene();
    let arguments = "-d scene.rviz --bag scene.bag --video out.mp4 --rate 1000";
    let cases = [("echo 'Unknown encoder' >&2; exit 1", ""), ("", "echo 'Unknown encoder' >&2; exit 1")];
    for (before, after) in cases {
        let folder = fake_ffmpeg(&render, before, after);
        let output = run_with_path(&render, arguments, &folder, false);
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{error}");
        assert!(error.contains("out.mp4: ffmpeg failed: Unknown encoder") && error.lines().count() == 1, "{error}");
    }
    fs::remove_file(render.path("bin/ffmpeg")).unwrap();
    let output = run_with_path(&render, arguments, &render.path("bin"), true);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(error.contains("ffmpeg is needed") && error.contains("apt install ffmpeg"), "{error}");
    let left = fs::read_dir(render.folder.path()).unwrap().map(|entry| entry.unwrap().file_name());
    let left: Vec<_> = left.filter(|name| name.to_string_lossy().contains("mp4")).collect();
    assert!(left.is_empty(), "{left:?}");
}

/// A limit on the size of files stands for a full disk: writing fails in the same way.
#[test]
fn a_full_disk_ends_a_sequence_with_the_files_name() {
    let render = Render::with_scene();
    let size = 4000;
    let file = format!("frame_id: eye\nwidth: {size}\nheight: {size}\nK: [50, 0, 32, 0, 50, 24, 0, 0, 1]\n");
    fs::write(render.path("large.yaml"), file).unwrap();
    let script = format!(
        "trap '' XFSZ; ulimit -f 8; exec {} render -d scene.rviz --bag scene.bag --projector large.yaml --sequence folder \
         --rate 1 --renderer cpu",
        program("camera_stream").display()
    );
    let mut running =
        Running::start(Command::new("bash").args(["-c", &script]).current_dir(render.folder.path())).unwrap();
    let status = running.wait(PATIENCE);
    let errors = running.errors();
    assert_eq!(status.and_then(|status| status.code()), Some(1), "{errors:?}");
    let error = errors.join("\n");
    assert!(error.contains("folder/frame_000000.png: cannot write") && errors.len() == 1, "{error}");
    assert_eq!(fs::read_dir(render.path("folder")).unwrap().count(), 0, "nothing unfinished is left");
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
        ("-d scene.rviz --bag scene.bag --sequence scene.bag", &["scene.bag"]),
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
    let case = GoldenCase::new("pc2_flat_squares_rgb8", &render.path("")).unwrap();
    render.good(&format!("{} -o plain.png", case_arguments(&case)));
    let plain = fs::read(render.path("plain.png")).unwrap();
    let master = RosMaster::reserve().unwrap();
    for compression in ["bz2", "lz4"] {
        let bag = render.path(&format!("{compression}.bag"));
        fs::copy(&case.bag, &bag).unwrap();
        let before = fs::metadata(&bag).unwrap().len();
        master.output("rosbag", &["compress", &format!("--{compression}"), "-q", bag.to_str().unwrap()]).unwrap();
        assert!(fs::metadata(&bag).unwrap().len() < before, "{compression}: it was compressed");
        render.good(&format!("-d {} --bag {} -o out.png", case.config.display(), bag.display()));
        assert!(fs::read(render.path("out.png")).unwrap() == plain, "{compression}");
    }
}

#[test]
fn packages_of_meshes_are_found_in_the_package_path_of_the_command_line() {
    let render = Render::new();
    let case = GoldenCase::new("marker_mesh_stl", &render.path("")).unwrap();
    let assets = repository().join("tests/golden/assets");
    render.good(&format!("{} -o with.png --package-path {}", case_arguments(&case), assets.display()));
    let output = render.run(&format!("{} -o without.png", case_arguments(&case)));
    let warnings = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() && warnings.contains("package://"), "a missing mesh is reported: {warnings}");
    assert!(fs::read(render.path("with.png")).unwrap() != fs::read(render.path("without.png")).unwrap());
}

/// Where the real ffmpeg is installed: its video is played again.
#[test]
fn a_video_by_the_real_ffmpeg_plays() {
    if Command::new("ffmpeg").arg("-version").output().is_err() {
        println!("skipped: ffmpeg is not installed");
        return;
    }
    let render = Render::with_scene();
    render.good("-d scene.rviz --bag scene.bag --video out.mp4 --rate 2");
    let mut play = Command::new("ffmpeg");
    play.args(["-v", "error", "-i", "out.mp4", "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]);
    let played = play.current_dir(render.folder.path()).output().unwrap();
    assert!(played.status.success(), "{}", String::from_utf8_lossy(&played.stderr));
    let frames: Vec<&[u8]> = played.stdout.chunks(64 * 48 * 3).collect();
    assert_eq!((frames.len(), frames[6].len()), (7, 64 * 48 * 3));
    let middle = (24 * 64 + 32) * 3;
    for (frame, brightest) in [(0, 0), (3, 1), (6, 2)] {
        let pixel = &frames[frame][middle..middle + 3];
        // Compression changes colours a little.
        assert!((0..3).all(|channel| (pixel[channel] > 200) == (channel == brightest)), "{frame}: {pixel:?}");
    }
}
