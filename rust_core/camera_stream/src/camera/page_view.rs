//! A camera on the operator's page.

use std::sync::Arc;

use rcs_ros::settings::NamedValues;
use rcs_ros::ReconfigureServer;

use super::output::CameraPublisher;
use crate::outputs::TopicOutput;

/// A camera's figures for the operator's page.
#[derive(Debug)]
pub(crate) struct CameraFigures<'a> {
    /// The whole name of the image topic.
    pub(crate) topic: Option<&'a str>,
    /// The optical frame and the size of the last image.
    pub(crate) frame: Option<&'a str>,
    pub(crate) size_px: Option<[u32; 2]>,
    /// Images published so far.
    pub(crate) published: u64,
    /// Medians, where they were measured.
    pub(crate) latency_ms: Option<f64>,
    pub(crate) age_ms: Option<f64>,
    /// Why the last image is black, or why there is none.
    pub(crate) dark: Option<String>,
}

impl CameraPublisher {
    /// Its figures for the operator's page.
    pub(crate) fn figures(&self) -> CameraFigures<'_> {
        let last = self.buffers.front.as_ref();
        let black = last.and_then(|last| last.spec.dark_reason()).map(|dark| dark.why.clone());
        let [latency_ms, age_ms] = self.health.latency.medians_ms();
        CameraFigures {
            topic: self.connections.outputs.topic.as_ref().map(TopicOutput::topic),
            frame: last.map(|last| last.spec.info.header.frame_id.as_str()),
            size_px: last.map(|last| last.image.size_px()),
            published: self.health.published(),
            latency_ms,
            age_ms,
            dark: black.or_else(|| self.health.problem()),
        }
    }

    /// Its servers of dynamic_reconfigure: its own first, then that of the compressed images.
    pub(crate) fn servers(&self) -> impl Iterator<Item = &ReconfigureServer> {
        let topic = self.connections.outputs.topic.as_ref();
        self.settings.server().into_iter().chain(topic.and_then(TopicOutput::server))
    }

    /// The displays that it shows, by their paths, without the groups around them.
    pub(crate) fn shown_displays(&self) -> Vec<String> {
        self.settings.shown_displays()
    }

    /// The server of its settings, and the values that show these displays and hide all others.
    ///
    /// # Errors
    /// A display that the config does not have, or there is no server.
    pub(crate) fn values_showing(&self, shown: &[String]) -> Result<(Arc<str>, NamedValues), String> {
        let server = self.settings.server().ok_or("its settings cannot be changed")?;
        Ok((Arc::clone(server.name()), self.settings.values_showing(shown)?))
    }

    /// The switches of the displays: path, name of the parameter, and `true` for one that is on.
    pub(crate) fn switches(&self) -> impl Iterator<Item = (&[String], &str, bool)> {
        self.settings.switches()
    }
}
