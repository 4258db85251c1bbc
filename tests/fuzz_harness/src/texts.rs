//! Files of text: `.rviz`, projector files and PCD (whose points may be binary).

use std::path::Path;

use rcs_files::pcd::{PcdCloud, PointDatatype};
use rcs_files::projector::ProjectorFile;

use crate::displays::Shown;

/// A `.rviz` file: its findings, and the scene of all its displays before the first message.
pub(crate) fn rviz_config(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let config = match rcs_rviz_config::parse(text, "fuzz.rviz") {
        Ok(config) => config,
        Err(error) => {
            assert!(error.to_string().starts_with("fuzz.rviz"));
            return;
        }
    };
    let lines = text.replace("\r\n", "\n").split(['\n', '\r']).count();
    for finding in &config.findings {
        assert!((1..=lines).contains(&finding.line), "{finding:?} in {lines} lines");
        assert_eq!(finding.to_string().lines().count(), 1, "{finding:?}");
    }
    assert!(config.findings.is_sorted_by_key(|finding| finding.line));
    let mut shown = Shown::new(&config);
    shown.advance();
    let kept = shown.reconfigure(&config);
    assert_eq!((kept.added, kept.removed), (0, 0), "the same config changes no display");
    shown.advance();
    shown.draw_some(data);
}

/// A projector file: what was read is written and read as the same.
pub(crate) fn projector(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let path = Path::new("fuzz.yaml");
    let file = match ProjectorFile::parse(path, text) {
        Ok(file) => file,
        Err(error) => {
            assert!(error.to_string().starts_with("fuzz.yaml"));
            return;
        }
    };
    let _ = file.warnings();
    // Some of what can be read cannot be written, such as a frame of no name.
    if let Ok(written) = file.to_yaml(path) {
        let again = ProjectorFile::parse(path, &written);
        let again = again.unwrap_or_else(|error| panic!("{error} in what was written:\n{written}"));
        let kept = ProjectorFile { ignored_keys: Vec::new(), ..file };
        assert_eq!(again, kept, "{written}");
    }
}

/// A PCD file: its points fill its data.
pub(crate) fn pcd(data: &[u8]) {
    let cloud = match PcdCloud::parse(Path::new("fuzz.pcd"), data) {
        Ok(cloud) => cloud,
        Err(error) => {
            assert!(error.to_string().starts_with("fuzz.pcd"));
            return;
        }
    };
    let points = cloud.width as usize * cloud.height as usize;
    assert_eq!(cloud.data.len(), points * cloud.point_step_bytes as usize);
    for field in &cloud.fields {
        let size = match field.datatype {
            PointDatatype::Int8 | PointDatatype::Uint8 => 1,
            PointDatatype::Int16 | PointDatatype::Uint16 => 2,
            PointDatatype::Int32 | PointDatatype::Uint32 | PointDatatype::Float32 => 4,
            PointDatatype::Float64 => 8,
        };
        assert!(field.offset_bytes + size * field.count <= cloud.point_step_bytes, "{field:?}");
    }
}
