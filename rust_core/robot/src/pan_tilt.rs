//! A pan-tilt unit that carries a lens: two rotating joints with any axes and offsets.
//!
//! ```text
//!   base ─ first joint(q0) ─ between ─ second joint(q1) ─ lens
//! ```
//!
//! The base is the first joint's frame at zero, which its `<origin>` places in its parent link.

use std::f64::consts::{PI, TAU};

use nalgebra::{Isometry3, Unit, UnitQuaternion, Vector3};

use crate::chain::ChainError;
use crate::urdf::{Joint, JointKind};

/// Range of a joint's position, radians; infinite for a continuous one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Travel {
    /// The least position.
    pub lower: f64,
    /// The greatest position.
    pub upper: f64,
}

impl Travel {
    /// Travel of a joint without limits.
    pub const ENDLESS: Self = Self { lower: f64::NEG_INFINITY, upper: f64::INFINITY };

    /// `true` if a position is within the limits.
    pub fn contains(&self, position: f64) -> bool {
        (self.lower..=self.upper).contains(&position)
    }

    /// The nearest position within the limits.
    pub fn clamp(&self, position: f64) -> f64 {
        position.max(self.lower).min(self.upper)
    }

    /// Positions around `present`, at most a whole turn of them.
    pub(crate) fn turn_around(&self, present: f64) -> Self {
        if self.upper - self.lower <= TAU {
            return *self;
        }
        let lower = (present - PI).max(self.lower).min(self.upper - TAU);
        Self { lower, upper: lower + TAU }
    }

    /// Of the positions whole turns apart from `position` and within the limits, the nearest to `present`.
    pub fn nearest_turn(&self, position: f64, present: f64) -> Option<f64> {
        // Within rounding of a limit is at the limit.
        const ROUNDING: f64 = 1e-9;
        let turns = ((present - position) / TAU).round();
        let inwards = |limit: f64| ((limit - position) / TAU).is_finite();
        let mut candidates = vec![turns];
        if inwards(self.lower) {
            candidates.push(((self.lower - ROUNDING - position) / TAU).ceil());
        }
        if inwards(self.upper) {
            candidates.push(((self.upper + ROUNDING - position) / TAU).floor());
        }
        let reached = candidates.into_iter().map(|turns| position + turns * TAU);
        let inside = reached.filter(|place| (place - self.clamp(*place)).abs() <= ROUNDING);
        inside.map(|place| self.clamp(place)).min_by(|a, b| (a - present).abs().total_cmp(&(b - present).abs()))
    }
}

/// A rotating joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hinge {
    /// Axis in the joint's frame.
    pub axis: Unit<Vector3<f64>>,
    /// Range of its position.
    pub travel: Travel,
}

impl Hinge {
    /// Hinge of a description's joint; `name` is for errors.
    ///
    /// # Errors
    /// [`ChainError::NotTurning`], [`ChainError::NoAxis`] or [`ChainError::NoTravel`].
    pub fn of(name: &str, joint: &Joint) -> Result<Self, ChainError> {
        let travel = match (joint.kind, joint.limits) {
            (JointKind::Continuous, _) => Travel::ENDLESS,
            (JointKind::Revolute, Some(limits)) => Travel { lower: limits.lower, upper: limits.upper },
            _ => return Err(ChainError::NotTurning(name.to_owned())),
        };
        let axis = Unit::try_new(joint.axis, 1e-9).ok_or_else(|| ChainError::NoAxis(name.to_owned()))?;
        if travel.lower > travel.upper {
            return Err(ChainError::NoTravel(name.to_owned()));
        }
        Ok(Self { axis, travel })
    }

    /// The rotation at a position.
    pub(crate) fn at(&self, position: f64) -> UnitQuaternion<f64> {
        UnitQuaternion::from_axis_angle(&self.axis, position)
    }
}

/// Two rotating joints and a lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PanTilt {
    /// The joints, the one nearer to the base first.
    pub hinges: [Hinge; 2],
    /// Pose of the second joint's frame, at zero, in the link that the first joint moves.
    pub first_from_second: Isometry3<f64>,
    /// Pose of the lens in the link that the second joint moves.
    pub second_from_lens: Isometry3<f64>,
}

impl PanTilt {
    /// Forward kinematics: the pose of the lens in the base at these positions.
    pub fn base_from_lens(&self, positions: [f64; 2]) -> Isometry3<f64> {
        let [first, second] = self.hinges;
        first.at(positions[0]) * self.first_from_second * second.at(positions[1]) * self.second_from_lens
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_equal_positions_the_nearest_within_the_limits_is_taken() {
        let travel = Travel { lower: -PI - 0.5, upper: PI + 0.5 };
        let near = |position, present: f64| travel.nearest_turn(position, present);
        assert!((near(PI + 0.2, 3.0).unwrap() - (PI + 0.2)).abs() < 1e-12);
        assert!((near(PI + 0.2, -3.0).unwrap() - (0.2 - PI)).abs() < 1e-12);
        assert!((near(9.0 * TAU + 0.1, 50.0).unwrap() - 0.1).abs() < 1e-9, "the present may be outside of the limits");
        assert_eq!(Travel { lower: -1.0, upper: 1.0 }.nearest_turn(2.0, 0.0), None);
        assert_eq!(Travel { lower: -1.0, upper: 1.0 }.nearest_turn(1.0 + 1e-12, 0.0), Some(1.0));
        let turned = Travel::ENDLESS.nearest_turn(0.1, 100.0 * TAU).unwrap();
        assert!((turned - 100.0 * TAU - 0.1).abs() < 1e-9);
    }
}
