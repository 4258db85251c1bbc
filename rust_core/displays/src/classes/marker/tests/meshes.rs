//! Markers that show the mesh of a file.

use super::*;
use crate::framework::test_world::STL;

fn mesh(url: &str, id: i32) -> Marker {
    Marker { mesh_resource: url.to_owned(), ..marker(Marker::MESH_RESOURCE, id) }
}

#[test]
fn a_mesh_appears_when_it_is_loaded_and_the_others_do_not_wait_for_it() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.stl"), STL).unwrap();
    let mut bench = Bench::new();
    let gate = bench.world.load_behind_gate(folder.path());
    let url = format!("file://{}/a.stl", folder.path().display());
    let mut late = mesh(&url, 3);
    late.header.frame_id = "arm".to_owned();
    late.frame_locked = true;
    let broken = mesh("http://x/y.stl", 4);
    let shown = bench.show(&[mesh(&url, 1), marker(Marker::CUBE, 2), late, broken]);
    assert_eq!(shown.len(), 1, "the cube");
    let loading = |url: &str| Some((Level::Ok, format!("loading [{url}]")));
    assert_eq!(bench.status("n/1"), loading(&url));
    assert_eq!(bench.status("n/4"), loading("http://x/y.stl"));
    assert!(!bench.update(), "nothing new");

    // Another colour while it is loading: the marker appears in it.
    let mut blue = mesh(&url, 1);
    blue.color = color(0.0, 0.0, 1.0, 1.0);
    assert_eq!(bench.show(&[blue]).len(), 1);
    let version = bench.world.version();
    gate.open();
    bench.world.wait_for_version(version + 2);
    assert!(bench.update());
    let drawn = bench.drawn();
    let [mesh, _cube] = drawn.as_slice() else { panic!("{drawn:?}") };
    let Geometry::Mesh { material, .. } = &mesh.geometry else { panic!("{mesh:?}") };
    assert!(matches!(material.lighting, Lighting::Lit { diffuse, .. } if diffuse.to_array() == [0.0, 0.0, 1.0, 1.0]));
    assert_eq!(bench.status("n/1"), None);
    let (level, text) = bench.status("n/4").unwrap();
    assert!(level == Level::Error && text.contains("could not load [http://x/y.stl]"), "{text}");
    assert!(!bench.update(), "nothing new");

    // The one whose frame comes later is there with its mesh.
    bench.place("arm", 100, 1.0);
    assert!(bench.update());
    assert_eq!(bench.drawn().len(), 3);
    assert_eq!(bench.status("n/3"), None);
}

#[test]
fn a_corrected_mesh_is_shown_when_its_marker_comes_again() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.stl");
    let url = format!("file://{}", file.display());
    std::fs::write(&file, "nothing").unwrap();
    let mut bench = Bench::new();
    bench.world.load_behind_gate(folder.path()).open();
    let version = bench.world.version();
    bench.show(&[mesh(&url, 1)]);
    bench.world.wait_for_version(version + 1);
    bench.update();
    assert_eq!(bench.status("n/1").unwrap().0, Level::Error);
    std::fs::write(&file, STL).unwrap();
    assert!(bench.show(&[mesh(&url, 1)]).is_empty());
    bench.world.wait_for_version(version + 2);
    assert!(bench.update());
    assert_eq!((bench.drawn().len(), bench.status("n/1")), (1, None));
}
