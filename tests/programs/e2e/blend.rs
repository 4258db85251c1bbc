//! Several projectors on one surface: `projector_blend` writes each one's share, and the node gives it to its images.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use nalgebra::{Isometry3, Vector3};
use rcs_calibration::Lens;
use rcs_files::blend_file::BlendFile;
use rcs_files::projector::ProjectorFile;
use rcs_tests::programs::{program, repository};
use rcs_tests::ros::{Running, PATIENCE};
use rcs_tests::ros_fixture::{config, master_and_python, CameraPub, Setup, CLOUD};

const SIZE: [u32; 2] = [128, 80];

/// A projector's file: 2 m before the wall z = 0 of the frame `map`, so far to the side, upright.
fn write_projector(folder: &Path, name: &str, x: f64) -> String {
    write_projector_in(folder, name, "map", [x, 0.0, -2.0])
}

/// A projector's file, which places it somewhere in this frame.
fn write_projector_in(folder: &Path, name: &str, parent: &str, [x, y, z]: [f64; 3]) -> String {
    let lens = Lens::pinhole(SIZE, [120.0, 121.0], [64.0, 40.0]);
    write_file(folder, name, parent, &lens, &Isometry3::from(Vector3::new(x, y, z)))
}

/// The file of a projector with this lens, at a pose in a frame.
fn write_file(folder: &Path, name: &str, parent: &str, lens: &Lens, pose: &Isometry3<f64>) -> String {
    let mut file = ProjectorFile::calibrated(lens, parent, pose);
    // Two files must not place one frame.
    file.camera_info.header.frame_id = format!("{name}_frame");
    file.frames[0].child = format!("{name}_frame");
    file.camera_info_topic = Some(format!("/{name}/camera_info"));
    let path = folder.join(format!("{name}.yaml"));
    file.write(&path).unwrap();
    path.display().to_string()
}

/// The points of an upright rectangle so far before the wall, so far apart; all in metres.
fn rectangle([left, right]: [f64; 2], [top, bottom]: [f64; 2], before: f64, step: f64) -> Vec<[f64; 3]> {
    let places = |begin: f64, end: f64| {
        let count = ((end - begin) / step).round() as i32;
        (0..=count).map(move |i| begin + step * f64::from(i))
    };
    places(left, right).flat_map(|x| places(top, bottom).map(move |y| [x, y, -before])).collect()
}

/// A wall as a PCD file.
fn write_wall(path: &Path) {
    write_cloud(path, &rectangle([-2.0, 2.0], [-1.2, 1.2], 0.0, 0.02));
}

fn write_cloud(path: &Path, points: &[[f64; 3]]) {
    let mut text = format!(
        "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {0}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\n\
         POINTS {0}\nDATA ascii\n",
        points.len()
    );
    for [x, y, z] in points {
        let _ = writeln!(text, "{x} {y} {z}");
    }
    std::fs::write(path, text).unwrap();
}

#[test]
fn the_shares_of_two_projectors_add_up_on_the_wall_and_are_files_for_each() {
    let folder = tempfile::tempdir().unwrap();
    let (left, right) = (write_projector(folder.path(), "left", -0.5), write_projector(folder.path(), "right", 0.5));
    let wall = folder.path().join("wall.pcd");
    write_wall(&wall);
    let run = |args: &[&str]| Command::new(program("projector_blend")).args(args).output().unwrap();
    let (wall, out) = (wall.display().to_string(), folder.path().join("out").display().to_string());
    let preview = folder.path().join("preview.png").display().to_string();
    let args = [&*left, &*right, "--cloud", &wall, "-o", &out, "--black-level", "0.01", "--preview", &preview];
    let output = run(&args);
    assert!(output.status.success(), "{output:?}");
    let [left_file, right_file] =
        ["left", "right"].map(|name| BlendFile::read(&Path::new(&out).join(format!("{name}.blend.png"))).unwrap());
    assert_eq!((left_file.size_px, right_file.size_px), (SIZE, SIZE));
    // A metre at 2 m is 60 pixels: what pixel (u, v) of the left one lights, (u - 60, v) of the right one does.
    for v in [5, 40, 70] {
        for u in 0..128 {
            let at = |file: &BlendFile, u: usize| f64::from(file.weights[v * 128 + u]) / 65535.0;
            let sum = at(&left_file, u) + if u >= 60 { at(&right_file, u - 60) } else { 0.0 };
            assert!((sum - 1.0).abs() < 0.02, "({u}, {v}): {sum}");
            let lift = left_file.lifts[v * 128 + u];
            assert_eq!(lift, if u < 60 { 655 } else { 0 }, "({u}, {v})");
        }
        let edges = [left_file.weights[v * 128 + 127], right_file.weights[v * 128]];
        assert!(edges.iter().all(|weight| *weight < 656), "{v}: {edges:?}");
    }
    assert!(image::open(&preview).unwrap().width() > 500);
    let refused = run(&[&left, &left, "--cloud", &wall]);
    assert!(String::from_utf8_lossy(&refused.stderr).contains("rename one"), "{refused:?}");
}

/// The image of docs/how-to/mounting-and-blending.md, as it says. `UPDATE_GALLERY=1` writes it again.
#[test]
fn the_documented_image_is_that_of_two_projectors_a_wall_and_a_box() {
    const STEP_M: f64 = 0.005;
    const TURN: f64 = 0.06;
    let folder = tempfile::tempdir().unwrap();
    let lens = Lens::pinhole([480, 300], [500.0, 500.0], [240.0, 150.0]);
    let [left, right] = [("left", -0.5, TURN), ("right", 0.5, -TURN)].map(|(name, x, turn)| {
        let pose = Isometry3::new(Vector3::new(x, 0.0, -2.0), Vector3::y() * turn);
        write_file(folder.path(), name, "map", &lens, &pose)
    });
    let mut points = rectangle([-2.0, 2.0], [-1.2, 1.2], 0.0, STEP_M);
    points.extend(rectangle([-0.2, 0.2], [0.1, 1.2], 0.4, STEP_M));
    // The sides of the box, and its top.
    let depths = (0..80).map(|i| STEP_M * f64::from(i));
    points.extend(depths.flat_map(|before| {
        let sides = [-0.2, 0.2].into_iter().flat_map(move |x| rectangle([x, x], [0.1, 1.2], before, STEP_M));
        sides.chain(rectangle([-0.2, 0.2], [0.1, 0.1], before, STEP_M))
    }));
    let [cloud, preview] = ["wall.pcd", "preview.png"].map(|name| folder.path().join(name));
    write_cloud(&cloud, &points);
    let mut command = Command::new(program("projector_blend"));
    command.args([&left, &right, "--frame", "map", "-o"]).arg(folder.path());
    let output = command.arg("--cloud").arg(&cloud).arg("--preview").arg(&preview).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let documented = repository().join("docs/images/blend.png");
    if std::env::var_os("UPDATE_GALLERY").is_some() {
        std::fs::copy(&preview, &documented).unwrap();
    }
    let [drawn, documented] = [&preview, &documented].map(|path| image::open(path).unwrap().to_luma8());
    assert_eq!(drawn.dimensions(), documented.dimensions());
    let differ = drawn.iter().zip(documented.iter()).filter(|(a, b)| a.abs_diff(**b) > 1).count();
    assert!(differ * 1000 < drawn.len(), "{differ} pixels differ: run this test with UPDATE_GALLERY=1");
}

#[test]
fn the_node_gives_its_images_their_share_in_linear_light() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("half.png");
    let weights: Vec<f32> = (0..64 * 48).map(|at| if at % 64 < 32 { 0.5 } else { 1.0 }).collect();
    let lifts: Vec<f32> = (0..64 * 48).map(|at| if at % 64 < 32 { 0.01 } else { 0.0 }).collect();
    BlendFile::new([64, 48], &weights, &lifts).write(&path).unwrap();
    let arg = format!("_blend:={}", path.display());
    let fixture = Setup::of(&[CLOUD]).args(&[&arg]).start();
    fixture.python("show()");
    // Half the light of 255, and of what is left over the lift, is the level 255 · (0.01 + 0.99 · 0.5)^(1 / 2.2).
    fixture.wait_for("viewer.last and viewer.pixel(40, 24) == (255, 0, 0) and viewer.pixel(24, 24) == (187, 31, 31)");
    assert_eq!(fixture.python("viewer.pixel(2, 2), viewer.pixel(60, 2)"), "((31, 31, 31), (0, 0, 0))");
}

/// The light of both projectors on the wall, whose levels are light to the power of each one's gamma. What pixel
/// (u + 60, v) of the left one lights, (u, v) of the right one does.
const LIGHT: &str = "
def light(viewer, u, v, gamma):
    return (viewer.pixel(u, v)[0] / 255) ** gamma
def is_even():
    both = [light(left, u + 60, v, 1.8) + light(right, u, v, 2.6) for u in range(68) for v in (5, 40, 74)]
    alone = [light(left, u, v, 1.8) for u in range(58) for v in (5, 40, 74)]
    return max(abs(sum - 1) for sum in both + alone) < 0.03
";

#[test]
fn nodes_that_know_nothing_of_each_other_light_the_live_surface_evenly() {
    let folder = tempfile::tempdir().unwrap();
    let left = write_projector(folder.path(), "left", -0.5);
    // Its frame is placed by a file, and the frame of that on /tf only.
    let right = write_projector_in(folder.path(), "right", "stand", [0.0, 0.0, -1.0]);
    let (master, python) =
        master_and_python("wall = [(0.05 * x, 0.05 * y, 0) for x in range(-45, 46) for y in range(-25, 26)]");
    python.run("PublishRepeatedly(5, lambda i: cloud(0xffffff, points=wall), '/cloud')").unwrap();
    python
        .run("PublishRepeatedly(20, lambda i: tf('map', 'stand', (0.5, 0, -1), stamp=rospy.Time.now()), '/tf')")
        .unwrap();
    let blended = master
        .program("projector_blend")
        .args([&left, &right, "--topic", "/cloud", "-o", &folder.path().display().to_string()])
        .output()
        .unwrap();
    assert!(blended.status.success(), "{blended:?}");

    // Each projector has a machine of its own: another address, a node that publishes its file, and one that draws.
    let start = |name: &str, address: &str, file: &str, gamma: &str| {
        let on_machine = |program_name: &str| {
            let mut command = master.program(program_name);
            command.env("ROS_IP", address).arg(format!("__name:={name}_{program_name}"));
            command
        };
        let publisher = Running::start(on_machine("projector").arg(file)).unwrap();
        let cloud = CLOUD.replace("Size (m): 1", "Size (m): 0.1");
        let scene = folder.path().join(format!("{name}.rviz"));
        let text = config(&[&cloud], &[CameraPub { image: "IMAGE", info: "INFO", ..CameraPub::default() }]);
        let text = text.replace("IMAGE", &format!("/{name}/image")).replace("INFO", &format!("/{name}/camera_info"));
        std::fs::write(&scene, text).unwrap();
        let weights = folder.path().join(format!("{name}.blend.png"));
        let mut node = on_machine("camera_stream");
        node.args(["--renderer", "cpu", "--projection", "exact", "--blend-gamma", gamma, "-d"]).arg(scene);
        node.arg(format!("_blend:={}", weights.display()));
        (publisher, Running::start(&mut node).unwrap())
    };
    let _left = start("left", "127.0.0.2", &left, "1.8");
    let _right = start("right", "127.0.0.3", &right, "2.6");
    python.run(LIGHT).unwrap();
    python.run("left, right = Viewer('/left/image'), Viewer('/right/image')").unwrap();
    let is_even = python.wait_for(PATIENCE, "left.last and right.last and is_even()");
    let row = "[(left.pixel(u + 60, 40)[0], right.pixel(u, 40)[0]) for u in range(68)]";
    assert!(is_even, "{:?}", python.run(row));
    // The edges are soft.
    assert_eq!(python.run("left.pixel(127, 40)[0] < 40 and right.pixel(0, 40)[0] < 40").unwrap(), "True");
}

#[test]
fn a_painted_mask_keeps_its_camera_dark_beside_the_weights() {
    let folder = tempfile::tempdir().unwrap();
    let [mask, blend] = ["mask.png", "blend.png"].map(|name| folder.path().join(name).display().to_string());
    image::GrayImage::from_fn(64, 48, |u, _| image::Luma([if u < 32 { 255 } else { 0 }])).save(&mask).unwrap();
    image::GrayImage::from_fn(64, 48, |_, v| image::Luma([if v < 24 { 255 } else { 0 }])).save(&blend).unwrap();
    let other = CameraPub { name: "other", image: "/other/image", ..CameraPub::default() };
    let args = [format!("_mask:=[{{camera: other, file: {mask}}}]"), format!("_blend:={blend}")];
    let args = args.each_ref().map(String::as_str);
    let fixture = Setup::with_cameras(&[CLOUD], &[CameraPub::default(), other]).args(&args).start();
    fixture.python("place_camera()");
    fixture.python("latch('/cloud', cloud(0xff0000))");
    fixture.python("viewer, other = Viewer('/view/image'), Viewer('/other/image')");
    fixture
        .python("def lit(viewer): return [viewer.pixel(u, v)[0] for u, v in ((28, 20), (36, 20), (28, 28), (36, 28))]");
    fixture.wait_for("viewer.last and lit(viewer) == [255, 255, 0, 0]");
    fixture.wait_for("other.last and lit(other) == [255, 0, 0, 0]");
}

#[test]
fn weights_that_cannot_be_read_are_named() {
    let fixture = Setup::of(&[CLOUD]).args(&["--blend", "/nowhere/left.png"]).launch();
    fixture.wait_for_log("/nowhere/left.png: cannot read it").unwrap();
}
