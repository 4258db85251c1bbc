//! Meshes of markers: loaded beside the images, and only files that may be read.

use rcs_tests::ros::{wait_until, PATIENCE};
use rcs_tests::ros_fixture::{CameraPub, RosFixture, Setup, CLOUD};
use std::fs::{self, File};
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

use crate::load::{of_process, CAMERA, LOAD, LONGEST_GAP_SECS};

const MARKERS: &str = "{Class: rviz/Marker, Name: markers, Enabled: true, Marker Topic: /markers, Queue Size: 100}";
/// Triangles of a large mesh. Loading it takes some tenths of a second.
const TRIANGLES: usize = 400_000;
/// Triangles of a huge mesh, such as a scan of a building. Its file has 150 MB.
const HUGE_TRIANGLES: usize = 3_000_000;

/// A marker with a mesh, and a cloud of another place and colour in each message.
const PUBLISH: &str = "
from visualization_msgs.msg import Marker
def mesh(url, id=0, scale=1.0):
    marker = Marker(type=Marker.MESH_RESOURCE, ns='m', id=id, mesh_resource=url)
    marker.header.frame_id = 'map'
    marker.pose.position.z = 3
    marker.pose.orientation.w = 1
    marker.scale.x = marker.scale.y = marker.scale.z = scale
    marker.color.r = marker.color.g = marker.color.b = marker.color.a = 1.0
    return marker
cloud_of = lambda i: cloud(0x400000 + i * 7919 % 0xbfffff, points=[(0.9, 0.01 * (i % 50), 2)])
";

/// A node with a display that changes all the time, and whose markers' meshes may be in a folder.
fn fixture(args: &[&str]) -> RosFixture {
    // The light does not reach the square's side that the camera sees: it is black.
    let camera = CameraPub { background: "0; 0; 200", ..CameraPub::default() };
    let fixture = Setup::with_cameras(&[CLOUD, MARKERS], &[camera]).args(args).start();
    fixture.python("monitor()");
    fixture.python(PUBLISH);
    fixture.python("place_camera()");
    fixture.python("viewer = Viewer('/view/image')");
    fixture.python("good = PublishRepeatedly(30, cloud_of, '/cloud')");
    fixture.wait_for("len(viewer.images) > 10");
    fixture
}

fn file_url(path: &Path) -> String {
    format!("file://{}", path.display())
}

/// Waits until the status of a marker contains a text.
fn wait_for_status(fixture: &RosFixture, marker: &str, text: &str) {
    fixture.wait_for(format!("{text:?} in values('camera_stream: markers').get({marker:?}, '')"));
}

/// A binary STL file: a square of 2 m that faces the camera, cut into strips.
fn write_square(path: &Path, triangles: usize) {
    let mut bytes = vec![b' '; 80];
    bytes.extend((triangles as u32).to_le_bytes());
    let strips = triangles / 2;
    let x = |strip: usize| strip as f32 / strips as f32 * 2.0 - 1.0;
    for i in 0..triangles {
        let (left, right) = (x(i / 2), x(i / 2 + 1));
        let (a, b, c, d) = ([left, -1.0, 0.0], [left, 1.0, 0.0], [right, 1.0, 0.0], [right, -1.0, 0.0]);
        let corners = if i % 2 == 0 { [a, b, c] } else { [a, c, d] };
        let numbers = [0.0, 0.0, -1.0].into_iter().chain(corners.into_iter().flatten());
        bytes.extend(numbers.flat_map(|number: f32| number.to_le_bytes()));
        bytes.extend([0, 0]);
    }
    fs::write(path, bytes).unwrap();
}

#[test]
fn images_go_on_while_large_meshes_are_loaded_and_then_show_them() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("square.stl");
    write_square(&file, TRIANGLES);
    let fixture = fixture(&[&format!("_mesh_folder:=[{}]", folder.path().display())]);
    assert_eq!(fixture.python("viewer.middle()"), "(0, 0, 200)");
    for i in 0..3 {
        // The same file under other names, so that each is loaded.
        symlink(&file, folder.path().join(format!("{i}.stl"))).unwrap();
        let url = file_url(&folder.path().join(format!("{i}.stl")));
        fixture.python(format!("send('/markers', mesh('{url}', {i}))"));
    }
    fixture.images_go_on(30);
    fixture.wait_for("viewer.middle() == (0, 0, 0)");
}

/// A binary STL file: a wavy square of 2 m that faces the camera, of `side` times `side` squares, cut in two.
fn write_waves(path: &Path, side: usize) {
    let mut bytes = vec![b' '; 80];
    bytes.extend((2 * side as u32 * side as u32).to_le_bytes());
    let at = |i: usize| i as f32 / side as f32 * 2.0 - 1.0;
    let corner = |column: usize, row: usize| [at(column), at(row), 0.02 * (40.0 * at(column)).sin()];
    let mut push = |corners: [[f32; 3]; 3]| {
        let numbers = [0.0, 0.0, -1.0].into_iter().chain(corners.into_iter().flatten());
        bytes.extend(numbers.flat_map(|number: f32| number.to_le_bytes()));
        bytes.extend([0, 0]);
    };
    for (row, column) in (0..side).flat_map(|row| (0..side).map(move |column| (row, column))) {
        let (a, b) = (corner(column, row), corner(column, row + 1));
        let (c, d) = (corner(column + 1, row + 1), corner(column + 1, row));
        push([a, b, c]);
        push([a, c, d]);
    }
    fs::write(path, bytes).unwrap();
}

#[test]
#[ignore = "a load: ./test full"]
fn images_go_on_while_a_mesh_of_three_million_triangles_comes_and_goes() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("hall.stl");
    write_waves(&file, (HUGE_TRIANGLES as f64 / 2.0).sqrt().ceil() as usize);
    let fixture = fixture(&[&format!("_mesh_folder:=[{}]", folder.path().display())]);
    fixture.python(LOAD);
    fixture.python(CAMERA);
    fixture.wait_for("viewer.last.width == 640");
    // The longest time without a new image, from what is done until its end is seen and for some images more.
    let gap = |done: &str, seen: &str| {
        fixture.python(format!("viewer.forget(); begun = time.time(); {done}"));
        fixture.wait_for(seen);
        fixture.python("seen = time.time(); before = len(viewer.images)");
        fixture.wait_for("len(viewer.images) > before + 10");
        fixture.python("longest_gap()").parse::<f64>().unwrap()
    };
    let megabytes = || of_process(&fixture, "VmRSS") >> 10;
    let before = megabytes();
    let mut with = 0;
    for round in 0..2 {
        // The same file under another name, so that it is loaded again.
        let name = folder.path().join(format!("{round}.stl"));
        symlink(&file, &name).unwrap();
        let coming = gap(&format!("send('/markers', mesh('{}'))", file_url(&name)), "viewer.middle() == (0, 0, 0)");
        let after = fixture.python("'%.2f' % (seen - begun)");
        let staying = gap("pass", "len(viewer.images) > 30");
        with = with.max(megabytes());
        let going = gap("send('/markers', Marker(action=Marker.DELETEALL))", "viewer.middle() == (0, 0, 200)");
        println!(
            "at most {coming:.3} s without a new picture until the mesh is there, which is after {after} s; \
             {staying:.3} s while it is; {going:.3} s when it goes"
        );
        let gap = coming.max(going);
        assert!(gap < LONGEST_GAP_SECS, "{gap} s without a new picture");
    }
    // What nobody uses is given back when another mesh is loaded; free memory that the C library keeps stays.
    let small = folder.path().join("small.stl");
    write_square(&small, 2);
    fixture.python(format!("send('/markers', mesh('{}'))", file_url(&small)));
    let is_given_back = wait_until(PATIENCE, || megabytes() < before + 90);
    println!("{before} MB, at most {with} MB, then {} MB", megabytes());
    assert!(is_given_back && with > before + 80, "the meshes' memory is kept");
}

#[test]
fn files_that_must_not_be_read_are_statuses_and_images_go_on() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    assert!(Command::new("mkfifo").arg(path("fifo.stl")).status().unwrap().success());
    fs::create_dir(path("folder.stl")).unwrap();
    symlink("/dev/zero", path("zero.stl")).unwrap();
    symlink("/dev/tty", path("tty.stl")).unwrap();
    File::create(path("huge.stl")).unwrap().set_len(1 << 40).unwrap();
    write_square(&path("large.stl"), 30_000);
    let outside = tempfile::tempdir().unwrap();
    write_square(&outside.path().join("outside.stl"), 2);
    let fixture = fixture(&["--mesh-folder", &folder.path().display().to_string(), "_max_mesh_mb:=1"]);
    let cases = [
        (file_url(&path("fifo.stl")), "it is a FIFO, only regular files are read"),
        (file_url(&path("folder.stl")), "it is a folder, only regular files are read"),
        (file_url(&path("zero.stl")), "it is a device, only regular files are read"),
        (file_url(&path("tty.stl")), "it is a device, only regular files are read"),
        (file_url(&path("huge.stl")), "larger than 1 MB"),
        (file_url(&path("large.stl")), "larger than 1 MB"),
        (file_url(&outside.path().join("outside.stl")), "add its folder to the parameter ~mesh_folder"),
        ("file:///etc/passwd".to_owned(), "mesh format"),
        ("package://roscpp/../../../etc/passwd.stl".to_owned(), "the path leaves package"),
        ("http://127.0.0.1:9/a.stl".to_owned(), "nothing is downloaded"),
        ("package://no_such_package/a.stl".to_owned(), "is not on the search path"),
        ("package://$(touch /tmp/x)`id`;/a.stl".to_owned(), "is not on the search path"),
    ];
    for (i, (url, _)) in cases.iter().enumerate() {
        fixture.python(format!("send('/markers', mesh({url:?}, {i}))"));
    }
    // A missing package again and again, of other files each time.
    fixture.python("[send('/markers', mesh('package://no_such_package/%d.stl' % i, 100 + i)) for i in range(30)]");
    fixture.images_go_on(60);
    for (i, (_, reason)) in cases.iter().enumerate() {
        wait_for_status(&fixture, &format!("m/{i}"), reason);
    }

    // A file that is corrected is shown when its marker comes again.
    let url = file_url(&path("large.stl"));
    assert_eq!(fixture.python("viewer.middle()"), "(0, 0, 200)");
    write_square(&path("large.stl"), 2);
    fixture.python(format!("send('/markers', mesh('{url}', 5))"));
    fixture.wait_for("viewer.middle() == (0, 0, 0)");
    fixture.wait_for("'m/5' not in values('camera_stream: markers')");
}
