//! `projector_calibrate` with a printed board: from folders of images and from topics to the files.

use nalgebra::{Isometry3, Vector3};
use rcs_calibration::board::Chessboard;
use rcs_calibration::patterns::{gray_code, Pattern};
use rcs_files::image_file;
use rcs_files::projector::{write_camera, ProjectorFile};
use rcs_scan_simulator::{Conditions, Rig, Room, Scan, View};
use rcs_scene::{Encoding, Image};
use rcs_tests::programs::program;
use rcs_tests::python_node::PythonNode;
use rcs_tests::ros::{RosMaster, Running};
use std::fs;
use std::path::Path;
use std::process::Command;

const BOARD: Chessboard = Chessboard { corners: [8, 6], square_m: 0.045 };

/// Runs the program in a folder, without a master.
fn run(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(program("projector_calibrate"));
    let output =
        command.current_dir(folder).env("ROS_MASTER_URI", "http://localhost:1").args(arguments).output().unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

/// Writes the images of a pose, tilted and beside the middle, in OpenCV's order: white and black last. A hidden file is
/// among them.
fn write_pose(
    folder: &Path,
    extension: &str,
    rig: &Rig,
    [about_x, about_y]: [f64; 2],
    [right_m, down_m, depth_m]: [f64; 3],
) {
    let place = rig.target.coords * (depth_m / rig.target.z) + Vector3::new(right_m, down_m, 0.0);
    let board = Isometry3::new(place, Vector3::new(about_x, about_y, 0.05));
    let view = View::new(&Room::wall(1.9, [0.1, 0.1]).with_board(BOARD, &board), rig);
    let scan = Scan::new(&view, Conditions { flicker: 0.0, ..Conditions::random(5) });
    let mut patterns = gray_code([1280, 800]);
    patterns.rotate_left(2);
    assert_eq!(patterns[patterns.len() - 2], Pattern::White);
    fs::create_dir_all(folder).unwrap();
    for (index, data) in scan.capture_all(&patterns).into_iter().enumerate() {
        let [width_px, height_px] = view.size_px();
        let image = image::GrayImage::from_raw(width_px, height_px, data).unwrap();
        image.save(folder.join(format!("shot{index}-cam0.{extension}"))).unwrap();
    }
    fs::write(folder.join("._shot0-cam0.png"), "Mac OS X").unwrap();
}

#[test]
fn folders_of_images_calibrate_a_camera_and_a_projector() {
    let (folder, rig) = (tempfile::tempdir().unwrap(), Rig::random(3));
    let poses = [
        ("png", [0.1, 0.1], [0.0, 0.0, 1.2]),
        ("pgm", [0.0, 0.5], [-0.16, -0.09, 1.1]),
        ("webp", [-0.1, -0.5], [0.16, 0.09, 1.15]),
        ("bmp", [0.5, 0.0], [0.18, -0.1, 1.4]),
        ("tiff", [-0.5, 0.1], [-0.18, 0.1, 1.3]),
    ];
    for (index, (extension, tilt, place)) in poses.into_iter().enumerate() {
        write_pose(&folder.path().join(format!("photos/p{index}")), extension, &rig, tilt, place);
    }
    // Pictures of something else in a folder beside the poses.
    fs::create_dir(folder.path().join("photos/else")).unwrap();
    for name in ["shot0-cam0.png", "shot1-cam0.png"] {
        fs::copy(folder.path().join("photos/p0").join(name), folder.path().join("photos/else").join(name)).unwrap();
    }
    let board = ["--board", "chessboard:8x6:45mm", "--size", "1280x800"];
    let scan = |arguments: &[&str]| run(folder.path(), &[&["scan"], &board[..], arguments].concat());
    let (code, errors) = scan(&["--pictures", "photos", "-o", "boards"]);
    assert_eq!(code, Some(0), "{errors}");
    assert!(errors.contains("pose05: 48 corners") && errors.contains("written: 5 poses in boards"), "{errors}");
    assert!(errors.contains("photos/else: this pose is not used: 2 pictures, but 44 patterns"), "{errors}");
    let (code, errors) = scan(&["--pictures", "photos", "-o", "boards"]);
    assert!(code == Some(2) && errors.contains("folders in it already"), "{errors}");
    let (code, errors) = scan(&["--pictures", "boards/pose01", "-o", "none"]);
    let expected = "boards/pose01: no folder in it has pictures (.png, .jpg, .jpeg, .bmp, ";
    assert!(code == Some(2) && errors.contains(expected) && errors.contains(".pgm, "), "{errors}");
    // Refused for another reason, each.
    fs::create_dir(folder.path().join("side")).unwrap();
    fs::rename(folder.path().join("photos/else"), folder.path().join("side/else")).unwrap();
    let (code, errors) = scan(&["--pictures", "side", "-o", "refused"]);
    let last = errors.lines().last().unwrap_or_default();
    assert!(code == Some(1) && last.contains("side/else: 2 pictures, but 44 patterns"), "{errors}");

    let outputs = ["-o", "projector.yaml", "--camera", "camera.yaml", "--report", "report"];
    let solved = [&["solve", "boards"], &board[..], &outputs].concat();
    // A webcam's photos do not name its frame.
    let (code, errors) = run(folder.path(), &[&solved[..], &["--in-camera-frame"]].concat());
    assert!(code == Some(2) && errors.contains("give --camera-frame FRAME"), "{errors}");
    assert!(!folder.path().join("projector.yaml").exists());
    let solve = |arguments: &[&str]| run(folder.path(), &[arguments, &["--camera-frame", "webcam"]].concat());
    let (code, errors) = solve(&solved);
    assert_eq!(code, Some(0), "{errors}");
    assert!(errors.contains("the pose is written in webcam: "), "{errors}");
    let (code, errors) = solve(&[&solved[..], &["--in-camera-frame"]].concat());
    assert!(code == Some(0) && !errors.contains("the pose is written"), "{errors}");
    assert!(errors.contains("at poses that are left out") && errors.contains("written: camera.yaml"), "{errors}");
    let camera = ProjectorFile::read(&folder.path().join("camera.yaml")).unwrap().camera_lens().unwrap();
    assert!((camera.focal_px.x / rig.camera.focal_px.x - 1.0).abs() < 0.01, "{camera:?}");
    let projector = ProjectorFile::read(&folder.path().join("projector.yaml")).unwrap();
    let lens = projector.lens().unwrap();
    assert!((lens.focal_px.x / rig.projector.focal_px.x - 1.0).abs() < 0.01, "{lens:?}");
    assert_eq!(projector.frames[0].parent, "webcam");
    let off = projector.frames[0].translation_m;
    let truth = rig.projector_from_camera().inverse().translation.vector;
    assert!((Vector3::from(off) - truth).norm() < 0.02, "{off:?} instead of {truth}");
    let report = fs::read_to_string(folder.path().join("report/report.yaml")).unwrap();
    assert!(report.contains("\ncamera:\n  rms_px: ") && report.matches("  - {name: \"pose0").count() == 5, "{report}");
    let page = fs::read_to_string(folder.path().join("report/report.html")).unwrap();
    assert!(page.contains("<h2>Camera lens</h2>") && page.contains("<td>pose05</td>"));

    // A board of other squares is another scale: the board is found, but not its count of corners.
    let (code, errors) =
        solve(&["solve", "boards", "--board", "chessboard:12x9:45mm", "--size", "1280x800", "-o", "other.yaml"]);
    assert!(code == Some(1) && errors.contains("of a board with 12x9 inner corners"), "{errors}");
    let (code, errors) = solve(&[
        "solve",
        "boards/pose01",
        "boards/pose02",
        "--board",
        "chessboard:8x6:45mm",
        "--size",
        "1280x800",
        "-o",
        "two.yaml",
    ]);
    assert!(code == Some(1) && errors.contains("at least 3 are needed"), "{errors}");
    assert!(!errors.contains("the pose is written") && !folder.path().join("two.yaml").exists(), "{errors}");
    let (code, errors) = solve(&["solve", "photos", "--board", "chessboard:8x6:45mm", "--size", "1280x800", "-o", "x"]);
    assert!(code == Some(2) && errors.contains("photos: no capture.yaml in it or in a folder in it"), "{errors}");
    let decode = run(folder.path(), &["decode", "boards/pose01", "-o", "points.csv"]);
    assert!(decode.0 == Some(1), "{}", decode.1);
}

#[test]
fn pictures_of_a_scene_are_a_scan_with_depth_or_without() {
    let (folder, rig) = (tempfile::tempdir().unwrap(), Rig::random(3));
    write_pose(&folder.path().join("photos"), "png", &rig, [0.1, 0.1], [0.0, 0.0, 1.2]);
    write_camera(&folder.path().join("camera.yaml"), &rig.camera, "camera_optical").unwrap();
    let [width_px, height_px] = rig.camera.size_px;
    let data = 1500_u16.to_ne_bytes().repeat((width_px * height_px) as usize);
    let depth = Image { width_px, height_px, encoding: Encoding::Mono16, data };
    // Beside the pictures, it is not taken for one of them.
    image_file::write(&folder.path().join("photos/depth.png"), &depth).unwrap();
    let scan = ["scan", "--pictures", "photos", "--size", "1280x800"];
    let with_depth = ["--camera", "camera.yaml", "--depth-picture", "photos/depth.png", "-o", "deep"];
    let (code, errors) = run(folder.path(), &[&scan[..], &with_depth].concat());
    assert!(code == Some(0) && errors.contains("written: 44 pictures"), "{errors}");
    let (code, errors) = run(folder.path(), &["decode", "deep", "-o", "points.csv"]);
    assert_eq!(code, Some(0), "{errors}");
    let points = fs::read_to_string(folder.path().join("points.csv")).unwrap();
    let depth_m: f64 = points.lines().nth(1).unwrap().rsplit(',').next().unwrap().parse().unwrap();
    assert!((depth_m - 1.5).abs() < 1e-3, "{depth_m}");

    fs::remove_file(folder.path().join("photos/depth.png")).unwrap();
    let (code, errors) = run(folder.path(), &[&scan[..], &["-o", "flat"]].concat());
    assert!(code == Some(0) && !errors.contains("in TF"), "{errors}");
    assert_eq!(run(folder.path(), &["decode", "flat", "--pixels", "pixels.csv"]).0, Some(0));
    let (code, errors) = run(folder.path(), &["decode", "flat", "-o", "none.csv"]);
    assert!(code == Some(1) && errors.contains("no depth image"), "{errors}");
    let (code, errors) = run(folder.path(), &["scan", "--pictures", "deep/..", "--size", "1280x800", "-o", "none"]);
    assert!(code == Some(2) && errors.contains("no pictures"), "{errors}");
}

#[test]
fn a_board_is_written_to_print() {
    let folder = tempfile::tempdir().unwrap();
    let (code, errors) = run(folder.path(), &["board", "-o", "board.pdf"]);
    assert!(code == Some(0) && errors.contains("print it on A4 at 100 %"), "{errors}");
    assert!(fs::read(folder.path().join("board.pdf")).unwrap().starts_with(b"%PDF-1.4\n"));
    assert_eq!(run(folder.path(), &["board", "-o", "board.pdf", "--board", "circles:4x5:1cm"]).0, Some(2));
}

#[test]
fn a_live_scan_says_how_to_hold_the_board_and_takes_a_pose_each_time_it_rests() {
    let (master, folder) = (RosMaster::start().unwrap(), tempfile::tempdir().unwrap());
    let robot = Running::start(
        master
            .program("simulate_scan")
            .args(["--seed", "3", "robot", "--small", "--scene", "board"])
            .arg(folder.path()),
    )
    .unwrap();
    let python = PythonNode::start(&master, &[]).unwrap();
    python.run("rospy.wait_for_service('/simulated_robot/next_view', 300)").unwrap();
    let mut command = master.program("projector_calibrate");
    command.current_dir(folder.path()).args(["scan", "--board", "chessboard:8x6:45mm", "--size", "640x400"]);
    command.args(["--show-on", "/projector/patterns", "--step", "4", "--frames", "1", "-o", "boards"]);
    let mut scan = Running::start(&mut command).unwrap();
    scan.wait_for_error(&["pose 1: hold the board so that camera and projector see all of it"]);
    scan.wait_for_error(&["pose01: ", " corners"]);
    scan.wait_for_error(&["pose 2: tilt the board to the left: its left side away from the camera"]);
    assert!(python.run("trigger('/simulated_robot/next_view')").unwrap().contains("True"), "{:?}", robot.errors());
    scan.wait_for_error(&["pose02: ", " corners"]);
    scan.wait_for_error(&["pose 3: tilt the board to the right"]);
    python.run("trigger('/simulated_robot/next_view')").unwrap();
    scan.wait_for_error(&["pose03: ", " corners"]);
    scan.wait_for_error(&["verdict: "]);
    scan.wait_for_error(&["pose 4: tilt the board back"]);
    // Three poses are enough to end.
    let status = scan.end("INT").unwrap();
    assert_eq!(status.code(), Some(0), "{:?}", scan.errors());
    scan.wait_for_error(&["written: 3 poses in boards"]);

    let solve = ["solve", "boards", "--board", "chessboard:8x6:45mm", "--size", "640x400", "--in-camera-frame"];
    let (code, errors) = run(folder.path(), &[&solve[..], &["-o", "projector.yaml"]].concat());
    assert_eq!(code, Some(0), "{errors}");
    let lens = |name: &str| ProjectorFile::read(&folder.path().join(name)).unwrap().lens().unwrap();
    let (found, truth) = (lens("projector.yaml"), lens("truth.yaml"));
    assert!((found.focal_px.x / truth.focal_px.x - 1.0).abs() < 0.02, "{found:?} instead of {truth:?}");
}
