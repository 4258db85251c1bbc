//! Coverage across the image and in depth: points at one depth cannot separate focal length and distance.

use rcs_calibration::statistics::quantile;
use rcs_calibration::{Sample, Solution};

use super::axes::{Axes, ColourBar};
use super::COLD;
use crate::calibration_report::scale::{colour, Scale};
use crate::calibration_report::svg::Svg;

const COLUMNS: usize = 36;
const ROWS: usize = 26;

/// Draws the plot.
pub(in crate::calibration_report) fn depth_coverage(solution: &Solution, samples: &[Sample]) -> String {
    let [left, top, right, bottom] = [62.0, 12.0, 390.0, 262.0];
    let width_px = f64::from(solution.lens.size_px[0].max(1));
    let inliers = solution.residuals.iter().filter(|residual| residual.is_inlier && residual.depth_m.is_finite());
    let places: Vec<[f64; 2]> = inliers
        .filter_map(|residual| samples.get(residual.sample).map(|sample| [sample.pixel.x, residual.depth_m]))
        .collect();
    let mut depths: Vec<f64> = places.iter().map(|[_, depth]| *depth).collect();
    let range = if depths.is_empty() { [0.0, 1.0] } else { [0.005, 0.995].map(|share| quantile(&mut depths, share)) };
    let axes = Axes {
        x: Scale::new([-0.5, width_px - 0.5], [left, right]),
        y: Scale::rounded(range, [bottom, top]),
        x_label: "u in the projector's picture [px]",
        y_label: "depth from the projector [m]",
    };
    let mut cells = vec![0_u32; COLUMNS * ROWS];
    for [u, depth] in places {
        let [column, row] = [axes.x.share(u) * COLUMNS as f64, axes.y.share(depth) * ROWS as f64];
        if (0.0..COLUMNS as f64).contains(&column) && (0.0..ROWS as f64).contains(&row) {
            cells[row as usize * COLUMNS + column as usize] += 1;
        }
    }
    // Logarithmic: walls have hundreds of times the points of objects before them.
    let most = f64::from(cells.iter().copied().max().unwrap_or(0).max(10));
    let colours = Scale::new([0.0, most.log10()], [bottom, top]);

    let mut svg = Svg::new([right + 90.0, bottom + 50.0], "Points across the picture and in depth");
    axes.draw(&mut svg);
    let [width, height] = [(right - left) / COLUMNS as f64, (bottom - top) / ROWS as f64];
    for (index, count) in cells.iter().enumerate().filter(|(_, count)| **count > 0) {
        let (column, row) = ((index % COLUMNS) as f64, (index / COLUMNS) as f64);
        let fill = colour(&COLD, colours.share(f64::from(*count).log10()));
        let place = [left + column * width, bottom - (row + 1.0) * height];
        // A little more hides gaps.
        svg.rect([place[0], place[1] - 0.3], [width + 0.3, height + 0.3], &format!("fill=\"{fill}\""));
    }
    axes.draw_border(&mut svg);
    let powers = (0..10).map(f64::from).take_while(|power| *power <= most.log10());
    let ticks = powers.map(|power| (power, format!("{:.0}", 10_f64.powf(power)))).collect();
    ColourBar { left: right + 14.0, scale: colours, stops: &COLD, ticks, label: "points in a cell" }.draw(&mut svg);
    svg.finish()
}
