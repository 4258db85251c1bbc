//! Checks of the projector's monitor, the window over it, and the display server.

use std::sync::mpsc::sync_channel;
use std::time::Duration;

use rcs_window::{inspect_monitor, list_monitors, MonitorChoice, MonitorInfo, MonitorReport, WindowPlace};

use super::finding::{check_name, Finding};
use super::viewer::Viewer;
use super::windows::Windows;

/// Time in which a display server answers.
const PATIENCE: Duration = Duration::from_secs(5);

/// Answer of the display server.
struct Screen {
    monitors: Vec<MonitorInfo>,
    /// The chosen monitor of each window, with its report, or why there is none.
    chosen: Vec<Result<(MonitorInfo, MonitorReport), String>>,
}

/// Monitor, window and display server, for images of this size, if that is known.
pub(super) fn all(windows: &Windows, image_px: Option<[u32; 2]>) -> Vec<Finding> {
    if windows.viewer == Viewer::None {
        let no_window = |name| Finding::unknown(name, "no window is asked for (viewer:=none, no --window)", "");
        return ["monitor", "window", "display server"].map(no_window).into();
    }
    if let Some((node, host)) = &windows.elsewhere {
        let text = format!("{node} runs on {host}");
        let remote = |name| Finding::unknown(name, text.clone(), format!("run camera_stream doctor on {host} for it"));
        return ["monitor", "window", "display server"].map(remote).into();
    }
    let environment = Environment::of_process();
    match asked(windows) {
        Ok(screen) => {
            let of_each = screen.chosen.iter().flat_map(|chosen| {
                let name = |check: &str| match chosen {
                    Ok((monitor, _)) => check_name(check, &monitor.name, screen.chosen.len()),
                    Err(_) => check.to_owned(),
                };
                [monitor(name("monitor"), chosen, &screen.monitors, image_px), window(name("window"), chosen)]
            });
            of_each.chain([Finding::good("display server", environment.text())]).collect()
        }
        Err(reason) => {
            let unknown = |name| Finding::unknown(name, "the display server cannot be asked", "");
            vec![unknown("monitor"), unknown("window"), environment.unreachable(&reason)]
        }
    }
}

/// Asks the display server, which may hang: on a thread of its own.
fn asked(windows: &Windows) -> Result<Screen, String> {
    let (choices, title) = (windows.monitors.clone(), windows.title());
    let (answer, answered) = sync_channel(1);
    let asking = move || {
        // Fails if that took too long and the caller went on.
        let _ = answer.send(ask(&choices, title));
    };
    let spawned = std::thread::Builder::new().name("screen".to_owned()).spawn(asking);
    spawned.map_err(|error| error.to_string())?;
    let silent = |_| format!("no answer in {} s", PATIENCE.as_secs());
    answered.recv_timeout(PATIENCE).map_err(silent)?
}

fn ask(choices: &[MonitorChoice], title: Option<&str>) -> Result<Screen, String> {
    let monitors = list_monitors().map_err(|error| error.to_string())?;
    let report = |choice: &MonitorChoice| {
        let index = choice.resolve(&monitors).map_err(|error| error.to_string())?;
        let monitor = monitors.get(index).cloned().ok_or("no such monitor")?;
        let report = inspect_monitor(&monitor, title).map_err(|error| error.to_string())?;
        Ok((monitor, report))
    };
    let chosen = choices.iter().map(report).collect();
    Ok(Screen { monitors, chosen })
}

/// The variables that name the display server.
struct Environment {
    display: Option<String>,
    wayland: Option<String>,
    authority: Option<String>,
    user: Option<String>,
}

impl Environment {
    fn of_process() -> Self {
        let variable = |name: &str| std::env::var(name).ok().filter(|value| !value.is_empty());
        let [display, wayland, authority, user] = ["DISPLAY", "WAYLAND_DISPLAY", "XAUTHORITY", "USER"].map(variable);
        Self { display, wayland, authority, user }
    }

    fn text(&self) -> String {
        match (&self.wayland, &self.display, &self.authority) {
            (Some(wayland), ..) => format!("WAYLAND_DISPLAY is {wayland}"),
            (None, Some(display), Some(authority)) => format!("DISPLAY is {display}, XAUTHORITY {authority}"),
            (None, Some(display), None) => format!("DISPLAY is {display}"),
            (None, None, _) => "DISPLAY is not set".to_owned(),
        }
    }

    /// The fault that no display server is reached.
    fn unreachable(&self, reason: &str) -> Finding {
        let export =
            "export DISPLAY=:0 XAUTHORITY=$HOME/.Xauthority before roslaunch (the values of the desktop's session)";
        if self.display.is_none() && self.wayland.is_none() {
            return Finding::bad("display server", self.text(), export);
        }
        let user = self.user.as_deref().unwrap_or("USER");
        let advice = format!("{export}, or run xhost +si:localuser:{user} in that session");
        Finding::bad("display server", reason, advice)
    }
}

/// The monitor: there, in its native mode, of the image's size, beside the others and not the primary one.
fn monitor(
    name: String,
    chosen: &Result<(MonitorInfo, MonitorReport), String>,
    all: &[MonitorInfo],
    image_px: Option<[u32; 2]>,
) -> Finding {
    let (monitor, report) = match chosen {
        Ok(chosen) => chosen,
        Err(reason) => return Finding::bad(name, reason, "set monitor:=NAME (--window NAME) to one that is there"),
    };
    let faults = faults(monitor, report, all, image_px);
    if !faults.is_empty() {
        let (texts, advice): (Vec<String>, Vec<String>) = faults.into_iter().unzip();
        return Finding::bad(name, format!("{monitor}: {}", texts.join(", ")), advice.join("; "));
    }
    if all.iter().filter(|other| !other.is_virtual).count() == 1 && !monitor.is_virtual {
        let text = format!("{monitor}: the only monitor");
        let advice = format!(
            "if it is not the projector, connect that and extend the desktop: {}",
            beside("PROJECTOR", monitor)
        );
        return Finding::unknown(name, text, advice);
    }
    Finding::good(name, monitor.to_string())
}

/// The command that extends a desktop.
fn beside(name: &str, other: &MonitorInfo) -> String {
    format!("xrandr --output {name} --auto --right-of {}", other.name)
}

/// Faults of a monitor, and advice.
fn faults(
    monitor: &MonitorInfo,
    report: &MonitorReport,
    all: &[MonitorInfo],
    image_px: Option<[u32; 2]>,
) -> Vec<(String, String)> {
    let MonitorInfo { name, size_px: (width, height), .. } = monitor;
    let others: Vec<&MonitorInfo> =
        all.iter().filter(|other| other.name != *name && !other.is_virtual && !monitor.is_virtual).collect();
    let mut faults = Vec::new();
    if let Some([native, current]) = report.other_mode {
        let text = format!("runs {current}, not each pixel as one, its native mode is {native}");
        faults.push((text, format!("set_mode:=true (--set-mode), or xrandr --output {name} --mode {native}")));
    }
    if report.is_scaled {
        faults.push(("the X server scales it".to_owned(), format!("xrandr --output {name} --scale 1")));
    }
    if let Some(other) = others.iter().find(|other| overlap(monitor, other)) {
        faults.push((format!("shows the same as {}", other.name), beside(name, other)));
    }
    if let (true, Some(other)) = (monitor.is_primary, others.first()) {
        let text = "is the primary monitor, which shows the desktop's panels".to_owned();
        faults.push((text, format!("xrandr --output {} --primary, or monitor:={}", other.name, other.name)));
    }
    if let Some([image_width, image_height]) = image_px.filter(|size_px| *size_px != [*width, *height]) {
        let text = format!("the image is {image_width}x{image_height}, not pixel for pixel");
        let advice = "set that mode, or write the monitor's size into the projector's file and calibrate again";
        faults.push((text, advice.to_owned()));
    }
    faults
}

/// `true` if two monitors show a part of the desktop both.
fn overlap(a: &MonitorInfo, b: &MonitorInfo) -> bool {
    let is_apart = |a_from: i32, a_len: u32, b_from: i32, b_len: u32| {
        i64::from(a_from) + i64::from(a_len) <= i64::from(b_from)
            || i64::from(b_from) + i64::from(b_len) <= i64::from(a_from)
    };
    let ((ax, ay), (aw, ah)) = (a.position_px, a.size_px);
    let ((bx, by), (bw, bh)) = (b.position_px, b.size_px);
    !is_apart(ax, aw, bx, bw) && !is_apart(ay, ah, by, bh)
}

/// The window over the monitor.
fn window(name: String, chosen: &Result<(MonitorInfo, MonitorReport), String>) -> Finding {
    let Ok((monitor, report)) = chosen else {
        return Finding::unknown(name, "without its monitor there is no window", "");
    };
    match &report.window {
        WindowPlace::Over => Finding::good(name, format!("over {}", monitor.name)),
        WindowPlace::Elsewhere(place) => {
            let text = format!("it is at {place}, the monitor {monitor}");
            Finding::bad(name, text, "close what moves it; its node's log says why it does not cover the monitor")
        }
        WindowPlace::Missing => {
            let text = format!("none over {}", monitor.name);
            Finding::bad(
                name,
                text,
                "start the launch file, or see the viewer's log: each program says why it has no window",
            )
        }
        WindowPlace::Unknown => {
            Finding::unknown(name, "Wayland does not tell", "look at the projector: t shows a test picture")
        }
    }
}

#[cfg(test)]
mod tests {
    use rcs_window::{MonitorMode, Scan};

    use super::*;

    fn info(name: &str, x: i32, is_primary: bool) -> MonitorInfo {
        MonitorInfo { name: name.to_owned(), position_px: (x, 0), size_px: (1280, 800), is_primary, is_virtual: false }
    }

    fn line(chosen: &MonitorInfo, report: MonitorReport, all: &[MonitorInfo], image_px: Option<[u32; 2]>) -> String {
        monitor("monitor".to_owned(), &Ok((chosen.clone(), report)), all, image_px).to_string()
    }

    #[test]
    fn a_projector_beside_the_primary_monitor_is_well() {
        let all = [info("eDP-1", 0, true), info("HDMI-1", 1280, false)];
        let (size_px, report) = (Some([1280, 800]), MonitorReport::default());
        assert_eq!(line(&all[1], report.clone(), &all, size_px), "✓ monitor: HDMI-1 1280x800+1280+0");
        let primary = line(&all[0], report.clone(), &all, size_px);
        let expected =
            "✗ monitor: eDP-1 1280x800+0+0 primary: is the primary monitor, which shows the desktop's panels; xrandr \
                        --output HDMI-1 --primary, or monitor:=HDMI-1";
        assert_eq!(primary, expected);
        let only = line(&all[0], report.clone(), &all[..1], size_px);
        assert!(
            only.starts_with("? monitor: eDP-1 1280x800+0+0 primary: the only monitor; if it is not the proj"),
            "{only}"
        );
        let mirrored = [info("eDP-1", 0, true), info("HDMI-1", 0, false)];
        let mirrored = line(&mirrored[1], report, &mirrored, size_px);
        assert!(
            mirrored.ends_with("shows the same as eDP-1; xrandr --output HDMI-1 --auto --right-of eDP-1"),
            "{mirrored}"
        );
    }

    #[test]
    fn a_monitor_that_scales_or_has_another_size_is_a_fault() {
        let all = [info("eDP-1", 0, true), info("HDMI-1", 1280, false)];
        let mode = |width, height, scan| MonitorMode { size_px: (width, height), scan };
        let modes = [mode(1280, 800, Scan::Progressive), mode(1024, 768, Scan::Interlaced)];
        let report = MonitorReport { other_mode: Some(modes), ..MonitorReport::default() };
        let other_mode = line(&all[1], report, &all, None);
        let expected =
            "✗ monitor: HDMI-1 1280x800+1280+0: runs 1024x768 interlaced, not each pixel as one, its native mode is \
                        1280x800; set_mode:=true (--set-mode), or xrandr --output HDMI-1 --mode 1280x800";
        assert_eq!(other_mode, expected);
        let scaled = MonitorReport { is_scaled: true, ..MonitorReport::default() };
        assert!(line(&all[1], scaled, &all, None).ends_with("scales it; xrandr --output HDMI-1 --scale 1"));
        let other_size = line(&all[1], MonitorReport::default(), &all, Some([640, 360]));
        assert!(other_size.contains("the image is 640x360, not pixel for pixel; "), "{other_size}");
        let unknown = Err("no monitor 'VGA-1'; monitors: 0: eDP-1".to_owned());
        let absent = monitor("monitor".to_owned(), &unknown, &all, None).to_string();
        assert!(absent.starts_with("✗ monitor: no monitor 'VGA-1'; monitors: 0: eDP-1; set monitor:=NAME"), "{absent}");
        assert!(window("window".to_owned(), &unknown).to_string().starts_with("? window: "));
    }

    #[test]
    fn the_window_covers_the_monitor_or_not() {
        let line = |place: WindowPlace| {
            let report = MonitorReport { window: place, ..MonitorReport::default() };
            window("window".to_owned(), &Ok((info("HDMI-1", 0, false), report))).to_string()
        };
        assert_eq!(line(WindowPlace::Over), "✓ window: over HDMI-1");
        assert!(line(WindowPlace::Missing).starts_with("✗ window: none over HDMI-1; start the launch file"));
        let elsewhere = line(WindowPlace::Elsewhere("200x150+30+30".to_owned()));
        assert!(elsewhere.starts_with("✗ window: it is at 200x150+30+30, the monitor HDMI-1 1280x800+0+0; "));
        assert!(line(WindowPlace::Unknown).starts_with("? window: "));
    }

    #[test]
    fn without_a_display_the_advice_is_to_name_or_to_open_it() {
        let environment = |display: Option<&str>| Environment {
            display: display.map(str::to_owned),
            wayland: None,
            authority: None,
            user: Some("robot".to_owned()),
        };
        let none = environment(None).unreachable("x").to_string();
        assert!(none.starts_with("✗ display server: DISPLAY is not set; export DISPLAY=:0 XAUTHORITY="), "{none}");
        let refused = environment(Some(":0")).unreachable("no window: DISPLAY :0: refused").to_string();
        assert!(refused.starts_with("✗ display server: no window: DISPLAY :0: refused; export"), "{refused}");
        assert!(refused.ends_with("or run xhost +si:localuser:robot in that session"), "{refused}");
        assert_eq!(environment(Some(":0")).text(), "DISPLAY is :0");
    }
}
