//! What most end-to-end tests start: a master of their own, a Python node that the test controls, and `camera_stream`.

use crate::python_node::PythonNode;
use crate::ros::{RosMaster, Running, PATIENCE, PROMPT};
use std::fmt::Write as _;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

/// A display of `/cloud`: the points are squares of 1 m in their own colour.
pub const CLOUD: &str = "{Class: rviz/PointCloud2, Name: cloud, Enabled: true, Topic: /cloud, Style: Flat Squares, \
     Size (m): 1, Color Transformer: RGB8, Position Transformer: XYZ, Queue Size: 10, Alpha: 1, Decay Time: 0}";

/// A CameraPub display of a config.
#[derive(Clone, Debug)]
pub struct CameraPub {
    /// Its name.
    pub name: &'static str,
    /// "Image Topic".
    pub image: &'static str,
    /// "Camera Info Topic".
    pub info: &'static str,
    /// "Display namespace".
    pub namespace: &'static str,
    /// "Frame Rate".
    pub rate: &'static str,
    /// "Background Color".
    pub background: &'static str,
}

impl Default for CameraPub {
    fn default() -> Self {
        Self {
            name: "CameraPub",
            image: "/view/image",
            info: "/eye/camera_info",
            namespace: "",
            rate: "-1",
            background: "0; 0; 0",
        }
    }
}

/// The text of a `.rviz` file with these displays and cameras, and `map` as fixed frame.
pub fn config(displays: &[&str], cameras: &[CameraPub]) -> String {
    let mut text = "Visualization Manager:\n  Displays:\n".to_owned();
    for display in displays {
        text += &format!("  - {display}\n");
    }
    for camera in cameras {
        let CameraPub { name, image, info, namespace, rate, background } = camera;
        let _ = writeln!(
            text,
            "  - {{Class: rviz_camera_stream/CameraPub, Name: {name}, Enabled: true, Image Topic: '{image}', Camera Info \
             Topic: '{info}', Display namespace: '{namespace}', Frame Rate: {rate}, Background Color: {background}, \
             Image Encoding: rgb8, Near Clip Distance: 0.01, Queue Size: 2, Visibility: {{Value: true}}}}"
        );
    }
    text + "  Enabled: true\n  Global Options: {Fixed Frame: map, Frame Rate: 30}\n"
}

/// A master, and a Python node that has run this code.
///
/// # Panics
/// When one of them does not start, or the code fails.
pub fn master_and_python(code: impl std::fmt::Display) -> (RosMaster, PythonNode) {
    let start = || {
        let master = RosMaster::start()?;
        let python = PythonNode::start(&master, &[])?;
        python.run(code).map(|_| (master, python))
    };
    start().unwrap_or_else(|error| fail(&error))
}

/// Names the renderer of all nodes of these tests: `cpu` (the default), `gpu` or `auto`.
const RENDERER: &str = "RCS_RENDERER";

/// Name of the config's file.
const CONFIG: &str = "scene.rviz";

/// `camera_stream`, a Python node and their master. When a test fails, the log of `camera_stream` is printed.
#[derive(Debug)]
pub struct RosFixture {
    /// `camera_stream`.
    pub node: Running,
    /// Publishes and subscribes for the test.
    pub python: PythonNode,
    /// The master, on a port of its own.
    pub master: RosMaster,
    folder: PathBuf,
}

/// A node to be started on a master of its own, beside a Python node: its config, arguments and environment.
#[derive(Clone, Debug)]
pub struct Setup<'a> {
    config: String,
    args: Vec<&'a str>,
    environment: Vec<(&'a str, &'a str)>,
    is_time_simulated: bool,
}

impl<'a> Setup<'a> {
    /// A node with these displays and the default camera.
    pub fn of(displays: &[&str]) -> Self {
        Self::with_cameras(displays, &[CameraPub::default()])
    }

    /// A node with these displays and cameras.
    pub fn with_cameras(displays: &[&str], cameras: &[CameraPub]) -> Self {
        Self::with_config(config(displays, cameras))
    }

    /// A node with the text of a config.
    pub fn with_config(config: String) -> Self {
        Self { config, args: Vec::new(), environment: Vec::new(), is_time_simulated: false }
    }

    /// Adds arguments.
    pub fn args(mut self, args: &[&'a str]) -> Self {
        self.args.extend(args);
        self
    }

    /// Has the node use an X server, and no other display server.
    pub fn on_screen(mut self, display: &'a str) -> Self {
        self.environment.extend([("DISPLAY", display), ("WAYLAND_DISPLAY", ""), ("WAYLAND_SOCKET", "")]);
        self
    }

    /// Sets `/use_sim_time`, so that there is no time before the first `/clock`.
    pub fn simulated_time(mut self) -> Self {
        self.is_time_simulated = true;
        self
    }

    /// Starts the master, the Python node and `camera_stream`, and waits until that is ready.
    ///
    /// # Panics
    /// When one of them does not start.
    pub fn start(&self) -> RosFixture {
        let fixture = self.launch();
        fixture.wait_for_log("drawing ").unwrap_or_else(|error| fail(&error));
        fixture
    }

    /// Starts all of them as [`start`](Self::start), and neither waits for `camera_stream` nor expects it to live.
    ///
    /// # Panics
    /// When a process cannot be started.
    pub fn launch(&self) -> RosFixture {
        RosMaster::start().and_then(|master| self.beside(master)).unwrap_or_else(|error| fail(&error))
    }

    /// Starts the Python node and `camera_stream` beside what a master has already, and does not wait.
    ///
    /// # Errors
    /// When a process cannot be started.
    pub fn beside(&self, master: RosMaster) -> io::Result<RosFixture> {
        if self.is_time_simulated {
            master.output("rosparam", &["set", "/use_sim_time", "true"])?;
        }
        let python = PythonNode::start(&master, &[])?;
        let folder = std::env::temp_dir().join(format!("rcs_fixture_{}", master.uri().replace(['/', ':'], "")));
        fs::create_dir_all(&folder)?;
        let file = folder.join(CONFIG);
        fs::write(&file, &self.config)?;
        let node = Running::start(&mut command(&master, &file, &self.args, &self.environment))?;
        Ok(RosFixture { node, python, master, folder })
    }

    /// Starts all, publishes a red cloud before the camera with the Python helper `show`, and waits until the viewer
    /// `viewer` sees it in the middle of the image.
    ///
    /// # Panics
    /// When it is not seen.
    pub fn showing_red(&self) -> RosFixture {
        let fixture = self.start();
        fixture.python("show()");
        fixture.wait_for("viewer.middle() == (255, 0, 0)");
        fixture
    }
}

#[expect(clippy::panic, reason = "a test cannot go on")]
fn fail(error: &io::Error) -> ! {
    panic!("{error}")
}

impl RosFixture {
    /// Starts `camera_stream` again, without arguments, after it has ended.
    ///
    /// # Errors
    /// When it does not start.
    pub fn respawn(&mut self) -> io::Result<()> {
        self.node = Running::start(&mut command(&self.master, &self.config_file(), &[], &[]))?;
        self.wait_for_log("drawing ")
    }

    /// The config's file.
    pub fn config_file(&self) -> PathBuf {
        self.folder.join(CONFIG)
    }

    /// Writes the config's file again, as rviz does: in place.
    ///
    /// # Panics
    /// When it cannot be written.
    #[expect(clippy::panic, reason = "a test cannot go on")]
    pub fn rewrite(&self, config: &str) {
        fs::write(self.config_file(), config).unwrap_or_else(|error| panic!("{error}"));
    }

    /// The node's log.
    pub fn log(&self) -> String {
        self.node.errors().join("\n")
    }

    /// Number of lines of the node's log that contain all of these words.
    pub fn log_lines(&self, words: &[&str]) -> usize {
        self.node.errors().iter().filter(|line| words.iter().all(|word| line.contains(word))).count()
    }

    /// Waits until the node's log has a line with this text.
    ///
    /// # Errors
    /// With the log, when it does not come, or when the node ends before.
    pub fn wait_for_log(&self, text: &str) -> io::Result<()> {
        let is_logged = || self.log_lines(&[text]) > 0;
        crate::ros::wait_until(PATIENCE, || is_logged() || self.node.is_silent());
        if is_logged() {
            Ok(())
        } else {
            Err(io::Error::other(format!("the node does not log \"{text}\":\n{}", self.log())))
        }
    }

    /// Runs Python in the Python node.
    ///
    /// # Panics
    /// With the traceback, when it fails.
    #[expect(clippy::panic, reason = "a test cannot go on")]
    pub fn python(&self, python: impl std::fmt::Display) -> String {
        self.python.run(python).unwrap_or_else(|error| panic!("{error}"))
    }

    /// Waits until a Python expression is true in the Python node.
    ///
    /// # Panics
    /// When it does not become so, with what the viewer `viewer` has received.
    #[expect(clippy::panic, reason = "a test cannot go on")]
    pub fn wait_for(&self, python: impl std::fmt::Display) {
        if !self.python.wait_for(PATIENCE, &python) {
            let received = "viewer and (viewer.colors[-10:], viewer.images[-3:], viewer.infos[-3:])";
            panic!("not true after {PATIENCE:?}: {python}; the viewer received {:?}", self.python.run(received));
        }
    }

    /// Has the Python node's `viewer` receive `count` more images, and prints the longest time between two of them.
    ///
    /// # Panics
    /// When that is more than [`PROMPT`], or the images do not come.
    #[expect(clippy::panic, reason = "a test cannot go on")]
    pub fn images_go_on(&self, count: usize) {
        self.python("viewer.forget()");
        self.wait_for(format!("len(viewer.images) > {count}"));
        let gap = self.python("max(b[0] - a[0] for a, b in zip(viewer.images, viewer.images[1:]))");
        println!("{count} pictures, at most {gap} s apart");
        if !gap.parse::<f64>().is_ok_and(|secs| secs < PROMPT.as_secs_f64()) {
            panic!("{gap} s without a picture");
        }
    }

    /// Waits until so long a time has passed in which all that the Python node's `viewer` received was this: of a
    /// publisher that is held up for as long as data may be old, the image is rightly black for a moment.
    ///
    /// # Panics
    /// When there is no such time.
    #[expect(clippy::panic, reason = "a test cannot go on")]
    pub fn shows_only(&self, color: &str, duration: Duration) {
        let is_steady = || {
            self.python("viewer.forget()");
            std::thread::sleep(duration);
            self.python("viewer.colors") == format!("[{color}]")
        };
        if !crate::ros::wait_until(PATIENCE, is_steady) {
            panic!("not {color} for {duration:?}: {}", self.python("viewer.colors"));
        }
    }
}

/// `camera_stream` with a config and more arguments.
fn command(master: &RosMaster, config: &Path, args: &[&str], environment: &[(&str, &str)]) -> Command {
    let mut command = master.program("camera_stream");
    command.envs(environment.iter().copied());
    let renderer = std::env::var(RENDERER).unwrap_or_else(|_| "cpu".to_owned());
    command.arg("-d").arg(config).args(args);
    if !args.contains(&"--renderer") {
        command.args(["--renderer", &renderer]);
    }
    command
}

impl Drop for RosFixture {
    fn drop(&mut self) {
        if std::thread::panicking() {
            eprintln!("--- the node's log:\n{}\n---", self.log());
        }
        // If this fails, a small folder of temporary files remains.
        let _ = fs::remove_dir_all(&self.folder);
    }
}
