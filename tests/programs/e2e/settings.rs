//! Settings that change while the node runs: dynamic_reconfigure, the service `reload_config`, and the config's file.

use rcs_tests::programs::program;
use rcs_tests::python_node::PythonNode;
use rcs_tests::ros::{wait_until, RosMaster, Running, PATIENCE};
use rcs_tests::ros_fixture::{config, CameraPub, RosFixture, Setup, CLOUD};
use std::fs::{self, File};
use std::process::Command;
use std::time::Duration;

const CLIENT: &str = "from dynamic_reconfigure.client import Client\n\
     def client(name='CameraPub'): return Client('/camera_stream/' + name, timeout=300)\n\
     def described(c): return {p['name']: p for p in c.get_parameter_descriptions(300)}\n\
     def connections(topic): return sorted(c.id for c in publishers[topic].impl.connections)\n\
     def viewer_connections(): return [c.id for s in viewer.subscribers for c in s.impl.connections]\n\
     def corner(): return viewer.pixel(1, 1)\n";
/// Python that registers two publishers of `/other`: one never says where the topic is, the other never answers there.
const HANGING: &str = "
import os, socket, xmlrpc.client, xmlrpc.server
silent = [socket.create_server(('127.0.0.1', 0), backlog=50) for _ in range(2)]
ports = [server.getsockname()[1] for server in silent]
reached = [[], []]
def keep(index):
    while True: reached[index].append(silent[index].accept())
for index in range(2): threading.Thread(target=keep, args=(index,), daemon=True).start()
api = xmlrpc.server.SimpleXMLRPCServer(('127.0.0.1', 0), logRequests=False)
api.register_function(lambda *_: [1, '', ['TCPROS', '127.0.0.1', ports[1]]], 'requestTopic')
threading.Thread(target=api.serve_forever, daemon=True).start()
core = xmlrpc.client.ServerProxy(os.environ['ROS_MASTER_URI'])
for name, port in (('/asleep', ports[0]), ('/silent', api.server_address[1])):
    core.registerPublisher(name, '/other', 'sensor_msgs/PointCloud2', f'http://127.0.0.1:{port}/')
";
const BLACK: &str = "(0, 0, 0)";
const BLUE: &str = "(0, 0, 255)";
const RED: &str = "(255, 0, 0)";
const RELOAD: &str = "trigger('/camera_stream/reload_config')";

fn camera() -> CameraPub {
    CameraPub::default()
}

fn blue() -> CameraPub {
    CameraPub { background: "0; 0; 255", ..camera() }
}

/// A node whose image has a red square in its middle.
fn fixture(config: &str, args: &[&str]) -> RosFixture {
    let fixture = Setup::with_config(config.to_owned()).args(args).start();
    fixture.python("place_camera(); latch('/cloud', cloud(0xff0000))");
    fixture.python(CLIENT);
    fixture.python("viewer = Viewer('/view/image')");
    fixture.wait_for("viewer.middle() == (255, 0, 0)");
    fixture
}

/// What changes the file of a node that watches it, each from a red square on black; the last ends the node.
const SCENARIOS: [fn(&mut RosFixture); 4] = [
    saving_the_file_changes_the_image,
    images_go_on_when_the_file_changes_while_the_master_hangs,
    images_go_on_when_the_file_changes_while_publishers_hang_in_the_handshake,
    a_config_that_became_a_fifo_or_huge_is_refused_and_all_goes_on,
];

#[test]
fn a_watched_file_is_followed() {
    let mut fixture = fixture(&config(&[CLOUD], &[camera()]), &[]);
    for scenario in SCENARIOS {
        fixture.rewrite(&config(&[CLOUD], &[camera()]));
        fixture.wait_for(format!("corner() == {BLACK} and viewer.middle() == {RED}"));
        scenario(&mut fixture);
    }
}

#[test]
fn a_cameras_settings_are_offered_as_rqt_reconfigure_and_dynparam_expect_them() {
    let grouped = format!("{{Class: rviz/Group, Name: My sensors, Enabled: true, Displays: [{CLOUD}]}}");
    let fixture = fixture(&config(&[&grouped], &[camera()]), &["--no-watch"]);
    fixture.wait_for("__import__('dynamic_reconfigure').find_reconfigure_services() == ['/camera_stream', '/camera_stream/CameraPub', '/view/image/compressed']");
    fixture.python("c = client(); updates = []; c.set_config_callback(lambda config: updates.append(config))");

    let names =
        "blackout frame_rate background_red background_green background_blue image_encoding near_clip visibility \
                 show_My_sensors show_My_sensors_cloud";
    assert_eq!(fixture.python("' '.join(p['name'] for p in c.get_parameter_descriptions(300))"), names);
    let bounds = |name: &str| fixture.python(format!("[described(c)['{name}'][k] for k in ('type', 'min', 'max')]"));
    assert_eq!(bounds("near_clip"), "['double', 0.01, 100.0]");
    assert_eq!(bounds("background_red"), "['int', 0, 255]");
    let choices = "[e['value'] for e in eval(described(c)['image_encoding']['edit_method'])['enum']]";
    assert_eq!(fixture.python(choices), "['rgb8', 'rgba8', 'bgr8', 'bgra8', 'mono8', 'mono16']");
    let groups = "[(g, len(d['parameters'])) for g, d in c.get_group_descriptions()['groups'].items()]";
    assert_eq!(fixture.python(groups), "[('Visibility', 2)]");
    let values = "[c.get_configuration(300)[n] for n in ('frame_rate', 'image_encoding', 'near_clip', 'visibility')]";
    assert_eq!(fixture.python(values), "[-1.0, 'rgb8', 0.01, True]");
    assert_eq!(
        fixture.python("sorted(rospy.get_param('/camera_stream/CameraPub').items())[0]"),
        "('background_blue', 0)"
    );

    // The next image shows the new values; those out of bounds are clamped, and the answer has the clamped value.
    let answer =
        fixture.python("c.update_configuration({'background_blue': 999, 'background_green': -1})['background_blue']");
    assert_eq!(answer, "255");
    fixture.wait_for(format!("corner() == {BLUE} and viewer.middle() == {RED}"));
    fixture.wait_for(
        "updates[-1]['background_blue'] == 255 and rospy.get_param('/camera_stream/CameraPub/background_blue') == 255",
    );
    // A disabled group hides its displays.
    fixture.python("c.update_configuration({'show_My_sensors': False})");
    fixture.wait_for(format!("viewer.middle() == {BLUE}"));
    fixture.python("c.update_configuration({'show_My_sensors': True, 'show_My_sensors_cloud': False})");
    fixture.python("viewer.forget()");
    fixture.wait_for(format!("viewer.middle() == {BLUE}"));
    fixture.python("c.update_configuration({'show_My_sensors_cloud': True})");
    fixture.wait_for(format!("viewer.middle() == {RED}"));
    // The cloud is 2 m away.
    fixture.python("c.update_configuration({'near_clip': 2.5})");
    fixture.wait_for(format!("viewer.middle() == {BLUE}"));
    fixture.python("c.update_configuration({'near_clip': 0.0, 'image_encoding': 'bgr8'})");
    fixture.wait_for("viewer.last.encoding == 'bgr8' and viewer.middle() == (0, 0, 255)");
    fixture.python("c.update_configuration({'image_encoding': 'foo'})");
    fixture.wait_for_log("/CameraPub: image_encoding: unknown encoding \"foo\"").unwrap();
    let late = PythonNode::start(&fixture.master, &["__name:=late"]).unwrap();
    late.run(CLIENT).unwrap();
    assert_eq!(late.run("client().get_configuration(300)['near_clip']").unwrap(), "0.01", "published to late clients");
    // 0: only when triggered.
    fixture.python("c.update_configuration({'frame_rate': 0})");
    fixture.wait_for("viewer.quiet_secs() > 1");
}

#[test]
fn a_reload_changes_what_differs_and_nothing_else() {
    let fixture = fixture(&config(&[CLOUD], &[camera()]), &["--no-watch"]);
    fixture.python("before = connections('/cloud'), connections('/eye/camera_info'), viewer_connections()");
    assert_eq!(fixture.python(RELOAD), "(True, 'nothing changed')");
    // Another display before it and another background: the latched cloud is not received again and still shown.
    let grid = "{Class: rviz/Grid, Name: grid, Enabled: true, Reference Frame: elsewhere}";
    fixture.rewrite(&config(&[grid, CLOUD], &[blue()]));
    let answer = fixture.python(RELOAD);
    assert!(answer.starts_with("(True, ") && answer.contains("1 displays kept, 1 added, 0 removed"), "{answer}");
    fixture.wait_for(format!("corner() == {BLUE}"));
    fixture.python("viewer.forget()");
    fixture.wait_for(format!("viewer.middle() == {RED}"));
    // A display with other settings shows the same cloud with these.
    let outside = "viewer.pixel(12, 24)";
    assert_eq!(fixture.python(outside), BLUE);
    fixture.rewrite(&config(&[grid, &CLOUD.replace("Size (m): 1", "Size (m): 2")], &[blue()]));
    assert!(fixture.python(RELOAD).starts_with("(True, "));
    fixture.wait_for(format!("{outside} == {RED}"));
    assert_eq!(
        fixture.python("before == (connections('/cloud'), connections('/eye/camera_info'), viewer_connections())"),
        "True"
    );

    // Another topic, image topic and namespace: the old ones are unregistered, the new ones registered.
    let moved = CameraPub { image: "/other/image", namespace: "lamp", ..blue() };
    fixture.python("latch('/green', cloud(0x00ff00)); other = viewer; viewer = Viewer('/other/image')");
    fixture.rewrite(&config(&[&CLOUD.replace("/cloud", "/green")], &[moved]));
    assert!(fixture.python(RELOAD).starts_with("(True, "));
    fixture.wait_for("viewer.middle() == (0, 255, 0)");
    let subscribed = fixture.master.output("rostopic", &["list", "-s"]).unwrap();
    assert!(subscribed.contains("/green") && !subscribed.contains("/cloud"), "{subscribed}");
    let published = fixture.master.output("rostopic", &["list", "-p"]).unwrap();
    assert!(published.contains("/other/image") && !published.contains("/view/image"), "{published}");
    let services = fixture.master.output("rosservice", &["list"]).unwrap();
    assert!(services.contains("/lamp/camera_trigger") && !services.contains("\n/camera_trigger"), "{services}");
    assert_eq!(fixture.python("trigger('/lamp/camera_trigger')[0]"), "True");

    // Another fixed frame: the cloud is transformed into it.
    let text = config(&[&CLOUD.replace("/cloud", "/green")], &[CameraPub { image: "/other/image", ..camera() }]);
    fixture.rewrite(&text.replace("Fixed Frame: map", "Fixed Frame: world"));
    assert!(fixture.python(RELOAD).starts_with("(True, "));
    fixture.wait_for("len(viewer.images) > 0");
    fixture.python("latch('/tf_static', tf('world', 'map', xyz=(1, 2, 3)))");
    fixture.wait_for(format!("viewer.middle() == (0, 255, 0) and corner() == {BLACK}"));
}

#[test]
fn a_reconfigured_value_lasts_until_the_file_changes_it() {
    let fixture = fixture(&config(&[CLOUD], &[camera()]), &["--no-watch"]);
    fixture.python("c = client(); c.update_configuration({'background_blue': 255, 'show_cloud': False})");
    fixture.wait_for(format!("corner() == {BLUE} and viewer.middle() == {BLUE}"));
    // In the file the cloud is still enabled, and a display is added.
    let grid = "{Class: rviz/Grid, Name: grid, Enabled: true, Reference Frame: elsewhere}";
    fixture.rewrite(&config(&[CLOUD, grid], &[camera()]));
    assert!(fixture.python(RELOAD).starts_with("(True, "));
    fixture.wait_for("'show_grid' in c.get_configuration()");
    assert_eq!(
        fixture.python("c.get_configuration()['background_blue'], c.get_configuration()['show_cloud']"),
        "(255, False)"
    );
    fixture.python("viewer.forget()");
    fixture.wait_for(format!("viewer.middle() == {BLUE}"));
    // Values that changed in the file are taken over and published.
    let green = CameraPub { background: "0; 255; 0", ..camera() };
    fixture.rewrite(&config(&[CLOUD, grid], std::slice::from_ref(&green)));
    assert!(fixture.python(RELOAD).starts_with("(True, "));
    fixture.wait_for("viewer.middle() == (0, 255, 0) and c.get_configuration()['background_green'] == 255");
    assert_eq!(fixture.python("c.get_configuration()['show_cloud']"), "False");
    // A second camera is added with parameters of its own, and removed with them.
    let second = CameraPub { name: "Second eye", image: "/second/image", namespace: "second", ..camera() };
    fixture.rewrite(&config(&[CLOUD, grid], &[green.clone(), second]));
    assert!(fixture.python(RELOAD).starts_with("(True, "));
    assert_eq!(fixture.python("client('Second_eye').get_configuration(300)['background_green']"), "0");
    fixture.rewrite(&config(&[CLOUD, grid], &[green]));
    assert!(fixture.python(RELOAD).starts_with("(True, "));
    fixture.wait_for("__import__('dynamic_reconfigure').find_reconfigure_services() == ['/camera_stream', '/camera_stream/CameraPub', '/view/image/compressed']");
    // A display that is removed takes its switch along: added again it is seen, as in rviz.
    for displays in [&[grid][..], &[CLOUD, grid]] {
        fixture.rewrite(&config(displays, &[camera()]));
        assert!(fixture.python(RELOAD).starts_with("(True, "));
    }
    fixture.wait_for(format!("viewer.middle() == {RED}"));
    fixture.wait_for("c.get_configuration()['show_cloud']");
}

fn images_go_on_when_the_file_changes_while_the_master_hangs(fixture: &mut RosFixture) {
    fixture.master.signal("STOP");
    // Another subscription, another topic and another service: all of it is for the master to know.
    let other = CLOUD.replace("Name: cloud", "Name: other").replace("/cloud", "/other");
    let second = CameraPub { name: "Second eye", image: "/second/image", namespace: "second", ..camera() };
    fixture.rewrite(&config(&[CLOUD, &other], &[blue(), second]));
    fixture.images_go_on(90);
    fixture.wait_for(format!("corner() == {BLUE}"));
    // It is told as soon as it answers.
    fixture.master.signal("CONT");
    fixture.python("second = Viewer('/second/image')");
    fixture.wait_for(format!("second.middle() == {RED}"));
}

fn images_go_on_when_the_file_changes_while_publishers_hang_in_the_handshake(fixture: &mut RosFixture) {
    fixture.python(HANGING);
    let other = CLOUD.replace("Name: cloud", "Name: other").replace("/cloud", "/other");
    fixture.rewrite(&config(&[CLOUD, &other], &[blue()]));
    fixture.images_go_on(60);
    fixture.wait_for(format!("corner() == {BLUE} and all(reached)"));
    // Nor does leaving them wait for their answers.
    fixture.rewrite(&config(&[CLOUD], &[camera()]));
    fixture.images_go_on(60);
    fixture.wait_for(format!("corner() == {BLACK} and viewer.middle() == {RED}"));
}

#[test]
fn a_file_that_cannot_be_read_changes_nothing() {
    let fixture = fixture(&config(&[CLOUD], &[camera()]), &["_watch:=false"]);
    fixture.rewrite("Visualization Manager: {Displays: [\n");
    let answer = fixture.python(RELOAD);
    assert!(answer.starts_with("(False, '") && answer.contains("scene.rviz:2:") && !answer.contains("\\n"), "{answer}");
    fixture.rewrite(&config(&[], &[CameraPub { image: "/no name/image", ..camera() }]));
    let answer = fixture.python(RELOAD);
    assert!(answer.starts_with("(False, ") && answer.contains("no name"), "{answer}");
    fixture.python("viewer.forget()");
    fixture.wait_for(format!("viewer.middle() == {RED}"));
    // The file is not watched: nothing may happen for longer than a watched file takes to be read.
    fixture.rewrite(&config(&[CLOUD], &[blue()]));
    std::thread::sleep(Duration::from_secs(2));
    assert_eq!(fixture.python("corner()"), BLACK);
    assert_eq!(fixture.log_lines(&["the config changed"]), 0, "{}", fixture.log());
}

fn a_config_that_became_a_fifo_or_huge_is_refused_and_all_goes_on(fixture: &mut RosFixture) {
    let file = fixture.config_file();
    let become_fifo = || {
        fs::remove_file(&file).unwrap();
        assert!(Command::new("mkfifo").arg(&file).status().unwrap().success());
        // Longer than a watched file takes to be read.
        std::thread::sleep(Duration::from_secs(1));
    };
    become_fifo();
    let answer = fixture.python(RELOAD);
    assert!(answer.starts_with("(False, ") && answer.contains("it is a FIFO"), "{answer}");
    fs::remove_file(&file).unwrap();
    File::create(&file).unwrap().set_len(40 << 30).unwrap();
    fixture.wait_for_log("cannot be read: larger than 8 MB").unwrap();
    fixture.rewrite(&config(&[CLOUD], &[blue()]));
    fixture.wait_for(format!("corner() == {BLUE} and viewer.middle() == {RED}"));
    become_fifo();
    assert!(fixture.node.end("TERM").unwrap().success());
}

/// As `-d <(…)` gives it to the node in a shell.
#[test]
fn a_config_from_a_pipe_is_read_at_the_start_only() {
    let master = RosMaster::start().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.rviz");
    fs::write(&file, config(&[CLOUD], &[camera()])).unwrap();
    let mut command = master.environment(Command::new("bash"));
    command.args(["-c", "exec \"$0\" -d <(cat \"$1\") --renderer cpu"]).arg(program("camera_stream")).arg(&file);
    let node = Running::start(&mut command).unwrap();
    let log = || node.errors().join("\n");
    assert!(wait_until(PATIENCE, || log().contains("drawing ")), "{}", log());
    std::thread::sleep(Duration::from_secs(1));
    let answer = master.output("rosservice", &["call", "/camera_stream/reload_config"]).unwrap();
    assert!(answer.contains("success: False") && answer.contains("it is a FIFO"), "{answer}");
    assert!(!log().contains("the config changed"), "{}", log());
}

fn saving_the_file_changes_the_image(fixture: &mut RosFixture) {
    fixture.python("before = connections('/cloud'), viewer_connections()");
    fixture.rewrite(&config(&[CLOUD], &[blue()]));
    fixture.wait_for(format!("corner() == {BLUE}"));
    // A file that is half written is not taken over.
    let green = config(&[CLOUD], &[CameraPub { background: "0; 255; 0", ..camera() }]);
    fixture.rewrite(&green[..green.find("Background").unwrap()]);
    fixture.wait_for_log("cannot be read, so the previous one is kept").unwrap();
    fixture.python("viewer.forget()");
    fixture.wait_for(format!("corner() == {BLUE} and viewer.middle() == {RED}"));
    fixture.rewrite(&green);
    fixture.wait_for("corner() == (0, 255, 0)");
    // Many editors write another file and rename it to the old one.
    let beside = fixture.config_file().with_extension("tmp");
    std::fs::write(&beside, config(&[CLOUD], &[camera()])).unwrap();
    std::fs::rename(&beside, fixture.config_file()).unwrap();
    fixture.wait_for(format!("corner() == {BLACK} and viewer.middle() == {RED}"));
    assert_eq!(fixture.python("before == (connections('/cloud'), viewer_connections())"), "True");
}

/// What `dynparam set` does: a process connects, sets one value and is gone, with its connections to the node's topics.
#[test]
fn clients_that_set_a_value_and_leave_are_no_warning_and_no_error() {
    let fixture = fixture(&config(&[CLOUD], &[camera()]), &["--no-watch"]);
    for blue in [10, 200, 30, 255] {
        let mut set = fixture.master.environment(Command::new("python3"));
        let script = format!(
            "import rospy\nfrom dynamic_reconfigure.client import Client\nrospy.init_node('dynparam', anonymous=True)\n\
             Client('/camera_stream/CameraPub', timeout=300).update_configuration({{'background_blue': {blue}}})"
        );
        let output = set.args(["-c", &script]).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        fixture.wait_for(format!("corner() == (0, 0, {blue})"));
    }
    // What is published to a connection that has ended fails at the latest with the second message.
    fixture.python("c = client()");
    for blue in [1, 2, 3, 255] {
        fixture.python(format!("c.update_configuration({{'background_blue': {blue}}})"));
    }
    fixture.wait_for(format!("corner() == {BLUE}"));
    let log = fixture.log();
    assert!(!["ERROR", "WARN", "Broken pipe"].iter().any(|word| log.contains(word)), "{log}");
}
