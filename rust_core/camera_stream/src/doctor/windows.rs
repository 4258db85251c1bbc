//! The windows that should show the image, and where.

use rcs_ros::{is_this_computer, RosNode};
use rcs_window::MonitorChoice;

use super::viewer::Viewer;
use crate::options::Options;

/// The windows that should be there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Windows {
    pub(super) viewer: Viewer,
    pub(super) monitors: Vec<MonitorChoice>,
    /// The node of the window and its computer, if it runs on another one.
    pub(super) elsewhere: Option<(String, String)>,
}

impl Windows {
    /// The windows by a launch file's arguments, the node's options, and the nodes that run.
    pub(super) fn of(
        viewer: Option<Viewer>,
        monitor: Option<&MonitorChoice>,
        options: &Options,
        ros: Option<(&RosNode, &str)>,
    ) -> Self {
        let runs = |node: &str| ros.is_some_and(|(ros, _)| ros.host_of(node).is_some());
        let viewer = match viewer {
            Some(viewer) => viewer,
            None if !options.windows.is_empty() => Viewer::Window,
            None if runs(Viewer::PROJECTOR_WINDOW) => Viewer::ProjectorWindow,
            None => Viewer::None,
        };
        let monitors = match (viewer, monitor) {
            (Viewer::None, _) => Vec::new(),
            (_, Some(monitor)) => vec![monitor.clone()],
            (Viewer::Window, None) if options.windows.is_empty() => vec![MonitorChoice::default()],
            (Viewer::Window, None) => options.windows.iter().map(|window| window.value.clone()).collect(),
            (_, None) => vec![ros.and_then(|(ros, _)| parameter(ros)).unwrap_or_default()],
        };
        let elsewhere = ros.and_then(|(ros, checked_name)| {
            let node = viewer.node(checked_name)?;
            let host = ros.host_of(node).filter(|host| !is_this_computer(host))?;
            Some((node.to_owned(), host))
        });
        Self { viewer, monitors, elsewhere }
    }

    /// The title of a window that another package's program has.
    pub(super) fn title(&self) -> Option<&'static str> {
        // As launch/viewers/image_view.launch names it.
        (self.viewer == Viewer::ImageView).then_some("picture of the projector")
    }
}

/// The parameter `~monitor` of the node `projector_window`.
fn parameter(ros: &RosNode) -> Option<MonitorChoice> {
    let parameters = ros.parameters_of(Viewer::PROJECTOR_WINDOW).ok()?;
    let text = parameters.get("monitor")?.text()?;
    text.parse().ok()
}
