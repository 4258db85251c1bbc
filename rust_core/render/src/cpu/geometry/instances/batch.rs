//! Solids of one drawable, and what those of a picture share.

use std::sync::Arc;

use nalgebra::{Matrix4, Vector3};
use rcs_scene::{Material, Mesh, Solid, Solids};

use super::shape::{shape_of, Shape, Shapes};
use crate::cpu::paint::Surface;
use crate::cpu::tile::screen::{ObjectTransform, Screen};
use crate::shading::to_light;
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

    /// The solid of an index.
    pub(super) fn solid(&self, item: usize) -> Option<SolidInstance<'_>> {
        let solid = self.solids.as_slice().get(item)?;
        let (mesh, shape) = (self.solids.shapes().get(solid.shape())?, self.shapes.get(solid.shape())?);
        Some(SolidInstance { solid, mesh, shape })
    }
}

/// The picture that batches are drawn in.
#[derive(Clone, Copy, Debug)]
pub(in crate::cpu) struct InstanceContext<'a> {
    /// All batches.
    pub batches: &'a [Batch<'a>],
    /// Common to them.
    pub view: &'a BatchView<'a>,
    /// The picture's pixels.
    pub screen: &'a Screen,
}

/// The part common to all batches of a picture.
#[derive(Debug)]
pub(in crate::cpu) struct BatchView<'a> {
    pub(in crate::cpu) view: View<'a>,
    pub(in crate::cpu) view_from_fixed: Matrix4<f64>,
    to_light: Option<Vector3<f32>>,
    /// Of solids: opaque and translucent, each as it is and mirrored.
    surfaces: [[Surface; 2]; 2],
}

impl<'a> BatchView<'a> {
    /// In a picture.
    pub(in crate::cpu) fn new(view: &View<'a>) -> Self {
        let surface = |is_translucent| {
            let surface = Surface::of(&Material::unlit(is_translucent), None);
            [surface.clone(), surface.mirrored()]
        };
        Self {
            view: *view,
            view_from_fixed: view.camera.fixed_from_view().inverse().to_homogeneous(),
            to_light: to_light(view.camera, view.scene.light.as_ref()),
            surfaces: [surface(false), surface(true)],
        }
    }

    pub(in crate::cpu) fn surface_of_solid(&self, solid: &Solid) -> &Surface {
        &self.surfaces[usize::from(solid.is_translucent())][usize::from(solid.is_mirrored())]
    }

    pub(in crate::cpu) fn transform(&self, view_from_object: &Matrix4<f64>) -> ObjectTransform {
        ObjectTransform::with_light(self.view.camera, view_from_object, self.to_light)
    }
}
