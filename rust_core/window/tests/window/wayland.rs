//! The window on a Wayland compositor with two outputs: weston, whose outputs are windows on an X server.

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use x11rb::protocol::xproto::{ClientMessageEvent, ConfigureWindowAux, ConnectionExt as _, EventMask};

use crate::screen::*;

pub(crate) const OUTPUT: (u32, u32) = (600, 400);

pub(crate) struct Weston {
    pub(crate) compositor: Process,
    pub(crate) screen: Screen,
    folder: tempfile::TempDir,
}

impl Weston {
    /// Two outputs beside each other.
    pub(crate) fn start() -> Self {
        let screen = Screen::start(false);
        let folder = tempfile::tempdir().unwrap();
        let (width, height) = OUTPUT;
        let mut command = Command::new("weston");
        command.args(["--backend=x11-backend.so", "--use-pixman", "--no-config", "--output-count=2", "--idle-time=0"]);
        command.args([format!("--width={width}"), format!("--height={height}"), "--socket=test".to_owned()]);
        command.env("XDG_RUNTIME_DIR", folder.path()).env("DISPLAY", &screen.display).env_remove("WAYLAND_DISPLAY");
        let compositor = Process::start(command.stdout(Stdio::null()).stderr(Stdio::null()));
        let started = Self { compositor, screen, folder };
        let outputs = wait_for("the outputs", || {
            let tree = started.screen.connection.query_tree(started.screen.root).unwrap().reply().unwrap();
            let is_there = started.folder.path().join("test").exists();
            Some(tree.children).filter(|children| is_there && children.len() == 2)
        });
        for (index, window) in outputs.into_iter().enumerate() {
            let place = ConfigureWindowAux::new().x(index as i32 * OUTPUT.0 as i32).y(0);
            started.screen.connection.configure_window(window, &place).unwrap().check().unwrap();
        }
        started
    }

    pub(crate) fn show(&self, arguments: &[&str]) -> Shown {
        let mut command = Command::new(example());
        command.env("XDG_RUNTIME_DIR", self.folder.path()).env("WAYLAND_DISPLAY", "test").env_remove("WAYLAND_SOCKET");
        Shown::start(command.env_remove("DISPLAY").args(arguments))
    }

    /// `true` if the window shows the pattern on an output.
    pub(crate) fn has_pattern(&self, output: usize) -> bool {
        self.screen.corners((output as u32 * OUTPUT.0, 0), OUTPUT) == pattern_corners(OUTPUT)
    }

    pub(crate) fn wait_for_pattern(&self, window: &Shown, output: usize) {
        let start = Instant::now();
        while !self.has_pattern(output) {
            assert!(start.elapsed() < PATIENCE, "{}", window.log_text());
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}

#[test]
fn the_output_that_is_asked_for_shows_the_image_pixel_by_pixel() {
    let weston = Weston::start();
    for (name, output) in [("screen1", 1), ("screen0", 0)] {
        let mut window = weston.show(&["600x400", "--monitor", name]);
        weston.wait_for_pattern(&window, output);
        let place = (i16::try_from(output as u32 * OUTPUT.0).unwrap(), 0);
        let all = expected(OUTPUT.0, OUTPUT.1);
        let rows = all.chunks(WIDTH_PX as usize).take(OUTPUT.1 as usize);
        let image: Vec<u32> = rows.flat_map(|row| &row[..OUTPUT.0 as usize]).copied().collect();
        assert!(weston.screen.pixels_at(place, OUTPUT) == image, "each pixel is the picture's");
        let is_black = || weston.screen.corners((output as u32 * OUTPUT.0, 0), OUTPUT) == [0; 4];
        wait_for("black by a key", || {
            if !window.log_text().contains("key Character('b')") {
                weston.focus(output);
                weston.screen.press(LETTER_B);
            }
            is_black().then_some(())
        });
        wait_for("the end by a key", || {
            weston.focus(output);
            weston.screen.press(LETTER_Q);
            window.process.0.try_wait().unwrap()
        });
    }
}

impl Weston {
    /// Closes an output, as weston does when its window on the X server is closed.
    fn close_output(&self, output: usize) {
        let connection = &self.screen.connection;
        let windows = connection.query_tree(self.screen.root).unwrap().reply().unwrap().children;
        let left = (output as u32 * OUTPUT.0) as i16;
        let at = |window: &u32| connection.get_geometry(*window).unwrap().reply().unwrap().x;
        let window = windows.into_iter().find(|window| at(window) == left).unwrap();
        let atom = |name: &[u8]| connection.intern_atom(false, name).unwrap().reply().unwrap().atom;
        let data = [atom(b"WM_DELETE_WINDOW"), 0, 0, 0, 0];
        let close = ClientMessageEvent::new(32, window, atom(b"WM_PROTOCOLS"), data);
        connection.send_event(false, window, EventMask::NO_EVENT, close).unwrap().check().unwrap();
    }

    /// Gives the keyboard to an output: the pointer is over it.
    pub(crate) fn focus(&self, output: usize) {
        let (x, y) = (output as i16 * OUTPUT.0 as i16 + 300, 200);
        self.screen.connection.warp_pointer(x11rb::NONE, self.screen.root, 0, 0, 0, 0, x, y).unwrap().check().unwrap();
    }
}

#[test]
fn outputs_are_listed_and_an_unknown_one_is_an_error() {
    let weston = Weston::start();
    let window = weston.show(&["64x64", "--monitor", "none-such"]);
    let list = "0: screen0 600x400+0+0, 1: screen1 600x400+600+0";
    wait_for("the list", || window.log_text().contains(list).then_some(()));
}

#[test]
fn the_compositors_end_is_one_line() {
    let mut weston = Weston::start();
    let mut window = weston.show(&["600x400"]);
    weston.wait_for_pattern(&window, 1);
    weston.compositor.0.kill().unwrap();
    let status = wait_for("the program's end", || window.process.0.try_wait().unwrap());
    assert_eq!(status.code(), Some(1));
    let log = window.log_text();
    assert_eq!(log.lines().filter(|line| line.contains("the Wayland compositor is gone")).count(), 1, "{log}");
}

#[test]
fn buffers_are_destroyed_with_the_window_when_its_output_goes() {
    let weston = Weston::start();
    let mut command = Command::new(example());
    command.env("XDG_RUNTIME_DIR", weston.folder.path()).env("WAYLAND_DISPLAY", "test").env_remove("WAYLAND_SOCKET");
    // The client library logs each request.
    command.env_remove("DISPLAY").env("WAYLAND_DEBUG", "client");
    let window = Shown::start(command.args(["600x400", "--monitor", "screen1"]));
    weston.wait_for_pattern(&window, 1);
    let count = |parts: [&str; 2]| {
        let log = window.log_text();
        log.lines().filter(|line| parts.iter().all(|part| line.contains(part))).count()
    };
    let destroyed = || count(["wl_buffer@", ".destroy("]);
    assert_eq!((count([".create_buffer(", ""]), destroyed()), (2, 0));
    weston.close_output(1);
    wait_for("the buffers' end", || (destroyed() == 2).then_some(()));
}
