//! Addresses into paths, by rospack's rules.
#![expect(clippy::unwrap_used, reason = "a test that cannot be set up fails")]

use std::{
    fs,
    path::{Path, PathBuf},
};

use rcs_resources::{PackageIndex, ResourceError};
use tempfile::TempDir;

/// A folder with these files; a file's text is the package's name where it is a `package.xml`.
fn tree(files: &[(&str, &str)]) -> TempDir {
    let dir = tempfile::tempdir().unwrap();
    for (path, name) in files {
        let path = dir.path().join(path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, format!("<?xml version=\"1.0\"?>\n<package format=\"2\">\n <name> {name}\n</name></package>"))
            .unwrap();
    }
    dir
}

fn index(roots: &[&Path]) -> PackageIndex {
    PackageIndex::new(roots.iter().map(|root| root.to_path_buf()))
}

/// Files in a search folder, and the folders in it that packages of these names have.
type Case = (&'static [(&'static str, &'static str)], &'static [(&'static str, Option<&'static str>)]);

const SEARCHES: [Case; 7] = [
    // By the name in the manifest.
    (
        &[("src/deep/folder/package.xml", "robot_description")],
        &[("robot_description", Some("src/deep/folder")), ("folder", None)],
    ),
    // A folder of the right name may have another package's manifest.
    (
        &[("arm/package.xml", "arm_old"), ("src/new_arm/package.xml", "arm")],
        &[("arm", Some("src/new_arm")), ("arm_old", Some("arm"))],
    ),
    // A rosbuild package is named after its folder.
    (
        &[("stack/legacy/manifest.xml", "ignored"), ("both/manifest.xml", ""), ("both/package.xml", "wet")],
        &[("legacy", Some("stack/legacy")), ("both", Some("both")), ("wet", None)],
    ),
    // Packages are not searched for packages.
    (
        &[("a/outer/package.xml", "outer"), ("a/outer/inner/package.xml", "inner")],
        &[("outer", Some("a/outer")), ("inner", None)],
    ),
    // A search folder that is a package is that package only.
    (&[("package.xml", "me"), ("other/package.xml", "other")], &[("me", Some("")), ("other", None)]),
    // Ignored and hidden folders are skipped.
    (
        &[
            ("a/CATKIN_IGNORE", ""),
            ("a/in_a/package.xml", "in_a"),
            ("ignored/CATKIN_IGNORE", ""),
            ("ignored/package.xml", "ignored"),
            ("b/rospack_nosubdirs", ""),
            ("b/in_b/package.xml", "in_b"),
            (".hidden/package.xml", "hidden"),
            ("c/.git/package.xml", "in_git"),
        ],
        &[("in_a", None), ("ignored", None), ("in_b", None), ("hidden", None), (".hidden", None), ("in_git", None)],
    ),
    // So is a search folder that wants no search below it.
    (&[("rospack_nosubdirs", ""), ("direct/package.xml", "direct")], &[("direct", None)]),
];

#[test]
fn packages_are_found_in_a_search_folder_as_by_rospack() {
    for (files, packages) in SEARCHES {
        let dir = tree(files);
        let index = index(&[dir.path()]);
        for (name, folder) in packages {
            assert_eq!(index.package(name), folder.map(|folder| dir.path().join(folder)), "{name} of {files:?}");
        }
    }
}

#[test]
fn the_earlier_search_folder_wins_however_deep_the_package_is_in_it() {
    let over = tree(&[("src/x/y/package.xml", "shared")]);
    let under = tree(&[("shared/package.xml", "shared"), ("only/package.xml", "only")]);
    let index = index(&[over.path(), under.path()]);
    assert_eq!(index.package("shared"), Some(over.path().join("src/x/y")));
    assert_eq!(index.package("only"), Some(under.path().join("only")));
}

#[test]
fn extra_folders_go_before_the_environments() {
    // The environment of a test process is shared, so only the order of the arguments is tested here.
    let extra = tree(&[("p/package.xml", "p")]);
    let index = PackageIndex::from_env(&[extra.path().to_owned()]);
    assert_eq!(index.package("p"), Some(extra.path().join("p")));
}

#[test]
fn search_folders_that_do_not_exist_are_skipped() {
    let dir = tree(&[("p/package.xml", "p")]);
    let index = PackageIndex::new([PathBuf::new(), dir.path().join("nowhere"), dir.path().to_owned()]);
    assert_eq!(index.package("p"), Some(dir.path().join("p")));
}

#[cfg(unix)]
#[test]
fn links_are_followed_and_rings_of_links_end() {
    let elsewhere = tree(&[("real/package.xml", "linked")]);
    let dir = tree(&[("a/b/file", "")]);
    std::os::unix::fs::symlink(elsewhere.path(), dir.path().join("a/link")).unwrap();
    std::os::unix::fs::symlink(dir.path(), dir.path().join("a/b/up")).unwrap();
    std::os::unix::fs::symlink("loop", dir.path().join("a/loop")).unwrap();
    let index = index(&[dir.path()]);
    assert_eq!(index.package("linked"), Some(dir.path().join("a/link/real")));
    assert_eq!(index.package("absent"), None);
}

#[test]
fn a_manifest_that_cannot_be_read_leaves_the_folders_name() {
    let dir = tempfile::tempdir().unwrap();
    fs::create_dir(dir.path().join("odd")).unwrap();
    fs::write(dir.path().join("odd/package.xml"), "<package><na").unwrap();
    assert_eq!(index(&[dir.path()]).package("odd"), Some(dir.path().join("odd")));
}

#[test]
fn addresses_become_paths() {
    let dir = tree(&[("share/robot/package.xml", "robot")]);
    let index = index(&[&dir.path().join("share")]);
    let robot = dir.path().join("share/robot");
    for (url, path) in [
        ("package://robot/meshes/arm.stl", robot.join("meshes/arm.stl")),
        ("package://robot/meshes/left%20arm%C3%A4.stl", robot.join("meshes/left armä.stl")),
        ("package://robot/a%2", robot.join("a%2")),
        ("package://robot//a.stl", robot.join("a.stl")),
        ("PACKAGE://robot/a.stl", robot.join("a.stl")),
        ("file:///tmp/a%20b.stl", PathBuf::from("/tmp/a b.stl")),
        ("file://localhost/tmp/a.stl", PathBuf::from("/tmp/a.stl")),
        ("file:/tmp/a.stl", PathBuf::from("/tmp/a.stl")),
        ("/tmp/100%20.stl", PathBuf::from("/tmp/100%20.stl")),
    ] {
        assert_eq!(index.resolve(url).unwrap(), path, "{url}");
    }
}

#[test]
fn a_path_does_not_leave_its_package() {
    let dir = tree(&[("share/robot/package.xml", "robot")]);
    let index = index(&[&dir.path().join("share")]);
    let robot = dir.path().join("share/robot");
    for (url, path) in [
        ("package://robot/meshes/../a.stl", robot.join("a.stl")),
        ("package://robot/./a//b/../../c.stl", robot.join("c.stl")),
        ("package://robot/..a/...stl", robot.join("..a/...stl")),
    ] {
        assert_eq!(index.resolve(url).unwrap(), path, "{url}");
    }
    for url in [
        "package://robot/../../../etc/passwd",
        "package://robot/../robot/a.stl",
        "package://robot/meshes/../../a.stl",
        "package://robot/%2e%2e/a.stl",
        "package://robot/%2E%2E%2Fa.stl",
        "package://robot//../a.stl",
    ] {
        assert!(matches!(index.resolve(url), Err(ResourceError::LeavesPackage { .. })), "{url}");
    }
    // The part that names a package is no path.
    for url in ["package://../a.stl", "package://./a.stl", "package://%2e%2e%2f/a.stl", "package://robot%00/a.stl"] {
        assert!(matches!(index.resolve(url), Err(ResourceError::NoSuchPackage { .. })), "{url}");
    }
}

#[test]
fn a_package_that_is_installed_later_is_found() {
    let dir = tree(&[("one/package.xml", "one")]);
    let index = index(&[dir.path()]);
    assert_eq!(index.package("two"), None);
    // In the folder of its name at once; elsewhere when the folder is searched again.
    fs::create_dir_all(dir.path().join("two")).unwrap();
    fs::write(dir.path().join("two/package.xml"), "<package><name>two</name></package>").unwrap();
    assert_eq!(index.package("two"), Some(dir.path().join("two")));
}

#[test]
fn bad_addresses_are_different_errors() {
    let index = PackageIndex::new([]);
    for url in ["", "mesh.stl", "package://", "package://name", "package:///x", "package:name/x", "file://host/x"] {
        assert!(matches!(index.resolve(url), Err(ResourceError::BadUrl { .. })), "{url}");
    }
    let error = index.resolve("http://example.org/a.stl").unwrap_err();
    assert!(error.to_string().contains("http:// addresses are not supported"), "{error}");
    let error = index.resolve("package://robot/a.stl").unwrap_err();
    assert!(matches!(&error, ResourceError::NoSuchPackage { package, .. } if package == "robot"));
    assert!(error.to_string().contains("ROS_PACKAGE_PATH is empty"), "{error}");
}
