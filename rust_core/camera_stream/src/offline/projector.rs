//! A projector's file that replaces a bag's CameraInfo and frames.

use std::path::Path;

use anyhow::{bail, Result};
use rcs_displays::CameraView;
use rcs_files::projector::ProjectorFile;
use rcs_messages::tf2_msgs::TFMessage;
use rcs_messages::AnyMessage;
use rcs_transforms::Time;

use crate::scene::SceneState;

/// The CameraInfo and frames of a projector's file, for one camera.
#[derive(Debug)]
pub(crate) struct ProjectorOverride {
    file: ProjectorFile,
    /// The file's name, as the publisher of its transforms.
    name: String,
    /// The camera's CameraInfo topic, by its name in the config.
    pub(super) topic: String,
}

impl ProjectorOverride {
    /// Reads the file for a camera.
    ///
    /// # Errors
    /// An invalid file, or a camera without a Camera Info Topic.
    pub(crate) fn read(path: &Path, camera: &CameraView) -> Result<Self> {
        let name = path.display().to_string();
        let file = ProjectorFile::read(path)?;
        for warning in file.warnings() {
            log::warn!("{name}: {warning}");
        }
        if file.camera_info.header.frame_id.is_empty() {
            if path.extension().is_some_and(|ending| ending == "ini") {
                bail!("{name}: no frame: an .ini has none; write its width, height and K into a .yaml with frame_id");
            }
            bail!("{name}: no frame: the file needs frame_id (or header.frame_id)");
        }
        let topic = camera.settings.camera_info_topic.clone();
        if topic.is_empty() {
            bail!("camera {}: its Camera Info Topic is empty, and --projector stands for that topic", camera.name);
        }
        Ok(Self { file, name, topic })
    }

    /// Hands CameraInfo and frames to the scene.
    pub(super) fn place(&self, scene: &mut SceneState, now: Time) {
        let transforms = self.file.frames.iter().map(|frame| frame.to_message(rcs_messages::Time::default()));
        scene.take_transforms(&TFMessage { transforms: transforms.collect() }, true, &self.name);
        let info = AnyMessage::CameraInfo(self.file.camera_info.clone().into());
        scene.take(&self.topic, &info, now);
    }

    /// `true` if the file places this frame.
    pub(super) fn places(&self, frame: &str) -> bool {
        let name = frame.trim_start_matches('/');
        self.file.frames.iter().any(|placed| placed.child.trim_start_matches('/') == name)
    }
}
