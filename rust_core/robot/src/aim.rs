//! Inverse kinematics of a pan-tilt unit: the joint positions at which a beam from the lens hits a target.
//!
//! The lens may be anywhere on the unit and the axes may be tilted and apart, for which there is no closed form. The
//! angle between beam and target is a smooth function of the two positions. Its zeros, of which there are at most
//! eight, are found by Levenberg-Marquardt from a grid of start positions. Of those within the limits the nearest to
//! the present posture counts; without any, the posture of the least angle.

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix2, Matrix3x2, Point3, Unit, Vector2, Vector3};

use crate::pan_tilt::{PanTilt, Travel};

/// A ray of light in the lens's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// Origin, metres.
    pub origin: Point3<f64>,
    /// Direction.
    pub direction: Unit<Vector3<f64>>,
}

/// A posture of the two joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aim {
    /// Joint positions, radians, within the limits.
    pub positions: [f64; 2],
    /// Angle between the beam and the target, radians.
    pub miss_rad: f64,
}

/// Largest angle that counts as a hit: a hundredth of a millimetre at ten metres.
const HIT_RAD: f64 = 1e-6;
/// Start positions along each joint.
const GRID: usize = 14;
/// Steps from one start position.
const MOST_STEPS: usize = 100;
/// Postures nearer to each other than this are the same, radians.
const SAME: f64 = 1e-4;
/// A target nearer to the lens has no direction, metres.
const AT_LENS_M: f64 = 1e-6;
/// Error of the cheap descent above the least angle, radians.
const ROUGH_RAD: f64 = 0.05;

impl Aim {
    /// `true` if the beam hits the target.
    pub fn meets(&self) -> bool {
        self.miss_rad < HIT_RAD
    }
}

/// Direction error at a posture: unit vector towards the target minus the beam's, and its derivatives.
struct DirectionError {
    vector: Vector3<f64>,
    by_position: Matrix3x2<f64>,
}

impl DirectionError {
    /// The angle, of which the vector is the chord.
    fn angle(&self) -> f64 {
        2.0 * (self.vector.norm() / 2.0).min(1.0).asin()
    }

    /// Gradient of half the squared length.
    fn slope(&self) -> Vector2<f64> {
        self.by_position.transpose() * self.vector
    }
}

impl PanTilt {
    /// The posture nearest to `present` at which `beam` hits `target`, a point of the base, or else the one of the
    /// least angle. `None` for a target that is always at the lens, or is not finite.
    pub fn aim(&self, beam: &Beam, target: Point3<f64>, present: [f64; 2]) -> Option<Aim> {
        let problem = Problem { unit: self, beam, target };
        let present = present.map(|position| if position.is_finite() { position } else { 0.0 });
        let is_finite = target.coords.iter().all(|number| number.is_finite());
        if !is_finite {
            return None;
        }
        problem.nearest_hit(present).or_else(|| problem.least_miss(present))
    }

    /// Angle between `beam` and `target`, a point of the base, at these positions, radians; `None` for a target at the
    /// lens.
    pub fn miss_rad(&self, beam: &Beam, target: Point3<f64>, positions: [f64; 2]) -> Option<f64> {
        Problem { unit: self, beam, target }.miss(positions).map(|miss| miss.angle())
    }
}

/// Second derivatives that a step uses.
#[derive(Clone, Copy)]
enum Hessian {
    /// Gauss and Newton's approximation, cheap and exact at a hit.
    GaussNewton,
    /// All terms, for a minimum that is no hit.
    Full,
}

struct Problem<'a> {
    unit: &'a PanTilt,
    beam: &'a Beam,
    target: Point3<f64>,
}

impl Problem<'_> {
    fn miss(&self, positions: [f64; 2]) -> Option<DirectionError> {
        let [first, second] = self.unit.hinges;
        // The target in the frames from the base to the lens; a joint that turns moves it the other way.
        let in_first = first.at(positions[0]).inverse() * self.target;
        let by_first = -first.axis.cross(&in_first.coords);
        let at_second = self.unit.first_from_second.inverse() * in_first;
        let turned_back = second.at(positions[1]).inverse();
        let in_second = turned_back * at_second;
        let by_second = -second.axis.cross(&in_second.coords);
        let lens_from_second = self.unit.second_from_lens.inverse();
        let towards = lens_from_second * in_second - self.beam.origin;
        let by_first = turned_back * (self.unit.first_from_second.rotation.inverse() * by_first);
        let columns = [by_first, by_second].map(|column| lens_from_second.rotation * column);

        let distance = towards.norm();
        if distance.is_nan() || distance < AT_LENS_M {
            return None;
        }
        let direction = towards / distance;
        let across = columns.map(|column| (column - direction * direction.dot(&column)) / distance);
        Some(DirectionError {
            vector: direction - self.beam.direction.into_inner(),
            by_position: Matrix3x2::from_columns(&across),
        })
    }

    /// Second derivatives of half the squared error, by differences.
    fn curvature(&self, positions: [f64; 2]) -> Option<Matrix2<f64>> {
        const STEP: f64 = 1e-5;
        let column = |joint: usize| {
            let moved = |by: f64| {
                let mut moved = positions;
                moved[joint] += by;
                self.miss(moved).map(|miss| miss.slope())
            };
            Some((moved(STEP)? - moved(-STEP)?) / (2.0 * STEP))
        };
        let both = Matrix2::from_columns(&[column(0)?, column(1)?]);
        Some((both + both.transpose()) / 2.0)
    }

    /// Descends from a posture to a minimum within the limits.
    fn descend(&self, from: [f64; 2], limits: [Travel; 2], hessian: Hessian) -> Option<Aim> {
        // The end of a span is rounded, perhaps beyond a limit, and a controller may refuse what is beyond.
        let mut positions = [0, 1].map(|joint| limits[joint].clamp(from[joint]));
        let mut miss = self.miss(positions)?;
        let mut damping = 1e-3;
        for _ in 0..MOST_STEPS {
            let curvature = match hessian {
                Hessian::GaussNewton => miss.by_position.transpose() * miss.by_position,
                Hessian::Full => self.curvature(positions)?,
            };
            let Some(step) = step(curvature, miss.slope(), positions, limits, damping) else { break };
            let tried = [0, 1].map(|joint| limits[joint].clamp(positions[joint] + step[joint]));
            match self.miss(tried).filter(|tried| tried.vector.norm_squared() < miss.vector.norm_squared()) {
                Some(better) => {
                    let change = (tried[0] - positions[0]).abs().max((tried[1] - positions[1]).abs());
                    (positions, miss, damping) = (tried, better, damping * 0.1);
                    if change < 1e-14 {
                        break;
                    }
                }
                None if damping > 1e8 => break,
                None => damping = damping.max(1e-9) * 10.0,
            }
        }
        Some(Aim { positions, miss_rad: miss.angle() })
    }

    /// The nearest posture within the limits at which the beam hits the target.
    fn nearest_hit(&self, present: [f64; 2]) -> Option<Aim> {
        let travel = self.unit.hinges.map(|hinge| hinge.travel);
        let mut found: Vec<Aim> = Vec::new();
        let starts = std::iter::once(present).chain(grid([Travel { lower: -PI, upper: PI }; 2]));
        for aim in
            starts.filter_map(|from| self.descend(from, [Travel::ENDLESS; 2], Hessian::GaussNewton)).filter(Aim::meets)
        {
            let is_known = |known: &Aim| {
                let apart = |joint: usize| turn_between(known.positions[joint], aim.positions[joint]) < SAME;
                apart(0) && apart(1)
            };
            if !found.iter().any(is_known) {
                found.push(aim);
            }
        }
        let within = found.into_iter().filter_map(|aim| {
            let first = travel[0].nearest_turn(aim.positions[0], present[0])?;
            let second = travel[1].nearest_turn(aim.positions[1], present[1])?;
            Some(Aim { positions: [first, second], ..aim })
        });
        within.min_by(|a, b| distance(a.positions, present).total_cmp(&distance(b.positions, present)))
    }

    /// The posture of the least angle within the limits.
    fn least_miss(&self, present: [f64; 2]) -> Option<Aim> {
        let travel = self.unit.hinges.map(|hinge| hinge.travel);
        let spans = [0, 1].map(|joint| travel[joint].turn_around(present[joint]));
        let here = [0, 1].map(|joint| travel[joint].clamp(present[joint]));
        let starts = std::iter::once(here).chain(grid(spans));
        let rough: Vec<Aim> = starts.filter_map(|from| self.descend(from, travel, Hessian::GaussNewton)).collect();
        let least = rough.iter().map(|aim| aim.miss_rad).fold(f64::INFINITY, f64::min);
        let promising = rough.into_iter().filter(|aim| aim.miss_rad < least + ROUGH_RAD);
        let refined = promising.filter_map(|aim| self.descend(aim.positions, travel, Hessian::Full));
        // The nearest of equal ones.
        let order = |a: &Aim, b: &Aim| {
            if (a.miss_rad - b.miss_rad).abs() > HIT_RAD {
                a.miss_rad.total_cmp(&b.miss_rad)
            } else {
                distance(a.positions, present).total_cmp(&distance(b.positions, present))
            }
        };
        refined.min_by(order)
    }
}

/// A Levenberg-Marquardt step. A joint at a limit that the step would leave stays there. `None` at a minimum.
fn step(
    mut curvature: Matrix2<f64>,
    mut slope: Vector2<f64>,
    positions: [f64; 2],
    limits: [Travel; 2],
    damping: f64,
) -> Option<Vector2<f64>> {
    // An axis that the target lies on has no effect: the damping keeps that joint where it is.
    let scale = curvature.diagonal().abs().max().max(1e-12);
    for joint in 0..2 {
        let Travel { lower, upper } = limits[joint];
        let is_held =
            positions[joint] <= lower && slope[joint] > 0.0 || positions[joint] >= upper && slope[joint] < 0.0;
        if is_held {
            curvature.row_mut(joint).fill(0.0);
            curvature.column_mut(joint).fill(0.0);
            slope[joint] = 0.0;
        }
        curvature[(joint, joint)] += damping * scale;
    }
    if slope.norm() < 1e-16 {
        return None;
    }
    let step = curvature.lu().solve(&-slope)?;
    // No further than the model can be right.
    let longest = step.amax();
    Some(if longest > 0.5 { step * (0.5 / longest) } else { step })
}

/// A grid of postures over these spans, their ends included: the least angle is often at a limit.
fn grid(spans: [Travel; 2]) -> impl Iterator<Item = [f64; 2]> {
    let place = move |joint: usize, cell: usize| {
        let Travel { lower, upper } = spans[joint];
        lower + (upper - lower) * cell as f64 / (GRID - 1) as f64
    };
    (0..GRID * GRID).map(move |cell| [place(0, cell / GRID), place(1, cell % GRID)])
}

/// The shorter rotation between two positions, unsigned.
fn turn_between(a: f64, b: f64) -> f64 {
    let turn = (a - b).rem_euclid(TAU);
    turn.min(TAU - turn)
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

#[cfg(test)]
mod tests;
