//! The solver on scenes whose truth is known.

use rcs_scan_simulator::{has_many_seeds, seeds};

use super::{solve, DistortionTerms, FocalLengths, Parameter, Refusal, Solution, SolveOptions};
use synthetic::{pose, Simulation};

mod accuracy;
mod keystone;
mod motion;
mod refusals;
pub(crate) mod synthetic;
mod uncertainty;

const SIZE_PX: [u32; 2] = [1280, 800];
const PINHOLE: [f64; 5] = [0.0; 5];
const K1: [f64; 5] = [-0.1, 0.0, 0.0, 0.0, 0.0];
const K1K2: [f64; 5] = [-0.15, 0.12, 0.0, 0.0, 0.0];
const PLUMB_BOB: [f64; 5] = [-0.1, 0.05, 0.002, -0.002, 0.0];

fn options() -> SolveOptions {
    SolveOptions::new(SIZE_PX)
}

/// How far light lands from where it should over the whole working volume, pixels.
fn landing_px(simulation: &Simulation, solution: &Solution) -> f64 {
    simulation.landing_error(&solution.lens, &solution.poses[0].projector_from_camera).0
}
