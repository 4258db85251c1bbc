//! Heavy scenes in the running node: pictures of another display go on beside them, and it ends when it is asked to.
//!
//! Beside each scene, a square of some pixels in front of it changes its colour thirty times a second. What counts is
//! the longest time without a new picture of it, from before the scene's message is sent until it has been shown for a
//! while: on two cores, at 640×480, beside the Python that sends and receives, divided by how many times longer the
//! node took because it waited for a processor. The best of two rounds counts, on a busy machine of five. The limits
//! are well above what that is now, and for faces less than what it is without culling, for translucent spheres, where
//! they are drawn ten times. Nothing of a scene is nearer than the square, which would hide that pictures change.

use rcs_tests::ros::PATIENCE;
use rcs_tests::ros_fixture::{config, CameraPub, RosFixture};
use std::time::{Duration, Instant};

use crate::load::{core_share, in_turn, longest_gap, CAMERA, CROWD, MANY};

/// The display whose pictures must go on, so small and near that it hides nothing and nothing hides it.
const NEAR: &str =
    "{Class: rviz/PointCloud2, Name: near, Enabled: true, Topic: /near, Style: Flat Squares, Size (m): 0.0005, \
     Color Transformer: RGB8, Position Transformer: XYZ}";

const MARKERS: &str = "{Class: rviz/Marker, Name: markers, Enabled: true, Marker Topic: /markers, Queue Size: 100}";

/// Messages of very many points, which NumPy makes.
const HEAVY: &str = "import numpy\n\
     rng = numpy.random.default_rng(7)\n\
     def heavy_cloud(places):\n    \
         message = cloud(0, points=[])\n    \
         message.width, message.row_step = len(places), 16 * len(places)\n    \
         points = numpy.empty((len(places), 4), '<f4')\n    \
         points[:, :3] = places\n    \
         points.view('<u4')[:, 3] = numpy.arange(len(places)) * 0x3f5f7 & 0x00ffff\n    \
         message.data = points.tobytes()\n    \
         return written(message)\n\
     def spread(f, z):\n    \
         rows, columns = numpy.mgrid[0:480, 0:640].reshape(2, -1)\n    \
         return numpy.stack([(columns - 319.5) / f * z, (rows - 239.5) / f * z, numpy.full(640 * 480, z)], 1)\n\
     def in_one_place():\n    \
         return numpy.tile([0.003, -0.002, 0.06], (640 * 480, 1))\n\
     def between(count, f, near, far):\n    \
         z = rng.uniform(near, far, count)\n    \
         z += numpy.where(abs(z) < .03, numpy.copysign(.03, z), 0)\n    \
         return numpy.stack([rng.uniform(-320, 320, count) / f * z, rng.uniform(-240, 240, count) / f * z, z], 1)\n\
     def around(count):\n    \
         places = rng.uniform(-2, 2, (count, 3))\n    \
         places[:, 2] = numpy.abs(places[:, 2]) + 0.1\n    \
         places[count // 2:, 2] *= -1\n    \
         return places\n\
     def filling(count):\n    \
         corners = numpy.array([[-2, -2, 1], [0, 4, 1], [2, -2, 1]])\n    \
         return (rng.uniform(1, 3, (count, 1, 1)) * corners).reshape(-1, 3)\n\
     def of_points(kind, places, size=0.01, alpha=1):\n    \
         marker = Marker(header=Header(frame_id='map'), ns='heavy', type=kind, pose=Pose(orientation=Quaternion(0, 0, 0, 1)), \
             scale=Vector3(size, size, size), color=ColorRGBA(0, 1, .5, alpha), points=[Point(1, 2, 3)])\n    \
         same, one = written(marker), struct.pack('<I3d', 1, 1, 2, 3)\n    \
         assert same.bytes.count(one) == 1\n    \
         same.bytes = same.bytes.replace(one, struct.pack('<I', len(places)) + places.astype('<f8').tobytes())\n    \
         return same\n\
     def spheres(count, shift):\n    \
         at = lambda i: Pose(Point(i % 60 * .02 - .6 + shift, i // 60 * .018 - .45, 2), Quaternion(0, 0, 0, 1))\n    \
         return MarkerArray([Marker(header=Header(frame_id='map'), ns='many', id=i, type=Marker.SPHERE, pose=at(i), \
             scale=Vector3(.02, .02, .02), color=ColorRGBA(0, 1, i % 9 / 9, 1)) for i in range(count)])\n\
     none = cloud(0, points=[])\n\
     no_marker = Marker(action=Marker.DELETEALL)\n\
     def shown():\n    \
         if viewer.last is None:\n        return False\n    \
         pixels = numpy.frombuffer(viewer.last.data, 'u1').reshape(-1, 3).astype(int)\n    \
         return (numpy.abs(pixels[:, 1:] - [0, 200]).max(axis=1) > 20).sum() > 1000";

/// A scene: what it is, where it is sent, the Python that makes its message, and the longest time that may pass
/// without a picture of the display beside it.
struct Heavy {
    name: &'static str,
    topic: &'static str,
    message: &'static str,
    limit: Duration,
}

const fn heavy(name: &'static str, topic: &'static str, message: &'static str, limit_ms: u64) -> Heavy {
    Heavy { name, topic, message, limit: Duration::from_millis(limit_ms) }
}

/// A node with the near display and others, which draws at 640×480, and whose pictures change.
fn fixture(displays: &[&str]) -> RosFixture {
    let all: Vec<&str> = [NEAR].iter().chain(displays).copied().collect();
    let fixture =
        RosFixture::start(&config(&all, &[CameraPub { background: "0; 0; 200", ..CameraPub::default() }]), &[])
            .unwrap();
    fixture.python(MANY);
    fixture.python(CROWD);
    fixture.python(HEAVY);
    fixture.python("latch('/tf_static', tf('map', 'eye')); viewer = Viewer('/view/image')");
    fixture.python(CAMERA.replace("500.0", "1900.0"));
    fixture.python(
        "near = PublishRepeatedly(30, lambda i: cloud(0x010000 * (i % 250 + 1) + 200, points=[(0, 0, 0.02)]), '/near')",
    );
    fixture.wait_for("viewer.last and viewer.last.width == 640 and len({i[6] for i in viewer.images}) > 30");
    fixture
}

/// Shows scenes one after the other, and checks how long no new picture comes beside them. The last one stays.
fn pictures_go_on_beside(fixture: &RosFixture, scenes: &[Heavy]) {
    for (number, scene) in scenes.iter().enumerate() {
        let Heavy { name, topic, message, limit } = scene;
        fixture.python(format!("heavy = {message}"));
        let (limit, mut gaps) = (limit.as_secs_f64(), Vec::new());
        while gaps.len() < 2 || gaps.len() < 5 && gaps.iter().all(|gap| *gap >= limit) {
            if number > 0 || fixture.python("shown()") == "True" {
                fixture.python("{topic: send(topic, no_marker if topic == '/markers' else none) for topic in sent_to}");
                fixture.wait_for("not shown()");
            }
            gaps.push(longest_gap(fixture, "", || {
                fixture.python(format!("viewer.forget(); sent_to = ['{topic}']; send('{topic}', heavy)"));
                fixture.wait_for("shown()");
                fixture.python("before = len(viewer.images)");
                fixture.wait_for("len(viewer.images) > before + 10");
            }));
        }
        let gap = gaps.iter().copied().fold(f64::INFINITY, f64::min);
        println!("{name}: at most {gap:.3} s between pictures ({gaps:.3?})");
        assert!(gap < limit, "{name}: {gap} s without a new picture");
    }
}

fn ends_when_asked_to(mut fixture: RosFixture) {
    let asked = Instant::now();
    fixture.node.signal("TERM");
    let status = fixture.node.wait(PATIENCE).unwrap();
    println!("ended after {:.2} s", asked.elapsed().as_secs_f64());
    assert!(status.success() && asked.elapsed() < Duration::from_secs(2), "{status} after {:?}", asked.elapsed());
}

fn cloud_of(style: &str, topic: &str) -> String {
    format!(
        "{{Class: rviz/PointCloud2, Name: {topic}, Enabled: true, Topic: /{topic}, Style: {style}, Size (m): 0.004, \
         Color Transformer: RGB8, Position Transformer: XYZ, Queue Size: 10, Alpha: 1, Decay Time: 0}}"
    )
}

#[test]
fn pictures_go_on_beside_a_depth_cameras_points_before_the_lens() {
    let displays = [("Flat Squares", "squares"), ("Spheres", "spheres"), ("Boxes", "boxes")];
    let displays = displays.map(|(style, topic)| cloud_of(style, topic));
    let fixture = fixture(&displays.each_ref().map(String::as_str));
    pictures_go_on_beside(
        &fixture,
        &[
            heavy("Flat Squares at 6 cm", "/squares", "heavy_cloud(spread(1900, 0.06))", 200),
            heavy("Flat Squares in one place", "/squares", "heavy_cloud(in_one_place())", 200),
            heavy("Spheres at 6 cm", "/spheres", "heavy_cloud(spread(1900, 0.06))", 200),
            heavy("Spheres in one place", "/spheres", "heavy_cloud(in_one_place())", 200),
            heavy("Boxes at 6 cm", "/boxes", "heavy_cloud(spread(1900, 0.06))", 200),
            heavy("Boxes in one place", "/boxes", "heavy_cloud(in_one_place())", 200),
        ],
    );
    ends_when_asked_to(fixture);
}

#[test]
fn pictures_go_on_beside_five_million_points_near_and_behind_the_lens() {
    let display = cloud_of("Flat Squares", "squares");
    let fixture = fixture(&[&display]);
    pictures_go_on_beside(
        &fixture,
        &[
            heavy("5 million points around", "/squares", "heavy_cloud(between(5000000, 1900, -0.5, 0.5))", 500),
            heavy("5 million points near the lens", "/squares", "heavy_cloud(between(5000000, 1900, 0.05, 0.1))", 500),
        ],
    );
    ends_when_asked_to(fixture);
}

#[test]
fn pictures_go_on_beside_markers_of_very_many_lines_triangles_and_translucent_spheres() {
    let fixture = fixture(&[MARKERS]);
    let list = "of_points(Marker.LINE_LIST, around(1000000))";
    let strip = "of_points(Marker.LINE_STRIP, around(1000000))";
    let triangles = "of_points(Marker.TRIANGLE_LIST, filling(100000), 1)";
    let spheres = "of_points(Marker.SPHERE_LIST, between(100000, 1900, 0.5, 2), 0.02, 0.5)";
    pictures_go_on_beside(
        &fixture,
        &[
            heavy("a line list of a million points", "/markers", list, 400),
            heavy("a line strip of a million points", "/markers", strip, 400),
            heavy("100,000 triangles that fill the picture", "/markers", triangles, 200),
            heavy("100,000 translucent spheres", "/markers", spheres, 400),
        ],
    );
    ends_when_asked_to(fixture);
}

#[test]
fn three_thousand_markers_that_change_fifty_times_a_second_are_drawn_as_often() {
    let markers = "{Class: rviz/MarkerArray, Name: markers, Enabled: true, Marker Topic: /markers}";
    let text = config(&[markers], &[CameraPub::default()]).replace("Frame Rate: 30}", "Frame Rate: 60}");
    let fixture = RosFixture::start(&text, &[]).unwrap();
    fixture.python(MANY);
    fixture.python(HEAVY);
    fixture.python("latch('/tf_static', tf('map', 'eye')); viewer = Viewer('/view/image')");
    fixture.python(CAMERA);
    fixture.python(in_turn(50, "/markers", "spheres", 3000));
    fixture.wait_for("viewer.last and viewer.last.width == 640 and len({i[6] for i in viewer.images}) > 1");
    let changes = "sum(a[6] != b[6] for a, b in zip(viewer.images, viewer.images[1:]))";
    let mut best = 0.0_f64;
    // A busy machine leaves the node more time in one round than in another.
    for _ in 0..10 {
        fixture.python("viewer.forget(); begun = time.time()");
        let cores = core_share(&fixture, Duration::from_secs(3));
        let rate: f64 = fixture.python(format!("{changes} / (time.time() - begun)")).parse().unwrap();
        println!("3,000 markers at 50 Hz: {rate:.1} new pictures a second, {:.0} % of a core", cores * 100.0);
        best = best.max(rate);
        if best > 45.0 {
            break;
        }
    }
    assert!(best > 30.0, "{best} new pictures a second");
}
