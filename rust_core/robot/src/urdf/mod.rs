//! A robot's description (URDF): its links with their shapes, and its joints.
//!
//! Reads what urdfdom 3.0 reads and refuses what it refuses, because rviz shows that: a shape that cannot be read takes
//! with it the rest of its link, but not the link and not the robot; a joint that cannot be read takes the whole robot;
//! a material belongs to the first definition of its name in the whole file; a colour of three numbers is black.
//!
//! The crate `urdf-rs` cannot do that: it refuses the robot for one shape or one incomplete `<inertial>`, has no lines
//! in its errors (it sorts the elements into a new text and reads that), does not notice names that occur twice, and
//! fills joints without limits with zeros.

mod attribute_values;
mod elements;
mod xml;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use nalgebra::{Isometry3, Vector3};
use thiserror::Error;

use elements::{Origin, Partial};
use xml::Element;

/// A robot.
#[derive(Clone, Debug, Default)]
pub struct Robot {
    /// By their names.
    pub links: BTreeMap<String, Link>,
    /// By their names.
    pub joints: BTreeMap<String, Joint>,
    /// What was left out because it could not be read.
    pub left_out: Vec<UrdfError>,
}

/// A link.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Link {
    /// Its shapes for display.
    pub visuals: Vec<Visual>,
    /// Whether all of the link's visuals could be read. If not, urdfdom knows no first one, by whose material rviz
    /// otherwise colours the collision shapes.
    pub has_first_visual: bool,
    /// Its shapes for collision checks.
    pub collisions: Vec<Collision>,
}

/// A shape of a link for display.
#[derive(Clone, Debug, PartialEq)]
pub struct Visual {
    /// Where the shape is in its link.
    pub link_from_shape: Isometry3<f64>,
    /// What it is.
    pub shape: UrdfShape,
    /// The name of its material; empty without.
    pub material_name: String,
    /// Its material, where there is one of that name.
    pub material: Option<Arc<UrdfMaterial>>,
}

/// A shape of a link for collision checks.
#[derive(Clone, Debug, PartialEq)]
pub struct Collision {
    /// Where the shape is in its link.
    pub link_from_shape: Isometry3<f64>,
    /// What it is.
    pub shape: UrdfShape,
}

/// A shape in its own frame, lengths in metres.
#[derive(Clone, Debug, PartialEq)]
pub enum UrdfShape {
    /// A ball.
    Sphere {
        /// Its radius.
        radius_m: f64,
    },
    /// A box.
    Box {
        /// Its edges along x, y and z.
        size_m: [f64; 3],
    },
    /// A cylinder along z.
    Cylinder {
        /// Its radius.
        radius_m: f64,
        /// Its length along z.
        length_m: f64,
    },
    /// A mesh of a file.
    Mesh {
        /// The file's address.
        url: String,
        /// Factors along x, y and z.
        scale: [f64; 3],
    },
}

/// A colour or a texture.
#[derive(Clone, Debug, PartialEq)]
pub struct UrdfMaterial {
    /// Its name.
    pub name: String,
    /// 0 to 1.
    pub rgba: [f32; 4],
    /// The address of an image; empty without. rviz ignores the colour where there is one.
    pub texture: String,
}

/// How a joint moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// Turns about its axis, within limits.
    Revolute,
    /// Turns about its axis without limits.
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

/// How far and how fast a joint may move, in radians or metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimits {
    /// The least position; the larger one of the limit and the safety controller's.
    pub lower: f64,
    /// The greatest position; the smaller one of the limit and the safety controller's.
    pub upper: f64,
    /// The greatest speed, per second.
    pub velocity: f64,
}

/// A joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// How it moves.
    pub kind: JointKind,
    /// The link that it hangs on.
    pub parent_link: String,
    /// The link that it moves.
    pub child_link: String,
    /// Where the child link is in the parent link while the joint is at zero.
    pub parent_from_child_at_zero: Isometry3<f64>,
    /// In the child's frame, not normalised.
    pub axis: Vector3<f64>,
    /// The largest effort, in newton or newton metres; `None` for joints without limits.
    pub max_effort: Option<f64>,
    /// Its limits, where it has some; those of a continuous joint bound its speed only.
    pub limits: Option<JointLimits>,
    /// The joint whose movement it follows, if it follows one.
    pub mimics: Option<String>,
    line: usize,
}

/// Why a description, or a part of it, cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("line {line}: {element}: {reason}")]
pub struct UrdfError {
    /// From 1.
    pub line: usize,
    /// Such as `link "base"`.
    pub element: String,
    /// What is wrong with it.
    pub reason: String,
}

impl UrdfError {
    fn new(line: usize, element: impl Into<String>, reason: impl Into<String>) -> Self {
        Self { line, element: element.into(), reason: reason.into() }
    }

    fn at(element: &Element, reason: impl Into<String>) -> Self {
        Self::new(element.line, element.describe(), reason)
    }
}

impl Robot {
    /// The robot of a description.
    ///
    /// # Errors
    /// What urdfdom refuses.
    pub fn parse(text: &str) -> Result<Self, UrdfError> {
        parse(text)
    }
}

fn parse(text: &str) -> Result<Robot, UrdfError> {
    let document = xml::parse(text)?;
    let root = document.iter().find(|element| element.name == "robot");
    let root = root.ok_or_else(|| UrdfError::new(1, "robot", "there is no element of that name"))?;
    if root.attribute("name").is_none() {
        return Err(UrdfError::at(root, "it has no name"));
    }
    if root.attribute("version").is_some_and(|version| version.trim() != "1.0") {
        return Err(UrdfError::at(root, "only version 1.0 is known"));
    }
    let mut robot = Robot::default();
    let mut materials: BTreeMap<String, Arc<UrdfMaterial>> = BTreeMap::new();
    for element in root.children("material") {
        let Partial { value: material, fault } = elements::material(element);
        robot.left_out.extend(fault);
        if materials.insert(material.name.clone(), Arc::new(material)).is_some() {
            return Err(UrdfError::at(element, "its name occurs twice"));
        }
    }
    for element in root.children("link") {
        let Partial { value: mut link, fault } = elements::link(element);
        robot.left_out.extend(fault);
        for visual in &mut link.visuals {
            robot.left_out.extend(assign_material(visual, element, &mut materials));
        }
        let name = element.attribute("name").unwrap_or_default().to_owned();
        if robot.links.insert(name, link).is_some() {
            return Err(UrdfError::at(element, "its name occurs twice"));
        }
    }
    if robot.links.is_empty() {
        return Err(UrdfError::at(root, "it has no links"));
    }
    for element in root.children("joint") {
        let (name, joint) = elements::joint(element)?;
        if robot.joints.insert(name, joint).is_some() {
            return Err(UrdfError::at(element, "its name occurs twice"));
        }
    }
    check_tree(&robot, root)?;
    Ok(robot)
}

/// Finds the material of a visual by its name; a definition that is the first of its name serves all later ones.
fn assign_material(
    visual: &mut Visual,
    link: &Element,
    materials: &mut BTreeMap<String, Arc<UrdfMaterial>>,
) -> Option<UrdfError> {
    if visual.material_name.is_empty() {
        return None;
    }
    match (materials.get(&visual.material_name), &visual.material) {
        (Some(known), _) => visual.material = Some(known.clone()),
        (None, Some(own)) => {
            materials.insert(visual.material_name.clone(), own.clone());
        }
        (None, None) => {
            let reason = format!("its material \"{}\" is defined nowhere", visual.material_name);
            return Some(UrdfError::at(link, reason));
        }
    }
    None
}

/// Joints must connect links that exist, into one tree.
fn check_tree(robot: &Robot, root: &Element) -> Result<(), UrdfError> {
    let mut children: BTreeSet<&str> = BTreeSet::new();
    for (name, joint) in &robot.joints {
        let error = |reason: String| UrdfError::new(joint.line, format!("joint \"{name}\""), reason);
        for (what, link) in [("parent", &joint.parent_link), ("child", &joint.child_link)] {
            if link.is_empty() {
                return Err(error(format!("it has no {what} link")));
            }
            if !robot.links.contains_key(link) {
                return Err(error(format!("its {what} link \"{link}\" does not exist")));
            }
        }
        children.insert(&joint.child_link);
    }
    let mut roots = robot.links.keys().filter(|link| !children.contains(link.as_str()));
    match (roots.next(), roots.next()) {
        (Some(_), None) => Ok(()),
        (None, _) => Err(UrdfError::at(root, "its joints go round in a circle, no link is the first")),
        (Some(a), Some(b)) => Err(UrdfError::at(root, format!("the links \"{a}\" and \"{b}\" both hang on no joint"))),
    }
}

impl Default for Origin {
    fn default() -> Self {
        Self(Isometry3::identity())
    }
}

#[cfg(test)]
mod tests;
