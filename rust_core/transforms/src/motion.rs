//! Constant-velocity motion model of a frame, rotation included.
//!
//! The velocity is the child's twist in its own axes, averaged over [`WINDOW_SECS`], so that a base that drives and
//! turns is followed along its arc and a joint about its axis. Linear and angular velocity are judged separately. A
//! velocity is used only where the newest step, between the two newest samples, agrees with those before it:
//!
//! - after a stop the newest step is shorter, so nothing is predicted from the first sample that stands still;
//! - after a jump steps that disagree are not averaged, so nothing is predicted until two steps after the jump agree;
//! - steps of noise around a place cancel out.

use std::collections::VecDeque;
use std::time::Duration;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::sample::PoseSample;

/// Averaging window of a velocity; at least two steps, whatever they take.
const WINDOW_SECS: f64 = 0.08;
/// Samples that follow each other faster are merged.
const SHORTEST_STEP_SECS: f64 = 0.005;
/// Shortest newest step; the velocity of a shorter one is only noise of the stamps.
const SHORTEST_NEWEST_STEP_SECS: f64 = 0.001;
/// Steps that take longer say nothing about the velocity now.
const LONGEST_STEP_SECS: f64 = 0.5;
/// Steps that turn further are ambiguous in their direction.
const LARGEST_TURN_RAD: f64 = 1.0;
/// Largest deviation of a step from the mean of the later ones, as a share of that mean.
const AGREEMENT: f64 = 0.8;
/// Like [`AGREEMENT`], for the newest step.
const NEWEST_AGREEMENT: f64 = 0.5;
/// Like [`AGREEMENT`], if there is a single step to compare with.
const PAIR_AGREEMENT: f64 = 0.1;
/// Least distance covered by a motion, in standard deviations of its steps.
const DISTANCE_TO_SCATTER: f64 = 4.0;

/// Velocity of a frame.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Motion {
    /// In the child's axes, metres a second.
    linear: Vector3<f64>,
    /// In the child's axes, radians a second.
    angular: Vector3<f64>,
    /// Time between the two newest samples.
    pub(crate) period: Duration,
}

/// Velocity from one sample to a later one.
#[derive(Clone, Copy)]
struct MotionStep {
    secs: f64,
    linear: Vector3<f64>,
    angular: Vector3<f64>,
}

impl Motion {
    /// Motion of the newest samples (oldest first), if they have one.
    pub(crate) fn of(samples: &VecDeque<PoseSample>) -> Option<Self> {
        let mut backwards = samples.iter().rev();
        let newest = backwards.next()?;
        let before = backwards.next()?;
        // Most frames stand still.
        if newest.parent_from_child == before.parent_from_child {
            return None;
        }
        let last = MotionStep::between(before, newest).filter(|last| last.secs >= SHORTEST_NEWEST_STEP_SECS)?;
        let steps = steps(samples);
        let linear = steady(last.linear, steps.iter().map(|step| (step.linear, step.secs)));
        let angular = steady(last.angular, steps.iter().map(|step| (step.angular, step.secs)));
        let zero = Vector3::zeros;
        (linear.is_some() || angular.is_some()).then(|| Self {
            linear: linear.unwrap_or_else(zero),
            angular: angular.unwrap_or_else(zero),
            period: Duration::from_secs_f64(last.secs),
        })
    }

    /// Extrapolates a pose (`parent_from_child`) by `secs` seconds.
    pub(crate) fn extrapolate(&self, from: &Isometry3<f64>, secs: f64) -> Isometry3<f64> {
        let turn = self.angular * secs;
        let chord = UnitQuaternion::from_scaled_axis(turn * 0.5) * (self.linear * secs);
        from * Isometry3::from_parts(Translation3::from(chord), UnitQuaternion::from_scaled_axis(turn))
    }
}

impl MotionStep {
    /// `None` between different parents, and where it is unclear what happened in between.
    fn between(older: &PoseSample, newer: &PoseSample) -> Option<Self> {
        let secs = newer.stamp.secs_since(older.stamp);
        if newer.parent != older.parent || secs > LONGEST_STEP_SECS || secs <= 0.0 {
            return None;
        }
        let older_from_newer = older.parent_from_child.inv_mul(&newer.parent_from_child);
        let turn = older_from_newer.rotation.scaled_axis();
        // The chord of an arc points half a turn away from where the arc began.
        let chord = UnitQuaternion::from_scaled_axis(turn * -0.5) * older_from_newer.translation.vector;
        let is_clear = turn.norm() <= LARGEST_TURN_RAD && chord.iter().all(|part| part.is_finite());
        is_clear.then(|| Self { secs, linear: chord / secs, angular: turn / secs })
    }
}

/// Steps within the window, newest first.
fn steps(samples: &VecDeque<PoseSample>) -> Vec<MotionStep> {
    let mut steps: Vec<MotionStep> = Vec::new();
    let mut covered_secs = 0.0;
    let mut backwards = samples.iter().rev();
    let Some(mut newer) = backwards.next() else { return steps };
    for older in backwards {
        if newer.stamp.secs_since(older.stamp) < SHORTEST_STEP_SECS && newer.parent == older.parent {
            continue;
        }
        let Some(step) = MotionStep::between(older, newer) else { break };
        covered_secs += step.secs;
        // Half a step is left for stamps that are not evenly spaced.
        if steps.len() >= 2 && covered_secs > WINDOW_SECS + step.secs * 0.5 {
            break;
        }
        steps.push(step);
        newer = older;
    }
    steps
}

/// Mean velocity of the steps (newest first, each with its seconds) of one motion, if `last`, between the two newest
/// samples, agrees with it.
fn steady(last: Vector3<f64>, mut steps: impl Iterator<Item = (Vector3<f64>, f64)>) -> Option<Vector3<f64>> {
    let newest = steps.next()?;
    let mut run = Run::default();
    for (velocity, secs) in steps {
        if run.count > 0.0 && (velocity - run.mean()).norm() > AGREEMENT * run.mean().norm() {
            break;
        }
        run.add(velocity, secs);
    }
    if run.count == 0.0 {
        return None;
    }
    let (mean, scatter) = (run.mean(), run.scatter());
    let speed = mean.norm();
    let tolerance = if run.count > 1.0 {
        (2.5 * scatter).clamp(NEWEST_AGREEMENT * speed, AGREEMENT * speed)
    } else {
        PAIR_AGREEMENT * speed
    };
    if speed == 0.0 || [newest.0, last].iter().any(|velocity| (velocity - mean).norm() > tolerance) {
        return None;
    }
    run.add(newest.0, newest.1);
    let distance = run.mean().norm() * run.count;
    (distance >= DISTANCE_TO_SCATTER * run.scatter()).then(|| run.mean())
}

/// Sums over the steps of one motion.
#[derive(Default)]
struct Run {
    count: f64,
    secs: f64,
    distance: Vector3<f64>,
    sum: Vector3<f64>,
    sum_of_squares: f64,
}

impl Run {
    fn add(&mut self, velocity: Vector3<f64>, secs: f64) {
        self.count += 1.0;
        self.secs += secs;
        self.distance += velocity * secs;
        self.sum += velocity;
        self.sum_of_squares += velocity.norm_squared();
    }

    /// Mean velocity: distance by time.
    fn mean(&self) -> Vector3<f64> {
        self.distance / self.secs
    }

    /// Standard deviation of the steps' velocities.
    fn scatter(&self) -> f64 {
        let mean = self.sum / self.count;
        (self.sum_of_squares / self.count - mean.norm_squared()).max(0.0).sqrt()
    }
}
