//! `rviz/Grid`: a grid of lines in a plane of a frame, or a stack of them.

use crate::displays::{LineStyle, LINE_STYLES};
use crate::section::{at_least, Section};

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

/// The properties of a Grid display.
#[derive(Debug, Clone, PartialEq)]
pub struct GridSettings {
    /// The frame whose origin is the grid's centre; `None` is the fixed frame.
    pub reference_frame: Option<String>,
    /// Cells along each side; at least 1.
    pub plane_cell_count: u32,
    /// Cells along the normal; 0 draws one plane.
    pub normal_cell_count: u32,
    /// Side of a cell in metres; at least 0.0001.
    pub cell_size_m: f32,
    /// How lines are drawn.
    pub line_style: LineStyle,
    /// Width of lines of style [`LineStyle::Billboards`] in metres; at least 0.001.
    pub line_width_m: f32,
    /// Red, green and blue.
    pub color: [u8; 3],
    /// Opacity, 0 to 1.
    pub alpha: f32,
    /// The plane that the grid lies in.
    pub plane: GridPlane,
    /// The grid's centre in the reference frame, in metres.
    pub offset_m: [f32; 3],
}

impl Default for GridSettings {
    fn default() -> Self {
        GridSettings {
            reference_frame: None,
            plane_cell_count: 10,
            normal_cell_count: 0,
            cell_size_m: 1.0,
            line_style: LineStyle::Lines,
            line_width_m: 0.03,
            color: [160, 160, 164],
            alpha: 0.5,
            plane: GridPlane::Xy,
            offset_m: [0.0; 3],
        }
    }
}

impl GridSettings {
    pub(crate) fn read(section: &mut Section<'_>) -> Self {
        let mut settings = GridSettings::default();
        section.frame_or_fixed("Reference Frame", &mut settings.reference_frame);
        section.count("Plane Cell Count", 1, &mut settings.plane_cell_count);
        section.count("Normal Cell Count", 0, &mut settings.normal_cell_count);
        section.float("Cell Size", at_least(0.0001), &mut settings.cell_size_m);
        let mut style = section.child("Line Style");
        style.choice("Value", &LINE_STYLES, &mut settings.line_style);
        style.float("Line Width", at_least(0.001), &mut settings.line_width_m);
        style.finish();
        section.color("Color", &mut settings.color);
        section.float("Alpha", 0.0..=1.0, &mut settings.alpha);
        section.choice("Plane", &PLANES, &mut settings.plane);
        section.vector("Offset", &mut settings.offset_m);
        settings
    }
}
