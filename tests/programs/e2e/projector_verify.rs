//! `projector_calibrate verify` and `refine` on topics: a simulated robot has a projector and a camera that sees it.

use std::fs;
use std::path::Path;
use std::time::Duration;

use nalgebra::{Isometry3, Point2, Point3, Translation3, UnitQuaternion};
use rcs_files::projector::ProjectorFile;
use rcs_tests::python_node::PythonNode;
use rcs_tests::ros::{wait_until, RosMaster, Running, PATIENCE};

use crate::viewers::Screen;

/// A folder with the robot's truth.yaml and tape.yaml, and the robot.
pub(crate) fn robot(master: &RosMaster, folder: &Path) -> Running {
    let robot =
        Running::start(master.program("simulate_scan").args(["--seed", "1", "robot", "--small"]).arg(folder)).unwrap();
    assert!(wait_until(PATIENCE, || folder.join("tape.yaml").exists()), "{:?}", robot.errors());
    robot
}

/// Runs the program and gives its exit code, lines and errors.
pub(crate) fn calibrate(
    master: &RosMaster,
    folder: &Path,
    arguments: &[&str],
) -> (Option<i32>, Vec<String>, Vec<String>) {
    let mut running =
        Running::start(master.program("projector_calibrate").current_dir(folder).args(arguments)).unwrap();
    let code = running.wait(3 * PATIENCE).and_then(|status| status.code());
    (code, running.lines(), running.errors())
}

/// Arguments of a verification on the projector's topic.
fn verify<'a>(file: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["verify", file, "--show-on", "/projector/patterns", "--hold", "0"], more].concat()
}

#[test]
fn a_true_file_is_within_the_limit_and_one_by_tape_is_not() {
    let master = RosMaster::start().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let _robot = robot(&master, folder.path());
    let arguments = verify("truth.yaml", &["--limit", "1", "--report", "truth_report.yaml", "--picture", "truth.png"]);
    let (code, lines, errors) = calibrate(&master, folder.path(), &arguments);
    assert_eq!(code, Some(0), "{lines:?} {errors:?}");
    assert!(lines.iter().any(|line| line.starts_with("light: 0.")), "{lines:?}");
    assert!(["spots", "edges"].iter().all(|kind| lines.iter().any(|line| line.contains(kind))), "{lines:?}");
    let report = fs::read_to_string(folder.path().join("truth_report.yaml")).unwrap();
    assert!(report.contains("is_within_limit: true") && report.contains("kind: edge"), "{report}");
    assert_eq!(image::image_dimensions(folder.path().join("truth.png")).unwrap(), (320, 240));

    let (code, lines, errors) = calibrate(&master, folder.path(), &verify("tape.yaml", &["--limit", "2"]));
    assert_eq!(code, Some(1), "{lines:?} {errors:?}");
    assert!(errors.iter().any(|line| line.contains("beyond the limit of 2 px")), "{errors:?}");
    for (arguments, reason) in [
        (verify("missing.yaml", &[]), "missing.yaml"),
        (verify("truth.yaml", &["--picture", "missing/picture.png"]), "missing"),
    ] {
        let (code, _, errors) = calibrate(&master, folder.path(), &arguments);
        assert!(code == Some(2) && errors.iter().any(|line| line.contains(reason)), "{errors:?}");
    }
}

/// Where the robot's camera is in its torso.
fn torso_from_camera() -> Isometry3<f64> {
    let rotation = UnitQuaternion::from_euler_angles(-1.2, 0.3, -1.5);
    Isometry3::from_parts(Translation3::new(0.1, 0.2, 0.6), rotation)
}

/// Where the crosshair is.
fn crosshair(screen: &Screen) -> Option<[i32; 2]> {
    let pixels = screen.pixels();
    let is_lit = |u: i32, v: i32| pixels[3 * (v * 640 + u) as usize] == 255;
    // The crosshair's row is lit all along, its column from top to bottom.
    let column = (0..640).find(|u| is_lit(*u, 0) && is_lit(*u, 359))?;
    let row = (0..360).find(|v| is_lit(0, *v) && is_lit(639, *v))?;
    Some([column, row])
}

/// Steers it with the keyboard.
fn steer(screen: &Screen, goal: [i32; 2]) {
    for _ in 0..100 {
        let Some(at) = crosshair(screen) else { continue };
        let key = match [goal[0] - at[0], goal[1] - at[1]] {
            [0, 0] => return,
            [0, down] => {
                if down > 0 {
                    "Down"
                } else {
                    "Up"
                }
            }
            [right, _] => {
                if right > 0 {
                    "Right"
                } else {
                    "Left"
                }
            }
        };
        // The window has the keyboard only once it has settled, and a key may come late.
        screen.press(key);
        wait_until(Duration::from_secs(2), || crosshair(screen) != Some(at));
    }
    panic!("{:?} instead of {goal:?}", crosshair(screen));
}

/// Publishes that.
fn publish_torso(python: &PythonNode) {
    let q = torso_from_camera().rotation;
    let (x, y, z, w) = (q.i, q.j, q.k, q.w);
    let transform = format!("'torso', 'head_camera_rgb_optical_frame', (0.1, 0.2, 0.6), ({x}, {y}, {z}, {w})");
    python.run(format!("latch('/tf_static', tf({transform}))")).unwrap();
}

#[test]
fn a_file_in_another_frame_is_related_by_tf() {
    let master = RosMaster::start().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let _robot = robot(&master, folder.path());
    let truth = ProjectorFile::read(&folder.path().join("truth.yaml")).unwrap();
    let frame = &truth.frames[0];
    let camera_from_projector = Isometry3::from_parts(Translation3::from(frame.translation_m), frame.rotation);
    let lens = truth.lens().unwrap();
    let in_torso = ProjectorFile::calibrated(&lens, "torso", &(torso_from_camera() * camera_from_projector));
    in_torso.write(&folder.path().join("torso.yaml")).unwrap();
    let (code, _, errors) = calibrate(&master, folder.path(), &verify("torso.yaml", &["--limit", "1"]));
    assert!(code == Some(1) && errors.iter().any(|line| line.contains("torso")), "{errors:?}");
    let python = PythonNode::start(&master, &[]).unwrap();
    publish_torso(&python);
    let (code, lines, errors) = calibrate(&master, folder.path(), &verify("torso.yaml", &["--limit", "1"]));
    assert_eq!(code, Some(0), "{lines:?} {errors:?}");
}

#[test]
fn a_pose_is_refined_by_clicks_in_rviz() {
    let (master, screen) = (RosMaster::start().unwrap(), Screen::start());
    let folder = tempfile::tempdir().unwrap();
    let python = PythonNode::start(&master, &[]).unwrap();
    publish_torso(&python);
    python.run("from geometry_msgs.msg import Point, PointStamped\nfrom std_msgs.msg import Header").unwrap();
    let lens = rcs_calibration::Lens::pinhole([640, 360], [700.0, 700.0], [320.0, 180.0]);
    // In the camera's frame, before and after it was bumped.
    let old =
        Isometry3::from_parts(Translation3::new(0.2, -0.1, 0.0), UnitQuaternion::from_euler_angles(0.0, 0.1, 0.0));
    let turned = UnitQuaternion::from_euler_angles(0.003, -0.012, 0.004);
    let bumped = old * Isometry3::from_parts(Translation3::new(0.004, 0.002, 0.0), turned);
    ProjectorFile::calibrated(&lens, "torso", &(torso_from_camera() * old))
        .write(&folder.path().join("old.yaml"))
        .unwrap();
    let mut command = master.program("projector_calibrate");
    command.current_dir(folder.path()).env("DISPLAY", &screen.display);
    let arguments = ["refine", "--clicked", "--projector", "old.yaml", "-o", "new.yaml", "--parent", "torso"];
    command.args(arguments).args(["--camera-frame", "head_camera_rgb_optical_frame"]);
    let mut refining = Running::start(&mut command).unwrap();
    refining.wait_for_error(&["click the next point"]);

    // Things in the corners of the image and elsewhere, clicked in the torso's frame.
    let places = [[60, 40], [580, 50], [70, 320], [570, 310], [320, 60], [200, 200], [450, 250], [330, 300]];
    for (number, [u, v]) in places.into_iter().enumerate() {
        let ray = lens.ray(Point2::new(f64::from(u), f64::from(v))).unwrap();
        let thing = old * Point3::from(ray * (1.0 + 0.15 * number as f64));
        let in_torso = torso_from_camera() * thing;
        let place = format!("x={}, y={}, z={}", in_torso.x, in_torso.y, in_torso.z);
        let header = "header=Header(frame_id='torso')";
        python.run(format!("send('/clicked_point', PointStamped({header}, point=Point({place})))")).unwrap();
        refining.wait_for_error(&[&format!("point {}:", number + 1)]);
        // The crosshair is where the old pose expects the thing, and has to go to where the new one does.
        assert!(wait_until(PATIENCE, || crosshair(&screen) == Some([u, v])), "{number}: {:?}", crosshair(&screen));
        let lit_by = lens.project(&bumped.inverse_transform_point(&thing)).unwrap();
        steer(&screen, [lit_by.x.round() as i32, lit_by.y.round() as i32]);
        screen.press("Return");
        refining.wait_for_error(&[&format!("; {} ", number + 1)]);
    }
    refining.wait_for_error(&["8 points are done"]);
    screen.press("f");
    assert_eq!(refining.wait(PATIENCE).unwrap().code(), Some(0), "{:?}", refining.errors());
    let new = ProjectorFile::read(&folder.path().join("new.yaml")).unwrap();
    assert_eq!((new.frames[0].parent.as_str(), new.lens().unwrap()), ("torso", lens));
    let frame = &new.frames[0];
    let found = Isometry3::from_parts(Translation3::from(frame.translation_m), frame.rotation);
    let off = (torso_from_camera() * bumped).inv_mul(&found);
    assert!(off.translation.vector.norm() < 0.005 && off.rotation.angle() < 0.003, "{off}");
}
