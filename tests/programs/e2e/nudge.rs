//! Correcting a projector's pose by hand: dynamic_reconfigure of the node `projector`, its `~save` and `~revert`, and
//! steps along the image's axes.

use std::fs::{self, Permissions};
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::process::Command;

use rcs_files::projector::ProjectorFile;
use rcs_tests::python_node::PythonNode;
use rcs_tests::ros::{RosMaster, Running, PATIENCE};

const FILE: &str = "\
# The lab's projector; the pose is from Monday.
width: 64
height: 48
K: [50, 0, 32, 0, 50, 24, 0, 0, 1]
frame_id: proj_view   # the lens
camera_info_topic: /proj/camera_info
frames:
  # on the mast
  - {parent: base, child: proj_link, translation: [0.05, 0, 1.30], rotation_rpy: [0, 0.77, 0]}
  - {parent: proj_link, child: proj_view, translation: [0.110, 6e-2, 0.05], rotation_rpy: [-1.5707963267948966, 0, -1.5707963267948966]}
";

/// Python that keeps the latest transform of each frame and changes the projector's settings.
const PYTHON: &str = include_str!("nudge.py");

/// A master, the node `projector` with a file, and Python that sees its transforms.
struct Fixture {
    master: RosMaster,
    python: PythonNode,
    projector: Running,
    file: PathBuf,
    _folder: tempfile::TempDir,
}

impl Fixture {
    fn start(text: &str) -> Self {
        let (master, folder) = (RosMaster::start().unwrap(), tempfile::tempdir().unwrap());
        let file = folder.path().join("projector.yaml");
        fs::write(&file, text).unwrap();
        let python = PythonNode::start(&master, &[]).unwrap();
        python.run(PYTHON).unwrap();
        let projector = Running::start(master.program("projector").arg(&file)).unwrap();
        let fixture = Self { master, python, projector, file, _folder: folder };
        fixture.python("c = Client('/projector', timeout=300)");
        fixture
    }

    /// As [`start`](Self::start), once the pose of the frame is known as `before`.
    fn start_with_pose(text: &str) -> Self {
        let fixture = Self::start(text);
        fixture.wait_for("'proj_view' in placed");
        fixture.python("before = placed['proj_view']");
        fixture
    }

    fn python(&self, python: &str) -> String {
        self.python.run(python).unwrap()
    }

    fn wait_for(&self, python: &str) {
        assert!(self.python.wait_for(PATIENCE, python), "{python}: {:?}", self.python.run("placed, c.config"));
    }

    /// The text of the file with another translation of the nudged frame.
    fn text_with(&self, translation: &str) -> String {
        FILE.replace("[0.110, 6e-2, 0.05]", translation)
    }

    /// Waits until the client has heard that nothing is nudged.
    fn wait_for_no_nudge(&self) {
        self.wait_for("not any(c.get_configuration(300)[n] for n in ('x', 'y', 'z', 'roll', 'pitch', 'yaw'))");
    }

    /// One step by `ros_probe`: what it prints.
    fn step(&self, topic: &str, arguments: [&str; 4]) -> String {
        let mut command = self.master.environment(Command::new(env!("CARGO_BIN_EXE_ros_probe")));
        let mut probe = Running::start(command.args(["nudge", topic]).args(arguments)).unwrap();
        probe.wait(PATIENCE).unwrap();
        assert!(probe.lines().len() == 2, "{:?} {:?}", probe.lines(), probe.errors());
        probe.lines().swap_remove(0)
    }
}

#[test]
fn a_nudge_moves_the_frame_at_once_and_is_saved_or_taken_back() {
    let fixture = Fixture::start_with_pose(FILE);
    fixture.wait_for_no_nudge();
    let bounds = "[[p[k] for k in ('name', 'type', 'min', 'max')] for p in c.get_parameter_descriptions(300)][3]";
    assert_eq!(fixture.python(bounds), "['roll', 'double', -0.5, 0.5]");

    fixture.python("c.update_configuration({'x': 0.01, 'yaw': 0.1})");
    fixture.wait_for("offset((0.01, 0, 0), (0, 0, 0.1)) < 1e-12");
    fixture.python("c.update_configuration({'y': -0.002})");
    fixture.wait_for("offset((0.01, -0.002, 0), (0, 0, 0.1)) < 1e-12");
    assert_eq!(fixture.python("stamps == sorted(stamps) and len(placed)"), "2", "with all other frames");
    // Values out of bounds become the nearest ones, and nonsense changes nothing.
    let answer = "c.update_configuration({'z': 7.0, 'pitch': float('-inf'), 'x': float('nan')})";
    assert_eq!(fixture.python(&format!("[{answer}[n] for n in ('x', 'z', 'pitch')]")), "[0.01, 0.5, -0.5]");
    fixture.wait_for("offset((0.01, -0.002, 0.5), (0, -0.5, 0.1)) < 1e-12");

    assert_eq!(fixture.python("trigger('/projector/revert')[0]"), "True");
    fixture.wait_for("offset() < 1e-15");
    fixture.wait_for_no_nudge();
    assert_eq!(fs::read_to_string(&fixture.file).unwrap(), FILE);

    // x of the optical frame is to the right, -y of the projector.
    fixture.python("c.update_configuration({'x': 0.001, 'z': 0.25})");
    fixture.wait_for("offset((0.001, 0, 0.25)) < 1e-12");
    let answer = fixture.python("trigger('/projector/save')");
    let saved = format!("(True, 'frame proj_view in {} moved by 250.0 mm and 0.00 degrees')", fixture.file.display());
    assert_eq!(answer, saved);
    assert_eq!(fs::read_to_string(&fixture.file).unwrap(), fixture.text_with("[0.36, 0.059, 0.05]"));
    fixture.wait_for_no_nudge();
    let pose = ProjectorFile::read(&fixture.file).unwrap().frames[1].parent_from_child();
    let (translation, xyzw) = (pose.translation.vector.as_slice().to_vec(), pose.rotation.coords.as_slice().to_vec());
    let saved = format!("pose({translation:?}, turn({:?}, {}))", &xyzw[..3], xyzw[3]);
    fixture.wait_for(&format!("numpy.abs(placed['proj_view'] - {saved}).max() < 1e-11"));
    // The next nudge starts there.
    fixture.python("c.update_configuration({'x': 0.002})");
    fixture.wait_for("offset((0.003, 0, 0.25)) < 1e-11");
    fixture.python("trigger('/projector/revert')");
    fixture.wait_for("offset((0.001, 0, 0.25)) < 1e-11");
    // The file before the save is kept, and a second revert reaches it.
    assert_eq!(fs::read_to_string(fixture.file.with_extension("yaml.1")).unwrap(), FILE);
    let answer = fixture.python("trigger('/projector/revert')");
    assert_eq!(answer, format!("(True, '{} is as it was before the last save')", fixture.file.display()));
    fixture.wait_for("offset() < 1e-15");
    assert_eq!(fs::read_to_string(&fixture.file).unwrap(), FILE);
    // A third has nothing to take back.
    assert_eq!(fixture.python("trigger('/projector/revert')[0]"), "True");
    assert_eq!(fs::read_to_string(&fixture.file).unwrap(), FILE);
}

#[test]
fn a_file_that_cannot_be_written_and_one_without_the_frame_say_so() {
    let fixture = Fixture::start_with_pose(FILE);
    fs::set_permissions(&fixture.file, Permissions::from_mode(0o444)).unwrap();
    fixture.python("c.update_configuration({'x': 0.001})");
    fixture.wait_for("offset((0.001, 0, 0)) < 1e-12");
    fixture.projector.wait_for_error(&[
        "WARN",
        "the file is read-only",
        "make the file writable before /projector/save",
    ]);
    let answer = fixture.python("trigger('/projector/save')");
    assert!(answer.starts_with("(False, ") && answer.contains("cannot write: the file is read-only"), "{answer}");
    assert_eq!(fixture.python("c.get_configuration(300)['x']"), "0.001", "the nudge is kept");
    fs::set_permissions(&fixture.file, Permissions::from_mode(0o600)).unwrap();
    assert!(fixture.python("trigger('/projector/save')").starts_with("(True, "));
    assert_eq!(fs::read_to_string(&fixture.file).unwrap(), fixture.text_with("[0.110, 0.059, 0.05]"));
    drop(fixture);

    let fixture = Fixture::start(&FILE.replace("frame_id: proj_view", "frame_id: elsewhere"));
    let answer = "[c.update_configuration({'x': 0.1, 'yaw': 0.2})[n] for n in ('x', 'yaw')]";
    assert_eq!(fixture.python(answer), "[0.0, 0.0]");
    let reason = "frames: no entry has the child 'elsewhere', the CameraInfo's frame; add one";
    fixture.projector.wait_for_error(&["WARN", "nudging the projector failed", reason]);
    for service in ["save", "revert"] {
        let answer = fixture.python(&format!("trigger('/projector/{service}')"));
        assert!(answer.starts_with("(False, ") && answer.contains("no entry has the child"), "{answer}");
    }
    let refused = fixture.step("/proj/camera_info", ["0", "0.001", "0", "0"]);
    assert!(refused.starts_with("error /projector: ") && refused.contains(reason), "{refused}");
}

#[test]
fn a_step_moves_the_projector_along_the_axes_of_its_image() {
    let fixture = Fixture::start_with_pose(FILE);
    let nudged = fixture.step("/proj/camera_info", ["0", "0.001", "0", "0"]);
    assert_eq!(nudged, "nudged /projector [0.001, 0.0, 0.0, 0.0, 0.0, 0.0]");
    fixture.wait_for("offset((0.001, 0, 0)) < 1e-14");
    // In an image that is turned by a quarter to the right, right is up in the lens; steps add up.
    let nudged = fixture.step("/proj/camera_info", ["90", "0.001", "0", "0.01"]);
    assert_eq!(nudged, "nudged /projector [0.001, -0.001, 0.01, 0.0, 0.0, 0.0]");
    fixture.wait_for("offset((0.001, -0.001, 0.01)) < 1e-14");
    // After a turn, the steps follow the turned image.
    fixture.python("c.update_configuration({'x': 0.0, 'y': 0.0, 'z': 0.0, 'pitch': 0.5})");
    fixture.step("/proj/camera_info", ["0", "0.001", "0", "0"]);
    fixture.wait_for("offset((0.001 * numpy.cos(0.5), 0, -0.001 * numpy.sin(0.5)), (0, 0.5, 0)) < 1e-14");

    let error = fixture.step("/proj/camera_info", ["0", "0.6", "0", "0"]);
    assert!(error.starts_with("error /projector can be nudged by at most 0.5 m and rad; save"), "{error}");
    fixture.python("latch('/other/camera_info', info())");
    let error = fixture.step("/other/camera_info", ["0", "0.001", "0", "0"]);
    assert!(error.starts_with("error /other/camera_info is not published by a node projector"), "{error}");
}
