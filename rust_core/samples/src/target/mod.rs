//! The target of a node: a pose, a point, a cloud's centroid or a frame, in the fixed frame.
//!
//! A message is transformed to the fixed frame at its own stamp, as soon as its transform is known, and stays there
//! until the next one, although the robot or a camera on the turret moves. A frame is looked up each time.

mod arguments;
mod waiting;

use std::time::{Duration, Instant};

use nalgebra::Point3;
use rcs_messages::{AnyMessage, MessageKind};
use rcs_ros::{NodeError, RosNode, TopicSubscription};
use rcs_transforms::{Time, TransformTree};

pub(crate) use arguments::{TargetArguments, TargetSource};
use waiting::{PendingTargets, ReceivedTarget};

/// A target over time.
pub(crate) struct Target {
    source: TargetSource,
    fixed_frame: String,
    /// `None`: it never expires.
    timeout: Option<Duration>,
    subscription: Option<TopicSubscription>,
    pending: PendingTargets,
    /// Last position in the fixed frame.
    known: Option<(Point3<f64>, Instant)>,
    /// Error of the last message.
    fault: Option<String>,
}

/// Why the position of a target is unknown.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum NoTarget {
    /// No message yet.
    #[error("no target yet on {0}")]
    Never(String),
    /// The last message has expired.
    #[error("the target on {0} has expired")]
    Stale(String),
    /// The message is invalid, or its transform missing.
    #[error("invalid target on {topic}: {reason}")]
    Fault {
        /// Its topic.
        topic: String,
        /// The reason.
        reason: String,
    },
    /// The target's frame is unknown.
    #[error("no target: {0}")]
    NoFrame(String),
    /// The target's frame has expired.
    #[error("frame {0} is stale")]
    StaleFrame(String),
}

impl Target {
    /// Subscribes to the target's topic, if it has one.
    ///
    /// # Errors
    /// [`NodeError`]: an invalid topic name.
    pub(crate) fn start(
        node: &RosNode,
        source: TargetSource,
        fixed_frame: &str,
        timeout: Option<Duration>,
    ) -> Result<Self, NodeError> {
        let subscribe = |topic: &str, kind| node.subscribe(topic, kind, 1).map(Some);
        let subscription = match &source {
            TargetSource::Pose(topic) => subscribe(topic, MessageKind::PoseStamped)?,
            TargetSource::Point(topic) => subscribe(topic, MessageKind::PointStamped)?,
            TargetSource::Cloud(topic) => subscribe(topic, MessageKind::PointCloud2)?,
            TargetSource::Frame(_) => None,
        };
        let fixed_frame = fixed_frame.to_owned();
        let pending = PendingTargets::default();
        Ok(Self { source, fixed_frame, timeout, subscription, pending, known: None, fault: None })
    }

    /// The frame in which targets are fixed.
    pub(crate) fn fixed_frame(&self) -> &str {
        &self.fixed_frame
    }

    /// Handles a message of the target's topic.
    pub(crate) fn take(&mut self, topic: &str, message: &AnyMessage, received: Instant) {
        if self.subscription.as_ref().is_none_or(|own| &**own.topic() != topic) {
            return;
        }
        match ReceivedTarget::of(message, received) {
            Ok(sighting) => self.pending.push(sighting),
            Err(reason) => self.fault = Some(reason),
        }
    }

    /// Position of the target in the fixed frame, metres.
    ///
    /// # Errors
    /// [`NoTarget`].
    pub(crate) fn position(&mut self, tree: &TransformTree, now: Time) -> Result<Point3<f64>, NoTarget> {
        if let TargetSource::Frame(frame) = &self.source {
            return self.position_of_frame(frame, tree, now);
        }
        match self.pending.place(tree, &self.fixed_frame) {
            Some(Ok(place)) => (self.known, self.fault) = (Some(place), None),
            Some(Err(reason)) => self.fault = Some(reason),
            None => {}
        }
        let topic = || self.subscription.as_ref().map(|own| own.topic().to_string()).unwrap_or_default();
        let is_current = |at: &Instant| self.timeout.is_none_or(|timeout| at.elapsed() <= timeout);
        match (&self.known, &self.fault) {
            (Some((place, at)), _) if is_current(at) => Ok(*place),
            (_, Some(reason)) => Err(NoTarget::Fault { topic: topic(), reason: reason.clone() }),
            (Some(_), None) => Err(NoTarget::Stale(topic())),
            (None, None) => Err(NoTarget::Never(topic())),
        }
    }

    fn position_of_frame(&self, frame: &str, tree: &TransformTree, now: Time) -> Result<Point3<f64>, NoTarget> {
        let found = tree.lookup_stamped(&self.fixed_frame, frame, Time::ZERO);
        let (fixed_from_frame, stamp) = found.map_err(|error| NoTarget::NoFrame(error.to_string()))?;
        let is_current = |timeout: Duration| now.secs_since(stamp) <= timeout.as_secs_f64();
        // Stamp zero: all between the two is static.
        if stamp != Time::ZERO && !self.timeout.is_none_or(is_current) {
            return Err(NoTarget::StaleFrame(frame.to_owned()));
        }
        Ok(fixed_from_frame.translation.vector.into())
    }
}
