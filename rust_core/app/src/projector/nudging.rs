//! Correcting the projector's pose by hand: dynamic_reconfigure moves the frame that the file places, `~save` writes
//! its pose into the file, and `~revert` takes the correction back, or the last save where nothing is corrected.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::anyhow;
use rcs_files::projector::{check_writable, restore_before, write_pose, ProjectorFile, StaticFrame};
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_node_support::nudge::Nudge;
use rcs_ros::settings::{accepted, NamedValues};
use rcs_ros::{ReconfigureServer, RosNode, ServiceCall};

use super::publishers::Publishers;

/// The file's contents, published with the present nudge, and the services that change it.
pub(super) struct Nudging {
    path: PathBuf,
    info: CameraInfo,
    /// The frames as they are in the file.
    frames: Vec<StaticFrame>,
    publishers: Publishers,
    /// Name of the CameraInfo's frame, which is nudged.
    child: String,
    nudge: Nudge,
    server: ReconfigureServer,
    save: Arc<str>,
    revert: Arc<str>,
    /// `true` once this node has saved, until that is taken back: an older file of before is somebody else's.
    has_saved: bool,
}

impl Nudging {
    /// Publishes the contents of a file and offers the services, without a nudge.
    pub(super) fn start(
        node: &RosNode,
        path: &Path,
        file: ProjectorFile,
        mut publishers: Publishers,
    ) -> anyhow::Result<Self> {
        let ProjectorFile { camera_info: info, frames, .. } = file;
        publishers.publish(node, &info, &frames)?;
        let frame_id = &info.header.frame_id;
        Ok(Self {
            path: path.to_owned(),
            child: frame_id.strip_prefix('/').unwrap_or(frame_id).to_owned(),
            info,
            frames,
            publishers,
            nudge: Nudge::default(),
            server: node.serve_reconfigure("~", Nudge::default().groups())?,
            save: node.serve_trigger("~save")?,
            revert: node.serve_trigger("~revert")?,
            has_saved: false,
        })
    }

    /// Publishes again once simulated time has started, which may be after this node.
    pub(super) fn replace_zero_stamp(&mut self, node: &RosNode) -> anyhow::Result<()> {
        if self.publishers.has_zero_stamp(node) {
            self.publishers.publish(node, &self.info, &self.nudged_frames())?;
        }
        Ok(())
    }

    /// The frames with the nudge.
    fn nudged_frames(&self) -> Vec<StaticFrame> {
        let mut frames = self.frames.clone();
        let frame = frames.iter_mut().find(|frame| frame.child == self.child);
        if let Some(frame) = frame.filter(|_| self.nudge != Nudge::default()) {
            let parent_from_child = frame.parent_from_child() * self.nudge.isometry();
            frame.translation_m = parent_from_child.translation.vector.into();
            frame.rotation = parent_from_child.rotation;
        }
        frames
    }

    /// Answers a call.
    pub(super) fn answer(&mut self, node: &RosNode, call: ServiceCall) {
        match call {
            ServiceCall::Reconfigure { request, reply, .. } => {
                if let Err(error) = self.take(node, &request) {
                    log::warn!("nudging the projector failed: {error:#}");
                }
                reply.answer(self.nudge.config());
            }
            ServiceCall::Trigger { service, reply, caller } if service == self.save || service == self.revert => {
                let result = match service == self.save {
                    true => self.save(node),
                    false => self.revert(node),
                };
                match result {
                    Ok(done) => {
                        log::info!("{service} by {caller}: {done}");
                        reply.send(true, done);
                    }
                    Err(error) => {
                        log::warn!("{service} by {caller} failed: {error:#}");
                        reply.send(false, format!("{error:#}"));
                    }
                }
            }
            _ => {}
        }
    }

    /// Takes the values of a request.
    fn take(&mut self, node: &RosNode, request: &NamedValues) -> anyhow::Result<()> {
        let mut wanted = self.nudge;
        wanted.take(&accepted(self.server.groups(), request));
        if wanted == self.nudge {
            return Ok(());
        }
        let checked = self.placed().map(drop);
        if checked.is_ok() {
            if self.nudge == Nudge::default() {
                self.warn_if_read_only();
            }
            self.nudge = wanted;
        }
        // Also values that were refused, for clients that show theirs.
        self.server.set(node, self.nudge.groups());
        checked?;
        self.publishers.publish_frames(node, &self.nudged_frames())
    }

    /// Says at the first nudge, and not only after an hour's work, that it cannot be saved.
    fn warn_if_read_only(&self) {
        if let Err(error) = check_writable(&self.path) {
            log::warn!("the nudge will be lost with this node: {error}; make the file writable before {}", self.save);
        }
    }

    /// Writes the nudged pose into the file, whose pose it is then.
    fn save(&mut self, node: &RosNode) -> anyhow::Result<String> {
        let parent_from_child = self.placed()?.parent_from_child() * self.nudge.isometry();
        let written = write_pose(&self.path, &self.child, &parent_from_child)?;
        let saved = format!("frame {} in {} moved by {}", self.child, self.path.display(), self.nudge);
        self.take_pose(written);
        self.has_saved = true;
        self.reset(node);
        Ok(saved)
    }

    /// Takes the nudge back; without one, the last save of this node.
    fn revert(&mut self, node: &RosNode) -> anyhow::Result<String> {
        self.placed()?;
        let reverted = if self.has_saved && self.nudge == Nudge::default() {
            let before = restore_before(&self.path)?;
            self.take_pose(before);
            self.has_saved = false;
            format!("{} is as it was before the last save", self.path.display())
        } else {
            format!("frame {} moved back by {}", self.child, self.nudge)
        };
        self.reset(node);
        self.publishers.publish_frames(node, &self.nudged_frames())?;
        Ok(reverted)
    }

    /// Takes the nudged frame's pose from a file.
    fn take_pose(&mut self, file: ProjectorFile) {
        let new = file.frames.into_iter().find(|frame| frame.child == self.child);
        if let (Some(known), Some(new)) = (self.frames.iter_mut().find(|frame| frame.child == self.child), new) {
            *known = new;
        }
    }

    fn reset(&mut self, node: &RosNode) {
        self.nudge = Nudge::default();
        self.server.set(node, self.nudge.groups());
    }

    /// The frame that is nudged, as it is in the file.
    fn placed(&self) -> anyhow::Result<&StaticFrame> {
        let placed = self.frames.iter().find(|frame| frame.child == self.child);
        placed.ok_or_else(|| {
            anyhow!(
                "{}: frames: no entry has the child '{}', the CameraInfo's frame; add one, or correct the pose where \
                 that frame is published",
                self.path.display(),
                self.child
            )
        })
    }
}
