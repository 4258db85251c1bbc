//! Every thread has a name, in the programs that share work among threads, too; [`crate::lifecycle`] has the node's.

use std::collections::BTreeMap;
use std::fs;
use std::process::{Command, Stdio};
use std::thread;
use std::time::Duration;

use rcs_tests::programs::{program, repository};

/// How often the threads are looked at.
const PERIOD: Duration = Duration::from_millis(2);

/// The threads of a process by their ids. One that ends meanwhile is left out.
fn thread_names(process: u32) -> BTreeMap<u32, String> {
    let Ok(tasks) = fs::read_dir(format!("/proc/{process}/task")) else { return BTreeMap::new() };
    let named = tasks.filter_map(|task| {
        let path = task.ok()?.path();
        let id = path.file_name()?.to_str()?.parse().ok()?;
        Some((id, fs::read_to_string(path.join("comm")).ok()?.trim_end().to_owned()))
    });
    named.collect()
}

/// Runs a program to its end, and asserts that it shares work and that all of its threads get names: until then, a
/// thread has the name of the one that started it.
fn assert_named(command: &mut Command) {
    let mut running = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let mut names = BTreeMap::new();
    let status = loop {
        names.extend(thread_names(running.id()));
        if let Some(status) = running.try_wait().unwrap() {
            break status;
        }
        thread::sleep(PERIOD);
    };
    assert!(status.success(), "{command:?}: {status}");
    let own = names.remove(&running.id()).unwrap();
    println!("{own}: {names:?}");
    assert!(names.values().any(|name| name == "draw-0"), "{own} shares no work: {names:?}");
    assert!(names.values().all(|name| *name != own), "{own}: {names:?}");
}

#[test]
fn threads_that_share_work_have_names_in_every_program() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let run = |name: &str, arguments: &[&str]| assert_named(Command::new(program(name)).args(arguments));
    let simulate = |arguments: &[&str]| assert_named(Command::new(program("simulate_scan")).args(arguments));

    // The demo's image, so large that it takes a while.
    let demo = |name: &str| repository().join(name).to_str().unwrap().to_owned();
    let lens = fs::read_to_string(demo("config/projector.yaml")).unwrap();
    let large = lens.replace("\nwidth: 1280\nheight: 800\n", "\nwidth: 6400\nheight: 4000\n");
    fs::write(at("large.yaml"), large).unwrap();
    let drawn =
        [&demo("rviz/projection.rviz"), "--bag", &demo("config/demo/demo.bag"), "--projector", &at("large.yaml")];
    run("camera_stream", &[&["render", "-d"], &drawn[..], &["--renderer", "cpu", "-o", &at("out.png")]].concat());
    run("projector_calibrate", &["patterns", "--size", "1280x800", "-o", &at("patterns")]);
    simulate(&["scan", &at("")]);
    run("projector_calibrate", &["decode", &at("capture_0"), "-o", &at("points.csv")]);
    fs::write(at("wall.pcd"), wall()).unwrap();
    // The same projector again, by another name.
    let truth = fs::read_to_string(at("truth.yaml")).unwrap();
    fs::write(at("other.yaml"), truth.replace("proj_view", "other_view")).unwrap();
    let light = [&*at("truth.yaml"), &at("other.yaml"), "--cloud", &at("wall.pcd")];
    run("projector_blend", &[&light[..], &["--frame", "head_camera_rgb_optical_frame", "-o", &at("shares")]].concat());
    simulate(&["light", &at("truth.yaml"), "-o", &at("light.png")]);
}

/// A wall before the camera, as a PCD file.
fn wall() -> String {
    let places = |half_m: i32| (-half_m..=half_m).map(|place| f64::from(place) * 0.02);
    let points: Vec<String> = places(100).flat_map(|x| places(60).map(move |y| format!("{x} {y} 1.5\n"))).collect();
    format!(
        "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {0}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\n\
         POINTS {0}\nDATA ascii\n{1}",
        points.len(),
        points.concat()
    )
}
