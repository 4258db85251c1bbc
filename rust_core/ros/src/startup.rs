//! What has to happen before the process has threads: its own master for rosrust, and starting again.
//!
//! rosrust reads the master's address and its host's name from the process's arguments and environment. It is to take
//! [`crate::rosrust_master`] for the master, so both are changed; and because libraries read the environment on any
//! thread, that is done once, first thing in `main`.

use std::ffi::{OsStr, OsString};
use std::io;
use std::net::{Ipv4Addr, TcpListener};
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, OnceLock};

use rcs_scene::lock;

const MASTER_VARIABLE: &str = "ROS_MASTER_URI";
const HOST_VARIABLE: &str = "ROS_HOSTNAME";
const IP_VARIABLE: &str = "ROS_IP";

/// ROS's arguments that override a variable.
const OVERRIDES: [(&str, &str); 3] =
    [("__master:=", MASTER_VARIABLE), ("__hostname:=", HOST_VARIABLE), ("__ip:=", IP_VARIABLE)];

/// What the process was started with.
pub(crate) struct Startup {
    /// The real master's address.
    pub(crate) master_uri: String,
    /// The host under which others reach this node.
    pub(crate) host: String,
    /// Whether the user named it.
    pub(crate) is_host_chosen: bool,
    /// The port of what rosrust takes for the master, until that is started.
    rosrust_listener: Mutex<Option<TcpListener>>,
    /// The variables that were changed, as they were.
    before: [(&'static str, Option<OsString>); 3],
}

static STARTUP: OnceLock<Startup> = OnceLock::new();

/// Prepares the process for a [`RosNode`](crate::RosNode). To be called before any thread is started: it changes the
/// environment, and starts the program again where ROS's arguments `__master:=`, `__hostname:=` or `__ip:=` are given,
/// which count for more than the environment. Does nothing the second time.
///
/// # Errors
/// The system's, where there is no port left or the program cannot be started again.
pub fn init() -> io::Result<()> {
    if STARTUP.get().is_some() {
        return Ok(());
    }
    if let Some((arguments, environment)) = without_overrides(std::env::args_os().skip(1)) {
        return Err(restart(arguments, &environment));
    }
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
    let uri = format!("http://127.0.0.1:{}/", listener.local_addr()?.port());
    let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    let before = [MASTER_VARIABLE, HOST_VARIABLE, IP_VARIABLE].map(|name| (name, std::env::var_os(name)));
    // One that is set to nothing, as container tools do, counts as not set.
    for name in [HOST_VARIABLE, IP_VARIABLE].into_iter().filter(|name| !is_set(name)) {
        std::env::remove_var(name);
    }
    let startup = Startup {
        master_uri: rosrust::api::resolve::master(),
        host: rosrust::api::resolve::hostname(),
        is_host_chosen: is_set(HOST_VARIABLE) || is_set(IP_VARIABLE),
        rosrust_listener: Mutex::new(Some(listener)),
        before,
    };
    std::env::set_var(MASTER_VARIABLE, uri);
    // rosrust's own API is nobody's business but this process's.
    std::env::set_var(HOST_VARIABLE, "localhost");
    // Set only here, and only once.
    let _ = STARTUP.set(startup);
    Ok(())
}

/// What [`init`] found.
pub(crate) fn startup() -> Option<&'static Startup> {
    STARTUP.get()
}

impl Startup {
    /// The port on which rosrust expects the master; there is one for one node.
    pub(crate) fn take_rosrust_listener(&self) -> Option<TcpListener> {
        lock(&self.rosrust_listener).take()
    }
}

type Environment = Vec<(&'static str, OsString)>;

/// The arguments without those that override variables, and the variables that they set; `None` if there are none.
fn without_overrides(arguments: impl Iterator<Item = OsString>) -> Option<(Vec<OsString>, Environment)> {
    let mut environment = Environment::new();
    let mut others = Vec::new();
    for argument in arguments {
        let text = argument.to_string_lossy();
        let found = OVERRIDES.iter().find_map(|(prefix, name)| Some((*name, text.strip_prefix(prefix)?.into())));
        match found {
            Some(variable) => environment.push(variable),
            None => others.push(argument),
        }
    }
    // A host's name counts for more than an address, whichever way they are given.
    let has_host = environment.iter().any(|(name, _)| *name == HOST_VARIABLE);
    if let Some((_, ip)) = environment.iter().find(|(name, _)| *name == IP_VARIABLE && !has_host).cloned() {
        environment.push((HOST_VARIABLE, ip));
    }
    (!environment.is_empty()).then_some((others, environment))
}

/// Replaces the running program by itself with these arguments (the program's name is not among them) and these
/// variables added to the environment that it was started with. The process id, the open streams and the working folder
/// stay the same. Returns only if that fails.
///
/// For arguments and variables that have to be others from the beginning: libraries read both by themselves, and a
/// running program with threads must not change its environment.
pub fn restart<V: AsRef<OsStr>>(
    arguments: impl IntoIterator<Item = OsString>,
    environment: &[(&'static str, V)],
) -> io::Error {
    let program = match std::env::current_exe() {
        Ok(program) => program,
        Err(error) => return error,
    };
    let called = std::env::args_os().next().unwrap_or_default();
    let mut command = Command::new(by_its_name(program, Path::new(&called)));
    command.arg0(called);
    for (name, value) in startup().map(|startup| startup.before.as_slice()).unwrap_or_default() {
        match value {
            Some(value) => command.env(name, value),
            None => command.env_remove(name),
        };
    }
    command.args(arguments).envs(environment.iter().map(|(name, value)| (name, value))).exec()
}

/// The link to `program` in its folder that has the name by which it was `called`, else `program`: one file may hold
/// several programs, and the process is listed under the name of what is executed.
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

    fn parts(arguments: &[&str]) -> Option<(Vec<String>, Vec<String>)> {
        let (others, environment) = without_overrides(arguments.iter().map(OsString::from))?;
        let text = |text: OsString| text.into_string().unwrap();
        let environment = environment.into_iter().map(|(name, value)| format!("{name}={}", text(value)));
        Some((others.into_iter().map(text).collect(), environment.collect()))
    }

    #[test]
    fn ros_arguments_that_override_variables_become_variables() {
        assert_eq!(parts(&["-d", "a.rviz", "image:=/x", "__name:=y"]), None);
        let (others, environment) = parts(&["-d", "__master:=http://r:1/", "a.rviz", "__ip:=10.0.0.7"]).unwrap();
        assert_eq!(others, ["-d", "a.rviz"]);
        assert_eq!(environment, ["ROS_MASTER_URI=http://r:1/", "ROS_IP=10.0.0.7", "ROS_HOSTNAME=10.0.0.7"]);
        let (_, environment) = parts(&["__hostname:=robot", "__ip:=10.0.0.7"]).unwrap();
        assert_eq!(environment, ["ROS_HOSTNAME=robot", "ROS_IP=10.0.0.7"]);
    }
}
