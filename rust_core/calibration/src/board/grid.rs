//! The grid of a chessboard among candidates for corners.
//!
//! Two corners are neighbours if a straight edge joins them: bright on one side all along, dark on the other. From a
//! seed the grid grows along such edges, and sides of an edge that contradict the pattern of squares are not followed.
//! Around a corner bright and dark squares alternate, unlike where squares meet the sheet's edge.

use std::collections::{BTreeMap, VecDeque};

use nalgebra::{Matrix2, Point2, Vector2};

use super::response::Grey;

/// Nearest candidates that are tried as neighbours.
const NEAREST: usize = 16;
/// Minimum distance of neighbours, pixels.
const LEAST_PX: f64 = 5.0;
/// Places along an edge where its sides are compared, as shares of its length.
const ALONG: [f64; 5] = [0.2, 0.35, 0.5, 0.65, 0.8];
/// Distance from the edge to both sides as a share of its length, and at least, pixels.
const ASIDE: f64 = 0.15;
const LEAST_ASIDE_PX: f64 = 1.5;
/// Minimum contrast of an edge's weakest place as a share of its mean, and minimum mean, levels.
const EVENNESS: f64 = 0.3;
const LEAST_CONTRAST: f64 = 4.0;
/// Places in the four squares around a corner, in steps to its neighbours.
const IN_SQUARE: f64 = 0.3;
/// Tolerance of a step along the grid, in steps.
const TOLERANCE: f64 = 0.35;
/// Maximum number of corners beyond the board, such as those of reflections, as a share of its shorter side.
const BEYOND: f64 = 0.5;
/// Maximum number of seeds that are tried.
const SEEDS: usize = 400;

/// Labelled candidates.
#[derive(Debug, Default)]
pub(super) struct Grid {
    /// Index of the candidate at each column and row.
    pub(super) places: BTreeMap<[i32; 2], usize>,
    /// Number of corners of the largest grid that was too large for the board.
    pub(super) larger: usize,
}

/// An edge to another candidate.
#[derive(Debug, Clone, Copy)]
struct Edge {
    to: usize,
    /// 1 if it is brighter on the side of its direction turned by 90° from x to y, else -1.
    side: i32,
}

/// A labelled corner that grows.
struct Grown {
    index: usize,
    place: [i32; 2],
    /// Steps to the next column and row, pixels.
    steps: Matrix2<f64>,
}

impl Grid {
    /// The largest grid of at most this number of corners along its sides, apart from checkered surfaces with more.
    pub(super) fn largest(grey: &Grey, points: &[Point2<f64>], most: [u32; 2]) -> Self {
        let edges = edges(grey, points);
        let mut is_used = vec![false; points.len()];
        let mut largest = Self::default();
        let complete = most[0] as usize * most[1] as usize;
        for seed in (0..points.len()).filter(|seed| edges[*seed].len() >= 3).take(SEEDS) {
            if is_used[seed] {
                continue;
            }
            let grown = Self::grown(grey, points, &edges, seed);
            grown.places.values().for_each(|index| is_used[*index] = true);
            let (count, grid) = (grown.places.len(), grown.within(most));
            if count > grid.places.len() + (BEYOND * f64::from(most[0].min(most[1]))) as usize {
                largest.larger = largest.larger.max(count);
                continue;
            }
            if grid.places.len() > largest.places.len() {
                largest.places = grid.places;
            }
            if largest.places.len() == complete {
                break;
            }
        }
        largest
    }

    /// Grows a grid from a seed.
    fn grown(grey: &Grey, points: &[Point2<f64>], edges: &[Vec<Edge>], seed: usize) -> Self {
        let mut grid = Self::default();
        let directions: Vec<Vector2<f64>> = edges[seed].iter().map(|edge| points[edge.to] - points[seed]).collect();
        let first = directions[0];
        let cross = |direction: &&Vector2<f64>| first.perp(direction) / direction.norm();
        let Some(second) = directions.iter().max_by(|a, b| cross(a).abs().total_cmp(&cross(b).abs())) else {
            return grid;
        };
        let second = *second * cross(&second).signum();
        // Squares of even places are bright if this is 1.
        let even = edges[seed][0].side;
        let steps = Matrix2::from_columns(&[first, second]);
        if !alternates(grey, points[seed], &steps) {
            return grid;
        }
        let mut queue = VecDeque::from([Grown { index: seed, place: [0, 0], steps }]);
        let mut is_used = vec![false; points.len()];
        is_used[seed] = true;
        grid.places.insert([0, 0], seed);
        while let Some(mut grown) = queue.pop_front() {
            let neighbours = grown.neighbours(points, &edges[grown.index], even);
            for (axis, sign, to) in &neighbours {
                grown.steps.set_column(*axis, &((points[*to] - points[grown.index]) * f64::from(*sign)));
            }
            for (axis, sign, to) in neighbours {
                let mut place = grown.place;
                place[axis] += sign;
                let is_taken = is_used[to] || grid.places.contains_key(&place);
                if is_taken || !alternates(grey, points[to], &grown.steps) {
                    continue;
                }
                is_used[to] = true;
                grid.places.insert(place, to);
                queue.push_back(Grown { index: to, place, steps: grown.steps });
            }
        }
        grid
    }

    /// The part of at most this number of corners along both sides, with the most of them.
    fn within(self, most: [u32; 2]) -> Self {
        let bounds = [0, 1].map(|axis| {
            let places = || self.places.keys().map(|place| place[axis]);
            [places().min().unwrap_or(0), places().max().unwrap_or(0)]
        });
        let most = most.map(|count| count as i32);
        let mut best = Self::default();
        for size in [most, [most[1], most[0]]] {
            let firsts = [0, 1].map(|axis| bounds[axis][0]..=(bounds[axis][1] - size[axis] + 1).max(bounds[axis][0]));
            let [columns, rows] = firsts;
            for (column, row) in columns.flat_map(|column| rows.clone().map(move |row| (column, row))) {
                let is_inside = |place: &[i32; 2]| {
                    (column..column + size[0]).contains(&place[0]) && (row..row + size[1]).contains(&place[1])
                };
                let count = self.places.keys().filter(|place| is_inside(place)).count();
                if count > best.places.len() {
                    let inside = self.places.iter().filter(|(place, _)| is_inside(place));
                    best.places = inside.map(|(place, index)| (*place, *index)).collect();
                }
            }
        }
        best
    }

    /// Distance from a corner to its nearest neighbour on the grid, pixels.
    pub(super) fn spacing_px(&self, points: &[Point2<f64>], place: [i32; 2]) -> f64 {
        let Some(own) = self.places.get(&place) else { return 0.0 };
        let neighbours = [[1, 0], [-1, 0], [0, 1], [0, -1]].map(|[x, y]| [place[0] + x, place[1] + y]);
        let distances = neighbours.iter().filter_map(|neighbour| self.places.get(neighbour));
        distances.map(|other| (points[*other] - points[*own]).norm()).fold(f64::INFINITY, f64::min)
    }
}

impl Grown {
    /// Neighbours along the grid: axis, direction and candidate.
    fn neighbours(&self, points: &[Point2<f64>], edges: &[Edge], even: i32) -> Vec<(usize, i32, usize)> {
        let Some(inverse) = self.steps.try_inverse() else { return Vec::new() };
        let parity = if (self.place[0] + self.place[1]).rem_euclid(2) == 0 { even } else { -even };
        let neighbour = |edge: &Edge| {
            let steps = inverse * (points[edge.to] - points[self.index]);
            let axis = steps.iamax();
            let sign = if steps[axis] > 0.0 { 1 } else { -1 };
            let off = (steps[axis] - f64::from(sign)).abs().max(steps[1 - axis].abs());
            // Along columns the bright side is that of rising rows where the square is bright; along rows the other.
            // The edge to the left or up begins at a place of the other parity, and its direction turns its sides.
            let expected = if axis == 0 { parity } else { -parity };
            (off < TOLERANCE && edge.side == expected).then_some((axis, sign, edge.to))
        };
        edges.iter().filter_map(neighbour).collect()
    }
}

/// Edges of each candidate to its neighbours.
fn edges(grey: &Grey, points: &[Point2<f64>]) -> Vec<Vec<Edge>> {
    let nearest = |index: usize| {
        let mut others: Vec<(f64, usize)> = (0..points.len())
            .filter(|other| *other != index)
            .map(|other| ((points[other] - points[index]).norm(), other))
            .filter(|(distance, _)| *distance >= LEAST_PX)
            .collect();
        let count = NEAREST.min(others.len());
        if count < others.len() {
            others.select_nth_unstable_by(count, |a, b| a.0.total_cmp(&b.0));
            others.truncate(count);
        }
        others.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut edges: Vec<Edge> = Vec::new();
        for (_, other) in others {
            let direction = (points[other] - points[index]).normalize();
            // A nearer one in about the same direction hides it.
            let is_free = edges.iter().all(|edge| (points[edge.to] - points[index]).normalize().dot(&direction) < 0.8);
            if let Some(side) = bright_side(grey, points[index], points[other]).filter(|_| is_free) {
                edges.push(Edge { to: other, side });
            }
        }
        edges
    };
    use rayon::prelude::*;
    (0..points.len()).into_par_iter().map(nearest).collect()
}

/// `true` if bright and dark squares alternate around a corner.
fn alternates(grey: &Grey, corner: Point2<f64>, steps: &Matrix2<f64>) -> bool {
    let level = |x: f64, y: f64| grey.at(corner + steps * Vector2::new(x, y) * IN_SQUARE);
    let (Some(one), Some(opposite), Some(left), Some(right)) =
        (level(1.0, 1.0), level(-1.0, -1.0), level(-1.0, 1.0), level(1.0, -1.0))
    else {
        return false;
    };
    let difference = one + opposite - left - right;
    let gap = if difference > 0.0 { one.min(opposite) - left.max(right) } else { left.min(right) - one.max(opposite) };
    gap > EVENNESS * 0.5 * difference.abs()
}

/// The bright side of the edge between two corners: 1 for the side of its direction turned from x to y, else -1;
/// `None` if there is no edge.
fn bright_side(grey: &Grey, from: Point2<f64>, to: Point2<f64>) -> Option<i32> {
    let along = to - from;
    let length = along.norm();
    let aside = Vector2::new(-along.y, along.x) / length * (ASIDE * length).max(LEAST_ASIDE_PX);
    let mut differences = [0.0; ALONG.len()];
    for (difference, share) in differences.iter_mut().zip(ALONG) {
        let place = from + along * share;
        *difference = grey.at(place + aside)? - grey.at(place - aside)?;
    }
    let mean = differences.iter().sum::<f64>() / ALONG.len() as f64;
    let least = differences.iter().map(|difference| difference * mean.signum()).fold(f64::INFINITY, f64::min);
    (mean.abs() >= LEAST_CONTRAST && least > EVENNESS * mean.abs()).then_some(mean.signum() as i32)
}
