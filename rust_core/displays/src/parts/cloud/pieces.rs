//! The pieces of at most [`MAX_VERTICES`] vertices that rviz cuts a cloud into; translucent ones are sorted piece by
//! piece.

use rcs_scene::{PointBuffer, PointColors, PointStyle};

const MAX_VERTICES: usize = 36 * 1024 * 10;

/// Points in a piece of a style.
pub(crate) fn max_points(style: &PointStyle) -> usize {
    let vertices_per_point = match style {
        PointStyle::Points { .. } => 1,
        PointStyle::Spheres { .. } => 3,
        PointStyle::Squares { .. } | PointStyle::FlatSquares { .. } | PointStyle::Tiles { .. } => 6,
        PointStyle::Boxes { .. } => 36,
    };
    MAX_VERTICES / vertices_per_point
}

/// Cuts a cloud into pieces; one that fits into a piece stays as it is.
pub(super) fn cut(buffer: PointBuffer, style: &PointStyle) -> Vec<PointBuffer> {
    let max_points = max_points(style);
    if buffer.positions.len() <= max_points {
        return vec![buffer];
    }
    let mut pieces = Vec::with_capacity(buffer.positions.len().div_ceil(max_points));
    for (i, some) in buffer.positions.chunks(max_points).enumerate() {
        let colors = match &buffer.colors {
            PointColors::Uniform(color) => PointColors::Uniform(*color),
            PointColors::PerPoint(all) => {
                PointColors::PerPoint(all.iter().skip(i * max_points).take(some.len()).copied().collect())
            }
        };
        pieces.push(PointBuffer { positions: some.to_vec(), colors });
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pieces_are_the_whole_in_order() {
        let count = 25_000;
        let positions: Vec<[f32; 3]> = (0..count).map(|i| [i as f32; 3]).collect();
        let colors: Vec<[u8; 4]> = (0..count as u32).map(u32::to_le_bytes).collect();
        let whole = PointBuffer { positions: positions.clone(), colors: PointColors::PerPoint(colors) };
        let pieces = cut(whole, &PointStyle::Boxes { size_m: [0.1; 3] });
        let lens: Vec<usize> = pieces.iter().map(|piece| piece.positions.len()).collect();
        assert_eq!(lens, [10_240, 10_240, 4_520]);
        assert_eq!(pieces.iter().flat_map(|piece| piece.positions.clone()).collect::<Vec<_>>(), positions);
        assert_eq!(pieces[2].colors.get(0), 20_480_u32.to_le_bytes());
    }
}
