//! A monitor's mode, compared with its native one: only the native mode shows each pixel as one.
//!
//! The native size is that of the first of RandR's list, which begins with the preferred modes (X RandR 1.5,
//! RRGetOutputInfo), or the current one where none is preferred. The native mode is the first of that size that is
//! neither interlaced nor doubled.

use std::time::Duration;

use x11rb::protocol::randr::{
    ConnectionExt as _, Crtc, GetCrtcInfoReply, GetOutputInfoReply, ModeFlag, ModeInfo, Rotation, SetConfig,
};
use x11rb::protocol::render::Transform;
use x11rb::protocol::xproto::ConnectionExt as _;
use x11rb::CURRENT_TIME;

use super::session::X11Session;
use crate::report::{MonitorMode, Scan};

/// The number 1 in RENDER's fixed-point format.
const ONE: i32 = 1 << 16;
/// The identity matrix, row by row.
const IDENTITY: [i32; 9] = [ONE, 0, 0, 0, ONE, 0, 0, 0, ONE];

fn elements(t: &Transform) -> [i32; 9] {
    [t.matrix11, t.matrix12, t.matrix13, t.matrix21, t.matrix22, t.matrix23, t.matrix31, t.matrix32, t.matrix33]
}

/// Option and state of checking a monitor's mode.
pub(super) struct ModeCheck {
    /// `true` to set the native mode.
    pub(super) set_mode: bool,
    pub(super) last_warning: Option<String>,
}

/// The modes of an output that is on.
pub(super) struct OutputModes {
    crtc: Crtc,
    state: GetCrtcInfoReply,
    native: ModeInfo,
    current: ModeInfo,
    /// `true` if the server scales the output.
    pub(super) is_scaled: bool,
}

impl OutputModes {
    /// `true` if the output runs its native mode.
    pub(super) fn is_native(&self) -> bool {
        let [native, current] = self.native_and_current();
        native == current
    }

    /// The native and the current mode.
    pub(super) fn native_and_current(&self) -> [MonitorMode; 2] {
        [described(&self.native), described(&self.current)]
    }

    /// Time between two refreshes of the current mode; `None` for a screen without refresh.
    pub(super) fn refresh_period(&self) -> Option<Duration> {
        refresh_period(&self.current)
    }

    /// Width and height of the native mode as the monitor stands, pixels.
    fn turned_size_px(&self) -> (i32, i32) {
        let (width, height) = (i32::from(self.native.width), i32::from(self.native.height));
        let is_turned = self.state.rotation.intersects(Rotation::ROTATE90 | Rotation::ROTATE270);
        if is_turned {
            (height, width)
        } else {
            (width, height)
        }
    }
}

fn described(mode: &ModeInfo) -> MonitorMode {
    let scan = if mode.mode_flags.contains(ModeFlag::INTERLACE) {
        Scan::Interlaced
    } else if mode.mode_flags.contains(ModeFlag::DOUBLE_SCAN) {
        Scan::Doubled
    } else {
        Scan::Progressive
    };
    MonitorMode { size_px: (mode.width.into(), mode.height.into()), scan }
}

fn refresh_period(mode: &ModeInfo) -> Option<Duration> {
    let lines = match described(mode).scan {
        Scan::Progressive => f64::from(mode.vtotal),
        Scan::Interlaced => f64::from(mode.vtotal) / 2.0,
        Scan::Doubled => f64::from(mode.vtotal) * 2.0,
    };
    let pixels = f64::from(mode.htotal) * lines;
    (mode.dot_clock > 0 && pixels > 0.0).then(|| Duration::from_secs_f64(pixels / f64::from(mode.dot_clock)))
}

/// The native one of an output's modes, of which the first `preferred_count` are preferred.
fn native(modes: &[ModeInfo], preferred_count: u16, current: &ModeInfo) -> ModeInfo {
    let preferred = if preferred_count > 0 { modes.first().unwrap_or(current) } else { current };
    let wanted = MonitorMode { scan: Scan::Progressive, ..described(preferred) };
    *modes.iter().find(|mode| described(mode) == wanted).unwrap_or(preferred)
}

impl X11Session {
    /// The modes of an output by name; `None` if it is off or unknown.
    pub(super) fn output_modes(&self, name: &str) -> Option<OutputModes> {
        let resources = self.connection.randr_get_screen_resources_current(self.root()).ok()?.reply().ok()?;
        let time = resources.config_timestamp;
        let info = |output: &u32| self.connection.randr_get_output_info(*output, time).ok()?.reply().ok();
        let is_named = |info: &GetOutputInfoReply| info.name == name.as_bytes() && info.crtc != 0;
        let output = resources.outputs.iter().filter_map(info).find(is_named)?;
        let state = self.connection.randr_get_crtc_info(output.crtc, time).ok()?.reply().ok()?;
        let transform = self.connection.randr_get_crtc_transform(output.crtc).ok()?.reply().ok();
        let mode = |id: u32| resources.modes.iter().find(|mode| mode.id == id).copied();
        let modes: Vec<ModeInfo> = output.modes.iter().filter_map(|id| mode(*id)).collect();
        let current = mode(state.mode)?;
        Some(OutputModes {
            crtc: output.crtc,
            native: native(&modes, output.num_preferred, &current),
            current,
            state,
            is_scaled: transform.is_some_and(|transform| elements(&transform.current_transform) != IDENTITY),
        })
    }

    /// Sets a monitor that runs another mode to its native one if the check's `set_mode` is set, else warns about it
    /// once. Returns `true` if the mode was changed.
    pub(super) fn check_mode(&self, name: &str, check: &mut ModeCheck) -> bool {
        let ModeCheck { set_mode, last_warning } = check;
        let Some(modes) = self.output_modes(name).filter(|modes| modes.is_scaled || !modes.is_native()) else {
            *last_warning = None;
            return false;
        };
        let [native, current] = modes.native_and_current();
        let mut warning = if modes.is_native() {
            format!("THE X SERVER SCALES MONITOR {name}: no picture fits; switch that off: xrandr --output {name} --scale 1")
        } else {
            format!("MONITOR {name} RUNS {current}, ITS NATIVE MODE IS {native}: no picture is pixel for pixel; set that mode")
        };
        if !modes.is_native() && *set_mode {
            match self.set_native_mode(&modes) {
                Ok(()) => {
                    log::info!("monitor {name} is set from {current} to its native mode {native}");
                    return true;
                }
                Err(error) => warning = format!("{warning} by hand: {error}"),
            }
        } else if !modes.is_native() {
            warning.push_str(" (--set-mode does)");
        }
        if last_warning.as_ref() != Some(&warning) {
            log::warn!("{warning}");
            *last_warning = Some(warning);
        }
        false
    }

    /// Sets an output to its native mode. If it would overlap another monitor, it is placed to the right of all.
    ///
    /// # Errors
    /// The reason for a message.
    fn set_native_mode(&self, modes: &OutputModes) -> Result<(), String> {
        let (width, height) = modes.turned_size_px();
        let place = self.place_for(modes).ok_or("the desktop's monitors cannot be listed")?;
        self.enlarge_desktop(i32::from(place.0) + width, i32::from(place.1) + height)?;
        let (rotation, outputs) = (modes.state.rotation, &modes.state.outputs);
        let request = self.connection.randr_set_crtc_config(
            modes.crtc,
            CURRENT_TIME,
            CURRENT_TIME,
            place.0,
            place.1,
            modes.native.id,
            rotation,
            outputs,
        );
        match request.map_err(|error| error.to_string())?.reply() {
            Ok(reply) if reply.status == SetConfig::SUCCESS => Ok(()),
            Ok(reply) => Err(format!("the X server answers {:?}", reply.status)),
            Err(error) => Err(error.to_string()),
        }
    }

    /// A position at which an output fits in its native mode.
    fn place_for(&self, modes: &OutputModes) -> Option<(i16, i16)> {
        let resources = self.connection.randr_get_screen_resources_current(self.root()).ok()?.reply().ok()?;
        let state = |crtc: &Crtc| self.connection.randr_get_crtc_info(*crtc, CURRENT_TIME).ok()?.reply().ok();
        let others = resources.crtcs.iter().filter(|crtc| **crtc != modes.crtc).filter_map(state);
        let others: Vec<_> = others.filter(|other| other.width > 0).collect();
        let (x, y) = (i32::from(modes.state.x), i32::from(modes.state.y));
        let (width, height) = modes.turned_size_px();
        let (end_x, end_y) = (x + width, y + height);
        let right_of = |other: &GetCrtcInfoReply| i32::from(other.x) + i32::from(other.width);
        let overlaps = |other: &GetCrtcInfoReply| {
            let below = i32::from(other.y) + i32::from(other.height);
            x < right_of(other) && i32::from(other.x) < end_x && y < below && i32::from(other.y) < end_y
        };
        if others.iter().any(overlaps) {
            let right = others.iter().map(right_of).max()?;
            return Some((i16::try_from(right).ok()?, 0));
        }
        Some((modes.state.x, modes.state.y))
    }

    /// Enlarges the desktop to at least this size, pixels.
    fn enlarge_desktop(&self, width: i32, height: i32) -> Result<(), String> {
        let geometry = || self.connection.get_geometry(self.root()).ok()?.reply().ok();
        let now = geometry().ok_or("the desktop's size is unknown")?;
        let side = |wanted: i32, now: u16| u16::try_from(wanted).map_or(u16::MAX, |wanted| wanted.max(now));
        let wanted = (side(width, now.width), side(height, now.height));
        if wanted == (now.width, now.height) {
            return Ok(());
        }
        // The size in millimetres, at 96 pixels an inch; unused here.
        let mm = |pixels: u16| (f64::from(pixels) * 25.4 / 96.0) as u32;
        let request =
            self.connection.randr_set_screen_size(self.root(), wanted.0, wanted.1, mm(wanted.0), mm(wanted.1));
        request.map_err(|error| error.to_string())?.check().map_err(|error| error.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mode(id: u32, (width, height): (u16, u16), mode_flags: ModeFlag) -> ModeInfo {
        let (dot_clock, htotal, vtotal) = (74_250_000, 2200, 1125);
        ModeInfo { id, width, height, dot_clock, htotal, vtotal, mode_flags, ..ModeInfo::default() }
    }

    #[test]
    fn the_native_mode_has_the_preferred_size_and_sends_each_line_once() {
        let none = ModeFlag::from(0u8);
        let hd = (1920, 1080);
        let modes = [mode(1, hd, ModeFlag::INTERLACE), mode(2, (1280, 720), none), mode(3, hd, none)];
        assert_eq!(native(&modes, 1, &modes[1]).id, 3);
        assert_eq!(native(&modes, 0, &modes[1]).id, 2);
        assert_eq!(native(&modes, 0, &modes[0]).id, 3);
        assert_eq!(native(&modes[..2], 1, &modes[1]).id, 1);
    }

    #[test]
    fn a_turned_monitors_native_mode_takes_its_turned_size_on_the_desktop() {
        let native = mode(1, (1920, 1080), ModeFlag::from(0u8));
        let size = |rotation| {
            let state = GetCrtcInfoReply { rotation, ..GetCrtcInfoReply::default() };
            OutputModes { crtc: 1, state, native, current: native, is_scaled: false }.turned_size_px()
        };
        for (rotation, expected) in [
            (Rotation::ROTATE0, (1920, 1080)),
            (Rotation::ROTATE90, (1080, 1920)),
            (Rotation::ROTATE180 | Rotation::REFLECT_X, (1920, 1080)),
            (Rotation::ROTATE270 | Rotation::REFLECT_Y, (1080, 1920)),
        ] {
            assert_eq!(size(rotation), expected, "{rotation:?}");
        }
    }

    #[test]
    fn a_refresh_of_an_interlaced_mode_has_half_the_lines_and_of_a_doubled_one_twice_as_many() {
        for (flags, hz) in [(ModeFlag::from(0u8), 30.0), (ModeFlag::INTERLACE, 60.0), (ModeFlag::DOUBLE_SCAN, 15.0)] {
            let period = refresh_period(&mode(1, (1920, 1080), flags));
            assert_eq!(period, Some(Duration::from_secs_f64(1.0 / hz)), "{flags:?}");
        }
    }

    #[test]
    fn only_the_identity_shows_each_pixel_as_one() {
        let scaled = |scale: i32| Transform { matrix11: scale, matrix22: scale, matrix33: ONE, ..Transform::default() };
        assert_eq!(elements(&scaled(ONE)), IDENTITY);
        assert_ne!(elements(&scaled(ONE / 2)), IDENTITY);
    }
}
