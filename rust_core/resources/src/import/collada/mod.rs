//! COLLADA (`.dae`).
//!
//! As in Assimp 5.2, where it matters for the image: geometries are read in the order of the file into corners that
//! faces do not share; materials are the `library_materials` in the order of their ids; the visual scene of `<scene>`
//! is traversed, `instance_node`s included, a node's own geometry before its children's. rviz keeps the scale of the
//! root (the `<unit>`) and drops its rotation (the `<up_axis>`), so a Y_UP file lies on its side.
//!
//! Small faults for which Assimp refuses a file (a colour of three channels, a blank before a number) are accepted.

mod dom;
mod effect;
mod geometry;
mod scene;
mod source;

use rcs_text::xml::PassedOver;

use super::imported::Imported;
use crate::MeshFault;

/// Reads a COLLADA file of at most `max_corners` corners.
pub(super) fn read(bytes: &[u8], max_corners: usize) -> Result<Imported, MeshFault> {
    let text = rcs_text::decode(bytes);
    let document = rcs_text::xml::parse(&text).map_err(|error| MeshFault::Xml(error.to_string()))?;
    let root = document.elements.first().ok_or_else(|| MeshFault::Xml("no element in it".to_owned()))?;
    if root.name != "COLLADA" {
        return Err(dom::fault(root, "the root element is not <COLLADA>"));
    }
    let materials = effect::read_materials(root);
    let geometries = geometry::read_geometries(root, max_corners)?;
    let imported = scene::build(root, &geometries, materials, max_corners)?;
    let mut passed_over = document.passed_over;
    let hole = root.descendants().find(|element| element.name == "ph");
    passed_over
        .extend(hole.map(|hole| PassedOver { line: hole.line, what: "polygons with holes, which are left out" }));
    Ok(Imported { passed_over, ..imported })
}
