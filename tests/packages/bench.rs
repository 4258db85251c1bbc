//! The command `./bench`, without measuring: its arguments, and the programs that it would measure.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use crate::{bash, printed_by, succeed};

#[test]
fn unusable_arguments_are_refused_and_nothing_is_installed() {
    for (arguments, word) in [
        ("--nope", "unrecognized arguments: --nope"),
        ("--only colours", "there is no colours"),
        ("--seconds 0", "0 is not a positive number"),
    ] {
        let output = bash(&format!("./bench {arguments}"));
        assert_eq!(output.status.code(), Some(2), "{arguments}: {}", printed_by(&output));
        assert!(output.stdout.is_empty() && printed_by(&output).contains(word), "{}", printed_by(&output));
    }
}

/// A package with nothing but its description.
fn write_package(folder: &Path, name: &str, rest: &str) {
    let head = format!("<name>{name}</name><version>1.0.0</version><description>{name}</description>");
    let people = "<maintainer email=\"nobody@example.org\">nobody</maintainer><license>BSD</license>";
    fs::create_dir_all(folder.join(name)).unwrap();
    let file = folder.join(name).join("package.xml");
    fs::write(file, format!("<package format=\"2\">{head}{people}{rest}</package>")).unwrap();
}

#[test]
fn the_plugin_of_a_sourced_workspace_is_found() {
    let folder = tempfile::tempdir().unwrap();
    // Stands for rviz where that is not installed.
    write_package(folder.path(), "rviz", "");
    fs::copy("/bin/true", folder.path().join("rviz/rviz")).unwrap();
    let rest = r#"<depend>rviz</depend><export><rviz plugin="${prefix}/plugin.xml"/></export>"#;
    write_package(folder.path(), "camera_plugin", rest);
    let plugin = r#"<library path="lib/camera"><class name="rviz_camera_stream/CameraPub" type="Camera"/></library>"#;
    fs::write(folder.path().join("camera_plugin/plugin.xml"), plugin).unwrap();

    let workspace = folder.path().display();
    let sourced =
        format!("ROS_PACKAGE_PATH={workspace}${{ROS_PACKAGE_PATH:+:$ROS_PACKAGE_PATH}} PATH=$PATH:{workspace}/rviz");
    assert_eq!(succeed(&format!("{sourced} ./bench --list --renderers cpu")), "camera_stream, cpu\nrviz\n");
}

/// Output of a Python script that imports the bench's modules.
fn python(script: &str) -> String {
    succeed(&format!("python3 -B - <<'END'\nimport sys\nsys.path.insert(0, 'tests')\n{script}\nEND"))
}

#[test]
fn rviz_draws_on_the_gpu_if_opengl_says_that_it_can() {
    let command = |devices: &str, text: &str| {
        let folder = tempfile::tempdir().unwrap();
        let (rviz, folder) = (folder.path().join("rviz"), folder.path().display());
        fs::write(&rviz, format!("#!/bin/bash\n{text}\necho \"GL_RENDERER = $name\"\nexec sleep 60\n")).unwrap();
        fs::set_permissions(&rviz, fs::Permissions::from_mode(0o755)).unwrap();
        python(&format!(
            "from bench import drivers\n\
             drivers.NVIDIA_DEVICES = '{devices}'\n\
             command, name = drivers.rviz_on_gpu(['{folder}/rviz'], '{folder}')\n\
             print(command[:-1], name)"
        ))
    };
    let nvidia = "['env', '__GLX_VENDOR_LIBRARY_NAME=nvidia']";
    let asks_nvidia = "name='llvmpipe (LLVM 15)'; [[ ${__GLX_VENDOR_LIBRARY_NAME:-} != nvidia ]] || name='NVIDIA H200'";
    let asks_nobody = "name='llvmpipe (LLVM 15)'";
    assert_eq!(command("/dev/null", asks_nvidia), format!("{nvidia} NVIDIA H200\n"));
    assert_eq!(command("/dev/null", "name='AMD Radeon Graphics'"), "[] AMD Radeon Graphics\n");
    assert_eq!(command("/dev/null", asks_nobody), "[] llvmpipe (LLVM 15)\n", "NVIDIA's driver does not work");
    assert_eq!(command("/nowhere/nvidia*", asks_nvidia), "[] llvmpipe (LLVM 15)\n", "there is no NVIDIA");
    assert_eq!(command("/dev/null", "exit 1"), "[] None\n");
}

#[test]
fn a_table_says_which_driver_drew() {
    let notes = |gpu: &str, opengl: &str, rviz: &str| {
        python(&format!(
            "from types import SimpleNamespace\n\
             from bench import page\n\
             from bench.drivers import Drivers\n\
             given = SimpleNamespace(drivers=Drivers({gpu}, {opengl}))\n\
             rows = [dict(name=name) for name in ('camera_stream, cpu', 'camera_stream, gpu', '{rviz}')]\n\
             print(page.driver_note(given, rows))\n\
             print(len(page.without_software_gpu(given, dict(rows=rows))['rows']))\n\
             print(page.machine(given).endswith('H200'))"
        ))
    };
    let (h200, llvmpipe) = ("'NVIDIA H200'", "'llvmpipe (LLVM 15)'");
    assert_eq!(notes(h200, h200, "rviz, gpu"), "rviz, gpu drew with NVIDIA H200.\n3\nTrue\n");
    let on_cpu = "rviz drew on the CPU, with llvmpipe (LLVM 15): its display offered no other OpenGL.\n3\nTrue\n";
    assert_eq!(notes(h200, llvmpipe, "rviz"), on_cpu);
    let without = "This machine has no GPU: rviz ran on a software driver.\n2\nFalse\n";
    assert_eq!(notes(llvmpipe, llvmpipe, "rviz"), without);
    assert_eq!(notes("None", llvmpipe, "rviz"), without);
}
