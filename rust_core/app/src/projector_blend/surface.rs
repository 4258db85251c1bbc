//! The surface that projectors share: a cloud and the transforms around it.

use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{anyhow, bail, Context, Result};
use nalgebra::{Isometry3, Point3};
use rcs_files::projector::ProjectorFile;
use rcs_messages::tf2_msgs::TFMessage;
use rcs_messages::{AnyMessage, MessageKind, NoPositions, PointCloud2};
use rcs_ros::{NodeEvent, RosNode};
use rcs_transforms::{Time, TransformTree};

use rcs_node_support::frames::insert_transforms;
use rcs_node_support::lifecycle::EndRequest;
use rcs_samples::publish_cloud;

/// Time to wait for a cloud and its transforms.
const TIMEOUT: Duration = Duration::from_secs(10);

/// Points of the surface and the transforms around them.
pub(super) struct SharedSurface {
    /// Finite points in the cloud's frame, metres.
    pub(super) points: Vec<Point3<f64>>,
    frame: String,
    frames: TransformTree,
}

impl SharedSurface {
    /// The surface of a PCD file, whose frame defaults to the parent of the first projector.
    pub(super) fn from_file(path: &Path, frame: Option<&str>, files: &[(&Path, ProjectorFile)]) -> Result<Self> {
        let parent = files.first().and_then(|(_, file)| file.frames.first()).map(|placed| placed.parent.as_str());
        let frame = frame.or(parent).context("which frame are the points in? Give --frame FRAME")?.to_owned();
        let cloud = publish_cloud::read(path, &frame)?;
        let points = finite_points(&cloud).map_err(|error| anyhow!("{}: {error}", path.display()))?;
        Ok(Self { points, frame, frames: frames_of(files) })
    }

    /// The surface of the next cloud on a topic, once all projectors can be transformed to its frame.
    pub(super) fn from_topic(topic: &str, files: &[(&Path, ProjectorFile)]) -> Result<Self> {
        let end = EndRequest::watch_signals().context("cannot handle signals")?;
        let node = RosNode::connect_now("projector_blend", &|| end.is_requested())?;
        let received = receive(&node, &end, topic, files);
        node.shutdown();
        received
    }

    /// Pose of a projector's frame in the cloud's.
    ///
    /// # Errors
    /// The missing frame.
    pub(super) fn pose_of(&self, frame: &str) -> Result<Isometry3<f64>> {
        if frame.is_empty() {
            bail!("no frame: the file needs frame_id (or header.frame_id)");
        }
        self.frames
            .lookup(&self.frame, frame, Time::ZERO)
            .context("frames that place the projector in that of the cloud are missing")
    }
}

/// The finite points of a cloud, metres.
///
/// # Errors
/// [`NoPositions`].
fn finite_points(cloud: &PointCloud2) -> Result<Vec<Point3<f64>>, NoPositions> {
    Ok(cloud.positions()?.map(Point3::from).filter(|point| point.iter().all(|value| value.is_finite())).collect())
}

/// The transforms of projector files.
fn frames_of(files: &[(&Path, ProjectorFile)]) -> TransformTree {
    let mut frames = TransformTree::new();
    for (path, file) in files {
        let transforms = file.frames.iter().map(|frame| frame.to_message(rcs_messages::Time::default())).collect();
        insert_transforms(&mut frames, &TFMessage { transforms }, true, &path.display().to_string());
    }
    frames
}

/// Waits for the cloud and the transforms of all projectors.
fn receive(node: &RosNode, end: &EndRequest, topic: &str, files: &[(&Path, ProjectorFile)]) -> Result<SharedSurface> {
    let _subscription = node.subscribe(topic, MessageKind::PointCloud2, 1)?;
    node.subscribe_transforms()?;
    let mut frames = frames_of(files);
    let mut last: Option<std::sync::Arc<PointCloud2>> = None;
    let until = Instant::now() + TIMEOUT;
    loop {
        for event in node.events().wait(Duration::from_millis(100)) {
            match event {
                NodeEvent::Transforms { message, is_static, authority, .. } => {
                    insert_transforms(&mut frames, &message, is_static, &authority);
                }
                NodeEvent::Message { message: AnyMessage::PointCloud2(cloud), .. } => last = Some(cloud),
                _ => {}
            }
        }
        if let Some(cloud) = &last {
            let frame = &cloud.header.frame_id;
            let is_placed =
                |file: &ProjectorFile| frames.can_transform(frame, &file.camera_info.header.frame_id, Time::ZERO);
            // After the timeout, `pose_of` reports what is missing.
            if files.iter().all(|(_, file)| is_placed(file)) || Instant::now() > until {
                let points = finite_points(cloud).map_err(|error| anyhow!("{topic}: {error}"))?;
                return Ok(SharedSurface { points, frame: frame.clone(), frames });
            }
        }
        if end.is_requested() {
            bail!("interrupted");
        }
        if last.is_none() && Instant::now() > until {
            bail!("no cloud on {topic} for {} s", TIMEOUT.as_secs());
        }
    }
}
