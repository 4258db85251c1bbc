//! The projector's file and its pose in the camera's optical frame, or in another frame by TF.

use std::path::Path;
use std::time::{Duration, Instant};

use clap::Args;
use nalgebra::Isometry3;
use rcs_calibration::Lens;
use rcs_files::capture::CapturedRobot;
use rcs_files::projector::{ProjectorFile, StaticFrame};
use rcs_messages::tf2_msgs::TFMessage;
use rcs_node_support::frames::insert_transforms;
use rcs_node_support::lifecycle::EndRequest;
use rcs_ros::{NodeEvent, RosNode};
use rcs_scan::captured_robot;
use rcs_transforms::{Time, TransformTree};

use super::camera_chain::CameraChain;
use super::Failure;

/// Timeout of TF.
pub(super) const TF_TIMEOUT: Duration = Duration::from_secs(5);

/// The frame that the projector's pose is written in.
#[derive(Debug, Clone, Args)]
pub(super) struct PlacingArguments {
    /// The camera's optical frame; points and photos need it [default: the capture folder's]
    #[arg(long, value_name = "FRAME")]
    camera_frame: Option<String>,
    /// Write the pose in this frame, the one that the projector is mounted on. Where the camera was in it is in the
    /// capture; for other points, TF is asked where it is now
    #[arg(long, value_name = "FRAME")]
    parent: Option<String>,
    /// Write the pose in the camera's optical frame although joints move that: the projector moves with the camera
    #[arg(long, conflicts_with = "parent")]
    in_camera_frame: bool,
}

/// The camera's pose in the frame that the projector's pose is written in.
pub(super) struct CameraPose {
    /// The frame.
    pub(super) parent: String,
    /// Takes points of the camera's optical frame to it.
    pub(super) parent_from_camera: Isometry3<f64>,
    /// `true` if joints may move the frame, as far as is known.
    pub(super) may_move: bool,
}

impl CameraPose {
    /// Prints the file that the pose was written to, and warns of a frame that may move.
    pub(super) fn tell_written(&self, path: &Path) {
        if self.may_move {
            log::warn!(
                "the pose is written in {}: the points have no chain of frames that tells whether joints move the \
                 camera; give --parent FRAME, or --in-camera-frame if the projector moves with the camera",
                self.parent
            );
        }
        eprintln!("written: {}", path.display());
    }
}

impl PlacingArguments {
    /// The camera's optical frame.
    ///
    /// # Errors
    /// [`Failure::Unreadable`]: neither --camera-frame nor a capture names it.
    pub(super) fn camera<'a>(&'a self, named_by_capture: Option<&'a str>) -> Result<&'a str, Failure> {
        self.camera_frame.as_deref().or(named_by_capture).ok_or_else(|| {
            Failure::Unreadable(anyhow::anyhow!(
                "the camera's optical frame is not known: no capture folder names it; give --camera-frame FRAME"
            ))
        })
    }

    /// The camera's pose in the wanted frame: by the chain of frames of the scan, else by TF, as for a link of a turret
    /// that only carries the projector. TF is asked only if no `frames` are given: a process has one node.
    ///
    /// # Errors
    /// [`Failure::Refused`]: joints move the camera and neither --parent nor --in-camera-frame is given; an unknown
    /// frame. [`Failure::Unreadable`]: the camera's frame is not named.
    pub(super) fn camera_pose(
        &self,
        named_by_capture: Option<&str>,
        robot: &CapturedRobot,
        frames: Option<&RobotFrames>,
    ) -> Result<CameraPose, Failure> {
        let camera = self.camera(named_by_capture)?;
        let chain = CameraChain::new(robot, camera);
        let Some(parent) = &self.parent else {
            let may_move = chain.is_none() && !self.in_camera_frame;
            if let Some(chain) = chain.filter(|_| !self.in_camera_frame) {
                chain.check_rigid()?;
            }
            let parent_from_camera = Isometry3::identity();
            return Ok(CameraPose { parent: camera.to_owned(), parent_from_camera, may_move });
        };
        let parent_from_camera = camera_in(parent, camera, chain.as_ref(), frames)?;
        Ok(CameraPose { parent: parent.clone(), parent_from_camera, may_move: false })
    }

    /// The camera's pose in the frame that a file places its projector in, unless another one is wanted. It is known by
    /// the scan, by TF, or by the file's own frames in between.
    ///
    /// # Errors
    /// Like [`Self::camera_pose`].
    pub(super) fn camera_pose_like(
        &self,
        file: &ProjectorFile,
        named_by_capture: Option<&str>,
        robot: &CapturedRobot,
        frames: Option<&RobotFrames>,
    ) -> Result<CameraPose, Failure> {
        let frame = frame_in_file(file, None).filter(|_| self.parent.is_none() && !self.in_camera_frame);
        let Some(frame) = frame else { return self.camera_pose(named_by_capture, robot, frames) };
        let camera = self.camera(named_by_capture)?;
        // From the projector upwards: the first frame in which the camera is known.
        let (mut above, mut parent_from_above) = (&frame.parent, Isometry3::identity());
        let chain = CameraChain::new(robot, camera);
        for _ in 0..file.frames.len() {
            let stored = chain.as_ref().and_then(|chain| chain.parent_from_camera(above).ok());
            let is_camera = is_same_frame(above, camera).then(Isometry3::identity);
            if let Some(above_from_camera) = is_camera.or(stored) {
                let parent_from_camera = parent_from_above * above_from_camera;
                return Ok(CameraPose { parent: frame.parent.clone(), parent_from_camera, may_move: false });
            }
            let Some(next) = file.frames.iter().find(|next| is_same_frame(&next.child, above)) else { break };
            parent_from_above *= next.parent_from_child().inverse();
            above = &next.parent;
        }
        let above_from_camera = camera_in(above, camera, chain.as_ref(), frames)?;
        let parent_from_camera = parent_from_above * above_from_camera;
        Ok(CameraPose { parent: frame.parent.clone(), parent_from_camera, may_move: false })
    }
}

/// The camera's pose in a frame.
fn camera_in(
    parent: &str,
    camera: &str,
    chain: Option<&CameraChain<'_>>,
    frames: Option<&RobotFrames>,
) -> Result<Isometry3<f64>, Failure> {
    let stored = chain.map(|chain| chain.parent_from_camera(parent)).transpose();
    match (stored, frames) {
        (Ok(Some(pose)), _) => Ok(pose),
        (_, Some(frames)) => frames.newest(parent, camera).map_err(tf_failed),
        (stored, None) => {
            log::warn!(
                "--parent {parent}: not in the chain of frames of a scan, so TF is asked where {camera} is now; the \
                 robot must stand as it did during the scan"
            );
            // The error names the frames that the scan has.
            look_up(parent, camera).map_err(|error| stored.err().unwrap_or(error))
        }
    }
}

/// `true` if two names are of the same frame.
pub(super) fn is_same_frame(one: &str, other: &str) -> bool {
    one.trim_start_matches('/') == other.trim_start_matches('/')
}

pub(super) fn tf_failed(error: impl Into<anyhow::Error>) -> Failure {
    Failure::Refused(error.into().context("TF"))
}

/// Asks TF for the newest `target_from_source`, with a node of its own.
fn look_up(target: &str, source: &str) -> Result<Isometry3<f64>, Failure> {
    let end = EndRequest::watch_signals().map_err(tf_failed)?;
    // The user waits for an answer: no waiting for a master.
    let node = RosNode::connect_now("projector_calibrate", &|| end.is_requested()).map_err(tf_failed)?;
    let found = look_up_with(&node, &end, target, source);
    node.shutdown();
    found
}

/// Like [`look_up`], with a connected node, whose other messages are dropped meanwhile.
fn look_up_with(node: &RosNode, end: &EndRequest, target: &str, source: &str) -> Result<Isometry3<f64>, Failure> {
    node.subscribe_transforms().map_err(tf_failed)?;
    let mut frames = RobotFrames::default();
    let until = Instant::now() + TF_TIMEOUT;
    loop {
        for event in node.events().wait(Duration::from_millis(100)) {
            frames.add(&event);
        }
        match frames.newest(target, source) {
            Ok(transform) => return Ok(transform),
            Err(error) if Instant::now() > until => return Err(tf_failed(error)),
            Err(_) if end.is_requested() => {
                return Err(Failure::Interrupted(anyhow::anyhow!("interrupted before TF was known")));
            }
            Err(_) => {}
        }
    }
}

/// The robot's frames by TF.
#[derive(Default)]
pub(super) struct RobotFrames(TransformTree);

impl RobotFrames {
    /// Adds a node's event, if it has transforms.
    pub(super) fn add(&mut self, event: &NodeEvent) {
        if let NodeEvent::Transforms { message, is_static, authority, .. } = event {
            insert_transforms(&mut self.0, message, *is_static, authority);
        }
    }

    /// The frames above the camera.
    pub(super) fn captured(&self, camera: &str, description: Option<&str>) -> CapturedRobot {
        captured_robot(&self.0, camera, description)
    }

    /// Adds the frames of a projector's file, which are fixed.
    pub(super) fn add_file(&mut self, file: &ProjectorFile) {
        let transforms = file.frames.iter().map(|frame| frame.to_message(Default::default())).collect();
        insert_transforms(&mut self.0, &TFMessage { transforms }, true, "the projector's file");
    }

    /// The newest `target_from_source`.
    ///
    /// # Errors
    /// The missing frame.
    pub(super) fn newest(&self, target: &str, source: &str) -> anyhow::Result<Isometry3<f64>> {
        if is_same_frame(target, source) {
            return Ok(Isometry3::identity());
        }
        // Time zero: the newest time at which all transforms are known.
        Ok(self.0.lookup(target, source, Time::ZERO)?)
    }
}

/// Reads a projector's file and its lens, and logs the file's warnings.
pub(super) fn read_projector(path: &Path) -> Result<(ProjectorFile, Lens), Failure> {
    let file = ProjectorFile::read(path).map_err(Failure::unreadable)?;
    for warning in file.warnings() {
        log::warn!("{}: {warning}", path.display());
    }
    let lens = file.lens();
    let lens = lens.map_err(|problem| Failure::Unreadable(anyhow::anyhow!("{}: {problem}", path.display())))?;
    Ok((file, lens))
}

/// `projector_from_camera` by a projector's file; `None` if the file has no pose in that frame.
pub(super) fn pose_in_file(file: &ProjectorFile, camera: Option<&str>) -> Option<Isometry3<f64>> {
    frame_in_file(file, camera).map(projector_from_parent)
}

/// The frame of the projector in its file: below a certain parent, or below any.
pub(super) fn frame_in_file<'a>(file: &'a ProjectorFile, parent: Option<&str>) -> Option<&'a StaticFrame> {
    let is_wanted = |frame: &&StaticFrame| {
        is_same_frame(&frame.child, &file.camera_info.header.frame_id)
            && parent.is_none_or(|parent| is_same_frame(&frame.parent, parent))
    };
    file.frames.iter().find(is_wanted)
}

/// Inverts a projector's frame.
pub(super) fn projector_from_parent(frame: &StaticFrame) -> Isometry3<f64> {
    frame.parent_from_child().inverse()
}
