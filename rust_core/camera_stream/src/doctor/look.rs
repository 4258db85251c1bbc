//! Input of the doctor's checks, after it has listened.

use std::sync::Arc;
use std::time::{Duration, Instant};

use rcs_displays::CameraView;
use rcs_ros::Publications;

use super::finding::check_name;
use crate::check::observed::Observed;
use crate::check::session::Session;
use crate::options::Options;
use crate::safety::ages::limits::AgeLimits;
use crate::scene::subscriptions::Subscriptions;
use crate::scene::SceneState;

/// The state of things after listening.
pub(super) struct Look<'a> {
    pub(super) session: &'a Session,
    pub(super) options: &'a Options,
    pub(super) limits: &'a AgeLimits,
    pub(super) scene: &'a SceneState,
    pub(super) subscriptions: &'a Subscriptions,
    pub(super) observed: &'a Observed,
    /// Other nodes' publications; `None` if the master no longer answers.
    pub(super) publications: Option<Arc<Publications>>,
    /// How long it listened, and until when.
    pub(super) listened: Duration,
    pub(super) ended: Instant,
}

impl Look<'_> {
    /// The name of a check of a camera.
    pub(super) fn name(&self, check: &str, camera: &CameraView) -> String {
        check_name(check, &camera.name, self.scene.cameras().len())
    }

    /// The whole name of a topic.
    pub(super) fn whole_name(&self, topic: &str) -> String {
        self.session.ros.resolve(topic).unwrap_or_else(|_| topic.to_owned())
    }

    /// The nodes that publish a topic, by its whole name.
    pub(super) fn publishers(&self, topic: &str) -> &[String] {
        let publication = self.publications.as_ref().and_then(|publications| publications.get(topic));
        publication.map(|publication| publication.nodes.as_slice()).unwrap_or_default()
    }
}
