//! Real ROS processes for tests: a master on a free port, programs that connect to it, and waiting for what they print.
//!
//! Everything that is started here is ended when its value is dropped, and nothing else is.

use std::fs;
use std::io::{self, BufRead, BufReader, Read};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rcs_process::lock;

/// Timeout of the longest waits: ten times what a large array through Python needs on a slow machine.
pub const PATIENCE: Duration = Duration::from_secs(300);
/// Timeout of short waits: the end of a program, the next image. Ten times what a slow machine needs.
pub const PROMPT: Duration = Duration::from_secs(20);
/// How long an ended program's last lines may take to be read.
const LAST_LINES: Duration = Duration::from_secs(60);

/// Polls `condition` until it holds; false when it does not within `timeout`.
pub fn wait_until(timeout: Duration, mut condition: impl FnMut() -> bool) -> bool {
    let started = Instant::now();
    loop {
        if condition() {
            return true;
        }
        if started.elapsed() > timeout {
            return false;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// A TCP port that nobody listens on, and that no other test of this process was given. It lies below those that Linux
/// gives by itself (32768 and up), because one of them may be another node's before the master listens there.
pub fn free_port() -> io::Result<u16> {
    const PORTS: std::ops::Range<u32> = 20_000..32_000;
    static GIVEN: AtomicU32 = AtomicU32::new(0);
    let count = PORTS.end - PORTS.start;
    // Other processes begin elsewhere.
    let first = std::process::id().wrapping_mul(37);
    for _ in PORTS {
        let next = GIVEN.fetch_add(1, Ordering::Relaxed);
        let port = u16::try_from(PORTS.start + first.wrapping_add(next) % count).map_err(io::Error::other)?;
        if TcpListener::bind(("127.0.0.1", port)).is_ok() {
            return Ok(port);
        }
    }
    Err(io::Error::other("no port is free"))
}

/// Where a file of ROS is: in a sourced installation, or Debian's.
fn installed(path: &Path) -> PathBuf {
    let sourced = std::env::var("CMAKE_PREFIX_PATH").unwrap_or_default();
    let places = sourced.split(':').filter(|place| !place.is_empty()).chain(["/usr"]);
    let mut found = places.map(|place| Path::new(place).join(path));
    found.find(|path| path.is_file()).unwrap_or_else(|| Path::new("/usr").join(path))
}

/// A master on a port of its own, and the node that collects logs: what `roscore` starts, without roscore itself, which
/// takes longer to start and to end than most tests take.
#[derive(Debug)]
pub struct RosMaster {
    port: u16,
    home: PathBuf,
    core: Option<Core>,
}

#[derive(Debug)]
struct Core {
    master: Running,
    _rosout: Running,
}

impl RosMaster {
    /// Starts a master and waits until it answers.
    pub fn start() -> io::Result<Self> {
        let mut master = Self::reserve()?;
        master.run()?;
        Ok(master)
    }

    /// Chooses a port without starting a master there yet.
    pub fn reserve() -> io::Result<Self> {
        let port = free_port()?;
        let home = std::env::temp_dir().join(format!("rcs_ros_home_{}_{port}", std::process::id()));
        fs::create_dir_all(&home)?;
        Ok(Self { port, home, core: None })
    }

    /// Starts the master on its port.
    pub fn run(&mut self) -> io::Result<()> {
        let port = self.port.to_string();
        let master = Running::start(self.command("rosmaster").args(["--core", "-p", &port, "-w", "3"]))?;
        let is_up = || TcpStream::connect(("127.0.0.1", self.port)).is_ok();
        if !wait_until(PATIENCE, is_up) {
            return Err(io::Error::other(format!("rosmaster does not answer: {:?}", master.errors())));
        }
        let mut rosout = self.environment(Command::new(installed(Path::new("lib/rosout/rosout"))));
        self.core = Some(Core { master, _rosout: Running::start(&mut rosout)? });
        Ok(())
    }

    /// Ends the master and starts another on the same port, with which no node is registered.
    pub fn restart(&mut self) -> io::Result<()> {
        self.core = None;
        self.run()
    }

    /// Sends a signal, such as `STOP`, to the master.
    pub fn signal(&self, name: &str) {
        if let Some(core) = &self.core {
            core.master.signal(name);
        }
    }

    /// Its address.
    pub fn uri(&self) -> String {
        format!("http://127.0.0.1:{}", self.port)
    }

    /// A program of ROS that uses this master.
    pub fn command(&self, name: &str) -> Command {
        self.environment(Command::new(installed(&Path::new("bin").join(name))))
    }

    /// One of the project's programs, as built, that uses this master.
    pub fn program(&self, name: &str) -> Command {
        self.environment(Command::new(crate::programs::program(name)))
    }

    /// Sets the environment of any program so that it uses this master.
    pub fn environment(&self, mut command: Command) -> Command {
        // Debian's ROS is for Debian's python.
        let path = format!("/usr/bin:{}", std::env::var("PATH").unwrap_or_default());
        command
            .env("PATH", path)
            .env("ROS_MASTER_URI", self.uri())
            .env("ROS_IP", "127.0.0.1")
            .env_remove("ROS_HOSTNAME")
            .env_remove("ROS_NAMESPACE")
            .env("ROS_HOME", &self.home)
            .env("ROS_LOG_DIR", self.home.join("log"))
            .env("PYTHONUNBUFFERED", "1");
        if std::env::var_os("ROS_PACKAGE_PATH").is_none() {
            command.env("ROS_PACKAGE_PATH", "/usr/share");
        }
        if std::env::var_os("CMAKE_PREFIX_PATH").is_none() {
            command.env("CMAKE_PREFIX_PATH", "/usr");
        }
        command
    }

    /// Runs one of ROS's programs to its end and returns what it printed.
    pub fn output(&self, name: &str, args: &[&str]) -> io::Result<String> {
        let output = self.command(name).args(args).stdin(Stdio::null()).output()?;
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    }
}

impl Drop for RosMaster {
    fn drop(&mut self) {
        self.core = None;
        // A log that is still being written stays behind; the next test has a folder of its own.
        let _ = fs::remove_dir_all(&self.home);
    }
}

/// A running program, and the lines that it has printed so far. It is killed when this is dropped.
#[derive(Debug)]
pub struct Running {
    child: Child,
    printed: Lines,
    errors: Lines,
    readers: Vec<JoinHandle<()>>,
}

type Lines = Arc<Mutex<Vec<String>>>;

impl Running {
    /// Starts a program and collects what it prints.
    pub fn start(command: &mut Command) -> io::Result<Self> {
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn()?;
        let (printed, errors) = (Lines::default(), Lines::default());
        let stdout = child.stdout.take().map(|stdout| collect(stdout, &printed));
        let stderr = child.stderr.take().map(|stderr| collect(stderr, &errors));
        Ok(Self { child, printed, errors, readers: stdout.into_iter().chain(stderr).collect() })
    }

    /// Its process.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// The lines on its standard output so far.
    pub fn lines(&self) -> Vec<String> {
        lock(&self.printed).clone()
    }

    /// The lines on its standard error so far.
    pub fn errors(&self) -> Vec<String> {
        lock(&self.errors).clone()
    }

    /// How many lines contain `text` so far.
    pub fn count(&self, text: &str) -> usize {
        lock(&self.printed).iter().filter(|line| line.contains(text)).count()
    }

    /// Waits for the first line that contains `text`; none when there is none in time.
    pub fn line_with(&self, text: &str) -> Option<String> {
        let mut found = None;
        wait_until(PATIENCE, || {
            found = lock(&self.printed).iter().find(|line| line.contains(text)).cloned();
            found.is_some()
        });
        found
    }

    /// Waits for a line on its standard error with all of these texts.
    ///
    /// # Panics
    /// When there is none in time.
    pub fn wait_for_error(&self, texts: &[&str]) {
        let is_said = || lock(&self.errors).iter().any(|line| texts.iter().all(|text| line.contains(text)));
        assert!(wait_until(PATIENCE, is_said), "{texts:?}: {:?}", self.errors());
    }

    /// Waits until more lines contain `text` than now; false when none comes.
    pub fn prints_again(&self, text: &str) -> bool {
        let before = self.count(text);
        wait_until(PROMPT, || self.count(text) > before)
    }

    /// Sends it a signal by name, such as `TERM`.
    pub fn signal(&self, name: &str) {
        // A process that has ended already needs none.
        let _ = Command::new("kill").arg(format!("-{name}")).arg(self.id().to_string()).status();
    }

    /// Sends it a signal and waits for its end, which is printed with how long it took.
    ///
    /// # Errors
    /// With what it printed, when it goes on for longer than [`PROMPT`].
    pub fn end(&mut self, signal: &str) -> io::Result<ExitStatus> {
        let begin = Instant::now();
        self.signal(signal);
        let status = self.wait(PROMPT);
        println!("ends {:.2?} after SIG{signal}", begin.elapsed());
        status.ok_or_else(|| io::Error::other(format!("still runs after SIG{signal}: {:?}", self.errors())))
    }

    /// Sends it a first signal, and second ones until it has ended: signals that wait at the same time are one.
    ///
    /// # Errors
    /// When it does not end.
    pub fn end_at_once(&mut self, first: &str, second: &str) -> io::Result<ExitStatus> {
        self.signal(first);
        for _ in 0..100 {
            if let Some(status) = self.wait(Duration::from_millis(200)) {
                return Ok(status);
            }
            self.signal(second);
        }
        self.end(second)
    }

    /// Whether nothing more will come: it has ended, or closed both of its outputs.
    pub fn is_silent(&self) -> bool {
        self.readers.iter().all(JoinHandle::is_finished)
    }

    /// Waits for its end; none when it still runs after `timeout`. Then all of its lines have been read, unless another
    /// program that it has started goes on to print.
    pub fn wait(&mut self, timeout: Duration) -> Option<ExitStatus> {
        let mut status = None;
        wait_until(timeout, || {
            status = self.child.try_wait().ok().flatten();
            status.is_some()
        });
        if status.is_some() {
            wait_until(LAST_LINES, || self.is_silent());
        }
        status
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // A wrapper such as rosbag has started another program, which would live on.
        let children = ["-KILL", "-P", &self.child.id().to_string()];
        let _ = Command::new("pkill").args(children).status();
        // Both fail only when it has ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn collect(stream: impl Read + Send + 'static, lines: &Lines) -> JoinHandle<()> {
    let lines = Arc::clone(lines);
    std::thread::spawn(move || {
        for line in BufReader::new(stream).lines().map_while(Result::ok) {
            lock(&lines).push(line);
        }
    })
}
