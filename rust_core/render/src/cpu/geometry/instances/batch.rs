//! Which things there are many of, and what they share in a picture.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::{Matrix4, Vector3};
use rcs_scene::{Drawable, Material, Solid, Solids, Text};

use super::shape::{shape_of, Shape, Shapes};
use crate::cpu::paint::Surface;
use crate::cpu::tile::band::Mode;
use crate::cpu::tile::screen::{ObjectTransform, Screen};

use crate::shading::to_light;
use crate::View;

/// Many things of one drawable.
#[derive(Debug)]
pub(in crate::cpu) enum Batch<'a> {
    /// Solids, with the shapes that they are made of.
    Solids(&'a Solids, Vec<Arc<Shape>>),
    /// The glyphs of a text.
    Text(&'a Text, &'a Drawable),
}

impl<'a> Batch<'a> {
    /// Of solids.
    pub(in crate::cpu) fn of_solids(solids: &'a Solids, shapes: &mut Shapes) -> Self {
        Self::Solids(solids, solids.shapes().iter().map(|mesh| shape_of(mesh, shapes)).collect())
    }
}

/// Some things of the batch with this index.
#[derive(Clone, Debug)]
pub(in crate::cpu) struct BatchPiece {
    /// Index of the batch.
    pub batch: usize,
    /// Which of its solids or glyphs.
    pub range: Range<usize>,
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
    /// Of the picture's texts: tested against the depth, and on top of everything.
    text_surfaces: Option<[Surface; 2]>,
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
            text_surfaces: None,
        }
    }

    /// Takes note of a text's surface.
    pub(in crate::cpu) fn note_text(&mut self, text: &Text, mut surface_of: impl FnMut(&Material) -> Surface) {
        if self.text_surfaces.is_none() {
            let plain = surface_of(text.material());
            let mode = |depth_test| Mode { blend: true, depth_test, depth_write: false };
            self.text_surfaces =
                Some([true, false].map(|depth_test| Surface { mode: mode(depth_test), ..plain.clone() }));
        }
    }

    pub(in crate::cpu) fn surface_of_solid(&self, solid: &Solid) -> &Surface {
        &self.surfaces[usize::from(solid.is_translucent())][usize::from(solid.is_mirrored())]
    }

    /// Of texts that are tested against the depth, or are on top of everything.
    pub(in crate::cpu) fn surface_of_texts(&self, are_on_top: bool) -> Option<&Surface> {
        self.text_surfaces.as_ref().map(|surfaces| &surfaces[usize::from(are_on_top)])
    }

    pub(in crate::cpu) fn transform(&self, view_from_object: &Matrix4<f64>) -> ObjectTransform {
        ObjectTransform::with_light(self.view.camera, view_from_object, self.to_light)
    }
}
