//! Heavy scenes in the running node: images of another display go on beside them, and it ends when it is asked to.
//!
//! Beside each scene, a square of some pixels in front of it changes its colour thirty times a second. Printed is the
//! longest time without a new image of it, from before the scene's message is sent until it has been shown for a
//! while, at 640×480. Nothing of a scene is nearer than the square, which would hide that images change.

use crate::load::{CAMERA, LOAD, LONGEST_GAP_SECS};
use rcs_tests::ros_fixture::{CameraPub, RosFixture, Setup};

/// The display whose images must go on, so small and near that it hides nothing and nothing hides it.
const NEAR: &str =
    "{Class: rviz/PointCloud2, Name: near, Enabled: true, Topic: /near, Style: Flat Squares, Size (m): 0.0005, \
     Color Transformer: RGB8, Position Transformer: XYZ}";

const MARKERS: &str = "{Class: rviz/Marker, Name: markers, Enabled: true, Marker Topic: /markers, Queue Size: 100}";

/// A scene: what it is, where it is sent, and the Python that makes its message.
type Heavy = (&'static str, &'static str, &'static str);

/// A node with the near display and others, which draws at 640×480, and whose images change.
fn fixture(displays: &[&str]) -> RosFixture {
    let all: Vec<&str> = [NEAR].iter().chain(displays).copied().collect();
    let fixture = Setup::with_cameras(&all, &[CameraPub { background: "0; 0; 200", ..CameraPub::default() }]).start();
    fixture.python(LOAD);
    fixture.python("latch('/tf_static', tf('map', 'eye')); viewer = Viewer('/view/image')");
    fixture.python(CAMERA.replace("500.0", "1900.0"));
    fixture.python(
        "near = PublishRepeatedly(30, lambda i: cloud(0x010000 * (i % 250 + 1) + 200, points=[(0, 0, 0.02)]), '/near')",
    );
    fixture.wait_for("viewer.last and viewer.last.width == 640 and len({i[6] for i in viewer.images}) > 30");
    fixture
}

/// Shows scenes one after the other, while images go on, and ends the node while the last one is shown.
fn images_go_on_beside(mut fixture: RosFixture, scenes: &[Heavy]) {
    for (number, (name, topic, message)) in scenes.iter().enumerate() {
        fixture.python(format!("heavy = {message}"));
        if number > 0 {
            fixture.python("{topic: send(topic, no_marker if topic == '/markers' else none) for topic in sent_to}");
            fixture.wait_for("not shown()");
        }
        fixture.python(format!("viewer.forget(); sent_to = ['{topic}']; send('{topic}', heavy)"));
        fixture.wait_for("shown()");
        fixture.python("before = len(viewer.images)");
        fixture.wait_for("len(viewer.images) > before + 10");
        let gap = fixture.python("longest_gap()");
        println!("{name}: at most {gap} s between pictures");
        assert!(gap.parse::<f64>().unwrap() < LONGEST_GAP_SECS, "{name}: {gap} s without a new picture");
    }
    let status = fixture.node.end("TERM").unwrap();
    assert!(status.success(), "{status}");
}

fn cloud_of(style: &str, topic: &str) -> String {
    format!(
        "{{Class: rviz/PointCloud2, Name: {topic}, Enabled: true, Topic: /{topic}, Style: {style}, Size (m): 0.004, \
         Color Transformer: RGB8, Position Transformer: XYZ, Queue Size: 10, Alpha: 1, Decay Time: 0}}"
    )
}

#[test]
#[ignore = "a load: ./test full"]
fn images_go_on_beside_a_depth_cameras_points_before_the_lens() {
    let displays = [("Flat Squares", "squares"), ("Spheres", "spheres"), ("Boxes", "boxes")];
    let displays = displays.map(|(style, topic)| cloud_of(style, topic));
    let fixture = fixture(&displays.each_ref().map(String::as_str));
    images_go_on_beside(
        fixture,
        &[
            ("Flat Squares at 6 cm", "/squares", "heavy_cloud(spread(1900, 0.06))"),
            ("Flat Squares in one place", "/squares", "heavy_cloud(in_one_place())"),
            ("Spheres at 6 cm", "/spheres", "heavy_cloud(spread(1900, 0.06))"),
            ("Spheres in one place", "/spheres", "heavy_cloud(in_one_place())"),
            ("Boxes at 6 cm", "/boxes", "heavy_cloud(spread(1900, 0.06))"),
            ("Boxes in one place", "/boxes", "heavy_cloud(in_one_place())"),
        ],
    );
}

#[test]
#[ignore = "a load: ./test full"]
fn images_go_on_beside_five_million_points_near_and_behind_the_lens() {
    let display = cloud_of("Flat Squares", "squares");
    let fixture = fixture(&[&display]);
    images_go_on_beside(
        fixture,
        &[
            ("5 million points around", "/squares", "heavy_cloud(between(5000000, 1900, -0.5, 0.5))"),
            ("5 million points near the lens", "/squares", "heavy_cloud(between(5000000, 1900, 0.05, 0.1))"),
        ],
    );
}

#[test]
#[ignore = "a load: ./test full"]
fn images_go_on_beside_markers_of_very_many_lines_triangles_and_translucent_spheres() {
    let fixture = fixture(&[MARKERS]);
    let list = "of_points(Marker.LINE_LIST, around(1000000))";
    let strip = "of_points(Marker.LINE_STRIP, around(1000000))";
    let triangles = "of_points(Marker.TRIANGLE_LIST, filling(100000), 1)";
    let spheres = "of_points(Marker.SPHERE_LIST, between(100000, 1900, 0.5, 2), 0.02, 0.5)";
    images_go_on_beside(
        fixture,
        &[
            ("a line list of a million points", "/markers", list),
            ("a line strip of a million points", "/markers", strip),
            ("100,000 triangles that fill the picture", "/markers", triangles),
            ("100,000 translucent spheres", "/markers", spheres),
        ],
    );
}
