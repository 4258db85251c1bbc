//! Starting the running program again with other arguments or environment variables.

use std::ffi::{OsStr, OsString};
use std::io;
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Replaces the running program by itself with these arguments, without the program's name, and these variables added
/// to its environment. The process id, the open streams and the working folder stay the same. Returns only if that
/// fails.
///
/// It is for arguments and variables that libraries read by themselves, because a program with threads must not change
/// its environment.
pub fn restart<V: AsRef<OsStr>>(arguments: impl IntoIterator<Item = OsString>, environment: &[(&str, V)]) -> io::Error {
    let program = match std::env::current_exe() {
        Ok(program) => program,
        Err(error) => return error,
    };
    let called = std::env::args_os().next().unwrap_or_default();
    #[expect(clippy::disallowed_methods, reason = "this program again, without a shell")]
    let mut command = Command::new(by_its_name(program, Path::new(&called)));
    command.arg0(called);
    command.args(arguments).envs(environment.iter().map(|(name, value)| (name, value))).exec()
}

/// The link to `program` in its folder with the name by which it was `called`, else `program`: one file may contain
/// several programs, and the process is listed under the name of the executed file.
fn by_its_name(program: PathBuf, called: &Path) -> PathBuf {
    let link = called.file_name().map(|name| program.with_file_name(name));
    match link {
        Some(link) if link.canonicalize().is_ok_and(|file| file == program) => link,
        _ => program,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_starts_itself_again_through_the_link_by_which_it_was_called() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().canonicalize().unwrap();
        let program = folder.join("all_programs");
        std::fs::write(&program, "").unwrap();
        std::fs::write(folder.join("other"), "").unwrap();
        std::os::unix::fs::symlink("all_programs", folder.join("camera_stream")).unwrap();
        let found = |called: &str| by_its_name(program.clone(), Path::new(called));
        assert_eq!(found("camera_stream"), folder.join("camera_stream"));
        assert_eq!(found("/usr/bin/camera_stream"), folder.join("camera_stream"));
        for called in ["other", "missing", ""] {
            assert_eq!(found(called), program, "{called}");
        }
    }
}
