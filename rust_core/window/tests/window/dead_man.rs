//! The dead-man's switch of a window: its process is stopped, killed and ended, without a window manager, under openbox
//! and on weston.

use std::fs;
use std::process::Command;
use std::thread::sleep;
use std::time::{Duration, Instant};

use x11rb::protocol::xproto::{ChangeWindowAttributesAux, ConnectionExt as _};

use crate::screen::*;
use crate::wayland::{Weston, OUTPUT};

/// A monitor whose desktop is not black, and the window on it.
struct Guarded {
    place: (i16, i16),
    size: (u32, u32),
    weston: Option<Weston>,
    screen: Option<Screen>,
}

const ARGUMENTS: [&str; 2] = ["--guarded", "yes"];

impl Guarded {
    fn on_x11(with_manager: bool) -> Self {
        let screen = Screen::start(with_manager);
        let white = ChangeWindowAttributesAux::new().background_pixel(0x00ff_ffff);
        screen.connection.change_window_attributes(screen.root, &white).unwrap().check().unwrap();
        screen.connection.clear_area(false, screen.root, 0, 0, 0, 0).unwrap().check().unwrap();
        Self { place: (0, 0), size: (WIDTH_PX, HEIGHT_PX), weston: None, screen: Some(screen) }
    }

    fn on_weston() -> Self {
        Self { place: (OUTPUT.0 as i16, 0), size: OUTPUT, weston: Some(Weston::start()), screen: None }
    }

    fn screen(&self) -> &Screen {
        self.screen.as_ref().or(self.weston.as_ref().map(|weston| &weston.screen)).unwrap()
    }

    /// Starts the window; its image does not become stale.
    fn show(&self) -> Shown {
        let size = format!("{}x{}", self.size.0, self.size.1);
        let arguments = [&[size.as_str()], &ARGUMENTS[..]].concat();
        match &self.weston {
            Some(weston) => weston.show(&arguments),
            None => self.screen().show(&arguments),
        }
    }

    fn has_pattern(&self) -> bool {
        let (left, top) = (self.place.0 as u32, self.place.1 as u32);
        self.screen().corners((left, top), self.size) == pattern_corners(self.size)
    }

    fn is_black(&self) -> bool {
        self.screen().pixels_at(self.place, self.size).iter().all(|pixel| *pixel == 0)
    }

    fn wait_for_pattern(&self, window: &Shown) {
        let start = Instant::now();
        while !self.has_pattern() {
            assert!(start.elapsed() < PATIENCE, "{:#?} {}", self.screen().windows(), window.log_text());
            sleep(Duration::from_millis(20));
        }
    }

    /// Asserts that the monitor is black, and stays so until the switch has reacted.
    fn stays_black(&self, window: &Shown) {
        // The display server has yet to see that the program's connection has ended, and a compositor to paint.
        wait_for("black", || self.is_black().then_some(()));
        let mut is_told = None;
        while is_told.is_none_or(|at: Instant| at.elapsed() < Duration::from_millis(1500)) {
            let pixels = self.screen().pixels_at(self.place, self.size);
            let lit = pixels.iter().filter(|pixel| **pixel != 0).count();
            assert_eq!(lit, 0, "lit pixels: {:#?} {}", self.screen().windows(), window.log_text());
            is_told = is_told.or_else(|| window.log_text().contains("has died").then(Instant::now));
        }
    }

    /// Presses a key until something has happened.
    fn press_until<T>(&self, what: &str, key: u32, mut poll: impl FnMut() -> Option<T>) -> T {
        wait_for(what, || {
            self.weston.iter().for_each(|weston| weston.focus(1));
            self.screen().press(key);
            poll()
        })
    }
}

/// The process of the black window.
fn child_of(window: &Shown) -> u32 {
    let parent = window.process.0.id().to_string();
    let stat = |pid: &u32| fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
    let is_child = |pid: &u32| {
        // PID (NAME) STATE PARENT …
        let text = stat(pid);
        text.rsplit_once(") ").is_some_and(|(_, rest)| rest.split(' ').nth(1) == Some(&parent))
    };
    let pids = fs::read_dir("/proc").unwrap().filter_map(|entry| entry.ok()?.file_name().to_str()?.parse().ok());
    let children: Vec<u32> = pids.filter(is_child).collect();
    let [child] = children[..] else { panic!("{children:?} {}", window.log_text()) };
    child
}

fn is_running(pid: u32) -> bool {
    fs::read_to_string(format!("/proc/{pid}/comm")).is_ok_and(|name| name.trim() == "black-window")
}

fn wait_for_end(pid: u32) {
    wait_for("the black window's end", || (!is_running(pid)).then_some(()));
}

fn signal(name: &str, pid: u32) {
    assert!(Command::new("kill").args([format!("-{name}"), pid.to_string()]).status().unwrap().success());
}

fn stopped(monitor: &Guarded) {
    let mut window = monitor.show();
    monitor.wait_for_pattern(&window);
    for _ in 0..2 {
        signal("STOP", window.process.0.id());
        wait_for("black", || monitor.is_black().then_some(()));
        if let Some(weston) = &monitor.weston {
            // The black window has the keyboard, but nobody may uncover the last image of a program that hangs.
            weston.focus(1);
            weston.screen.press(ESCAPE);
            sleep(Duration::from_millis(500));
            assert!(monitor.is_black(), "{}", window.log_text());
        }
        signal("CONT", window.process.0.id());
        monitor.wait_for_pattern(&window);
    }
    let child = child_of(&window);
    let status = monitor.press_until("the end by a key", LETTER_Q, || window.process.0.try_wait().unwrap());
    assert!(status.success(), "{}", window.log_text());
    wait_for_end(child);
    assert!(!monitor.is_black(), "the desktop is back");
}

#[test]
fn a_stopped_program_is_covered_by_black_until_it_goes_on_without_a_window_manager() {
    stopped(&Guarded::on_x11(false));
}

#[test]
fn a_stopped_program_is_covered_by_black_until_it_goes_on_under_openbox() {
    stopped(&Guarded::on_x11(true));
}

#[test]
fn a_stopped_program_is_covered_by_black_until_it_goes_on_on_weston() {
    stopped(&Guarded::on_weston());
}

fn killed(monitor: &Guarded) {
    let mut window = monitor.show();
    monitor.wait_for_pattern(&window);
    let child = child_of(&window);
    window.process.0.kill().unwrap();
    window.process.0.wait().unwrap();
    monitor.stays_black(&window);
    assert!(is_running(child));

    let mut successor = monitor.show();
    monitor.wait_for_pattern(&successor);
    wait_for_end(child);
    assert!(monitor.has_pattern());
    let status = monitor.press_until("the end by a key", LETTER_Q, || successor.process.0.try_wait().unwrap());
    assert!(status.success(), "{}", successor.log_text());
}

#[test]
fn a_killed_program_leaves_black_which_its_successor_covers_without_a_window_manager() {
    killed(&Guarded::on_x11(false));
}

#[test]
fn a_killed_program_leaves_black_which_its_successor_covers_under_openbox() {
    killed(&Guarded::on_x11(true));
}

#[test]
fn a_killed_program_leaves_black_which_its_successor_covers_on_weston() {
    killed(&Guarded::on_weston());
}

fn escape(monitor: &Guarded) {
    let mut window = monitor.show();
    monitor.wait_for_pattern(&window);
    let child = child_of(&window);
    window.process.0.kill().unwrap();
    window.process.0.wait().unwrap();
    monitor.stays_black(&window);
    monitor.press_until("the black window's end", ESCAPE, || (!is_running(child)).then_some(()));
    wait_for("the desktop", || (!monitor.is_black()).then_some(()));
}

#[test]
fn escape_ends_the_black_window_of_a_killed_program_without_a_window_manager() {
    escape(&Guarded::on_x11(false));
}

#[test]
fn escape_ends_the_black_window_of_a_killed_program_under_openbox() {
    escape(&Guarded::on_x11(true));
}

#[test]
fn escape_ends_the_black_window_of_a_killed_program_on_weston() {
    escape(&Guarded::on_weston());
}

#[test]
fn a_black_window_that_dies_is_an_error_and_the_image_stays() {
    let monitor = Guarded::on_x11(true);
    let window = monitor.show();
    monitor.wait_for_pattern(&window);
    signal("KILL", child_of(&window));
    wait_for("the error", || {
        window.log_text().contains("ERROR: the test pattern: the dead-man's switch").then_some(())
    });
    assert!(monitor.has_pattern());
}

#[test]
fn black_windows_end_with_their_x_server() {
    let mut monitor = Guarded::on_x11(false);
    let (mut killed, other) = (monitor.show(), Guarded::on_x11(false));
    monitor.wait_for_pattern(&killed);
    let window = other.show();
    other.wait_for_pattern(&window);
    let children = [child_of(&killed), child_of(&window)];
    killed.process.0.kill().unwrap();
    killed.process.0.wait().unwrap();
    monitor.stays_black(&killed);
    for mut screen in [monitor.screen.take(), other.screen].into_iter().flatten() {
        screen.stop();
    }
    children.into_iter().for_each(wait_for_end);
}

#[test]
fn a_monitor_that_comes_back_shows_the_image_above_black() {
    for with_manager in [false, true] {
        let screen = Screen::start(with_manager);
        screen.xrandr(&["--setmonitor", "wall", "640/160x400/100+320+200", "none"]);
        let arguments = [&["640x400", "--monitor", "wall"][..], &ARGUMENTS].concat();
        let window = screen.show(&arguments);
        let (place, size) = ((320, 200), (640, 400));
        wait_for("the image", || (screen.corners(place, size) == pattern_corners(size)).then_some(()));
        let first = child_of(&window);
        screen.xrandr(&["--delmonitor", "wall"]);
        wait_for("the warning", || window.log_text().contains("wall 640x400+320+200 virtual is gone").then_some(()));
        screen.xrandr(&["--setmonitor", "wall", "640/160x400/100+100+50", "none"]);
        wait_for_end(first);
        wait_for("the image", || (screen.corners((100, 50), size) == pattern_corners(size)).then_some(()));
        sleep(Duration::from_millis(500));
        assert!(screen.corners((100, 50), size) == pattern_corners(size), "{}", window.log_text());
        signal("STOP", window.process.0.id());
        let is_black = || screen.pixels_at((100, 50), size).iter().all(|pixel| *pixel == 0);
        wait_for("black", || is_black().then_some(()));
    }
}
