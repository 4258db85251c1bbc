//! A camera on ROS topics: the newest picture and depth image, and the CameraInfo that came first.

use std::sync::Arc;
use std::time::{Duration, Instant};

use rcs_calibration::Lens;
use rcs_files::projector::ProjectorFile;
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_messages::{AnyMessage, MessageKind};
use rcs_ros::{NodeError, NodeEvent, RosNode, TopicSubscription};

use super::devices::{Camera, CameraError, DepthFrame, Frame};
use super::received::{cloud_depths_m, depths_m, grey_levels};
use crate::small_node::EndRequest;

/// How often a wait looks whether the program is to end.
const POLL_PERIOD: Duration = Duration::from_millis(100);
/// How long the first message of each topic may take: drivers start and connections are made.
const FIRST_MESSAGE: Duration = Duration::from_secs(10);
/// The newest message counts.
const QUEUE_SIZE: usize = 1;

/// Where depth comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum DepthTopic {
    /// A depth image that is registered to the pictures.
    Image(String),
    /// An organised cloud with a point for each pixel.
    Cloud(String),
    /// Nowhere.
    None,
}

/// The topics of a camera.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct CameraTopics {
    /// Its pictures.
    pub(super) image: String,
    /// Its CameraInfo.
    pub(super) camera_info: String,
    /// Its depth.
    pub(super) depth: DepthTopic,
}

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
        let image = node.subscribe(&topics.image, MessageKind::Image, QUEUE_SIZE)?;
        let depth = match &topics.depth {
            DepthTopic::Image(topic) => Some(node.subscribe(topic, MessageKind::Image, QUEUE_SIZE)?),
            DepthTopic::Cloud(topic) => Some(node.subscribe(topic, MessageKind::PointCloud2, QUEUE_SIZE)?),
            DepthTopic::None => None,
        };
        let info = node.subscribe(&topics.camera_info, MessageKind::CameraInfo, QUEUE_SIZE)?;
        let info_topic = Arc::clone(info.topic());
        // The lens is known once the CameraInfo is there.
        let lens = Lens::pinhole([1, 1], [1.0, 1.0], [0.0, 0.0]);
        let (frame_id, newest_frame, newest_depth) = (String::new(), None, None);
        let mut camera = Self { node, end, image, depth, lens, frame_id, newest_frame, newest_depth };

        let started = Instant::now();
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
            camera.lens = lens_of(&info, is_rectified(camera.image.topic()))
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
            if let Some((AnyMessage::Image(image), received)) =
                self.newest_frame.take_if(|(_, received)| *received > after)
            {
                let grey = grey_levels(&image).map_err(|reason| Self::unusable(&self.image, reason))?;
                return Ok(Frame { size_px: [image.width, image.height], grey, received });
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
        let (size_px, depths) = match &message {
            AnyMessage::Image(image) => ([image.width, image.height], depths_m(image)),
            AnyMessage::PointCloud2(cloud) => ([cloud.width, cloud.height], cloud_depths_m(cloud)),
            _ => return Ok(None),
        };
        let depth_m = depths.map_err(|reason| Self::unusable(topic, reason))?;
        Ok(Some(DepthFrame { size_px, depth_m }))
    }
}

/// Whether a topic has rectified pictures, by the names of image_proc.
fn is_rectified(topic: &str) -> bool {
    topic.rsplit('/').next().is_some_and(|name| name.starts_with("image_rect"))
}

/// The lens of a CameraInfo: K and D for raw pictures, the left part of P for rectified ones.
///
/// # Errors
/// What is wrong with it.
fn lens_of(info: &CameraInfo, is_rectified: bool) -> Result<Lens, String> {
    let mut camera_info = info.clone();
    if is_rectified {
        let [fx, skew, cx, _, below, fy, cy, ..] = info.P;
        camera_info.K = [fx, skew, cx, below, fy, cy, 0.0, 0.0, 1.0];
        camera_info.D.clear();
        camera_info.distortion_model.clear();
    }
    if camera_info.width == 0 || camera_info.height == 0 {
        return Err(format!("the camera's size is {}x{} pixels", camera_info.width, camera_info.height));
    }
    let file = ProjectorFile { camera_info, camera_info_topic: None, frames: Vec::new(), ignored_keys: Vec::new() };
    file.lens().map_err(|problem| problem.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rectified_pictures_have_another_lens() {
        let info = CameraInfo {
            width: 640,
            height: 480,
            distortion_model: "plumb_bob".to_owned(),
            D: vec![0.1, 0.0, 0.0, 0.0, 0.0],
            K: [500.0, 0.0, 320.0, 0.0, 501.0, 240.0, 0.0, 0.0, 1.0],
            P: [510.0, 0.0, 321.0, 0.0, 0.0, 511.0, 241.0, 0.0, 0.0, 0.0, 1.0, 0.0],
            ..CameraInfo::default()
        };
        let (raw, rectified) = (lens_of(&info, false).unwrap(), lens_of(&info, true).unwrap());
        assert_eq!((raw.focal_px.x, raw.distortion.coefficients()[0]), (500.0, 0.1));
        assert_eq!(rectified, Lens::pinhole([640, 480], [510.0, 511.0], [321.0, 241.0]));
        assert!(is_rectified("/camera/rgb/image_rect_color") && !is_rectified("/camera/rgb/image_raw"));
    }

    #[test]
    fn an_uncalibrated_camera_is_an_error() {
        let info = CameraInfo { width: 640, height: 480, ..CameraInfo::default() };
        assert!(lens_of(&info, false).unwrap_err().contains("K"));
        assert!(lens_of(&CameraInfo::default(), false).unwrap_err().contains("0x0"));
    }
}
