//! Sums over the samples of cells of the camera's image, for covariances.

use nalgebra::{DMatrix, SVector, Vector2};
use rayon::prelude::*;

use super::adjust::Adjusted;
use super::input::Observations;
use super::model::{Block, Free, LOCAL};
use super::noise::{cauchy_weight, CAUCHY};
use super::normal_equations::equations;

/// Cells along the longer side of the observed area.
pub(super) const CELLS: usize = 16;
/// Maximum number of fine cells along a side of a cell, and minimum mean number of samples in each.
const MOST_FINE: usize = 4;
const LEAST_IN_FINE: f64 = 10.0;

/// Sums of a cell; pairs are along and across the epipolar lines.
#[derive(Debug, Clone, Copy)]
pub(super) struct CellSums {
    pub(super) slopes: [SVector<f64, LOCAL>; 2],
    pub(super) residuals: [f64; 2],
    pub(super) squares: [f64; 2],
    pub(super) count: f64,
    /// Sums over the fine cells: slopes times counts, and squared counts.
    pub(super) fine_slopes: [SVector<f64, LOCAL>; 2],
    pub(super) fine_squares: f64,
}

impl CellSums {
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

pub(super) struct ScanSums {
    columns: usize,
    pub(super) cells: Vec<CellSums>,
    /// Fine cells along a side of a cell.
    per_side: usize,
    /// Fine cells, row by row.
    fine: Vec<CellSums>,
    pub(super) products: [Block; 2],
    pub(super) fine_products: [Block; 2],
    /// Summed curvature of the loss and summed weight.
    pub(super) curvature: f64,
    pub(super) weight: f64,
}

/// Sums of a scan after a step of the unknowns, to first order.
pub(super) fn sums_of(
    observations: &Observations,
    adjusted: &Adjusted,
    scan: usize,
    step: &SVector<f64, LOCAL>,
) -> ScanSums {
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
    let empty = || ScanSums {
        columns,
        cells: Vec::new(),
        per_side,
        fine: vec![CellSums::EMPTY(); per_side * rows * per_side * columns],
        products: [Block::zeros(); 2],
        fine_products: [Block::zeros(); 2],
        curvature: 0.0,
        weight: 0.0,
    };
    let chunks: Vec<_> = range.clone().step_by(16_384).map(|from| from..(from + 16_384).min(range.end)).collect();
    let parts: Vec<ScanSums> = chunks
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

/// Matrix of all unknowns from the blocks of scans.
pub(super) fn over_scans(sums: &[ScanSums], free: &Free, block: impl Fn(&ScanSums) -> Block) -> DMatrix<f64> {
    let mut total = DMatrix::zeros(free.len(), free.len());
    sums.iter().enumerate().for_each(|(scan, sums)| free.add_block(&mut total, scan, &block(sums)));
    total
}

impl ScanSums {
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

    /// Merges the fine cells into cells.
    fn gather(&mut self, rows: usize) {
        self.cells = vec![CellSums::EMPTY(); rows * self.columns];
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

    /// Cells with samples, with their positions.
    pub(super) fn filled(&self) -> Vec<(Vector2<f64>, &CellSums)> {
        let place = |i: usize| Vector2::new((i % self.columns) as f64, (i / self.columns) as f64);
        self.cells.iter().enumerate().filter(|(_, cell)| cell.count > 0.0).map(|(i, cell)| (place(i), cell)).collect()
    }
}
