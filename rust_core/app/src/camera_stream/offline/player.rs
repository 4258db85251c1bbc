//! A bag's messages, handed to a stage as the node hands it those that it receives.

use std::time::Duration;

use rcs_bag::{full_name, Bag, BagMessage, Connection};
use rcs_camera::CameraModel;
use rcs_displays::{time_from_stamp, CameraView};
use rcs_messages::tf2_msgs::TFMessage;
use rcs_messages::{AnyMessage, MessageKind};
use rcs_transforms::Time;

use super::projector::Projector;
use crate::camera_stream::stage::Stage;
use crate::camera_stream::status_log::StatusLog;

/// Plays a bag's messages to a stage.
pub(super) struct Player {
    messages: std::iter::Peekable<rcs_bag::Messages>,
    /// The topics of the config: the full name, the config's name, and the type that it expects.
    wanted: Vec<(String, String, MessageKind)>,
    /// When the first and the last of the transforms were recorded that the displays were not yet updated with.
    unseen_transforms: Option<(Time, Time)>,
    /// What takes the place of the bag's CameraInfo and frames.
    projector: Option<Projector>,
    pub(super) status_log: StatusLog,
}

/// The displays are updated with the transforms of so much time at once, as rviz is once a picture.
const UPDATE_PERIOD: Duration = Duration::from_millis(33);

fn is_transforms(connection: &Connection) -> bool {
    matches!(&*full_name(&connection.topic), "/tf" | "/tf_static")
}

impl Player {
    pub(super) fn new(stage: &Stage, bag: &Bag, projector: Option<Projector>) -> Self {
        let requests = stage.topics();
        let wanted: Vec<(String, String, MessageKind)> =
            requests.into_iter().map(|request| (full_name(&request.topic), request.topic, request.kind)).collect();
        for connection in bag.connections() {
            for (_, topic, kind) in wanted.iter().filter(|(name, ..)| *name == full_name(&connection.topic)) {
                if kind.ros_type() != &*connection.ros_type {
                    log::warn!("topic {topic} holds {} in the bag, not {}", connection.ros_type, kind.ros_type());
                }
            }
        }
        let names: Vec<String> = wanted.iter().map(|(name, ..)| name.clone()).collect();
        let messages =
            bag.messages(|connection| is_transforms(connection) || names.contains(&full_name(&connection.topic)));
        let (messages, status_log) = (messages.peekable(), StatusLog::default());
        Self { messages, wanted, unseen_transforms: None, projector, status_log }
    }

    /// Plays all messages up to a time.
    pub(super) fn play_until(&mut self, stage: &mut Stage, moment: Time) {
        while self.play_next(stage, moment).is_some() {}
        self.update_with_transforms(stage);
    }

    /// Plays all messages up to a time, and then those until there is the camera. Returns the time of the last of
    /// those, or that time if the camera is there already; `None` if there is no camera by the other time.
    pub(super) fn play_until_camera(
        &mut self,
        stage: &mut Stage,
        view: &CameraView,
        model: CameraModel,
        [moment, last]: [Time; 2],
    ) -> Option<Time> {
        self.play_until(stage, moment);
        let mut reached = moment;
        while stage.camera(view, model).is_err() {
            reached = self.play_next(stage, last)?.max(moment);
        }
        Some(reached)
    }

    /// Plays one message, unless it is after a time. Returns its time.
    fn play_next(&mut self, stage: &mut Stage, last: Time) -> Option<Time> {
        if self.messages.peek()?.as_ref().is_ok_and(|message| time_from_stamp(message.time) > last) {
            return None;
        }
        match self.messages.next()? {
            Ok(message) => {
                self.play(stage, &message);
                let now = time_from_stamp(message.time);
                if self.status_log.is_due(now) {
                    self.status_log.check(&stage.status_entries(now), now);
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
    fn update_with_transforms(&mut self, stage: &mut Stage) {
        if let Some((_, last)) = self.unseen_transforms.take() {
            stage.update(last);
        }
    }

    fn play(&mut self, stage: &mut Stage, message: &BagMessage) {
        let connection = &message.connection;
        let name = full_name(&connection.topic);
        let damaged = |error: &dyn std::fmt::Display| log::warn!("topic {name}: cannot decode a message: {error}");
        let now = time_from_stamp(message.time);
        if self.unseen_transforms.is_some_and(|(first, _)| now.saturating_since(first) >= UPDATE_PERIOD) {
            self.update_with_transforms(stage);
        }
        if is_transforms(connection) {
            let first = self.unseen_transforms.map_or(now, |(first, _)| first);
            self.unseen_transforms = Some((first, now));
            match MessageKind::TFMessage.decode(&message.bytes) {
                Ok(AnyMessage::TFMessage(transforms)) => {
                    let transforms = self.without_projectors(&transforms);
                    stage.take_transforms(&transforms, name == "/tf_static", &connection.publisher);
                }
                Ok(_) => {}
                Err(error) => damaged(&error),
            }
            return;
        }
        for (_, topic, kind) in self.wanted.iter().filter(|(full, ..)| *full == name) {
            if kind.ros_type() != &*connection.ros_type {
                continue;
            }
            if *kind == MessageKind::CameraInfo && self.projector.as_ref().is_some_and(|own| own.topic == *topic) {
                continue;
            }
            match kind.decode(&message.bytes) {
                Ok(message) => stage.take(topic, &message, now),
                Err(error) => damaged(&error),
            }
        }
        self.unseen_transforms = None;
        stage.update(now);
    }

    /// The transforms but for those of frames that the projector's file places.
    fn without_projectors(&self, message: &TFMessage) -> TFMessage {
        let mut message = message.clone();
        if let Some(projector) = &self.projector {
            message.transforms.retain(|transform| !projector.places(&transform.child_frame_id));
        }
        message
    }
}
