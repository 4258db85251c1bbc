//! Polygons into triangles, by the rules of Assimp's `aiProcess_Triangulate`.
//!
//! A quad is cut from the corner whose inner angle is above 180 degrees, else from the first: if it is not flat, the
//! diagonal matters for the image. Larger polygons are projected along the largest component of their normal, and their
//! ears (convex corners whose triangle holds no other corner) are clipped one after another. The rest of a polygon that
//! crosses itself so that no ear is left is not drawn.

use std::f32::consts::PI;

use super::vectors::{dot, minus, normalized};

/// Most corner-in-triangle tests of a polygon; the rest of a polygon that needs more is not drawn.
const MAX_TESTS: usize = 20_000_000;
/// Most corner-in-triangle tests of a file, which take a few seconds.
const MAX_TESTS_OF_FILE: usize = 1_000_000_000;

/// Cuts the polygons of a file.
#[derive(Debug)]
pub(crate) struct Triangulation {
    tests_left: usize,
}

impl Triangulation {
    pub(crate) fn new() -> Self {
        Self { tests_left: MAX_TESTS_OF_FILE }
    }

    /// Calls `emit` with the corner numbers of each triangle of a polygon of four or more corners.
    pub(super) fn cut(&mut self, corners: &[[f32; 3]], mut emit: impl FnMut([u32; 3])) {
        match corners {
            [a, b, c, d] => {
                let first = reflex_corner([a, b, c, d]);
                let corner = |i: u32| (first + i) % 4;
                emit([corner(0), corner(1), corner(2)]);
                emit([corner(0), corner(2), corner(3)]);
            }
            _ if corners.len() > 4 => {
                let tests = cut_ears(&projected(corners), MAX_TESTS.min(self.tests_left), emit);
                self.tests_left = self.tests_left.saturating_sub(tests);
            }
            _ => {}
        }
    }
}

/// The corner of a quad with an inner angle above 180 degrees; 0 when there is none.
fn reflex_corner(quad: [&[f32; 3]; 4]) -> u32 {
    let [a, b, c, d] = quad;
    let around = [[d, a, b, c], [a, b, c, d], [b, c, d, a], [c, d, a, b]];
    let is_reflex = |[before, corner, after, opposite]: &[&[f32; 3]; 4]| {
        let towards = |other: &[f32; 3]| normalized(minus(other, corner));
        let diagonal = towards(opposite);
        dot(towards(before), diagonal).acos() + dot(towards(after), diagonal).acos() > PI
    };
    around.iter().position(is_reflex).map_or(0, |i| i as u32)
}

/// The polygon projected onto the plane in which it is largest, counter-clockwise.
fn projected(corners: &[[f32; 3]]) -> Vec<[f32; 2]> {
    // Newell's normal: each component is the polygon's area projected along that axis.
    let mut normal = [0.0_f32; 3];
    let next = corners.iter().cycle().skip(1);
    for (p, q) in corners.iter().zip(next) {
        normal[0] += (p[1] - q[1]) * (p[2] + q[2]);
        normal[1] += (p[2] - q[2]) * (p[0] + q[0]);
        normal[2] += (p[0] - q[0]) * (p[1] + q[1]);
    }
    let [x, y, z] = normal.map(f32::abs);
    let (towards, [mut u, mut v]) = if x > y && x > z {
        (normal[0], [1, 2])
    } else if x <= y && y > z {
        (normal[1], [2, 0])
    } else {
        (normal[2], [0, 1])
    };
    if towards < 0.0 {
        std::mem::swap(&mut u, &mut v);
    }
    corners.iter().map(|corner| [corner[u], corner[v]]).collect()
}

/// Clips one ear after another, going around the remaining corners. Returns the number of corner-in-triangle tests, at
/// most `max_tests`.
fn cut_ears(corners: &[[f32; 2]], max_tests: usize, mut emit: impl FnMut([u32; 3])) -> usize {
    let mut ring: Vec<usize> = (0..corners.len()).collect();
    let mut at = 0;
    let mut tests = 0;
    while ring.len() > 3 {
        let around = |i: usize| [i + ring.len() - 1, i, i + 1].map(|i| ring[i % ring.len()]);
        let mut candidates = (at..at + ring.len()).map(|i| i % ring.len());
        let ear = candidates.find(|&i| {
            let triangle = around(i).map(|corner| corners[corner]);
            // Not "is convex": a corner that is neither, because of NaN, may be clipped as well.
            if is_reflex(&triangle) {
                return false;
            }
            tests += corners.len();
            tests < max_tests && is_empty(&triangle, corners)
        });
        let Some(ear) = ear else { return tests };
        emit(around(ear).map(|corner| corner as u32));
        ring.remove(ear);
        at = ear % ring.len();
    }
    if let &[a, b, c] = ring.as_slice() {
        emit([a, b, c].map(|corner| corner as u32));
    }
    tests
}

/// `true` if the second corner is concave.
fn is_reflex([a, b, c]: &[[f32; 2]; 3]) -> bool {
    twice_area(a, b, c) < 0.0
}

/// `true` if no corner lies in a triangle. As in Assimp, clipped corners count as well.
fn is_empty(triangle: &[[f32; 2]; 3], corners: &[[f32; 2]]) -> bool {
    let [a, b, c] = triangle;
    !corners.iter().any(|p| !triangle.contains(p) && is_inside(p, a, b, c))
}

/// Twice the signed area of a triangle, positive for counter-clockwise corners.
fn twice_area(a: &[f32; 2], b: &[f32; 2], c: &[f32; 2]) -> f32 {
    a[0] * (b[1] - c[1]) + b[0] * (c[1] - a[1]) + c[0] * (a[1] - b[1])
}

/// `true` if `p` lies inside of a triangle, its edges excluded.
fn is_inside(p: &[f32; 2], a: &[f32; 2], b: &[f32; 2], c: &[f32; 2]) -> bool {
    let sides = [twice_area(a, b, p), twice_area(b, c, p), twice_area(c, a, p)];
    sides.iter().all(|&side| side > 0.0) || sides.iter().all(|&side| side < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangles(corners: &[[f32; 3]]) -> Vec<[u32; 3]> {
        let mut out = Vec::new();
        Triangulation::new().cut(corners, |triangle| out.push(triangle));
        out
    }

    #[test]
    fn the_polygons_of_a_file_take_no_more_than_seconds() {
        let polygon: Vec<_> =
            (0..4000).map(|i| (i as f32 / 4000.0 * 2.0 * PI).sin_cos()).map(|(x, y)| [x, y, 0.0]).collect();
        let mut triangulation = Triangulation::new();
        let cut = |triangulation: &mut Triangulation| {
            let mut count = 0;
            triangulation.cut(&polygon, |_| count += 1);
            count
        };
        assert_eq!(cut(&mut triangulation), 3998);
        // Each takes millions of tests; not all of these are cut.
        let whole = (0..200).filter(|_| cut(&mut triangulation) == 3998).count();
        assert!((10..200).contains(&whole), "{whole}");
        assert_eq!(triangulation.tests_left, 0);
    }

    fn area(corners: &[[f32; 3]], triangles: &[[u32; 3]]) -> f32 {
        let at = |i: u32| [corners[i as usize][0], corners[i as usize][1]];
        triangles.iter().map(|t| twice_area(&at(t[0]), &at(t[1]), &at(t[2])) / 2.0).sum()
    }

    #[test]
    fn a_quad_is_cut_from_its_first_corner() {
        let quad = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        assert_eq!(triangles(&quad), [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn a_quad_with_a_dent_is_cut_from_the_dent() {
        let dart = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.0, 2.0, 0.0]];
        assert_eq!(triangles(&dart), [[2, 3, 0], [2, 0, 1]]);
    }

    #[test]
    fn a_concave_polygon_is_covered_once_and_nothing_else_is() {
        // A letter L, seen from either side.
        let letter = [[0., 0., 0.], [2., 0., 0.], [2., 1., 0.], [1., 1., 0.], [1., 3., 0.], [0., 3., 0.]];
        let cut = triangles(&letter);
        assert_eq!(cut.len(), 4);
        assert!((area(&letter, &cut) - 4.0).abs() < 1e-5);
        let reversed: Vec<_> = letter.iter().rev().copied().collect();
        let cut = triangles(&reversed);
        assert_eq!(cut.len(), 4);
        assert!((area(&reversed, &cut) + 4.0).abs() < 1e-5);
    }

    #[test]
    fn polygons_that_make_no_sense_end() {
        triangles(&[[0.0; 3]; 9]);
        triangles(&[[f32::NAN; 3]; 9]);
        let star: Vec<_> = (0..7).map(|i| (i as f32 * 2.7).sin_cos()).map(|(x, y)| [x, y, 0.0]).collect();
        assert!(triangles(&star).len() <= 5);
    }
}
