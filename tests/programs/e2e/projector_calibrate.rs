//! `projector_calibrate` as a user runs it: what it writes, what it refuses, and what it shows on a screen.

use std::fs;
use std::io::{Read as _, Write as _};
use std::path::Path;
use std::process::{Command, Output, Stdio};

use rcs_files::capture::read_patterns;
use rcs_files::projector::ProjectorFile;
use rcs_tests::programs::program;
use rcs_tests::ros::{wait_until, Running, PATIENCE};

use crate::viewers::Screen;

const ONE_DISTANCE: [&str; 8] =
    ["--size", "1280x800", "--distance", "1.2", "--projected", "0.9x0.5625", "--axis", "0.45,0.6"];

/// The program in a folder, without a display.
fn calibrate(folder: &Path) -> Command {
    let mut command = Command::new(program("projector_calibrate"));
    command.current_dir(folder);
    for variable in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
        command.env_remove(variable);
    }
    command
}

fn run(folder: &Path, args: &[&str]) -> Output {
    calibrate(folder).args(args).stdin(Stdio::null()).output().unwrap()
}

/// Exit code and the lines on standard error.
fn exit(output: &Output) -> (i32, Vec<String>) {
    let errors = String::from_utf8(output.stderr.clone()).unwrap();
    (output.status.code().unwrap(), errors.lines().map(str::to_owned).collect())
}

#[test]
fn a_measured_projector_is_a_file_that_the_projector_program_reads() {
    let folder = tempfile::tempdir().unwrap();
    let output = run(folder.path(), &[&["manual"], &ONE_DISTANCE[..]].concat());
    assert_eq!(output.status.code(), Some(0));
    let printed = String::from_utf8(output.stdout).unwrap();
    let file = ProjectorFile::parse(Path::new("printed"), &printed).unwrap();
    let info = &file.camera_info;
    let (fx, fy, cx, cy) = (1280.0 * 1.2 / 0.9, 800.0 * 1.2 / 0.5625, 1280.0 * 0.45 / 0.9, 800.0 * 0.6 / 0.5625);
    assert_eq!(info.K, [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0]);
    assert_eq!(info.P, [fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0]);
    assert_eq!(info.R, [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    assert_eq!((info.distortion_model.as_str(), info.D.as_slice()), ("plumb_bob", [0.0; 5].as_slice()));
    assert_eq!((info.width, info.height, info.header.frame_id.as_str()), (1280, 800, "proj_view"));
    assert!(file.warnings().is_empty());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);

    // Measured from 30 mm behind where the light comes from: two distances cancel that.
    let second = ["--distance2", "2.43", "--projected2", "1.8x1.125", "--axis2", "0.9,1.2", "-o", "projector.yaml"];
    let first =
        ["manual", "--size", "1280x800", "--distance", "123cm", "--projected", "0.9x0.5625", "--axis", "0.45,0.6"];
    let output = run(folder.path(), &[&first[..], &second].concat());
    assert_eq!(output.status.code(), Some(0), "{:?}", exit(&output));
    let file = ProjectorFile::read(&folder.path().join("projector.yaml")).unwrap();
    assert!((file.camera_info.K[0] - fx).abs() < 1e-6 && (file.camera_info.K[5] - cy).abs() < 1e-6);
    let checked = run(folder.path(), &["manual", "--check", "projector.yaml"]);
    assert_eq!(exit(&checked), (0, Vec::new()));
}

#[test]
fn what_is_odd_is_warned_of_and_written() {
    let folder = tempfile::tempdir().unwrap();
    let flat = ["manual", "--size", "1280x800", "--distance", "1.2", "--projected", "0.9x0.52", "--axis", "0.45,2.5"];
    let (code, errors) = exit(&run(folder.path(), &[&flat[..], &["-o", "flat.yaml"]].concat()));
    assert_eq!(code, 0);
    for expected in ["differ by 8.2 %", "cy 3846.2 is far outside of the picture (0 to 800)"] {
        assert!(errors.iter().any(|line| line.contains(expected)), "{expected}: {errors:?}");
    }
    let text = fs::read_to_string(folder.path().join("flat.yaml")).unwrap();
    assert!(text.contains("3846.15"), "it is not clamped: {text}");

    fs::write(
        folder.path().join("paper.yaml"),
        "width: 1280\nheight: 800\nK: [1900, 0, 640, 0, 1900, 817, 0, 0, 1]\n\
         P: [1900, 0, 640, 0, 0, 1900, 750, 0, 0, 0, 1, 0]\n",
    )
    .unwrap();
    let (code, errors) = exit(&run(folder.path(), &["manual", "--check", "paper.yaml"]));
    assert_eq!(code, 1);
    assert!(errors[0].contains("cy 817 and 750: up to 67 pixels, 35 mm at a metre"), "{errors:?}");
}

#[test]
fn refusals_are_1_and_unreadable_inputs_2_each_one_line_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("broken.yaml"), "width: 1280\nheight: [\n").unwrap();
    let with = |option: &str, value: &'static str| {
        let mut args = [&["manual", "-o", "out.yaml"], &ONE_DISTANCE[..]].concat();
        let at = args.iter().position(|arg| *arg == option).unwrap();
        args[at + 1] = value;
        args
    };
    let mut grown = with("--axis", "0,0");
    grown.extend(["--distance2", "2.4", "--projected2", "0.8x0.5"]);
    let cases = [
        (with("--distance", "-1"), 1, "greater than zero"),
        (with("--distance", "nan"), 1, "not a finite number"),
        (with("--projected", "0.9x0"), 1, "greater than zero"),
        (with("--axis", "inf,0"), 1, "not a finite number"),
        (grown, 1, "a picture grows with the distance"),
        (vec!["manual", "--size", "1280x800", "-o", "out.yaml"], 2, "--projected is missing"),
        (vec!["manual", "--check", "missing.yaml"], 2, "missing.yaml: No such file"),
        (vec!["manual", "--check", "broken.yaml"], 2, "line 2"),
        (vec!["patterns", "--size", "1280x800", "-o", "no/such/folder"], 1, "No such file"),
        (vec!["show", "--patterns", "missing"], 2, "missing: No such file"),
        (vec!["show", "--test", "grid"], 1, "DISPLAY"),
        (vec!["show", "-o", "missing", "--size", "64x48"], 1, "missing/"),
    ];
    for (args, expected, reason) in cases {
        let (code, errors) = exit(&run(folder.path(), &args));
        assert_eq!(code, expected, "{args:?}: {errors:?}");
        assert!(errors.len() == 1 && errors[0].starts_with("projector_calibrate: "), "{args:?}: {errors:?}");
        assert!(errors[0].contains(reason), "{args:?}: {errors:?}");
    }
    for args in [&[][..], &["manual", "--size", "wide"], &["show", "--test", "moire"], &["patterns"]] {
        assert_eq!(run(folder.path(), args).status.code(), Some(2), "{args:?}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn without_arguments_the_measures_are_asked_for_and_an_end_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let answer = |answers: &str| {
        let mut command = calibrate(folder.path());
        command.arg("manual").stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut asking = command.spawn().unwrap();
        asking.stdin.take().unwrap().write_all(answers.as_bytes()).unwrap();
        asking.wait_with_output().unwrap()
    };
    let output = answer("1280x800\n-3\n1.2\n0.9x0.5625\n");
    assert_eq!(output.status.code(), Some(1));
    assert!(exit(&output).1.last().unwrap().contains("nothing written"));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);

    let mut command = calibrate(folder.path());
    command.arg("manual").stdin(Stdio::piped()).stderr(Stdio::piped());
    let mut asking = command.spawn().unwrap();
    // Asked for the first answer, it handles signals.
    asking.stderr.as_mut().unwrap().read_exact(&mut [0]).unwrap();
    Command::new("kill").args(["-INT", &asking.id().to_string()]).status().unwrap();
    assert_eq!(asking.wait_with_output().unwrap().status.code(), Some(1));

    let output = answer("1280x800\n-3\n1.2\n0.9x0.5625\n0.45,0.6\nn\n\n");
    assert_eq!(output.status.code(), Some(0), "{:?}", exit(&output));
    let file = ProjectorFile::read(&folder.path().join("projector.yaml")).unwrap();
    assert_eq!(file.camera_info.K[0], 1280.0 * 1.2 / 0.9);
}

#[test]
fn patterns_are_written_with_their_list() {
    let folder = tempfile::tempdir().unwrap();
    for (step, count) in [("1", 44), ("4", 64)] {
        let output = run(folder.path(), &["patterns", "--size", "1280x800", "--step", step, "-o", step]);
        assert_eq!(output.status.code(), Some(0), "{:?}", exit(&output));
        let list = read_patterns(&folder.path().join(step).join("patterns.yaml")).unwrap();
        assert_eq!((list.projector_size_px, list.patterns.len()), ([1280, 800], count));
        for (path, pattern) in list.patterns {
            assert_eq!(image::open(&path).unwrap().into_luma8().into_raw(), pattern.image([1280, 800]), "{path:?}");
        }
    }
}

#[test]
fn the_screen_shows_test_images_and_patterns_pixel_for_pixel() {
    let (folder, screen) = (tempfile::tempdir().unwrap(), Screen::start());
    let path = |name: &str| folder.path().join(name);
    assert_eq!(run(folder.path(), &["show", "-o", ".", "--size", "640x360"]).status.code(), Some(0));
    assert_eq!(run(folder.path(), &["patterns", "--size", "640x360", "-o", "patterns"]).status.code(), Some(0));
    let pixels = |name: &str| image::open(path(name)).unwrap().into_rgb8().into_raw();
    let start = |args: &[&str]| {
        Running::start(calibrate(folder.path()).env("DISPLAY", &screen.display).arg("show").args(args)).unwrap()
    };
    let shows = |name: &str| wait_until(PATIENCE, || screen.pixels() == pixels(name));

    for test in ["grid", "checkerboard", "crosshair", "border", "ramp", "orientation"] {
        let mut window = start(&["--test", test, "--screenshot", "screenshot.png"]);
        assert!(shows(&format!("{test}.png")), "{test}: {:?}", window.errors());
        assert!(wait_until(PATIENCE, || path("screenshot.png").exists()), "{test}");
        assert_eq!(pixels("screenshot.png"), pixels(&format!("{test}.png")), "{test}");
        fs::remove_file(path("screenshot.png")).unwrap();
        window.signal("INT");
        assert_eq!(window.wait(PATIENCE).unwrap().code(), Some(0), "{test}: {:?}", window.errors());
    }
    // By themselves, one after the other, and then it ends.
    let stripes =
        "  - {file: p012.png, kind: gray_code, axis: x, bits: 10, bit: 5, step: 1, offset: 0, inverted: false}\n";
    let few =
        format!("projector: {{width: 640, height: 360}}\npatterns:\n  - {{file: p000.png, kind: white}}\n{stripes}");
    assert!(fs::read_to_string(path("patterns/patterns.yaml")).unwrap().contains(stripes));
    fs::write(path("patterns/few.yaml"), few).unwrap();
    let mut window = start(&["--patterns", "patterns/few.yaml", "--seconds", "4"]);
    for name in ["p000.png", "p012.png"] {
        assert!(shows(&format!("patterns/{name}")), "{name}: {:?}", window.errors());
    }
    assert_eq!(window.wait(PATIENCE).unwrap().code(), Some(0), "{:?}", window.errors());
}

#[test]
fn captures_of_other_tools_are_decoded_and_a_wrong_image_is_named() {
    let captures = Path::new(env!("CARGO_MANIFEST_DIR")).join("captures");
    let folder = tempfile::tempdir().unwrap();
    let decode =
        |capture: &Path| exit(&run(folder.path(), &["decode", capture.to_str().unwrap(), "--pixels", "pixels.csv"]));
    let (code, errors) = decode(&captures.join("gsoup"));
    assert!(code == 0 && errors.iter().any(|line| line.contains("overexposed")), "{errors:?}");
    assert_eq!(decode(&captures.join("kamino")).0, 0);

    fs::remove_file(folder.path().join("pixels.csv")).unwrap();
    for file in fs::read_dir(captures.join("kamino")).unwrap() {
        let file = file.unwrap();
        fs::copy(file.path(), folder.path().join(file.file_name())).unwrap();
    }
    fs::copy(folder.path().join("c14.png"), folder.path().join("c15.png")).unwrap();
    let (code, errors) = decode(folder.path());
    assert_eq!((code, errors.len()), (1, 1), "{errors:?}");
    assert!(errors[0].contains("c14.png and c15.png are not each other's inverse"), "{errors:?}");
    assert!(!folder.path().join("pixels.csv").exists());
}
