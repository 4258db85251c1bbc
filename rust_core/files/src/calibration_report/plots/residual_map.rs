//! Residuals over the projector's image: cells coloured by RMS, with arrows for their significant mean. Noise has no
//! arrows; a pattern of arrows shows a distortion that was not solved for.

use nalgebra::Vector2;
use rcs_calibration::statistics::quantile;
use rcs_calibration::{Sample, Solution};

use super::axes::{Axes, ColourBar};
use super::{GREY, INK, WARM};
use crate::calibration_report::scale::{colour, digits, Scale};
use crate::calibration_report::svg::{Anchor, Svg};

/// Cells along the longer side of the image.
const CELLS: f64 = 24.0;
/// Minimum points of a cell with an arrow.
const ARROW_POINTS: u32 = 5;

/// Residual sums of a cell.
#[derive(Clone, Copy, Default)]
struct ResidualCell {
    points: u32,
    sum: Vector2<f64>,
    sum_squared: f64,
}

impl ResidualCell {
    fn rms(&self) -> f64 {
        (self.sum_squared / f64::from(self.points.max(1))).sqrt()
    }

    fn mean(&self) -> Vector2<f64> {
        self.sum / f64::from(self.points.max(1))
    }

    /// Mean, shortened by its own deviation so that chance does not show.
    fn bias(&self) -> Vector2<f64> {
        let (mean, points) = (self.mean(), f64::from(self.points.max(1)));
        let variance = (self.sum_squared / points - mean.norm_squared()).max(0.0) / points;
        let length = mean.norm();
        if length > 0.0 {
            mean * ((length - 1.5 * variance.sqrt()).max(0.0) / length)
        } else {
            mean
        }
    }
}

/// Cells of the image.
struct ResidualGrid {
    columns: usize,
    cell_px: f64,
    cells: Vec<ResidualCell>,
}

impl ResidualGrid {
    fn new(solution: &Solution, samples: &[Sample]) -> Self {
        let [width, height] = solution.lens.size_px.map(|size| f64::from(size.max(1)));
        let cell_px = width.max(height) / CELLS;
        let [columns, rows] = [width, height].map(|size| (size / cell_px - 1e-9).ceil().max(1.0) as usize);
        let mut cells = vec![ResidualCell::default(); columns * rows];
        for residual in solution.residuals.iter().filter(|residual| residual.is_inlier) {
            let Some(sample) = samples.get(residual.sample) else { continue };
            let error = residual.error_px;
            if !solution.lens.contains(sample.pixel) || !error.norm_squared().is_finite() {
                continue;
            }
            let [column, row] = [sample.pixel.x, sample.pixel.y].map(|at| ((at + 0.5) / cell_px) as usize);
            if let Some(cell) = cells.get_mut(row * columns + column) {
                cell.points += 1;
                cell.sum += error;
                cell.sum_squared += error.norm_squared();
            }
        }
        Self { columns, cell_px, cells }
    }

    /// Cells with points, with their centres, pixels.
    fn filled(&self) -> impl Iterator<Item = ([f64; 2], &ResidualCell)> {
        let filled = self.cells.iter().enumerate().filter(|(_, cell)| cell.points > 0);
        filled.map(|(index, cell)| {
            let (column, row) = (index % self.columns, index / self.columns);
            ([column, row].map(|at| (at as f64 + 0.5) * self.cell_px - 0.5), cell)
        })
    }
}

/// Draws the plot.
pub(in crate::calibration_report) fn residual_map(solution: &Solution, samples: &[Sample]) -> String {
    const LEFT: f64 = 62.0;
    const TOP: f64 = 12.0;
    let [width_px, height_px] = solution.lens.size_px.map(|size| f64::from(size.max(1)));
    // Pixels are square; tall images become narrow.
    let unit = (640.0 / width_px).min(520.0 / height_px);
    let [width, height] = [width_px * unit, height_px * unit].map(|size| size.max(120.0));
    let axes = Axes {
        x: Scale::new([-0.5, width_px - 0.5], [LEFT, LEFT + width]),
        y: Scale::new([-0.5, height_px - 0.5], [TOP, TOP + height]),
        x_label: "u in the projector's picture [px]",
        y_label: "v [px]",
    };
    let grid = ResidualGrid::new(solution, samples);
    let mut rms: Vec<f64> = grid.filled().map(|(_, cell)| cell.rms()).collect();
    // A few bad cells must not make all others look alike.
    let largest = if rms.is_empty() { 1.0 } else { quantile(&mut rms, 0.97) };
    let colours = Scale::rounded([0.0, largest], [TOP + height, TOP]);

    let mut svg = Svg::new([LEFT + width + 100.0, TOP + height + 74.0], "Residuals over the projector's picture");
    axes.draw(&mut svg);
    for ([u, v], cell) in grid.filled() {
        let half = 0.5 * grid.cell_px;
        let corner = |at: f64, size: f64, side: f64| (at + side * half).clamp(-0.5, size - 0.5);
        let [x0, x1] = [-1.0, 1.0].map(|side| axes.x.place(corner(u, width_px, side)));
        let [y0, y1] = [-1.0, 1.0].map(|side| axes.y.place(corner(v, height_px, side)));
        let fill = colour(&WARM, colours.share(cell.rms()));
        svg.rect([x0, y0], [x1 - x0, y1 - y0], &format!("fill=\"{fill}\" stroke=\"#ffffff\" stroke-width=\"0.5\""));
    }
    let arrow_px = draw_arrows(&mut svg, &axes, &grid, largest);
    axes.draw_border(&mut svg);
    let (left, ticks) = (LEFT + width + 16.0, colours.ticks(5.0));
    ColourBar { left, scale: colours, stops: &WARM, ticks, label: "RMS error [px]" }.draw(&mut svg);

    // Legend of the arrows.
    let (x, y) = (LEFT, TOP + height + 60.0);
    let length = grid.cell_px * axes_unit(&axes);
    svg.arrow([x, y], [x + length, y], &format!("stroke=\"{INK}\" stroke-width=\"1.2\""));
    let meaning = format!("mean residual of a cell; this length: {} px", digits(arrow_px, 2));
    svg.text([x + length + 8.0, y + 4.0], Anchor::Start, &meaning, &format!("fill=\"{GREY}\" font-size=\"11\""));
    svg.finish()
}

/// Drawing units per pixel.
fn axes_unit(axes: &Axes<'_>) -> f64 {
    axes.x.place(1.0) - axes.x.place(0.0)
}

/// Draws the arrows and returns the residual, pixels, whose arrow is as long as a cell.
fn draw_arrows(svg: &mut Svg, axes: &Axes<'_>, grid: &ResidualGrid, largest_rms_px: f64) -> f64 {
    let arrow_px = [1.0, 2.0, 5.0]
        .into_iter()
        .flat_map(|factor| (-4..4).map(move |power| factor * 10_f64.powi(power)))
        .filter(|round| *round >= 0.5 * largest_rms_px)
        .fold(1e4, f64::min);
    let scale = grid.cell_px * axes_unit(axes) / arrow_px;
    for ([u, v], cell) in grid.filled().filter(|(_, cell)| cell.points >= ARROW_POINTS) {
        let bias = cell.bias() * scale;
        let [x, y] = [axes.x.place(u), axes.y.place(v)];
        let (from, to) = ([x - 0.5 * bias.x, y - 0.5 * bias.y], [x + 0.5 * bias.x, y + 0.5 * bias.y]);
        svg.arrow(from, to, &format!("stroke=\"{INK}\" stroke-width=\"1.2\""));
    }
    arrow_px
}
