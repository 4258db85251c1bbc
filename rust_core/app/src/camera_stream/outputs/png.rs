//! Pictures as PNG files: one, or a numbered sequence.

use std::io;
use std::path::{Path, PathBuf};

use rcs_files::picture_file;

use super::{Frame, Output, OutputError};

/// One PNG file; each frame replaces it.
#[derive(Clone, Debug)]
pub struct PngFile {
    file: PathBuf,
}

impl PngFile {
    /// Writes to this file, whose folder must exist.
    pub fn new(file: &Path) -> Self {
        Self { file: file.to_owned() }
    }
}

impl Output for PngFile {
    fn send(&mut self, frame: &Frame) -> Result<(), OutputError> {
        Ok(picture_file::write(&self.file, &frame.picture)?)
    }
}

/// Numbered PNG files in a folder: `frame_000000.png` and so on.
#[derive(Clone, Debug)]
pub struct PngSequence {
    folder: PathBuf,
    next_number: u64,
}

impl PngSequence {
    /// Writes into this folder, which is created if it does not exist.
    ///
    /// # Errors
    /// When the folder cannot be created.
    pub fn create(folder: &Path) -> io::Result<Self> {
        std::fs::create_dir_all(folder)?;
        Ok(Self { folder: folder.to_owned(), next_number: 0 })
    }
}

impl Output for PngSequence {
    fn send(&mut self, frame: &Frame) -> Result<(), OutputError> {
        picture_file::write(&self.folder.join(format!("frame_{:06}.png", self.next_number)), &frame.picture)?;
        self.next_number += 1;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rcs_messages::Time;
    use rcs_scene::{Encoding, Picture};

    use super::*;

    #[test]
    fn a_file_is_replaced_and_a_sequence_is_numbered() {
        let folder = tempfile::tempdir().unwrap();
        let frame = |width_px: u32| {
            let mut picture = Picture::default();
            picture.reset(width_px, 1, Encoding::Mono8);
            Frame { picture: Arc::new(picture), info: Arc::default(), stamp: Time::default() }
        };
        let (file, sequence) = (folder.path().join("one.png"), folder.path().join("new/folder"));
        let mut outputs: [Box<dyn Output>; 2] =
            [Box::new(PngFile::new(&file)), Box::new(PngSequence::create(&sequence).unwrap())];
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
        let missing = PngFile::new(&folder.path().join("missing/one.png")).send(&frame(1)).unwrap_err();
        assert!(missing.to_string().contains("missing/one.png"), "{missing}");
    }
}
