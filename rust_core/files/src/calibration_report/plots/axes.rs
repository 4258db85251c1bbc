//! Plot axes with tick marks and labels, and colour bars.

use super::{GREY, GRID};
use crate::calibration_report::scale::{colour, Scale};
use crate::calibration_report::svg::{Anchor, Svg};

/// Two axes.
pub(super) struct Axes<'a> {
    pub(super) x: Scale,
    pub(super) y: Scale,
    /// Label with the unit.
    pub(super) x_label: &'a str,
    /// Label with the unit.
    pub(super) y_label: &'a str,
}

impl Axes<'_> {
    /// Left, top, right and bottom of the plot area.
    pub(super) fn area(&self) -> [f64; 4] {
        let ([x0, x1], [y0, y1]) = (self.x.range(), self.y.range());
        let (left, right) = (self.x.place(x0), self.x.place(x1));
        let (one, other) = (self.y.place(y0), self.y.place(y1));
        [left, one.min(other), right, one.max(other)]
    }

    /// Draws grid lines, tick labels and axis labels.
    pub(super) fn draw(&self, svg: &mut Svg) {
        let [left, top, right, bottom] = self.area();
        let small = format!("fill=\"{GREY}\" font-size=\"11\"");
        for (tick, text) in self.x.ticks((right - left) / 75.0) {
            let x = self.x.place(tick);
            svg.line([x, top], [x, bottom + 4.0], GRID);
            svg.text([x, bottom + 17.0], Anchor::Middle, &text, &small);
        }
        for (tick, text) in self.y.ticks((bottom - top) / 45.0) {
            let y = self.y.place(tick);
            svg.line([left - 4.0, y], [right, y], GRID);
            svg.text([left - 7.0, y + 4.0], Anchor::End, &text, &small);
        }
        let label = format!("fill=\"{GREY}\"");
        svg.text([0.5 * (left + right), bottom + 36.0], Anchor::Middle, self.x_label, &label);
        svg.text_upwards([left - 46.0, 0.5 * (top + bottom)], self.y_label, &label);
    }

    /// Draws a border over the data.
    pub(super) fn draw_border(&self, svg: &mut Svg) {
        let [left, top, right, bottom] = self.area();
        let border = format!("fill=\"none\" stroke=\"{GREY}\" stroke-width=\"1\"");
        svg.rect([left, top], [right - left, bottom - top], &border);
    }
}

/// Colour bar to the right of the axes.
pub(super) struct ColourBar<'a> {
    /// Left edge.
    pub(super) left: f64,
    /// Scale from bottom to top.
    pub(super) scale: Scale,
    /// Colour map of the scale's range.
    pub(super) stops: &'a [[u8; 3]],
    /// Marked quantities with their texts.
    pub(super) ticks: Vec<(f64, String)>,
    /// Label with the unit.
    pub(super) label: &'a str,
}

impl ColourBar<'_> {
    pub(super) fn draw(&self, svg: &mut Svg) {
        const STEPS: u32 = 48;
        const WIDTH: f64 = 14.0;
        let Self { left, scale, stops, ticks, label } = self;
        let [low, high] = scale.range();
        let (bottom, top) = (scale.place(low), scale.place(high));
        let step = (bottom - top) / f64::from(STEPS);
        for index in 0..STEPS {
            let fill = colour(stops, (f64::from(index) + 0.5) / f64::from(STEPS));
            let y = bottom - step * f64::from(index + 1);
            // Half a unit more hides gaps.
            svg.rect([*left, y], [WIDTH, step + 0.5], &format!("fill=\"{fill}\""));
        }
        let small = format!("fill=\"{GREY}\" font-size=\"11\"");
        for (tick, text) in ticks {
            let y = scale.place(*tick);
            svg.line([left + WIDTH, y], [left + WIDTH + 4.0, y], &format!("stroke=\"{GREY}\""));
            svg.text([left + WIDTH + 7.0, y + 4.0], Anchor::Start, text, &small);
        }
        svg.text_upwards([left + WIDTH + 46.0, 0.5 * (bottom + top)], label, &format!("fill=\"{GREY}\""));
    }
}
