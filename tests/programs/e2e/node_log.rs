//! The node's log as roscpp's: on `/rosout`, with its time, in the file of `__log:=`, with levels that can be changed.

use rcs_tests::ros::{wait_until, RosMaster, Running, PATIENCE, PROMPT};
use rcs_tests::ros_fixture::{config, master_and_python, CameraPub, RosFixture, Setup, CLOUD};
use std::fs::{self, File};
use std::io::Write;
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::process::{Command, Stdio};
use std::time::Duration;

/// What the log says of a config that was saved again.
const RELOADED: &str = "1 displays kept, 0 added, 0 removed";

fn fixture(args: &[&str]) -> RosFixture {
    Setup::of(&[CLOUD]).args(args).start()
}

#[test]
fn lines_are_on_rosout_with_level_name_and_topics() {
    let fixture = fixture(&["__name:=eyes"]);
    fixture.python(
        "from rosgraph_msgs.msg import Log\n\
         lines = []\n\
         rosout = rospy.Subscriber('/rosout', Log, lambda m: lines.append(m) if m.name == '/eyes' else None)\n",
    );
    // A late subscriber gets the last line.
    fixture.wait_for("len(lines) == 1");
    fixture.rewrite("Visualization Manager: {Displays: [\n");
    fixture.wait_for("any('cannot be read' in line.msg and line.level == Log.WARN for line in lines)");
    let fields = "lines[-1].file.endswith('.rs'), lines[-1].line > 0, '/view/image' in lines[-1].topics, \
                  abs(lines[-1].header.stamp.to_sec() - time.time()) < 3600, lines[0].level == Log.INFO";
    assert_eq!(fixture.python(fields), "(True, True, True, True, True)", "{}", fixture.python("lines[-1]"));
    assert!(fixture.master.output("rosnode", &["info", "/eyes"]).unwrap().contains("/rosout [rosgraph_msgs/Log]"));
}

#[test]
fn levels_are_changed_as_rqt_logger_level_does() {
    let fixture = fixture(&[]);
    let loggers = fixture.master.output("rosservice", &["call", "/camera_stream/get_loggers"]).unwrap();
    let names: Vec<&str> = loggers.lines().map(|line| line.trim_start_matches(['-', ' ']).trim()).collect();
    let expected =
        ["loggers:", "name: \"ros\"", "level: \"error\"", "name: \"ros.rviz_camera_stream\"", "level: \"info\""];
    assert_eq!(names.iter().filter(|line| !line.is_empty()).copied().collect::<Vec<_>>(), expected);
    let set = |logger: &str, level: &str| {
        fixture.master.output("rosservice", &["call", "/camera_stream/set_logger_level", logger, level]).unwrap()
    };
    let save = |background: &'static str| {
        fixture.rewrite(&config(&[CLOUD], &[CameraPub { background, ..CameraPub::default() }]));
        fixture.wait_for(format!(
            "Client('/camera_stream/CameraPub').get_configuration(30)['background_red'] == {background:.1}"
        ));
    };
    fixture.python("from dynamic_reconfigure.client import Client");
    save("1; 0; 0");
    fixture.wait_for_log(RELOADED).unwrap();
    // What it logs at this level is no longer logged.
    set("ros.rviz_camera_stream", "error");
    save("2; 0; 0");
    set("ros.rviz_camera_stream", "DEBUG");
    save("3; 0; 0");
    assert!(wait_until(PATIENCE, || fixture.log_lines(&[RELOADED]) == 2), "{}", fixture.log());
    let mut refused = fixture.master.command("rosservice");
    let refused = refused.args(["call", "/camera_stream/set_logger_level", "x", "info"]).output().unwrap();
    assert!(!refused.status.success());
    assert!(String::from_utf8_lossy(&refused.stderr).contains("no logger 'x'"), "{refused:?}");
}

/// Severity, and seconds with nine digits behind the point.
fn has_roscpps_beginning(line: &str) -> bool {
    let Some(rest) = line.strip_prefix("[ INFO] [").or_else(|| line.strip_prefix("[ WARN] [")) else { return false };
    let Some((time, _)) = rest.split_once("]: ") else { return false };
    let is_number = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    time.split_once('.')
        .is_some_and(|(secs, nanos)| secs.len() == 10 && nanos.len() == 9 && is_number(secs) && is_number(nanos))
}

#[test]
fn the_file_that_roslaunch_names_gets_all_lines_with_their_time() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("camera_stream-1.log");
    let fixture = fixture(&[&format!("__log:={}", file.display())]);
    let log = fixture.log();
    assert!(log.lines().all(has_roscpps_beginning), "{log}");
    assert_eq!(fs::read_to_string(&file).unwrap().trim_end(), log);
}

/// As roslaunch starts a node with `output="log"`.
#[test]
fn where_standard_output_is_a_file_information_goes_there() {
    let master = RosMaster::start().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let (scene, output) = (folder.path().join("scene.rviz"), folder.path().join("stdout.log"));
    fs::write(&scene, config(&[CLOUD], &[CameraPub::default()])).unwrap();
    let mut command = master.program("camera_stream");
    command.arg("-d").arg(&scene).args(["--renderer", "cpu"]);
    command.env("ROSCONSOLE_FORMAT", "${node}|${severity}|${message}");
    let mut node =
        command.stdin(Stdio::null()).stdout(File::create(&output).unwrap()).stderr(Stdio::piped()).spawn().unwrap();
    let printed = || fs::read_to_string(&output).unwrap();
    let is_ready = wait_until(PATIENCE, || printed().contains("/camera_stream| INFO|drawing CameraPub"));
    // Fails where it has ended already.
    let _ = Command::new("kill").arg(node.id().to_string()).status();
    node.wait().unwrap();
    assert!(is_ready, "{}", printed());
}

/// A terminal that was stopped with Ctrl-S, or a pipe whose reader hangs.
#[test]
fn a_log_that_nobody_reads_stops_neither_images_nor_calls_nor_the_end() {
    let (master, python) = master_and_python("");
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.rviz");
    fs::write(&scene, config(&[CLOUD], &[CameraPub::default()])).unwrap();
    let (_reader, full) = UnixStream::pair().unwrap();
    full.set_nonblocking(true).unwrap();
    while (&full).write(&[b'\n'; 4096]).is_ok() {}
    full.set_nonblocking(false).unwrap();
    let mut command = master.program("camera_stream");
    command.arg("-d").arg(&scene).args(["--renderer", "cpu"]).stdin(Stdio::null()).stdout(Stdio::null());
    let mut node = command.stderr(OwnedFd::from(full)).spawn().unwrap();
    python.run("place_camera()").unwrap();
    python.run("latch('/cloud', cloud(0xff0000)); viewer = Viewer('/view/image')").unwrap();
    let is_drawn = python.wait_for(PATIENCE, "viewer.middle() == (255, 0, 0)");
    let answer = is_drawn.then(|| python.run("trigger('/camera_stream/reload_config')").unwrap());
    // Fails where it has ended already.
    let _ = Command::new("kill").arg(node.id().to_string()).status();
    let has_ended = wait_until(PROMPT, || node.try_wait().unwrap().is_some());
    let _ = node.kill();
    let status = node.wait().unwrap();
    assert_eq!(answer.as_deref(), Some("(True, 'nothing changed')"));
    assert!(has_ended);
    assert_eq!(status.code(), Some(0));
}

#[test]
fn a_camera_info_that_does_not_come_is_one_warning() {
    let fixture = fixture(&[]);
    fixture.python("viewer = Viewer('/view/image')");
    fixture.wait_for_log("No CameraInfo received on [/eye/camera_info]").unwrap();
    fixture.python("latch('/eye/camera_info', info()); latch('/cloud', cloud(0xff0000))");
    // In the meantime the frame is missing, which is no line of its own.
    std::thread::sleep(Duration::from_millis(500));
    fixture.python("latch('/tf_static', tf('map', 'eye'))");
    fixture.wait_for_log("camera CameraPub: ok").unwrap();
    assert_eq!(fixture.log_lines(&["No CameraInfo"]), 1, "{}", fixture.log());
}

/// The small programs log in the same way.
#[test]
fn small_nodes_log_on_rosout_too() {
    let master = RosMaster::start().unwrap();
    let file = rcs_tests::programs::repository().join("config/projector.yaml");
    let _node = Running::start(master.program("projector").arg(file)).unwrap();
    let services = || master.output("rosservice", &["list"]).unwrap();
    assert!(wait_until(PATIENCE, || services().contains("/projector/set_logger_level")), "{}", services());
    assert!(master.output("rosnode", &["info", "/projector"]).unwrap().contains("/rosout [rosgraph_msgs/Log]"));
}

/// `program` fails after it has connected with the master.
fn the_last_line_is_everywhere(program_name: &str, args: &[&str], reason: &str) {
    let (master, python) = master_and_python(
        "from rosgraph_msgs.msg import Log\n\
             lines = []\n\
             rosout = rospy.Subscriber('/rosout', Log, lambda m: lines.append(m) if m.name == '/fails' else None)\n",
    );
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("fails.log");
    let mut command = master.program(program_name);
    command.args(args).arg("__name:=fails").arg(format!("__log:={}", file.display()));
    let mut node = Running::start(&mut command).unwrap();
    assert_eq!(node.wait(PATIENCE).and_then(|status| status.code()), Some(1), "{:?}", node.errors());
    let last = node.errors().last().cloned().unwrap_or_default();
    assert!(last.starts_with("[ERROR] [") && last.contains(reason), "{last}");
    assert_eq!(fs::read_to_string(&file).unwrap().lines().last(), Some(last.as_str()));
    let is_heard = format!("any({reason:?} in line.msg and line.level == Log.ERROR for line in lines)");
    assert!(python.wait_for(PATIENCE, &is_heard), "{}", python.run("lines").unwrap());
    // It is unregistered, too.
    let nodes = master.output("rosnode", &["list"]).unwrap();
    assert!(!nodes.contains("/fails"), "{nodes}");
}

#[test]
fn the_error_that_ends_a_small_node_is_the_last_line_of_its_log() {
    the_last_line_is_everywhere("projector", &[], "no projector file");
}

#[test]
fn the_error_that_ends_the_node_is_the_last_line_of_its_log() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.rviz");
    fs::write(&scene, config(&[CLOUD], &[CameraPub::default()])).unwrap();
    let args = ["-d", scene.to_str().unwrap(), "_renderer:=foo"];
    the_last_line_is_everywhere("camera_stream", &args, "foo");
}
