//! Sums over the samples of cells of the camera's picture: what covariances are made of.

use nalgebra::{SMatrix, SVector, Vector2};
use rayon::prelude::*;

use super::adjust::Adjusted;
use super::depth_errors::equations;
use super::input::Observations;
use super::model::LOCAL;
use super::noise::{cauchy_weight, CAUCHY};

/// Cells along the longer side of what the camera sees.
pub(super) const CELLS: usize = 16;
/// Fine cells along a side of each of these, at most, and the samples of each, at least, on the average.
const MOST_FINE: usize = 4;
const LEAST_IN_FINE: f64 = 10.0;

/// A matrix over the parameters that a sample depends on.
pub(super) type Block = SMatrix<f64, LOCAL, LOCAL>;

/// What the samples of a cell add up to; the first of each pair along the epipolar lines, the second across.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    pub(super) slopes: [SVector<f64, LOCAL>; 2],
    pub(super) residuals: [f64; 2],
    pub(super) squares: [f64; 2],
    pub(super) count: f64,
    /// Sums over its fine cells: of slopes times their counts, and of their squared counts.
    pub(super) fine_slopes: [SVector<f64, LOCAL>; 2],
    pub(super) fine_squares: f64,
}

impl Cell {
    const EMPTY: fn() -> Self = || Self {
        slopes: [SVector::zeros(); 2],
        residuals: [0.0; 2],
        squares: [0.0; 2],
        count: 0.0,
        fine_slopes: [SVector::zeros(); 2],
        fine_squares: 0.0,
    };

    fn merge(&mut self, other: &Self) {
        self.count += other.count;
        for direction in 0..2 {
            self.slopes[direction] += other.slopes[direction];
            self.residuals[direction] += other.residuals[direction];
            self.squares[direction] += other.squares[direction];
        }
    }
}

/// The sums of one scan.
pub(super) struct Sums {
    pub(super) columns: usize,
    pub(super) cells: Vec<Cell>,
    /// How many fine cells are along a side of a cell.
    pub(super) per_side: usize,
    /// These, row by row over the whole picture.
    pub(super) fine: Vec<Cell>,
    /// Sums of the products of slopes.
    pub(super) products: [Block; 2],
    /// The same of the sums over fine cells.
    pub(super) fine_products: [Block; 2],
    /// The mean curvature of the loss, times the number of samples, and the mean weight.
    pub(super) curvature: f64,
    pub(super) weight: f64,
}

pub(super) fn sums_of(
    observations: &Observations,
    adjusted: &Adjusted,
    scan: usize,
    step: &SVector<f64, LOCAL>,
) -> Sums {
    let range = observations.range(scan);
    let used = || range.clone().filter(|i| adjusted.weights[*i].is_used());
    let (mut least, mut most) = (Vector2::repeat(f64::INFINITY), Vector2::repeat(f64::NEG_INFINITY));
    for i in used() {
        let ray = observations.all[i].ray.xy();
        (least, most) = (least.inf(&ray), most.sup(&ray));
    }
    let size = (most - least).max().max(1e-9) / CELLS as f64 * (1.0 + 1e-9);
    let columns = ((most.x - least.x) / size) as usize + 1;
    let rows = ((most.y - least.y) / size) as usize + 1;
    let in_cell = used().count() as f64 / (rows * columns) as f64;
    let per_side = ((in_cell / LEAST_IN_FINE).sqrt() as usize).clamp(1, MOST_FINE);
    let cell_of = |ray: Vector2<f64>| {
        let place = (ray - least) / size * per_side as f64;
        (place.y as usize).min(per_side * rows - 1) * per_side * columns
            + (place.x as usize).min(per_side * columns - 1)
    };
    let empty = || Sums {
        columns,
        cells: Vec::new(),
        per_side,
        fine: vec![Cell::EMPTY(); per_side * rows * per_side * columns],
        products: [Block::zeros(); 2],
        fine_products: [Block::zeros(); 2],
        curvature: 0.0,
        weight: 0.0,
    };
    let chunks: Vec<_> = range.clone().step_by(16_384).map(|from| from..(from + 16_384).min(range.end)).collect();
    let parts: Vec<Sums> = chunks
        .par_iter()
        .map(|chunk| {
            let mut sums = empty();
            for i in chunk.clone().filter(|i| adjusted.weights[*i].is_used()) {
                let (observation, weight) = (&observations.all[i], &adjusted.weights[i]);
                let Some(equations) = equations(&adjusted.state, observation, weight) else { continue };
                let squared = equations.residual.norm_squared();
                let factor = cauchy_weight(squared);
                sums.weight += factor;
                sums.curvature += factor - squared * factor * factor / (CAUCHY * CAUCHY);
                let explained = Vector2::from(equations.slopes.map(|slopes| slopes.dot(step)));
                let residual = (equations.residual - explained) * factor;
                sums.add(cell_of(observation.ray.xy()), &equations.slopes, residual);
            }
            sums
        })
        .collect();
    let mut sums = empty();
    for part in &parts {
        sums.merge(part);
    }
    sums.gather(rows);
    sums
}

impl Sums {
    fn add(&mut self, cell: usize, rows: &[SVector<f64, LOCAL>; 2], residual: Vector2<f64>) {
        let cell = &mut self.fine[cell];
        cell.count += 1.0;
        for direction in 0..2 {
            let row = &rows[direction];
            cell.slopes[direction] += row;
            cell.residuals[direction] += residual[direction];
            cell.squares[direction] += residual[direction] * residual[direction];
            for column in 0..LOCAL {
                let by = row[column];
                for below in 0..LOCAL {
                    self.products[direction][(below, column)] += row[below] * by;
                }
            }
        }
    }

    fn merge(&mut self, part: &Self) {
        for (cell, other) in self.fine.iter_mut().zip(&part.fine) {
            cell.merge(other);
        }
        for direction in 0..2 {
            self.products[direction] += part.products[direction];
        }
        self.curvature += part.curvature;
        self.weight += part.weight;
    }

    /// Puts the fine cells together.
    fn gather(&mut self, rows: usize) {
        self.cells = vec![Cell::EMPTY(); rows * self.columns];
        for (place, fine) in self.fine.iter().enumerate().filter(|(_, fine)| fine.count > 0.0) {
            let in_row = self.per_side * self.columns;
            let (column, row) = (place % in_row / self.per_side, place / in_row / self.per_side);
            let cell = &mut self.cells[row * self.columns + column];
            cell.merge(fine);
            cell.fine_squares += fine.count * fine.count;
            for direction in 0..2 {
                cell.fine_slopes[direction] += fine.slopes[direction] * fine.count;
                self.fine_products[direction] += fine.slopes[direction] * fine.slopes[direction].transpose();
            }
        }
    }

    /// The cells that have samples, with their places.
    pub(super) fn filled(&self) -> Vec<(Vector2<f64>, &Cell)> {
        let place = |i: usize| Vector2::new((i % self.columns) as f64, (i / self.columns) as f64);
        self.cells.iter().enumerate().filter(|(_, cell)| cell.count > 0.0).map(|(i, cell)| (place(i), cell)).collect()
    }
}
