//! The view of rviz's main window, section `Views: Current`.
//!
//! Virtual cameras do not use it, but the default light shines in its direction,
//! [`ViewConfig::direction_in_target_frame`]. Each view controller of rviz 1.14 is read with the properties that place
//! its camera.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use std::ops::RangeInclusive;

use crate::finding::FindingKind;
use crate::section::{at_least, Properties, Section, ANY};

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

/// A view controller by class, with the pose of its camera in the view's frame.
#[derive(Debug, Clone, PartialEq)]
pub enum ViewController {
    /// `rviz/Orbit`: around a focal point.
    Orbit(OrbitView),
    /// `rviz/XYOrbit`: around a focal point in the plane Z = 0, raised above it a little.
    XyOrbit(OrbitView),
    /// `rviz/ThirdPersonFollower`: as XYOrbit, and turns with the frame's heading.
    ThirdPersonFollower(OrbitView),
    /// `rviz/FPS`: free in space.
    Fps {
        /// Position of the camera in metres.
        position_m: [f32; 3],
        /// Radians around Z; 0 looks along X; -π to π.
        yaw_rad: f32,
        /// Radians downwards from the horizon; -π to π.
        pitch_rad: f32,
        /// Radians around the direction of view; -π to π.
        roll_rad: f32,
    },
    /// `rviz/FrameAligned`: as FPS, and fixed to the frame.
    FrameAligned {
        /// Position of the camera in metres.
        position_m: [f32; 3],
        /// Radians around Z; 0 looks along X; -π to π.
        yaw_rad: f32,
        /// Radians downwards from the horizon; -π to π.
        pitch_rad: f32,
        /// Radians around the direction of view; -π to π.
        roll_rad: f32,
        /// The axis that the camera was pointed along before the angles were set.
        axis: FrameAxis,
    },
    /// `rviz/TopDownOrtho`: from above, without perspective.
    TopDownOrtho {
        /// Radians around Z.
        angle_rad: f32,
        /// Pixels a metre.
        scale_px_per_m: f32,
        /// Position of the picture's centre in metres.
        x_m: f32,
        /// Position of the picture's centre in metres.
        y_m: f32,
    },
}

/// An axis of a frame, or minus one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameAxis {
    /// +X
    PlusX,
    /// -X
    MinusX,
    /// +Y
    PlusY,
    /// -Y
    MinusY,
    /// +Z
    PlusZ,
    /// -Z
    MinusZ,
}

/// The names of axes in a config. Once the user has turned the camera, the axis is saved as "arbitrary", and rviz starts
/// from -Z, as it does for an unknown name.
const FRAME_AXES: [(&str, FrameAxis); 7] = [
    ("-z axis", FrameAxis::MinusZ),
    ("arbitrary", FrameAxis::MinusZ),
    ("+x axis", FrameAxis::PlusX),
    ("-x axis", FrameAxis::MinusX),
    ("+y axis", FrameAxis::PlusY),
    ("-y axis", FrameAxis::MinusY),
    ("+z axis", FrameAxis::PlusZ),
];

impl FrameAxis {
    /// Yaw and pitch in radians that look along this axis.
    fn yaw_pitch_rad(self) -> [f32; 2] {
        match self {
            FrameAxis::PlusX => [0.0, 0.0],
            FrameAxis::MinusX => [PI, 0.0],
            FrameAxis::PlusY => [FRAC_PI_2, 0.0],
            FrameAxis::MinusY => [-FRAC_PI_2, 0.0],
            FrameAxis::PlusZ => [0.0, -FRAC_PI_2],
            FrameAxis::MinusZ => [0.0, FRAC_PI_2],
        }
    }
}

/// Smallest angle between an orbit's pitch and straight up or down, in radians.
const PITCH_MARGIN_RAD: f64 = 0.001;

fn orbit_pitches() -> RangeInclusive<f32> {
    let max = (f64::from(FRAC_PI_2) - PITCH_MARGIN_RAD) as f32;
    -max..=max
}

properties! {
    /// The camera of a view that orbits.
    pub struct OrbitView {
        /// Metres from the focal point to the camera; at least 0.001.
        distance_m: f32 = 10.0 => float("Distance", at_least(0.001));
        /// The point that the camera looks at, in metres.
        focal_point_m: [f32; 3] = [0.0; 3] => vector("Focal Point");
        /// Radians around Z from X to the camera, as seen from the focal point.
        yaw_rad: f32 = FRAC_PI_4 => float("Yaw", ANY);
        /// Radians upwards from the horizon to the camera, as seen from the focal point; short of ±π/2.
        pitch_rad: f32 = FRAC_PI_4 => float("Pitch", orbit_pitches());
    }
    skip ["Focal Shape Size", "Focal Shape Fixed Size", "Field of View"];
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
            "rviz/Orbit" => Some(ViewController::Orbit(OrbitView::read(section))),
            "rviz/XYOrbit" => Some(ViewController::XyOrbit(OrbitView::read(section))),
            "rviz/ThirdPersonFollower" => Some(ViewController::ThirdPersonFollower(OrbitView::read(section))),
            "rviz/FPS" => {
                let (position_m, [yaw_rad, pitch_rad, roll_rad]) = read_free(section, [0.0, 0.0]);
                Some(ViewController::Fps { position_m, yaw_rad, pitch_rad, roll_rad })
            }
            "rviz/FrameAligned" => {
                let mut axis = FrameAxis::MinusZ;
                section.choice("Point towards", &FRAME_AXES, &mut axis);
                section.skip(&["Lock Camera"]);
                let (position_m, [yaw_rad, pitch_rad, roll_rad]) = read_free(section, axis.yaw_pitch_rad());
                Some(ViewController::FrameAligned { position_m, yaw_rad, pitch_rad, roll_rad, axis })
            }
            "rviz/TopDownOrtho" => {
                let (mut angle_rad, mut scale_px_per_m, mut x_m, mut y_m) = (0.0, 10.0, 0.0, 0.0);
                section.float("Angle", ANY, &mut angle_rad);
                section.float("Scale", ANY, &mut scale_px_per_m);
                section.float("X", ANY, &mut x_m);
                section.float("Y", ANY, &mut y_m);
                Some(ViewController::TopDownOrtho { angle_rad, scale_px_per_m, x_m, y_m })
            }
            _ => None,
        }
    }
}

/// Position in metres, and yaw, pitch and roll in radians, of a free camera.
fn read_free(section: &mut Section<'_>, yaw_pitch_rad: [f32; 2]) -> ([f32; 3], [f32; 3]) {
    let (mut position_m, [mut yaw, mut pitch], mut roll) = ([0.0; 3], yaw_pitch_rad, 0.0);
    section.vector("Position", &mut position_m);
    section.float("Yaw", -PI..=PI, &mut yaw);
    section.float("Pitch", -PI..=PI, &mut pitch);
    section.float("Roll", -PI..=PI, &mut roll);
    (position_m, [yaw, pitch, roll])
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
