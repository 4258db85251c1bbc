//! `camera_stream check --live`: its table and exit codes against a running ROS.

use rcs_tests::ros::{RosMaster, Running, PATIENCE};
use rcs_tests::ros_fixture::{config, master_and_python, CameraPub, CLOUD};
use std::io::{Read as _, Write as _};
use std::net::TcpListener;
use std::path::Path;
use std::process::Output;

fn check(master: &RosMaster, file: &Path, args: &[&str]) -> Output {
    master.program("camera_stream").args(["check", "--live"]).arg(file).args(args).output().unwrap()
}

fn file(content: &str) -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.rviz");
    std::fs::write(&path, content).unwrap();
    (folder, path)
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Whether a row contains these words in this order.
fn has_row(table: &str, words: &[&str]) -> bool {
    table.lines().any(|line| {
        let mut rest = line;
        words.iter().all(|word| match rest.split_once(word) {
            Some((_, after)) => {
                rest = after;
                true
            }
            None => false,
        })
    })
}

#[test]
fn the_table_names_what_is_missing_and_exits_with_1_or_with_0_if_nothing_is() {
    let (master, python) = master_and_python("place_camera()");
    python
        .run("latch('/wrong', info()); latch('/lost', cloud(0xff0000, 'nowhere')); latch('/cloud', cloud(0xff0000))")
        .unwrap();
    let cloud =
        |name: &str, topic: &str| format!("{{Class: rviz/PointCloud2, Name: {name}, Enabled: true, Topic: {topic}}}");
    let displays = [cloud("silent", "/silent"), cloud("wrong", "/wrong"), cloud("lost", "/lost")];
    let mut displays: Vec<&str> = displays.iter().map(String::as_str).collect();
    displays.push("{Class: rviz/Path, Name: off, Enabled: false, Topic: /silent}");
    displays.push(CLOUD);
    let (_folder, path) = file(&config(&displays, &[CameraPub::default()]));
    let output = check(&master, &path, &["--listen", "2"]);
    let table = text(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{table}\n{}", text(&output.stderr));
    let rows: [&[&str]; 8] = [
        &["DISPLAY", "CLASS", "TOPIC", "STATUS", "TEXT"],
        &["Global Status", "Ok", "Fixed Frame: OK"],
        &["silent", "rviz/PointCloud2", "/silent", "Warn", "Topic: No messages received"],
        &["silent", "rviz/PointCloud2", "/silent", "Warn", "No publishers on [/silent]"],
        &["wrong", "rviz/PointCloud2", "/wrong", "Error", "sensor_msgs/CameraInfo", "sensor_msgs/PointCloud2"],
        &["lost", "rviz/PointCloud2", "/lost", "Warn", "For frame [nowhere]: Frame [nowhere] does not exist"],
        &["cloud", "rviz/PointCloud2", "/cloud", "Ok", "1 messages received"],
        &["CameraPub", "rviz_camera_stream/CameraPub", "/view/image", "Ok", "Camera Info: OK"],
    ];
    for row in rows {
        assert!(has_row(&table, row), "{row:?} is not in\n{table}");
    }
    assert!(!table.contains("off"), "{table}");

    let (_folder, path) = file(&config(&[CLOUD], &[CameraPub::default()]));
    let output = check(&master, &path, &["--listen", "2"]);
    assert_eq!(output.status.code(), Some(0), "{}{}", text(&output.stdout), text(&output.stderr));
    // In place of the node's launch line, whose name and private parameters it has, too, with the node running.
    let mut node = master.program("camera_stream");
    let line = ["-f", "map", "--splash-screen", "", "--renderer", "cpu", "__name:=eyes", "_projection:=exact"];
    let node = Running::start(node.arg("-d").arg(&path).args(line)).unwrap();
    node.wait_for_error(&["drawing "]);
    let mut command = master.program("camera_stream");
    command.args(["check", "--live", "--listen", "2", "-d"]).arg(&path).args(line);
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}{}", text(&output.stdout), text(&output.stderr));
    assert!(master.output("rosnode", &["list"]).unwrap().lines().any(|name| name == "/eyes"), "{:?}", node.errors());
    assert_eq!(check(&master, &path, &["_projection:=voodoo"]).status.code(), Some(2));
    // The parameter that a launch file set for the node.
    master.output("rosparam", &["set", "/ears/projection", "voodoo"]).unwrap();
    let output = check(&master, &path, &["__name:=ears"]);
    assert_eq!(output.status.code(), Some(2), "{}{}", text(&output.stdout), text(&output.stderr));
    let elsewhere = check(&master, &path, &["--listen", "1", "--fixed-frame", "elsewhere"]);
    assert!(has_row(&text(&elsewhere.stdout), &["Global Status", "Error", "Unknown frame elsewhere"]));
    // Topics are remapped as for the node.
    let output = check(&master, &path, &["--listen", "2", "/cloud:=/silent"]);
    assert_eq!(output.status.code(), Some(1), "{}{}", text(&output.stdout), text(&output.stderr));
    assert!(text(&output.stdout).contains("[/silent]"), "{}", text(&output.stdout));
}

#[test]
fn without_a_master_or_a_config_it_exits_with_2_and_a_signal_ends_the_listening() {
    let mut master = RosMaster::reserve().unwrap();
    let (_folder, path) = file(&config(&[CLOUD], &[CameraPub::default()]));
    let output = check(&master, &path, &["--listen", "600"]);
    let error = text(&output.stderr);
    assert_eq!((output.status.code(), error.lines().count()), (Some(2), 1), "{error}");
    assert!(error.contains(&master.uri()), "{error}");
    assert!(output.stdout.is_empty());
    assert_eq!(check(&master, Path::new("/nowhere/scene.rviz"), &[]).status.code(), Some(2));

    master.run().unwrap();
    let mut running =
        Running::start(master.program("camera_stream").args(["check", "--live", "--listen", "600"]).arg(&path))
            .unwrap();
    let is_listening = || master.output("rosnode", &["list"]).is_ok_and(|nodes| nodes.contains("camera_stream_check"));
    assert!(rcs_tests::ros::wait_until(PATIENCE, is_listening), "{:?}", running.errors());
    running.signal("INT");
    assert_eq!(running.wait(PATIENCE).and_then(|status| status.code()), Some(1), "{:?}", running.errors());
    assert!(running.line_with("No messages received").is_some(), "{:?}", running.lines());
}

/// Line breaks in the text of an XML-RPC fault stay within the one line of the error.
#[test]
fn a_master_that_answers_with_a_fault_of_two_lines_is_one_line() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let uri = format!("http://{}/", listener.local_addr().unwrap());
    let member = |name: &str, value: &str| format!("<member><name>{name}</name><value>{value}</value></member>");
    let fault = member("faultCode", "<int>1</int>") + &member("faultString", "<string>first\nsecond</string>");
    let body = format!("<methodResponse><fault><value><struct>{fault}</struct></value></fault></methodResponse>");
    std::thread::spawn(move || {
        for stream in listener.incoming() {
            let mut stream = stream.unwrap();
            let _ = stream.read(&mut [0; 4096]);
            let _ = write!(stream, "HTTP/1.1 200 OK\r\nContent-Length: {}\r\n\r\n{body}", body.len());
        }
    });
    let master = RosMaster::reserve().unwrap();
    let (_folder, path) = file(&config(&[CLOUD], &[CameraPub::default()]));
    let output = master
        .program("camera_stream")
        .args(["check", "--live"])
        .arg(&path)
        .env("ROS_MASTER_URI", &uri)
        .output()
        .unwrap();
    let error = text(&output.stderr);
    assert_eq!((output.status.code(), error.lines().count()), (Some(2), 1), "{error}");
    assert!(error.contains("first second") && error.contains(&uri), "{error}");
}

#[test]
fn a_publisher_that_is_dead_is_in_the_table() {
    let (master, python) = master_and_python("place_camera()");
    // Nobody listens at this port.
    let register = "import rosgraph; rosgraph.Master('/dead').registerPublisher\
                    ('/cloud', 'sensor_msgs/PointCloud2', 'http://127.0.0.1:9/')";
    python.run(register).unwrap();
    let (_folder, path) = file(&config(&[CLOUD], &[CameraPub::default()]));
    let output = check(&master, &path, &["--listen", "3"]);
    let (table, errors) = (text(&output.stdout), text(&output.stderr));
    assert_eq!(output.status.code(), Some(1), "{table}\n{errors}");
    let row = ["cloud", "/cloud", "Warn", "Publisher: Failed to contact publisher [/dead] for topic [/cloud]: "];
    assert!(has_row(&table, &row), "{table}");
    assert_eq!(errors.matches("Failed to contact publisher [/dead]").count(), 1, "{errors}");
}
