//! The operator's settings: `~blackout`, `~pause`, `~test_picture`, a camera's `blackout`, and the keys of its window.

use std::time::Duration;

use crate::load::LOAD;
use crate::viewers::{saved, Screen};
use rcs_tests::python_node::PythonNode;
use rcs_tests::ros::{wait_until, PATIENCE};
use rcs_tests::ros_fixture::{config, CameraPub, RosFixture, Setup, CLOUD};

/// A wall of one colour before the whole view.
const WALL: &str = "
from std_srvs.srv import SetBool
def wall(color, stamp=rospy.Time()):
    return cloud(color, points=[(0.5 * x, 0.5 * y, 2) for x in range(-6, 7) for y in range(-6, 7)], stamp=stamp)
def switch(service, on):
    rospy.wait_for_service(service, 300)
    answer = rospy.ServiceProxy(service, SetBool)(on)
    return answer.success, answer.message
def blackout(on):
    return switch('/camera_stream/blackout', on)
def pause(on):
    return switch('/camera_stream/pause', on)
def set_up_view(width=64, height=48, f=50.0):
    place_camera(width=width, height=height, f=f)
def set_up(*size):
    set_up_view(*size)
    latch('/cloud', wall(0xff0000))
def is_black():
    return viewer.last is not None and max(viewer.last.data) == 0
";
const CLIENT: &str = "import dynamic_reconfigure.client\n\
     client = dynamic_reconfigure.client.Client('/camera_stream/CameraPub', timeout=300)";
const RED: &str = "viewer.middle() == (255, 0, 0)";
const BLUE: &str = "viewer.middle() == (0, 0, 255)";
const MARKERS: &str = "{Class: rviz/MarkerArray, Name: markers, Enabled: true, Marker Topic: /markers}";

/// An operator's scenarios on a node without arguments, each from a red wall.
const SCENARIOS: [fn(&RosFixture); 4] = [
    a_blackout_is_black_until_it_is_released_and_then_the_image_is_the_current_one,
    diagnostics_say_who_has_set_what,
    each_new_image_has_a_record_that_joins_it,
    a_script_shows_cues_and_one_that_is_not_possible_changes_nothing,
];

/// Scenarios of an operator whose node has a window on a screen.
const SCENARIOS_OF_A_WINDOW: [fn(&RosFixture, &Screen); 4] = [
    the_key_of_a_window_blacks_out_its_camera_and_the_service_releases_it,
    test_images_come_one_after_the_other_and_then_the_scene,
    the_record_of_an_image_in_a_window_comes_when_the_x_server_has_it,
    // Its markers stay.
    a_blackout_does_not_wait_for_the_scene_that_is_being_drawn,
];

/// Takes back what a scenario has set, and waits for the wall.
const BACK: &str = "blackout(False); pause(False); viewer.forget(); latch('/cloud', wall(0xff0000))";

#[test]
fn an_operator_is_obeyed() {
    let fixture = fixture(&[]);
    for scenario in SCENARIOS {
        fixture.python(BACK);
        fixture.wait_for(RED);
        scenario(&fixture);
    }
}

#[test]
fn an_operator_is_obeyed_in_a_window() {
    let screen = Screen::start();
    let fixture = with_window(&screen, &[]);
    for scenario in SCENARIOS_OF_A_WINDOW {
        fixture.python(BACK);
        assert!(wait_until(PATIENCE, || is_red(&screen)), "{}", fixture.log());
        fixture.wait_for(RED);
        scenario(&fixture, &screen);
    }
}

fn fixture(args: &[&str]) -> RosFixture {
    let fixture = Setup::of(&[CLOUD, MARKERS]).args(args).start();
    fixture.python(WALL);
    fixture.python("viewer = Viewer('/view/image'); set_up()");
    fixture
}

/// A node with a window on a screen.
fn with_window(screen: &Screen, args: &[&str]) -> RosFixture {
    let setup = Setup::of(&[CLOUD, MARKERS]).args(&["--window", "auto"]).args(args);
    let fixture = setup.on_screen(&screen.display).start();
    fixture.python(WALL);
    fixture.python("viewer = Viewer('/view/image'); set_up(640, 360, 300.0)");
    fixture
}

fn is_black(screen: &Screen) -> bool {
    screen.pixels().iter().all(|level| *level == 0)
}

fn is_red(screen: &Screen) -> bool {
    screen.pixels().chunks_exact(3).all(|pixel| *pixel == [255, 0, 0])
}

fn a_blackout_is_black_until_it_is_released_and_then_the_image_is_the_current_one(fixture: &RosFixture) {
    assert_eq!(fixture.python("blackout(True)"), "(True, 'all cameras are black')");
    fixture.wait_for("is_black()");
    fixture.python("viewer.forget(); latch('/cloud', wall(0x0000ff))");
    fixture.python("late = Viewer('/view/image')");
    fixture.wait_for("late.last is not None and max(late.last.data) == 0");
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(fixture.python("viewer.colors in ([], [(0, 0, 0)])"), "True");
    fixture.python("viewer.forget()");
    assert_eq!(fixture.python("blackout(False)"), "(True, 'all blackouts are released')");
    fixture.wait_for(BLUE);
    assert_eq!(fixture.python("(255, 0, 0) in viewer.colors"), "False", "never the old one");
    let caller = fixture.python("rospy.get_name()");
    fixture.wait_for_log(&format!("all cameras: blackout on by {caller}")).unwrap();
    fixture.wait_for_log(&format!("camera CameraPub: the picture is black: blackout by {caller}")).unwrap();
    fixture.wait_for_log(&format!("all cameras: blackout off by {caller}")).unwrap();
}

fn diagnostics_say_who_has_set_what(fixture: &RosFixture) {
    fixture.python("monitor()");
    let caller = fixture.python("rospy.get_name()");
    fixture.python("blackout(True); pause(True); trigger('/camera_stream/test_picture')");
    fixture.wait_for(format!("values('camera_stream: CameraPub').get('Dark', '').endswith('blackout by {caller}')"));
    fixture.wait_for(format!("'paused by {caller}' in values('camera_stream: CameraPub').get('Pause', '')"));
    fixture.wait_for(format!("'{caller}' in values('camera_stream: Global Status').get('Blackout', '')"));
    fixture.wait_for("'name' in values('camera_stream: Global Status').get('Test picture', '')");
    fixture.python("while trigger('/camera_stream/test_picture')[1] != 'the scene': pass");
}

fn a_blackout_does_not_wait_for_the_scene_that_is_being_drawn(fixture: &RosFixture, screen: &Screen) {
    fixture.python(LOAD);
    // Markers behind the wall, which are placed again and again.
    fixture.python("array = crowd(100000, Marker.ARROW)");
    fixture.python("sending = PublishRepeatedly(5, lambda i: array, '/markers')");
    for _ in 0..5 {
        fixture.python("viewer.forget(); begun = time.time(); blackout(True)");
        let took: f64 = fixture.python("time.time() - begun").parse().unwrap();
        assert!(wait_until(PATIENCE, || is_black(screen)), "{}", fixture.log());
        fixture.wait_for("is_black()");
        let black = fixture.python("[i[0] for i in viewer.images][-1] - begun");
        println!("answered after {took:.3} s, black on the topic after {black} s");
        fixture.python("viewer.forget()");
        std::thread::sleep(Duration::from_millis(300));
        assert!(is_black(screen));
        assert_eq!(fixture.python("viewer.colors in ([], [(0, 0, 0)])"), "True", "nothing that was begun before");
        fixture.python("blackout(False)");
        assert!(wait_until(PATIENCE, || is_red(screen)), "{}", fixture.log());
        fixture.wait_for(RED);
    }
}

#[test]
fn a_cameras_switch_blacks_out_that_camera_and_the_service_releases_it() {
    let left = CameraPub { name: "Left", image: "/left/image", namespace: "left", ..CameraPub::default() };
    let fixture = Setup::with_cameras(&[CLOUD], &[CameraPub::default(), left]).start();
    fixture.python(WALL);
    fixture.python("viewer, left = Viewer('/view/image'), Viewer('/left/image'); set_up()");
    fixture.python(CLIENT);
    fixture.wait_for(format!("{RED} and left.middle() == (255, 0, 0)"));
    fixture.python(
        "updates = []; client.set_config_callback(lambda config: updates.append(config and config['blackout']))",
    );
    assert_eq!(fixture.python("client.update_configuration({'blackout': True})['blackout']"), "True");
    fixture.wait_for("is_black() and rospy.get_param('/camera_stream/CameraPub/blackout')");
    fixture.wait_for_log("camera CameraPub: blackout on by /").unwrap();
    fixture.python("left.forget(); latch('/cloud', wall(0x0000ff))");
    fixture.wait_for("left.middle() == (0, 0, 255) and is_black()");
    fixture.python("blackout(False)");
    fixture.wait_for(format!("{BLUE} and updates[-1] == False"));
    fixture.python("client.update_configuration({'blackout': True})");
    fixture.wait_for("is_black()");
    fixture.python("client.update_configuration({'blackout': False})");
    fixture.wait_for(BLUE);
}

fn the_key_of_a_window_blacks_out_its_camera_and_the_service_releases_it(fixture: &RosFixture, screen: &Screen) {
    screen.press_until_logged(fixture, "b", "camera CameraPub: blackout on by key b");
    fixture.wait_for("is_black()");
    assert!(wait_until(PATIENCE, || is_black(screen)), "{}", fixture.log());
    (0..3).for_each(|_| screen.press("b"));
    std::thread::sleep(Duration::from_millis(300));
    assert!(is_black(screen), "black is no toggle");
    fixture.python("blackout(True)");
    screen.press_until_logged(fixture, "shift+l", "camera CameraPub: blackout off by key Shift+L");
    std::thread::sleep(Duration::from_millis(300));
    assert!(is_black(screen) && fixture.python("is_black()") == "True", "the service holds");
    screen.press_until_logged(fixture, "b", "camera CameraPub: blackout on by key b");
    fixture.python("blackout(False)");
    assert!(wait_until(PATIENCE, || is_red(screen)), "{}", fixture.log());
    fixture.wait_for(RED);
}

#[test]
fn a_blackout_survives_a_respawn_and_its_release_too() {
    let mut fixture = fixture(&["--blackout"]);
    fixture.wait_for("is_black() and rospy.get_param('/camera_stream/blackout') == True");
    fixture.python("blackout(False)");
    fixture.wait_for(format!("{RED} and rospy.get_param('/camera_stream/blackout') == False"));
    fixture.python(CLIENT);
    let respawn = |fixture: &mut RosFixture| {
        fixture.node.signal("KILL");
        assert!(fixture.node.wait(PATIENCE).is_some());
        fixture.python("viewer.forget()");
        fixture.respawn().unwrap();
    };
    respawn(&mut fixture);
    fixture.wait_for(RED);
    fixture.python("blackout(True)");
    fixture.wait_for("rospy.get_param('/camera_stream/blackout') == True");
    respawn(&mut fixture);
    fixture.wait_for("is_black()");
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(fixture.python("viewer.colors"), "[(0, 0, 0)]", "never lit");
    fixture.python("blackout(False)");
    fixture.wait_for(RED);
    fixture.python("client.update_configuration({'blackout': True})");
    fixture.wait_for("rospy.get_param('/camera_stream/CameraPub/blackout') == True");
    respawn(&mut fixture);
    fixture.wait_for("is_black()");
    fixture.python("blackout(False)");
    fixture.wait_for(RED);
}

#[test]
fn a_blackout_outlives_the_master_and_the_name_of_its_camera() {
    let mut fixture = fixture(&[]);
    fixture.wait_for(RED);
    fixture.python(CLIENT);
    fixture.python("client.update_configuration({'blackout': True}); blackout(True)");
    fixture.wait_for("is_black()");
    fixture.python("rospy.delete_param('/camera_stream/blackout')");
    fixture.node.signal("KILL");
    assert!(fixture.node.wait(PATIENCE).is_some());
    fixture.python("viewer.forget()");
    fixture.respawn().unwrap();
    fixture.wait_for("is_black() and rospy.get_param('/camera_stream/blackout') == True");
    // As rviz saves a config in which the camera has another name.
    fixture.python("blackout(False)");
    fixture.wait_for(RED);
    fixture.python("client.update_configuration({'blackout': True})");
    fixture.wait_for("is_black()");
    let renamed = config(&[CLOUD, MARKERS], &[CameraPub { name: "Projector", ..CameraPub::default() }]);
    fixture.rewrite(&renamed);
    fixture.wait_for_log("camera Projector: black, because CameraPub was").unwrap();
    fixture.python("viewer.forget(); latch('/cloud', wall(0x0000ff))");
    std::thread::sleep(Duration::from_millis(700));
    assert_eq!(fixture.python("viewer.colors in ([], [(0, 0, 0)])"), "True", "never lit");
    fixture.python("blackout(False)");
    fixture.wait_for(BLUE);
}

#[test]
fn masks_without_stamps_that_waited_while_the_node_was_stopped_light_nothing() {
    let fixture = fixture(&["--mask-topic", "/mask"]);
    fixture.python(MASK);
    fixture.python("unstamped = lambda i: (lambda m: (setattr(m.header, 'stamp', rospy.Time()), m)[1])(mask())");
    fixture.python("masks.stop(); masks = PublishRepeatedly(20, unstamped, '/mask')");
    fixture.wait_for(RED);
    fixture.node.signal("STOP");
    std::thread::sleep(Duration::from_secs(3));
    // The queue is full of old ones, and no new one comes.
    fixture.python("masks.stop(); viewer.forget()");
    fixture.node.signal("CONT");
    fixture.wait_for("is_black()");
    std::thread::sleep(Duration::from_millis(1500));
    assert_eq!(fixture.python("viewer.colors"), "[(0, 0, 0)]");
}

#[test]
fn a_pause_keeps_the_image_until_its_data_are_stale() {
    let fixture = Setup::of(&[CLOUD]).args(&["--stale-timeout", "1"]).start();
    fixture.python(WALL);
    // What a latching publisher sent would not age.
    fixture.python("viewer = Viewer('/view/image'); set_up_view()");
    let publisher = PythonNode::start(&fixture.master, &["__name:=publisher"]).unwrap();
    publisher.run(WALL).unwrap();
    publisher.run("color = [0xff0000]").unwrap();
    publisher.run("PublishRepeatedly(20, lambda i: wall(color[0], rospy.Time.now()), '/cloud')").unwrap();
    fixture.wait_for(RED);
    assert_eq!(fixture.python("pause(True)"), "(True, 'all cameras are paused')");
    publisher.run("color[0] = 0x0000ff").unwrap();
    std::thread::sleep(Duration::from_millis(1500));
    assert_eq!(fixture.python(RED), "True", "it is paused while data are current");
    fixture.python(CLIENT);
    fixture.python("client.update_configuration({'near_clip': 0.5})");
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(fixture.python(RED), "True", "settings apply when the pause ends");
    fixture.python("blackout(True)");
    fixture.wait_for("is_black()");
    fixture.python("blackout(False)");
    fixture.wait_for(BLUE);
    publisher.run("color[0] = 0xff0000").unwrap();
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(fixture.python(BLUE), "True", "the pause goes on with the first image after a blackout");
    drop(publisher);
    fixture.wait_for("is_black()");
    assert_eq!(fixture.python("pause(False)"), "(True, 'no camera is paused')");
}

/// A mask that is dark on the right of a column.
const MASK: &str = "column = [64]
def mask():
    message = Image(width=64, height=48, step=64, encoding='mono8')
    message.header.stamp = rospy.Time.now()
    message.data = bytes([255] * column[0] + [0] * (64 - column[0])) * 48
    return message
def lit_columns():
    rows = [bytes(viewer.last.data[192 * v : 192 * (v + 1)]) for v in range(48)]
    lit = [u for u in range(64) if any(row[3 * u : 3 * u + 3] != b'\\0\\0\\0' for row in rows)]
    return (min(lit), max(lit)) if lit else None
masks = PublishRepeatedly(20, lambda i: mask(), '/mask')";

#[test]
fn masks_apply_to_paused_images_and_to_test_images() {
    let fixture = fixture(&["--mask-topic", "/mask"]);
    fixture.python(MASK);
    fixture.wait_for(format!("{RED} and lit_columns() == (0, 63)"));
    fixture.python("pause(True); latch('/cloud', wall(0x0000ff)); column[0] = 40");
    fixture.wait_for(format!("{RED} and lit_columns() == (0, 39)"));
    fixture.python("column[0] = 64");
    fixture.wait_for(format!("{RED} and lit_columns() == (0, 63)"));
    fixture.python("pause(False)");
    fixture.wait_for(BLUE);
    // The border is lit along all edges.
    assert_eq!(fixture.python("[trigger('/camera_stream/test_picture') for _ in range(2)][-1]"), "(True, 'border')");
    fixture.wait_for("lit_columns() == (0, 63) and viewer.pixel(0, 0) == (255, 255, 255)");
    fixture.python("column[0] = 40");
    fixture.wait_for("lit_columns() == (0, 39) and viewer.pixel(0, 0) == (255, 255, 255)");
    fixture.python("blackout(True)");
    fixture.wait_for("is_black()");
    fixture.python("blackout(False)");
    fixture.wait_for("lit_columns() == (0, 39)");
    fixture.python("masks.stop()");
    fixture.wait_for("is_black()");
}

fn test_images_come_one_after_the_other_and_then_the_scene(fixture: &RosFixture, screen: &Screen) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("picture");
    for name in ["name", "border", "orientation", "grid", "checkerboard", "crosshair", "ramp"] {
        fixture.python("viewer.forget()");
        let answer = fixture.python("trigger('/camera_stream/test_picture')");
        assert_eq!(answer, format!("(True, '{name}')"));
        fixture.wait_for("viewer.last is not None");
        let is_same = || saved(&fixture.python, &file) == screen.pixels();
        assert!(wait_until(PATIENCE, is_same), "{name}: {}", fixture.log());
    }
    assert_eq!(fixture.python("trigger('/camera_stream/test_picture')"), "(True, 'the scene')");
    fixture.wait_for(RED);
    assert!(wait_until(PATIENCE, || is_red(screen)), "{}", fixture.log());
}

/// Receives the records of what was shown.
const RECORDS: &str = "
from sensor_msgs.msg import TimeReference
records = []
recorder = rospy.Subscriber('/view/shown', TimeReference, records.append)
def joined():
    stamps = {image[2] for image in viewer.images}
    return [record.source for record in records if record.header.stamp.to_sec() in stamps]";

fn each_new_image_has_a_record_that_joins_it(fixture: &RosFixture) {
    fixture.python(RECORDS);
    fixture.wait_for("recorder.get_num_connections() == 1");
    fixture.python("viewer.forget(); latch('/cloud', wall(0x0000ff, rospy.Time(12, 34)))");
    fixture.wait_for(format!("{BLUE} and records and records[-1].source == 'CameraPub;;12.000000034'"));
    assert_eq!(fixture.python("joined()[-1:]"), "['CameraPub;;12.000000034']");
    assert_eq!(fixture.python("0 <= (records[-1].time_ref - records[-1].header.stamp).to_sec() < 60"), "True");
    let caller = fixture.python("rospy.get_name()");
    fixture.python("blackout(True)");
    fixture.wait_for(format!("records[-1].source == 'CameraPub;blackout by {caller};'"));
    let count = fixture.python("len(records)");
    // The same image again.
    fixture.python("trigger('/camera_trigger'), trigger('/camera_trigger')");
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(fixture.python("len(records)"), count);
}

fn the_record_of_an_image_in_a_window_comes_when_the_x_server_has_it(fixture: &RosFixture, screen: &Screen) {
    fixture.python(RECORDS);
    fixture.wait_for("recorder.get_num_connections() == 1");
    screen.signal("STOP");
    fixture.python("viewer.forget(); latch('/cloud', wall(0x0000ff, rospy.Time(12, 34)))");
    fixture.wait_for(BLUE);
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(fixture.python("records"), "[]", "it is not on the screen yet");
    screen.signal("CONT");
    fixture.wait_for("'CameraPub;;12.000000034' in joined()");
    fixture.python("blackout(True)");
    fixture.wait_for("records[-1].source.startswith('CameraPub;blackout by ')");
}

/// Sets settings of all cameras; an error of the node is none of the values.
const SETTINGS: &str = "
import dynamic_reconfigure.client
settings = dynamic_reconfigure.client.Client('/camera_stream', timeout=300)
def configure(**values):
    try: return settings.update_configuration(values)['brightness']
    except dynamic_reconfigure.DynamicReconfigureCallbackException: return None
def reds(): return [color[0] for color in viewer.colors]";

#[test]
fn the_brightness_dims_all_outputs_and_fades_without_new_data() {
    let screen = Screen::start();
    let fixture = with_window(&screen, &["--brightness", "0.5"]);
    let is_half = || screen.pixels().chunks_exact(3).all(|pixel| *pixel == [128, 0, 0]);
    fixture.wait_for("viewer.middle() == (128, 0, 0)");
    assert!(wait_until(PATIENCE, is_half), "{}", fixture.log());
    fixture.python(SETTINGS);
    assert_eq!(fixture.python("settings.get_configuration(300)['brightness']"), "0.5");
    fixture.python("viewer.forget(); configure(fade_seconds=3.0, brightness=1.0)");
    fixture.wait_for(RED);
    assert!(wait_until(PATIENCE, || is_red(&screen)), "{}", fixture.log());
    let colors = fixture.python("reds()");
    assert_eq!(fixture.python("reds() == sorted(reds()) and len(reds()) > 4"), "True", "{colors}");
    // Out of range, nothing changes: neither to the nearest value nor the one beside it.
    for wrong in ["brightness=7.0", "brightness=-1.0", "brightness=float('nan')", "brightness=0.1, fade_seconds=9.0"] {
        assert_eq!(fixture.python(format!("configure({wrong})")), "None", "{wrong}");
    }
    let values = "[rospy.get_param('/camera_stream/' + name) for name in ('brightness', 'fade_seconds')]";
    assert_eq!(fixture.python(values), "[1.0, 3.0]");
    assert_eq!(fixture.python("viewer.middle()"), "(255, 0, 0)");
    fixture.wait_for_log("nothing changed: brightness: 7 is no number from 0 to 1").unwrap();
    // A blackout does not wait for a fade, and its release does not start one.
    fixture.python("configure(fade_seconds=5.0, brightness=0.2); viewer.forget(); blackout(True)");
    fixture.wait_for("is_black()");
    assert_eq!(fixture.python("configure(fade_seconds=0.0, brightness=0.4)"), "0.4");
    fixture.python("viewer.forget(); blackout(False)");
    fixture.wait_for("viewer.middle() == (102, 0, 0)");
    assert_eq!(fixture.python("set(reds()) <= {0, 102}"), "True");
    // A paused image is dimmed, too, and back again.
    fixture.python("pause(True); configure(brightness=0.0)");
    fixture.wait_for("is_black()");
    fixture.python("latch('/cloud', wall(0x0000ff)); configure(brightness=1.0)");
    fixture.wait_for(RED);
}

const CUES: &str = "cues:
- name: both
  brightness: 1.0
  cameras: {CameraPub: [cloud, markers]}
- name: dim
  brightness: 0.4
  cameras: {CameraPub: [cloud]}
- name: nothing
  brightness: 1.0
  cameras: {CameraPub: []}
";

/// A script asks for cues by topic, service and dynamic_reconfigure.
const SCRIPT: &str = "
from std_msgs.msg import String
shown = []
listener = rospy.Subscriber('/camera_stream/cue', String, lambda message: shown.append(message.data))
asking = rospy.Publisher('/camera_stream/set_cue', String, queue_size=10)";

fn a_script_shows_cues_and_one_that_is_not_possible_changes_nothing(fixture: &RosFixture) {
    let file = fixture.config_file().with_extension("cues.yaml");
    fixture.python(SETTINGS);
    fixture.python(SCRIPT);
    fixture.wait_for("shown == [''] and asking.get_num_connections() == 1");
    let none = fixture.python("trigger('/camera_stream/next_cue')");
    assert!(none.starts_with("(False, 'there are no cues"), "{none}");
    std::fs::write(&file, CUES).unwrap();
    let next = |fixture: &RosFixture| fixture.python("trigger('/camera_stream/next_cue')");
    assert_eq!([next(fixture), next(fixture)], ["(True, 'both')", "(True, 'dim')"]);
    fixture.wait_for("viewer.middle() == (102, 0, 0) and shown[-1] == 'dim'");
    assert_eq!(fixture.python("settings.get_configuration(300)['cue']"), "dim");
    fixture.python("asking.publish('nothing')");
    fixture.wait_for(
        "is_black() and shown[-1] == 'nothing' and not rospy.get_param('/camera_stream/CameraPub/show_cloud')",
    );
    assert_eq!(fixture.python("configure(cue='both')"), "1.0");
    fixture.wait_for(format!("{RED} and shown[-1] == 'both'"));
    // What is not possible is no cue and nothing near it.
    let faults = [
        (CUES.to_owned(), "no such cue", "there is no cue 'no such cue'; cues: both, dim, nothing"),
        (CUES.replace("[cloud]", "[cloud, nobody]"), "dim", "the config has no display 'nobody'"),
        (CUES.replace("CameraPub: [cloud]", "Other: [cloud]"), "dim", "the config has no camera Other"),
        (CUES.replace("{CameraPub: [cloud]}", "{}"), "dim", "it says nothing about camera CameraPub"),
        (CUES.replace("0.4", "4"), "nothing", "brightness: 4 is no number from 0 to 1"),
        (CUES[..CUES.len() - 30].to_owned(), "dim", "scene.cues.yaml"),
    ];
    for (text, name, why) in faults {
        std::fs::write(&file, text).unwrap();
        assert_eq!(fixture.python(format!("configure(cue='{name}')")), "None", "{why}");
        fixture.wait_for_log(why).unwrap();
        assert_eq!(fixture.python("viewer.middle(), shown[-1]"), "((255, 0, 0), 'both')", "{why}");
    }
    // Whatever else is set ends the cue.
    std::fs::write(&file, CUES).unwrap();
    fixture.python("configure(brightness=0.9)");
    fixture.wait_for("shown[-1] == ''");
    // A blackout stays.
    fixture.python("blackout(True)");
    assert_eq!(fixture.python("configure(cue='both')"), "1.0");
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(fixture.python("is_black()"), "True");
}
