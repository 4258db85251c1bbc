//! rviz's Time panel, which may synchronize frames with the messages of a display.
//!
//! With a `SyncMode` other than 0, rviz looks frames up at another time than their latest: at the stamp of the source's
//! last message (exact), earlier by these messages' delay (approximate), or now (frame). This is unsupported, and
//! reported.

use std::rc::Rc;

use crate::finding::FindingKind;
use crate::node::Node;
use crate::qt_value;
use crate::report::Report;

/// The names of the modes from 1 on in rviz's window. Other numbers count as 0.
const MODES: [&str; 3] = ["Exact", "Approximate", "Frame"];

/// Reports the synchronization of a Time panel among `panels`.
pub(crate) fn check(panels: Option<&Node>, report: &Report) {
    let is_time = |panel: &&Rc<Node>| panel.get("Class").and_then(Node::scalar) == Some("rviz/Time");
    for panel in panels.map(Node::items).unwrap_or_default().iter().filter(is_time) {
        let Some(node) = panel.get("SyncMode") else { continue };
        let number = node.scalar().and_then(qt_value::to_int).and_then(|mode| usize::try_from(mode).ok());
        let mode = number.and_then(|number| MODES.get(number.checked_sub(1)?));
        let Some(mode) = mode else { continue };
        let source = panel.get("SyncSource").and_then(Node::scalar).unwrap_or_default().to_owned();
        report.add(node.line, "Panels / Time / SyncMode", FindingKind::TimeSync { mode, source });
    }
}
