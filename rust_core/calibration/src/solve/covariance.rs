//! How certain lens and poses are, given that neighbouring samples share errors.
//!
//! A sandwich (Huber 1967; White 1980): H⁻¹ M H⁻¹, where H is the curvature of the loss and M the covariance of its
//! slope. Depth cameras err smoothly, so M has terms between samples, as for errors that are correlated in space
//! (Conley, "GMM estimation with cross sectional dependence", 1999). Samples are put into square cells of the camera's
//! picture. Products of the residuals of pairs of cells show how the correlation falls with distance; a covariance
//! function is fitted to them, as in kriging (Cressie, "Statistics for spatial data", 1993, 2.4), separately along the
//! epipolar lines, where depth errors show, and across. Where points are so few that cells have no pairs, errors count
//! as independent.

use nalgebra::{DMatrix, Point2, SMatrix, SVector, Vector2};
use rayon::prelude::*;

use super::adjust::{inverse_of_positive, Adjusted};
use super::depth_errors::equations;
use super::input::Observations;
use super::model::{Free, State, LOCAL};
use super::noise::{cauchy_weight, CAUCHY};
use super::normal_equations::NormalEquations;

/// Cells along the longer side of what the camera sees.
const CELLS: usize = 16;
/// Distances up to which pairs of cells are looked at, cells.
const FARTHEST: usize = 10;
/// Scans that the correlation is measured on, at most.
const MEASURED_SCANS: usize = 4;
/// Samples below which errors count as independent.
const LEAST_FOR_CORRELATION: usize = 200;

/// A matrix over the parameters that a sample depends on.
type Block = SMatrix<f64, LOCAL, LOCAL>;

/// What the samples of a cell add up to; the first of each pair along the epipolar lines, the second across.
#[derive(Debug, Clone, Copy)]
struct Cell {
    slopes: [SVector<f64, LOCAL>; 2],
    residuals: [f64; 2],
    squares: [f64; 2],
    count: f64,
}

impl Cell {
    const EMPTY: fn() -> Self =
        || Self { slopes: [SVector::zeros(); 2], residuals: [0.0; 2], squares: [0.0; 2], count: 0.0 };
}

/// The sums of one scan.
struct Sums {
    columns: usize,
    cells: Vec<Cell>,
    /// Sums of the products of slopes.
    products: [Block; 2],
    /// The mean curvature of the loss, times the number of samples, and the mean weight.
    curvature: f64,
    weight: f64,
}

/// How errors are correlated in one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Correlation {
    /// The variance that neighbours share.
    shared: f64,
    /// The variance that each sample has for itself.
    own: f64,
    /// How the shared part falls with distance.
    shape: Shape,
}

/// How correlation falls with distance.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Shape {
    /// Like a normal distribution of this standard deviation, cells.
    Normal(f64),
    /// Exponentially, to 1/e over this distance, cells.
    Exponential(f64),
}

/// Those that are tried.
const SHAPES: [Shape; 16] = [
    Shape::Normal(0.4),
    Shape::Normal(0.6),
    Shape::Normal(0.8),
    Shape::Normal(1.0),
    Shape::Normal(1.25),
    Shape::Normal(1.6),
    Shape::Normal(2.0),
    Shape::Normal(2.5),
    Shape::Normal(3.2),
    Shape::Normal(4.0),
    Shape::Exponential(0.6),
    Shape::Exponential(1.0),
    Shape::Exponential(1.6),
    Shape::Exponential(2.5),
    Shape::Exponential(4.0),
    Shape::Exponential(6.0),
];

impl Shape {
    fn at(&self, distance: f64) -> f64 {
        match self {
            Self::Normal(range) => (-0.5 * (distance / range).powi(2)).exp(),
            Self::Exponential(range) => (-distance / range).exp(),
        }
    }

    fn table(&self) -> Table {
        let side = CELLS + 1;
        Table((0..side * side).map(|i| self.at(((i % side) as f64).hypot((i / side) as f64))).collect())
    }
}

/// Correlations of cells by how many columns and rows they are apart.
struct Table(Vec<f64>);

impl Table {
    fn at(&self, apart: Vector2<f64>) -> f64 {
        self.0[apart.y.abs() as usize * (CELLS + 1) + apart.x.abs() as usize]
    }
}

/// The covariance of the unknowns; none if the samples do not determine them.
pub(super) fn covariance(observations: &Observations, adjusted: &Adjusted, free: &Free) -> Option<DMatrix<f64>> {
    let sums: Vec<Sums> = (0..observations.scans.len()).map(|scan| sums_of(observations, adjusted, scan)).collect();
    let equations = NormalEquations::new(observations, &adjusted.weights, &adjusted.state, free);
    let (curvature, weight) = sums.iter().fold((0.0, 0.0), |(c, w), sums| (c + sums.curvature, w + sums.weight));
    let inverse = inverse_of_positive(&(equations.hessian * (curvature / weight)))?;
    let used: f64 = sums.iter().flat_map(|sums| &sums.cells).map(|cell| cell.count).sum();
    let mut slope_covariance = DMatrix::zeros(free.len(), free.len());
    for direction in 0..2 {
        let correlation = correlation(&sums, direction, used, free, &inverse);
        slope_covariance += over_scans(&sums, free, |sums| {
            shared_slopes(sums, direction, &correlation.shape) * correlation.shared
                + sums.products[direction] * correlation.own
        });
    }
    let covariance = &inverse * slope_covariance * &inverse;
    covariance.iter().all(|value| value.is_finite()).then_some(covariance)
}

/// Adds up what scans contribute to a matrix of all unknowns.
fn over_scans(sums: &[Sums], free: &Free, block: impl Fn(&Sums) -> Block) -> DMatrix<f64> {
    let mut total = DMatrix::zeros(free.len(), free.len());
    for (scan, sums) in sums.iter().enumerate() {
        let block = block(sums);
        let columns = free.columns(scan);
        for (parameter, unknown) in &columns {
            for (other_parameter, other) in &columns {
                total[(*unknown, *other)] += block[(*parameter, *other_parameter)];
            }
        }
    }
    total
}

/// The part of a matrix of all unknowns that a scan's samples depend on.
fn of_scan(matrix: &DMatrix<f64>, free: &Free, scan: usize) -> Block {
    let columns = free.columns(scan);
    let mut block = Block::zeros();
    for (parameter, unknown) in &columns {
        for (other_parameter, other) in &columns {
            block[(*parameter, *other_parameter)] = matrix[(*unknown, *other)];
        }
    }
    block
}

fn sums_of(observations: &Observations, adjusted: &Adjusted, scan: usize) -> Sums {
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
    let cell_of = |ray: Vector2<f64>| {
        let place = (ray - least) / size;
        (place.y as usize).min(rows - 1) * columns + (place.x as usize).min(columns - 1)
    };
    let empty = || Sums {
        columns,
        cells: vec![Cell::EMPTY(); rows * columns],
        products: [Block::zeros(); 2],
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
                sums.add(cell_of(observation.ray.xy()), &equations.slopes, equations.residual * factor);
            }
            sums
        })
        .collect();
    let mut sums = empty();
    for part in &parts {
        sums.merge(part);
    }
    sums
}

impl Sums {
    fn add(&mut self, cell: usize, rows: &[SVector<f64, LOCAL>; 2], residual: Vector2<f64>) {
        let cell = &mut self.cells[cell];
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
        for (cell, other) in self.cells.iter_mut().zip(&part.cells) {
            cell.count += other.count;
            for direction in 0..2 {
                cell.slopes[direction] += other.slopes[direction];
                cell.residuals[direction] += other.residuals[direction];
                cell.squares[direction] += other.squares[direction];
            }
        }
        for direction in 0..2 {
            self.products[direction] += part.products[direction];
        }
        self.curvature += part.curvature;
        self.weight += part.weight;
    }

    /// The cells that have samples, with their places.
    fn filled(&self) -> Vec<(Vector2<f64>, &Cell)> {
        let place = |i: usize| Vector2::new((i % self.columns) as f64, (i / self.columns) as f64);
        self.cells.iter().enumerate().filter(|(_, cell)| cell.count > 0.0).map(|(i, cell)| (place(i), cell)).collect()
    }
}

/// Sums over pairs of samples by the distance of their cells, and how many pairs there are.
type Bins = [(f64, f64); FARTHEST + 1];

/// Adds up what pairs of cells give; within a cell, pairs are of different samples.
fn binned(sums: &[Sums], pair: impl Fn(usize, usize, usize) -> f64, within: impl Fn(usize, usize) -> f64) -> Bins {
    let mut bins = [(0.0, 0.0); FARTHEST + 1];
    for (scan, sums) in sums.iter().enumerate() {
        let filled = sums.filled();
        for (i, (place, cell)) in filled.iter().enumerate() {
            bins[0].0 += within(scan, i);
            bins[0].1 += cell.count * (cell.count - 1.0);
            for (j, (other_place, other)) in filled.iter().enumerate().skip(i + 1) {
                let bin = (place - other_place).norm().round() as usize;
                if bin <= FARTHEST {
                    bins[bin].0 += pair(scan, i, j);
                    bins[bin].1 += cell.count * other.count;
                }
            }
        }
    }
    bins
}

/// Measures how errors are correlated in a direction.
fn correlation(sums: &[Sums], direction: usize, used: f64, free: &Free, inverse: &DMatrix<f64>) -> Correlation {
    let squares: f64 = sums.iter().flat_map(|sums| &sums.cells).map(|cell| cell.squares[direction]).sum();
    // Residuals are smaller than errors by what the unknowns took up.
    let taken_up = 2.0 * used / (2.0 * used - free.len() as f64).max(0.2 * used);
    let variance = squares / used.max(1.0) * taken_up;
    let independent = Correlation { shared: 0.0, own: variance, shape: SHAPES[0] };
    if used < LEAST_FOR_CORRELATION as f64 {
        return independent;
    }
    let measured = &sums[..sums.len().min(MEASURED_SCANS)];
    let filled: Vec<_> = measured.iter().map(Sums::filled).collect();
    let residual = |scan: usize, i: usize| filled[scan][i].1.residuals[direction];
    let seen = binned(
        measured,
        |scan, i, j| residual(scan, i) * residual(scan, j),
        |scan, i| residual(scan, i).powi(2) - filled[scan][i].1.squares[direction],
    );
    let fits: Vec<(f64, Correlation)> = SHAPES
        .par_iter()
        .map(|shape| {
            let expected = expected(sums, measured, direction, shape, free, inverse);
            // Least squares of seen = shared * expected; near pairs count more.
            let (mut both, mut own, mut all) = (0.0, 0.0, 0.0);
            for (distance, ((seen, pairs), (expected, _))) in seen.iter().zip(&expected).enumerate() {
                if *pairs > 0.0 {
                    let (seen, expected, weight) = (seen / pairs, expected / pairs, 1.0 / (1.0 + distance as f64));
                    both += weight * seen * expected;
                    own += weight * expected * expected;
                    all += weight * seen * seen;
                }
            }
            let shared = if both > 0.0 { both / own } else { 0.0 };
            let within = if expected[0].1 > 0.0 { expected[0].0 / expected[0].1 } else { 1.0 };
            let own = (variance - shared * within).max(0.0);
            (all - shared * both, Correlation { shared, own, shape: *shape })
        })
        .collect();
    fits.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map_or(independent, |(_, correlation)| correlation)
}

/// What products of residuals add up to on the average if errors are correlated like this with a variance of one.
/// Residuals are errors less what the unknowns took up of them.
fn expected(
    sums: &[Sums],
    measured: &[Sums],
    direction: usize,
    shape: &Shape,
    free: &Free,
    inverse: &DMatrix<f64>,
) -> Bins {
    let covariance = inverse * over_scans(sums, free, |sums| shared_slopes(sums, direction, shape)) * inverse;
    let table = shape.table();
    // For each cell its slopes, how the unknowns follow them, and how unknowns and the cell's errors vary together.
    let mut cells: Vec<Vec<CellInFit>> = Vec::new();
    for (scan, sums) in measured.iter().enumerate() {
        let (inverse, covariance) = (of_scan(inverse, free, scan), of_scan(&covariance, free, scan));
        let filled = sums.filled();
        let in_fit = filled.iter().map(|(place, cell)| {
            let mut near = SVector::<f64, LOCAL>::zeros();
            for (other_place, other) in &filled {
                near += other.slopes[direction] * table.at(place - other_place);
            }
            let slopes = cell.slopes[direction];
            CellInFit {
                place: *place,
                count: cell.count,
                slopes,
                taken: covariance * slopes - inverse * near * cell.count,
                with: inverse * near * cell.count,
            }
        });
        cells.push(in_fit.collect());
    }
    let product = |a: &CellInFit, b: &CellInFit| {
        a.count * b.count * table.at(a.place - b.place) + a.taken.dot(&b.slopes) - a.slopes.dot(&b.with)
    };
    binned(
        measured,
        |scan, i, j| product(&cells[scan][i], &cells[scan][j]),
        |scan, i| {
            let cell = &cells[scan][i];
            product(cell, cell) * (1.0 - 1.0 / cell.count)
        },
    )
}

/// A cell and how the solution follows its errors.
struct CellInFit {
    place: Vector2<f64>,
    count: f64,
    slopes: SVector<f64, LOCAL>,
    taken: SVector<f64, LOCAL>,
    with: SVector<f64, LOCAL>,
}

/// The covariance of the sum of slope times error over the samples of a scan, for errors of this correlation and a
/// variance of one.
fn shared_slopes(sums: &Sums, direction: usize, shape: &Shape) -> Block {
    let (filled, table) = (sums.filled(), shape.table());
    let mut total = Block::zeros();
    for (place, cell) in &filled {
        let mut near = SVector::<f64, LOCAL>::zeros();
        for (other_place, other) in &filled {
            near += other.slopes[direction] * table.at(place - other_place);
        }
        total += cell.slopes[direction] * near.transpose();
    }
    total
}

/// Standard deviation of where light is predicted over the picture, between two distances from the projector, pixels.
pub(super) fn prediction_sigma_px(state: &State, free: &Free, covariance: &DMatrix<f64>, depth_m: [f64; 2]) -> f64 {
    let [width, height] = state.lens.size_px.map(f64::from);
    let (mut sum, mut count) = (0.0, 0.0);
    for (scan, pose) in state.poses.iter().enumerate().take(4) {
        let columns = free.columns(scan);
        for place in 0..9 * 7 {
            let pixel =
                Point2::new(width * f64::from(place % 9) / 8.0 - 0.5, height * f64::from(place / 9) / 6.0 - 0.5);
            let Some(ray) = state.lens.ray(pixel) else { continue };
            for depth in [depth_m[0], (depth_m[0] * depth_m[1]).sqrt(), depth_m[1]] {
                let point = pose.inverse_transform_point(&(ray * depth).into());
                let Some(prediction) = state.predict(scan, &point) else { continue };
                for (parameter, unknown) in &columns {
                    for (other_parameter, other) in &columns {
                        let (a, b) =
                            (prediction.jacobian.column(*parameter), prediction.jacobian.column(*other_parameter));
                        sum += a.dot(&b) * covariance[(*unknown, *other)];
                    }
                }
                count += 1.0;
            }
        }
    }
    if count == 0.0 {
        f64::INFINITY
    } else {
        (sum / count).max(0.0).sqrt()
    }
}
