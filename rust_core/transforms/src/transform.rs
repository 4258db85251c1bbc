//! A transform as published, and its checks.
//!
//! The checks are tf2's: both frames named, not the same frame twice, no NaN, a rotation whose squared norm is within
//! [`NORM_TOLERANCE`] of one. Two differ, because the tree returns rigid transforms: infinite translations, which tf2
//! stores and then answers with NaN, are refused; and a rotation within the tolerance is normalised, where tf2 keeps
//! the small error and scales by it.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use thiserror::Error;

use crate::{Time, MOST_FRAMES};

/// Tolerance of the squared norm of a rotation; tf2's value.
const NORM_TOLERANCE: f64 = 10e-3;

/// A transform as a message has it, unchecked. Frame names may carry one leading `/`, which is ignored.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct RawTransform<'a> {
    /// The frame that the numbers are given in (`header.frame_id`).
    pub parent: &'a str,
    /// The frame that is placed (`child_frame_id`).
    pub child: &'a str,
    /// Time of the transform.
    pub stamp: Time,
    /// The child's origin in the parent, metres.
    pub translation: [f64; 3],
    /// The child's orientation in the parent, a quaternion in message order: x, y, z, w.
    pub rotation_xyzw: [f64; 4],
}

/// A refused transform, with its publisher and both frames.
#[derive(Clone, PartialEq, Debug, Error)]
#[error("{authority} published a transform of frame [{child}] in [{parent}] {problem}; it is ignored")]
pub struct InsertError {
    /// Name of the publishing node.
    pub authority: String,
    /// The parent frame as named.
    pub parent: String,
    /// The child frame as named.
    pub child: String,
    /// Reason.
    pub problem: InsertProblem,
}

/// Reason why a transform is refused.
#[derive(Clone, PartialEq, Debug, Error)]
pub enum InsertProblem {
    /// Parent and child are the same frame.
    #[error("which is the same frame")]
    SelfTransform,
    /// The parent, the child or both have no name.
    #[error("with an empty frame name")]
    EmptyFrame,
    /// The translation (metres) or rotation (x, y, z, w) holds a NaN.
    #[error("with NaN in it (x y z, then rotation x y z w: {0:?})")]
    NaN(Box<[f64; 7]>),
    /// The translation (metres) holds an infinity.
    #[error("with an infinite translation {0:?}")]
    Infinite([f64; 3]),
    /// The rotation (x, y, z, w) is not a unit quaternion.
    #[error("whose rotation xyzw {0:?} is not a unit quaternion")]
    NotNormalised([f64; 4]),
    /// The stamp is older than all that the frame's history keeps.
    #[error("at {stamp}, too far behind the newest one at {latest}")]
    TooOld {
        /// The stamp as published.
        stamp: Time,
        /// The newest stamp of the frame.
        latest: Time,
    },
    /// The frame has another pose at that stamp, which holds. tf2 calls it `TF_REPEATED_DATA`.
    #[error("at {stamp} that differs from an earlier one of that stamp (TF_REPEATED_DATA)")]
    Repeated {
        /// The stamp of both.
        stamp: Time,
    },
    /// The tree has no room for another name.
    #[error("beyond the limit of {MOST_FRAMES} frames, whose names are kept until the program ends")]
    TooManyFrames,
}

/// A frame name without the one leading `/` that tf (the first) used to write.
pub(crate) fn strip_slash(frame: &str) -> &str {
    frame.strip_prefix('/').unwrap_or(frame)
}

impl RawTransform<'_> {
    pub(crate) fn refused(&self, authority: &str, problem: InsertProblem) -> InsertError {
        let [parent, child] = [self.parent, self.child].map(|frame| strip_slash(frame).to_owned());
        InsertError { authority: authority.to_owned(), parent, child, problem }
    }

    /// Checks the message's transform and returns it as a rigid one, `parent_from_child`.
    pub(crate) fn check(&self) -> Result<Isometry3<f64>, InsertProblem> {
        let (parent, child) = (strip_slash(self.parent), strip_slash(self.child));
        if parent.is_empty() || child.is_empty() {
            return Err(InsertProblem::EmptyFrame);
        }
        if parent == child {
            return Err(InsertProblem::SelfTransform);
        }
        let (translation, rotation_xyzw) = (self.translation, self.rotation_xyzw);
        let ([x, y, z, w], [tx, ty, tz]) = (rotation_xyzw, translation);
        let values = [tx, ty, tz, x, y, z, w];
        if values.iter().any(|value| value.is_nan()) {
            return Err(InsertProblem::NaN(Box::new(values)));
        }
        if translation.iter().any(|value| value.is_infinite()) {
            return Err(InsertProblem::Infinite(translation));
        }
        let norm_squared: f64 = rotation_xyzw.iter().map(|value| value * value).sum();
        if (norm_squared - 1.0).abs() >= NORM_TOLERANCE {
            return Err(InsertProblem::NotNormalised(rotation_xyzw));
        }
        let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        Ok(Isometry3::from_parts(Translation3::from(translation), rotation))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const IDENTITY: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

    fn raw<'a>(parent: &'a str, child: &'a str, x: f64, rotation_xyzw: [f64; 4]) -> RawTransform<'a> {
        RawTransform { parent, child, stamp: Time::from_secs_nanos(5, 0), translation: [x, 0.0, 0.0], rotation_xyzw }
    }

    fn refusal(transform: RawTransform<'_>) -> InsertError {
        transform.refused("/driver", transform.check().expect_err("it should be refused"))
    }

    #[test]
    fn a_self_transform_is_refused_even_when_a_slash_hides_it() {
        for (parent, child) in [("map", "map"), ("/map", "map")] {
            let error = refusal(raw(parent, child, 0.0, IDENTITY));
            assert!(matches!(error.problem, InsertProblem::SelfTransform));
            let text = error.to_string();
            assert!(text.contains("/driver") && text.contains("[map]"), "{text}");
        }
    }

    #[test]
    fn frames_without_a_name_are_refused() {
        for (parent, child) in [("", "base"), ("map", ""), ("/", "base"), ("", "")] {
            let error = refusal(raw(parent, child, 0.0, IDENTITY));
            assert!(matches!(error.problem, InsertProblem::EmptyFrame), "{error}");
        }
    }

    #[test]
    fn nan_anywhere_is_refused_and_both_frames_are_named() {
        for error in [
            refusal(raw("map", "base", f64::NAN, IDENTITY)),
            refusal(raw("map", "base", 0.0, [f64::NAN, 0.0, 0.0, 1.0])),
        ] {
            assert!(matches!(error.problem, InsertProblem::NaN(_)));
            let text = error.to_string();
            for part in ["/driver", "[map]", "[base]", "NaN"] {
                assert!(text.contains(part), "{text}");
            }
        }
    }

    #[test]
    fn infinities_are_refused() {
        let error = refusal(raw("map", "base", f64::NEG_INFINITY, IDENTITY));
        assert!(matches!(error.problem, InsertProblem::Infinite(_)));
        let error = refusal(raw("map", "base", 0.0, [0.0, 0.0, f64::INFINITY, 1.0]));
        assert!(matches!(error.problem, InsertProblem::NotNormalised(_)));
    }

    #[test]
    fn a_rotation_is_refused_when_its_squared_norm_is_off_by_a_hundredth() {
        for w_squared in [0.0_f64, 0.9899, 1.0101, 4.0] {
            let error = refusal(raw("map", "base", 0.0, [0.0, 0.0, 0.0, w_squared.sqrt()]));
            assert!(matches!(error.problem, InsertProblem::NotNormalised(_)), "{w_squared}");
        }
        for w_squared in [0.9901_f64, 1.0, 1.0099] {
            let rotation = [0.0, 0.0, 0.0, -w_squared.sqrt()];
            let checked = raw("map", "base", 0.0, rotation).check().expect("within the tolerance");
            assert_eq!(checked.rotation.w, -1.0, "{w_squared}");
        }
    }
}
