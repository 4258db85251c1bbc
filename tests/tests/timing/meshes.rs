//! Meshes of markers: loaded beside the pictures, and only files that may be read.

use rcs_tests::python_node::MONITOR;
use rcs_tests::ros_fixture::{config, CameraPub, RosFixture, CLOUD};
use std::fs::{self, File};
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

const MARKERS: &str = "{Class: rviz/Marker, Name: markers, Enabled: true, Marker Topic: /markers, Queue Size: 100}";
/// Triangles of a large mesh. Loading it takes some tenths of a second.
const TRIANGLES: usize = 400_000;
/// Much longer than between two pictures, much shorter than the node was blocked before meshes were loaded beside.
const LONGEST_GAP: Duration = Duration::from_millis(500);

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
cloud_of = lambda i: cloud(0xff8000 if i % 2 else 0x0080ff, points=[(0.9, 0.01 * (i % 50), 2)])
";

/// A node with a display that changes all the time, and whose markers' meshes may be in a folder.
fn fixture(args: &[&str]) -> RosFixture {
    // The light does not reach the square's side that the camera sees: it is black.
    let camera = CameraPub { background: "0; 0; 200", ..CameraPub::default() };
    let fixture = RosFixture::start(&config(&[CLOUD, MARKERS], &[camera]), args).unwrap();
    fixture.python("topic = '/diagnostics'");
    fixture.python(MONITOR);
    fixture.python(PUBLISH);
    fixture.python("latch('/tf_static', tf('map', 'eye'))");
    fixture.python("latch('/eye/camera_info', info())");
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
fn pictures_go_on_while_large_meshes_are_loaded_and_then_show_them() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("square.stl");
    write_square(&file, TRIANGLES);
    let fixture = fixture(&[&format!("_mesh_folders:=[{}]", folder.path().display())]);
    assert_eq!(fixture.python("viewer.middle()"), "(0, 0, 200)");
    for i in 0..3 {
        // The same file under other names, so that each is loaded.
        symlink(&file, folder.path().join(format!("{i}.stl"))).unwrap();
        let url = file_url(&folder.path().join(format!("{i}.stl")));
        fixture.python(format!("send('/markers', mesh('{url}', {i}))"));
    }
    fixture.pictures_go_on(30, LONGEST_GAP);
    fixture.wait_for("viewer.middle() == (0, 0, 0)");
}

#[test]
fn files_that_must_not_be_read_are_statuses_and_pictures_go_on() {
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
        (file_url(&outside.path().join("outside.stl")), "add its folder to the parameter ~mesh_folders"),
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
    fixture.pictures_go_on(60, LONGEST_GAP);
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
