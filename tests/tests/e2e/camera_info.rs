//! The CameraInfo that a camera subscribes to, and the one that it publishes beside its picture.

use rcs_tests::ros::wait_until;
use rcs_tests::stand::{config, CameraPub, Stand, CLOUD};
use std::time::Duration;

/// A node with one camera at `eye` in front of a red cloud, and an eye on its picture.
fn stand(camera: &CameraPub) -> Stand {
    let stand = Stand::start(&config(&[CLOUD], std::slice::from_ref(camera)), &[]).unwrap();
    stand.puppet("latch('/tf_static', tf('map', 'eye'))");
    stand.puppet("latch('/cloud', cloud(0xff0000))");
    stand.puppet(format!("eye = Eye('{}')", camera.image));
    stand
}

#[test]
fn image_and_camera_info_have_the_same_stamp_number_and_frame() {
    let stand = stand(&CameraPub::default());
    stand.puppet("latch('/eye/camera_info', info())");
    stand.wait_for("len(eye.images) > 20 and len(eye.infos) > 20");
    // Of each pair the later message may still be on its way.
    let pairs = "sorted({i[1:6] for i in eye.images[2:18]} - {i[1:6] for i in eye.infos})";
    stand.wait_for(format!("{pairs} == []"));
    assert_eq!(stand.puppet("{i[3] for i in eye.images}"), "{'eye'}");
    assert_eq!(stand.puppet("{i[6] for i in eye.infos}"), "{'/camera_stream'}");
    let numbers = "[b[1] - a[1] for a, b in zip(eye.images, eye.images[1:])]";
    assert_eq!(stand.puppet(format!("min({numbers}) >= 1")), "True");
    assert_eq!(
        stand.puppet("max(abs(i[0] - i[2]) for i in eye.images) < 2"),
        "True",
        "stamps are the time of publishing"
    );
}

#[test]
fn a_camera_info_published_on_the_topic_it_is_read_from_does_not_feed_back() {
    let stand = stand(&CameraPub { image: "/proj_view/image", info: "/proj_view/camera_info", ..CameraPub::default() });
    stand.puppet("latch('/proj_view/camera_info', info())");
    stand.wait_for("len(eye.images) > 60");
    let rate = "(len(eye.images) - 1) / (eye.images[-1][0] - eye.images[0][0])";
    let rate: f64 = stand.puppet(rate).parse().unwrap();
    assert!(rate < 45.0, "{rate} pictures a second, for an unchanged scene at 30");
    // The next message of the real publisher is used, although most on the topic are the node's own.
    stand.puppet("latch('/proj_view/camera_info', info(width=80, height=60))");
    stand.wait_for("eye.images[-1][4:6] == (80, 60)");
    stand.wait_for("eye.infos[-1][4:6] == (80, 60)");
    stand.puppet("eye.forget()");
    stand.wait_for("len(eye.images) > 20");
    assert_eq!(stand.puppet("{i[4:6] for i in eye.images}"), "{(80, 60)}");
    assert_eq!(stand.puppet("max(abs(i[0] - i[2]) for i in eye.images) < 2"), "True");
    // The image's CameraInfo is published as well, and reaches the publisher of the other one.
    assert_eq!(stand.puppet("'/camera_stream' in {i[6] for i in eye.infos}"), "True");
}

#[test]
fn size_p_and_frame_of_a_camera_info_may_change_at_any_time() {
    let stand = stand(&CameraPub::default());
    stand.puppet("latch('/eye/camera_info', info())");
    stand.wait_for("eye.middle() == (255, 0, 0)");
    // The square of 1 m at 2 m is 25 pixels wide.
    assert_eq!(stand.puppet("eye.pixel(21, 24), eye.pixel(18, 24)"), "((255, 0, 0), (0, 0, 0))");
    stand.puppet("latch('/eye/camera_info', info(width=101, height=31))");
    stand.wait_for("(eye.last.width, eye.last.height, eye.last.step) == (101, 31, 303)");
    stand.puppet("latch('/eye/camera_info', info(f=100))");
    stand.wait_for("eye.last.width == 64 and eye.pixel(9, 24) == (255, 0, 0)");
    // The principal point far outside, as a projector's is.
    stand.puppet("latch('/eye/camera_info', info(P=[50, 0, 32, 0, 0, 50, 200, 0, 0, 0, 1, 0]))");
    stand.wait_for("eye.middle() == (0, 0, 0)");
    stand.puppet("latch('/tf_static', tf('map', 'aside', xyz=(0, 0.4, 0)))");
    stand.puppet("latch('/eye/camera_info', info(frame='aside'))");
    stand.wait_for("eye.last.header.frame_id == 'aside' and eye.pixel(32, 4) == (255, 0, 0)");
    assert_eq!(stand.puppet("eye.pixel(32, 32)"), "(0, 0, 0)");
}

#[test]
fn an_invalid_camera_info_is_one_error_and_stops_the_pictures() {
    let stand = stand(&CameraPub::default());
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
        stand.puppet("latch('/eye/camera_info', info())");
        stand.puppet("eye.forget()");
        stand.wait_for("eye.middle() == (255, 0, 0)");
        stand.puppet(format!("latch('/eye/camera_info', {bad})"));
        let errors = || stand.log_lines(&["ERROR", "/eye/camera_info"]);
        assert!(wait_until(Duration::from_secs(20), || errors() == number + 1), "{bad}: {}", stand.log());
        let said = stand.node.errors().into_iter().rfind(|line| line.contains("ERROR")).unwrap();
        assert!(said.contains(field), "{bad}: {said}");
        // What was published before may arrive after the error; the last good picture is not repeated.
        stand.wait_for("eye.quiet_secs() > 0.7");
        assert_eq!(errors(), number + 1, "{bad}: {}", stand.log());
    }
    stand.puppet("latch('/eye/camera_info', info())");
    stand.wait_for("eye.middle() == (255, 0, 0)");
}
