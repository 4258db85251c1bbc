//! Plays a bag's messages to a scene, as the node does with those that it receives.

use std::collections::BTreeSet;
use std::time::Duration;

use anyhow::Result;
use rcs_bag::{Bag, BagMessage, Connection};
use rcs_camera::CameraModel;
use rcs_displays::CameraView;
use rcs_messages::tf2_msgs::TFMessage;
use rcs_messages::{AnyMessage, MessageKind};
use rcs_text::full_name;
use rcs_transforms::Time;

use super::moments::BagTimes;
use super::projector::ProjectorOverride;
use super::ros_time::{clock_jumps_back, clock_of, is_clock, RosTime};
use crate::scene::status_log::StatusLog;
use crate::scene::{camera, status_tree, SceneState};

/// Plays a bag's messages to a scene.
pub(super) struct Player {
    messages: std::iter::Peekable<rcs_bag::Messages>,
    /// The topics of the config: the full name, the config's name, and the expected type.
    wanted: Vec<(String, String, MessageKind)>,
    ros_time: RosTime,
    pub(super) times: BagTimes,
    /// The clock's times before and after it jumped back.
    jump: Option<(Time, Time)>,
    /// The times of the first and last transforms since the displays were updated.
    pending_transforms: Option<(Time, Time)>,
    /// Replaces the bag's CameraInfo and frames.
    projector: Option<ProjectorOverride>,
    pub(super) status_log: StatusLog,
}

/// Period of transforms that the displays are updated with at once, as rviz is once per image.
const UPDATE_PERIOD: Duration = Duration::from_millis(33);

/// The topics of transforms.
const TRANSFORMS: [&str; 2] = ["/tf", "/tf_static"];

fn is_transforms(connection: &Connection) -> bool {
    TRANSFORMS.contains(&&*full_name(&connection.topic)) && connection.holds(MessageKind::TFMessage)
}

impl Player {
    pub(super) fn new(scene: &SceneState, bag: &Bag, times: BagTimes, projector: Option<ProjectorOverride>) -> Self {
        let requests = scene.topics();
        let wanted: Vec<(String, String, MessageKind)> =
            requests.into_iter().map(|request| (full_name(&request.topic), request.topic, request.kind)).collect();
        warn_of_other_types(bag, &wanted);
        let is_wanted = |connection: &Connection| {
            let name = full_name(&connection.topic);
            let is_it = |(full, _, kind): &(String, String, MessageKind)| *full == name && connection.holds(*kind);
            is_transforms(connection) || is_clock(connection) || wanted.iter().any(is_it)
        };
        let messages = bag.messages(is_wanted).peekable();
        let (ros_time, status_log) = (RosTime::new(times), StatusLog::default());
        Self { messages, wanted, ros_time, times, jump: None, pending_transforms: None, projector, status_log }
    }

    /// Plays all messages up to a time.
    ///
    /// # Errors
    /// The bag's clock jumps back.
    pub(super) fn play_until(&mut self, scene: &mut SceneState, moment: Time) -> Result<()> {
        while self.play_next(scene, moment).is_some() {}
        self.update_with_transforms(scene);
        if let Some((from, to)) = self.jump {
            return clock_jumps_back(from, to);
        }
        // At the clock's last time nothing is left, unless it comes back from later ones.
        match (self.ros_time, self.messages.peek()) {
            (RosTime::Clock(_), Some(Ok(next))) if moment >= self.times.end => {
                clock_jumps_back(self.ros_time.of(next), self.times.end)
            }
            _ => Ok(()),
        }
    }

    /// Plays all messages up to a time, and then those until there is the camera. Returns the time of the last of
    /// those, or that time if the camera is there already; `None` if there is no camera by the other time.
    pub(super) fn play_until_camera(
        &mut self,
        scene: &mut SceneState,
        view: &CameraView,
        model: CameraModel,
        [moment, last]: [Time; 2],
    ) -> Result<Option<Time>> {
        self.play_until(scene, moment)?;
        let mut reached = moment;
        while camera(scene, view, model).is_err() {
            let Some(played) = self.play_next(scene, last) else { return Ok(None) };
            reached = played.max(moment);
        }
        Ok(Some(reached))
    }

    /// Plays one message, unless it is after a time. Returns its time.
    fn play_next(&mut self, scene: &mut SceneState, last: Time) -> Option<Time> {
        let ros_time = self.ros_time;
        if self.messages.peek()?.as_ref().is_ok_and(|message| ros_time.of(message) > last) {
            return None;
        }
        match self.messages.next()? {
            Ok(message) => {
                let now = ros_time.of(&message);
                match (ros_time, clock_of(&message)) {
                    (RosTime::Clock(before), Some(clock)) => {
                        self.jump = self.jump.or((clock < before).then_some((before, clock)));
                        self.ros_time = RosTime::Clock(clock);
                    }
                    _ => self.play(scene, &message, now),
                }
                if self.status_log.is_due(now) {
                    self.status_log.check(&status_tree::scene(scene, now), now);
                }
                Some(now)
            }
            Err(error) => {
                log::warn!("{error}");
                Some(Time::ZERO)
            }
        }
    }

    /// Updates the displays with the transforms since their last update, at the time of the last of those.
    fn update_with_transforms(&mut self, scene: &mut SceneState) {
        if let Some((_, last)) = self.pending_transforms.take() {
            scene.update(last);
        }
    }

    fn play(&mut self, scene: &mut SceneState, message: &BagMessage, now: Time) {
        let connection = &message.connection;
        let name = full_name(&connection.topic);
        let damaged = |error: &dyn std::fmt::Display| log::warn!("topic {name}: cannot decode a message: {error}");
        if self.pending_transforms.is_some_and(|(first, _)| now.saturating_since(first) >= UPDATE_PERIOD) {
            self.update_with_transforms(scene);
        }
        if is_transforms(connection) {
            let first = self.pending_transforms.map_or(now, |(first, _)| first);
            self.pending_transforms = Some((first, now));
            match MessageKind::TFMessage.decode(&message.bytes) {
                Ok(AnyMessage::TFMessage(transforms)) => {
                    let transforms = self.without_projectors(&transforms);
                    scene.take_transforms(&transforms, name == "/tf_static", &connection.publisher);
                }
                Ok(_) => {}
                Err(error) => damaged(&error),
            }
            return;
        }
        let is_it = |(full, _, kind): &&(String, String, MessageKind)| *full == name && connection.holds(*kind);
        for (_, topic, kind) in self.wanted.iter().filter(is_it) {
            if *kind == MessageKind::CameraInfo && self.projector.as_ref().is_some_and(|own| own.topic == *topic) {
                continue;
            }
            match kind.decode(&message.bytes) {
                Ok(message) => scene.take(topic, &message, now),
                Err(error) => damaged(&error),
            }
        }
        self.pending_transforms = None;
        scene.update(now);
    }

    /// The transforms without those of frames that the projector's file places.
    fn without_projectors(&self, message: &TFMessage) -> TFMessage {
        let mut message = message.clone();
        if let Some(projector) = &self.projector {
            message.transforms.retain(|transform| !projector.places(&transform.child_frame_id));
        }
        message
    }
}

/// Warns about messages of another type than the config expects on their topic. One of several types that a topic has
/// may be for another display.
fn warn_of_other_types(bag: &Bag, wanted: &[(String, String, MessageKind)]) {
    let transforms = TRANSFORMS.map(|name| (name.to_owned(), name.to_owned(), MessageKind::TFMessage));
    let mut warnings = BTreeSet::new();
    for connection in bag.connections() {
        let name = full_name(&connection.topic);
        let takers: Vec<_> = wanted.iter().chain(&transforms).filter(|(full, ..)| *full == name).collect();
        let is_taken = takers.iter().any(|(.., kind)| connection.holds(*kind));
        let is_held = |kind| bag.connections().any(|other| full_name(&other.topic) == name && other.holds(kind));
        for (_, topic, kind) in takers {
            if !(connection.holds(*kind) || is_taken && is_held(*kind)) {
                warnings.insert(format!(
                    "topic {topic} holds {} in the bag, not {}",
                    connection.held(),
                    kind.ros_type()
                ));
            }
        }
    }
    warnings.iter().for_each(|warning| log::warn!("{warning}"));
}
