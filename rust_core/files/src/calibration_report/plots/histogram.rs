//! Histogram of reprojection errors.

use rcs_calibration::statistics::quantile;
use rcs_calibration::Solution;

use super::axes::Axes;
use super::INK;
use crate::calibration_report::scale::{digits, Scale};
use crate::calibration_report::svg::{Anchor, Svg};

const BINS: usize = 36;

/// Draws the plot.
pub(in crate::calibration_report) fn histogram(solution: &Solution) -> String {
    let [left, top, right, bottom] = [62.0, 34.0, 450.0, 262.0];
    let inliers = solution.residuals.iter().filter(|residual| residual.is_inlier);
    let mut errors: Vec<f64> =
        inliers.map(|residual| residual.error_px.norm()).filter(|error| error.is_finite()).collect();
    // The largest half percent would squeeze the others.
    let nearly_all = if errors.is_empty() { 1.0 } else { quantile(&mut errors, 0.995) };
    let marks = [solution.rms_px, solution.held_out_rms_px].map(|rms| if rms.is_finite() { rms } else { 0.0 });
    let last = marks.iter().fold(nearly_all, |last, rms| last.max(1.1 * rms));
    let x = Scale::rounded([0.0, last], [left, right]);
    let mut bins = [0_usize; BINS];
    for error in &errors {
        if let Some(bin) = bins.get_mut((x.share(*error) * BINS as f64) as usize) {
            *bin += 1;
        }
    }
    let percent = |count: usize| 100.0 * count as f64 / errors.len().max(1) as f64;
    let highest = bins.iter().map(|count| percent(*count)).fold(0.0, f64::max);
    let y = Scale::rounded([0.0, highest], [bottom, top]);
    let axes = Axes { x, y, x_label: "reprojection error [px]", y_label: "points [%]" };

    let mut svg = Svg::new([right + 20.0, bottom + 50.0], "Error histogram");
    axes.draw(&mut svg);
    let width = (right - left) / BINS as f64;
    for (index, count) in bins.iter().enumerate() {
        let height = bottom - y.place(percent(*count));
        let place = [left + width * index as f64 + 0.5, bottom - height];
        svg.rect(place, [width - 1.0, height], "fill=\"#4a8fc7\"");
    }
    svg.line([left, bottom], [right, bottom], &format!("stroke=\"{INK}\""));
    draw_marks(&mut svg, &axes, marks);
    svg.finish()
}

/// Draws lines at the RMS and the held-out RMS error; their texts do not overlap.
fn draw_marks(svg: &mut Svg, axes: &Axes<'_>, [rms, held_out]: [f64; 2]) {
    let [_, top, right, bottom] = axes.area();
    let marks = [(rms, "RMS", INK, 20.0), (held_out, "held-out RMS", "#b3261e", 6.0)];
    for (value, name, ink, above) in marks {
        let x = axes.x.place(value);
        svg.line(
            [x, bottom],
            [x, top - above],
            &format!("stroke=\"{ink}\" stroke-width=\"1.5\" stroke-dasharray=\"5 3\""),
        );
        let text = format!("{name} {} px", digits(value, 3));
        let (anchor, x) = if x > 0.6 * right { (Anchor::End, x - 5.0) } else { (Anchor::Start, x + 5.0) };
        svg.text([x, top - above + 4.0], anchor, &text, &format!("fill=\"{ink}\" font-size=\"11\""));
    }
}
