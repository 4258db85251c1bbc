//! The parts of a robot description.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::{Isometry3, Vector3};
use rcs_text::xml::PassedOver;
use thiserror::Error;

/// A robot.
#[derive(Clone, Debug, Default)]
pub struct Robot {
    /// Links by name.
    pub links: BTreeMap<String, Link>,
    /// Joints by name.
    pub joints: BTreeMap<String, Joint>,
    /// Errors of the parts that were left out.
    pub left_out: Vec<UrdfError>,
    /// Faults of the text that change nothing.
    pub passed_over: Vec<PassedOver>,
}

/// A link.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Link {
    /// Shapes for display.
    pub visuals: Vec<Visual>,
    /// `true` if all visuals could be read. If not, urdfdom knows no first one, by whose material rviz colours the
    /// collision shapes.
    pub has_first_visual: bool,
    /// Shapes for collision checks.
    pub collisions: Vec<Collision>,
}

/// A shape of a link for display.
#[derive(Clone, Debug, PartialEq)]
pub struct Visual {
    /// Pose in the link.
    pub link_from_shape: Isometry3<f64>,
    /// Shape.
    pub shape: UrdfShape,
    /// Name of the material; empty without.
    pub material_name: String,
    /// The material, if one of that name is defined.
    pub material: Option<Arc<UrdfMaterial>>,
}

/// A shape of a link for collision checks.
#[derive(Clone, Debug, PartialEq)]
pub struct Collision {
    /// Pose in the link.
    pub link_from_shape: Isometry3<f64>,
    /// Shape.
    pub shape: UrdfShape,
}

/// A shape in its own frame, lengths in metres.
#[derive(Clone, Debug, PartialEq)]
pub enum UrdfShape {
    /// A sphere.
    Sphere {
        /// Radius.
        radius_m: f64,
    },
    /// A box.
    Box {
        /// Edges along x, y and z.
        size_m: [f64; 3],
    },
    /// A cylinder along z.
    Cylinder {
        /// Radius.
        radius_m: f64,
        /// Length along z.
        length_m: f64,
    },
    /// A mesh of a file.
    Mesh {
        /// Address of the file.
        url: String,
        /// Factors along x, y and z.
        scale: [f64; 3],
    },
}

/// A colour or a texture.
#[derive(Clone, Debug, PartialEq)]
pub struct UrdfMaterial {
    /// Name.
    pub name: String,
    /// Colour and opacity, 0 to 1.
    pub rgba: [f32; 4],
    /// Address of an image, which replaces the colour as in rviz; empty without.
    pub texture: String,
}

/// Type of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// Rotates about its axis within limits.
    Revolute,
    /// Rotates about its axis without limits.
    Continuous,
    /// Slides along its axis.
    Prismatic,
    /// Moves freely.
    Floating,
    /// Moves in a plane.
    Planar,
    /// Does not move.
    Fixed,
}

/// Limits of a joint's position and speed, radians or metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimits {
    /// Least position, the safety controller's included.
    pub lower: f64,
    /// Greatest position, the safety controller's included.
    pub upper: f64,
    /// Greatest speed, per second.
    pub velocity: f64,
}

/// A joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Type.
    pub kind: JointKind,
    /// Parent link.
    pub parent_link: String,
    /// Child link, which the joint moves.
    pub child_link: String,
    /// Pose of the child link in the parent link while the joint is at zero.
    pub parent_from_child_at_zero: Isometry3<f64>,
    /// Axis in the child's frame, not normalised.
    pub axis: Vector3<f64>,
    /// Largest effort, newtons or newton metres; `None` for joints without limits.
    pub max_effort: Option<f64>,
    /// Limits, if it has any; those of a continuous joint bound its speed only.
    pub limits: Option<JointLimits>,
    /// Joint that it mimics.
    pub mimics: Option<String>,
    pub(super) line: usize,
}

/// A description, or a part of it, cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("line {line}: {element}: {reason}")]
pub struct UrdfError {
    /// Line, from 1.
    pub line: usize,
    /// Element, such as `link "base"`.
    pub element: String,
    /// Reason.
    pub reason: String,
}

impl UrdfError {
    pub(super) fn new(line: usize, element: impl Into<String>, reason: impl Into<String>) -> Self {
        Self { line, element: element.into(), reason: reason.into() }
    }
}
