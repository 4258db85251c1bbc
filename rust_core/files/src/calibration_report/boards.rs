//! Part of both files on a calibration with a board: the camera's lens, and the errors of each of the board's poses.
//!
//! ```yaml
//! camera:
//!   rms_px: 0.12                                        # of the board's corners, in the camera's image
//!   size_px: [1280, 720]
//!   parameters:
//!     fx: {value: 1000.2, sigma: 0.9}                   # sigma 0: by its CameraInfo
//! left_out_rms_px: 0.15                                 # of poses by a calibration without them
//! boards:
//!   - {name: "pose01", camera_rms_px: 0.11, projector_rms_px: 0.08, left_out_px: 0.14, distance_m: 1.13}
//! ```

use std::fmt::Write as _;

use rcs_calibration::board::{BoardPose, BoardSolution};

use super::page::estimates_table;
use super::scale::digits;
use super::svg::escaped;
use crate::yaml_text::{exact, figure, quoted};

/// Lines for `report.yaml`.
pub(super) fn yaml(solution: &BoardSolution) -> String {
    let [width, height] = solution.camera.size_px;
    let mut yaml = format!(
        "camera:\n  rms_px: {}\n  size_px: [{width}, {height}]\n  parameters:\n",
        figure(solution.camera_rms_px)
    );
    for estimate in &solution.camera_estimates {
        let (value, sigma) = (exact(estimate.value), figure(estimate.sigma));
        // Writing to a String cannot fail.
        let _ = writeln!(yaml, "    {}: {{value: {value}, sigma: {sigma}}}", estimate.parameter);
    }
    if let Some(left_out_px) = solution.left_out_px {
        let _ = writeln!(yaml, "left_out_rms_px: {}", figure(left_out_px));
    }
    yaml += "boards:\n";
    for pose in &solution.poses {
        let left_out =
            pose.left_out_px.map_or(String::new(), |left_out| format!("left_out_px: {}, ", figure(left_out)));
        let _ = writeln!(
            yaml,
            "  - {{name: {}, camera_rms_px: {}, projector_rms_px: {}, {left_out}distance_m: {}}}",
            quoted(&pose.name),
            figure(pose.camera_rms_px),
            figure(pose.projector_rms_px),
            figure(pose.camera_from_board.translation.vector.norm()),
        );
    }
    yaml
}

/// Tables for `report.html`.
pub(super) fn tables(solution: &BoardSolution) -> String {
    let rows: String = solution.poses.iter().map(row).collect();
    format!(
        "{}<h2>Poses of the board</h2>\n<p class=\"note\">RMS errors at the corners. A pose that is left out is predicted by \
         the others.</p>\n<div class=\"wide\"><table>\n<tr><th>pose</th><th class=\"number\">distance [m]</th>\
         <th class=\"number\">camera [px]</th><th class=\"number\">projector [px]</th>\
         <th class=\"number\">left out [px]</th></tr>\n{rows}</table></div>\n",
        estimates_table("Camera lens", &solution.camera_estimates)
    )
}

fn row(pose: &BoardPose) -> String {
    let left_out = pose.left_out_px.map_or_else(|| "–".to_owned(), |left_out| digits(left_out, 3));
    let figures = [
        digits(pose.camera_from_board.translation.vector.norm(), 3),
        digits(pose.camera_rms_px, 3),
        digits(pose.projector_rms_px, 3),
        left_out,
    ];
    let cells = figures.map(|figure| format!("<td class=\"number\">{figure}</td>")).concat();
    format!("<tr><td>{}</td>{cells}</tr>\n", escaped(&pose.name))
}
