//! `projector_calibrate refine --spots` and `watch` on topics: a simulated robot's projector was bumped.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use rcs_files::projector::{write_pose, ProjectorFile};
use rcs_tests::programs::program;
use rcs_tests::ros::{RosMaster, Running};
use rcs_tests::ros_fixture::{config, CameraPub, RosFixture, Setup};

use crate::projector_verify::{calibrate, robot};

const COMMENT: &str = "# measured on Monday\n";

/// A folder with the robot's truth.yaml and a file from before a bump, and the robot.
fn bumped_robot(master: &RosMaster, folder: &Path) -> (Running, PathBuf) {
    let robot = robot(master, folder);
    let path = folder.join("projector.yaml");
    fs::write(&path, fs::read_to_string(folder.join("truth.yaml")).unwrap() + COMMENT).unwrap();
    let bump = Isometry3::from_parts(
        Translation3::new(0.012, -0.008, 0.01),
        UnitQuaternion::from_euler_angles(0.015, -0.02, 0.01),
    );
    let truth = pose(&path);
    write_pose(&path, ProjectorFile::FRAME_ID, &(truth * bump)).unwrap();
    (robot, path)
}

/// The projector's pose by a file.
fn pose(path: &Path) -> Isometry3<f64> {
    ProjectorFile::read(path).unwrap().frames[0].parent_from_child()
}

/// Checks that a file has the true pose again and everything else that it had.
fn assert_mended(path: &Path) {
    let text = fs::read_to_string(path).unwrap();
    assert!(text.ends_with(COMMENT), "{text}");
    let off = pose(&path.with_file_name("truth.yaml")).inverse() * pose(path);
    let (off_m, off_rad) = (off.translation.vector.norm(), off.rotation.angle());
    println!("off by {:.2} mm and {:.3} degrees", 1000.0 * off_m, off_rad.to_degrees());
    assert!(off_m < 0.003 && off_rad < 0.002, "{off}");
}

/// Refines by spots on a topic: the exit code and standard error.
fn refine(master: &RosMaster, file: &Path, topic: &str, more: &[&str]) -> (Option<i32>, Vec<String>) {
    let spots = ["refine", "--spots", "--projector", "projector.yaml", "--show-on", topic];
    let (code, _, errors) = calibrate(master, file.parent().unwrap(), &[&spots, more].concat());
    (code, errors)
}

#[test]
fn a_bump_is_mended_in_the_file_by_spots() {
    let (master, folder) = (RosMaster::start().unwrap(), tempfile::tempdir().unwrap());
    let (_robot, file) = bumped_robot(&master, folder.path());
    let bumped = fs::read_to_string(&file).unwrap();
    let (code, errors) = refine(&master, &file, "/projector/patterns", &["-o", "new.yaml"]);
    assert_eq!(code, Some(0), "{errors:?}");
    assert!(errors.iter().any(|line| line.contains("spots seen in")), "{errors:?}");
    println!("{errors:?}");
    assert_mended(&folder.path().join("new.yaml"));
    assert_eq!(fs::read_to_string(&file).unwrap(), bumped);
    let (code, errors) = refine(&master, &file, "/projector/patterns", &[]);
    assert_eq!(code, Some(0), "{errors:?}");
    assert_mended(&file);

    // Far off: nothing is written.
    let away = Isometry3::from_parts(Translation3::identity(), UnitQuaternion::from_euler_angles(0.0, 1.5, 0.0));
    write_pose(&file, ProjectorFile::FRAME_ID, &(pose(&file) * away)).unwrap();
    let wrong = fs::read_to_string(&file).unwrap();
    let (code, errors) = refine(&master, &file, "/projector/patterns", &[]);
    assert!(code == Some(1) && errors.iter().any(|line| line.contains("only 0 places")), "{errors:?}");
    assert_eq!(fs::read_to_string(&file).unwrap(), wrong);
}

/// A file with comments, a topic, names and a frame in between.
const OWN: &str = "\
# the lab's, native resolution
width: 640   # px
height: 400
K: [750, 0, 320, 0, 750, 200, 0, 0, 1]
frame_id: lab_projector
camera_info_topic: /lab/camera_info   # ours
frames:
  # the bracket
  - {parent: head_camera_rgb_optical_frame, child: mount, translation: [0.1, 0.2, 0.3]}
  - {parent: mount, child: lab_projector, translation: [0.02, 0, 0], rotation_rpy: [0, 0, 0]}  # measured
";

#[test]
fn a_file_that_is_refined_keeps_comments_topic_names_and_frames_between() {
    let folder = tempfile::tempdir().unwrap();
    // The projector has moved by 1 cm to the right and 5 mm back.
    let mut points = "u_px,v_px,x_m,y_m,z_m\n".to_owned();
    for number in 0..60_u32 {
        let (u, v) = (f64::from(number * 97 % 620) + 10.0, f64::from(number * 61 % 380) + 10.0);
        let z = 0.8 + 0.02 * f64::from(number * 13 % 60);
        let (x, y) = ((u - 320.0) / 750.0 * z + 0.13, (v - 200.0) / 750.0 * z + 0.2);
        points += &format!("{u},{v},{x},{y},{}\n", z + 0.295);
    }
    let file = |name: &str| folder.path().join(name);
    let write = |name: &str, text: &str| fs::write(file(name), text).unwrap();
    write("points.csv", &points);
    write("own.yaml", OWN);
    let refine = |more: &[&str]| {
        let mut command = Command::new(program("projector_calibrate"));
        command.current_dir(folder.path()).args(["refine", "points.csv", "--projector", "own.yaml"]);
        command.args(["--camera-frame", "head_camera_rgb_optical_frame"]).args(more);
        let output = command.output().unwrap();
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let check = |name: &str| {
        let text = fs::read_to_string(file(name)).unwrap();
        let changed: Vec<(&str, &str)> = text.lines().zip(OWN.lines()).filter(|(new, old)| new != old).collect();
        let [(new, _)] = changed[..] else { panic!("{text}") };
        assert!(
            new.starts_with("  - {parent: mount, child: lab_projector,") && new.ends_with("}  # measured"),
            "{new}"
        );
        let moved = ProjectorFile::read(&file(name)).unwrap().frames[1].translation_m;
        assert!((moved[0] - 0.03).abs() < 1e-4 && (moved[2] + 0.005).abs() < 1e-4, "{moved:?}");
    };
    assert_eq!(refine(&["-o", "new.yaml"]).0, Some(0));
    check("new.yaml");
    // A file that is there keeps what it has.
    write("there.yaml", &OWN.replace("native resolution", "another comment"));
    assert_eq!(refine(&["-o", "there.yaml"]).0, Some(0));
    assert!(fs::read_to_string(file("there.yaml")).unwrap().starts_with("# the lab's, another comment\n"));
    // One of another lens is not touched.
    let other = OWN.replace("750", "760");
    write("other.yaml", &other);
    let (code, errors) = refine(&["-o", "other.yaml"]);
    assert!(code == Some(1) && errors.contains("other.yaml has another lens than own.yaml"), "{errors}");
    assert_eq!(fs::read_to_string(file("other.yaml")).unwrap(), other);
    // In place, without --output.
    assert_eq!(fs::read_to_string(file("own.yaml")).unwrap(), OWN);
    assert_eq!(refine(&[]).0, Some(0));
    check("own.yaml");
}

/// `camera_stream` with the robot's projector as its screen, and the node `projector`.
fn streaming(folder: &Path) -> (RosFixture, Running, Running, PathBuf) {
    let master = RosMaster::start().unwrap();
    let (robot, file) = bumped_robot(&master, folder);
    let projector = Running::start(master.program("projector").arg(&file)).unwrap();
    let camera = CameraPub { image: "/projector/patterns", info: "/proj_view/camera_info", ..CameraPub::default() };
    let config = config(&[], &[camera]).replace("rgb8", "mono8").replace("map", "head_camera_rgb_optical_frame");
    let fixture = Setup::with_config(config).args(&["__name:=camera_stream"]).beside(master).unwrap();
    fixture.wait_for_log("drawing ").unwrap();
    fixture.python("from std_srvs.srv import SetBool");
    fixture.python("viewer = Viewer('/projector/patterns')");
    fixture.wait_for("viewer.last");
    (fixture, robot, projector, file)
}

#[test]
fn camera_stream_shows_the_spots_and_the_running_projector_takes_the_pose() {
    let folder = tempfile::tempdir().unwrap();
    let (fixture, _robot, _projector, file) = streaming(folder.path());
    let refine = || refine(&fixture.master, &file, "/camera_stream/patterns", &[]);
    let black = |on: &str| fixture.python(format!("rospy.ServiceProxy('/camera_stream/blackout', SetBool)({on})"));
    black("True");
    let (code, errors) = refine();
    let refused = errors.iter().any(|line| line.contains("does not see the projector's light"));
    assert!(code == Some(1) && refused, "{errors:?}");
    fixture.wait_for("max(viewer.last.data) == 0");
    black("False");
    let (code, errors) = refine();
    assert_eq!(code, Some(0), "{errors:?} {}", fixture.log());
    assert!(errors.iter().any(|line| line.contains("saved by /projector")), "{errors:?}");
    assert_mended(&file);
    // The scene comes back: nothing.
    fixture.wait_for("trigger('/camera_stream/is_idle')[0]");
    // A pattern of another size is not ignored silently.
    fixture
        .python("send('/camera_stream/patterns', Image(width=4, height=2, encoding='mono8', step=4, data=bytes(8)))");
    fixture.wait_for_log("not shown: a pattern of 4x2 pixels fits no camera, which take 640x400 pixels").unwrap();
}

#[test]
fn a_watch_tells_the_drift_and_measures_by_itself_only_while_there_is_nothing_to_show() {
    let folder = tempfile::tempdir().unwrap();
    let (fixture, _robot, _projector, file) = streaming(folder.path());
    fixture.python(
        "from diagnostic_msgs.msg import DiagnosticArray\ndrifts = []\ndef keep(message):\n    for s in message.status:\n        \
         if s.name.endswith('projection drift'): drifts.append((s.level, s.message, {v.key: v.value for v in s.values}))\n\
         listener = rospy.Subscriber('/diagnostics', DiagnosticArray, keep)",
    );
    let before = fs::read_to_string(&file).unwrap();
    let watch =
        Running::start(fixture.master.program("projector_calibrate").arg("watch").arg(&file).args(["--every", "1"]))
            .unwrap();
    // By itself, and it is off by the bump.
    fixture.wait_for("drifts and drifts[-1][0] == 1 and float(drifts[-1][2].get('drift_px', 0)) > 5");
    // It has changed nothing.
    assert_eq!(fs::read_to_string(&file).unwrap(), before);
    // On request, with the true file.
    fs::write(&file, fs::read_to_string(folder.path().join("truth.yaml")).unwrap()).unwrap();
    fixture.python("rospy.wait_for_service('/projector_watch/verify', 60)");
    let answer = fixture.python("rospy.ServiceProxy('/projector_watch/verify', Trigger)().success");
    assert!(answer.contains("True"), "{answer} {:?}", watch.errors());
    fixture.wait_for("drifts[-1][0] == 0 and float(drifts[-1][2]['drift_px']) < 1");
    // A blackout is no lack of something to show.
    fixture.python("rospy.ServiceProxy('/camera_stream/blackout', SetBool)(True)");
    watch.wait_for_error(&["blackout"]);
}
