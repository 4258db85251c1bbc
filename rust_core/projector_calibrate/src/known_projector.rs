//! The projector's file that `refine` starts from, and what stays of it: comments, topic, names, and frames between.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use nalgebra::Isometry3;
use rcs_calibration::Lens;
use rcs_files::projector::{write_frame, ProjectorFile, StaticFrame};

use super::placing::{frame_in_file, is_same_frame, read_projector};
use super::Failure;

/// A projector's file with its lens.
pub(super) struct KnownProjector {
    pub(super) path: PathBuf,
    pub(super) file: ProjectorFile,
    pub(super) lens: Lens,
}

impl KnownProjector {
    /// Reads the file.
    pub(super) fn read(path: &Path) -> Result<Self, Failure> {
        let (file, lens) = read_projector(path)?;
        Ok(Self { path: path.to_owned(), file, lens })
    }

    /// The name of the projector's optical frame.
    pub(super) fn child(&self) -> &str {
        match self.file.camera_info.header.frame_id.trim_start_matches('/') {
            "" => ProjectorFile::FRAME_ID,
            frame_id => frame_id,
        }
    }

    /// The projector's frame.
    ///
    /// # Errors
    /// [`Failure::Unreadable`]: the file has none.
    pub(super) fn frame(&self) -> Result<&StaticFrame, Failure> {
        frame_in_file(&self.file, None).ok_or_else(|| {
            let (path, child) = (self.path.display(), self.child());
            Failure::Unreadable(anyhow!("{path}: no frame places {child}: solve or refine writes such a file"))
        })
    }

    /// Writes the pose into a file. One that is there keeps everything else; a new one gets the rest from this file.
    ///
    /// # Errors
    /// [`Failure::Refused`]: a file with another lens or with the projector in another frame, or one that cannot be
    /// edited or written.
    pub(super) fn write(&self, output: &Path, parent: &str, pose: &Isometry3<f64>) -> Result<(), Failure> {
        let frame = StaticFrame {
            parent: parent.trim_start_matches('/').to_owned(),
            child: self.child().to_owned(),
            translation_m: pose.translation.vector.into(),
            // Composed rotations drift from the norm 1, which a file needs.
            rotation: nalgebra::UnitQuaternion::new_normalize(pose.rotation.into_inner()),
        };
        if output.exists() {
            let (file, lens) = read_projector(output)?;
            if lens != self.lens {
                return Err(Failure::Refused(anyhow!(
                    "{} has another lens than {}: refine with --projector {0}, or write a new file",
                    output.display(),
                    self.path.display()
                )));
            }
            let has_frame_id = !file.camera_info.header.frame_id.is_empty();
            if has_frame_id && !is_same_frame(&file.camera_info.header.frame_id, self.child()) {
                return Err(Failure::Refused(anyhow!(
                    "{} is of the frame {}, not of {}: write a new file",
                    output.display(),
                    file.camera_info.header.frame_id,
                    self.child()
                )));
            }
            return write_frame(output, output, &frame).map_err(Failure::refused);
        }
        let keeps_text = match frame_in_file(&self.file, None) {
            Some(known) => is_same_frame(&known.parent, parent),
            None => !self.file.camera_info.header.frame_id.is_empty(),
        };
        if keeps_text {
            return write_frame(&self.path, output, &frame).map_err(Failure::refused);
        }
        // Its text places the projector elsewhere, or has no name for it.
        let mut file = self.file.clone();
        file.camera_info.header.frame_id = self.child().to_owned();
        file.frames.retain(|known| !is_same_frame(&known.child, self.child()));
        file.frames.push(frame);
        file.write(output).map_err(Failure::refused)
    }
}
