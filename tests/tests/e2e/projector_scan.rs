//! `projector_calibrate scan` on topics: a Python node is a projector that lights a wall, and the camera that sees it.

use rcs_files::capture::Capture;
use rcs_tests::programs::program;
use rcs_tests::python_node::PythonNode;
use rcs_tests::ros::{RosMaster, Running, PATIENCE};
use std::path::Path;
use std::process::Command;

/// Shows `/projector/patterns` on a wall and sees it with a camera of 160×120 pixels. Camera pixel (x, y) is lit by
/// projector pixel (0.7 x + 4, 0.6 y + 2); `mirrored` shows the picture mirrored.
const ROBOT: &str = "
SIZE, CAMERA = (128, 80), (160, 120)
mirrored, picture = False, bytes(CAMERA[0] * CAMERA[1])
def lit_by(x, y):
    u, v = round(0.7 * x + 4), round(0.6 * y + 2)
    return v * SIZE[0] + (SIZE[0] - 1 - u if mirrored else u)
def show(message):
    global picture
    assert (message.width, message.height, message.encoding) == SIZE + ('mono8',)
    table = [lit_by(x, y) for y in range(CAMERA[1]) for x in range(CAMERA[0])]
    picture = bytes(30 + message.data[i] * 3 // 5 for i in table)
def image(encoding, step, data):
    message = Image(width=CAMERA[0], height=CAMERA[1], encoding=encoding, step=step, data=data)
    message.header.frame_id, message.header.stamp = 'head_camera_optical', rospy.Time.now()
    return message
def see():
    while not rospy.is_shutdown():
        rgb = bytes(level for level in picture for _ in range(3))
        publisher('/head_camera/rgb/image_raw', Image, False).publish(image('rgb8', 3 * CAMERA[0], rgb))
        depth = struct.pack('<H', 1200) * len(picture)
        publisher('/head_camera/depth_registered/image_raw', Image, False).publish(image('16UC1', 2 * CAMERA[0], depth))
        latch('/head_camera/rgb/camera_info', info('head_camera_optical', *CAMERA, f=130.0))
        time.sleep(0.05)
projector = rospy.Subscriber('/projector/patterns', Image, show)
threading.Thread(target=see, daemon=True).start()
";

/// The scan with more arguments.
fn scan(master: &RosMaster, folder: &Path, arguments: &[&str]) -> Running {
    let mut command = master.environment(Command::new(program("projector_calibrate")));
    command.args(["scan", "--size", "128x80", "--show-on", "/projector/patterns", "--frames", "2", "-o"]);
    Running::start(command.arg(folder).args(arguments)).unwrap()
}

#[test]
fn a_scan_on_topics_is_written_and_can_be_decoded() {
    let master = RosMaster::start().unwrap();
    let python = PythonNode::start(&master, &[]).unwrap();
    python.run(ROBOT).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let preview = folder.path().join("preview.png");
    let mut scan = scan(&master, &folder.path().join("scan"), &["--preview", preview.to_str().unwrap()]);
    let status = scan.wait(3 * PATIENCE).unwrap();
    assert_eq!(status.code(), Some(0), "{:?}", scan.errors());
    let capture = Capture::read(&folder.path().join("scan")).unwrap();
    assert_eq!((capture.projector_size_px, capture.image_size_px()), ([128, 80], [160, 120]));
    assert_eq!((capture.pictures.len(), capture.camera_frame_id.as_str()), (2 + 2 * 14, "head_camera_optical"));
    assert!(capture.depth_m.unwrap().iter().all(|depth| (depth - 1.2).abs() < 1e-4));
    assert_eq!(image::image_dimensions(&preview).unwrap(), (160, 120));
    assert!(scan.errors().iter().any(|line| line.contains("light is seen after")), "{:?}", scan.errors());
}

#[test]
fn a_mirrored_projector_is_refused_and_nothing_is_written() {
    let master = RosMaster::start().unwrap();
    let python = PythonNode::start(&master, &[]).unwrap();
    python.run(format!("{ROBOT}\nmirrored = True")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut scan = scan(&master, &folder.path().join("scan"), &[]);
    assert_eq!(scan.wait(3 * PATIENCE).unwrap().code(), Some(1), "{:?}", scan.errors());
    assert!(scan.errors().iter().any(|line| line.contains("mirrored")), "{:?}", scan.errors());
    assert!(!folder.path().join("scan").exists());
}

#[test]
fn a_silent_topic_is_named() {
    let master = RosMaster::start().unwrap();
    let python = PythonNode::start(&master, &[]).unwrap();
    python.run(ROBOT).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut scan = scan(&master, &folder.path().join("scan"), &["--depth", "/nobody/depth"]);
    assert_eq!(scan.wait(3 * PATIENCE).unwrap().code(), Some(2), "{:?}", scan.errors());
    assert!(scan.errors().iter().any(|line| line.contains("/nobody/depth")), "{:?}", scan.errors());
}
