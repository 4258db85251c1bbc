//! Results of a verification, as YAML for programs and as an [`image`] for people.
//!
//! ```yaml
//! projector: "projector.yaml"
//! is_within_limit: true
//! limit_px: 2.0
//! all: {count: 117, rms_px: 0.21, rms_mm: 0.2, median_px: 0.1, median_mm: 0.1, worst_px: 0.9, worst_mm: 0.8}
//! spots: {shown: 64, count: 64, rms_px: 0.08, …}
//! edges: {shown: 53, count: 53, rms_px: 0.23, …}
//! misses:
//!   - {kind: spot, expected_px: [312.1, 80.4], landed_px: [312.2, 80.4], miss_px: 0.2, miss_mm: 0.2}
//! ```
//!
//! `expected_px` and `landed_px` are pixels of the camera, all other pixels are the projector's.

mod image;

pub use image::image;

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use rcs_calibration::{ErrorStatistics, VerificationResult, VerifiedPoint};

use crate::atomic_file::write_atomically;
use crate::yaml_text::{figure, figures, quoted};
use crate::FileError;

/// Writes the file; it appears whole or not at all. `projector` names what was verified, against a limit of the RMS in
/// pixels.
///
/// # Errors
/// [`FileError`] with the file.
pub fn write(path: &Path, projector: &str, limit_px: f64, verified: &VerificationResult) -> Result<(), FileError> {
    let text = yaml(projector, limit_px, verified);
    let io_error = |source| FileError::writing(path, source);
    write_atomically(path, |file| file.write_all(text.as_bytes()).map_err(io_error), io_error)
}

fn yaml(projector: &str, limit_px: f64, verified: &VerificationResult) -> String {
    let VerificationResult { spots, spots_shown, edges, edges_shown } = verified;
    let all = verified.all();
    let mut yaml =
        "# A verification. Pixels are the projector's, those of expected_px and landed_px the camera's.\n".to_owned();
    yaml += &format!("projector: {}\n", quoted(projector));
    yaml += &format!("is_within_limit: {}\nlimit_px: {}\n", all.rms[0] <= limit_px, figure(limit_px));
    yaml += &format!("all: {{{}}}\n", summary(&all));
    for (kind, misses, shown) in [("spots", spots, spots_shown), ("edges", edges, edges_shown)] {
        yaml += &format!("{kind}: {{shown: {shown}, {}}}\n", summary(&ErrorStatistics::of(misses)));
    }
    yaml += if spots.is_empty() && edges.is_empty() { "misses: []\n" } else { "misses:\n" };
    for (kind, misses) in [("spot", spots), ("edge", edges)] {
        for VerifiedPoint { expected, landed, px, m } in misses {
            // Writing to a String cannot fail.
            let _ = writeln!(
                yaml,
                "  - {{kind: {kind}, expected_px: {}, landed_px: {}, miss_px: {}, miss_mm: {}}}",
                figures(&[expected.x, expected.y]),
                figures(&[landed.x, landed.y]),
                figure(*px),
                figure(1000.0 * m)
            );
        }
    }
    yaml
}

/// The distances of one kind.
fn summary(figures: &ErrorStatistics) -> String {
    let ErrorStatistics { count, median, rms, worst } = figures;
    let mut text = format!("count: {count}");
    for (name, [px, m]) in [("rms", rms), ("median", median), ("worst", worst)] {
        text += &format!(", {name}_px: {}, {name}_mm: {}", figure(*px), figure(1000.0 * m));
    }
    text
}

#[cfg(test)]
mod tests {
    use nalgebra::Point2;
    use serde::Deserialize;

    use super::*;

    #[derive(Deserialize)]
    struct Read {
        projector: String,
        is_within_limit: bool,
        spots: Kind,
        edges: Kind,
        misses: Vec<ReadMiss>,
    }

    #[derive(Deserialize)]
    struct Kind {
        shown: usize,
        count: usize,
        rms_px: f64,
        worst_mm: f64,
    }

    #[derive(Deserialize)]
    struct ReadMiss {
        kind: String,
        landed_px: [f64; 2],
        miss_mm: f64,
    }

    #[test]
    fn a_program_reads_what_was_measured() {
        let miss = |px: f64| VerifiedPoint {
            expected: Point2::new(10.0, 20.0),
            landed: Point2::new(11.0, 20.5),
            px,
            m: 0.001 * px,
        };
        let verified =
            VerificationResult { spots: vec![miss(3.0), miss(4.0)], spots_shown: 3, edges: Vec::new(), edges_shown: 0 };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("verification.yaml");
        for (limit, is_within_limit) in [(3.0, false), (4.0, true)] {
            write(&path, "a \"b\".yaml", limit, &verified).unwrap();
            let read: Read = serde_yaml_ng::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
            assert_eq!((read.projector.as_str(), read.is_within_limit), ("a \"b\".yaml", is_within_limit));
            assert_eq!((read.spots.shown, read.spots.count, read.edges.shown, read.edges.count), (3, 2, 0, 0));
            assert!((read.spots.rms_px - 12.5_f64.sqrt()).abs() < 1e-4 && read.spots.worst_mm == 4.0);
            assert!(read.misses[1].kind == "spot" && read.misses[1].landed_px == [11.0, 20.5]);
            assert!(read.misses[1].miss_mm == 4.0);
        }
        assert!(write(Path::new("missing/x.yaml"), "", 1.0, &verified).unwrap_err().to_string().contains("missing"));
    }
}
