//! The test images, each drawn by one function.

use rcs_scene::Image;

use super::canvas::{Anchor, Canvas, BLACK, WHITE};
use crate::monitor::MonitorInfo;

/// Level of secondary lines.
const DIM: u8 = 110;

/// The size of small text in an image.
fn small_text_em_px(size_px: [u32; 2]) -> f64 {
    (0.024 * f64::from(size_px[0].min(size_px[1]))).clamp(9.0, 60.0).round()
}

/// Lines at round coordinates, and the coordinates at each crossing.
pub(super) fn grid(size_px: [u32; 2]) -> Image {
    let mut canvas = Canvas::new(size_px, BLACK);
    let spacing = grid_spacing(size_px);
    let [width, height] = canvas.size_px();
    let lines = |side: i64| (0..side).step_by(spacing);
    for u in lines(width) {
        canvas.column(u, DIM);
    }
    for v in lines(height) {
        canvas.row(v, DIM);
    }
    // A scale on each line: every tenth of the spacing, the fifth longer.
    let tick = spacing as i64 / 10;
    for v in lines(height) {
        for (index, u) in (0..width).step_by(tick.max(1) as usize).enumerate() {
            let half = if index % 5 == 0 { 5 } else { 2 };
            canvas.fill([u, v - half], [u + 1, v + half + 1], DIM);
        }
    }
    for u in lines(width) {
        for (index, v) in (0..height).step_by(tick.max(1) as usize).enumerate() {
            let half = if index % 5 == 0 { 5 } else { 2 };
            canvas.fill([u - half, v], [u + half + 1, v + 1], DIM);
        }
    }
    let em_px = small_text_em_px(size_px).min(spacing as f64 * 0.19);
    for v in lines(height) {
        for u in lines(width) {
            canvas.fill([u - 1, v - 1], [u + 2, v + 2], WHITE);
            let text = format!("{u},{v}");
            let [text_width, text_height] = Canvas::text_size_px(&text, em_px);
            // Above the line where it would be cut off below or at the right: the label to the left is below its line.
            let is_left = u as f64 + 8.0 + text_width > width as f64;
            let is_above = is_left || v as f64 + 6.0 + text_height > height as f64;
            let (anchor, across, down) = match (is_left, is_above) {
                (_, false) => (Anchor::TopLeft, 8.0, 6.0),
                (false, true) => (Anchor::BottomLeft, 8.0, -6.0),
                (true, true) => (Anchor::BottomRight, -8.0, -6.0),
            };
            canvas.text(&text, [u as f64 + across, v as f64 + down], anchor, em_px, WHITE);
        }
    }
    canvas.frame([0, 0], [width, height], WHITE);
    canvas.into_image()
}

/// A round number of pixels, at most 13 times in the longer side so that labels have room.
fn grid_spacing(size_px: [u32; 2]) -> usize {
    let longer = size_px[0].max(size_px[1]) as usize;
    let fits = |spacing: &usize| longer / spacing <= 13;
    [10, 20, 50, 100, 200, 500, 1000].into_iter().find(fits).unwrap_or(2000)
}

/// Squares, whole ones if there is a side that divides the image.
pub(super) fn checkerboard(size_px: [u32; 2]) -> Image {
    let side = i64::from(square_side(size_px));
    let mut canvas = Canvas::new(size_px, BLACK);
    let end = canvas.size_px();
    canvas.fill_with([0, 0], end, |u, v| if (u / side + v / side) % 2 == 0 { WHITE } else { BLACK });
    canvas.into_image()
}

/// The side of a square: one that divides both sides of the image if there is one from a twentieth to a twelfth of
/// the width.
fn square_side([width, height]: [u32; 2]) -> u32 {
    let fits = |side: &u32| width % side == 0 && height % side == 0;
    (width.div_ceil(20).max(1)..=width / 12).rev().find(fits).unwrap_or((width / 16).max(1))
}

/// Lines through the middle, two pixels wide where the middle lies between pixels, and a scale from there.
pub(super) fn crosshair(size_px: [u32; 2]) -> Image {
    let mut canvas = Canvas::new(size_px, BLACK);
    let [width, height] = canvas.size_px();
    let first = [(width - 1) / 2, (height - 1) / 2];
    let end = [width / 2 + 1, height / 2 + 1];
    canvas.fill([first[0], 0], [end[0], height], WHITE);
    canvas.fill([0, first[1]], [width, end[1]], WHITE);
    let half_of = |distance: i64| match distance {
        _ if distance % 100 == 0 => 14,
        _ if distance % 50 == 0 => 9,
        _ => 4,
    };
    let em_px = small_text_em_px(size_px);
    for distance in (10..width.max(height)).step_by(10) {
        let half = half_of(distance);
        for at in [first[0] - distance, end[0] - 1 + distance] {
            canvas.fill([at, first[1] - half], [at + 1, end[1] + half], WHITE);
        }
        for at in [first[1] - distance, end[1] - 1 + distance] {
            canvas.fill([first[0] - half, at], [end[0] + half, at + 1], WHITE);
        }
        if distance % 100 == 0 {
            let label = distance.to_string();
            let below = end[1] as f64 + 16.0 + 0.5 * em_px;
            for at in [first[0] - distance, end[0] - 1 + distance] {
                if (em_px as i64..width - em_px as i64).contains(&at) {
                    canvas.text(&label, [at as f64, below], Anchor::Middle, em_px, WHITE);
                }
            }
            // None that would be cut off.
            for at in [first[1] - distance, end[1] - 1 + distance] {
                let place = [end[0] as f64 + 20.0, at as f64 - 0.56 * em_px];
                if (0.0..height as f64 - 1.12 * em_px).contains(&place[1]) {
                    canvas.text(&label, place, Anchor::TopLeft, em_px, WHITE);
                }
            }
        }
    }
    let middle = [0, 1].map(|axis| (f64::from(size_px[axis]) - 1.0) / 2.0);
    let place = [end[0] as f64 + 20.0, first[1] as f64 - 20.0];
    canvas.text(&format!("({}, {})", middle[0], middle[1]), place, Anchor::BottomLeft, em_px, WHITE);
    canvas.into_image()
}

/// The outermost pixels, their coordinates in the corners, and fields of stripes one pixel wide, which look evenly grey
/// unless the image is scaled.
pub(super) fn border(size_px: [u32; 2]) -> Image {
    let mut canvas = Canvas::new(size_px, BLACK);
    let [width, height] = canvas.size_px();
    let em_px = small_text_em_px(size_px);
    canvas.frame([0, 0], [width, height], WHITE);
    let (near, [far_u, far_v]) = (10.0, [width as f64 - 10.0, height as f64 - 10.0]);
    let [last_u, last_v] = [width - 1, height - 1];
    for (text, place, anchor) in [
        ("0,0".to_owned(), [near, near], Anchor::TopLeft),
        (format!("{last_u},0"), [far_u, near], Anchor::TopRight),
        (format!("0,{last_v}"), [near, far_v], Anchor::BottomLeft),
        (format!("{last_u},{last_v}"), [far_u, far_v], Anchor::BottomRight),
    ] {
        canvas.text(&text, place, anchor, em_px, WHITE);
    }
    let (field, middle) = ((width.min(height) / 5).max(1), [width / 2, height / 2]);
    let gap = field / 8;
    type IsLit = fn(i64, i64) -> bool;
    let fields: [(i64, IsLit); 3] = [
        (-field / 2 - gap - field, |u, _| u % 2 == 0),
        (-field / 2, |u, v| (u + v) % 2 == 0),
        (-field / 2 + gap + field, |_, v| v % 2 == 0),
    ];
    let top = middle[1] - field / 2;
    for (left, is_lit) in fields {
        let left = middle[0] + left;
        canvas.fill_with([left, top], [left + field, top + field], |u, v| if is_lit(u, v) { WHITE } else { BLACK });
    }
    let lines = ["the outermost line must be seen on all four sides", "the fields must be evenly grey, without bands"];
    for (index, line) in lines.into_iter().enumerate() {
        let row = (top + field) as f64 + (1.0 + 1.3 * index as f64) * em_px;
        canvas.text(line, [middle[0] as f64, row + 0.5 * em_px], Anchor::Middle, em_px, WHITE);
    }
    canvas.into_image()
}

/// Levels of grey: all of them from left to right, 17 steps with their values, and the darkest and lightest ones beside
/// black and white.
pub(super) fn ramp(size_px: [u32; 2]) -> Image {
    const STEPS: i64 = 17;
    let mut canvas = Canvas::new(size_px, BLACK);
    let [width, height] = canvas.size_px();
    let em_px = small_text_em_px(size_px);
    let rows = [height / 3, 2 * height / 3];
    canvas.fill_with([0, 0], [width, rows[0]], |u, _| (u * 255 / (width - 1).max(1)) as u8);
    let step_of = |u: i64| u * STEPS / width.max(1);
    let level_of = |step: i64| ((step * 255 + STEPS / 2) / (STEPS - 1)) as u8;
    canvas.fill_with([0, rows[0]], [width, rows[1]], |u, _| level_of(step_of(u)));
    let opposite = |level: u8| if level < 128 { WHITE } else { BLACK };
    for step in 0..STEPS {
        let level = level_of(step);
        let place = [(width * (2 * step + 1)) as f64 / (2 * STEPS) as f64, rows[1] as f64 - em_px];
        canvas.text(&level.to_string(), place, Anchor::Middle, em_px, opposite(level));
    }
    // Squares that must be distinguishable from their surroundings.
    const NEAR: [u8; 6] = [2, 4, 8, 12, 16, 24];
    let half = width / 2;
    canvas.fill([half, rows[1]], [width, height], WHITE);
    let cell = half / (NEAR.len() as i64 + 1);
    let side = (cell * 2 / 3).min((height - rows[1]) / 2);
    for (index, near) in NEAR.into_iter().enumerate() {
        for (start, level) in [(0, near), (half, WHITE - near)] {
            let middle = [start + cell * (index as i64 + 1), (rows[1] + height) / 2 - side / 4];
            canvas.fill(middle.map(|at| at - side / 2), middle.map(|at| at + side / 2), level);
            let place = [middle[0] as f64, (middle[1] + side / 2) as f64 + em_px];
            canvas.text(&level.to_string(), place, Anchor::Middle, em_px, opposite(level));
        }
    }
    canvas.into_image()
}

/// The monitor's name and resolution, as large as possible.
pub(super) fn name(size_px: [u32; 2], monitor: &str) -> Image {
    let mut canvas = Canvas::new(size_px, BLACK);
    let [width, height] = canvas.size_px();
    canvas.frame([0, 0], [width, height], WHITE);
    let resolution = format!("{width} x {height}");
    let middle = [width as f64 / 2.0, height as f64 / 2.0];
    lines(&mut canvas, &[(monitor, 0.36, 0.2), (&resolution, 0.58, 0.16)]);
    let hint = "space: next picture, backspace: previous, escape: end";
    canvas.text(hint, [middle[0], 0.8 * height as f64], Anchor::Middle, small_text_em_px(size_px), DIM);
    canvas.into_image()
}

/// The monitor's number in the list, name, resolution and position in the desktop.
pub(crate) fn identification(index: usize, monitor: &MonitorInfo) -> Image {
    let (width, height) = monitor.size_px;
    let mut canvas = Canvas::new([width, height], BLACK);
    let [columns, rows] = canvas.size_px();
    canvas.frame([0, 0], [columns, rows], WHITE);
    let (number, resolution) = (index.to_string(), format!("{width} x {height}"));
    let (x, y) = monitor.position_px;
    let primary = if monitor.is_primary { ", primary" } else { "" };
    let place = format!("at {x:+}{y:+}{primary}");
    lines(
        &mut canvas,
        &[(&number, 0.24, 0.3), (&monitor.name, 0.52, 0.14), (&resolution, 0.69, 0.12), (&place, 0.84, 0.08)],
    );
    canvas.into_image()
}

/// Centred texts, each with its row and its letters' size as shares of the image's height.
fn lines(canvas: &mut Canvas, texts: &[(&str, f64, f64)]) {
    let [width, height] = canvas.size_px().map(|side| side as f64);
    for (text, row, share) in texts {
        let [width_at_1, _] = Canvas::text_size_px(text, 1.0);
        let letters = (share * height).min(0.85 * width / width_at_1.max(1e-3));
        canvas.text(text, [width / 2.0, row * height], Anchor::Middle, letters, WHITE);
    }
}
