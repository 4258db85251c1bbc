//! `~orientation`: the image is turned, and the published CameraInfo leads a point to where it is in that image.

use std::process::Command;

use rcs_tests::golden::GoldenCase;
use rcs_tests::programs::program;
use rcs_tests::ros_fixture::{Setup, CLOUD};

/// Where the CameraInfo that the viewer received last says that a point of the frame `eye` is, by its P and its frame.
const PROJECTED: &str = "
import tf2_ros, numpy as np
infos = []
info_subscriber = rospy.Subscriber('/view/camera_info', CameraInfo, infos.append)
frames = tf2_ros.Buffer()
listener = tf2_ros.TransformListener(frames)
def projected(point):
    message = infos[-1]
    placed = frames.lookup_transform(message.header.frame_id, 'eye', rospy.Time()).transform.rotation
    x, y, z, w = placed.x, placed.y, placed.z, placed.w
    rotation = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                         [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                         [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
    pixel = np.array(message.P).reshape(3, 4) @ np.append(rotation @ np.array(point), 1)
    return [round(value, 3) for value in pixel[:2] / pixel[2]]
def middle_of_light():
    data = np.frombuffer(viewer.last.data, np.uint8).reshape(viewer.last.height, viewer.last.width, 3)[:, :, 0]
    rows, columns = np.nonzero(data)
    return [columns.mean(), rows.mean()]
";

#[test]
fn a_consumer_of_the_published_camera_info_finds_what_the_published_image_shows() {
    let (straight, mirrored) =
        ("[50, 0, 20, 0, 0, 50, 30, 0, 0, 0, 1, 0]", "[-50, 5, 43, 0, 0, 50, 30, 0, 0, 0, 1, 0]");
    for (orientation, size, p) in [
        ("0", (64, 48), straight),
        ("90", (48, 64), straight),
        ("180", (64, 48), straight),
        ("270", (48, 64), straight),
        ("mirrored", (64, 48), straight),
        ("mirrored-90", (48, 64), straight),
        ("0", (64, 48), mirrored),
        ("mirrored-90", (48, 64), mirrored),
    ] {
        let args = [&*format!("_orientation:={orientation}"), "--projection", "exact"];
        let cloud = CLOUD.replace("Size (m): 1", "Size (m): 0.12");
        let fixture = Setup::of(&[&cloud]).args(&args).start();
        fixture.python("latch('/tf_static', tf('map', 'eye', xyz=(0, 0, 1)))");
        fixture.python(format!("latch('/eye/camera_info', info(P={p}, binning_x=4))"));
        fixture.python("latch('/cloud', cloud(0xffffff, points=((0.42, -0.66, 3),)))");
        fixture.python("viewer = Viewer('/view/image')");
        fixture.python(PROJECTED);
        fixture.wait_for("viewer.last and max(viewer.last.data) > 0 and infos");
        assert_eq!(fixture.python("(viewer.last.width, viewer.last.height)"), format!("{size:?}"), "{orientation}");
        assert_eq!(fixture.python("(infos[-1].width, infos[-1].height)"), format!("{size:?}"), "{orientation}");
        assert_eq!(
            fixture.python("(infos[-1].binning_x, infos[-1].roi.width)"),
            "(0, 0)",
            "the picture is the whole one"
        );
        fixture.wait_for_log("binning 4x0 not applied").unwrap();
        assert_eq!(fixture.python("infos[-1].header.frame_id == viewer.last.header.frame_id"), "True");
        fixture.wait_for("frames.can_transform(infos[-1].header.frame_id, 'eye', rospy.Time())");
        let distance = "max(abs(a - b) for a, b in zip(projected((0.42, -0.66, 2)), middle_of_light()))";
        let off: f64 = fixture.python(distance).parse().unwrap();
        assert!(
            off < 0.51,
            "{orientation}: {off} px: {}",
            fixture.python("projected((0.42, -0.66, 2)), middle_of_light()")
        );
    }
}

#[test]
fn render_turns_its_images_too() {
    let folder = tempfile::tempdir().unwrap();
    let case = GoldenCase::new("pc2_flat_squares_rgb8", folder.path()).unwrap();
    let drawn = |orientation: &str| {
        let png = folder.path().join(format!("{orientation}.png"));
        let mut command = Command::new(program("camera_stream"));
        command.args(["render", "--renderer", "cpu", "--orientation", orientation, "-d"]).arg(&case.config);
        let output = command.arg("--bag").arg(&case.bag).arg("-o").arg(&png).output().unwrap();
        assert!(output.status.success(), "{output:?}");
        image::open(&png).unwrap().to_rgb8()
    };
    let plain = drawn("0");
    assert!(drawn("270") == image::imageops::rotate270(&plain));
    let mirrored = image::imageops::flip_horizontal(&plain);
    assert!(mirrored != plain && drawn("mirrored-90") == image::imageops::rotate90(&mirrored));
}
