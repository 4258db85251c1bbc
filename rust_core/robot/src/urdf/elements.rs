//! Elements of a description: materials, links with their shapes, joints.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rcs_text::xml::Element;

use super::attribute_values::{number, numbers, vector};
use super::model::{Collision, Joint, JointKind, JointLimits, Link, UrdfError, UrdfMaterial, UrdfShape, Visual};

/// An element as far as it could be read, and the error that ended it.
pub(super) struct Partial<T> {
    pub(super) value: T,
    pub(super) fault: Option<UrdfError>,
}

type Read<T> = Result<T, UrdfError>;

/// Error of an element.
pub(super) fn error_at(element: &Element<'_>, reason: impl Into<String>) -> UrdfError {
    UrdfError::new(element.line, describe(element), reason)
}

/// Name in errors, such as `link "base"`.
fn describe(element: &Element<'_>) -> String {
    match element.attribute("name") {
        Some(name) => format!("{} \"{name}\"", element.name),
        None => element.name.to_owned(),
    }
}

/// A required attribute.
fn needed<'a>(element: &'a Element<'_>, name: &str) -> Read<&'a str> {
    element.attribute(name).ok_or_else(|| error_at(element, format!("it has no attribute {name}")))
}

fn bad(element: &Element<'_>, name: &str, text: &str, wanted: &str) -> UrdfError {
    error_at(element, format!("{name}=\"{text}\" is not {wanted}"))
}

fn needed_number(element: &Element<'_>, name: &str) -> Read<f64> {
    let text = needed(element, name)?;
    number(text).ok_or_else(|| bad(element, name, text, "a number"))
}

fn optional_number(element: &Element<'_>, name: &str) -> Read<Option<f64>> {
    element.attribute(name).map(|text| number(text).ok_or_else(|| bad(element, name, text, "a number"))).transpose()
}

fn optional_vector(element: &Element<'_>, name: &str) -> Read<Option<[f64; 3]>> {
    let read = |text| vector(text).ok_or_else(|| bad(element, name, text, "three numbers"));
    element.attribute(name).map(read).transpose()
}

/// The `<origin>` of an element: its pose in the frame around it.
fn origin(parent: &Element<'_>) -> Read<Isometry3<f64>> {
    let Some(element) = parent.child("origin") else { return Ok(Isometry3::identity()) };
    let [x, y, z] = optional_vector(element, "xyz")?.unwrap_or_default();
    let [roll, pitch, yaw] = optional_vector(element, "rpy")?.unwrap_or_default();
    let rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    Ok(Isometry3::from_parts(Translation3::new(x, y, z), rotation))
}

/// A material of the robot, which must have a colour or a texture. One without is black.
pub(super) fn material(element: &Element<'_>) -> Partial<UrdfMaterial> {
    let defined = defined_material(element)
        .and_then(|material| material.ok_or_else(|| error_at(element, "it has neither a colour nor a texture")));
    match defined {
        Ok(value) => Partial { value, fault: None },
        Err(fault) => {
            let name = element.attribute("name").unwrap_or_default().to_owned();
            Partial {
                value: UrdfMaterial { name, rgba: [0.0, 0.0, 0.0, 1.0], texture: String::new() },
                fault: Some(fault),
            }
        }
    }
}

/// A material with a colour or a texture; `None` for a reference by name.
fn defined_material(element: &Element<'_>) -> Read<Option<UrdfMaterial>> {
    let texture = element.child("texture").and_then(|texture| texture.attribute("filename"));
    let color = element.child("color").and_then(|color| Some((color, color.attribute("rgba")?)));
    let rgba = match color {
        Some((color, text)) => {
            let channels = numbers(text).filter(|channels| channels.iter().all(|value| (0.0..=1.0).contains(value)));
            match (channels, texture) {
                // Any other count is black.
                (Some(channels), _) => Some(<[f64; 4]>::try_from(channels).unwrap_or([0.0, 0.0, 0.0, 1.0])),
                (None, Some(_)) => None,
                (None, None) => return Err(bad(color, "rgba", text, "four numbers from 0 to 1")),
            }
        }
        None => None,
    };
    if rgba.is_none() && texture.is_none() {
        return Ok(None);
    }
    Ok(Some(UrdfMaterial {
        name: element.attribute("name").unwrap_or_default().to_owned(),
        rgba: rgba.unwrap_or([0.0, 0.0, 0.0, 1.0]).map(|channel| channel as f32),
        texture: texture.unwrap_or_default().to_owned(),
    }))
}

/// The shape in `<geometry>`.
fn shape(parent: &Element<'_>) -> Read<UrdfShape> {
    let geometry = parent.child("geometry").ok_or_else(|| error_at(parent, "it has no geometry"))?;
    let element = geometry.elements.first().ok_or_else(|| error_at(geometry, "it is empty"))?;
    Ok(match element.name {
        "sphere" => UrdfShape::Sphere { radius_m: needed_number(element, "radius")? },
        "box" => {
            let text = needed(element, "size")?;
            let size_m = vector(text).ok_or_else(|| bad(element, "size", text, "three numbers"))?;
            UrdfShape::Box { size_m }
        }
        "cylinder" => UrdfShape::Cylinder {
            length_m: needed_number(element, "length")?,
            radius_m: needed_number(element, "radius")?,
        },
        "mesh" => UrdfShape::Mesh {
            url: needed(element, "filename")?.to_owned(),
            scale: optional_vector(element, "scale")?.unwrap_or([1.0; 3]),
        },
        _ => return Err(error_at(element, "unknown shape")),
    })
}

fn visual(element: &Element<'_>) -> Read<Visual> {
    let link_from_shape = origin(element)?;
    let shape = shape(element)?;
    let (material_name, material) = match element.child("material") {
        Some(material) => {
            let name = needed(material, "name")?.to_owned();
            // A definition that cannot be read counts as a reference by name.
            (name, defined_material(material).unwrap_or_default().map(Into::into))
        }
        None => (String::new(), None),
    };
    Ok(Visual { link_from_shape, shape, material_name, material })
}

fn check_inertial(element: &Element<'_>) -> Read<()> {
    let Some(inertial) = element.child("inertial") else { return Ok(()) };
    origin(inertial)?;
    let part = |name| inertial.child(name).ok_or_else(|| error_at(inertial, format!("it has no {name}")));
    needed_number(part("mass")?, "value")?;
    let inertia = part("inertia")?;
    for name in ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"] {
        needed_number(inertia, name)?;
    }
    Ok(())
}

/// A link up to the first error.
pub(super) fn link(element: &Element<'_>) -> Partial<Link> {
    let mut value = Link::default();
    let fault = read_link(element, &mut value).err();
    // Errors name the innermost element; the link's name helps as much.
    let fault = fault.map(|fault| UrdfError { element: format!("{}: {}", describe(element), fault.element), ..fault });
    Partial { value, fault }
}

fn read_link(element: &Element<'_>, link: &mut Link) -> Read<()> {
    needed(element, "name")?;
    check_inertial(element)?;
    for child in element.children("visual") {
        link.visuals.push(visual(child)?);
    }
    link.has_first_visual = !link.visuals.is_empty();
    for child in element.children("collision") {
        let link_from_shape = origin(child)?;
        link.collisions.push(Collision { link_from_shape, shape: shape(child)? });
    }
    Ok(())
}

/// A joint with its name.
pub(super) fn joint(element: &Element<'_>) -> Read<(String, Joint)> {
    let name = needed(element, "name")?.to_owned();
    let whose = |fault: UrdfError| UrdfError { element: format!("joint \"{name}\": {}", fault.element), ..fault };
    let joint = read_joint(element).map_err(whose)?;
    Ok((name, joint))
}

fn read_joint(element: &Element<'_>) -> Read<Joint> {
    let parent_from_child_at_zero = origin(element)?;
    let link = |name| element.child(name).and_then(|child| child.attribute("link")).unwrap_or_default().to_owned();
    let text = needed(element, "type")?;
    let kind = match text {
        "revolute" => JointKind::Revolute,
        "continuous" => JointKind::Continuous,
        "prismatic" => JointKind::Prismatic,
        "floating" => JointKind::Floating,
        "planar" => JointKind::Planar,
        "fixed" => JointKind::Fixed,
        _ => return Err(bad(element, "type", text, "a type of joint")),
    };
    let axis = match (kind, element.child("axis")) {
        (JointKind::Floating | JointKind::Fixed, _) => Vector3::zeros(),
        (_, None) => Vector3::x(),
        (_, Some(axis)) => optional_vector(axis, "xyz")?.unwrap_or_default().into(),
    };
    let (max_effort, limits) = match (element.child("limit"), kind) {
        (Some(limit), _) => {
            let number = |name| optional_number(limit, name).map(Option::unwrap_or_default);
            let (lower, upper) = (number("lower")?, number("upper")?);
            let velocity = needed_number(limit, "velocity")?;
            let limits = softened(JointLimits { lower, upper, velocity }, element);
            (Some(needed_number(limit, "effort")?), Some(limits))
        }
        (None, JointKind::Revolute | JointKind::Prismatic) => return Err(error_at(element, "it has no limits")),
        (None, _) => (None, None),
    };
    check_joint_extras(element)?;
    let mimics = element.child("mimic").and_then(|mimic| mimic.attribute("joint")).map(str::to_owned);
    let (parent_link, child_link, line) = (link("parent"), link("child"), element.line);
    Ok(Joint { kind, parent_link, child_link, parent_from_child_at_zero, axis, max_effort, limits, mimics, line })
}

/// Limits narrowed to those of the safety controller.
fn softened(limits: JointLimits, joint: &Element<'_>) -> JointLimits {
    let soft = |name| number(joint.child("safety_controller")?.attribute(name)?);
    match (soft("soft_lower_limit"), soft("soft_upper_limit")) {
        (Some(lower), Some(upper)) if lower < upper => {
            JointLimits { lower: limits.lower.max(lower), upper: limits.upper.min(upper), ..limits }
        }
        _ => limits,
    }
}

/// Checks the parts of a joint that are not used here, but that urdfdom refuses a robot for.
fn check_joint_extras(element: &Element<'_>) -> Read<()> {
    if let Some(safety) = element.child("safety_controller") {
        for name in ["soft_lower_limit", "soft_upper_limit", "k_position"] {
            optional_number(safety, name)?;
        }
        needed_number(safety, "k_velocity")?;
    }
    if let Some(calibration) = element.child("calibration") {
        optional_number(calibration, "rising")?;
        optional_number(calibration, "falling")?;
    }
    if let Some(mimic) = element.child("mimic") {
        needed(mimic, "joint")?;
        optional_number(mimic, "multiplier")?;
        optional_number(mimic, "offset")?;
    }
    if let Some(dynamics) = element.child("dynamics") {
        let given = [optional_number(dynamics, "damping")?, optional_number(dynamics, "friction")?];
        if given == [None, None] {
            return Err(error_at(dynamics, "it has neither damping nor friction"));
        }
    }
    Ok(())
}
