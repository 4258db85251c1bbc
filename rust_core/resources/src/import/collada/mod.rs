//! COLLADA (`.dae`).
//!
//! The reading rules are those of Assimp 5.2, as far as they reach the picture: geometries are read in the order of
//! the file into corners that faces do not share; materials are the `library_materials` in the order of their ids;
//! the visual scene that `<scene>` names is walked, `instance_node`s included, a node's own geometry before its
//! children's. rviz keeps the scale of the root (the `<unit>`) and drops its rotation (the `<up_axis>`), so a Y_UP
//! file lies on its side in rviz, and here.
//!
//! Where Assimp refuses a file for a trifle (a colour of three channels, a blank before a number), this reader goes on.

mod dom;
mod effect;
mod geometry;
mod scene;
mod source;

use dom::{parse, Node};

use super::{without_byte_order_mark, Imported};
use crate::MeshFault;

/// Reads a COLLADA file that may make so many corners.
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

/// Metres in a unit of the file.
fn unit_metres(root: Node<'_, '_>) -> f32 {
    let unit = dom::children(root, "asset").flat_map(|asset| dom::children(asset, "unit")).last();
    let metres = unit.and_then(|unit| unit.attribute("meter")).and_then(super::lenient_float::leading_f32);
    metres.filter(|metres| metres.is_finite()).unwrap_or(1.0)
}
