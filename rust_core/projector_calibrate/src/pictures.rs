//! Images of a camera in files: a folder for a scan, with one image of each pattern.

use std::path::Path;

use anyhow::anyhow;
use rcs_calibration::patterns::Pattern;
use rcs_calibration::Lens;
use rcs_files::capture::read_depth;
use rcs_files::image_file::read_grey;
use rcs_files::image_folder::images;
use rcs_files::projector::ProjectorFile;
use rcs_scan::recorded::ImageSet;
use rcs_scan::{ScanEvent, ScanFailure, ScanResult};

use crate::Failure;

/// Metres of the depth 1 in a file, as in ROS's 16UC1.
const DEPTH_SCALE_M: f64 = 0.001;

/// A scan, or scans in folders, whose images are in files.
pub(crate) struct Pictures<'a> {
    /// The folder of the images, or of their folders.
    pub(crate) folder: &'a Path,
    /// Width and height of the projector's image, pixels.
    pub(crate) projector_px: [u32; 2],
    /// The patterns in their order.
    pub(crate) patterns: Vec<Pattern>,
    /// The camera's file with its lens, if it is known.
    pub(crate) camera: Option<(ProjectorFile, Lens)>,
    /// The file of the depth, if there is one.
    pub(crate) depth: Option<&'a Path>,
}

impl Pictures<'_> {
    /// Reads the images in a folder, all of one size, in the natural order of their names. There may be none.
    pub(crate) fn read(&self, folder: &Path) -> Result<ImageSet, Failure> {
        let depth = self.depth.and_then(|depth| depth.canonicalize().ok());
        let is_depth = |path: &Path| depth.is_some() && path.canonicalize().ok() == depth;
        let mut paths = images(folder).map_err(Failure::unreadable)?;
        paths.retain(|path| !is_depth(path));
        let lens = self.camera.as_ref().map(|(_, lens)| *lens);
        let mut set = ImageSet { size_px: [0; 2], greys: Vec::new(), camera: lens, depth_m: None };
        for path in paths {
            let (size_px, grey) = read_grey(&path).map_err(Failure::unreadable)?;
            if set.greys.is_empty() {
                set.size_px = size_px;
            } else if size_px != set.size_px {
                let (path, [width, height], [others_width, others_height]) = (path.display(), size_px, set.size_px);
                return Err(Failure::Unreadable(anyhow!(
                    "{path}: {width}x{height} pixels, others have {others_width}x{others_height}"
                )));
            }
            set.greys.push(grey);
        }
        if let Some(path) = self.depth.filter(|_| !set.greys.is_empty()) {
            set.depth_m = Some(read_depth(path, set.size_px, DEPTH_SCALE_M).map_err(Failure::unreadable)?);
        }
        Ok(set)
    }

    /// Checks and decodes the images of a folder; its name is that of warnings.
    pub(crate) fn scan(&self, folder: &Path, set: ImageSet) -> Result<ScanResult, ScanFailure> {
        let mut scanned = set.scan(&self.patterns, self.projector_px, &mut |event| {
            if let ScanEvent::Warning(warning) = event {
                log::warn!("{}: {warning}", folder.display());
            }
        })?;
        if let Some((file, _)) = &self.camera {
            scanned.capture.camera_frame_id.clone_from(&file.camera_info.header.frame_id);
        }
        Ok(scanned)
    }
}
