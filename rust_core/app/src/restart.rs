//! Starts the program again in the same process, where arguments or environment have to be others from the beginning:
//! libraries read both by themselves, and a running program with threads must not change its environment.

use std::ffi::{OsStr, OsString};
use std::io;
use std::os::unix::process::CommandExt;
use std::process::Command;

/// Replaces the running program by itself with these arguments (the program's name is not among them) and these
/// variables added to its environment. The process id, the open streams and the working folder stay the same. Returns
/// only if that fails.
pub(crate) fn restart(arguments: impl IntoIterator<Item = OsString>, environment: &[(&str, &OsStr)]) -> io::Error {
    match std::env::current_exe() {
        Ok(program) => Command::new(program).args(arguments).envs(environment.iter().copied()).exec(),
        Err(error) => error,
    }
}
