//! `rviz/TF`: the frames themselves, with axes, names and arrows to their parents.

use std::collections::BTreeSet;

use crate::frame_filter::FrameFilter;
use crate::node::Content;
use crate::section::{at_least, join, Section, ANY, ENTRY};

/// The entry of "Frames" that is no frame.
const ALL_ENABLED: &str = "All Enabled";

/// The properties of a TF display.
#[derive(Debug, Clone, PartialEq)]
pub struct TfSettings {
    /// Whether names hang below the frames.
    pub show_names: bool,
    /// Whether the frames' axes are shown.
    pub show_axes: bool,
    /// Whether arrows point from the frames to their parents.
    pub show_arrows: bool,
    /// The size of names, axes and arrows; at 1 an axis is 0.2 m long. Unbounded, also below zero.
    pub marker_scale: f32,
    /// Opacity of the axes, 0 to 1; names and arrows stay opaque.
    pub marker_alpha: f32,
    /// Seconds between two updates of the frames, at least 0; 0 updates whenever something changed.
    pub update_interval_s: f32,
    /// Seconds without a new transform after which a frame disappears, at least 1. It turns grey in the second third of
    /// that time and fades away in the last one.
    pub frame_timeout_s: f32,
    /// Frames without a match in their names are left out; without an expression, none is.
    pub whitelist: FrameFilter,
    /// Frames with a match in their names are left out; without an expression, none is.
    pub blacklist: FrameFilter,
    /// The frames that the list "Frames" switches off.
    pub hidden_frames: BTreeSet<String>,
}

impl Default for TfSettings {
    fn default() -> Self {
        TfSettings {
            show_names: true,
            show_axes: true,
            show_arrows: true,
            marker_scale: 1.0,
            marker_alpha: 1.0,
            update_interval_s: 0.0,
            frame_timeout_s: 15.0,
            whitelist: FrameFilter::default(),
            blacklist: FrameFilter::default(),
            hidden_frames: BTreeSet::new(),
        }
    }
}

impl TfSettings {
    pub(crate) fn read(section: &mut Section<'_>) -> Self {
        let mut settings = TfSettings::default();
        section.bool("Show Names", &mut settings.show_names);
        section.bool("Show Axes", &mut settings.show_axes);
        section.bool("Show Arrows", &mut settings.show_arrows);
        section.float("Marker Scale", ANY, &mut settings.marker_scale);
        section.float("Marker Alpha", 0.0..=1.0, &mut settings.marker_alpha);
        section.float("Update Interval", at_least(0.0), &mut settings.update_interval_s);
        section.float("Frame Timeout", at_least(1.0), &mut settings.frame_timeout_s);
        filter(section, "Filter (whitelist)", &mut settings.whitelist);
        filter(section, "Filter (blacklist)", &mut settings.blacklist);
        settings.hidden_frames = hidden_frames(section);
        // What the window shows of the frames' order, and its button, which has no effect in a file wherever it stands.
        section.skip(&["Tree", ALL_ENABLED]);
        settings
    }

    /// Whether the filters leave a frame in.
    pub fn lists(&self, frame: &str) -> bool {
        self.whitelist.matches(frame).unwrap_or(true) && !self.blacklist.matches(frame).unwrap_or(false)
    }
}

/// Reads a filter. One that cannot be compiled is none, as in rviz.
fn filter(section: &mut Section<'_>, key: &str, setting: &mut FrameFilter) {
    section.record(key, String::new);
    let Some((text, line)) = section.scalar(key) else { return };
    *setting = FrameFilter::new(text).unwrap_or_else(|error| {
        let used = format!("no filter, because it is no regular expression: {error}");
        section.report().add_invalid(line, &join(section.path(), key), text, &used);
        FrameFilter::default()
    });
}

/// Reads the frames' tick boxes, which are maps with a `Value`. rviz takes anything else for a frame that is off, and
/// "All Enabled" for a button: when it loads the file, there is no frame yet that it could switch.
fn hidden_frames(section: &mut Section<'_>) -> BTreeSet<String> {
    let mut frames = section.child("Frames");
    let mut all_enabled = true;
    frames.bool(ALL_ENABLED, &mut all_enabled);
    frames.record(ENTRY, || true.to_string());
    let mut hidden = BTreeSet::new();
    for (name, node, _) in frames.all() {
        if name == ALL_ENABLED {
            continue;
        }
        let mut is_enabled = false;
        if matches!(node.content, Content::Map(_)) {
            let mut frame = Section::new(node, join(frames.path(), name), section.report());
            frame.bool("Value", &mut is_enabled);
            frame.finish();
        } else {
            section.report().add_invalid(node.line, &join(frames.path(), name), "no map with a Value", "false");
        }
        if !is_enabled {
            hidden.insert(name.to_owned());
        }
    }
    hidden
}
