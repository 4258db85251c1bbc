//! The CameraInfo that a camera subscribes to, and the one that it publishes beside its image.

use rcs_tests::ros::{wait_until, PATIENCE};
use rcs_tests::ros_fixture::{CameraPub, RosFixture, Setup, CLOUD};
/// A node with one camera at `eye` in front of a red cloud, and a viewer of its image.
fn fixture(camera: &CameraPub) -> RosFixture {
    let fixture = Setup::with_cameras(&[CLOUD], std::slice::from_ref(camera)).start();
    fixture.python("latch('/tf_static', tf('map', 'eye'))");
    fixture.python("latch('/cloud', cloud(0xff0000))");
    fixture.python(format!("viewer = Viewer('{}')", camera.image));
    fixture
}

#[test]
fn image_and_camera_info_have_the_same_stamp_number_and_frame() {
    let fixture = fixture(&CameraPub::default());
    fixture.python("latch('/eye/camera_info', info())");
    fixture.wait_for("len(viewer.images) > 20 and len(viewer.infos) > 20");
    // Of each pair the later message may still be on its way.
    let pairs = "sorted({i[1:6] for i in viewer.images[2:18]} - {i[1:6] for i in viewer.infos})";
    fixture.wait_for(format!("{pairs} == []"));
    assert_eq!(fixture.python("{i[3] for i in viewer.images}"), "{'eye'}");
    assert_eq!(fixture.python("{i[6] for i in viewer.infos}"), "{'/camera_stream'}");
    let numbers = "[b[1] - a[1] for a, b in zip(viewer.images, viewer.images[1:])]";
    assert_eq!(fixture.python(format!("min({numbers}) >= 1")), "True");
    assert_eq!(
        fixture.python("max(abs(i[0] - i[2]) for i in viewer.images) < 2"),
        "True",
        "stamps are the time of publishing"
    );
}

#[test]
fn a_camera_info_published_on_the_topic_it_is_read_from_does_not_feed_back() {
    let fixture =
        fixture(&CameraPub { image: "/proj_view/image", info: "/proj_view/camera_info", ..CameraPub::default() });
    fixture.python("latch('/proj_view/camera_info', info())");
    fixture.wait_for("len(viewer.images) > 60");
    let rate = "(len(viewer.images) - 1) / (viewer.images[-1][0] - viewer.images[0][0])";
    let rate: f64 = fixture.python(rate).parse().unwrap();
    assert!(rate < 45.0, "{rate} pictures a second, for an unchanged scene at 30");
    // The next message of the real publisher is used, although most on the topic are the node's own.
    fixture.python("latch('/proj_view/camera_info', info(width=80, height=60))");
    fixture.wait_for("viewer.images[-1][4:6] == (80, 60)");
    fixture.wait_for("viewer.infos[-1][4:6] == (80, 60)");
    fixture.python("viewer.forget()");
    fixture.wait_for("len(viewer.images) > 20");
    assert_eq!(fixture.python("{i[4:6] for i in viewer.images}"), "{(80, 60)}");
    assert_eq!(fixture.python("max(abs(i[0] - i[2]) for i in viewer.images) < 2"), "True");
    // The image's CameraInfo is published as well, and reaches the publisher of the other one.
    assert_eq!(fixture.python("'/camera_stream' in {i[6] for i in viewer.infos}"), "True");
}

#[test]
fn size_p_and_frame_of_a_camera_info_may_change_at_any_time() {
    let fixture = fixture(&CameraPub::default());
    fixture.python("latch('/eye/camera_info', info())");
    fixture.wait_for("viewer.middle() == (255, 0, 0)");
    // The square of 1 m at 2 m is 25 pixels wide.
    assert_eq!(fixture.python("viewer.pixel(21, 24), viewer.pixel(18, 24)"), "((255, 0, 0), (0, 0, 0))");
    fixture.python("latch('/eye/camera_info', info(width=101, height=31))");
    fixture.wait_for("(viewer.last.width, viewer.last.height, viewer.last.step) == (101, 31, 303)");
    fixture.python("latch('/eye/camera_info', info(f=100))");
    fixture.wait_for("viewer.last.width == 64 and viewer.pixel(9, 24) == (255, 0, 0)");
    // The principal point far outside, as a projector's is.
    fixture.python("latch('/eye/camera_info', info(P=[50, 0, 32, 0, 0, 50, 200, 0, 0, 0, 1, 0]))");
    fixture.wait_for("viewer.middle() == (0, 0, 0)");
    fixture.python("latch('/tf_static', tf('map', 'aside', xyz=(0, 0.4, 0)))");
    fixture.python("latch('/eye/camera_info', info(frame='aside'))");
    fixture.wait_for("viewer.last.header.frame_id == 'aside' and viewer.pixel(32, 4) == (255, 0, 0)");
    assert_eq!(fixture.python("viewer.pixel(32, 32)"), "(0, 0, 0)");
}

#[test]
fn an_invalid_camera_info_is_one_error_and_stops_the_images() {
    let fixture = fixture(&CameraPub::default());
    let infinite = "info(P=[50, 0, 32, 0, 0, float('inf'), 24, 0, 0, 0, 1, 0])";
    let nan = "info(P=[50, 0, float('nan'), 0, 0, 50, 24, 0, 0, 0, 1, 0])";
    let cases = [
        (nan, "P"),
        ("info(width=0)", "width"),
        ("info(height=0)", "height"),
        ("info(width=16385)", "width"),
        (infinite, "P"),
        ("info(height=4000000000)", "height"),
    ];
    for (number, (bad, field)) in cases.into_iter().enumerate() {
        fixture.python("latch('/eye/camera_info', info())");
        fixture.python("viewer.forget()");
        fixture.wait_for("viewer.middle() == (255, 0, 0)");
        fixture.python(format!("latch('/eye/camera_info', {bad})"));
        let errors = || fixture.log_lines(&["ERROR", "/eye/camera_info"]);
        assert!(wait_until(PATIENCE, || errors() == number + 1), "{bad}: {}", fixture.log());
        let error = fixture.node.errors().into_iter().rfind(|line| line.contains("ERROR")).unwrap();
        assert!(error.contains(field), "{bad}: {error}");
        // What was published before may arrive after the error; the last good image is not repeated.
        fixture.wait_for("viewer.quiet_secs() > 0.7");
        assert_eq!(errors(), number + 1, "{bad}: {}", fixture.log());
    }
    fixture.python("latch('/eye/camera_info', info())");
    fixture.wait_for("viewer.middle() == (255, 0, 0)");
}
