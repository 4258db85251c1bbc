//! The depths beside the image: on a topic of their own, while somebody subscribes, with the CameraInfo's stamp.

use rcs_tests::ros_fixture::{CameraPub, RosFixture, Setup, CLOUD};
const LISTEN: &str = "
import numpy as np
depths, infos = [], []
info_subscriber = rospy.Subscriber('/view/camera_info', CameraInfo, infos.append)
def listen():
    global depth_subscriber
    depth_subscriber = rospy.Subscriber('/view/depth', Image, depths.append, queue_size=10, buff_size=1 << 24)
def depth(u, v, kind):
    message = depths[-1]
    return float(np.frombuffer(message.data, kind).reshape(message.height, message.width)[v, u])
";

/// A node before a square of 1 m at 2 m, with a listener to depths and CameraInfo.
fn fixture(args: &[&str]) -> RosFixture {
    let fixture = Setup::of(&[CLOUD]).args(args).start();
    fixture.python("place_camera()");
    fixture.python("latch('/cloud', cloud(0xff0000))");
    fixture.python(LISTEN);
    fixture
}

#[test]
fn depths_are_metres_with_the_stamp_and_frame_of_the_camera_info() {
    let fixture = fixture(&[]);
    fixture.python("viewer = Viewer('/view/image')");
    fixture.wait_for("viewer.middle() == (255, 0, 0)");
    // One who comes when the image is drawn already gets them, too.
    fixture.python("listen()");
    fixture.wait_for("len(depths) > 5 and depth(32, 24, np.float32) > 0");
    assert_eq!(
        fixture.python("(depths[-1].encoding, depths[-1].width, depths[-1].height, depths[-1].step)"),
        "('32FC1', 64, 48, 256)"
    );
    assert_eq!(fixture.python("round(depth(32, 24, np.float32), 4), depths[-1].header.frame_id"), "(2.0, 'eye')");
    assert_eq!(fixture.python("np.isnan(depth(5, 5, np.float32))"), "True");
    fixture.wait_for("depths[3].header.stamp in [message.header.stamp for message in infos]");
    // With a cloud that is nearer, they change with the image.
    fixture.python("latch('/cloud', cloud(0x00ff00, points=((0, 0, 1.25),)))");
    fixture.wait_for("round(depth(32, 24, np.float32), 4) == 1.25 and viewer.middle() == (0, 255, 0)");
}

#[test]
fn depths_alone_are_drawn_for_who_subscribes_to_nothing_else_and_may_be_millimetres() {
    let fixture = fixture(&["_depth_encoding:=16UC1", "--stale-timeouts", "/cloud=0.5"]);
    fixture.python("info_subscriber.unregister()");
    fixture.python("listen()");
    fixture.wait_for("depths and depth(32, 24, np.uint16) in (0, 2000)");
    fixture.python("clouds = PublishRepeatedly(20, lambda i: cloud(0xff0000), '/cloud')");
    fixture.wait_for("depth(32, 24, np.uint16) == 2000 and depth(5, 5, np.uint16) == 0");
    assert_eq!(fixture.python("(depths[-1].encoding, depths[-1].step)"), "('16UC1', 128)");
    // What is too old is nowhere.
    fixture.python("clouds.stop()");
    fixture.wait_for("depth(32, 24, np.uint16) == 0");
}

#[test]
fn depths_are_drawn_only_while_somebody_subscribes() {
    let fixture = fixture(&[]);
    fixture.python("monitor()");
    fixture.python("viewer = Viewer('/view/image')");
    fixture.python("PublishRepeatedly(20, lambda i: cloud(0xff0000, points=((0, 0, 2 + 0.001 * i),)), '/cloud')");
    let drawn = |what: &str| format!("int(values('camera_stream: CameraPub').get('{what} drawn', 0))");
    let (frames, depths) = (drawn("frames"), drawn("depths"));
    fixture.wait_for(format!("{frames} > 20"));
    assert_eq!(fixture.python(&depths), "0");
    fixture.python("listen()");
    fixture.wait_for(format!("{depths} > 5 and len(depths) > 5"));
    fixture.python("depth_subscriber.unregister()");
    // Both are of one moment: from some image on, those without depths are drawn alone.
    fixture.python("def without(): return FRAMES - DEPTHS".replace("FRAMES", &frames).replace("DEPTHS", &depths));
    fixture.python("before = without()");
    fixture.wait_for("without() > before + 20");
    fixture.python("before = DEPTHS".replace("DEPTHS", &depths));
    fixture.python("frames_before = FRAMES".replace("FRAMES", &frames));
    fixture.wait_for(format!("{frames} > frames_before + 20"));
    assert_eq!(fixture.python(format!("{depths} - before")), "0");
}

#[test]
fn images_on_a_topic_of_that_name_are_not_mixed_with_depths() {
    let camera = CameraPub { image: "/view/depth", ..CameraPub::default() };
    let fixture = Setup::with_cameras(&[CLOUD], &[camera]).start();
    fixture.wait_for_log("depths are not published: the pictures themselves are on /view/depth").unwrap();
    fixture.python("place_camera()");
    fixture.python("latch('/cloud', cloud(0xff0000))");
    fixture.python(LISTEN);
    fixture.python("listen()");
    fixture.wait_for("len(depths) > 5");
    assert_eq!(fixture.python("{message.encoding for message in depths}"), "{'rgb8'}");
}
