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

use dom::parse;

use super::imported::{without_byte_order_mark, Imported};
use crate::MeshFault;

/// Reads a COLLADA file of at most `max_corners` corners.
pub(super) fn read(bytes: &[u8], max_corners: usize) -> Result<Imported, MeshFault> {
    let text = String::from_utf8_lossy(without_byte_order_mark(bytes));
    parse(&text, |root| {
        if root.tag_name().name() != "COLLADA" {
            return Err(dom::fault(root, "the root element is not <COLLADA>"));
        }
        let materials = effect::read_materials(root);
        let geometries = geometry::read_geometries(root, max_corners)?;
        scene::build(root, &geometries, materials, max_corners)
    })
}
