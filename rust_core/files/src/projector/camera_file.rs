//! Writing a camera's file as `camera_calibration` writes it and `camera_info_manager` reads it.

use std::path::Path;

use rcs_calibration::Lens;

use super::file::ProjectorFile;
use super::key_error::key_error;
use super::write::write_text;
use crate::yaml_text::{list, number, quoted};
use crate::FileError;

/// Writes or replaces the file of a camera of this name, in an existing folder.
///
/// # Errors
/// [`FileError`]: a lens that could not be read again, or a file that cannot be written.
pub fn write_camera(path: &Path, lens: &Lens, name: &str) -> Result<(), FileError> {
    let file = ProjectorFile::from_lens(lens, name);
    file.camera_lens().map_err(|problem| key_error(path, ("camera_matrix", problem.to_string())))?;
    let info = &file.camera_info;
    let matrix = |key: &str, columns: usize, values: &[f64]| {
        let rows = values.len() / columns;
        format!("{key}:\n  rows: {rows}\n  cols: {columns}\n  data: {}\n", list(values, number))
    };
    let text = format!(
        "image_width: {}\nimage_height: {}\ncamera_name: {}\n{}distortion_model: {}\n{}{}{}",
        info.width,
        info.height,
        quoted(name),
        matrix("camera_matrix", 3, &info.K),
        info.distortion_model,
        matrix("distortion_coefficients", info.D.len().max(1), &info.D),
        matrix("rectification_matrix", 3, &info.R),
        matrix("projection_matrix", 4, &info.P),
    );
    write_text(path, &text)
}

#[cfg(test)]
mod tests {
    use rcs_calibration::Distortion;

    use super::*;

    #[test]
    fn a_cameras_file_is_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("camera.yaml");
        for distortion in [Distortion::plumb_bob([-0.2, 0.05, 1e-4, -2e-4, 0.0]), Distortion::NONE] {
            let lens = Lens { distortion, ..Lens::pinhole([1280, 720], [1000.5, 1001.0], [640.25, 360.0]) };
            write_camera(&path, &lens, "webcam").unwrap();
            assert_eq!(ProjectorFile::read(&path).unwrap().camera_lens().unwrap(), lens);
            let text = std::fs::read_to_string(&path).unwrap();
            assert!(text.contains("camera_name: \"webcam\"\ncamera_matrix:\n  rows: 3\n  cols: 3\n"), "{text}");
        }
    }
}
