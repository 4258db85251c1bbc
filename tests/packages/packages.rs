//! The packages that `./release` makes, from programs that stand in for the built ones: what is in them, where, and
//! that the same input gives the same bytes. `tests/packages/run` installs the real ones in roots of Debian.

use std::fs;
use std::os::unix::fs::{symlink, PermissionsExt as _};
use std::path::{Path, PathBuf};

use rcs_tests::programs::{program, repository};

use crate::catkin::PROGRAMS;
use crate::launch::from_source;
use crate::{bash, printed_by, processors, succeed};

const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Where a program's man page and completions are below /usr/share.
const HELP_FILES: [[&str; 2]; 4] = [
    ["man/man1", "NAME.1.gz"],
    ["bash-completion/completions", "NAME"],
    ["zsh/vendor-completions", "_NAME"],
    ["fish/vendor_completions.d", "NAME.fish"],
];

/// A folder as `scripts/packages/build_programs` leaves it, with a script in place of the programs.
fn stand_in(version: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let (programs, share) =
        (folder.path().join("lib/rviz_camera_stream"), folder.path().join("share/rviz_camera_stream"));
    fs::create_dir_all(&programs).unwrap();
    fs::create_dir_all(&share).unwrap();
    let all = programs.join("all_programs");
    fs::write(&all, "#!/bin/sh\nbasename \"$0\"\n").unwrap();
    fs::set_permissions(&all, fs::Permissions::from_mode(0o755)).unwrap();
    for name in PROGRAMS {
        symlink("all_programs", programs.join(name)).unwrap();
    }
    fs::write(programs.join("librcs_capi.tar.xz"), "").unwrap();
    fs::write(share.join("prebuilt"), format!("{version}\n")).unwrap();
    succeed(&format!("{} --write-help {}/share", program("all_programs").display(), folder.path().display()));
    folder
}

fn make(built: &Path, output: &Path, only: &str) {
    let _processors = processors();
    succeed(&format!(
        "SOURCE_DATE_EPOCH=1763900000 scripts/packages/make_packages --built {} --architecture amd64 --output {} {only}",
        built.display(),
        output.display()
    ));
}

/// The paths of a package, without those of folders.
fn paths(package: &Path) -> Vec<String> {
    let listed = succeed(&format!("dpkg-deb --fsys-tarfile {} | tar -t", package.display()));
    listed.lines().filter(|path| !path.ends_with('/')).map(|path| path.trim_start_matches('.').to_owned()).collect()
}

/// The pages and images to which the README links.
fn linked_by_the_readme() -> Vec<String> {
    let readme = fs::read_to_string(repository().join("README.md")).unwrap();
    let targets = readme.split("](").skip(1).filter_map(|rest| rest.split([')', '#']).next());
    let pages = targets.filter(|target| target.starts_with("docs/") || (!target.contains('/') && !target.is_empty()));
    let pages: Vec<String> = pages.map(str::to_owned).collect();
    assert!(pages.len() > 10, "{pages:?}");
    pages
}

#[test]
fn packages_hold_all_that_is_installed_where_their_distribution_has_it() {
    let (built, output) = (stand_in(VERSION), tempfile::tempdir().unwrap());
    for (name, prefix, dependency, python) in [
        ("ros-melodic-rviz-camera-stream", "/opt/ros/melodic", "ros-melodic-roslaunch", "#!/usr/bin/python2"),
        ("ros-noetic-rviz-camera-stream", "/opt/ros/noetic", "ros-noetic-roslaunch", "#!/usr/bin/python3"),
        ("ros-one-rviz-camera-stream", "/opt/ros/one", "ros-one-roslaunch", "#!/usr/bin/python3"),
        ("ros-rviz-camera-stream", "/usr", "python3-roslaunch", "#!/usr/bin/python3"),
    ] {
        make(built.path(), output.path(), &format!("--only {name}"));
        let package = output.path().join(format!("{name}_{VERSION}-1_amd64.deb"));
        let paths = paths(&package);
        let has = |path: &str| assert!(paths.iter().any(|found| found == path), "{name}: no {path} in {paths:#?}");
        for program in PROGRAMS.iter().chain(&[
            "all_programs",
            "librcs_capi.tar.xz",
            "paper_scene",
            "simulated_turret",
            "image_view_overlay",
        ]) {
            has(&format!("{prefix}/lib/rviz_camera_stream/{program}"));
        }
        for folder in ["launch", "launch/viewers", "rviz", "config", "config/demo", "config/robot", "urdf"] {
            for entry in fs::read_dir(repository().join("ros_pkg").join(folder)).unwrap() {
                let entry = entry.unwrap();
                if entry.file_type().unwrap().is_file() {
                    has(&format!("{prefix}/share/rviz_camera_stream/{folder}/{}", entry.file_name().to_string_lossy()));
                }
            }
        }
        for file in ["package.xml", "prebuilt"] {
            has(&format!("{prefix}/share/rviz_camera_stream/{file}"));
        }
        let documents = format!("/usr/share/doc/{name}");
        for file in ["copyright", "changelog.Debian.gz", "third_party_licences.txt.gz", "README.md"] {
            has(&format!("{documents}/{file}"));
        }
        for page in linked_by_the_readme() {
            has(&format!("{documents}/{page}"));
        }
        let help = HELP_FILES.map(|[place, page]| [format!("/usr/share/{place}/"), page.to_owned()]);
        for [place, page] in &help {
            for program in PROGRAMS {
                has(&format!("{place}{}", page.replace("NAME", program)));
            }
        }
        has("/usr/share/man/man1/camera_stream-render.1.gz");
        let elsewhere = |path: &&String| {
            let lintian = format!("/usr/share/lintian/overrides/{name}");
            let is_ros = path.starts_with(&format!("{prefix}/lib/")) || path.starts_with(&format!("{prefix}/share/"));
            let is_hook =
                **path == format!("{prefix}/etc/catkin/profile.d/50.rviz_camera_stream.bash") && prefix != "/usr";
            let is_help = is_hook || help.iter().any(|[place, _]| path.starts_with(place));
            !(is_ros || is_help || path.starts_with(&format!("{documents}/")) || **path == lintian)
        };
        assert_eq!(paths.iter().find(elsewhere), None, "{name}");
        let field = |field: &str| succeed(&format!("dpkg-deb --field {} {field}", package.display()));
        let depends = field("Depends");
        assert!(depends.contains("libc6 (>= 2.27)") && depends.contains(dependency), "{depends}");
        assert!(field("Installed-Size").trim().parse::<u32>().unwrap() > 100);
        let scene = format!(
            "dpkg-deb --fsys-tarfile {} | tar -xO .{prefix}/lib/rviz_camera_stream/paper_scene | head -n 1",
            package.display()
        );
        assert_eq!(bash(&format!("set +o pipefail; {scene}")).stdout.trim_ascii(), python.as_bytes());
    }
}

#[test]
fn the_same_programs_give_the_same_packages() {
    let outputs = [0, 1].map(|_| {
        let (built, output) = (stand_in(VERSION), tempfile::tempdir().unwrap());
        make(built.path(), output.path(), "--only ros-noetic-rviz-camera-stream --only tarball");
        output
    });
    let files = |folder: &Path| {
        let mut files: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
        files.sort();
        files
            .into_iter()
            .map(|path| (path.file_name().unwrap().to_owned(), fs::read(path).unwrap()))
            .collect::<Vec<_>>()
    };
    let made = files(outputs[0].path());
    assert_eq!(made.len(), 2);
    assert!(made == files(outputs[1].path()), "the files of two runs differ");
}

#[test]
fn programs_that_need_newer_or_other_libraries_are_refused() {
    // Built for this machine, whose glibc is newer than Ubuntu 18.04's, and with its symbols.
    let output = bash(&format!("scripts/packages/check_programs {}", program("camera_stream").display()));
    let printed = printed_by(&output);
    assert_eq!(output.status.code(), Some(1), "{printed}");
    assert!(printed.contains("needs the library libgcc_s.so.1") && printed.contains("is not stripped"), "{printed}");
}

/// The output of cmake and make for the catkin package, where there is no Rust.
fn build_without_rust(folder: &Path, arguments: &str) -> std::process::Output {
    bash(&format!(
        "mkdir -p {0}/build {0}/bin && cd {0}/build
         for program in /usr/bin/*; do
           case $program in */cargo* | */rust*) ;; *) ln -sfn $program {0}/bin/ ;; esac
         done
         export HOME={0} PATH={0}/bin; unset CARGO_HOME
         cmake {1} {arguments} -DRVIZ_CAMERA_STREAM_PLUGIN=OFF -DCMAKE_INSTALL_PREFIX={0}/prefix && make && make install",
        folder.display(),
        repository().join("ros_pkg").display()
    ))
}

#[test]
fn cmake_takes_installed_programs_where_there_is_no_rust() {
    let built = stand_in(VERSION);
    // Named, and found by itself on the path of a sourced ROS.
    for argument in ["-DRVIZ_CAMERA_STREAM_PREBUILT=", "-DCMAKE_PREFIX_PATH=/usr;"] {
        let folder = tempfile::tempdir().unwrap();
        let argument = format!("'{argument}{}'", built.path().display());
        let output = build_without_rust(folder.path(), &argument);
        assert!(output.status.success(), "{}", printed_by(&output));
        for place in ["build/devel", "prefix"] {
            let programs = folder.path().join(place).join("lib/rviz_camera_stream");
            let printed = succeed(&format!("{}/turret_aim", programs.display()));
            assert_eq!(printed.trim(), "turret_aim", "{place}");
        }
    }
}

#[test]
fn cmake_takes_no_programs_of_another_version() {
    let (built, folder) = (stand_in("0.9.0"), tempfile::tempdir().unwrap());
    let output =
        build_without_rust(folder.path(), &format!("-DRVIZ_CAMERA_STREAM_PREBUILT={}", built.path().display()));
    let words = printed_by(&output).split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(!output.status.success());
    assert!(words.contains(&format!("is 0.9.0, this source is {VERSION}")), "{words}");
    let nowhere = build_without_rust(folder.path(), "-DRVIZ_CAMERA_STREAM_PREBUILT=/nowhere");
    let words = printed_by(&nowhere).split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words.contains("no rviz_camera_stream is installed in /nowhere"), "{words}");
}

#[test]
fn catkin_lint_finds_nothing() {
    // Without the path, on which it would look through all of /usr; with the dependencies of the plugin that is
    // exported.
    let lint = "env -u CMAKE_PREFIX_PATH RVIZ_CAMERA_STREAM_PLUGIN=ON catkin_lint --offline -W1 --strict ros_pkg";
    let output = bash(&format!("command -v catkin_lint >/dev/null || exit 77; {lint}"));
    if output.status.code() == Some(77) {
        println!("skipped: catkin_lint is not installed");
        return;
    }
    assert!(output.status.success(), "{}", printed_by(&output));
}

#[test]
fn the_systemd_unit_names_arguments_that_there_are() {
    let launch = fs::read_to_string(repository().join("launch/projection.launch")).unwrap();
    let unit = fs::read_to_string(repository().join("config/robot/projection.service")).unwrap();
    let line = unit.replace("\\\n", " ").lines().find(|line| line.contains("exec roslaunch")).unwrap().to_owned();
    let arguments: Vec<&str> =
        line.split_whitespace().filter_map(|word| word.split_once(":=").map(|(name, _)| name)).collect();
    assert!(arguments.contains(&"respawn"), "{arguments:?}");
    for argument in arguments {
        assert!(launch.contains(&format!("<arg name=\"{argument}\"")), "projection.launch has no {argument}");
    }
    // Where systemd is installed, it reads the unit.
    let unit = "command -v systemd-analyze >/dev/null || exit 0; systemd-analyze verify --man=no ./config/robot/projection.service 2>&1";
    let printed = printed_by(&bash(unit));
    assert!(!printed.contains("Unknown") && !printed.contains("Failed to parse"), "{printed}");
}

#[test]
fn a_program_that_ends_is_started_again_where_that_is_asked() {
    let printed = succeed(&format!(
        "{}
python3 - <<'EOF'
import roslaunch.config, roslaunch.xmlloader
config = roslaunch.config.ROSLaunchConfig()
loader = roslaunch.xmlloader.XmlLoader()
loader.load('launch/projection.launch', config, argv=['respawn:=true'], verbose=False)
print(sorted((node.name, node.respawn) for node in config.nodes))
EOF",
        from_source()
    ));
    for name in ["camera_stream", "projector", "projector_window", "clusters"] {
        assert!(printed.contains(&format!("('{name}', True)")), "{name}: {printed}");
    }
}
