//! One transform as it was published, and the checks that it passes before the tree takes it.
//!
//! The checks are tf2's: both frames named, not the same frame twice, no NaN, a rotation whose squared
//! norm is within [`NORM_TOLERANCE`] of one. Two things differ, each because the tree returns rigid
//! transforms. Infinite translations, which tf2 stores and then answers with NaN, are refused; and a
//! rotation within the tolerance is normalised here, where tf2 keeps the small error and scales by it.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use thiserror::Error;

use crate::Time;

/// How far the squared norm of a rotation may be from one; tf2's value.
pub(crate) const NORM_TOLERANCE: f64 = 10e-3;

/// A transform as a message has it, unchecked. Frame names may carry one leading `/`, which is ignored.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct RawTransform<'a> {
    /// The frame that the numbers are given in (`header.frame_id`).
    pub parent: &'a str,
    /// The frame that is placed (`child_frame_id`).
    pub child: &'a str,
    /// When it held.
    pub stamp: Time,
    /// The child's origin in the parent, metres.
    pub translation: [f64; 3],
    /// The child's orientation in the parent, a quaternion in message order: x, y, z, w.
    pub rotation_xyzw: [f64; 4],
}

/// A transform that owns its frame names and is known to be rigid.
#[derive(Clone, PartialEq, Debug)]
pub struct StampedTransform {
    /// The frame that the transform leads to.
    pub parent: String,
    /// The frame that it leads from.
    pub child: String,
    /// When it held.
    pub stamp: Time,
    /// Takes coordinates in the child frame to coordinates in the parent frame, metres.
    pub parent_from_child: Isometry3<f64>,
}

impl StampedTransform {
    /// The same as a message would have it, ready for [`crate::TransformTree::insert`].
    pub fn as_raw(&self) -> RawTransform<'_> {
        let translation = &self.parent_from_child.translation;
        let rotation = &self.parent_from_child.rotation;
        RawTransform {
            parent: &self.parent,
            child: &self.child,
            stamp: self.stamp,
            translation: [translation.x, translation.y, translation.z],
            rotation_xyzw: [rotation.i, rotation.j, rotation.k, rotation.w],
        }
    }
}

/// Why a transform was refused. Each names who published it and both frames.
#[derive(Clone, PartialEq, Debug, Error)]
pub enum InsertError {
    /// Parent and child are the same frame.
    #[error("{authority} published a transform from frame [{frame}] to itself; it is ignored")]
    SelfTransform {
        /// Who published it.
        authority: String,
        /// The frame that is both parent and child.
        frame: String,
    },
    /// The parent, the child or both have no name.
    #[error("{authority} published a transform with an empty frame name (parent [{parent}], child [{child}]); it is ignored")]
    EmptyFrame {
        /// Who published it.
        authority: String,
        /// The parent frame as named.
        parent: String,
        /// The child frame as named.
        child: String,
    },
    /// The translation or rotation holds a NaN.
    #[error("{authority} published a transform of frame [{child}] in [{parent}] with NaN in it (x y z, then rotation x y z w: {values:?}); it is ignored")]
    NaN {
        /// Who published it.
        authority: String,
        /// The parent frame.
        parent: String,
        /// The child frame.
        child: String,
        /// The translation (metres), then the rotation (x, y, z, w), as published.
        values: Box<[f64; 7]>,
    },
    /// The translation holds an infinity.
    #[error("{authority} published a transform of frame [{child}] in [{parent}] with an infinite translation {translation:?}; it is ignored")]
    Infinite {
        /// Who published it.
        authority: String,
        /// The parent frame.
        parent: String,
        /// The child frame.
        child: String,
        /// The translation as published, metres.
        translation: [f64; 3],
    },
    /// The rotation is not a unit quaternion.
    #[error("{authority} published a transform of frame [{child}] in [{parent}] whose rotation xyzw {rotation_xyzw:?} is not a unit quaternion; it is ignored")]
    NotNormalised {
        /// Who published it.
        authority: String,
        /// The parent frame.
        parent: String,
        /// The child frame.
        child: String,
        /// The rotation as published.
        rotation_xyzw: [f64; 4],
    },
    /// The stamp is older than all that the frame's history keeps.
    #[error("{authority} published a transform of frame [{child}] in [{parent}] at {stamp}, too far behind the newest one at {latest}; it is ignored")]
    OldData {
        /// Who published it.
        authority: String,
        /// The parent frame.
        parent: String,
        /// The child frame.
        child: String,
        /// The stamp as published.
        stamp: Time,
        /// The newest stamp that the frame has.
        latest: Time,
    },
    /// The frame has another place at that stamp, which holds. tf2 calls it `TF_REPEATED_DATA`.
    #[error("{authority} published a second, different transform of frame [{child}] in [{parent}] at {stamp}; it is ignored (TF_REPEATED_DATA)")]
    RepeatedData {
        /// Who published it.
        authority: String,
        /// The parent frame as published.
        parent: String,
        /// The child frame.
        child: String,
        /// The stamp of both.
        stamp: Time,
    },
}

/// A frame name without the one leading `/` that tf (the first) used to write.
pub(crate) fn strip_slash(frame: &str) -> &str {
    frame.strip_prefix('/').unwrap_or(frame)
}

impl RawTransform<'_> {
    /// Checks the message's transform and returns it as a rigid one, `parent_from_child`.
    pub(crate) fn check(&self, authority: &str) -> Result<Isometry3<f64>, InsertError> {
        let (parent, child) = (strip_slash(self.parent), strip_slash(self.child));
        let named = || (authority.to_owned(), parent.to_owned(), child.to_owned());
        if parent.is_empty() || child.is_empty() {
            let (authority, parent, child) = named();
            return Err(InsertError::EmptyFrame { authority, parent, child });
        }
        if parent == child {
            let (authority, frame, _) = named();
            return Err(InsertError::SelfTransform { authority, frame });
        }
        let (translation, rotation_xyzw) = (self.translation, self.rotation_xyzw);
        let [x, y, z, w] = rotation_xyzw;
        let [tx, ty, tz] = translation;
        let values = [tx, ty, tz, x, y, z, w];
        if values.iter().any(|v| v.is_nan()) {
            let (authority, parent, child) = named();
            return Err(InsertError::NaN { authority, parent, child, values: Box::new(values) });
        }
        if translation.iter().any(|v| v.is_infinite()) {
            let (authority, parent, child) = named();
            return Err(InsertError::Infinite { authority, parent, child, translation });
        }
        let norm_squared: f64 = rotation_xyzw.iter().map(|v| v * v).sum();
        if (norm_squared - 1.0).abs() >= NORM_TOLERANCE {
            let (authority, parent, child) = named();
            return Err(InsertError::NotNormalised { authority, parent, child, rotation_xyzw });
        }
        Ok(Isometry3::from_parts(
            Translation3::from(translation),
            UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)),
        ))
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
        transform.check("/driver").expect_err("it should be refused")
    }

    #[test]
    fn a_self_transform_is_refused_even_when_a_slash_hides_it() {
        for (parent, child) in [("map", "map"), ("/map", "map")] {
            let error = refusal(raw(parent, child, 0.0, IDENTITY));
            assert!(matches!(error, InsertError::SelfTransform { .. }));
            let text = error.to_string();
            assert!(text.contains("/driver") && text.contains("[map]"), "{text}");
        }
    }

    #[test]
    fn frames_without_a_name_are_refused() {
        for (parent, child) in [("", "base"), ("map", ""), ("/", "base"), ("", "")] {
            let error = refusal(raw(parent, child, 0.0, IDENTITY));
            assert!(matches!(error, InsertError::EmptyFrame { .. }), "{error}");
        }
    }

    #[test]
    fn nan_anywhere_is_refused_and_both_frames_are_named() {
        for error in [
            refusal(raw("map", "base", f64::NAN, IDENTITY)),
            refusal(raw("map", "base", 0.0, [f64::NAN, 0.0, 0.0, 1.0])),
        ] {
            assert!(matches!(error, InsertError::NaN { .. }));
            let text = error.to_string();
            for part in ["/driver", "[map]", "[base]", "NaN"] {
                assert!(text.contains(part), "{text}");
            }
        }
    }

    #[test]
    fn infinities_are_refused() {
        let error = refusal(raw("map", "base", f64::NEG_INFINITY, IDENTITY));
        assert!(matches!(error, InsertError::Infinite { .. }));
        let error = refusal(raw("map", "base", 0.0, [0.0, 0.0, f64::INFINITY, 1.0]));
        assert!(matches!(error, InsertError::NotNormalised { .. }));
    }

    #[test]
    fn a_rotation_is_refused_when_its_squared_norm_is_off_by_a_hundredth() {
        for w_squared in [0.0_f64, 0.9899, 1.0101, 4.0] {
            let error = refusal(raw("map", "base", 0.0, [0.0, 0.0, 0.0, w_squared.sqrt()]));
            assert!(matches!(error, InsertError::NotNormalised { .. }), "{w_squared}");
        }
        for w_squared in [0.9901_f64, 1.0, 1.0099] {
            let checked = raw("map", "base", 0.0, [0.0, 0.0, 0.0, -w_squared.sqrt()])
                .check("/driver")
                .expect("within the tolerance");
            assert_eq!(checked.rotation.w, -1.0, "{w_squared}");
        }
    }

    #[test]
    fn an_owned_transform_equals_the_one_it_was_made_of() {
        let transform = raw("map", "base", 2.0, [0.6, 0.0, 0.0, 0.8]);
        let owned = StampedTransform {
            parent: "map".into(),
            child: "base".into(),
            stamp: transform.stamp,
            parent_from_child: transform.check("/driver").expect("a good transform"),
        };
        let again = owned.as_raw();
        assert_eq!(again.translation, transform.translation);
        for (a, b) in again.rotation_xyzw.iter().zip(transform.rotation_xyzw) {
            assert!((a - b).abs() < 1e-15);
        }
    }
}
