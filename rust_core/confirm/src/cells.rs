//! Cells: squares of pixels that are decided together, and windows over them.

/// Side of a cell, pixels. A pixel of a depth camera covers about as much of a projector's image.
pub(crate) const CELL_PX: usize = 2;

/// Columns and rows of the cells that cover an image of this size.
pub(crate) fn cells_of(size_px: [u32; 2]) -> [usize; 2] {
    size_px.map(|side| (side as usize).div_ceil(CELL_PX))
}

/// Reusable memory of [`window`].
#[derive(Debug, Default)]
pub(crate) struct WindowScratch<T> {
    padded: Vec<T>,
    rows: Vec<T>,
}

/// Replaces each cell by the one that `pick` prefers among those at most `radius` columns and rows away. `outside` is
/// what `pick` never prefers.
#[inline(always)]
pub(crate) fn window<T: Copy>(
    cells: &mut [T],
    width: usize,
    radius: usize,
    outside: T,
    scratch: &mut WindowScratch<T>,
    pick: impl Fn(T, T) -> T + Copy,
) {
    if width == 0 {
        return;
    }
    let WindowScratch { padded, rows } = scratch;
    rows.clear();
    rows.resize(cells.len(), outside);
    padded.clear();
    padded.resize(width + 2 * radius, outside);
    for (row, across) in cells.chunks_exact(width).zip(rows.chunks_exact_mut(width)) {
        padded[radius..radius + width].copy_from_slice(row);
        for offset in 0..=2 * radius {
            across.iter_mut().zip(&padded[offset..]).for_each(|(best, other)| *best = pick(*best, *other));
        }
    }
    let height = cells.len() / width;
    for (y, row) in cells.chunks_exact_mut(width).enumerate() {
        row.fill(outside);
        for near in y.saturating_sub(radius)..(y + radius + 1).min(height) {
            let other = &rows[near * width..(near + 1) * width];
            row.iter_mut().zip(other).for_each(|(best, other)| *best = pick(*best, *other));
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_window_finds_the_largest_within_its_radius(
            width in 1..9_usize, height in 1..7_usize, radius in 0..5_usize, seed in any::<u64>(),
        ) {
            let value = |index: usize| (seed.rotate_left(index as u32 * 7) & 0xff) as u8;
            let cells: Vec<u8> = (0..width * height).map(value).collect();
            let mut found = cells.clone();
            window(&mut found, width, radius, 0, &mut WindowScratch::default(), u8::max);
            for (index, found) in found.iter().enumerate() {
                let (x, y) = (index % width, index / width);
                let is_near = |other: &usize| {
                    (other % width).abs_diff(x) <= radius && (other / width).abs_diff(y) <= radius
                };
                let largest = (0..cells.len()).filter(is_near).map(|other| cells[other]).max().unwrap();
                prop_assert_eq!(*found, largest);
            }
        }
    }
}
