//! The current monitors of an X server: RandR's outputs, virtual monitors (`xrandr --setmonitor`), and Xinerama's
//! heads.

use x11rb::connection::RequestConnection;
use x11rb::protocol::randr::{self, ConnectionExt as _, MonitorInfo as MonitorReply};
use x11rb::protocol::xinerama::{self, ConnectionExt as _, ScreenInfo};
use x11rb::protocol::xproto::ConnectionExt as _;

use super::session::X11Session;
use crate::monitor::MonitorInfo;

impl X11Session {
    /// All current monitors: the outputs of RandR and the virtual monitors; or, where several screens are one desktop
    /// by Xinerama, its heads; or, without both extensions, the whole screen.
    pub(crate) fn monitors(&self) -> Vec<MonitorInfo> {
        let mut monitors = self.outputs().unwrap_or_default();
        for monitor in self.named_monitors().unwrap_or_default() {
            match monitors.iter_mut().find(|output| output.name == monitor.name) {
                Some(output) => output.is_primary |= monitor.is_primary,
                None => monitors.push(monitor),
            }
        }
        // RandR's monitors are heads as well, so more heads are Xinerama's own.
        let heads = self.heads().unwrap_or_default();
        if heads.len() > monitors.len() {
            heads
        } else if monitors.is_empty() && !self.has_randr() {
            vec![self.whole_screen()]
        } else {
            monitors
        }
    }

    /// `true` if the server knows outputs; one without is an old or a remote one.
    pub(super) fn has_randr(&self) -> bool {
        self.connection.extension_information(randr::X11_EXTENSION_NAME).ok().flatten().is_some()
    }

    fn whole_screen(&self) -> MonitorInfo {
        MonitorInfo {
            name: "screen".to_owned(),
            size_px: (self.screen.width_in_pixels.into(), self.screen.height_in_pixels.into()),
            is_primary: true,
            ..MonitorInfo::default()
        }
    }

    /// The outputs that are on.
    fn outputs(&self) -> Option<Vec<MonitorInfo>> {
        let resources = self.connection.randr_get_screen_resources_current(self.root()).ok()?.reply().ok()?;
        let primary = self.connection.randr_get_output_primary(self.root()).ok()?.reply().ok()?.output;
        let time = resources.config_timestamp;
        let output = |crtc| {
            let crtc = self.connection.randr_get_crtc_info(crtc, time).ok()?.reply().ok()?;
            let id = *crtc.outputs.first()?;
            let output = self.connection.randr_get_output_info(id, time).ok()?.reply().ok()?;
            Some(MonitorInfo {
                name: String::from_utf8_lossy(&output.name).into_owned(),
                position_px: (crtc.x.into(), crtc.y.into()),
                size_px: (crtc.width.into(), crtc.height.into()),
                is_primary: id == primary,
                is_virtual: false,
            })
        };
        Some(resources.crtcs.into_iter().filter_map(output).filter(|output| output.size_px != (0, 0)).collect())
    }

    /// RandR 1.5's monitors: one for each output, and the user's virtual ones.
    fn named_monitors(&self) -> Option<Vec<MonitorInfo>> {
        let version = self.connection.randr_query_version(1, 5).ok()?.reply().ok()?;
        if (version.major_version, version.minor_version) < (1, 5) {
            return None;
        }
        let found = self.connection.randr_get_monitors(self.root(), false).ok()?.reply().ok()?;
        let monitor = |monitor: MonitorReply| {
            let name = self.connection.get_atom_name(monitor.name).ok()?.reply().ok()?.name;
            Some(MonitorInfo {
                name: String::from_utf8_lossy(&name).into_owned(),
                position_px: (monitor.x.into(), monitor.y.into()),
                size_px: (monitor.width.into(), monitor.height.into()),
                is_primary: monitor.primary,
                is_virtual: !monitor.automatic,
            })
        };
        // Monitors without outputs are not active.
        Some(found.monitors.into_iter().filter_map(monitor).filter(|monitor| monitor.size_px != (0, 0)).collect())
    }

    /// Xinerama's heads, which have no names; the first is the primary one.
    fn heads(&self) -> Option<Vec<MonitorInfo>> {
        self.connection.extension_information(xinerama::X11_EXTENSION_NAME).ok()??;
        let is_active = self.connection.xinerama_is_active().ok()?.reply().ok()?.state != 0;
        let heads = self.connection.xinerama_query_screens().ok()?.reply().ok()?.screen_info;
        let head = |(index, head): (usize, ScreenInfo)| MonitorInfo {
            name: format!("head-{index}"),
            position_px: (head.x_org.into(), head.y_org.into()),
            size_px: (head.width.into(), head.height.into()),
            is_primary: index == 0,
            is_virtual: false,
        };
        Some(heads.into_iter().enumerate().map(head).filter(|_| is_active).collect())
    }
}
