//! The box around points, by whose middle Ogre sorts translucent clouds and lines.

/// Middle of the box around positions; zero without any.
pub(crate) fn middle(positions: impl IntoIterator<Item = [f32; 3]>) -> [f32; 3] {
    let mut positions = positions.into_iter();
    let Some(first) = positions.next() else { return [0.0; 3] };
    let (mut low, mut high) = (first, first);
    for position in positions {
        for axis in 0..3 {
            low[axis] = low[axis].min(position[axis]);
            high[axis] = high[axis].max(position[axis]);
        }
    }
    [0, 1, 2].map(|axis| low[axis] + (high[axis] - low[axis]) * 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_is_that_of_the_box_not_the_mean() {
        assert_eq!(middle([[0.0, 0.0, 1.0], [1.0, 0.0, 3.0], [4.0, -2.0, 2.0]]), [2.0, -1.0, 2.0]);
        assert_eq!(middle([]), [0.0; 3]);
    }
}
