//! The bag of a recorded scan: the topics of a camera while patterns were shown. Times are since its beginning.

use std::ops::{ControlFlow, Range};
use std::path::PathBuf;
use std::time::Duration;

use rcs_bag::{Bag, Connection};
use rcs_calibration::patterns::Pattern;
use rcs_calibration::Lens;
use rcs_displays::raw_transforms;
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_messages::{AnyMessage, MessageKind, Time};
use rcs_text::full_name;
use rcs_transforms::TransformTree;

use crate::camera_messages::{depth_of, grey_image, lens_of_topic};
use crate::devices::{CameraTopics, DepthFrame, DepthTopic, ScanCameraError};
use crate::failure::ScanFailure;

/// A visitor of frames: number, time, width and height in pixels, grey levels row by row from the top.
pub(crate) type VisitFrame<'a> = dyn FnMut(usize, Duration, [u32; 2], Vec<u8>) -> Result<(), ScanFailure> + 'a;

/// A visitor of depth images.
pub(crate) type VisitDepth<'a> = dyn FnMut(DepthFrame) -> Result<(), ScanFailure> + 'a;

/// An image that was shown with the projector.
pub(crate) struct ShownImage {
    /// Time of publication.
    pub(crate) at: Duration,
    /// Its pattern; `None` for other images.
    pub(crate) pattern: Option<Pattern>,
}

/// Age up to which moving transforms count.
const RECENT: Duration = Duration::from_secs(10);

/// Types of image messages.
const IMAGES: &[MessageKind] = &[MessageKind::Image, MessageKind::CompressedImage];

/// A bag with the topics of a camera.
pub struct BagFootage {
    bag: Bag,
    /// Its name in messages.
    pub(crate) name: String,
    image: String,
    /// The topic of depth, and its types.
    depth: Option<(String, &'static [MessageKind])>,
    /// The topic on which the patterns were shown.
    shown: Option<String>,
    /// Time of the bag's first message, nanoseconds.
    beginning: i64,
    /// Time since then of the first message that counts.
    start: Duration,
    /// The camera's lens; its size is that of all frames.
    pub lens: Lens,
    /// The camera's optical frame; may be empty.
    pub(crate) frame_id: String,
}

impl BagFootage {
    /// Opens bags, of which messages in the first `start` do not count. `shown` is the topic on which the patterns were
    /// shown, if the bag has it.
    ///
    /// # Errors
    /// [`ScanFailure`]: an unreadable bag, a topic that is missing or of another type, an unusable CameraInfo.
    pub fn open(
        paths: &[PathBuf],
        topics: &CameraTopics,
        shown: Option<&str>,
        start: Duration,
    ) -> Result<Self, ScanFailure> {
        let bag = Bag::open_all(paths)?;
        let beginning = bag.time_range().map_or(0, |(first, _)| first.nanos());
        let depth = match &topics.depth {
            DepthTopic::Image(topic) => Some((full_name(topic), IMAGES)),
            DepthTopic::Cloud(topic) => Some((full_name(topic), &[MessageKind::PointCloud2][..])),
            DepthTopic::None => None,
        };
        let mut footage = Self {
            bag,
            name: paths.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", "),
            image: full_name(&topics.image),
            depth,
            shown: shown.map(full_name),
            beginning,
            start,
            lens: Lens::pinhole([1, 1], [1.0, 1.0], [0.0, 0.0]),
            frame_id: String::new(),
        };
        footage.check_topic(&footage.image, IMAGES)?;
        footage.depth.iter().try_for_each(|(topic, kinds)| footage.check_topic(topic, kinds))?;
        footage.shown.iter().try_for_each(|topic| footage.check_topic(topic, IMAGES))?;
        let info_topic = full_name(&topics.camera_info);
        footage.check_topic(&info_topic, &[MessageKind::CameraInfo])?;
        let info = footage.camera_info(&info_topic)?;
        footage.lens = lens_of_topic(&info, &footage.image).map_err(|reason| unusable(&info_topic, reason))?;
        footage.frame_id.clone_from(&info.header.frame_id);
        Ok(footage)
    }

    /// Checks that a topic has messages of one of these types. It may have others, which do not count.
    fn check_topic(&self, topic: &str, kinds: &[MessageKind]) -> Result<(), ScanFailure> {
        let types: Vec<&str> = kinds.iter().map(|kind| kind.ros_type()).collect();
        let connections = || self.bag.connections();
        let is_one = |connection: &Connection| holds_any(connection, kinds);
        let of_topic = || connections().filter(|connection| full_name(&connection.topic) == topic);
        let reason = match of_topic().find(|connection| is_one(connection)).or_else(|| of_topic().next()) {
            Some(connection) if is_one(connection) => return Ok(()),
            Some(connection) => format!("holds {} in the bag, not {}", connection.held(), types.join(" or ")),
            None => {
                let mut names: Vec<&str> = connections()
                    .filter(|connection| is_one(connection))
                    .map(|connection| &*connection.topic)
                    .collect();
                names.sort_unstable();
                names.dedup();
                let has = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
                format!("not in {}, whose topics with {} are: {has}", self.name, types.join(" or "))
            }
        };
        Err(unusable(topic, reason))
    }

    /// Visits the messages of a topic of one of these types from a time on. The visitor decodes those that it needs.
    fn messages(
        &self,
        (topic, kinds): (&str, &[MessageKind]),
        from: Duration,
        visit: &mut VisitMessage<'_>,
    ) -> Result<(), ScanFailure> {
        const LAST: Time = Time { sec: u32::MAX, nsec: 999_999_999 };
        let from = self.beginning.saturating_add(i64::try_from(from.as_nanos()).unwrap_or(i64::MAX)).min(LAST.nanos());
        let of_topic = |connection: &Connection| full_name(&connection.topic) == topic && holds_any(connection, kinds);
        for message in self.bag.messages_from(Time::from_nanos(from), of_topic) {
            let message = message?;
            let nanos = message.time.nanos().saturating_sub(self.beginning);
            let time = Duration::from_nanos(u64::try_from(nanos).unwrap_or_default());
            let decode = || {
                let connection = &message.connection;
                let kind = connection
                    .kind()
                    .ok_or_else(|| unusable(topic, format!("holds {} in the bag", connection.held())))?;
                kind.decode(&message.bytes).map_err(|error| {
                    unusable(topic, format!("cannot decode the message after {:.3} s: {error}", time.as_secs_f64()))
                })
            };
            if visit(time, &decode)?.is_break() {
                break;
            }
        }
        Ok(())
    }

    /// The first CameraInfo of the bag: it may be latched, and recorded once.
    fn camera_info(&self, topic: &str) -> Result<CameraInfo, ScanFailure> {
        let mut first = None;
        self.messages((topic, &[MessageKind::CameraInfo]), Duration::ZERO, &mut |_, decode| {
            if let AnyMessage::CameraInfo(info) = decode()? {
                first = Some(info);
            }
            Ok(ControlFlow::Break(()))
        })?;
        let info = first.ok_or_else(|| unusable(topic, "has no message in the bag".to_owned()))?;
        Ok((*info).clone())
    }

    /// Visits the frames with the wanted numbers in the order of time; the first has number 0.
    ///
    /// # Errors
    /// An unreadable frame, or the visitor's error.
    pub(crate) fn frames(&self, wanted: &dyn Fn(usize) -> bool, visit: &mut VisitFrame<'_>) -> Result<(), ScanFailure> {
        let mut number = 0;
        self.messages((&self.image, IMAGES), self.start, &mut |time, decode| {
            if wanted(number) {
                let image = grey_image(&self.image, &decode()?);
                let (size_px, grey) = image.map_err(|reason| unusable(&self.image, reason))?;
                visit(number, time, size_px, grey)?;
            }
            number += 1;
            Ok(ControlFlow::Continue(()))
        })
    }

    /// `true` if there is depth.
    pub(crate) fn has_depth(&self) -> bool {
        self.depth.is_some()
    }

    /// Visits the depth images of a part of the recording.
    ///
    /// # Errors
    /// An unreadable one, or the visitor's error.
    pub(crate) fn depths(&self, during: Range<Duration>, visit: &mut VisitDepth<'_>) -> Result<(), ScanFailure> {
        let Some((topic, kinds)) = &self.depth else { return Ok(()) };
        self.messages((topic, kinds), self.start, &mut |time, decode| {
            if during.contains(&time) {
                visit(depth_of(topic, &decode()?).map_err(|reason| unusable(topic, reason))?)?;
            }
            Ok(if time < during.end { ControlFlow::Continue(()) } else { ControlFlow::Break(()) })
        })
    }

    /// The transforms of `/tf_static`, and those of `/tf` in the seconds before a time.
    ///
    /// # Errors
    /// An unreadable bag.
    pub(crate) fn transforms(&self, until: Duration) -> Result<TransformTree, ScanFailure> {
        let mut tree = TransformTree::new();
        for (topic, from, is_static) in
            [("/tf_static", Duration::ZERO, true), ("/tf", until.saturating_sub(RECENT), false)]
        {
            self.messages((topic, &[MessageKind::TFMessage]), from, &mut |time, decode| {
                if !is_static && time > until {
                    return Ok(ControlFlow::Break(()));
                }
                if let Ok(AnyMessage::TFMessage(message)) = decode() {
                    for transform in raw_transforms(&message) {
                        // One that is refused, such as an old one, is left out.
                        let _ = tree.insert(&transform, is_static, "");
                    }
                }
                Ok(ControlFlow::Continue(()))
            })?;
        }
        Ok(tree)
    }

    /// The images that were shown, if they were recorded. `recognise` returns the pattern of an image of the
    /// projector's size.
    ///
    /// # Errors
    /// An unreadable image.
    pub(crate) fn shown(
        &self,
        recognise: &dyn Fn(&[u8]) -> Option<Pattern>,
    ) -> Result<Option<Vec<ShownImage>>, ScanFailure> {
        let Some(topic) = &self.shown else { return Ok(None) };
        let mut all = Vec::new();
        self.messages((topic, IMAGES), self.start, &mut |at, decode| {
            let (_, grey) = grey_image(topic, &decode()?).map_err(|reason| unusable(topic, reason))?;
            all.push(ShownImage { at, pattern: recognise(&grey) });
            Ok(ControlFlow::Continue(()))
        })?;
        Ok(Some(all))
    }
}

fn holds_any(connection: &Connection, kinds: &[MessageKind]) -> bool {
    kinds.iter().any(|kind| connection.holds(*kind))
}

fn unusable(topic: &str, reason: String) -> ScanFailure {
    ScanCameraError::Unusable { topic: topic.to_owned(), reason }.into()
}

/// Decodes a message.
type Decode<'a> = dyn Fn() -> Result<AnyMessage, ScanFailure> + 'a;

/// A visitor of messages, by their times.
type VisitMessage<'a> = dyn FnMut(Duration, &Decode<'_>) -> Result<ControlFlow<()>, ScanFailure> + 'a;
