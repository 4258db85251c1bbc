//! The interface from C: `tests/c` is compiled with gcc's address and undefined behaviour sanitizers, linked to the
//! static library, and run. A leak, a byte too many, or a wrong result ends it with a message.
//!
//! The sanitizers are gcc's (libasan, libubsan), which `scripts/install_dependencies` installs with the compiler.

#![expect(clippy::expect_used, reason = "what fails is the test")]

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const WARNINGS: [&str; 5] = ["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"];

/// Libraries of Rust's standard library, as in the header.
const SYSTEM_LIBRARIES: [&str; 7] = ["-lgcc_s", "-lutil", "-lrt", "-lpthread", "-lm", "-ldl", "-lc"];

fn crate_folder() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn includes() -> PathBuf {
    crate_folder().join("../../ros_pkg/include")
}

/// The static library that cargo has built together with this test, by the newest of its name beside it.
fn static_library() -> PathBuf {
    let program = std::env::current_exe().expect("a test has a path");
    let folder = program.parent().expect("it is in a folder");
    let entries = fs::read_dir(folder).expect("the folder can be read").filter_map(Result::ok);
    let is_library = |path: &PathBuf| {
        let name = path.file_name().and_then(OsStr::to_str).unwrap_or_default();
        name.starts_with("librcs_capi") && name.ends_with(".a")
    };
    let libraries = entries.map(|entry| entry.path()).filter(is_library);
    let newest = libraries.max_by_key(|path| fs::metadata(path).and_then(|data| data.modified()).ok());
    newest.unwrap_or_else(|| panic!("no librcs_capi*.a in {}", folder.display()))
}

fn run(command: &mut Command) -> Output {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let text = [&output.stdout[..], &output.stderr].map(String::from_utf8_lossy).concat();
    assert!(output.status.success(), "{command:?}: {}\n{text}", output.status);
    output
}

fn c_files() -> Vec<PathBuf> {
    let entries = fs::read_dir(crate_folder().join("tests/c")).expect("the C files are there");
    let paths = entries.filter_map(|entry| entry.ok().map(|entry| entry.path()));
    paths.filter(|path| path.extension() == Some(OsStr::new("c"))).collect()
}

#[test]
fn every_function_does_from_c_what_it_promises_under_sanitizers() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let program = folder.path().join("interface");
    let mut compiler = Command::new("gcc");
    compiler
        .args(["-std=c11", "-D_GNU_SOURCE", "-g", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"])
        .args(WARNINGS)
        .arg("-I")
        .arg(includes())
        .args(c_files())
        .arg(static_library())
        .args(SYSTEM_LIBRARIES)
        .arg("-o")
        .arg(&program);
    run(&mut compiler);
    let output = run(Command::new(&program).env("ASAN_OPTIONS", "detect_leaks=1:detect_stack_use_after_return=1"));
    let text = String::from_utf8_lossy(&output.stdout);
    assert_eq!(text.trim(), format!("all passed with version {}", env!("CARGO_PKG_VERSION")));
}

#[test]
fn every_function_of_the_header_is_called_from_c() {
    let header = fs::read_to_string(includes().join("rviz_camera_stream/core.h")).expect("the header is there");
    let is_part = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
    let sources: String = c_files().iter().filter_map(|path| fs::read_to_string(path).ok()).collect();
    let code = header.lines().filter(|line| !line.trim_start().starts_with('*'));
    let mut functions: Vec<&str> = code
        .flat_map(|line| line.match_indices("rcs_").map(|(at, _)| &line[at..]).collect::<Vec<_>>())
        .filter_map(|rest| {
            rest.find(|letter| !is_part(letter)).filter(|end| rest[*end..].starts_with('(')).map(|end| &rest[..end])
        })
        .collect();
    functions.dedup();
    assert!(functions.len() > 15, "{functions:?}");
    for function in functions {
        assert!(sources.contains(&format!("{function}(")), "no C test calls {function}");
    }
}

#[test]
fn the_header_is_plain_cpp_too() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let source = folder.path().join("header.cpp");
    let program = folder.path().join("header");
    let text = "#include \"rviz_camera_stream/core.h\"\n\
                int main() { return rcs_encoding_bytes_per_pixel(RCS_ENCODING_RGB8) == 3 ? 0 : 1; }\n";
    fs::write(&source, text).expect("the source can be written");
    let mut compiler = Command::new("g++");
    compiler.arg("-std=c++11").args(WARNINGS).arg("-I").arg(includes()).arg(&source).arg(static_library());
    run(compiler.args(SYSTEM_LIBRARIES).arg("-o").arg(&program));
    run(&mut Command::new(&program));
}
