//! A camera on ROS topics: the newest image and depth image, and the first CameraInfo.

use std::sync::Arc;
use std::time::{Duration, Instant};

use nalgebra::Isometry3;
use rcs_calibration::Lens;
use rcs_files::capture::CapturedRobot;
use rcs_files::projector::StaticFrame;
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_messages::{AnyMessage, MessageKind};
use rcs_node_support::lifecycle::EndRequest;
use rcs_ros::{NodeError, NodeEvent, RosNode, TopicSubscription};
use rcs_scan::{depth_of, grey_image, lens_of_topic};
use rcs_scan::{CameraFrame, CameraTopics, DepthFrame, DepthTopic, ScanCamera, ScanCameraError, ScanFailure};

use super::known_topics::silent_topic;
use crate::known_projector::KnownProjector;
use crate::placing::{projector_from_parent, tf_failed, RobotFrames, TF_TIMEOUT};
use crate::Failure;

/// Time between two checks for the end of the program.
const POLL_PERIOD: Duration = Duration::from_millis(100);
/// Timeout for the first message of each topic: drivers start and connections are made.
const FIRST_MESSAGE: Duration = Duration::from_secs(10);
/// The parameter of the robot's description.
const ROBOT_DESCRIPTION: &str = "robot_description";
/// Timeout for a CameraInfo that may be missing.
const OPTIONAL_INFO: Duration = Duration::from_secs(3);
/// Only the newest message counts.
const QUEUE_SIZE: usize = 1;

/// A camera on topics of a node.
pub(crate) struct RosCamera<'a> {
    node: &'a RosNode,
    end: &'a EndRequest,
    image: TopicSubscription,
    depth: Option<TopicSubscription>,
    info: TopicSubscription,
    lens: Lens,
    is_calibrated: bool,
    frame_id: String,
    newest_frame: Option<(AnyMessage, Instant)>,
    newest_depth: Option<AnyMessage>,
    first_info: Option<Arc<CameraInfo>>,
    robot: RobotListener,
}

/// A projector of a file, and the camera.
pub(crate) struct PlacedProjector {
    /// The projector's frame by the file.
    pub(crate) frame: StaticFrame,
    /// The camera in that frame's parent.
    pub(crate) parent_from_camera: Isometry3<f64>,
}

impl PlacedProjector {
    /// The projector's pose by the file, from the camera's optical frame.
    pub(crate) fn projector_from_camera(&self) -> Isometry3<f64> {
        projector_from_parent(&self.frame) * self.parent_from_camera
    }
}

/// What TF and the robot's description say, once they are followed.
#[derive(Default)]
struct RobotListener {
    frames: RobotFrames,
    description: Option<Arc<str>>,
}

impl RobotListener {
    fn add(&mut self, event: &NodeEvent) {
        match event {
            NodeEvent::Parameter { text: Some(text), .. } => self.description = Some(Arc::clone(text)),
            event => self.frames.add(event),
        }
    }
}

impl<'a> RosCamera<'a> {
    /// Subscribes and waits for the first message of each topic. A camera without calibration is accepted if
    /// `needs_lens` is `false`: its CameraInfo is missing, or its focal length 0.
    ///
    /// # Errors
    /// A topic's invalid name, or [`ScanCameraError`] with the topic.
    pub(crate) fn connect(
        node: &'a RosNode,
        end: &'a EndRequest,
        topics: &CameraTopics,
        needs_lens: bool,
    ) -> anyhow::Result<Self> {
        let started = Instant::now();
        let kind = |topic: &str| kind_of_images(node, end, topic, started + FIRST_MESSAGE);
        let image = node.subscribe(&topics.image, kind(&topics.image)?, QUEUE_SIZE)?;
        let depth = match &topics.depth {
            DepthTopic::Image(topic) => Some(node.subscribe(topic, kind(topic)?, QUEUE_SIZE)?),
            DepthTopic::Cloud(topic) => Some(node.subscribe(topic, MessageKind::PointCloud2, QUEUE_SIZE)?),
            DepthTopic::None => None,
        };
        let info = node.subscribe(&topics.camera_info, MessageKind::CameraInfo, QUEUE_SIZE)?;
        // The lens is known once the CameraInfo is there.
        let lens = Lens::pinhole([1, 1], [1.0, 1.0], [0.0, 0.0]);
        let (frame_id, newest_frame, newest_depth, first_info) = (String::new(), None, None, None);
        let robot = RobotListener::default();
        let mut camera = Self {
            node,
            end,
            image,
            depth,
            info,
            lens,
            is_calibrated: true,
            frame_id,
            newest_frame,
            newest_depth,
            first_info,
            robot,
        };
        while let Some(topic) = camera.missing() {
            let is_info = topic.topic() == camera.info.topic();
            if !needs_lens && is_info && camera.newest_frame.is_some() && started.elapsed() >= OPTIONAL_INFO {
                break;
            }
            if started.elapsed() >= FIRST_MESSAGE {
                return Err(silent_topic(node, topic.topic(), topic.kind(), FIRST_MESSAGE).into());
            }
            camera.receive()?;
        }
        let info = camera.first_info.take();
        if let Some(info) = &info {
            camera.frame_id.clone_from(&info.header.frame_id);
        }
        match info.filter(|info| needs_lens || info.K[0] != 0.0) {
            Some(info) => {
                camera.lens = lens_of_topic(&info, camera.image.topic())
                    .map_err(|reason| Self::unusable(&camera.info, reason))?;
            }
            None => {
                camera.is_calibrated = false;
                camera.lens = camera.lens_by_image()?;
            }
        }
        Ok(camera)
    }

    /// A lens of the images' size, whose other numbers mean nothing.
    fn lens_by_image(&self) -> Result<Lens, ScanCameraError> {
        let [width, height] = match &self.newest_frame {
            Some((message, _)) => {
                grey_image(self.image.topic(), message).map_err(|reason| Self::unusable(&self.image, reason))?.0
            }
            None => [1, 1],
        };
        let [middle_x, middle_y] = [width, height].map(|side| 0.5 * (f64::from(side) - 1.0));
        Ok(Lens::pinhole([width, height], [f64::from(width); 2], [middle_x, middle_y]))
    }

    /// `true` if the camera has a CameraInfo.
    pub(crate) fn is_calibrated(&self) -> bool {
        self.is_calibrated
    }

    /// A topic without a message so far.
    fn missing(&self) -> Option<&TopicSubscription> {
        let info = self.first_info.is_none().then_some(&self.info);
        let image = || self.newest_frame.is_none().then_some(&self.image);
        info.or_else(image).or_else(|| self.depth.as_ref().filter(|_| self.newest_depth.is_none()))
    }

    /// Waits up to [`POLL_PERIOD`] for messages and keeps them.
    fn receive(&mut self) -> Result<(), ScanCameraError> {
        if self.end.is_requested() {
            return Err(ScanCameraError::Interrupted);
        }
        for event in self.node.events().wait(POLL_PERIOD) {
            self.robot.add(&event);
            let NodeEvent::Message { topic, message, received, .. } = event else { continue };
            if self.depth.as_ref().is_some_and(|depth| *depth.topic() == topic) {
                self.newest_depth = Some(message);
            } else if *self.image.topic() == topic {
                self.newest_frame = Some((message, received));
            } else if let (AnyMessage::CameraInfo(info), true) = (message, *self.info.topic() == topic) {
                self.first_info = Some(info);
            }
        }
        Ok(())
    }

    /// Follows TF and the robot's description from now on.
    ///
    /// # Errors
    /// TF cannot be subscribed to.
    pub(crate) fn follow_robot(&self) -> Result<(), NodeError> {
        self.node.follow_parameters(vec![ROBOT_DESCRIPTION.to_owned()]);
        self.node.subscribe_transforms()
    }

    /// The robot as it is now, by what was received since it is followed.
    pub(crate) fn robot(&self) -> CapturedRobot {
        self.robot.frames.captured(&self.frame_id, self.robot.description.as_deref())
    }

    /// Stops receiving images and depth images, or goes on.
    pub(crate) fn set_paused(&mut self, is_paused: bool) {
        [Some(&self.image), self.depth.as_ref()].into_iter().flatten().for_each(|topic| topic.set_paused(is_paused));
        (self.newest_frame, self.newest_depth) = (None, None);
    }

    /// Where the projector of a file is, in a frame that TF or the file's other frames place the camera in. The robot
    /// must be followed.
    ///
    /// # Errors
    /// [`Failure`]: the file does not place it, or a frame is missing.
    pub(crate) fn place(&mut self, projector: &KnownProjector) -> Result<PlacedProjector, Failure> {
        let frame = projector.frame()?.clone();
        self.robot.frames.add_file(&projector.file);
        let camera = if self.frame_id.is_empty() { frame.parent.clone() } else { self.frame_id.clone() };
        let parent_from_camera = self.look_up(&frame.parent, &camera)?;
        Ok(PlacedProjector { frame, parent_from_camera })
    }

    /// The newest `target_from_source` by TF.
    ///
    /// # Errors
    /// [`Failure::Refused`]: a frame is missing.
    pub(crate) fn look_up(&mut self, target: &str, source: &str) -> Result<Isometry3<f64>, Failure> {
        let until = Instant::now() + TF_TIMEOUT;
        loop {
            match self.robot.frames.newest(target, source) {
                Ok(transform) => return Ok(transform),
                Err(error) if Instant::now() > until => return Err(tf_failed(error)),
                Err(_) => self.receive().map_err(ScanFailure::from)?,
            }
        }
    }

    fn unusable(topic: &TopicSubscription, reason: String) -> ScanCameraError {
        ScanCameraError::Unusable { topic: topic.topic().to_string(), reason }
    }
}

impl ScanCamera for RosCamera<'_> {
    fn lens(&self) -> Lens {
        self.lens
    }

    fn frame_id(&self) -> String {
        self.frame_id.clone()
    }

    fn frame(&mut self, after: Instant, timeout: Duration) -> Result<CameraFrame, ScanCameraError> {
        let started = Instant::now();
        loop {
            if let Some((message, received)) = self.newest_frame.take_if(|(_, received)| *received > after) {
                let image = grey_image(self.image.topic(), &message);
                let (size_px, grey) = image.map_err(|reason| Self::unusable(&self.image, reason))?;
                return Ok(CameraFrame { size_px, grey, received });
            }
            // `after` may lie in the future.
            let silent = Instant::now().saturating_duration_since(started.max(after));
            if silent >= timeout {
                return Err(silent_topic(self.node, self.image.topic(), self.image.kind(), timeout));
            }
            self.receive()?;
        }
    }

    fn has_depth(&self) -> bool {
        self.depth.is_some()
    }

    fn depth(&mut self) -> Result<Option<DepthFrame>, ScanCameraError> {
        let (Some(topic), Some(message)) = (&self.depth, self.newest_depth.take()) else { return Ok(None) };
        depth_of(topic.topic(), &message).map(Some).map_err(|reason| Self::unusable(topic, reason))
    }
}

/// The type of an image topic, plain or compressed, as the master knows it. A driver may start later.
///
/// # Errors
/// An invalid name; [`ScanCameraError`]: nobody publishes it up to the deadline, or the program is to end.
fn kind_of_images(node: &RosNode, end: &EndRequest, topic: &str, deadline: Instant) -> anyhow::Result<MessageKind> {
    let name = node.resolve(topic)?;
    loop {
        // The node's own copy: a master that hangs must not hold up the end.
        let publications = node.publications();
        if let Some(publication) = publications.as_ref().and_then(|publications| publications.get(&name)) {
            let is_packed = publication.ros_type == MessageKind::CompressedImage.ros_type();
            return Ok(if is_packed { MessageKind::CompressedImage } else { MessageKind::Image });
        }
        if Instant::now() >= deadline {
            return Err(silent_topic(node, &name, MessageKind::Image, FIRST_MESSAGE).into());
        }
        if end.wait_for(POLL_PERIOD) {
            return Err(ScanCameraError::Interrupted.into());
        }
    }
}
