//! The `Covariance` section of PoseWithCovariance and Odometry.

use crate::section::{at_least, Properties, Section};

/// The axes along which the orientation's covariance is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CovarianceFrame {
    /// The axes of the pose.
    Local,
    /// The axes of the message's frame.
    Fixed,
}

const FRAMES: [(&str, CovarianceFrame); 2] = [("Local", CovarianceFrame::Local), ("Fixed", CovarianceFrame::Fixed)];

/// Colours of the orientation's covariance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CovarianceColorStyle {
    /// All axes in one colour.
    Unique,
    /// Roll red, pitch green, yaw blue.
    Rgb,
}

const COLOR_STYLES: [(&str, CovarianceColorStyle); 2] =
    [("Unique", CovarianceColorStyle::Unique), ("RGB", CovarianceColorStyle::Rgb)];

/// How the covariance of a pose is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct CovarianceSettings {
    /// The ellipsoid of the position; `None` when it is switched off.
    pub position: Option<PositionCovarianceSettings>,
    /// The discs, or in 2D the cone, of the orientation; `None` when they are switched off.
    pub orientation: Option<OrientationCovarianceSettings>,
}

properties! {
    /// How the covariance of a position is drawn.
    pub struct PositionCovarianceSettings {
        /// Red, green and blue.
        color: [u8; 3] = [204, 51, 204] => color("Color");
        /// Opacity, 0 to 1.
        alpha: f32 = 0.3 => float("Alpha", 0.0..=1.0);
        /// Radius of the ellipsoid in standard deviations; at least 0.
        scale: f32 = 1.0 => float("Scale", at_least(0.0));
    }
}

properties! {
    /// How the covariance of an orientation is drawn.
    pub struct OrientationCovarianceSettings {
        /// The axes along which it is drawn.
        frame: CovarianceFrame = CovarianceFrame::Local => choice("Frame", &FRAMES);
        /// How the axes are coloured.
        color_style: CovarianceColorStyle = CovarianceColorStyle::Unique => choice("Color Style", &COLOR_STYLES);
        /// Red, green and blue of [`CovarianceColorStyle::Unique`].
        color: [u8; 3] = [255, 255, 127] => color("Color");
        /// Opacity, 0 to 1.
        alpha: f32 = 0.5 => float("Alpha", 0.0..=1.0);
        /// Distance of the discs from the pose, or length of the cone of a 2D pose, in metres; at least 0.
        offset_m: f32 = 1.0 => float("Offset", at_least(0.0));
        /// Standard deviations that are drawn; at least 0.
        scale: f32 = 1.0 => float("Scale", at_least(0.0));
    }
}

impl Default for CovarianceSettings {
    fn default() -> Self {
        CovarianceSettings { position: Some(Default::default()), orientation: Some(Default::default()) }
    }
}

impl Properties for CovarianceSettings {
    fn read_properties(&mut self, section: &mut Section<'_>) {
        let parts = if_enabled(section, "Covariance", |inside| CovarianceSettings {
            position: if_enabled(inside, "Position", Properties::read),
            orientation: if_enabled(inside, "Orientation", Properties::read),
        });
        *self = parts.unwrap_or(CovarianceSettings { position: None, orientation: None });
    }
}

/// Reads the section under `key`; `None` if it is switched off.
fn if_enabled<T>(section: &mut Section<'_>, key: &str, read: impl FnOnce(&mut Section<'_>) -> T) -> Option<T> {
    let mut inside = section.child(key);
    let mut is_enabled = true;
    inside.bool("Value", &mut is_enabled);
    let settings = read(&mut inside);
    inside.finish();
    is_enabled.then_some(settings)
}
