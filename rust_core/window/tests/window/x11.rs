//! The window on an X server of one monitor: Xvfb, with and without a window manager.

use std::process::Command;
use std::time::{Duration, Instant};

use x11rb::protocol::screensaver::{ConnectionExt as _, State};
use x11rb::protocol::xproto::{Blanking, ConnectionExt as _, Exposures};

use crate::screen::*;

fn covers_the_screen_and_quits(with_manager: bool, key: u32) {
    let screen = Screen::start(with_manager);
    let folder = tempfile::tempdir().unwrap();
    let screenshot = folder.path().join("shown.png");
    let mut window = screen.show(&["1280x800", "--screenshot", screenshot.to_str().unwrap()]);
    let image = expected(1280, 800);
    screen.wait_for_pixels(&mut window, &image);

    let saved = wait_for("the screenshot", || image::open(&screenshot).ok()).into_rgb8();
    assert_eq!(saved.dimensions(), (WIDTH_PX, HEIGHT_PX));
    let saved: Vec<u32> = saved.pixels().map(|p| u32::from_be_bytes([0, p[0], p[1], p[2]])).collect();
    assert!(saved == image, "the screenshot is the picture");

    assert!(screen.quit(&mut window, key).success());
}

#[test]
fn under_a_window_manager_the_screen_is_the_image_and_escape_quits() {
    covers_the_screen_and_quits(true, ESCAPE);
}

#[test]
fn without_a_window_manager_the_screen_is_the_image_and_q_quits() {
    covers_the_screen_and_quits(false, LETTER_Q);
}

#[test]
fn a_screen_without_randr_is_one_monitor() {
    for with_manager in [false, true] {
        let arguments = ["-screen", "0", "1280x800x24", "-extension", "RANDR", "-extension", "XINERAMA"];
        let screen = Screen::start_with(with_manager, &arguments);
        let mut window = screen.show(&["1280x800"]);
        screen.wait_for_pixels(&mut window, &expected(1280, 800));
        assert!(window.log_text().contains("screen 1280x800+0+0 primary"), "{}", window.log_text());
        assert!(screen.quit(&mut window, ESCAPE).success());
    }
}

#[test]
fn a_screen_of_ten_bits_a_channel_shows_the_images_colours_with_and_without_shared_memory() {
    for extension in [&[][..], &["-extension", "MIT-SHM"]] {
        let arguments = [&["-screen", "0", "1280x800x30"], extension].concat();
        let screen = Screen::start_with(false, &arguments);
        let mut window = screen.show(&["1280x800"]);
        screen.wait_for_pixels(&mut window, &expected(1280, 800));
        assert!(screen.quit(&mut window, LETTER_Q).success());
    }
}

#[test]
fn a_screen_whose_colours_do_not_fit_is_an_error_that_says_what_to_use() {
    let screen = Screen::start_with(false, &["-screen", "0", "1280x800x16"]);
    let mut window = screen.show(&["1280x800"]);
    let status = wait_for("the program's end", || window.process.0.try_wait().unwrap());
    assert_eq!(status.code(), Some(1));
    assert!(window.log_text().contains("has depth 16; use one of depth 24 or 30"), "{}", window.log_text());
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
    wait_for("no refresh of a virtual screen", || window.log_text().contains("refreshed every None").then_some(()));
    assert!(screen.quit(&mut window, ESCAPE).success());
    let log = window.log_text();
    let first = log.lines().position(|line| line.contains("opened on screen 1280x800+0+0"));
    assert!(first.is_some() && first < log.lines().position(|line| line.contains("key ")), "{log}");
}

#[test]
fn a_image_of_another_size_is_unscaled_at_the_top_left_and_warned_about_once() {
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
    assert!(message.contains("DISPLAY is not set, nor is WAYLAND_DISPLAY"), "{message}");
    assert_eq!(message.matches("DISPLAY").count(), 2, "{message}");
}

#[test]
fn a_key_that_is_held_down_is_told_from_one_that_is_pressed_again() {
    let screen = Screen::start(true);
    let mut window = screen.show(&["1280x800"]);
    screen.wait_for_pixels(&mut window, &expected(1280, 800));
    wait_for("the keyboard", || {
        screen.press(SPACE);
        window.log_text().contains("key Space").then_some(())
    });
    screen.hold(LETTER_N, || {
        wait_for("repetitions", || (window.log_text().matches("key Character('n') again").count() > 3).then_some(()));
    });
    assert_eq!(window.log_text().matches("key Character('n')\n").count(), 1, "{}", window.log_text());
    screen.press(LETTER_B);
    screen.wait_for_pixels(&mut window, &expected(0, 0));
    assert!(screen.quit(&mut window, ESCAPE).success());
}

#[test]
fn the_window_becomes_black_when_its_grant_ends() {
    let screen = Screen::start(true);
    let mut window = screen.show(&["1280x800", "--limit", "2"]);
    screen.wait_for_pixels(&mut window, &expected(1280, 800));
    wait_for("the warning", || window.log_text().contains("no picture in time: the window is black").then_some(()));
    screen.wait_for_pixels(&mut window, &expected(0, 0));
    assert!(screen.quit(&mut window, ESCAPE).success());
}

#[test]
fn the_screen_saver_stays_off_while_the_window_is_open() {
    let screen = Screen::start(true);
    screen.connection.set_screen_saver(1, 1, Blanking::PREFERRED, Exposures::DEFAULT).unwrap().check().unwrap();
    let is_on = || {
        let info = screen.connection.screensaver_query_info(screen.root).unwrap().reply().unwrap();
        info.state == u8::from(State::ON)
    };
    wait_for("the screen saver without the window", || is_on().then_some(()));
    let mut window = screen.show(&["1280x800"]);
    wait_for("the screen saver's end", || (!is_on()).then_some(()));
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(3) {
        assert!(!is_on());
        std::thread::sleep(Duration::from_millis(100));
    }
    assert!(screen.quit(&mut window, ESCAPE).success());
}

#[test]
fn the_x_servers_end_is_one_line() {
    let mut screen = Screen::start(false);
    let mut window = screen.show(&["1280x800"]);
    screen.wait_for_pixels(&mut window, &expected(1280, 800));
    screen.stop();
    let status = wait_for("the program's end", || window.process.0.try_wait().unwrap());
    assert_eq!(status.code(), Some(1));
    let log = window.log_text();
    let last: Vec<_> = log.lines().filter(|line| line.contains("gone")).collect();
    assert!(last.len() == 1 && last[0].contains(&screen.display), "{log}");
    assert!(!log.contains("XIO"), "{log}");
}
