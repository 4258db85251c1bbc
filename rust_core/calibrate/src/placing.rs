//! Where the projector is: its pose in the camera's optical frame, or in another frame by way of TF.

use std::path::Path;
use std::time::{Duration, Instant};

use clap::Args;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use rcs_files::projector::{ProjectorFile, StaticFrame};
use rcs_ros::{NodeEvent, RosNode};
use rcs_transforms::{Time, TransformTree};

use super::Failure;
use rcs_node_support::frames::insert_transforms;
use rcs_node_support::lifecycle::EndRequest;

/// The optical frame of Fetch's head camera.
const DEFAULT_CAMERA_FRAME: &str = "head_camera_rgb_optical_frame";
/// How long TF is waited for.
const PATIENCE: Duration = Duration::from_secs(5);

/// The frame that the projector's pose is written in.
#[derive(Debug, Args)]
pub(super) struct PlacingArguments {
    /// The camera's optical frame [default: the capture folder's, else head_camera_rgb_optical_frame]
    #[arg(long, value_name = "FRAME")]
    camera_frame: Option<String>,
    /// Write the pose in this frame, such as torso_lift_link, instead of the camera's: asks the robot's TF where the
    /// camera is in it now
    #[arg(long, value_name = "FRAME")]
    parent: Option<String>,
}

/// A pose of the projector.
pub(super) struct Placed {
    /// The frame it is given in.
    pub(super) parent: String,
    /// Takes points of the projector's optical frame to it.
    pub(super) parent_from_projector: Isometry3<f64>,
}

impl PlacingArguments {
    /// The camera's optical frame.
    pub(super) fn camera<'a>(&'a self, named_by_capture: Option<&'a str>) -> &'a str {
        self.camera_frame.as_deref().or(named_by_capture).unwrap_or(DEFAULT_CAMERA_FRAME)
    }

    /// The projector's pose in the wanted frame. Frames that are known already are not asked for again: a process has
    /// one node.
    pub(super) fn place(
        &self,
        projector_from_camera: &Isometry3<f64>,
        named_by_capture: Option<&str>,
        known: Option<&Frames>,
    ) -> Result<Placed, Failure> {
        let camera = self.camera(named_by_capture);
        let camera_from_projector = projector_from_camera.inverse();
        match &self.parent {
            None => Ok(Placed { parent: camera.to_owned(), parent_from_projector: camera_from_projector }),
            Some(parent) => {
                let parent_from_camera = match known {
                    Some(frames) => {
                        frames.newest(parent, camera).map_err(|error| Failure::Refused(error.context("TF")))?
                    }
                    None => look_up(parent, camera)?,
                };
                Ok(Placed { parent: parent.clone(), parent_from_projector: parent_from_camera * camera_from_projector })
            }
        }
    }
}

/// Asks TF for the newest transform that takes points of `source` to `target`.
fn look_up(target: &str, source: &str) -> Result<Isometry3<f64>, Failure> {
    let refused = |error: anyhow::Error| Failure::Refused(error.context("TF"));
    let end = EndRequest::watch_signals().map_err(|error| refused(error.into()))?;
    // Who calibrates waits for an answer: without a master there is none.
    let node = RosNode::connect_now("projector_calibrate", &|| end.is_requested());
    let node = node.map_err(|error| refused(error.into()))?;
    let found = look_up_with(&node, &end, target, source);
    node.shutdown();
    found
}

/// The same with a node that is connected. Its other messages are dropped meanwhile.
fn look_up_with(node: &RosNode, end: &EndRequest, target: &str, source: &str) -> Result<Isometry3<f64>, Failure> {
    let refused = |error: anyhow::Error| Failure::Refused(error.context("TF"));
    node.subscribe_transforms().map_err(|error| refused(error.into()))?;
    let mut frames = Frames::default();
    let until = Instant::now() + PATIENCE;
    loop {
        for event in node.events().wait(Duration::from_millis(100)) {
            frames.take(&event);
        }
        match frames.newest(target, source) {
            Ok(transform) => return Ok(transform),
            Err(error) if Instant::now() > until => return Err(refused(error)),
            Err(_) if end.is_requested() => return Err(interrupted()),
            Err(_) => {}
        }
    }
}

fn interrupted() -> Failure {
    Failure::Refused(anyhow::anyhow!("interrupted"))
}

/// The robot's frames as TF tells them.
#[derive(Default)]
pub(super) struct Frames(TransformTree);

impl Frames {
    /// Takes transforms from a node's events.
    pub(super) fn take(&mut self, event: &NodeEvent) {
        if let NodeEvent::Transforms { message, is_static, authority, .. } = event {
            insert_transforms(&mut self.0, message, *is_static, authority);
        }
    }

    /// The newest transform that takes points of `source` to `target`.
    ///
    /// # Errors
    /// Which frame is missing.
    pub(super) fn newest(&self, target: &str, source: &str) -> anyhow::Result<Isometry3<f64>> {
        if target.trim_start_matches('/') == source.trim_start_matches('/') {
            return Ok(Isometry3::identity());
        }
        // Time zero: the newest time for which all transforms on the way are known.
        Ok(self.0.lookup(target, source, Time::ZERO)?)
    }
}

/// The pose that a projector's file gives its frame in a camera's optical frame: takes points of the camera to the
/// projector. None if the file does not place it there.
pub(super) fn pose_in_file(file: &ProjectorFile, camera: Option<&str>) -> Option<Isometry3<f64>> {
    frame_in_file(file, camera).map(projector_from_parent)
}

/// The same for a file that places the projector in any frame: TF tells where the camera is in it now.
pub(super) fn pose_by_tf(
    file: &ProjectorFile,
    path: &Path,
    camera: &str,
    node: &RosNode,
    end: &EndRequest,
) -> Result<Isometry3<f64>, Failure> {
    if let Some(pose) = pose_in_file(file, Some(camera).filter(|camera| !camera.is_empty())) {
        return Ok(pose);
    }
    let frame = frame_in_file(file, None).ok_or_else(|| {
        let (path, child) = (path.display(), &file.camera_info.header.frame_id);
        Failure::Unreadable(anyhow::anyhow!("{path}: no frame places {child}: solve or refine writes such a file"))
    })?;
    Ok(projector_from_parent(frame) * look_up_with(node, end, &frame.parent, camera)?)
}

/// Where a file places the projector's frame: in a certain one, or in any.
pub(super) fn frame_in_file<'a>(file: &'a ProjectorFile, parent: Option<&str>) -> Option<&'a StaticFrame> {
    let same = |one: &str, other: &str| one.trim_start_matches('/') == other.trim_start_matches('/');
    let is_wanted = |frame: &&StaticFrame| {
        same(&frame.child, &file.camera_info.header.frame_id) && parent.is_none_or(|parent| same(&frame.parent, parent))
    };
    file.frames.iter().find(is_wanted)
}

/// Takes points of the frame's parent to the projector.
pub(super) fn projector_from_parent(frame: &StaticFrame) -> Isometry3<f64> {
    let translation = Translation3::from(Vector3::from(frame.translation_m));
    Isometry3::from_parts(translation, normalized(frame.rotation)).inverse()
}

fn normalized(rotation: UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::new_normalize(Quaternion::from(rotation.coords))
}
