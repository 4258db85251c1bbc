//! The options of all scripts: an unknown one is refused at once, before anything is installed, built or written.

use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use rcs_tests::programs::repository;

use crate::{bash, printed_by};

/// Scripts that take no options of their own, and why.
const WITHOUT_OPTIONS: [(&str, &str); 11] = [
    ("ros_pkg/nodes/image_view_anywhere", "passes them on to image_view"),
    ("ros_pkg/nodes/rviz_if_installed", "passes them on to rviz"),
    ("scripts/master_port.py", "takes no arguments"),
    ("tests/packages/container", "tests/packages/run calls it"),
    ("tests/packages/first_day", "tests/packages/run calls it"),
    ("tests/packages/imitate_ros", "tests/packages/run calls it"),
    ("tests/packages/in_root", "tests/packages/run calls it"),
    ("tests/packages/laptop", "tests/packages/run calls it"),
    ("tests/packages/plugin_in_root", "tests/packages/run calls it"),
    ("tests/packages/repository", "tests/packages/run calls it"),
    ("tests/packages/save_picture", "tests/packages/run calls it"),
];

/// What installs, downloads or builds.
const INSTALLERS: [&str; 14] = [
    "apt",
    "apt-get",
    "cargo",
    "cmake",
    "curl",
    "debootstrap",
    "dpkg",
    "git",
    "make",
    "pip",
    "pip3",
    "rustup",
    "sudo",
    "wget",
];

/// The repository's scripts, by their paths in it.
pub(crate) fn scripts(folder: &Path) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let (path, name) = (entry.path(), entry.file_name().into_string().unwrap());
        let kind = entry.file_type().unwrap();
        if kind.is_dir() {
            if name == ".ci" || !name.starts_with('.') && !["target", "test_output"].contains(&&*name) {
                found.extend(scripts(&path));
            }
        } else if kind.is_file()
            && entry.metadata().unwrap().permissions().mode() & 0o100 != 0
            && fs::read(&path).unwrap().starts_with(b"#!")
        {
            found.insert(path.strip_prefix(repository()).unwrap().display().to_string());
        }
    }
    found
}

/// Stand-ins for all [`INSTALLERS`], which note in a file that they were called, and fail.
fn stand_ins(folder: &Path) -> PathBuf {
    let called = folder.join("called");
    let programs = folder.join("bin");
    fs::create_dir(&programs).unwrap();
    for name in INSTALLERS {
        let program = programs.join(name);
        fs::write(&program, format!("#!/bin/sh\necho \"$0 $*\" >>'{}'\nexit 1\n", called.display())).unwrap();
        fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
    }
    called
}

#[test]
fn an_unknown_option_of_any_script_is_refused_before_anything_is_installed_built_or_written() {
    let folder = tempfile::tempdir().unwrap();
    let called = stand_ins(folder.path());
    let work = folder.path().join("work");
    fs::create_dir(&work).unwrap();
    let run = |script: &str, arguments: &str| {
        let (bin, root, place) = (folder.path().display(), repository(), work.display());
        // scripts/environment puts the folder of cargo's programs before all others.
        bash(&format!("cd {place}; CARGO_HOME={bin} PATH={bin}/bin:$PATH {}/{script} {arguments}", root.display()))
    };
    // What notes the calls works: this script looks for a compiler and tries to install it.
    let skipped = run("scripts/miri", "no_such_test");
    assert_eq!(skipped.status.code(), Some(77), "{}", printed_by(&skipped));
    let calls = fs::read_to_string(&called).unwrap();
    assert!(calls.contains("/cargo ") && calls.contains("/rustup "), "{calls}");
    fs::remove_file(&called).unwrap();

    let all = scripts(&repository());
    let without: BTreeSet<String> = WITHOUT_OPTIONS.iter().map(|(script, _)| (*script).to_owned()).collect();
    assert!(without.is_subset(&all), "{:?}", without.difference(&all));
    assert!(["bench", "tests/rviz/compare_live", ".ci/run"].iter().all(|script| all.contains(*script)), "{all:?}");
    let mut wrong = Vec::new();
    for script in all.difference(&without) {
        let output = run(script, "--nope");
        if output.status.code() != Some(2) || !output.stdout.is_empty() || output.stderr.is_empty() {
            wrong.push(format!("{script}: {}, {}", output.status, printed_by(&output)));
        }
        if let Ok(calls) = fs::read_to_string(&called) {
            wrong.push(format!("{script} has called {calls}"));
            fs::remove_file(&called).unwrap();
        }
        let written: Vec<_> = fs::read_dir(&work).unwrap().map(|entry| entry.unwrap().path()).collect();
        assert!(written.is_empty(), "{script} has written {written:?}");
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
