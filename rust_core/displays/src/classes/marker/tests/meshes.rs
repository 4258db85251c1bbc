//! Markers that show the mesh of a file.

use super::*;
use crate::framework::test_world::STL;

/// A mesh of one triangle with a material of its own, and the bench that finds it.
fn with_mesh(extension: &str) -> (Bench, Marker, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("package.xml", "<package><name>m</name></package>");
    write("m.mtl", "newmtl blue\nKd 0 0 1\n");
    write("m.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl blue\nf 1 2 3\n");
    write(
        "m.stl",
        "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid s\n",
    );
    let mut marker = marker(Marker::MESH_RESOURCE, 1);
    marker.mesh_resource = format!("file://{}", folder.path().join(format!("m.{extension}")).display());
    (Bench::new(), marker, folder)
}

#[test]
fn a_mesh_takes_the_markers_colour_or_is_tinted_with_it() {
    let (mut bench, mut mesh, _folder) = with_mesh("obj");
    let drawn = bench.only(&mesh);
    assert_eq!(diffuse(&drawn), [1.0, 0.5, 0.0, 1.0]);

    mesh.mesh_use_embedded_materials = true;
    let drawn = bench.show(&[mesh.clone()]);
    let [own, tint] = drawn.as_slice() else { panic!("own material and tint") };
    assert_eq!((diffuse(own), diffuse(tint)), ([0.0, 0.0, 1.0, 1.0], [1.0, 0.5, 0.0, 0.5]));
    assert_eq!((material(own).blending, material(tint).blending), (Blending::Replace, Blending::Alpha));
    assert!(!tint.geometry.is_translucent(), "the tint of an opaque part is drawn with the opaque things");

    mesh.color.a = 0.25;
    let drawn = bench.show(&[mesh.clone()]);
    assert_eq!(drawn.iter().map(diffuse).collect::<Vec<_>>(), [[0.0, 0.0, 1.0, 0.25], [1.0, 0.5, 0.0, 0.25]]);
    assert!(drawn.iter().all(|drawable| drawable.geometry.is_translucent()));

    // All zero asks for the file's colours, but only of a new mesh.
    mesh.color = color(0.0, 0.0, 0.0, 0.0);
    let drawn = bench.show(&[mesh.clone()]);
    assert_eq!((drawn.len(), diffuse(&drawn[0])), (2, [0.0, 0.0, 1.0, 0.0]));
    mesh.id = 2;
    bench.show(&[delete_all()]);
    assert_eq!(diffuse(&bench.only(&mesh)), [0.0, 0.0, 1.0, 1.0]);
}

#[test]
fn a_mesh_without_materials_takes_the_tint_for_its_colour() {
    let (mut bench, mut mesh, _folder) = with_mesh("stl");
    mesh.mesh_use_embedded_materials = true;
    let drawn = bench.only(&mesh);
    assert_eq!((diffuse(&drawn), drawn.geometry.is_translucent()), ([1.0, 0.5, 0.0, 0.5], false));
}

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
