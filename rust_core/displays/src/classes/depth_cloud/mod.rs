//! `rviz/DepthCloud`: a depth image as a cloud of points, coloured by a second image of the same camera.
//!
//! The depth image waits until its frame is known, then for the colour image whose stamp is nearest, and becomes a
//! cloud with the camera's last CameraInfo. The cloud is one like those of PointCloud2: it stands where its frame was
//! at its stamp.

mod pairs;
mod projection;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use rcs_messages::sensor_msgs::CameraInfo;
use rcs_messages::{AnyMessage, Image, MessageKind};
use rcs_rviz_config::DepthCloudSettings;
use rcs_scene::{DisplayId, Drawable};
use rcs_transforms::{Time, WaitingQueue};

use crate::framework::display::{bounded, Display, TopicRequest};
use crate::framework::frame;
use crate::framework::world::stamp;
use crate::parts::cloud::{Clouds, Decoded, NonFinite, PlacedCloud};
use crate::parts::compressed_image::unpack_image;
use crate::{Level, Status, StatusText, Statuses, World};
use pairs::{Pairs, COLOR, DEPTH};
use projection::{Occlusion, Shadows};

/// The smallest size of a point, in metres a metre of depth.
const MIN_AUTO_SIZE: f32 = 0.0001;

#[derive(Debug)]
pub(crate) struct DepthCloudDisplay {
    settings: DepthCloudSettings,
    depth: Option<TopicRequest>,
    color: Option<TopicRequest>,
    info: Option<TopicRequest>,
    waiting: WaitingQueue<Arc<Image>>,
    pairs: Pairs,
    last_info: Option<Arc<CameraInfo>>,
    /// Images to be shown once there is a CameraInfo.
    ready: Vec<(Arc<Image>, Option<Arc<Image>>)>,
    received: u64,
    shadows: Shadows,
    clouds: Clouds,
    statuses: Statuses,
}

/// The topic on which a transport sends an image; `None` without a topic or a transport.
///
/// # Errors
/// rviz's text for a transport that does not exist here.
fn transported(topic: &str, transport: &str, queue_size: u32) -> Result<Option<TopicRequest>, String> {
    let (suffix, kind) = match transport {
        _ if topic.is_empty() => return Ok(None),
        "" => return Ok(None),
        "raw" => ("", MessageKind::Image),
        "compressed" => ("/compressed", MessageKind::CompressedImage),
        "compressedDepth" => ("/compressedDepth", MessageKind::CompressedImage),
        other => return Err(format!("Error subscribing: Unable to load plugin for transport '{other}'")),
    };
    Ok(TopicRequest::new(&format!("{}{suffix}", topic.trim_end_matches('/')), kind, queue_size))
}

/// The topic of an image's CameraInfo: `camera_info` beside it.
fn info_topic(image_topic: &str) -> String {
    match image_topic.trim_end_matches('/').rsplit_once('/') {
        Some((namespace, _)) => format!("{namespace}/camera_info"),
        None => "camera_info".to_owned(),
    }
}

pub(crate) fn create(display: DisplayId, settings: &DepthCloudSettings) -> DepthCloudDisplay {
    let mut statuses = Statuses::default();
    let queue_size = settings.cloud.queue_size;
    let mut request = |topic: &str, transport: &str| {
        transported(topic, transport, queue_size).unwrap_or_else(|text| {
            statuses.set(Level::Error, "Message", text);
            None
        })
    };
    let depth = request(&settings.depth_topic, &settings.depth_transport);
    let color = request(&settings.color_topic, &settings.color_transport).filter(|_| depth.is_some());
    let info = depth
        .as_ref()
        .and_then(|_| TopicRequest::new(&info_topic(&settings.depth_topic), MessageKind::CameraInfo, queue_size));
    DepthCloudDisplay {
        depth,
        color,
        info,
        waiting: WaitingQueue::new(bounded(queue_size)),
        pairs: Pairs::new(queue_size),
        last_info: None,
        ready: Vec::new(),
        received: 0,
        shadows: Shadows::default(),
        clouds: Clouds::new(display, settings.cloud.clone(), NonFinite::FarAway),
        settings: settings.clone(),
        statuses,
    }
}

impl DepthCloudDisplay {
    /// The image of a message, unpacked; `None` for one of another topic or transport, and with a status for one that
    /// cannot be unpacked.
    fn image(&mut self, is_depth: bool, topic: &str, message: &AnyMessage) -> Option<Arc<Image>> {
        let request = if is_depth { &self.depth } else { &self.color };
        request.as_ref().filter(|request| request.topic == topic && request.kind == message.kind())?;
        let unpacked = match message {
            AnyMessage::Image(image) => return Some(image.clone()),
            AnyMessage::CompressedImage(packed) => unpack_image(topic, packed),
            _ => return None,
        };
        match unpacked {
            Ok(image) => Some(Arc::new(image)),
            Err(error) => {
                self.statuses.set(Level::Error, "Message", format!("Cannot decode an image of {topic}: {error}"));
                None
            }
        }
    }

    fn pair(&mut self, topic: usize, image: &Arc<Image>) {
        let mut out = Vec::new();
        self.pairs.add(topic, stamp(&image.header).as_secs_f64(), image.clone(), &mut out);
        self.ready.extend(out.into_iter().map(|[depth, color]| (depth, Some(color))));
    }

    fn take_placeable(&mut self, world: &World<'_>) {
        for depth in self.waiting.take_ready(world.transforms, world.fixed_frame) {
            if self.color.is_some() {
                self.pair(DEPTH, &depth);
            } else {
                self.ready.push((depth, None));
            }
        }
        frame::report_waiting(&self.waiting, world, &mut self.statuses);
    }

    fn show(&mut self, depth: &Image, color: Option<&Image>, world: &World<'_>) -> Result<Option<Decoded>, StatusText> {
        let Some(info) = self.last_info.clone() else { return Ok(None) };
        self.received += 1;
        self.statuses.set(Level::Ok, "Depth Map", format!("{} depth maps received", self.received));
        self.statuses.set(Level::Ok, "Message", "Ok");
        self.statuses.set(Level::Ok, "Depth Image Size", format!("{} x {}", depth.width, depth.height));
        if let Some(color) = color {
            self.statuses.set(Level::Ok, "Image Size", format!("{} x {}", color.width, color.height));
            let (frame, color_frame) = (&depth.header.frame_id, &color.header.frame_id);
            if frame != color_frame {
                let text = format!("Depth image frame id [{frame}] doesn't match color image frame id [{color_frame}]");
                self.statuses.set(Level::Warn, "Message", text);
            }
        }
        if self.settings.auto_size {
            let size = self.settings.auto_size_factor / info.K[0] as f32 * info.binning_x.max(1) as f32;
            let is_size = size.is_finite() && size > 0.0;
            if !is_size {
                let text = format!("K[0] of the CameraInfo is {}, by which Auto Size finds no size", info.K[0]);
                self.statuses.set(Level::Warn, "Message", text);
            }
            self.clouds.set_auto_size(if is_size { size.max(MIN_AUTO_SIZE) } else { MIN_AUTO_SIZE });
        }
        let shadows = if self.settings.occlusion_compensation {
            let place = world.fixed_from_header(&depth.header);
            let place = place.map_err(|_| frame::transform_failed(&depth.header.frame_id, world))?;
            self.shadows.follow(&place);
            let occlusion = Occlusion { now: world.now, timeout_secs: self.settings.occlusion_timeout_secs };
            Some((&mut self.shadows, occlusion))
        } else {
            None
        };
        let cloud = projection::cloud(depth, color, &info, shadows)
            .map_err(|error| format!("Error updating depth cloud: {error}"))?;
        let placed = PlacedCloud::at_stamp(Arc::new(cloud), world)?;
        let message = self.statuses.get("Message").cloned();
        let decoded = self.clouds.decode(placed, &mut self.statuses);
        // The status that clouds set for their message is about the cloud, which is whole.
        if let (Some(_), Some(Status { level, text, cause })) = (&decoded, message) {
            self.statuses.set(level, "Message", StatusText { text, cause });
        }
        Ok(decoded)
    }
}

impl Display for DepthCloudDisplay {
    fn topics(&self) -> Vec<TopicRequest> {
        [&self.depth, &self.info, &self.color].into_iter().flatten().cloned().collect()
    }

    fn take_from(&mut self, topic: &str, message: &AnyMessage, world: &World<'_>) {
        if let (AnyMessage::CameraInfo(info), Some(request)) = (message, &self.info) {
            if request.topic == topic {
                self.last_info = Some(info.clone());
            }
        }
        if let Some(depth) = self.image(true, topic, message) {
            self.waiting.push(&depth.header.frame_id, stamp(&depth.header), depth.clone());
            // Before the queue drops those that can be placed.
            self.take_placeable(world);
        }
        if let Some(color) = self.image(false, topic, message) {
            self.pair(COLOR, &color);
        }
    }

    fn is_waiting(&self, stamp: Time) -> bool {
        let is_ready = self.ready.iter().flat_map(|(depth, color)| std::iter::once(depth).chain(color));
        let is_one = |image: &Arc<Image>| crate::framework::world::stamp(&image.header) == stamp;
        self.waiting.stamps().any(|waiting| waiting == stamp) || self.pairs.images().chain(is_ready).any(is_one)
    }

    /// With compensation, occluded points are remembered from earlier images.
    fn is_replaced_by_newest(&self) -> bool {
        self.clouds.keeps_one() && !self.settings.occlusion_compensation
    }

    fn update(&mut self, world: &World<'_>) -> bool {
        self.take_placeable(world);
        let mut ready = std::mem::take(&mut self.ready);
        if self.last_info.is_none() || (self.clouds.keeps_one() && !self.settings.occlusion_compensation) {
            // Only the newest would be visible.
            let replaced = ready.len().saturating_sub(1);
            self.received += if self.last_info.is_some() { replaced as u64 } else { 0 };
            ready.drain(..replaced);
        }
        if self.last_info.is_none() {
            self.ready = ready;
            return false;
        }
        let mut new = Vec::new();
        for (depth, color) in ready {
            match self.show(&depth, color.as_deref(), world) {
                Ok(decoded) => new.extend(decoded),
                Err(text) => self.statuses.set(Level::Error, "Message", text),
            }
        }
        self.clouds.update(new, world.now)
    }

    fn drawables(&self) -> &[Drawable] {
        self.clouds.drawables()
    }

    fn next_change(&self) -> Option<Time> {
        self.clouds.next_change()
    }

    /// Keeps the CameraInfo, as rviz does.
    fn reset(&mut self) {
        self.waiting.clear();
        self.pairs.clear();
        self.ready.clear();
        self.clouds.clear();
        self.shadows.clear();
        self.received = 0;
        self.statuses.clear();
        self.statuses.set(Level::Ok, "Depth Map", "0 depth maps received");
        self.statuses.set(Level::Ok, "Message", "Ok");
    }

    fn statuses(&self) -> &Statuses {
        &self.statuses
    }
}
