//! The scene of a running node: the loaded config, the subscriptions that feed it, and the snapshot that is drawn.

use std::sync::Arc;
use std::time::{Duration, Instant};

use rcs_displays::Reconfigured;
use rcs_ros::{NodeEvent, RosNode};
use rcs_rviz_config::Config;
use rcs_scene::Scene;
use rcs_transforms::Time;

use super::subscriptions::Subscriptions;
use super::SceneState;
use crate::options::prediction::PredictionSettings;

/// The scene of a running node.
pub(crate) struct LiveScene {
    pub(crate) state: SceneState,
    pub(crate) subscriptions: Subscriptions,
    /// The scene of a version, for all cameras.
    snapshot: Option<(u64, Arc<Scene>)>,
    /// Arrival of the last transforms since the last update.
    transforms_received: Option<Instant>,
    prediction: PredictionSettings,
    /// The command line's, which overrides the config's.
    fixed_frame: Option<String>,
}

impl LiveScene {
    /// Subscribes to everything that a state reads.
    ///
    /// # Errors
    /// A topic that cannot be subscribed to.
    pub(crate) fn start(
        ros: &RosNode,
        state: SceneState,
        prediction: PredictionSettings,
        fixed_frame: Option<String>,
    ) -> anyhow::Result<Self> {
        ros.subscribe_transforms()?;
        let mut subscriptions = Subscriptions::default();
        subscriptions.update(ros, state.topics());
        ros.follow_parameters(state.parameters());
        Ok(Self { state, subscriptions, snapshot: None, transforms_received: None, prediction, fixed_frame })
    }

    /// Replaces the config. Subscriptions that are kept are not touched, and displays that are kept show what they did.
    pub(crate) fn reconfigure(&mut self, ros: &RosNode, config: &Config, now: Time) -> Reconfigured {
        let known_parameters = self.state.parameters();
        let changed = self.state.reconfigure(config, self.fixed_frame.as_deref(), now);
        self.subscriptions.update(ros, self.state.topics());
        let is_new = |name: &String| !known_parameters.contains(name);
        ros.follow_parameters(self.state.parameters().into_iter().filter(is_new).collect());
        changed
    }

    /// Applies an event. `now` is ROS time.
    pub(crate) fn apply(&mut self, event: NodeEvent, now: Time) {
        match &event {
            // The scene is put together again. Dropped here already, it holds no clouds whose memory the next ones can
            // use.
            NodeEvent::Message { .. } => self.snapshot = None,
            NodeEvent::Transforms { received, .. } => self.transforms_received = Some(*received),
            _ => {}
        }
        self.subscriptions.apply(event, &mut self.state, now);
    }

    /// Predicts frames from now on, if that is set. `lookup_to_publish` is the time that the slowest camera needs from
    /// looking up frames to publishing. Returns `true` if frames move without news.
    pub(crate) fn predict(&mut self, now: Time, lookup_to_publish: Option<Duration>) -> bool {
        let prediction = self.prediction.prediction(now, lookup_to_publish);
        self.state.predict(prediction);
        prediction.is_some()
    }

    /// Brings the displays up to date. Returns the arrival of the last transforms, if there are new ones.
    pub(crate) fn update(&mut self, now: Time) -> Option<Instant> {
        self.state.update(now);
        self.transforms_received.take()
    }

    /// The scene as it is now, for all cameras.
    pub(crate) fn snapshot(&mut self) -> Arc<Scene> {
        let version = self.state.displays().version();
        let current = self.snapshot.take().filter(|(known, _)| *known == version);
        let (_, scene) = self.snapshot.insert(current.unwrap_or_else(|| (version, Arc::new(self.state.scene()))));
        Arc::clone(scene)
    }
}
