//! Prediction of frames beyond their newest transforms, which makes up for the latency of an image.
//!
//! tf2 never extrapolates, so as not to mix up measurements and guesses; here a prediction is asked for explicitly.
//! Each link between two frames is extrapolated from its own newest sample by its own velocity (see the module
//! `motion`), so links of different rates and delays all end up at the same time.

use std::time::Duration;

use crate::Time;

/// Time at which frames are predicted, and prediction horizon.
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
    /// Time from now to the prediction.
    pub lead: Duration,
    /// Longest prediction beyond a frame's newest transform. A frame whose newest transform is older than this and two
    /// of its periods stays where it is.
    pub limit: Duration,
}

impl Prediction {
    /// The time at which frames are predicted.
    pub fn time(&self) -> Time {
        self.now.saturating_add(self.lead)
    }
}
