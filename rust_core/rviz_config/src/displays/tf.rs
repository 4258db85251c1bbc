//! `rviz/TF`: the frames themselves, with axes, names and arrows to their parents.

use std::collections::BTreeSet;

use crate::frame_filter::FrameFilter;
use crate::node::Content;
use crate::report::ENTRY;
use crate::section::{at_least, join, Section, ANY};

/// The entry of "Frames" that is no frame.
const ALL_ENABLED: &str = "All Enabled";

properties! {
    /// The properties of a TF display.
    pub struct TfSettings {
        /// `true` if names hang below the frames.
        show_names: bool = true => bool("Show Names");
        /// `true` if the frames' axes are drawn.
        show_axes: bool = true => bool("Show Axes");
        /// `true` if arrows point from the frames to their parents.
        show_arrows: bool = true => bool("Show Arrows");
        /// The size of names, axes and arrows; at 1 an axis is 0.2 m long. Unbounded, also below zero.
        marker_scale: f32 = 1.0 => float("Marker Scale", ANY);
        /// Opacity of the axes, 0 to 1; names and arrows stay opaque.
        marker_alpha: f32 = 1.0 => float("Marker Alpha", 0.0..=1.0);
        /// Seconds between two updates of the frames, at least 0; 0 updates at every change.
        update_interval_s: f32 = 0.0 => float("Update Interval", at_least(0.0));
        /// Seconds without a new transform after which a frame disappears, at least 1. It turns grey in the second
        /// third of that time and fades away in the last one.
        frame_timeout_s: f32 = 15.0 => float("Frame Timeout", at_least(1.0));
        /// Frames without a match in their names are left out; without an expression, none is.
        whitelist: FrameFilter = FrameFilter::default() => frame_filter("Filter (whitelist)");
        /// Frames with a match in their names are left out; without an expression, none is.
        blacklist: FrameFilter = FrameFilter::default() => frame_filter("Filter (blacklist)");
        /// The frames that the list "Frames" switches off.
        hidden_frames: BTreeSet<String> = BTreeSet::new() => hidden_frames("Frames");
    }
    // The frames' order as rviz displays it, and its button, which has no effect in a file wherever it stands.
    skip ["Tree", ALL_ENABLED];
}

impl TfSettings {
    /// `true` if the filters leave a frame in.
    pub fn lists(&self, frame: &str) -> bool {
        self.whitelist.matches(frame).unwrap_or(true) && !self.blacklist.matches(frame).unwrap_or(false)
    }
}

impl Section<'_> {
    /// Reads a filter. One that cannot be compiled is none, as in rviz.
    fn frame_filter(&mut self, key: &str, setting: &mut FrameFilter) {
        self.record(key, String::new);
        let Some((text, line)) = self.scalar(key) else { return };
        *setting = FrameFilter::new(text).unwrap_or_else(|error| {
            let used = format!("no filter, because it is no regular expression: {error}");
            self.report().add_invalid(line, &join(self.path(), key), text, &used);
            FrameFilter::default()
        });
    }

    /// Reads the frames' tick boxes, which are maps with a `Value`. rviz takes anything else for a frame that is off,
    /// and "All Enabled" for a button: when it loads the file, there is no frame yet that it could switch.
    fn hidden_frames(&mut self, key: &str, hidden: &mut BTreeSet<String>) {
        let mut frames = self.child(key);
        frames.bool(ALL_ENABLED, &mut true);
        frames.record(ENTRY, || true.to_string());
        for (name, node) in frames.all() {
            if name == ALL_ENABLED {
                continue;
            }
            let mut is_enabled = false;
            if matches!(node.content, Content::Map(_)) {
                let mut frame = frames.child(name);
                frame.bool("Value", &mut is_enabled);
                frame.finish();
            } else {
                frames.report().add_invalid(node.line, &join(frames.path(), name), "no map with a Value", "false");
            }
            if !is_enabled {
                hidden.insert(name.to_owned());
            }
        }
    }
}
