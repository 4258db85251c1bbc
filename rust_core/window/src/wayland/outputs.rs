//! The outputs of a compositor as monitors.

use wayland_client::protocol::wl_output::{self, Mode, Transform, WlOutput};
use wayland_client::WEnum;
use wayland_protocols::xdg::xdg_output::zv1::client::zxdg_output_v1::{self, ZxdgOutputV1};

use crate::monitor::MonitorInfo;
use crate::report::{MonitorMode, Scan};

/// An output as described so far.
struct WaylandOutput {
    /// The number of its global.
    global: u32,
    proxy: WlOutput,
    described: Option<ZxdgOutputV1>,
    info: MonitorInfo,
    mode_px: (u32, u32),
    is_turned: bool,
    native_px: Option<(u32, u32)>,
}

/// All outputs.
#[derive(Default)]
pub(super) struct WaylandOutputs(Vec<WaylandOutput>);

impl WaylandOutputs {
    /// Adds an output.
    pub(super) fn add(&mut self, global: u32, proxy: WlOutput) {
        let (described, info) = (None, MonitorInfo { name: format!("output-{global}"), ..MonitorInfo::default() });
        let output =
            WaylandOutput { global, proxy, described, info, mode_px: (0, 0), is_turned: false, native_px: None };
        self.0.push(output);
    }

    /// Requests the outputs' description beyond the core protocol.
    pub(super) fn describe(&mut self, mut ask: impl FnMut(&WlOutput) -> ZxdgOutputV1) {
        for output in self.0.iter_mut().filter(|output| output.described.is_none()) {
            output.described = Some(ask(&output.proxy));
        }
    }

    /// Removes an output. Returns `false` for other globals.
    pub(super) fn remove(&mut self, global: u32) -> bool {
        let count = self.0.len();
        self.0.retain(|output| output.global != global);
        count != self.0.len()
    }

    /// Applies an event of an output.
    pub(super) fn apply(&mut self, proxy: &WlOutput, event: wl_output::Event) {
        let Some(output) = self.0.iter_mut().find(|output| output.proxy == *proxy) else { return };
        match event {
            wl_output::Event::Geometry { x, y, transform, .. } => {
                output.info.position_px = (x, y);
                output.is_turned = matches!(
                    transform,
                    WEnum::Value(Transform::_90 | Transform::_270 | Transform::Flipped90 | Transform::Flipped270)
                );
            }
            wl_output::Event::Mode { flags: WEnum::Value(flags), width, height, .. } => {
                let size = (u32::try_from(width).unwrap_or(0), u32::try_from(height).unwrap_or(0));
                if flags.contains(Mode::Current) {
                    output.mode_px = size;
                }
                if flags.contains(Mode::Preferred) {
                    output.native_px = Some(size);
                }
            }
            wl_output::Event::Name { name } => output.info.name = name,
            _ => {}
        }
        output.info.size_px = if output.is_turned { (output.mode_px.1, output.mode_px.0) } else { output.mode_px };
    }

    /// Applies an event of an output's description.
    pub(super) fn apply_described(&mut self, proxy: &ZxdgOutputV1, event: zxdg_output_v1::Event) {
        let Some(output) = self.0.iter_mut().find(|output| output.described.as_ref() == Some(proxy)) else { return };
        match event {
            zxdg_output_v1::Event::LogicalPosition { x, y } => output.info.position_px = (x, y),
            zxdg_output_v1::Event::Name { name } => output.info.name = name,
            _ => {}
        }
    }

    /// The outputs that are on.
    pub(super) fn monitors(&self) -> Vec<MonitorInfo> {
        self.0.iter().map(|output| output.info.clone()).filter(|info| info.size_px != (0, 0)).collect()
    }

    /// The output with a name.
    pub(super) fn proxy(&self, name: &str) -> Option<&WlOutput> {
        self.0.iter().find(|output| output.info.name == name).map(|output| &output.proxy)
    }

    /// The native and the current mode of an output that runs another mode than its native one. The protocol does not
    /// tell interlaced modes apart.
    pub(super) fn other_mode(&self, name: &str) -> Option<[MonitorMode; 2]> {
        let output = self.0.iter().find(|output| output.info.name == name)?;
        let native = output.native_px.filter(|native| *native != output.mode_px)?;
        Some([native, output.mode_px].map(|size_px| MonitorMode { size_px, scan: Scan::Progressive }))
    }
}
