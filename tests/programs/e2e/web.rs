//! The operator's page of a live node: images, state, parameters, and who may use it.

use rcs_tests::ros_fixture::{config, CameraPub, RosFixture, Setup, CLOUD};

/// Python that is a page: a WebSocket of raw bytes, and POSTs.
const PAGE: &str = include_str!("web.py");
/// Words before the page's address in the log.
const ADDRESS: &str = "the operator's page: ";

/// A node with a red square before the camera and a page that nobody has opened yet: `URL` is its address.
fn fixture(args: &[&str]) -> RosFixture {
    let args = [args, &["--web", "0"]].concat();
    let fixture = Setup::of(&[CLOUD]).args(&args).start();
    fixture.python("place_camera()");
    fixture.python("latch('/cloud', cloud(0xff0000))");
    prepare_page(&fixture);
    fixture
}

/// Defines what opens the page of a node with `--web`.
fn prepare_page(fixture: &RosFixture) {
    fixture.wait_for_log("#token=").unwrap();
    let log = fixture.log();
    let url = log.lines().find_map(|line| line.split_once(ADDRESS)).unwrap().1;
    fixture.python(PAGE);
    fixture.python(format!("URL = '{}'", url.trim()));
}

/// Opens the page of a node with `--web`, as `page`.
pub(crate) fn open_page(fixture: &RosFixture) {
    prepare_page(fixture);
    fixture.python("page = Page(URL)");
}

#[test]
fn a_page_shows_the_image_and_the_statuses_and_counts_as_a_subscriber() {
    let fixture = fixture(&[]);
    fixture.python("page = Page(URL)");
    fixture.wait_for("page.images and page.state.get('displays')");
    assert_eq!(
        fixture.python("[page.images[-1][key] for key in ('camera', 'full_width', 'full_height')]"),
        "['CameraPub', 64, 48]"
    );
    assert_eq!(fixture.python("page.masks[-1]['width'], page.masks[-1]['full_width']"), "(1, 64)");
    // With a new cloud, the image changes.
    fixture.python("old = page.images[-1]['file']");
    fixture.python("latch('/cloud', cloud(0x00ff00))");
    fixture.wait_for("page.images[-1]['file'] != old");
    fixture.python("camera = page.state['cameras'][0]");
    assert_eq!(
        fixture.python("[camera[key] for key in ('name', 'topic', 'frame', 'size', 'encoding', 'dark')]"),
        "['CameraPub', '/view/image', 'eye', [64, 48], 'rgb8', None]"
    );
    fixture.wait_for("any(display['path'] == 'cloud' for display in page.state['displays'])");
    fixture.python("cloud_display = [d for d in page.state['displays'] if d['path'] == 'cloud'][0]");
    assert_eq!(
        fixture.python("[cloud_display[key] for key in ('class', 'topic', 'level', 'advice', 'switches')]"),
        "['rviz/PointCloud2', '/cloud', 'ok', None, {'CameraPub': {'name': 'show_cloud', 'on': True}}]"
    );
    fixture.wait_for("any('drawing ' in line['text'] for line in page.lines)");
    // Nothing is drawn for a page that is closed.
    fixture.python("page.close()");
    fixture.python("second = Page(URL, [])");
    fixture.wait_for("second.state.get('cameras')");
    assert_eq!(fixture.python("second.images"), "[]");
    assert!(!fixture.log().contains("panicked"));
}

#[test]
fn a_page_sets_parameters_and_a_missing_topic_has_advice() {
    let fixture = fixture(&[]);
    fixture.python("viewer = Viewer('/view/image')");
    fixture.python("page = Page(URL)");
    fixture.wait_for("viewer.middle() == (255, 0, 0) and page.state.get('reconfigure')");
    fixture.python("server = page.state['cameras'][0]['parameters']");
    fixture.python("parameters = {p['name']: p for p in page.state['reconfigure'][0]['parameters']}");
    assert_eq!(
        fixture.python("server, [parameters['image_encoding'][key] for key in ('type', 'value')]"),
        "('/camera_stream/CameraPub', ['str', 'rgb8'])"
    );
    assert_eq!(fixture.python("'bgra8' in [c['value'] for c in parameters['image_encoding']['choices']]"), "True");
    assert_eq!(
        fixture.python("page.post('parameters', {'server': server, 'values': {'show_cloud': False}})"),
        "(200, 'show_cloud set')"
    );
    fixture.wait_for("viewer.middle() == (0, 0, 0)");
    fixture
        .wait_for("not [d for d in page.state['displays'] if d['path'] == 'cloud'][0]['switches']['CameraPub']['on']");
    fixture.wait_for_log("show_cloud set by the page at 127.0.0.1").unwrap();
    let post =
        |values: &str| fixture.python(format!("page.post('parameters', {{'server': server, 'values': {values}}})"));
    assert_eq!(post("{'near_clip': 'x'}"), "(400, 'near_clip: \"x\" is no double')");
    assert_eq!(
        fixture.python("page.post('parameters', {'server': '/other', 'values': {}})"),
        "(400, 'server: there is no server /other')"
    );
    assert_eq!(fixture.python("page.post('parameters', {}, token='0' * 32)[0]"), "401");
    let other = CLOUD.replace("/cloud", "/nobody").replace("Name: cloud", "Name: missing");
    fixture.rewrite(&config(&[CLOUD, &other], &[CameraPub::default()]));
    fixture.wait_for(
        "[d['advice'] for d in page.state['displays'] if d['path'] == 'missing'] == \
         ['start the publisher, or correct the topic in the config']",
    );
}

#[test]
fn a_page_blacks_out_pauses_and_shows_test_images_and_all_pages_say_so() {
    let fixture = fixture(&[]);
    fixture.python("viewer = Viewer('/view/image')");
    fixture.python("page, other = Page(URL), Page(URL)");
    fixture.wait_for("viewer.middle() == (255, 0, 0) and page.state and other.state");
    assert_eq!(fixture.python("page.post('blackout', {'on': True, 'camera': None})"), "(200, 'all cameras: black')");
    fixture.wait_for("viewer.middle() == (0, 0, 0)");
    let by_page = "{'on': True, 'by': 'the page at 127.0.0.1'}";
    fixture
        .wait_for(format!("other.state['blackout'] == {by_page} and 'blackout' in other.state['cameras'][0]['dark']"));
    fixture.wait_for("other.answer('blackout', {'on': False}) == (200, 'all cameras: released')");
    fixture.wait_for("viewer.middle() == (255, 0, 0) and not page.state['blackout']['on']");
    assert_eq!(fixture.python("page.post('blackout', {'on': True, 'camera': 'CameraPub'})[0]"), "200");
    fixture.wait_for("viewer.middle() == (0, 0, 0) and other.state['cameras'][0]['blackout']");
    fixture.wait_for("other.answer('blackout', {'on': False, 'camera': 'CameraPub'})[0] == 200");
    fixture.wait_for("viewer.middle() == (255, 0, 0) and not page.state['cameras'][0]['black']");
    assert_eq!(fixture.python("page.post('pause', {'on': True})[0]"), "200");
    fixture.wait_for("page.answer('test_picture', {'name': 'grid'}) == (200, 'test picture: grid')");
    fixture.wait_for(format!("other.state['paused'] == {by_page} and other.state['test_picture']"));
    assert_eq!(fixture.python("page.post('blackout', {'on': 1})"), "(400, 'on: neither true nor false')");
    assert_eq!(
        fixture.python("page.post('blackout', {'on': True, 'camera': 'x'})"),
        "(400, 'camera: there is no camera x')"
    );
    assert_eq!(fixture.python("page.post('nudge', {'camera': 'CameraPub', 'right_m': 0.001})[0]"), "409");
}

#[test]
fn what_may_light_answers_the_present_state_and_is_young() {
    let fixture = fixture(&[]);
    fixture.python("viewer = Viewer('/view/image')");
    fixture.python("page = Page(URL)");
    fixture.wait_for("viewer.middle() == (255, 0, 0) and page.state");
    fixture.python("page.send({'type': 'black', 'camera': None})");
    fixture.wait_for("viewer.middle() == (0, 0, 0) and page.state['blackout']['on']");
    fixture.wait_for_log("all cameras: blackout on by the page at 127.0.0.1").unwrap();
    let outdated = "(409, 'the state has changed since; look at it, and press again')";
    for (name, body) in [
        ("blackout", "{'on': False}"),
        ("blackout", "{'on': False, 'camera': 'CameraPub'}"),
        ("pause", "{'on': False}"),
        ("test_picture", "{}"),
    ] {
        let answer = |how: &str| fixture.python(format!("page.answer('{name}', {body}, {how})"));
        assert_eq!(answer("number=page.state['number'] - 1"), outdated, "{name}");
        let late = answer("late_ms=2000");
        assert!(late.starts_with("(409, 'it is older than 2 s: "), "{name}: {late}");
        assert!(answer("late_ms=-60000").contains("future"), "{name}");
        assert_eq!(
            fixture.python(format!("page.post('{name}', {body})")),
            "(400, 'number: missing; the state has it')"
        );
    }
    let parameters = "{'server': page.state['cameras'][0]['parameters'], 'values': {'blackout': False}}";
    let refused = "(400, 'there is no parameter blackout')";
    assert_eq!(fixture.python(format!("page.post('parameters', {parameters})")), refused);
    // A Black that nobody has seen makes a release void.
    fixture.python("seen = page.state['number']");
    fixture.python("page.post('blackout', {'on': True})");
    assert_eq!(fixture.python("page.answer('blackout', {'on': False}, number=seen)"), outdated);
    fixture.wait_for("page.state['number'] > seen");
    assert_eq!(fixture.python("viewer.middle()"), "(0, 0, 0)");
    fixture.wait_for("page.answer('blackout', {'on': False})[0] == 200");
    fixture.wait_for("viewer.middle() == (255, 0, 0)");
}

#[test]
fn the_token_is_on_standard_error_alone_and_a_taken_port_ends_the_node() {
    let fixture = fixture(&["--web-hosts", "robot.local"]);
    fixture
        .python("from rosgraph_msgs.msg import Log\nlines = []\nSUB = rospy.Subscriber('/rosout', Log, lines.append)");
    fixture.wait_for("lines");
    fixture.python("page = Page(URL)");
    fixture.wait_for("page.lines");
    let with_token =
        "[line for line in [l.msg for l in lines] + [l['text'] for l in page.lines] if page.token in line]";
    assert_eq!(fixture.python(with_token), "[]");
    let port = fixture.python("int(page.address.split(':')[1])");
    let mut second = fixture.master.program("camera_stream");
    second.arg("-d").arg(fixture.config_file()).args(["--renderer", "cpu", "--web", &port, "__name:=second"]);
    let output = second.output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        !output.status.success() && errors.contains(&format!("--web: cannot listen at 127.0.0.1:{port}")),
        "{errors}"
    );
}
