//! A monitor's mode, compared with its native one: only the native mode is not scaled by the monitor.
//!
//! The native mode is the first of RandR's list, which begins with the preferred modes (X RandR 1.5, RRGetOutputInfo).

use std::time::Duration;

use x11rb::protocol::randr::{ConnectionExt as _, Crtc, GetCrtcInfoReply, GetOutputInfoReply, ModeInfo, SetConfig};
use x11rb::protocol::render::Transform;
use x11rb::protocol::xproto::ConnectionExt as _;
use x11rb::CURRENT_TIME;

use super::session::X11Session;

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
        self.current.id == self.native.id || Self::size(&self.current) == Self::size(&self.native)
    }

    /// Width and height of the native and of the current mode, pixels.
    pub(super) fn native_and_current_px(&self) -> [(u16, u16); 2] {
        [Self::size(&self.native), Self::size(&self.current)]
    }

    /// Time between two refreshes of the current mode; `None` for a screen without refresh.
    pub(super) fn refresh_period(&self) -> Option<Duration> {
        let pixels = u32::from(self.current.htotal) * u32::from(self.current.vtotal);
        (self.current.dot_clock > 0 && pixels > 0)
            .then(|| Duration::from_secs_f64(f64::from(pixels) / f64::from(self.current.dot_clock)))
    }

    fn size(mode: &ModeInfo) -> (u16, u16) {
        (mode.width, mode.height)
    }
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
        Some(OutputModes {
            crtc: output.crtc,
            native: mode(*output.modes.get(..output.num_preferred.into())?.first()?)?,
            current: mode(state.mode)?,
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
        let [native, current] = modes.native_and_current_px().map(|(width, height)| format!("{width}x{height}"));
        let mut warning = if modes.is_native() {
            format!("THE X SERVER SCALES MONITOR {name}: no picture fits; switch that off: xrandr --output {name} --scale 1")
        } else {
            format!("MONITOR {name} RUNS {current}, ITS NATIVE MODE IS {native}: it scales each picture; set that mode")
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
        let (width, height) = OutputModes::size(&modes.native);
        let place = self.place_for(modes).ok_or("the desktop's monitors cannot be listed")?;
        self.enlarge_desktop(i32::from(place.0) + i32::from(width), i32::from(place.1) + i32::from(height))?;
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
        let (width, height) = OutputModes::size(&modes.native);
        let (end_x, end_y) = (x + i32::from(width), y + i32::from(height));
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

    #[test]
    fn only_the_identity_shows_each_pixel_as_one() {
        let scaled = |scale: i32| Transform { matrix11: scale, matrix22: scale, matrix33: ONE, ..Transform::default() };
        assert_eq!(elements(&scaled(ONE)), IDENTITY);
        assert_ne!(elements(&scaled(ONE / 2)), IDENTITY);
    }
}
