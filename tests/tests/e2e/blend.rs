//! Several projectors on one surface: `projector_blend` writes each one's share, and the node gives it to its pictures.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use rcs_calibration::Lens;
use rcs_files::blend_file::BlendFile;
use rcs_files::projector::ProjectorFile;
use rcs_tests::programs::program;
use rcs_tests::ros_fixture::{config, CameraPub, RosFixture, CLOUD};

const SIZE: [u32; 2] = [128, 80];

/// A projector's file: 2 m before the wall z = 0, so far to the side, upright.
fn write_projector(folder: &Path, name: &str, x: f64) -> String {
    let lens = Lens::pinhole(SIZE, [120.0, 121.0], [64.0, 40.0]);
    let pose = Isometry3::from_parts(Vector3::new(x, 0.0, -2.0).into(), UnitQuaternion::identity());
    let mut file = ProjectorFile::calibrated(&lens, "map", &pose);
    // Two files must not place one frame.
    file.camera_info.header.frame_id = format!("{name}_frame");
    file.frames[0].child = format!("{name}_frame");
    let path = folder.join(format!("{name}.yaml"));
    file.write(&path).unwrap();
    path.display().to_string()
}

/// A wall as a PCD file.
fn write_wall(path: &Path) {
    let points: Vec<[f64; 2]> =
        (-100..=100).flat_map(|x| (-60..=60).map(move |y| [0.02 * f64::from(x), 0.02 * f64::from(y)])).collect();
    let mut text = format!(
        "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {0}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\n\
         POINTS {0}\nDATA ascii\n",
        points.len()
    );
    for [x, y] in points {
        let _ = writeln!(text, "{x} {y} 0");
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

#[test]
fn the_node_gives_its_pictures_their_share_in_linear_light() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("half.png");
    let weights: Vec<f32> = (0..64 * 48).map(|at| if at % 64 < 32 { 0.5 } else { 1.0 }).collect();
    BlendFile::new([64, 48], &weights, &[0.0; 64 * 48]).write(&path).unwrap();
    let arg = format!("_blend:={}", path.display());
    let fixture = RosFixture::start(&config(&[CLOUD], &[CameraPub::default()]), &[&arg]).unwrap();
    fixture.python("latch('/tf_static', tf('map', 'eye'))");
    fixture.python("latch('/eye/camera_info', info())");
    fixture.python("latch('/cloud', cloud(0xff0000))");
    fixture.python("viewer = Viewer('/view/image')");
    // Half the light of 255 is the level 255 · 0.5^(1 / 2.2).
    fixture.wait_for("viewer.last and viewer.pixel(40, 24) == (255, 0, 0) and viewer.pixel(24, 24) == (186, 0, 0)");
}

#[test]
fn weights_that_cannot_be_read_are_named() {
    let output = RosFixture::start(&config(&[CLOUD], &[CameraPub::default()]), &["--blend", "/nowhere/left.png"]);
    let error = output.err().map(|error| error.to_string()).unwrap_or_default();
    assert!(error.contains("/nowhere/left.png: cannot read it"), "{error}");
}
