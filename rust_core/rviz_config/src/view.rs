//! The view of rviz's main window, section `Views: Current`.
//!
//! Virtual cameras do not use it, but the default light shines in its direction,
//! [`ViewConfig::direction_in_target_frame`]. Each view controller of rviz 1.14 is read with the angles of its camera.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use std::ops::RangeInclusive;

use crate::finding::FindingKind;
use crate::section::{Properties, Section, ANY};

/// The main view of a config.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ViewConfig {
    /// The frame that the view follows; `None` is the fixed frame.
    pub target_frame: Option<String>,
    /// `true` for worlds whose Z points down. Orbiting views look from the mirrored side then.
    pub invert_z: bool,
    /// The class of the view and where it puts its camera. An unknown class is an Orbit with its defaults.
    pub controller: ViewController,
}

/// A view controller by class, with the angles of its camera.
#[derive(Debug, Clone, PartialEq)]
pub enum ViewController {
    /// `rviz/Orbit` and `rviz/XYOrbit`: around a focal point.
    Orbit(OrbitView),
    /// `rviz/ThirdPersonFollower`: around a focal point, and turns with the frame's heading.
    ThirdPersonFollower(OrbitView),
    /// `rviz/FPS`: free in space.
    Fps(FreeView),
    /// `rviz/FrameAligned`: as FPS, and fixed to the frame. The angles begin along the axis "Point towards".
    FrameAligned(FreeView),
    /// `rviz/TopDownOrtho`: from above, without perspective.
    TopDownOrtho,
}

properties! {
    /// The camera of a view that is free in space.
    pub struct FreeView {
        /// Radians around Z; 0 looks along X; -π to π.
        yaw_rad: f32 = 0.0 => float("Yaw", -PI..=PI);
        /// Radians downwards from the horizon; -π to π.
        pitch_rad: f32 = 0.0 => float("Pitch", -PI..=PI);
        /// Radians around the direction of view; -π to π.
        roll_rad: f32 = 0.0 => float("Roll", -PI..=PI);
    }
    skip ["Position"];
}

/// The names of axes in a config, with yaw and pitch in radians along them. Once the user has turned the camera, the
/// axis is saved as "arbitrary", and rviz starts from -Z, as it does for an unknown name.
const FRAME_AXES: [(&str, [f32; 2]); 7] = [
    ("-z axis", [0.0, FRAC_PI_2]),
    ("arbitrary", [0.0, FRAC_PI_2]),
    ("+x axis", [0.0, 0.0]),
    ("-x axis", [PI, 0.0]),
    ("+y axis", [FRAC_PI_2, 0.0]),
    ("-y axis", [-FRAC_PI_2, 0.0]),
    ("+z axis", [0.0, -FRAC_PI_2]),
];

/// Smallest angle between an orbit's pitch and straight up or down, in radians.
const PITCH_MARGIN_RAD: f64 = 0.001;

fn orbit_pitches() -> RangeInclusive<f32> {
    let max = (f64::from(FRAC_PI_2) - PITCH_MARGIN_RAD) as f32;
    -max..=max
}

properties! {
    /// The camera of a view that orbits.
    pub struct OrbitView {
        /// Radians around Z from X to the camera, as seen from the focal point.
        yaw_rad: f32 = FRAC_PI_4 => float("Yaw", ANY);
        /// Radians upwards from the horizon to the camera, as seen from the focal point; short of ±π/2.
        pitch_rad: f32 = FRAC_PI_4 => float("Pitch", orbit_pitches());
    }
    skip ["Distance", "Focal Point", "Focal Shape Size", "Focal Shape Fixed Size", "Field of View"];
}

impl Default for ViewController {
    fn default() -> Self {
        ViewController::Orbit(OrbitView::default())
    }
}

impl ViewController {
    /// The controller of `class`; `None` if there is no such class.
    fn read(class: &str, section: &mut Section<'_>) -> Option<Self> {
        match class {
            "rviz/Orbit" | "rviz/XYOrbit" => Some(ViewController::Orbit(OrbitView::read(section))),
            "rviz/ThirdPersonFollower" => Some(ViewController::ThirdPersonFollower(OrbitView::read(section))),
            "rviz/FPS" => Some(ViewController::Fps(FreeView::read(section))),
            "rviz/FrameAligned" => {
                let mut yaw_pitch_rad = [0.0, FRAC_PI_2];
                section.choice("Point towards", &FRAME_AXES, &mut yaw_pitch_rad);
                section.skip(&["Lock Camera"]);
                let [yaw_rad, pitch_rad] = yaw_pitch_rad;
                let mut view = FreeView { yaw_rad, pitch_rad, ..FreeView::default() };
                section.properties(&mut view);
                Some(ViewController::FrameAligned(view))
            }
            "rviz/TopDownOrtho" => {
                section.skip(&["Angle", "Scale", "X", "Y"]);
                Some(ViewController::TopDownOrtho)
            }
            _ => None,
        }
    }
}

impl ViewConfig {
    pub(crate) fn read(mut section: Section<'_>) -> Self {
        let mut view = ViewConfig::default();
        if section.is_empty() {
            return view;
        }
        let mut class = String::new();
        section.text("Class", &mut class);
        if let Some(controller) = ViewController::read(&class, &mut section) {
            view.controller = controller;
            section.frame_or_fixed("Target Frame", &mut view.target_frame);
            section.bool("Invert Z Axis", &mut view.invert_z);
            section.skip(&["Name", "Value", "Near Clip Distance", "Enable Stereo Rendering"]);
        } else {
            let kind = FindingKind::UnknownClass { class };
            // Only the default light depends on the view.
            section.report().with_notes(true, || section.report().add(section.line(), section.path(), kind));
            section.skip_rest();
        }
        // No property is left that the light could depend on.
        section.report().with_notes(true, || section.finish());
        view
    }
}
