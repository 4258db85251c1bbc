//! `~surface`: light only where a depth camera measures the surface that it is meant for.

use std::time::Duration;

use crate::web::open_page;
use rcs_tests::ros::PATIENCE;
use rcs_tests::ros_fixture::{RosFixture, Setup, CLOUD};

/// A second display, which draws `/labels` to the left of the square of `/cloud`.
const LABELS: &str = "{Class: rviz/PointCloud2, Name: labels, Enabled: true, Topic: /labels, Style: Flat Squares, \
     Size (m): 1, Color Transformer: RGB8, Position Transformer: XYZ, Queue Size: 10, Alpha: 1, Decay Time: 0}";
const ALL_BLACK: &str = "viewer.last and max(viewer.last.data) == 0";

/// A depth camera beside the projector that looks at a wall, and a hand that may be in front of it.
const DEPTH_CAMERA: &str = include_str!("confirmed_light.py");

/// A node with a square of 1 m at 2 m, and a depth camera that is silent yet.
fn fixture(args: &[&str]) -> RosFixture {
    let args = [&["--surface", "/cam/depth/image_raw", "--confirm-margin", "1"], args].concat();
    let fixture = Setup::of(&[CLOUD, LABELS]).args(&args).start();
    fixture.python(DEPTH_CAMERA);
    fixture.python("RED, GREEN, BLACK = (255, 0, 0), (0, 255, 0), (0, 0, 0)");
    fixture.python("def corner(): return viewer.pixel(20, 13)");
    fixture.python("def label(): return viewer.pixel(7, 24)");
    fixture
}

#[test]
fn light_on_a_hand_or_of_an_object_that_is_gone_is_dark_with_the_next_depth_image() {
    // Single depth images stay current.
    let fixture = fixture(&["--stale-timeouts", "/cam/depth/image_raw=never"]);
    fixture.wait_for(format!("{ALL_BLACK} and len(viewer.images) > 2"));
    fixture.wait_for_log("the picture is black: no current surface on /cam/depth/image_raw").unwrap();
    fixture.python("masks = []");
    fixture.python("mask_subscriber = rospy.Subscriber('/view/confirmed', Image, masks.append)");
    fixture.python("camera = stream()");
    fixture.wait_for("viewer.middle() == RED == corner()");
    fixture.wait_for("masks and masks[-1].encoding == 'mono8' and masks[-1].data[24 * 64 + 32] == 255");
    fixture.python("camera.stop()");
    fixture.python("hand[0] = True");
    fixture.python("send(TOPIC, depth_image())");
    fixture.wait_for("viewer.middle() == BLACK and corner() == RED");
    fixture.wait_for("masks[-1].data[24 * 64 + 32] == 0 and masks[-1].data[13 * 64 + 20] == 255");
    fixture.python("hand[0] = False");
    fixture.python("camera = stream()");
    fixture.wait_for("viewer.middle() == RED");
    fixture.python("camera.stop()");
    fixture.python("wall[0] = 2.5");
    fixture.python("send(TOPIC, depth_image())");
    fixture.wait_for("viewer.middle() == BLACK == corner()");
}

#[test]
fn a_stale_surface_is_dark_whatever_is_lit_where_nothing_is_seen() {
    let fixture = fixture(&["_unseen:=light"]);
    fixture.python("camera = stream()");
    fixture.wait_for("viewer.middle() == RED");
    fixture.python("camera.stop()");
    fixture.wait_for(ALL_BLACK);
    // Its age by the stamp or by the arrival, whichever was noticed first.
    fixture.wait_for_log("the picture is black: surface on /cam/depth/image_raw: ").unwrap();
    fixture.python("camera = stream()");
    fixture.wait_for("viewer.middle() == RED");
    // A CameraInfo that does not fit leaves no surface.
    fixture.python("latch('/cam/depth/camera_info', info('sensor', 40, 30, 30.0))");
    fixture.wait_for(ALL_BLACK);
    fixture.wait_for_log("the depth image has 80x60 pixels, its CameraInfo 40x30").unwrap();
}

#[test]
fn depth_images_slower_than_their_limit_light_nothing() {
    let fixture = fixture(&[]);
    fixture.python("camera = stream()");
    fixture.wait_for("viewer.middle() == RED");
    fixture.python("camera.stop()");
    fixture.wait_for(ALL_BLACK);
    fixture.python("viewer.forget()");
    for _ in 0..4 {
        fixture.python("send(TOPIC, depth_image())");
        std::thread::sleep(Duration::from_millis(700));
    }
    assert_eq!(fixture.python("viewer.colors"), "[(0, 0, 0)]");
}

#[test]
fn only_the_light_of_listed_displays_is_confirmed() {
    let fixture = fixture(&["--confirm", "cloud"]);
    fixture.python("camera = stream()");
    fixture.wait_for("viewer.middle() == RED and label() == GREEN");
    fixture.python("wall[0] = 2.5");
    fixture.wait_for("viewer.middle() == BLACK and label() == GREEN");
    // With all, a label in the air has no surface.
    let fixture = self::fixture(&[]);
    fixture.python("camera = stream()");
    fixture.wait_for("viewer.middle() == RED and label() == BLACK");
}

#[test]
fn an_organised_cloud_is_a_surface_and_another_is_an_error() {
    let fixture = fixture(&["_surface:=[{camera: CameraPub, topic: /cam/points}]"]);
    // The command line's wins, so this node has no parameter.
    drop(fixture);
    let fixture = Setup::of(&[CLOUD]).args(&["_surface:=[{camera: CameraPub, topic: /cam/points}]"]).start();
    fixture.python(DEPTH_CAMERA);
    fixture.python("rows = [60]");
    fixture.python("camera = PublishRepeatedly(20, lambda i: depth_cloud(rows[0]), '/cam/points')");
    fixture.wait_for("viewer.middle() == (255, 0, 0)");
    fixture.python("rows[0] = 1");
    fixture.wait_for(ALL_BLACK);
    fixture.wait_for_log("surface on /cam/points: the cloud is not organised: it has 1 row").unwrap();
}

#[test]
fn a_display_that_the_config_does_not_have_is_refused_with_the_one_that_was_meant() {
    for (args, expected_status) in [
        (vec!["--surface", "/cam/points", "--confirm", "clod"], 2),
        (vec!["_surface:=/cam/points", "_confirm:=[labels, clod]"], 1),
    ] {
        let mut fixture = Setup::of(&[CLOUD, LABELS]).args(&args).launch();
        let status = fixture.node.wait(PATIENCE).and_then(|status| status.code());
        assert_eq!(status, Some(expected_status), "{args:?}: {}", fixture.log());
        let words = ["the config has no display 'clod'", "did you mean 'cloud'?", "displays: cloud, labels"];
        assert_eq!(fixture.log_lines(&words), 1, "{args:?}: {}", fixture.log());
    }
}

#[test]
fn the_shares_are_on_diagnostics_and_the_page_and_a_scene_is_not_drawn_again_for_a_depth_image() {
    let fixture = fixture(&["--web", "0", "--confirm", "cloud"]);
    fixture.python("monitor()");
    fixture.python("camera = stream()");
    fixture.wait_for("viewer.middle() == RED");
    fixture.python("def share(name): return float(values('camera_stream: CameraPub').get(f'light {name} %', -1))");
    fixture.wait_for("share('confirmed') > 90 and share('blocked') == 0");
    fixture.python("def drawn(): return int(values('camera_stream: CameraPub')['frames drawn'])");
    fixture.python("before, arrays_before = drawn(), len(arrays)");
    fixture.python("hand[0] = True");
    fixture.wait_for("share('blocked') > 3 and viewer.middle() == BLACK and len(arrays) > arrays_before + 2");
    assert_eq!(fixture.python("drawn() - before"), "0");
    open_page(&fixture);
    let surface = "[s['text'] for c in page.state['cameras'] for s in c['statuses'] if s['name'] == 'Surface']";
    fixture.wait_for(format!(
        "'cameras' in page.state and any('of the light confirmed; blocked' in text for text in {surface})"
    ));
}

#[test]
fn a_pause_and_a_test_image_are_lit_only_where_the_last_check_allows() {
    let fixture = fixture(&["--confirm", "cloud"]);
    fixture.python("from std_srvs.srv import SetBool");
    fixture.python("camera = stream()");
    fixture.wait_for("viewer.middle() == RED");
    fixture.python("rospy.ServiceProxy('/camera_stream/pause', SetBool)(True)");
    fixture.python("hand[0] = True");
    fixture.wait_for("viewer.middle() == BLACK and corner() == RED");
    fixture.python("rospy.ServiceProxy('/camera_stream/pause', SetBool)(False)");
    fixture.python("trigger('/camera_stream/test_picture')");
    fixture.wait_for("viewer.pixel(0, 0) != BLACK and viewer.middle() == BLACK");
}

#[test]
fn a_depth_camera_is_not_listened_to_while_nobody_watches() {
    let fixture = fixture(&[]);
    fixture.python("camera = stream()");
    fixture.wait_for("viewer.middle() == RED and camera.out.get_num_connections() == 1");
    fixture.python("viewer.close()");
    fixture.wait_for("camera.out.get_num_connections() == 0");
    fixture.python("viewer = Viewer('/view/image')");
    fixture.wait_for("viewer.middle() == RED");
}
