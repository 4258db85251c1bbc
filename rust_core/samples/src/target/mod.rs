//! A thing that a node aims at: a pose, a point, a cloud's middle or a frame, placed where it stands still.
//!
//! What is received is placed in the fixed frame at its own stamp, as soon as the transforms for that are there, and
//! stays there until the next message: a robot that drives, or a camera on the turret itself, does not take it along. A
//! frame is looked up anew each time.

mod arguments;
mod waiting;

use std::time::{Duration, Instant};

use nalgebra::Point3;
use rcs_messages::{AnyMessage, MessageKind};
use rcs_ros::{NodeError, RosNode, TopicSubscription};
use rcs_transforms::{Time, TransformTree};

pub(crate) use arguments::{TargetArguments, TargetSource};
use waiting::{Sighting, Waiting};

/// A target over time.
pub(crate) struct Target {
    source: TargetSource,
    fixed_frame: String,
    /// None: it never becomes stale.
    timeout: Option<Duration>,
    subscription: Option<TopicSubscription>,
    waiting: Waiting,
    /// Its last place in the fixed frame.
    known: Option<(Point3<f64>, Instant)>,
    /// Why the last message gave none.
    fault: Option<String>,
}

/// Why a target has no place.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum NoTarget {
    /// Nothing was received yet.
    #[error("no target yet on {0}")]
    Never(String),
    /// What was received is too old.
    #[error("the target on {0} is gone")]
    Stale(String),
    /// What was received has no place.
    #[error("the target on {topic} has no place: {reason}")]
    Fault {
        /// Where it was received.
        topic: String,
        /// What is wrong.
        reason: String,
    },
    /// The target's frame is not there, or not any more.
    #[error("no target: {0}")]
    NoFrame(String),
    /// The target's frame was not published for too long.
    #[error("frame {0} is not published any more")]
    StaleFrame(String),
}

impl Target {
    /// Subscribes to the target's topic, if it has one.
    ///
    /// # Errors
    /// [`NodeError`], if the topic's name is none.
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
        let waiting = Waiting::default();
        Ok(Self { source, fixed_frame, timeout, subscription, waiting, known: None, fault: None })
    }

    /// The frame in which targets stand still.
    pub(crate) fn fixed_frame(&self) -> &str {
        &self.fixed_frame
    }

    /// Takes a message if it is of the target's topic.
    pub(crate) fn take(&mut self, topic: &str, message: &AnyMessage, received: Instant) {
        if self.subscription.as_ref().is_none_or(|own| &**own.topic() != topic) {
            return;
        }
        match Sighting::of(message, received) {
            Ok(sighting) => self.waiting.push(sighting),
            Err(reason) => self.fault = Some(reason),
        }
    }

    /// Where the target is in the fixed frame.
    ///
    /// # Errors
    /// [`NoTarget`].
    pub(crate) fn position(&mut self, tree: &TransformTree, now: Time) -> Result<Point3<f64>, NoTarget> {
        if let TargetSource::Frame(frame) = &self.source {
            return self.position_of_frame(frame, tree, now);
        }
        match self.waiting.place(tree, &self.fixed_frame) {
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
