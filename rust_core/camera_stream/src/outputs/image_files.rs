//! Images as files: one, or a numbered sequence.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{bail, Context, Result};
use rcs_files::image_file;

use super::{Output, OutputFrame};

/// One image file; each frame replaces it.
#[derive(Clone, Debug)]
pub(crate) struct ImageFile {
    file: PathBuf,
}

impl ImageFile {
    /// Writes to this file, whose folder must exist.
    pub(crate) fn new(file: &Path) -> Self {
        Self { file: file.to_owned() }
    }
}

impl Output for ImageFile {
    fn send(&mut self, frame: &OutputFrame) -> Result<()> {
        Ok(image_file::write(&self.file, &frame.image.content(Instant::now()))?)
    }
}

/// Numbered PNG files in a folder: `frame_000000.png` and so on.
#[derive(Clone, Debug)]
pub(crate) struct ImageSequence {
    folder: PathBuf,
    next_number: u64,
    /// `true` if the folder does not exist yet.
    is_new: bool,
}

const PREFIX: &str = "frame_";
const ENDING: &str = ".png";

impl ImageSequence {
    /// Writes into this folder, which is created with the first image if it does not exist. `overwrite` removes the
    /// images of an earlier sequence, which are an error otherwise.
    pub(crate) fn create(folder: &Path, overwrite: bool) -> Result<Self> {
        let name_of = |path: &Path| path.display().to_string();
        let entries = match fs::read_dir(folder) {
            Ok(entries) => entries,
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                return Ok(Self { folder: folder.to_owned(), next_number: 0, is_new: true });
            }
            Err(error) => return Err(error).with_context(|| name_of(folder)),
        };
        let mut old = Vec::new();
        for entry in entries {
            let name = entry.with_context(|| name_of(folder))?.file_name();
            old.extend(name.to_str().filter(|name| is_numbered(name)).map(str::to_owned));
        }
        old.sort();
        if let Some(example) = old.first().filter(|_| !overwrite) {
            let (images, them) = match old.len() {
                1 => ("a picture".to_owned(), "it"),
                count => (format!("{count} pictures"), "them"),
            };
            bail!("{}: has {images} of an earlier sequence ({example}); --overwrite removes {them}", name_of(folder));
        }
        for path in old.iter().map(|name| folder.join(name)) {
            fs::remove_file(&path).with_context(|| name_of(&path))?;
        }
        Ok(Self { folder: folder.to_owned(), next_number: 0, is_new: false })
    }

    /// The name of an image's file.
    pub(crate) fn name(number: u64) -> String {
        format!("{PREFIX}{number:06}{ENDING}")
    }
}

/// `true` for a file name of a sequence.
fn is_numbered(name: &str) -> bool {
    let number = name.strip_prefix(PREFIX).and_then(|rest| rest.strip_suffix(ENDING));
    number.is_some_and(|number| number.len() == 6 && number.bytes().all(|digit| digit.is_ascii_digit()))
}

impl Output for ImageSequence {
    fn send(&mut self, frame: &OutputFrame) -> Result<()> {
        if self.is_new {
            fs::create_dir_all(&self.folder).with_context(|| self.folder.display().to_string())?;
            self.is_new = false;
        }
        image_file::write(&self.folder.join(Self::name(self.next_number)), &frame.image.content(Instant::now()))?;
        self.next_number += 1;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rcs_messages::Time;
    use rcs_scene::Encoding;

    use super::super::FrameImage;
    use super::*;

    #[test]
    fn a_file_is_replaced_and_a_sequence_is_numbered() {
        let folder = tempfile::tempdir().unwrap();
        let frame = |width_px: u32| {
            let image = FrameImage::black([width_px, 1], Encoding::Mono8);
            OutputFrame { image, info: Arc::default(), depth: None, stamp: Time::default(), shown: None }
        };
        let (file, sequence) = (folder.path().join("one.png"), folder.path().join("new/folder"));
        let mut outputs: [Box<dyn Output>; 2] =
            [Box::new(ImageFile::new(&file)), Box::new(ImageSequence::create(&sequence, false).unwrap())];
        assert!(!folder.path().join("new").exists(), "a sequence without a picture leaves no folder");
        for output in &mut outputs {
            assert!(output.is_watched() && !output.take_new_watcher());
            output.send(&frame(1)).unwrap();
            output.send(&frame(2)).unwrap();
        }
        // The width stands in bytes 16 to 19 of a PNG file.
        let width = |path: &Path| std::fs::read(path).unwrap()[19];
        assert_eq!(width(&file), 2);
        let numbered = ["frame_000000.png", "frame_000001.png"].map(|name| width(&sequence.join(name)));
        assert_eq!(numbered, [1, 2]);
        let missing = ImageFile::new(&folder.path().join("missing/one.png")).send(&frame(1)).unwrap_err();
        assert!(missing.to_string().contains("missing/one.png"), "{missing}");
    }

    #[test]
    fn an_earlier_sequence_is_an_error_or_is_removed() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        for name in ["frame_000007.png", "frame_000008.png", "frame_7.png", "notes.txt"] {
            fs::write(path(name), b"").unwrap();
        }
        let error = ImageSequence::create(folder.path(), false).unwrap_err().to_string();
        assert!(error.contains("has 2 pictures") && error.contains("frame_000007.png"), "{error}");
        assert!(path("frame_000007.png").exists());
        fs::remove_file(path("frame_000008.png")).unwrap();
        let error = ImageSequence::create(folder.path(), false).unwrap_err().to_string();
        assert!(error.contains("has a picture of") && error.ends_with("--overwrite removes it"), "{error}");
        fs::write(path("frame_000008.png"), b"").unwrap();
        ImageSequence::create(folder.path(), true).unwrap();
        let left = ["frame_000007.png", "frame_000008.png", "frame_7.png", "notes.txt"].map(|name| path(name).exists());
        assert_eq!(left, [false, false, true, true]);
        ImageSequence::create(folder.path(), false).unwrap();
    }
}
