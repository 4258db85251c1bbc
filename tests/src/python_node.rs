//! A rospy node that a test controls: it runs the Python code that the test sends, which publishes, subscribes and
//! calls services.
//!
//! The helpers for that code (`cloud`, `info`, `tf`, `latch`, `show`, `monitor`, `Viewer`...) are in `python_node.py`.

use crate::ros::{wait_until, RosMaster};
use std::fmt::Display;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, ChildStdout, Stdio};
use std::sync::Mutex;
use std::time::Duration;

use rcs_process::lock;

const SCRIPT: &str = include_str!("python_node.py");

/// A rospy node. It ends when this is dropped.
#[derive(Debug)]
pub struct PythonNode {
    child: Child,
    pipes: Mutex<(ChildStdin, BufReader<ChildStdout>)>,
}

impl PythonNode {
    /// Starts the node; `args` are ROS's, such as `__name:=other`.
    pub fn start(master: &RosMaster, args: &[&str]) -> io::Result<Self> {
        let mut command = master.command("python3");
        command.args(["-c", SCRIPT]).args(args).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.spawn()?;
        let missing = || io::Error::other("no pipe");
        let stdin = child.stdin.take().ok_or_else(missing)?;
        let mut stdout = BufReader::new(child.stdout.take().ok_or_else(missing)?);
        let ready = read_answer(&mut stdout);
        let python = Self { child, pipes: Mutex::new((stdin, stdout)) };
        ready.map(|_| python)
    }

    /// Runs Python in the node. Returns what an expression gives, as text.
    ///
    /// # Errors
    /// With the traceback of an exception.
    pub fn run(&self, python: impl Display) -> io::Result<String> {
        let python = python.to_string();
        let mut pipes = lock(&self.pipes);
        let (stdin, stdout) = &mut *pipes;
        write!(stdin, "{}\n{python}", python.len())?;
        stdin.flush()?;
        read_answer(stdout).map_err(|error| io::Error::other(format!("{python}: {error}")))
    }

    /// Waits until an expression is true; false when it is not within `timeout`, or fails.
    pub fn wait_for(&self, timeout: Duration, python: impl Display) -> bool {
        let expression = format!("bool({python})");
        wait_until(timeout, || self.run(&expression).is_ok_and(|answer| answer == "True"))
    }

    /// Its process.
    pub fn id(&self) -> u32 {
        self.child.id()
    }
}

impl Drop for PythonNode {
    fn drop(&mut self) {
        // Both fail only when it has ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn read_answer(stdout: &mut BufReader<ChildStdout>) -> io::Result<String> {
    let mut head = String::new();
    stdout.read_line(&mut head)?;
    let Some((word, size)) = head.trim_end().split_once(' ') else {
        return Err(io::Error::other(format!("the Python node has ended: {head}")));
    };
    let size = size.parse().map_err(|_| io::Error::other(format!("no answer of the Python node: {head}")))?;
    let mut text = vec![0; size];
    stdout.read_exact(&mut text)?;
    let text = String::from_utf8_lossy(&text).into_owned();
    if word == "ok" {
        Ok(text)
    } else {
        Err(io::Error::other(text))
    }
}
