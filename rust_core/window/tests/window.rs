//! The window on a real X server: the screen shows the picture, pixel by pixel, over the whole screen.
//!
//! Each test starts its own Xvfb on a free display (and openbox where a window manager is asked for), runs the example
//! `window_pattern` there, reads the root window's pixels and presses keys through the XTEST extension. Debian's
//! packages `xvfb` and `openbox` must be installed.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use x11rb::connection::Connection;
use x11rb::protocol::xproto::{ConnectionExt as _, ImageFormat, KEY_PRESS_EVENT, KEY_RELEASE_EVENT};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;

const WIDTH_PX: u32 = 1280;
const HEIGHT_PX: u32 = 800;
const PATIENCE: Duration = Duration::from_secs(60);

/// A process that ends with the test.
struct Process(Child);

impl Process {
    fn start(command: &mut Command) -> Self {
        let name = format!("{command:?}");
        let child = command.spawn().unwrap_or_else(|error| panic!("{name}: {error}"));
        Self(child)
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The example program, and the file that its standard error goes to.
struct Shown {
    process: Process,
    log: tempfile::NamedTempFile,
}

impl Shown {
    fn log_text(&self) -> String {
        std::fs::read_to_string(self.log.path()).unwrap()
    }
}

/// Polls until there is an answer; fails the test when there is none in time.
fn wait_for<T>(what: &str, mut poll: impl FnMut() -> Option<T>) -> T {
    let deadline = Instant::now() + PATIENCE;
    loop {
        if let Some(answer) = poll() {
            return answer;
        }
        assert!(Instant::now() < deadline, "waited {PATIENCE:?} for {what}");
        sleep(Duration::from_millis(50));
    }
}

/// A virtual screen; `_server` lives as long as it.
struct Screen {
    display: String,
    connection: RustConnection,
    root: u32,
    _manager: Option<Process>,
    _server: Process,
}

impl Screen {
    fn start(with_manager: bool) -> Self {
        let size = format!("{WIDTH_PX}x{HEIGHT_PX}x24");
        Self::start_with(with_manager, &["-screen", "0", &size])
    }

    fn start_with(with_manager: bool, arguments: &[&str]) -> Self {
        let mut server = Process::start(
            Command::new("Xvfb")
                .args(["-displayfd", "1", "-nolisten", "tcp"])
                .args(arguments)
                .stdout(Stdio::piped())
                .stderr(Stdio::null()),
        );
        let mut number = String::new();
        BufReader::new(server.0.stdout.take().unwrap()).read_line(&mut number).unwrap();
        let display = format!(":{}", number.trim());
        let (connection, screen) = x11rb::connect(Some(&display)).unwrap();
        let root = connection.setup().roots[screen].root;
        let manager = with_manager.then(|| {
            Process::start(Command::new("openbox").env("DISPLAY", &display).stdout(Stdio::null()).stderr(Stdio::null()))
        });
        let started = Self { display, connection, root, _manager: manager, _server: server };
        if with_manager {
            wait_for("openbox to manage the screen", || started.is_managed().then_some(()));
        }
        started
    }

    fn is_managed(&self) -> bool {
        let atom = self.connection.intern_atom(false, b"_NET_SUPPORTING_WM_CHECK").unwrap();
        let atom = atom.reply().unwrap().atom;
        let any = x11rb::protocol::xproto::AtomEnum::ANY;
        let property = self.connection.get_property(false, self.root, atom, any, 0, 1).unwrap();
        property.reply().unwrap().value_len > 0
    }

    fn show(&self, arguments: &[&str]) -> Shown {
        let log = tempfile::NamedTempFile::new().unwrap();
        let process = Process::start(
            Command::new(example())
                .args(arguments)
                .env("DISPLAY", &self.display)
                .env_remove("WAYLAND_DISPLAY")
                .env_remove("WAYLAND_SOCKET")
                .stderr(log.reopen().unwrap()),
        );
        Shown { process, log }
    }

    /// Runs xrandr on this screen.
    fn xrandr(&self, arguments: &[&str]) {
        let output = Command::new("xrandr").args(arguments).env("DISPLAY", &self.display).output().unwrap();
        assert!(output.status.success(), "xrandr {arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    }

    /// A pattern's pixel at each corner of a part of the screen, as they are there.
    fn corners(&self, (left, top): (u32, u32), (width, height): (u32, u32)) -> [u32; 4] {
        let pixels = self.pixels();
        [(0, 0), (width - 1, 0), (0, height - 1), (width - 1, height - 1)]
            .map(|(u, v)| pixels[((top + v) * WIDTH_PX + left + u) as usize])
    }

    /// The pixels of the root window, `0x00RRGGBB`.
    fn pixels(&self) -> Vec<u32> {
        let (width, height) = (WIDTH_PX as u16, HEIGHT_PX as u16);
        let image = self.connection.get_image(ImageFormat::Z_PIXMAP, self.root, 0, 0, width, height, !0).unwrap();
        let data = image.reply().unwrap().data;
        data.chunks_exact(4).map(|bgrx| u32::from_be_bytes([0, bgrx[2], bgrx[1], bgrx[0]])).collect()
    }

    /// Presses and releases the key that types `keysym`.
    fn press(&self, keysym: u32) {
        let (first, last) = (self.connection.setup().min_keycode, self.connection.setup().max_keycode);
        let mapping = self.connection.get_keyboard_mapping(first, last - first + 1).unwrap();
        let mapping = mapping.reply().unwrap();
        let per_key = usize::from(mapping.keysyms_per_keycode);
        let place = mapping.keysyms.chunks(per_key).position(|keysyms| keysyms.contains(&keysym));
        let keycode = first + u8::try_from(place.unwrap()).unwrap();
        for event in [KEY_PRESS_EVENT, KEY_RELEASE_EVENT] {
            let request = self.connection.xtest_fake_input(event, keycode, 0, self.root, 0, 0, 0);
            request.unwrap().check().unwrap();
        }
    }

    /// Presses a key until the program ends: the window has the keyboard only once it has settled.
    fn quit(&self, window: &mut Shown, key: u32) -> ExitStatus {
        wait_for("the key to end the program", || {
            self.press(key);
            window.process.0.try_wait().unwrap()
        })
    }

    fn wait_for_pixels(&self, window: &mut Shown, expected: &[u32]) {
        let deadline = Instant::now() + PATIENCE;
        loop {
            let pixels = self.pixels();
            if pixels == expected {
                return;
            }
            let ended = window.process.0.try_wait().unwrap();
            if ended.is_some() || Instant::now() > deadline {
                let wrong = pixels.iter().zip(expected).filter(|(got, want)| got != want).count();
                panic!(
                    "{wrong} of {} pixels on the screen are not the picture's; the program {}; the windows are {:#?}; \
                     its log {}",
                    expected.len(),
                    ended.map_or("runs".to_owned(), |status| format!("ended with {status}")),
                    self.windows(),
                    window.log_text(),
                );
            }
            sleep(Duration::from_millis(100));
        }
    }

    /// The windows on the screen from the lowest to the topmost, one line each, for a failing test's message.
    fn windows(&self) -> Vec<String> {
        let mut lines = Vec::new();
        let mut open = vec![(self.root, 0)];
        while let Some((window, depth)) = open.pop() {
            let attributes = self.connection.get_window_attributes(window).unwrap().reply();
            let geometry = self.connection.get_geometry(window).unwrap().reply();
            if let (Ok(attributes), Ok(at)) = (attributes, geometry) {
                let (state, own_place) = (attributes.map_state, attributes.override_redirect);
                let place = format!("{}x{}{:+}{:+}", at.width, at.height, at.x, at.y);
                lines.push(format!("{:depth$}{window:#x} {place} {state:?} override-redirect {own_place}", ""));
            }
            let children = self.connection.query_tree(window).unwrap().reply();
            let children = children.map(|tree| tree.children).unwrap_or_default();
            open.extend(children.into_iter().rev().map(|child| (child, depth + 2)));
        }
        lines
    }
}

/// The example that cargo built beside this test.
fn example() -> PathBuf {
    let test = std::env::current_exe().unwrap();
    let profile = test.parent().and_then(|deps| deps.parent()).unwrap();
    let example = profile.join("examples").join("window_pattern");
    assert!(example.exists(), "{} is built with the tests", example.display());
    example
}

/// The screen with a pattern of this size at its top left, the rest black.
fn expected(width_px: u32, height_px: u32) -> Vec<u32> {
    let mut pixels = Vec::new();
    for v in 0..HEIGHT_PX {
        for u in 0..WIDTH_PX {
            let blue = (16 * (u / 256) + v / 256) % 256;
            let color = (u % 256) << 16 | (v % 256) << 8 | blue;
            pixels.push(if u < width_px && v < height_px { color } else { 0 });
        }
    }
    pixels
}

const ESCAPE: u32 = 0xff1b;
const LETTER_Q: u32 = 0x0071;
const SPACE: u32 = 0x0020;
const LEFT: u32 = 0xff51;
const LETTER_N: u32 = 0x006e;

fn covers_the_screen_and_quits(with_manager: bool, key: u32) {
    let screen = Screen::start(with_manager);
    let folder = tempfile::tempdir().unwrap();
    let screenshot = folder.path().join("shown.png");
    let mut window = screen.show(&["1280x800", "--screenshot", screenshot.to_str().unwrap()]);
    let picture = expected(1280, 800);
    screen.wait_for_pixels(&mut window, &picture);

    let saved = wait_for("the screenshot", || image::open(&screenshot).ok()).into_rgb8();
    assert_eq!(saved.dimensions(), (WIDTH_PX, HEIGHT_PX));
    let saved: Vec<u32> = saved.pixels().map(|p| u32::from_be_bytes([0, p[0], p[1], p[2]])).collect();
    assert!(saved == picture, "the screenshot is the picture");

    assert!(screen.quit(&mut window, key).success());
}

#[test]
fn under_a_window_manager_the_screen_is_the_picture_and_escape_quits() {
    covers_the_screen_and_quits(true, ESCAPE);
}

#[test]
fn without_a_window_manager_the_screen_is_the_picture_and_q_quits() {
    covers_the_screen_and_quits(false, LETTER_Q);
}

#[test]
fn keys_and_the_monitor_are_reported_to_the_program() {
    let screen = Screen::start(true);
    let mut window = screen.show(&["1280x800"]);
    screen.wait_for_pixels(&mut window, &expected(1280, 800));
    for (key, name) in [(SPACE, "key Space"), (LEFT, "key Left"), (LETTER_N, "key Character('n')")] {
        wait_for(name, || {
            screen.press(key);
            window.log_text().contains(name).then_some(())
        });
    }
    assert!(screen.quit(&mut window, ESCAPE).success());
    let log = window.log_text();
    let first = log.lines().position(|line| line.contains("opened on screen 1280x800+0+0"));
    assert!(first.is_some() && first < log.lines().position(|line| line.contains("key ")), "{log}");
}

#[test]
fn a_picture_of_another_size_is_unscaled_at_the_top_left_and_warned_about_once() {
    for (size, width, height) in [("640x480", 640, 480), ("1300x810", 1300, 810)] {
        let screen = Screen::start(true);
        let mut window = screen.show(&[size]);
        screen.wait_for_pixels(&mut window, &expected(width, height));
        wait_for("the same picture again", || window.log_text().contains("second picture").then_some(()));
        assert!(screen.quit(&mut window, ESCAPE).success());
        let log = window.log_text();
        let warnings: Vec<_> = log.lines().filter(|line| line.starts_with("WARN")).collect();
        assert_eq!(warnings.len(), 1, "{log}");
        assert!(warnings[0].contains(&format!("IS {size} PIXELS")), "{warnings:?}");
        assert!(warnings[0].contains("1280x800"), "{warnings:?}");
    }
}

/// The corners of a pattern of this size.
fn pattern_corners((width, height): (u32, u32)) -> [u32; 4] {
    let all = expected(width, height);
    [(0, 0), (width - 1, 0), (0, height - 1), (width - 1, height - 1)].map(|(u, v)| all[(v * WIDTH_PX + u) as usize])
}

#[test]
fn a_virtual_monitor_is_listed_and_covered_and_its_return_is_logged() {
    for with_manager in [false, true] {
        let screen = Screen::start(with_manager);
        screen.xrandr(&["--setmonitor", "wall", "640/160x400/100+320+200", "none"]);
        let unknown = screen.show(&["64x64", "--monitor", "none-such"]);
        wait_for("the list", || unknown.log_text().contains("wall 640x400+320+200 virtual").then_some(()));
        let mut window = screen.show(&["640x400", "--monitor", "wall"]);
        let (place, size) = ((320, 200), (640, 400));
        wait_for("the picture", || (screen.corners(place, size) == pattern_corners(size)).then_some(()));
        assert_eq!(screen.pixels()[0], 0, "nothing is beside the monitor");

        screen.xrandr(&["--delmonitor", "wall"]);
        wait_for("the warning", || window.log_text().contains("wall 640x400+320+200 virtual is gone").then_some(()));
        screen.xrandr(&["--setmonitor", "wall", "640/160x400/100+100+50", "none"]);
        wait_for("the return", || window.log_text().contains("wall 640x400+100+50 virtual is back").then_some(()));
        wait_for("the picture", || (screen.corners((100, 50), size) == pattern_corners(size)).then_some(()));
        assert!(screen.quit(&mut window, ESCAPE).success());
    }
}

#[test]
fn a_head_of_xinerama_is_covered() {
    // Xvfb puts all screens in the same place.
    let screens = ["+xinerama", "-screen", "0", "640x480x24", "-screen", "1", "1280x800x24"];
    for (monitor, head) in [("", "head-1 1280x800+0+0"), ("0", "head-0 640x480+0+0"), ("head-1", "head-1 1280x800+0+0")]
    {
        let screen = Screen::start_with(false, &screens);
        let mut window = screen.show(&["640x480", "--monitor", monitor]);
        wait_for("the monitor", || window.log_text().contains(&format!("on monitor {head}")).then_some(()));
        let place = &head[7..];
        wait_for("the window", || {
            screen.windows().iter().any(|line| line.contains(place) && line.contains("VIEWABLE")).then_some(())
        });
        assert!(screen.quit(&mut window, ESCAPE).success());
    }
}

#[test]
fn an_unknown_monitor_and_a_missing_display_are_errors_that_name_them() {
    let screen = Screen::start(false);
    let output = Command::new(example())
        .args(["64x64", "--monitor", "VGA-9"])
        .env("DISPLAY", &screen.display)
        .env_remove("WAYLAND_DISPLAY")
        .output()
        .unwrap();
    assert!(!output.status.success());
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.contains("VGA-9") && message.contains("1280x800+0+0"), "{message}");

    let output = Command::new(example())
        .arg("64x64")
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .unwrap();
    assert!(!output.status.success());
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.contains("DISPLAY"), "{message}");
}
