//! A camera on ROS topics: the newest picture and depth image, and the CameraInfo that came first.

use std::sync::Arc;
use std::time::{Duration, Instant};

use rcs_calibration::Lens;
use rcs_messages::{AnyMessage, MessageKind};
use rcs_ros::{NodeError, NodeEvent, RosNode, TopicSubscription};

use rcs_node_support::lifecycle::EndRequest;
use rcs_scan::{depth_of, lens_of_topic, picture_of, Camera, CameraError, CameraTopics, DepthFrame, DepthTopic, Frame};

/// How often a wait looks whether the program is to end.
const POLL_PERIOD: Duration = Duration::from_millis(100);
/// How long the first message of each topic may take: drivers start and connections are made.
const FIRST_MESSAGE: Duration = Duration::from_secs(10);
/// The newest message counts.
const QUEUE_SIZE: usize = 1;

/// A camera on topics of a node.
pub(super) struct RosCamera<'a> {
    node: &'a RosNode,
    end: &'a EndRequest,
    image: TopicSubscription,
    depth: Option<TopicSubscription>,
    lens: Lens,
    frame_id: String,
    newest_frame: Option<(AnyMessage, Instant)>,
    newest_depth: Option<AnyMessage>,
}

/// Why there is no camera.
#[derive(Debug, thiserror::Error)]
pub(super) enum ConnectError {
    /// A topic's name is none.
    #[error(transparent)]
    Node(#[from] NodeError),
    /// A topic is silent, or what it says cannot be used.
    #[error(transparent)]
    Camera(#[from] CameraError),
}

impl<'a> RosCamera<'a> {
    /// Subscribes and waits for the first message of each topic.
    ///
    /// # Errors
    /// [`ConnectError`] with the topic.
    pub(super) fn connect(node: &'a RosNode, end: &'a EndRequest, topics: &CameraTopics) -> Result<Self, ConnectError> {
        let started = Instant::now();
        let kind = |topic: &str| kind_of_images(node, end, topic, started + FIRST_MESSAGE);
        let image = node.subscribe(&topics.image, kind(&topics.image)?, QUEUE_SIZE)?;
        let depth = match &topics.depth {
            DepthTopic::Image(topic) => Some(node.subscribe(topic, kind(topic)?, QUEUE_SIZE)?),
            DepthTopic::Cloud(topic) => Some(node.subscribe(topic, MessageKind::PointCloud2, QUEUE_SIZE)?),
            DepthTopic::None => None,
        };
        let info = node.subscribe(&topics.camera_info, MessageKind::CameraInfo, QUEUE_SIZE)?;
        let info_topic = Arc::clone(info.topic());
        // The lens is known once the CameraInfo is there.
        let lens = Lens::pinhole([1, 1], [1.0, 1.0], [0.0, 0.0]);
        let (frame_id, newest_frame, newest_depth) = (String::new(), None, None);
        let mut camera = Self { node, end, image, depth, lens, frame_id, newest_frame, newest_depth };

        let mut newest_info = None;
        loop {
            for (topic, message) in camera.receive()? {
                if let (AnyMessage::CameraInfo(info), true) = (message, topic == info_topic) {
                    newest_info = Some(info);
                }
            }
            let waits_for_depth = camera.depth.as_ref().filter(|_| camera.newest_depth.is_none());
            let silent = match (&newest_info, &camera.newest_frame, waits_for_depth) {
                (None, ..) => &info_topic,
                (_, None, _) => camera.image.topic(),
                (.., Some(depth)) => depth.topic(),
                _ => break,
            };
            if started.elapsed() >= FIRST_MESSAGE {
                return Err(CameraError::Silent { topic: silent.to_string(), waited: FIRST_MESSAGE }.into());
            }
        }
        if let Some(info) = newest_info {
            camera.frame_id.clone_from(&info.header.frame_id);
            camera.lens = lens_of_topic(&info, camera.image.topic())
                .map_err(|reason| CameraError::Unusable { topic: info_topic.to_string(), reason })?;
        }
        Ok(camera)
    }

    /// Waits a moment, keeps the newest picture and depth image, and gives all other messages with their topics.
    fn receive(&mut self) -> Result<Vec<(Arc<str>, AnyMessage)>, CameraError> {
        if self.end.is_requested() {
            return Err(CameraError::Interrupted);
        }
        let mut others = Vec::new();
        for event in self.node.events().wait(POLL_PERIOD) {
            let NodeEvent::Message { topic, message, received, .. } = event else { continue };
            if self.depth.as_ref().is_some_and(|depth| *depth.topic() == topic) {
                self.newest_depth = Some(message);
            } else if *self.image.topic() == topic {
                self.newest_frame = Some((message, received));
            } else {
                others.push((topic, message));
            }
        }
        Ok(others)
    }

    fn unusable(topic: &TopicSubscription, reason: String) -> CameraError {
        CameraError::Unusable { topic: topic.topic().to_string(), reason }
    }
}

impl Camera for RosCamera<'_> {
    fn lens(&self) -> Lens {
        self.lens
    }

    fn frame_id(&self) -> String {
        self.frame_id.clone()
    }

    fn frame(&mut self, after: Instant, timeout: Duration) -> Result<Frame, CameraError> {
        let started = Instant::now();
        loop {
            if let Some((message, received)) = self.newest_frame.take_if(|(_, received)| *received > after) {
                let picture = picture_of(self.image.topic(), &message);
                let (size_px, grey) = picture.map_err(|reason| Self::unusable(&self.image, reason))?;
                return Ok(Frame { size_px, grey, received });
            }
            // A frame in the future is waited for, too.
            let silent = Instant::now().saturating_duration_since(started.max(after));
            if silent >= timeout {
                return Err(CameraError::Silent { topic: self.image.topic().to_string(), waited: timeout });
            }
            self.receive()?;
        }
    }

    fn has_depth(&self) -> bool {
        self.depth.is_some()
    }

    fn depth(&mut self) -> Result<Option<DepthFrame>, CameraError> {
        let (Some(topic), Some(message)) = (&self.depth, self.newest_depth.take()) else { return Ok(None) };
        depth_of(topic.topic(), &message).map(Some).map_err(|reason| Self::unusable(topic, reason))
    }
}

/// Whether images of a topic are compressed, by the type that the master has of it. A driver may start later.
///
/// # Errors
/// [`CameraError`]: nobody publishes it up to the deadline, or the program is to end; and [`NodeError`] for a name that
/// is none.
fn kind_of_images(
    node: &RosNode,
    end: &EndRequest,
    topic: &str,
    deadline: Instant,
) -> Result<MessageKind, ConnectError> {
    let name = node.resolve(topic)?;
    loop {
        // As the node knows them: a master that hangs must not hold up the end.
        let publications = node.publications();
        if let Some(publication) = publications.as_ref().and_then(|publications| publications.get(&name)) {
            let is_packed = publication.ros_type == MessageKind::CompressedImage.ros_type();
            return Ok(if is_packed { MessageKind::CompressedImage } else { MessageKind::Image });
        }
        if Instant::now() >= deadline {
            return Err(CameraError::Silent { topic: name, waited: FIRST_MESSAGE }.into());
        }
        if end.wait_for(POLL_PERIOD) {
            return Err(CameraError::Interrupted.into());
        }
    }
}
