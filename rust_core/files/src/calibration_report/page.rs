//! `report.html`: verdict and reasons, figures, parameters with deviations, and plots. One self-contained file without
//! scripts.

use std::fmt::Write as _;

use rcs_calibration::{Estimate, Parameter, Report, Sample, ScanPose, Verdict};

use super::plots;
use super::scale::{digits, with_sigma};
use super::svg::escaped;

/// Style sheet.
const STYLE: &str = include_str!("page.css");

/// Text of the file; `more` is appended to its sections.
pub(super) fn page(report: &Report, samples: &[Sample], more: &str) -> String {
    let solution = &report.solution;
    let [width, height] = solution.lens.size_px;
    let sections = [
        format!("<h1>Projector calibration</h1>\n<p class=\"note\">A projector of {width}×{height} pixels</p>\n"),
        verdict(report),
        figures(report),
        format!(
            "<h2>Residuals over the picture</h2>\n<p class=\"note\">Noise has even colours and short arrows. Arrows with a \
             pattern, outwards for example, show an error of the model: the lens, or depth that is wrong over whole \
             areas.</p>\n<div class=\"map\">{}</div>\n",
            plots::residual_map(solution, samples)
        ),
        format!(
            "<div class=\"pair\">\n<div><h2>Error histogram</h2>\n{}</div>\n<div><h2>Coverage in depth</h2>\n{}</div>\n\
             </div>\n",
            plots::histogram(solution),
            plots::depth_coverage(solution, samples)
        ),
        format!(
            "<h2>Cameras and projector</h2>\n<p class=\"note\">View from above the projector. Its frustum is black, with the \
             picture at the nearest and the farthest points. Axes: x red, y green, z blue.</p>\n\
             <div class=\"places\">{}</div>\n",
            plots::places(solution, samples, report.coverage.depth_m)
        ),
        lens_table(report),
        pose_table(report),
        more.to_owned(),
    ];
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>Projector calibration: {}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n{}</body>\n</html>\n",
        report.verdict.name(),
        sections.concat()
    )
}

fn verdict(report: &Report) -> String {
    let (title, sentence) = match report.verdict {
        Verdict::Good => ("Good", "The projector is calibrated accurately."),
        Verdict::Usable => ("Usable", "The calibration could be more accurate:"),
        Verdict::Again => ("Again", "Not usable, scan again:"),
    };
    let reasons: String = report.reasons.iter().map(|reason| format!("<li>{}</li>\n", escaped(reason))).collect();
    let reasons = if reasons.is_empty() { reasons } else { format!("<ul>\n{reasons}</ul>\n") };
    let class = report.verdict.name();
    format!("<div class=\"verdict {class}\"><strong>{title}.</strong> {sentence}\n{reasons}</div>\n")
}

fn figures(report: &Report) -> String {
    let (solution, coverage) = (&report.solution, &report.coverage);
    let [near, far] = coverage.depth_m;
    let share = 100.0 * solution.inliers as f64 / report.points.max(1) as f64;
    let entries = [
        ("Held-out RMS error", digits(solution.held_out_rms_px, 3), "px".to_owned()),
        ("Prediction uncertainty", digits(solution.prediction_sigma_px, 3), "px".to_owned()),
        ("RMS error", digits(solution.rms_px, 3), "px".to_owned()),
        ("RMS error at the points' depth", digits(1000.0 * report.rms_m, 3), "mm".to_owned()),
        ("Largest error of an inlier", digits(solution.max_px, 3), "px".to_owned()),
        ("Inliers", thousands(solution.inliers), format!("of {} ({share:.1} %)", thousands(report.points))),
        ("Picture covered", format!("{:.0}", 100.0 * coverage.image), "%".to_owned()),
        ("Depths", format!("{near:.2} to {far:.2}"), "m".to_owned()),
        ("Smooth depth error, about", digits(1000.0 * report.smooth_depth_error_m, 2), "mm".to_owned()),
        ("Scans", coverage.scans.to_string(), String::new()),
    ];
    let mut html = "<dl class=\"figures\">\n".to_owned();
    for (name, value, unit) in entries {
        // Writing to a String cannot fail.
        let _ = writeln!(html, "<div><dt>{}</dt><dd>{value} <small>{unit}</small></dd></div>", escaped(name));
    }
    html + "</dl>\n"
}

/// Count with narrow spaces between thousands.
fn thousands(count: usize) -> String {
    let text = count.to_string();
    let groups: Vec<&[u8]> = text.as_bytes().rchunks(3).rev().collect();
    let groups: Vec<_> = groups.into_iter().map(String::from_utf8_lossy).collect();
    groups.join("\u{202f}")
}

fn lens_table(report: &Report) -> String {
    estimates_table("Lens", &report.solution.estimates)
}

/// Table of a lens's parameters.
pub(super) fn estimates_table(title: &str, estimates: &[Estimate]) -> String {
    let mut html = format!(
        "<h2>{title}</h2>\n<div class=\"wide\"><table>\n<tr><th></th><th class=\"number\">value</th>\
                    <th class=\"number\">± deviation</th><th></th><th></th></tr>\n"
    );
    for estimate in estimates {
        let [value, sigma] = with_sigma(estimate.value, estimate.sigma);
        let sigma = if estimate.sigma == 0.0 { "fixed".to_owned() } else { sigma };
        let parameter = estimate.parameter;
        let _ = writeln!(
            html,
            "<tr><td>{}</td><td class=\"number\">{value}</td><td class=\"number\">{sigma}</td><td>{}</td><td>{}</td></tr>",
            parameter.name(),
            unit(parameter),
            meaning(parameter),
        );
    }
    html + "</table></div>\n"
}

const fn meaning(parameter: Parameter) -> &'static str {
    match parameter {
        Parameter::Fx => "focal length along u",
        Parameter::Fy => "focal length along v",
        Parameter::Cx => "principal point, u",
        Parameter::Cy => "principal point, v",
        Parameter::K1 | Parameter::K2 | Parameter::K3 => "radial distortion",
        Parameter::P1 | Parameter::P2 => "tangential distortion",
    }
}

/// Unit; none for distortion.
const fn unit(parameter: Parameter) -> &'static str {
    match parameter {
        Parameter::Fx | Parameter::Fy | Parameter::Cx | Parameter::Cy => "px",
        _ => "",
    }
}

fn pose_table(report: &Report) -> String {
    let mut html = "<h2>Projector pose</h2>\n<p class=\"note\">In the camera's optical frame (x right, y down, z \
                    along the view), for each scan.</p>\n<div class=\"wide\"><table>\n<tr><th>scan</th>\
                    <th class=\"number\">inliers</th><th class=\"number\">x [mm]</th><th class=\"number\">y [mm]</th>\
                    <th class=\"number\">z [mm]</th><th class=\"number\">roll [°]</th><th class=\"number\">pitch [°]</th>\
                    <th class=\"number\">yaw [°]</th><th class=\"number\">± turns [°]</th></tr>\n"
        .to_owned();
    html.extend(report.solution.poses.iter().map(pose_row));
    html + "</table></div>\n"
}

fn pose_row(pose: &ScanPose) -> String {
    let camera_from_projector = pose.projector_from_camera.inverse();
    let mut row = format!("<tr><td>{}</td><td class=\"number\">{}</td>", pose.scan, thousands(pose.inliers));
    for (metres, sigma) in camera_from_projector.translation.vector.iter().zip(pose.position_sigma_m) {
        let [value, sigma] = with_sigma(1000.0 * metres, 1000.0 * sigma);
        let _ = write!(row, "<td class=\"number\">{value} ± {sigma}</td>");
    }
    let sigma = pose.orientation_sigma_rad.map(f64::to_degrees);
    let largest = sigma.into_iter().fold(0.0, f64::max);
    let (roll, pitch, yaw) = camera_from_projector.rotation.euler_angles();
    for angle in [roll, pitch, yaw] {
        let [value, _] = with_sigma(angle.to_degrees(), largest);
        let _ = write!(row, "<td class=\"number\">{value}</td>");
    }
    let turns = sigma.map(|sigma| digits(sigma, 2)).join(", ");
    row + &format!("<td class=\"number\">{turns}</td></tr>\n")
}
