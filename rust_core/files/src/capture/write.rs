//! Writing a capture folder: images first, and last `capture.yaml`, which names them, so that an interrupted writer
//! leaves no `capture.yaml` or a valid one. New images of a folder with a capture get other names than the old ones,
//! which are removed afterwards.

use std::fs::File;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use rcs_scene::{Encoding, Image};

use super::error::CaptureError;
use super::file_name::FileName;
use super::folder::{Capture, RawCapture, CAPTURE_FILE, DEPTH_SCALE_M};
use super::limits::check_amount;
use super::pattern_entry::{check_writable, entry_line, projector_line, Patterns};
use super::pattern_list::{make_folder, remove_link, write_text};
use super::yaml_file::read_yaml;
use crate::image_file;
use crate::projector::ProjectorFile;

impl Capture {
    /// Writes the folder or replaces its capture. The folder is created if its parent exists. Depths are rounded to
    /// [`DEPTH_SCALE_M`], and those beyond 16 bits and [`warnings`](Self::warnings) are not written.
    ///
    /// # Errors
    /// A capture that could not be read again, or a file that cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), CaptureError> {
        self.check(folder)?;
        make_folder(folder)?;
        let old_files = files_of_capture(folder);
        let names = FileNames::new(&old_files);
        let [width_px, height_px] = self.camera.size_px;
        let camera_info = names.camera_info();
        let images = (0..self.images.len()).map(|index| names.image(index));
        let depth = self.depth_m.is_some().then(|| names.depth());
        let urdf = self.robot.description.is_some().then(|| names.robot_description());
        let files = images.chain([camera_info.clone()]).chain(depth).chain(urdf);
        let files: Vec<PathBuf> = files.map(|name| folder.join(name)).collect();
        files.iter().try_for_each(|file| remove_link(file))?;

        self.images.par_iter().enumerate().try_for_each(|(index, image)| {
            let data = image.grey.clone();
            let image = Image { width_px, height_px, encoding: Encoding::Mono8, data };
            image_file::write(&folder.join(names.image(index)), &image)
        })?;
        ProjectorFile::from_lens(&self.camera, &self.camera_frame_id).write(&folder.join(&camera_info))?;
        let entries = self.images.iter().enumerate();
        let mut text = projector_line(self.projector_size_px) + "patterns:\n";
        text.extend(entries.map(|(index, image)| entry_line(&names.image(index), &image.pattern)));
        text += &format!("camera_info: {camera_info}\n");
        if !self.is_camera_calibrated {
            text += "camera_calibrated: false\n";
        }
        if let Some(depth_m) = &self.depth_m {
            let depth = names.depth();
            let data = depth_m.iter().flat_map(|depth| depth_value(*depth).to_le_bytes()).collect();
            let image = Image { width_px, height_px, encoding: Encoding::Mono16, data };
            image_file::write(&folder.join(&depth), &image)?;
            text += &format!("depth: {depth}\ndepth_scale_m: {DEPTH_SCALE_M}\n");
        }
        text += &self.robot.frame_lines();
        if let Some(description) = &self.robot.description {
            let urdf = names.robot_description();
            write_text(&folder.join(&urdf), description)?;
            text += &format!("robot_description: {urdf}\n");
        }
        remove_link(&folder.join(CAPTURE_FILE))?;
        if !old_files.is_empty() {
            // The old capture goes when its `capture.yaml` is replaced: the new one is on the disk before.
            let write_error = |path: &Path, source| CaptureError::Write { path: path.to_owned(), source };
            files.iter().try_for_each(|path| {
                File::open(path).and_then(|file| file.sync_all()).map_err(|source| write_error(path, source))
            })?;
        }
        write_text(&folder.join(CAPTURE_FILE), &text)?;
        for file in old_files.iter().filter(|file| is_ours(file)) {
            // A file that stays does no harm.
            let _ = std::fs::remove_file(file.in_folder(folder));
        }
        Ok(())
    }

    /// Checks that the capture can be read again.
    fn check(&self, folder: &Path) -> Result<(), CaptureError> {
        let unwritable = |reason| CaptureError::Unwritable { path: folder.to_owned(), reason };
        check_writable(self.projector_size_px, self.images.iter().map(|image| &image.pattern)).map_err(unwritable)?;
        self.robot.check().map_err(unwritable)?;
        check_amount(folder, self.camera.size_px, self.images.len())?;
        ProjectorFile::from_lens(&self.camera, &self.camera_frame_id)
            .camera_lens()
            .map_err(|problem| unwritable(format!("the camera's {problem}")))?;
        let [width, height] = self.camera.size_px.map(|size| size as usize);
        let wrong = |count: usize| count != width * height;
        if let Some(index) = self.images.iter().position(|image| wrong(image.grey.len())) {
            let count = self.images[index].grey.len();
            return Err(unwritable(format!("picture {index} has {count} pixels, but the camera {width}x{height}")));
        }
        match &self.depth_m {
            Some(depth_m) if wrong(depth_m.len()) => {
                Err(unwritable(format!("the depth has {} pixels, but the camera {width}x{height}", depth_m.len())))
            }
            _ => Ok(()),
        }
    }
}

/// Value of a depth in the file; 0 for none and for one beyond 16 bits.
fn depth_value(depth_m: f32) -> u16 {
    let value = (f64::from(depth_m) / DEPTH_SCALE_M).round();
    if (1.0..=f64::from(u16::MAX)).contains(&value) {
        value as u16
    } else {
        0
    }
}

/// Files of the folder's capture, if it can be read.
fn files_of_capture(folder: &Path) -> Vec<FileName> {
    let Ok((RawCapture { patterns: Patterns(entries), camera_info, depth, robot_description, .. }, _)) =
        read_yaml(&folder.join(CAPTURE_FILE))
    else {
        return Vec::new();
    };
    let images = entries.into_iter().map(|entry| entry.file);
    images.chain([camera_info]).chain(depth).chain(robot_description).collect()
}

/// Names of a capture's files.
struct FileNames {
    /// Distinguishes them from those of the replaced capture.
    suffix: String,
}

impl FileNames {
    /// Names that no old file has.
    fn new(old_files: &[FileName]) -> Self {
        let is_free = |names: &Self| old_files.iter().all(|file| !names.has(file));
        let suffixes = std::iter::once(String::new()).chain((2..).map(|version: u64| format!("_{version}")));
        // Each old file takes one at the most.
        let free = suffixes.map(|suffix| Self { suffix }).take(old_files.len() + 1).find(is_free);
        free.unwrap_or(Self { suffix: String::new() })
    }

    fn image(&self, index: usize) -> String {
        format!("c{index:03}{}.png", self.suffix)
    }

    fn camera_info(&self) -> String {
        format!("camera_info{}.yaml", self.suffix)
    }

    fn depth(&self) -> String {
        format!("depth{}.png", self.suffix)
    }

    fn robot_description(&self) -> String {
        format!("robot{}.urdf", self.suffix)
    }

    /// `true` if a file could have one of these names.
    fn has(&self, file: &FileName) -> bool {
        let name = file.as_str().rsplit('/').next().unwrap_or_default();
        let index = name.strip_prefix('c').and_then(|rest| rest.strip_suffix(&format!("{}.png", self.suffix)));
        [self.camera_info(), self.depth(), self.robot_description()].iter().any(|ours| name == ours)
            || index.is_some_and(is_index)
    }
}

/// `true` if a file has a name of [`FileNames`]; others stay when a capture is replaced.
fn is_ours(file: &FileName) -> bool {
    let Some((stem, ending)) = file.as_str().rsplit_once('.') else { return false };
    let stem = match stem.rsplit_once('_') {
        Some((start, version)) if is_index(version) => start,
        _ => stem,
    };
    match stem.strip_prefix('c') {
        Some(index) if is_index(index) => index.len() == 3 && ending == "png",
        _ => matches!((stem, ending), ("camera_info", "yaml") | ("depth", "png") | ("robot", "urdf")),
    }
}

fn is_index(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())
}
