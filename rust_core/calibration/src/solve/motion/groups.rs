//! Small groups of neighbouring samples in the camera's image.
//!
//! Errors that change slowly over the image (smooth depth errors, unmodelled distortion) are nearly equal in a group.

use nalgebra::Vector2;

/// Maximum size of a group; the minimum is half of it.
const MOST: usize = 24;

/// Divides places into groups of indices, by halving at the median along the longer side.
pub(super) fn groups(places: &[Vector2<f64>]) -> Vec<Vec<usize>> {
    let mut groups = Vec::new();
    let mut open = vec![(0..places.len()).collect::<Vec<usize>>()];
    while let Some(mut group) = open.pop() {
        if group.len() <= MOST {
            groups.push(group);
            continue;
        }
        let (mut least, mut most) = (Vector2::repeat(f64::INFINITY), Vector2::repeat(f64::NEG_INFINITY));
        for i in &group {
            (least, most) = (least.inf(&places[*i]), most.sup(&places[*i]));
        }
        let axis = usize::from((most - least).y > (most - least).x);
        let middle = group.len() / 2;
        group.select_nth_unstable_by(middle, |a, b| places[*a][axis].total_cmp(&places[*b][axis]).then(a.cmp(b)));
        let second = group.split_off(middle);
        open.extend([second, group]);
    }
    groups
}

/// Nearest other member of a group to the place `i`.
pub(super) fn nearest(places: &[Vector2<f64>], group: &[usize], i: usize) -> Option<usize> {
    let distance = |other: &usize| (places[*other] - places[i]).norm_squared();
    group.iter().copied().filter(|other| *other != i).min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_small_compact_and_complete() {
        let places: Vec<_> = (0..4800).map(|i| Vector2::new(f64::from(i % 80), f64::from(i / 80))).collect();
        let groups = groups(&places);
        let mut seen: Vec<usize> = groups.concat();
        seen.sort_unstable();
        assert!(seen.into_iter().eq(0..4800));
        for group in &groups {
            assert!((MOST / 2..=MOST).contains(&group.len()));
            for i in group {
                assert!(group.iter().all(|j| (places[*i] - places[*j]).norm() < 12.0));
                let near = nearest(&places, group, *i).unwrap();
                assert!((places[*i] - places[near]).norm() == 1.0);
            }
        }
        assert!(nearest(&places, &[3], 3).is_none());
    }
}
