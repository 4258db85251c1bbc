//! Where a frame will be: a look ahead of the newest transforms, for a picture that takes time to become light.
//!
//! tf2 never extrapolates, as what was measured must not be mixed up with what was guessed. Here a guess is asked for
//! explicitly. Each link between the two frames is led on by itself, from its own newest sample by its own velocity
//! (see the module `motion`), so links of different rates and delays all end up at the same time.

use std::time::Duration;

use nalgebra::Isometry3;

use crate::lookup::names;
use crate::{LookupError, Time, TransformTree};

/// The time at which frames are predicted, and how far.
///
/// ```
/// use std::time::Duration;
/// use rcs_transforms::{Prediction, RawTransform, Time, TransformTree};
///
/// let mut tree = TransformTree::new();
/// for (millis, x) in [(0, 0.0), (20, 0.01), (40, 0.02)] {
///     let stamp = Time::from_secs_nanos(100, millis * 1_000_000);
///     let (translation, rotation_xyzw) = ([x, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]);
///     let base = RawTransform { parent: "odom", child: "base", stamp, translation, rotation_xyzw };
///     tree.insert(&base, false, "/drive")?;
/// }
/// let now = Time::from_secs_nanos(100, 45_000_000);
/// let prediction = Prediction { now, lead: Duration::from_millis(35), limit: Duration::from_millis(100) };
/// let odom_from_base = tree.predict("odom", "base", &prediction)?;
/// assert!((odom_from_base.translation.x - 0.04).abs() < 1e-9, "0.5 m/s for 40 ms more");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Prediction {
    /// The time now.
    pub now: Time,
    /// How far after now frames are predicted.
    pub lead: Duration,
    /// How far after its newest transform a frame is predicted at most. A frame whose newest transform is older than
    /// this and two of its periods has no motion to go by, and stays there.
    pub limit: Duration,
}

impl Prediction {
    /// The time at which frames are predicted.
    pub fn time(&self) -> Time {
        self.now.saturating_add(self.lead)
    }
}

impl TransformTree {
    /// Where `source` in `target` will be at a time ahead of the newest transforms: takes coordinates in the source
    /// frame to the target frame. Links whose transforms reach as far are taken at that time, those that move steadily
    /// are led on, and all others hold their newest transform.
    ///
    /// # Errors
    /// [`LookupError`], in the same cases as [`lookup`](Self::lookup) at time zero.
    pub fn predict(&self, target: &str, source: &str, prediction: &Prediction) -> Result<Isometry3<f64>, LookupError> {
        let (target, source) = names(target, source)?;
        if target == source {
            return Ok(Isometry3::identity());
        }
        let (target_id, source_id) = self.ids(target, source)?;
        // What cannot be looked up, such as through a frame that fell silent long ago, is not predicted either.
        let known = self.walk(target_id, source_id, Time::ZERO);
        let place = |_| {
            let by_motion = |history: &crate::history::History| history.predicted(prediction);
            self.walk_by(target_id, source_id, prediction.time(), by_motion)
        };
        let (target_from_source, _) =
            known.and_then(place).map_err(|failure| self.describe(failure, target, source))?;
        Ok(target_from_source)
    }
}
