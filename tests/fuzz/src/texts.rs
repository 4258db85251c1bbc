//! Files of text in any encoding: XML, `.rviz`, projector files and PCD (whose points may be binary).

use std::path::{Component, Path};

use rcs_files::capture::parse_patterns;
use rcs_files::correspondences::Correspondences;
use rcs_files::pcd::PcdCloud;
use rcs_files::projector::ProjectorFile;
use rcs_messages::element_size;
use rcs_text::xml::{self, Element};

use crate::displays::Shown;

/// Text, and the XML in it: lines end in one way, elements and faults are in its lines, in their order.
pub(crate) fn text(data: &[u8]) {
    let text = rcs_text::decode(data);
    assert!(!text.contains('\r'));
    let lines = 1..=text.matches('\n').count() + 1;
    let document = match xml::parse(&text) {
        Ok(document) => document,
        Err(error) => {
            assert!(lines.contains(&error.line), "{error:?} in {lines:?}");
            return;
        }
    };
    assert!(document.passed_over.iter().all(|fault| lines.contains(&fault.line)), "{:?}", document.passed_over);
    for element in document.elements.iter().flat_map(Element::descendants) {
        assert!(lines.contains(&element.line), "{element:?} in {lines:?}");
        assert!(element.elements.is_sorted_by_key(|inner| inner.line), "{element:?}");
        for inner in &element.elements {
            assert!(inner.line >= element.line && element.child(inner.name).is_some(), "{element:?}");
        }
    }
}

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

/// A projector file, of this project or of another tool: what was read is written and read as the same.
pub(crate) fn projector(data: &[u8]) {
    let text = rcs_text::decode(data);
    let path = Path::new("fuzz.yaml");
    let file = match ProjectorFile::parse(path, &text) {
        Ok(file) => file,
        Err(error) => {
            let error = error.to_string();
            assert!(error.starts_with("fuzz.yaml") && error.lines().count() == 1, "{error:?}");
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

/// A list of correspondences: its points are finite, and each is of a scan that is listed.
pub(crate) fn correspondences(data: &[u8]) {
    let points = match Correspondences::parse(Path::new("fuzz.csv"), data) {
        Ok(points) => points,
        Err(error) => {
            assert!(error.to_string().starts_with("fuzz.csv"), "{error}");
            return;
        }
    };
    for sample in &points.samples {
        let numbers = sample.pixel.coords.iter().chain(sample.point.coords.iter());
        assert!(numbers.chain([&sample.sigma_px, &sample.sigma_m]).all(|number| number.is_finite()), "{sample:?}");
        assert!(sample.sigma_px > 0.0 && sample.sigma_m >= 0.0, "{sample:?}");
        assert!(points.scans.iter().any(|scan| scan.number == sample.scan), "{sample:?}");
    }
}

/// A list of patterns, and so the patterns of a capture: their images are in its folder, and each pattern can be
/// shown.
pub(crate) fn pattern_list(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let list = match parse_patterns(Path::new("folder/fuzz.yaml"), text) {
        Ok(list) => list,
        Err(error) => {
            assert!(error.to_string().starts_with("folder/fuzz.yaml"), "{error}");
            return;
        }
    };
    for (path, pattern) in &list.patterns {
        let name = path.strip_prefix("folder").unwrap_or_else(|_| panic!("{} leaves the folder", path.display()));
        assert!(name.components().all(|part| matches!(part, Component::Normal(_))), "{}", path.display());
        let _ = pattern.is_lit(list.projector_size_px[0] - 1, list.projector_size_px[1] - 1);
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
        let size = element_size(field.datatype) as u32;
        assert!(size > 0 && field.offset + size * field.count <= cloud.point_step_bytes, "{field:?}");
    }
}
