//! Where the projector is: its pose in the camera's optical frame, or in another frame by way of TF.

use std::time::{Duration, Instant};

use clap::Args;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use rcs_messages::geometry_msgs::TransformStamped;
use rcs_ros::NodeEvent;
use rcs_transforms::{RawTransform, Time, TransformTree};

use super::Failure;
use crate::small_node::{self, EndRequest};

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
    /// The projector's pose in the wanted frame.
    pub(super) fn place(
        &self,
        projector_from_camera: &Isometry3<f64>,
        named_by_capture: Option<&str>,
    ) -> Result<Placed, Failure> {
        let camera = self.camera_frame.as_deref().or(named_by_capture).unwrap_or(DEFAULT_CAMERA_FRAME);
        let camera_from_projector = projector_from_camera.inverse();
        match &self.parent {
            None => Ok(Placed { parent: camera.to_owned(), parent_from_projector: camera_from_projector }),
            Some(parent) => {
                let parent_from_camera = look_up(parent, camera)?;
                Ok(Placed { parent: parent.clone(), parent_from_projector: parent_from_camera * camera_from_projector })
            }
        }
    }
}

/// Asks TF for the newest transform that takes points of `source` to `target`.
fn look_up(target: &str, source: &str) -> Result<Isometry3<f64>, Failure> {
    let refused = |error: anyhow::Error| Failure::Refused(error.context("TF"));
    let end = EndRequest::watch_signals().map_err(|error| refused(error.into()))?;
    let ended = || Failure::Refused(anyhow::anyhow!("interrupted"));
    let node = small_node::connect("projector_calibrate", &end).map_err(|error| refused(error.into()))?;
    let node = node.ok_or_else(ended)?;
    node.subscribe_transforms().map_err(|error| refused(error.into()))?;
    let mut tree = TransformTree::new();
    let until = Instant::now() + PATIENCE;
    let found = loop {
        for event in node.events().wait(Duration::from_millis(100)) {
            if let NodeEvent::Transforms { message, is_static, authority, .. } = event {
                for stamped in &message.transforms {
                    insert(&mut tree, stamped, is_static, &authority);
                }
            }
        }
        // Time zero: the newest time for which all transforms on the way are known.
        match tree.lookup(target, source, Time::ZERO) {
            Ok(transform) => break Ok(transform),
            Err(error) if Instant::now() > until => break Err(refused(error.into())),
            Err(_) if end.is_requested() => break Err(ended()),
            Err(_) => {}
        }
    };
    node.shutdown();
    found
}

fn insert(tree: &mut TransformTree, stamped: &TransformStamped, is_static: bool, authority: &str) {
    let (translation, rotation) = (&stamped.transform.translation, &stamped.transform.rotation);
    let transform = RawTransform {
        parent: &stamped.header.frame_id,
        child: &stamped.child_frame_id,
        stamp: Time::from_secs_f64(f64::from(stamped.header.stamp.sec) + f64::from(stamped.header.stamp.nsec) * 1e-9),
        translation: [translation.x, translation.y, translation.z],
        rotation_xyzw: [rotation.x, rotation.y, rotation.z, rotation.w],
    };
    if let Err(error) = tree.insert(&transform, is_static, authority) {
        log::warn!("{error}");
    }
}

/// The pose that a projector's file gives its frame in a camera's optical frame: takes points of the camera to the
/// projector. None if the file does not place it there.
pub(super) fn pose_in_file(file: &rcs_files::projector::ProjectorFile, camera: Option<&str>) -> Option<Isometry3<f64>> {
    let frame_id = file.camera_info.header.frame_id.trim_start_matches('/');
    let frame = file.frames.iter().find(|frame| {
        let is_wanted =
            camera.is_none_or(|camera| frame.parent.trim_start_matches('/') == camera.trim_start_matches('/'));
        frame.child.trim_start_matches('/') == frame_id && is_wanted
    })?;
    let translation = Translation3::from(Vector3::from(frame.translation_m));
    Some(Isometry3::from_parts(translation, normalized(frame.rotation)).inverse())
}

fn normalized(rotation: UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::new_normalize(Quaternion::from(rotation.coords))
}
