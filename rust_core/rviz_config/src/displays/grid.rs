//! `rviz/Grid`: a grid of lines in a plane of a frame, or a stack of them.

use crate::displays::line_style::{LineStyle, LINE_STYLES};
use crate::section::at_least;

/// The plane of a grid, named by the two axes of the reference frame that span it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GridPlane {
    /// Level.
    Xy,
    /// Upright, along X.
    Xz,
    /// Upright, along Y.
    Yz,
}

const PLANES: [(&str, GridPlane); 3] = [("XY", GridPlane::Xy), ("XZ", GridPlane::Xz), ("YZ", GridPlane::Yz)];

properties! {
    /// The properties of a Grid display.
    pub struct GridSettings {
        /// The frame whose origin is the grid's centre; `None` is the fixed frame.
        reference_frame: Option<String> = None => frame_or_fixed("Reference Frame");
        /// Cells along each side; at least 1.
        plane_cell_count: u32 = 10 => count("Plane Cell Count", 1);
        /// Cells along the normal; 0 draws one plane.
        normal_cell_count: u32 = 0 => count("Normal Cell Count", 0);
        /// Side of a cell in metres; at least 0.0001.
        cell_size_m: f32 = 1.0 => float("Cell Size", at_least(0.0001));
        /// Red, green and blue.
        color: [u8; 3] = [160, 160, 164] => color("Color");
        /// Opacity, 0 to 1.
        alpha: f32 = 0.5 => float("Alpha", 0.0..=1.0);
        /// The plane that the grid lies in.
        plane: GridPlane = GridPlane::Xy => choice("Plane", &PLANES);
        /// The grid's centre in the reference frame, in metres.
        offset_m: [f32; 3] = [0.0; 3] => vector("Offset");
    }
    inside "Line Style" {
        /// How lines are drawn.
        line_style: LineStyle = LineStyle::Lines => choice("Value", &LINE_STYLES);
        /// Width of lines of style [`LineStyle::Billboards`] in metres; at least 0.001.
        line_width_m: f32 = 0.03 => float("Line Width", at_least(0.001));
    }
}
