//! Streams that nobody watches are not received, and what a viewer then sees first is what is there now.

use std::time::Duration;

use rcs_tests::ros::{wait_until, PATIENCE};
use rcs_tests::ros_fixture::{RosFixture, Setup, CLOUD};
/// As [`CLOUD`], on another topic, and what accumulates on a third.
const LATCHED: &str = "{Class: rviz/PointCloud2, Name: latched, Enabled: true, Topic: /latched, Style: Points}";
const ACCUMULATED: &str =
    "{Class: rviz/PointCloud2, Name: accumulated, Enabled: true, Topic: /accumulated, Style: Points, Decay Time: 5}";
const PATH: &str = "{Class: rviz/Path, Name: path, Enabled: true, Topic: /path}";

/// Python that counts the connections of a topic's publisher.
const CONNECTIONS: &str = "
from nav_msgs.msg import Path
def connections(*topics): return [publishers[topic].get_num_connections() for topic in topics]
color = 0xff0000
far = ((0, 0, -50),)
";

fn fixture(args: &[&str]) -> RosFixture {
    let fixture = Setup::of(&[CLOUD, LATCHED, ACCUMULATED, PATH]).args(args).start();
    fixture.python(CONNECTIONS);
    fixture.python("place_camera()");
    fixture.python("stream = PublishRepeatedly(30, lambda i: cloud(color), '/cloud')");
    fixture.wait_for("connections('/cloud') == [1]");
    fixture
}

#[test]
fn an_unwatched_stream_is_not_received_and_comes_back_with_what_is_new() {
    let fixture = fixture(&[]);
    // What is latched, accumulates, or is no large stream stays connected.
    fixture.python("publisher('/latched', PointCloud2, True)");
    fixture.python("more = [PublishRepeatedly(20, lambda i: cloud(0xffffff, points=far), '/latched')]");
    fixture.python("more.append(PublishRepeatedly(20, lambda i: cloud(0xffffff, points=far), '/accumulated'))");
    fixture.python("more.append(PublishRepeatedly(20, lambda i: Path(), '/path'))");
    fixture.wait_for("connections('/latched', '/accumulated', '/path') == [1, 1, 1]");
    fixture.wait_for("connections('/cloud') == [0]");
    std::thread::sleep(Duration::from_secs(1));
    assert_eq!(fixture.python("connections('/cloud', '/latched', '/accumulated', '/path')"), "[0, 1, 1, 1]");

    fixture.python("rgb = lambda color: (color >> 16, color >> 8 & 255, color & 255)");
    let is_only_new_cloud_seen = || {
        fixture.python("color = color >> 8 or 0xff0000; viewer = Viewer('/view/image')");
        fixture.wait_for("len(viewer.images) > 20 and connections('/cloud') == [1]");
        let is_only_new = fixture.python("viewer.colors == [rgb(color)]");
        fixture.python("viewer.close()");
        fixture.wait_for("connections('/cloud') == [0]");
        is_only_new == "True"
    };
    // Twice, as it is paused again. The old cloud is seen first where connecting takes longer than an image waits.
    for _ in 0..2 {
        assert!(wait_until(PATIENCE, is_only_new_cloud_seen), "the cloud from before the pause");
    }

    // One that ended meanwhile is shown as it was, and images do not wait for it.
    fixture.python("stream.stop(); publishers.pop('/cloud').unregister()");
    fixture.python("viewer = Viewer('/view/image')");
    fixture.wait_for("len(viewer.images) > 0");
    assert_eq!(fixture.python("viewer.colors == [rgb(color)]"), "True");
}

#[test]
fn what_a_limit_makes_stale_is_not_seen_after_a_pause() {
    let fixture = fixture(&["_stale_timeout:=0.5"]);
    fixture.python("rgb = lambda color: (color >> 16, color >> 8 & 255, color & 255)");
    for _ in 0..3 {
        fixture.wait_for("connections('/cloud') == [0]");
        fixture.python("color = color >> 8 or 0xff0000");
        std::thread::sleep(Duration::from_millis(600));
        fixture.python("viewer = Viewer('/view/image')");
        fixture.wait_for("rgb(color) in viewer.colors");
        assert_eq!(fixture.python("set(viewer.colors) <= {rgb(color), (0, 0, 0)}"), "True");
        fixture.python("viewer.close()");
    }
}

#[test]
fn all_streams_are_received_where_that_is_asked_for() {
    for args in [&["_lazy:=false"][..], &["--no-lazy"]] {
        let fixture = fixture(args);
        std::thread::sleep(Duration::from_secs(4));
        assert_eq!(fixture.python("connections('/cloud')"), "[1]", "{args:?}");
    }
}
