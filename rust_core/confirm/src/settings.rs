//! Settings of confirmed light: agreement between the scene and the measured surface.

use std::time::Duration;

/// Part of the tolerance that grows with the distance, metres per metre.
pub(crate) const TOLERANCE_PER_METRE: f32 = 0.01;

/// Light where no surface was measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Unseen {
    /// Stays dark.
    #[default]
    Dark,
    /// Is allowed.
    Light,
}

/// Settings of a [`Confirmer`](crate::Confirmer).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConfirmSettings {
    /// Largest difference between an object's depth and the surface's, metres; 1 % of the distance is added, and
    /// surfaces seen at a grazing angle have more.
    pub tolerance_m: f64,
    /// Pixels around what is in the way that stay dark, too.
    pub margin_px: u32,
    /// Light where no surface was measured.
    pub unseen: Unseen,
    /// Longest time between two depth images; after a longer one, light is held back as at the start.
    pub max_gap: Duration,
}

impl Default for ConfirmSettings {
    fn default() -> Self {
        Self { tolerance_m: 0.03, margin_px: 4, unseen: Unseen::Dark, max_gap: Duration::from_millis(500) }
    }
}
