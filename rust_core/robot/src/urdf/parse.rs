//! Parsing a whole description.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use rcs_text::xml::{self, Element};

use super::elements::{self, error_at, Partial};
use super::model::{Robot, UrdfError, UrdfMaterial, Visual};

impl Robot {
    /// Parses a description.
    ///
    /// # Errors
    /// For what urdfdom refuses.
    pub fn parse(text: &str) -> Result<Self, UrdfError> {
        parse(text)
    }
}

fn parse(text: &str) -> Result<Robot, UrdfError> {
    let document = xml::parse(text).map_err(|error| UrdfError::new(error.line, "XML", error.what))?;
    let root = document.elements.iter().find(|element| element.name == "robot");
    let root = root.ok_or_else(|| UrdfError::new(1, "robot", "there is no element of that name"))?;
    if root.attribute("name").is_none() {
        return Err(error_at(root, "it has no name"));
    }
    if root.attribute("version").is_some_and(|version| version.trim() != "1.0") {
        return Err(error_at(root, "only version 1.0 is known"));
    }
    let mut robot = Robot { passed_over: document.passed_over, ..Robot::default() };
    let mut materials: BTreeMap<String, Arc<UrdfMaterial>> = BTreeMap::new();
    for element in root.children("material") {
        let Partial { value: material, fault } = elements::material(element);
        robot.left_out.extend(fault);
        if materials.insert(material.name.clone(), Arc::new(material)).is_some() {
            return Err(error_at(element, "its name occurs twice"));
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
            return Err(error_at(element, "its name occurs twice"));
        }
    }
    if robot.links.is_empty() {
        return Err(error_at(root, "it has no links"));
    }
    for element in root.children("joint") {
        let (name, joint) = elements::joint(element)?;
        if robot.joints.insert(name, joint).is_some() {
            return Err(error_at(element, "its name occurs twice"));
        }
    }
    check_tree(&robot, root)?;
    Ok(robot)
}

/// Resolves a visual's material; the first definition of a name serves all later visuals.
fn assign_material(
    visual: &mut Visual,
    link: &Element<'_>,
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
            return Some(error_at(link, reason));
        }
    }
    None
}

/// Checks that the joints connect existing links into one tree.
fn check_tree(robot: &Robot, root: &Element<'_>) -> Result<(), UrdfError> {
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
        (None, _) => Err(error_at(root, "its joints go round in a circle, no link is the first")),
        (Some(a), Some(b)) => Err(error_at(root, format!("the links \"{a}\" and \"{b}\" both hang on no joint"))),
    }
}

#[cfg(test)]
mod tests;
