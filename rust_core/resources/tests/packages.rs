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

#[test]
fn a_package_is_found_by_the_name_in_its_manifest() {
    let dir = tree(&[("src/deep/folder/package.xml", "robot_description")]);
    let index = index(&[dir.path()]);
    assert_eq!(index.package("robot_description"), Some(dir.path().join("src/deep/folder")));
    assert_eq!(index.package("folder"), None);
}

#[test]
fn a_folder_of_the_right_name_with_another_packages_manifest_is_not_taken() {
    let dir = tree(&[("arm/package.xml", "arm_old"), ("src/new_arm/package.xml", "arm")]);
    let index = index(&[dir.path()]);
    assert_eq!(index.package("arm"), Some(dir.path().join("src/new_arm")));
    assert_eq!(index.package("arm_old"), Some(dir.path().join("arm")));
}

#[test]
fn a_rosbuild_package_is_named_after_its_folder() {
    let dir = tree(&[("stack/legacy/manifest.xml", "ignored"), ("both/manifest.xml", ""), ("both/package.xml", "wet")]);
    let index = index(&[dir.path()]);
    assert_eq!(index.package("legacy"), Some(dir.path().join("stack/legacy")));
    assert_eq!(index.package("both"), Some(dir.path().join("both")));
    assert_eq!(index.package("wet"), None);
}

#[test]
fn packages_are_not_searched_for_packages() {
    let dir = tree(&[("a/outer/package.xml", "outer"), ("a/outer/inner/package.xml", "inner")]);
    let index = index(&[dir.path()]);
    assert!(index.package("outer").is_some());
    assert_eq!(index.package("inner"), None);
}

#[test]
fn a_search_folder_that_is_a_package_is_that_package_only() {
    let dir = tree(&[("package.xml", "me"), ("other/package.xml", "other")]);
    let index = index(&[dir.path()]);
    assert_eq!(index.package("me"), Some(dir.path().to_owned()));
    assert_eq!(index.package("other"), None);
}

#[test]
fn ignored_and_hidden_folders_are_skipped() {
    let dir = tree(&[
        ("a/CATKIN_IGNORE", ""),
        ("a/in_a/package.xml", "in_a"),
        ("ignored/CATKIN_IGNORE", ""),
        ("ignored/package.xml", "ignored"),
        ("b/rospack_nosubdirs", ""),
        ("b/in_b/package.xml", "in_b"),
        (".hidden/package.xml", "hidden"),
        ("c/.git/package.xml", "in_git"),
    ]);
    let index = index(&[dir.path()]);
    for name in ["in_a", "ignored", "in_b", "hidden", ".hidden", "in_git"] {
        assert_eq!(index.package(name), None, "{name}");
    }
}

#[test]
fn a_search_folder_without_subfolders_is_not_searched() {
    let dir = tree(&[("rospack_nosubdirs", ""), ("direct/package.xml", "direct")]);
    assert_eq!(index(&[dir.path()]).package("direct"), None);
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
