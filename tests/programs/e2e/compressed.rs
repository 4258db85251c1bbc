//! `IMAGE/compressed`: what image_transport's plugin `compressed` offers, without the plugin.

use rcs_messages::sensor_msgs::CompressedImage;
use rcs_tests::ros_fixture::{config, CameraPub, RosFixture, Setup, CLOUD};
use std::fs;

/// Python that subscribes to compressed images, and changes how they are made.
const SUBSCRIBE: &str = "
from sensor_msgs.msg import CompressedImage
from dynamic_reconfigure.msg import Config, IntParameter, StrParameter
from dynamic_reconfigure.srv import Reconfigure
packed = []
def subscribe(): return rospy.Subscriber('/view/image/compressed', CompressedImage, packed.append)
def set_values(**values):
    rospy.wait_for_service('/view/image/compressed/set_parameters', 30)
    ints = [IntParameter(n, v) for n, v in values.items() if isinstance(v, int)]
    strs = [StrParameter(n, v) for n, v in values.items() if isinstance(v, str)]
    answer = rospy.ServiceProxy('/view/image/compressed/set_parameters', Reconfigure)(Config(ints=ints, strs=strs)).config
    return {p.name: p.value for p in answer.ints + answer.strs}
";

fn fixture() -> RosFixture {
    let fixture = Setup::of(&[CLOUD]).start();
    fixture.python("place_camera()");
    fixture.python("latch('/cloud', cloud(0xff8000))");
    fixture.python(SUBSCRIBE);
    fixture
}

/// Whether the node has a thread of this name.
fn has_thread(fixture: &RosFixture, name: &str) -> bool {
    let threads = fs::read_dir(format!("/proc/{}/task", fixture.node.id())).unwrap();
    let name_of = |thread: fs::DirEntry| fs::read_to_string(thread.path().join("comm")).unwrap_or_default();
    threads.filter_map(Result::ok).any(|thread| name_of(thread).trim() == name)
}

/// The colour in the middle of the last compressed image, as image_transport's subscriber would have it.
fn middle(fixture: &RosFixture) -> [u8; 3] {
    let file = fixture.config_file().with_extension("packed");
    fixture.python(format!("open('{}', 'wb').write(packed[-1].data)", file.display()));
    let format = fixture.python("packed[-1].format");
    let data = fs::read(&file).unwrap();
    let image =
        rcs_displays::unpack_image("/view/image/compressed", &CompressedImage { format, data, ..Default::default() });
    let image = image.unwrap();
    assert_eq!((image.width, image.height), (64, 48));
    let pixel = 24 * image.step as usize + 32 * 3;
    let [a, b, c] = [0, 1, 2].map(|channel| image.data()[pixel + channel]);
    if image.encoding.starts_with("bgr") {
        [c, b, a]
    } else {
        [a, b, c]
    }
}

#[test]
fn a_camera_is_seen_by_subscribers_of_compressed_images_alone() {
    let fixture = fixture();
    let is_advertised = "['/view/image/compressed', 'sensor_msgs/CompressedImage'] in rospy.get_published_topics()";
    fixture.wait_for(is_advertised);
    fixture.python("subscription = subscribe()");
    fixture.wait_for("len(packed) > 5 and packed[-1].format == 'rgb8; jpeg compressed bgr8'");
    let color = middle(&fixture);
    assert!(color.iter().zip([255, 128, 0]).all(|(is, should)| is.abs_diff(should) < 12), "{color:?}");
    // Lossless, from the next image on.
    assert_eq!(
        fixture.python("sorted(set_values(format='png', png_level=2).items())"),
        "[('format', 'png'), ('jpeg_quality', 80), ('png_level', 2)]"
    );
    fixture.wait_for("packed[-1].format == 'rgb8; png compressed bgr8' and packed[-1].data[:4] == b'\\x89PNG'");
    assert_eq!(middle(&fixture), [255, 128, 0]);
    // The stamps are those of the raw images.
    fixture.python("viewer = Viewer('/view/image'); packed.clear()");
    fixture.wait_for("len({i[2] for i in viewer.images} & {p.header.stamp.to_sec() for p in packed}) > 3");
    assert_eq!(fixture.python("{p.header.frame_id for p in packed}"), "{'eye'}");
}

#[test]
fn nothing_is_compressed_that_nobody_subscribes_to_and_launch_files_set_how() {
    let fixture = fixture();
    fixture.python("viewer = Viewer('/view/image')");
    fixture.wait_for("len(viewer.images) > 10");
    assert!(!has_thread(&fixture, "compress"));
    fixture.python("subscription = subscribe()");
    fixture.wait_for("len(packed) > 2");
    assert!(has_thread(&fixture, "compress"));
    // Another camera's topic, whose parameters are on the server before it starts.
    fixture.python("rospy.set_param('/other/image/compressed/format', 'png')");
    fixture.python("rospy.set_param('/other/image/compressed/png_level', 3)");
    let other = CameraPub { image: "/other/image", ..CameraPub::default() };
    fixture.rewrite(&config(&[CLOUD], &[other]));
    fixture.python("others = []");
    fixture.python("other = rospy.Subscriber('/other/image/compressed', CompressedImage, others.append)");
    fixture.wait_for("len(others) > 2 and others[-1].format == 'rgb8; png compressed bgr8'");
    fixture.wait_for("rospy.get_param('/other/image/compressed/jpeg_quality') == 80");
}
