//! `report.yaml`: figures with their units in the keys, verdict and reasons.
//!
//! ```yaml
//! verdict: good
//! reasons: []
//! rms_px: 0.21
//! held_out_rms_px: 0.22
//! prediction_sigma_px: 0.08
//! max_px: 1.4
//! rms_mm: 0.31
//! points: 200000
//! inliers: 198200
//! coverage: {image: 0.96, depth_m: [0.62, 1.94], scans: 1}
//! smooth_depth_error_m: 0.0004
//! skew_px: {value: 0.04, sigma: 0.05}                   # estimated K[0][1]; missing if the lens was known
//! size_px: [1280, 800]
//! parameters:
//!   fx: {value: 1900.2, sigma: 0.3}
//! poses:
//!   - scan: 0
//!     inliers: 198200
//!     position_m: [0.1, 0.0, 0.02]                      # of the projector, in the camera's optical frame
//!     position_sigma_m: [0.0002, 0.0002, 0.0004]
//!     rotation_xyzw: [0.0, 0.0, 0.0, 1.0]               # of the projector, in the camera's optical frame
//!     orientation_sigma_rad: [0.0001, 0.0001, 0.0001]   # about the projector's own axes
//! ```

use std::fmt::Write as _;

use rcs_calibration::{Coverage, Report, ScanPose};

use crate::yaml_text::{exact, figure, figures, list, quoted};

/// Text of the file.
pub(super) fn yaml(report: &Report) -> String {
    let Report { solution, coverage, .. } = report;
    let Coverage { image, depth_m, scans } = coverage;
    let mut yaml = "# A projector's calibration. Pixels are the projector's.\n".to_owned();
    let mut line = |key: &str, value: &str| {
        // Writing to a String cannot fail.
        let _ = writeln!(yaml, "{key}: {value}");
    };
    let reasons: Vec<String> = report.reasons.iter().map(|reason| quoted(reason)).collect();
    line("verdict", report.verdict.name());
    line("reasons", &format!("[{}]", reasons.join(", ")));
    line("rms_px", &figure(solution.rms_px));
    line("held_out_rms_px", &figure(solution.held_out_rms_px));
    line("prediction_sigma_px", &figure(solution.prediction_sigma_px));
    line("max_px", &figure(solution.max_px));
    line("rms_mm", &figure(1000.0 * report.rms_m));
    line("points", &report.points.to_string());
    line("inliers", &solution.inliers.to_string());
    line("coverage", &format!("{{picture: {}, depth_m: {}, scans: {scans}}}", figure(*image), figures(depth_m)));
    line("smooth_depth_error_m", &figure(report.smooth_depth_error_m));
    if let Some(skew) = solution.skew {
        line("skew_px", &format!("{{value: {}, sigma: {}}}", figure(skew.value_px), figure(skew.sigma_px)));
    }
    let [width, height] = solution.lens.size_px;
    line("size_px", &format!("[{width}, {height}]"));
    yaml += if solution.estimates.is_empty() { "parameters: {}\n" } else { "parameters:\n" };
    for estimate in &solution.estimates {
        let (value, sigma) = (exact(estimate.value), figure(estimate.sigma));
        let _ = writeln!(yaml, "  {}: {{value: {value}, sigma: {sigma}}}", estimate.parameter);
    }
    yaml += if solution.poses.is_empty() { "poses: []\n" } else { "poses:\n" };
    yaml.extend(solution.poses.iter().map(pose));
    yaml
}

fn pose(pose: &ScanPose) -> String {
    let camera_from_projector = pose.projector_from_camera.inverse();
    let position: [f64; 3] = camera_from_projector.translation.vector.into();
    let rotation = camera_from_projector.rotation;
    format!(
        "  - scan: {}\n    inliers: {}\n    position_m: {}\n    position_sigma_m: {}\n    rotation_xyzw: {}\n    \
         orientation_sigma_rad: {}\n",
        pose.scan,
        pose.inliers,
        list(&position, exact),
        figures(&pose.position_sigma_m),
        list(&[rotation.i, rotation.j, rotation.k, rotation.w], exact),
        figures(&pose.orientation_sigma_rad),
    )
}
