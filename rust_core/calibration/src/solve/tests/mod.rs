//! Tests of the solver on scenes with known truth.

use rcs_scan_simulator::{has_many_seeds, seeds};

use super::{solve, DistortionTerms, FocalLengths, Parameter, Refusal, Solution, SolveOptions};
use synthetic::{pose, Simulation};

mod accuracy;
mod keystone;
mod motion;
mod refusals;
mod report;
mod synthetic;
mod uncertainty;

const SIZE_PX: [u32; 2] = [1280, 800];
const PINHOLE: [f64; 5] = [0.0; 5];
const K1: [f64; 5] = [-0.1, 0.0, 0.0, 0.0, 0.0];
const K1K2: [f64; 5] = [-0.15, 0.12, 0.0, 0.0, 0.0];
const PLUMB_BOB: [f64; 5] = [-0.1, 0.05, 0.002, -0.002, 0.0];

fn options() -> SolveOptions {
    SolveOptions::new(SIZE_PX)
}

/// RMS projection error over the working volume, pixels.
fn projection_error_px(simulation: &Simulation, solution: &Solution) -> f64 {
    simulation.projection_error_px(&solution.lens, &solution.poses[0].projector_from_camera)
}
