//! What a user gets and runs: the catkin package, the launch files and configs, and the commands `./demo`, `./test` and
//! `./bench`.
#![allow(clippy::unwrap_used, reason = "a test whose set-up fails has failed")]

mod bench;
mod catkin;
mod demo;
mod environment;
mod files;
mod launch;
mod options;
mod packages;
mod published;
mod setup;
mod test_command;
mod tutorials;

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};

use rcs_tests::programs::{program, repository};

/// Held by a test that compiles a workspace or packs packages, and by a demo, whose depth camera may not be late for
/// half a second: the picture would be dark, as it should.
static PROCESSORS: Mutex<()> = Mutex::new(());

/// Waits for the other tests that need the processors; one that failed hinders nobody.
fn processors() -> MutexGuard<'static, ()> {
    PROCESSORS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A bash script in the repository's folder and in the environment of the project's scripts, run to its end.
fn bash(script: &str) -> Output {
    bash_command(script).output().unwrap()
}

fn bash_command(script: &str) -> Command {
    let mut command = Command::new("bash");
    command
        .args(["-euo", "pipefail", "-c", &format!("source scripts/environment\n{script}")])
        .current_dir(repository())
        .env("LC_ALL", "C.UTF-8")
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .stdin(Stdio::null());
    // The variables that cargo sets for the test must not reach the cargo that the script calls; those that say how to
    // compile must, or it compiles everything again.
    for (name, _) in std::env::vars_os() {
        let is_kept =
            |name: &str| ["CARGO_HOME", "CARGO_INCREMENTAL"].contains(&name) || name.starts_with("CARGO_PROFILE_");
        if name.to_str().is_some_and(|name| name.starts_with("CARGO_") && !is_kept(name)) {
            command.env_remove(name);
        }
    }
    command.env("CARGO_TARGET_DIR", target());
    command
}

/// Standard output of a script that must succeed.
fn succeed(script: &str) -> String {
    let output = bash(script);
    assert!(output.status.success(), "{script}\n{}", printed_by(&output));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// All that a program printed, on both outputs.
fn printed_by(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

/// Cargo's build folder, in which the running test lies.
fn target() -> std::path::PathBuf {
    program("camera_stream").ancestors().nth(2).map(Path::to_path_buf).unwrap()
}
