//! The window on an X server with two monitors that come, go and change their modes: Xorg with the driver `dummy`.

use std::fs;
use std::process::Command;

use crate::screen::*;

/// Xorg's configuration. The first output is on, the second can be switched on.
const CONFIG: &str = r#"
Section "ServerFlags"
  Option "AutoAddDevices" "false"
  Option "AutoAddGPU" "false"
  Option "DontVTSwitch" "true"
EndSection
Section "Device"
  Identifier "card"
  Driver "dummy"
  VideoRam 65536
EndSection
Section "Monitor"
  Identifier "any"
  HorizSync 5-1000
  VertRefresh 5-200
EndSection
Section "Screen"
  Identifier "screen"
  Device "card"
  Monitor "any"
  DefaultDepth 24
  SubSection "Display"
    Depth 24
    Modes "800x600"
  EndSubSection
EndSection
"#;

/// The first monitor's size, and the second's in its native mode: the configuration gives all outputs the same.
const NATIVE: (u32, u32) = (800, 600);

struct TwoMonitors {
    screen: Screen,
    _folder: tempfile::TempDir,
}

impl TwoMonitors {
    /// Two monitors beside each other, the second in this mode.
    fn start(with_manager: bool, mode: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let config = folder.path().join("xorg.conf");
        fs::write(&config, CONFIG).unwrap();
        let mut command = Command::new("Xorg");
        command.args(["-noreset", "-novtswitch", "-sharevts", "-config"]).arg(&config);
        command.arg("-logfile").arg(folder.path().join("log"));
        let screen = Screen::start_server(with_manager, &mut command);
        screen.xrandr(&["--addmode", "DUMMY1", mode]);
        screen.xrandr(&["--output", "DUMMY1", "--mode", mode, "--right-of", "DUMMY0"]);
        // Asked without arguments, the server looks at its outputs again, as it does when a cable is plugged in.
        screen.xrandr(&[]);
        Self { screen, _folder: folder }
    }

    /// The corners of a part of the desktop.
    fn corners(&self, left: i16, (width, height): (u32, u32)) -> [u32; 4] {
        let pixels = self.screen.pixels_at((left, 0), (width, height));
        [(0, 0), (width - 1, 0), (0, height - 1), (width - 1, height - 1)]
            .map(|(u, v)| pixels[(v * width + u) as usize])
    }

    fn wait_for_pattern(&self, window: &Shown, left: i16, size: (u32, u32)) {
        let mut last = [0; 4];
        let start = std::time::Instant::now();
        while last != pattern_corners(size) {
            assert!(start.elapsed() < PATIENCE, "{last:x?} {:#?} {}", self.screen.windows(), window.log_text());
            std::thread::sleep(std::time::Duration::from_millis(50));
            last = self.corners(left, size);
        }
    }
}

#[test]
fn the_window_covers_the_second_monitor_and_comes_back_to_it() {
    for with_manager in [false, true] {
        let monitors = TwoMonitors::start(with_manager, "640x480");
        let screen = &monitors.screen;
        let before = monitors.corners(0, NATIVE);
        let mut window = screen.show(&["640x480"]);
        monitors.wait_for_pattern(&window, 800, (640, 480));
        assert_eq!(monitors.corners(0, NATIVE), before, "the first monitor is not touched");

        screen.xrandr(&["--output", "DUMMY1", "--off"]);
        wait_for("the warning", || window.log_text().contains("DUMMY1 640x480+800+0 is gone").then_some(()));
        wait_for("the window to be off the screen", || {
            let is_shown = |line: &String| line.contains("640x480") && line.contains("VIEWABLE");
            (!screen.windows().iter().any(is_shown) && monitors.corners(0, NATIVE) == before).then_some(())
        });

        screen.xrandr(&["--output", "DUMMY1", "--mode", "640x480", "--left-of", "DUMMY0"]);
        wait_for("the return", || window.log_text().contains("DUMMY1 640x480+0+0 is back").then_some(()));
        monitors.wait_for_pattern(&window, 0, (640, 480));
        assert!(screen.quit(&mut window, ESCAPE).success(), "{}", window.log_text());
    }
}

#[test]
fn a_monitor_that_moves_takes_the_window_with_it() {
    let monitors = TwoMonitors::start(true, "640x480");
    let mut window = monitors.screen.show(&["640x480", "--monitor", "DUMMY1"]);
    monitors.wait_for_pattern(&window, 800, (640, 480));
    monitors.screen.xrandr(&["--output", "DUMMY0", "--pos", "640x0", "--output", "DUMMY1", "--pos", "0x0"]);
    monitors.wait_for_pattern(&window, 0, (640, 480));
    assert!(monitors.screen.quit(&mut window, ESCAPE).success());
}

#[test]
fn another_mode_than_the_native_one_is_warned_about_and_set_only_on_request() {
    let monitors = TwoMonitors::start(true, "640x480");
    let screen = &monitors.screen;
    let mut window = screen.show(&["800x600"]);
    let warning = "MONITOR DUMMY1 RUNS 640x480, ITS NATIVE MODE IS 800x600";
    wait_for("the warning", || window.log_text().contains(warning).then_some(()));
    monitors.wait_for_pattern(&window, 800, (640, 480));
    assert!(screen.quit(&mut window, ESCAPE).success());
    assert_eq!(window.log_text().matches(warning).count(), 1);

    let mut window = screen.show(&["800x600", "--set-mode", "yes"]);
    monitors.wait_for_pattern(&window, 800, NATIVE);
    let log = window.log_text();
    assert!(log.contains("DUMMY1 is set from 640x480 to its native mode 800x600") && !log.contains(warning), "{log}");
    assert!(screen.quit(&mut window, ESCAPE).success());
}

#[test]
fn an_interlaced_mode_of_the_native_size_is_warned_about_and_replaced_on_request() {
    let monitors = TwoMonitors::start(true, "800x600");
    let screen = &monitors.screen;
    let timing = "40 800 840 968 1056 600 601 605 628 +hsync +vsync interlace".split_whitespace();
    screen.xrandr(&["--newmode", "800x600i"].into_iter().chain(timing).collect::<Vec<_>>());
    screen.xrandr(&["--addmode", "DUMMY1", "800x600i"]);
    screen.xrandr(&["--output", "DUMMY1", "--mode", "800x600i"]);
    let mut window = screen.show(&["800x600"]);
    let warning = "MONITOR DUMMY1 RUNS 800x600 interlaced, ITS NATIVE MODE IS 800x600:";
    wait_for("the warning", || window.log_text().contains(warning).then_some(()));
    assert!(screen.quit(&mut window, ESCAPE).success());
    let mut window = screen.show(&["800x600", "--set-mode", "yes"]);
    let set = "DUMMY1 is set from 800x600 interlaced to its native mode 800x600";
    wait_for("the mode to be set", || window.log_text().contains(set).then_some(()));
    assert!(!window.log_text().contains(warning), "{}", window.log_text());
    assert!(screen.quit(&mut window, ESCAPE).success());
}

#[test]
fn the_refresh_of_a_monitor_is_known() {
    let monitors = TwoMonitors::start(true, "800x600");
    let mut window = monitors.screen.show(&["800x600"]);
    let period = wait_for("the refresh", || {
        let log = window.log_text();
        let text = log.split("refreshed every Some(").nth(1)?.split("ms").next()?.to_owned();
        text.parse::<f64>().ok()
    });
    // The mode's own rate, or the server's count where both are near each other.
    assert!((11.0..19.0).contains(&period), "{period} ms");
    assert!(monitors.screen.quit(&mut window, ESCAPE).success());
}

#[test]
fn each_monitor_shows_which_one_it_is() {
    let monitors = TwoMonitors::start(true, "800x600");
    let mut window = monitors.screen.show(&["1x1", "--identify", "60"]);
    let part = |left| monitors.screen.pixels_at((left, 0), NATIVE);
    wait_for("both monitors", || {
        let (first, second) = (part(0), part(800));
        // A frame around both, and other texts.
        let is_framed = |pixels: &[u32]| [pixels[0], pixels[800 * 600 - 1]] == [0x00ff_ffff; 2];
        (is_framed(&first) && is_framed(&second) && first != second).then_some(())
    });
    save(&monitors.screen, "identify.png");
    wait_for("a key to end one, and the other", || {
        monitors.screen.press(ESCAPE);
        window.process.0.try_wait().unwrap()
    });
}

#[test]
fn another_programs_window_is_kept_over_the_monitor() {
    for with_manager in [false, true] {
        let monitors = TwoMonitors::start(with_manager, "640x480");
        let screen = &monitors.screen;
        let keeper = screen.show(&["1x1", "--keep", "a viewer", "--monitor", "DUMMY1"]);
        let window = screen.plain_window("a viewer", (300, 200));
        let is_there =
            |place: &str| screen.windows().iter().any(|line| line.contains(place) && line.contains("VIEWABLE"));
        let wait = |place: &str, place_px: (i16, i16), what: &str| {
            let start = std::time::Instant::now();
            while screen.place_of(window) != (place_px, (640, 480)) {
                assert!(start.elapsed() < PATIENCE, "{what} {place}: {:#?} {}", screen.windows(), keeper.log_text());
                std::thread::sleep(std::time::Duration::from_millis(50));
            }
        };
        wait("640x480+800+0", (800, 0), "placed");
        assert!(is_there("640x480"));
        screen.move_window(window, (10, 10), (200, 100));
        wait("640x480+800+0", (800, 0), "placed again");
        screen.xrandr(&["--output", "DUMMY0", "--pos", "640x0", "--output", "DUMMY1", "--pos", "0x0"]);
        wait("640x480+0+0", (0, 0), "moved with its monitor");
    }
}

/// Saves the desktop where the environment asks for that.
fn save(screen: &Screen, name: &str) {
    let Some(folder) = std::env::var_os("RCS_SCREENSHOTS") else { return };
    let pixels = screen.pixels_at((0, 0), (1600, 600));
    let image = image::RgbImage::from_fn(1600, 600, |u, v| {
        let [_, r, g, b] = pixels[(v * 1600 + u) as usize].to_be_bytes();
        image::Rgb([r, g, b])
    });
    image.save(std::path::Path::new(&folder).join(name)).unwrap();
}
