//! Marks that reveal rotation and mirroring of a projected image: in each corner a white disc with one to four black
//! dots, clockwise from the top left. The number of dots identifies a corner however it is distorted, and the order of
//! corners distinguishes mirroring from rotation. For people there is an F in the middle, which is different in each of
//! the eight orientations.

use rcs_scene::Image;

use super::canvas::{Canvas, BLACK, WHITE};

/// A disc with dots.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct OrientationMark {
    /// The disc's centre, pixels.
    pub(super) center_px: [f64; 2],
    /// The disc's radius, pixels.
    pub(super) radius_px: f64,
    /// Number of dots.
    pub(super) dots: u32,
    /// The dots' radius, pixels.
    pub(super) dot_radius_px: f64,
}

/// The marks of an image of this size, clockwise from the top left, with one to four dots.
pub(super) fn orientation_marks(size_px: [u32; 2]) -> [OrientationMark; 4] {
    let [width, height] = size_px.map(f64::from);
    let radius_px = 0.13 * width.min(height);
    // A quarter of the radius away from the edges.
    let near = 1.25 * radius_px;
    let (far_u, far_v) = (width - 1.0 - near, height - 1.0 - near);
    let mark = |dots, center_px| OrientationMark { center_px, radius_px, dots, dot_radius_px: 0.2 * radius_px };
    [mark(1, [near, near]), mark(2, [far_u, near]), mark(3, [far_u, far_v]), mark(4, [near, far_v])]
}

impl OrientationMark {
    /// The dots' centres, pixels.
    pub(super) fn dots_px(&self) -> Vec<[f64; 2]> {
        // A single dot is in the middle; others are more than a diameter from each other and from the edge.
        let ring_px = if self.dots < 2 { 0.0 } else { 0.52 * self.radius_px };
        let turn = std::f64::consts::TAU / f64::from(self.dots.max(1));
        let angles = (0..self.dots).map(|dot| turn * (f64::from(dot) + 0.5));
        angles
            .map(|angle| [0, 1].map(|axis| self.center_px[axis] + ring_px * [angle.sin(), -angle.cos()][axis]))
            .collect()
    }
}

/// The image with the marks and an F.
pub(super) fn orientation(size_px: [u32; 2]) -> Image {
    let mut canvas = Canvas::new(size_px, BLACK);
    for mark in orientation_marks(size_px) {
        canvas.disc(mark.center_px, mark.radius_px, WHITE);
        for dot in mark.dots_px() {
            canvas.disc(dot, mark.dot_radius_px, BLACK);
        }
    }
    // Stem and bars of the F, in sixths of its height.
    let sixth = canvas.size_px().into_iter().min().unwrap_or(0) / 12;
    let [left, top] = canvas.size_px().map(|side| side / 2);
    let (left, top) = (left - 2 * sixth, top - 3 * sixth);
    for (columns, first_row, last_row) in [(1, 0, 6), (4, 0, 1), (3, 2, 3)] {
        let (first, end) = ([left, top + first_row * sixth], [left + columns * sixth, top + last_row * sixth]);
        canvas.fill(first, end, WHITE);
    }
    canvas.into_image()
}
