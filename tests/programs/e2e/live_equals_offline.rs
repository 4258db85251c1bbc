//! The node draws of a played bag what `camera_stream render` draws of the same bag without ROS.

use rcs_tests::golden::GoldenCase;
use rcs_tests::programs::program;
use rcs_tests::python_node::PythonNode;
use rcs_tests::ros::{wait_until, RosMaster, Running, PATIENCE};
use std::fs;
use std::path::Path;
use std::process::Command;

/// Width, height and pixels that `render` draws of a case, with the channels in the order of an encoding.
fn offline(case: &GoldenCase, folder: &Path, encoding: &str) -> (u32, u32, Vec<u8>) {
    let png = folder.join("offline.png");
    let mut command = Command::new(program("camera_stream"));
    command.args(["render", "--renderer", "cpu", "-d"]).arg(&case.config);
    let output = command.arg("--bag").arg(&case.bag).arg("-o").arg(&png).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let image = image::open(&png).unwrap();
    let (width, height) = (image.width(), image.height());
    let mut pixels = if encoding == "mono8" { image.to_luma8().into_raw() } else { image.to_rgb8().into_raw() };
    if encoding == "bgr8" {
        pixels.chunks_exact_mut(3).for_each(|pixel| pixel.swap(0, 2));
    }
    (width, height, pixels)
}

#[test]
fn a_played_bag_gives_the_image_that_render_draws_of_it() {
    let master = RosMaster::start().unwrap();
    let cases = [
        ("pc2_flat_squares_rgb8", "rgb8"),
        ("cam_visibility_some", "rgb8"),
        ("marker_lists", "rgb8"),
        ("path_lines", "rgb8"),
        ("interactive_marker", "rgb8"),
        ("cam_encoding_bgr8", "bgr8"),
        ("cam_encoding_mono8", "mono8"),
    ];
    let python = PythonNode::start(&master, &[]).unwrap();
    for (name, encoding) in cases {
        let folder = tempfile::tempdir().unwrap();
        let case = GoldenCase::new(name, folder.path()).unwrap();
        let (width, height, expected) = offline(&case, folder.path(), encoding);

        let node = Running::start(master.program("camera_stream").args(["--renderer", "cpu", "-d"]).arg(&case.config))
            .unwrap();
        let log = || node.errors().join("\n");
        assert!(wait_until(PATIENCE, || log().contains("drawing")), "{name}: {}", log());
        // The bag marks latched topics as such; with --keep-alive their publishers remain at its end.
        let mut player = master.command("rosbag");
        let player = Running::start(player.args(["play", "--keep-alive"]).arg(&case.bag)).unwrap();
        python.run("viewer = Viewer('/proj_view/image')").unwrap();

        let live = folder.path().join("live");
        let mut last = Vec::new();
        let is_same = || {
            let saved = python.run(format!("viewer.save('{}')", live.display())).is_ok();
            last = if saved { fs::read(&live).unwrap() } else { Vec::new() };
            last == expected
        };
        if !wait_until(PATIENCE, is_same) {
            let differing = last.iter().zip(&expected).filter(|(live, offline)| live != offline).count();
            panic!(
                "{name}: {differing} of {} bytes differ ({} came)\n{}\n{:?}",
                expected.len(),
                last.len(),
                log(),
                player.errors()
            );
        }
        let layout =
            "viewer.last.encoding, viewer.last.width, viewer.last.height, viewer.last.step, viewer.last.is_bigendian";
        let step = width * if encoding == "mono8" { 1 } else { 3 };
        assert_eq!(python.run(layout).unwrap(), format!("('{encoding}', {width}, {height}, {step}, 0)"), "{name}");
        assert_eq!(python.run("viewer.last.header.frame_id").unwrap(), "proj_view");
        python.run("viewer.close()").unwrap();
    }
}
