//! The `Covariance` section of PoseWithCovariance and Odometry.

use crate::section::{at_least, Section};

/// Whose axes the orientation's covariance is drawn along.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CovarianceFrame {
    /// Those of the pose.
    Local,
    /// Those of the message's frame.
    Fixed,
}

const FRAMES: [(&str, CovarianceFrame); 2] = [("Local", CovarianceFrame::Local), ("Fixed", CovarianceFrame::Fixed)];

/// How the orientation's covariance is coloured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CovarianceColorStyle {
    /// All axes in one colour.
    Unique,
    /// Roll red, pitch green, yaw blue.
    Rgb,
}

const COLOR_STYLES: [(&str, CovarianceColorStyle); 2] =
    [("Unique", CovarianceColorStyle::Unique), ("RGB", CovarianceColorStyle::Rgb)];

/// What is shown of the covariance of a pose.
#[derive(Debug, Clone, PartialEq)]
pub struct CovarianceSettings {
    /// The ellipsoid of the position; `None` when it is switched off.
    pub position: Option<PositionCovarianceSettings>,
    /// The discs, or in 2D the cone, of the orientation; `None` when they are switched off.
    pub orientation: Option<OrientationCovarianceSettings>,
}

/// How the covariance of a position is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct PositionCovarianceSettings {
    /// Red, green and blue.
    pub color: [u8; 3],
    /// Opacity, 0 to 1.
    pub alpha: f32,
    /// How many standard deviations the ellipsoid reaches; at least 0.
    pub scale: f32,
}

/// How the covariance of an orientation is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct OrientationCovarianceSettings {
    /// Along whose axes.
    pub frame: CovarianceFrame,
    /// How the axes are coloured.
    pub color_style: CovarianceColorStyle,
    /// Red, green and blue of [`CovarianceColorStyle::Unique`].
    pub color: [u8; 3],
    /// Opacity, 0 to 1.
    pub alpha: f32,
    /// How far from the pose the discs stand, or how long the cone of a 2D pose is, in metres; at least 0.
    pub offset_m: f32,
    /// How many standard deviations are shown; at least 0.
    pub scale: f32,
}

impl Default for CovarianceSettings {
    fn default() -> Self {
        CovarianceSettings {
            position: Some(PositionCovarianceSettings::default()),
            orientation: Some(OrientationCovarianceSettings::default()),
        }
    }
}

impl Default for PositionCovarianceSettings {
    fn default() -> Self {
        PositionCovarianceSettings { color: [204, 51, 204], alpha: 0.3, scale: 1.0 }
    }
}

impl Default for OrientationCovarianceSettings {
    fn default() -> Self {
        OrientationCovarianceSettings {
            frame: CovarianceFrame::Local,
            color_style: CovarianceColorStyle::Unique,
            color: [255, 255, 127],
            alpha: 0.5,
            offset_m: 1.0,
            scale: 1.0,
        }
    }
}

impl CovarianceSettings {
    /// Reads the key `Covariance` of a display.
    pub(crate) fn read(section: &mut Section<'_>) -> Self {
        let mut inside = section.child("Covariance");
        let mut shown = true;
        inside.bool("Value", &mut shown);
        let position = PositionCovarianceSettings::read(&mut inside);
        let orientation = OrientationCovarianceSettings::read(&mut inside);
        inside.finish();
        CovarianceSettings { position: position.filter(|_| shown), orientation: orientation.filter(|_| shown) }
    }
}

impl PositionCovarianceSettings {
    fn read(section: &mut Section<'_>) -> Option<Self> {
        let mut settings = PositionCovarianceSettings::default();
        let mut inside = section.child("Position");
        let mut shown = true;
        inside.bool("Value", &mut shown);
        inside.color("Color", &mut settings.color);
        inside.float("Alpha", 0.0..=1.0, &mut settings.alpha);
        inside.float("Scale", at_least(0.0), &mut settings.scale);
        inside.finish();
        shown.then_some(settings)
    }
}

impl OrientationCovarianceSettings {
    fn read(section: &mut Section<'_>) -> Option<Self> {
        let mut settings = OrientationCovarianceSettings::default();
        let mut inside = section.child("Orientation");
        let mut shown = true;
        inside.bool("Value", &mut shown);
        inside.choice("Frame", &FRAMES, &mut settings.frame);
        inside.choice("Color Style", &COLOR_STYLES, &mut settings.color_style);
        inside.color("Color", &mut settings.color);
        inside.float("Alpha", 0.0..=1.0, &mut settings.alpha);
        inside.float("Offset", at_least(0.0), &mut settings.offset_m);
        inside.float("Scale", at_least(0.0), &mut settings.scale);
        inside.finish();
        shown.then_some(settings)
    }
}
