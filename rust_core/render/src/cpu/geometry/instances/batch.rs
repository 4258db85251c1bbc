//! Solids of one drawable, and what those of an image share.

use std::sync::Arc;

use nalgebra::Matrix4;
use rcs_scene::{Material, Mesh, Solid, Solids};

use super::shape::{shape_of, Shape, Shapes};
use crate::cpu::paint::Surface;
use crate::cpu::tile::screen::ObjectTransform;
use crate::View;

/// The solids of one drawable, with the shapes that they are made of.
#[derive(Debug)]
pub(in crate::cpu) struct Batch<'a> {
    solids: &'a Solids,
    shapes: Vec<Arc<Shape>>,
}

/// A solid with its shape.
pub(super) struct SolidInstance<'a> {
    pub solid: &'a Solid,
    pub mesh: &'a Mesh,
    pub shape: &'a Shape,
}

impl<'a> Batch<'a> {
    /// Of solids.
    pub(in crate::cpu) fn new(solids: &'a Solids, shapes: &mut Shapes) -> Self {
        Self { solids, shapes: solids.shapes().iter().map(|mesh| shape_of(mesh, shapes)).collect() }
    }

    fn solid(&self, item: usize) -> Option<SolidInstance<'_>> {
        let solid = self.solids.as_slice().get(item)?;
        let (mesh, shape) = (self.solids.shapes().get(solid.shape())?, self.shapes.get(solid.shape())?);
        Some(SolidInstance { solid, mesh, shape })
    }
}

/// The batches of an image.
#[derive(Debug)]
pub(in crate::cpu) struct Batches<'a> {
    pub(in crate::cpu) batches: Vec<Batch<'a>>,
    pub(in crate::cpu) view: View<'a>,
    pub(in crate::cpu) view_from_fixed: Matrix4<f64>,
    /// Of solids: opaque and translucent, each as it is and mirrored.
    surfaces: [[Surface; 2]; 2],
}

impl<'a> Batches<'a> {
    /// None, in an image.
    pub(in crate::cpu) fn new(view: &View<'a>) -> Self {
        let surface = |is_translucent| {
            let surface = Surface::of(&Material::unlit(is_translucent), None);
            [surface.clone(), surface.mirrored()]
        };
        Self {
            batches: Vec::new(),
            view: *view,
            view_from_fixed: view.camera.fixed_from_view().inverse().to_homogeneous(),
            surfaces: [surface(false), surface(true)],
        }
    }

    /// The solid of an index in the batch of an index.
    pub(super) fn solid(&self, [batch, item]: [usize; 2]) -> Option<SolidInstance<'_>> {
        self.batches.get(batch)?.solid(item)
    }

    pub(in crate::cpu) fn surface_of_solid(&self, solid: &Solid) -> &Surface {
        &self.surfaces[usize::from(solid.is_translucent())][usize::from(solid.is_mirrored())]
    }

    pub(in crate::cpu) fn transform(&self, view_from_object: &Matrix4<f64>) -> ObjectTransform {
        ObjectTransform::new(self.view.camera, view_from_object, self.view.scene.light.as_ref())
    }
}
