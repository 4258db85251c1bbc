//! Instances of shapes: the solids that markers, axes and arrows are made of.
//!
//! A scene may have hundreds of thousands of them, too many for a [`Drawable`](crate::Drawable) each. One drawable
//! holds all that follow one another in the scene: a few shapes, and the shape, matrix and colour of each solid. They
//! are lit as by [`Material::lit`], and drawn as if each were a drawable of its own, sorted by its origin.

use std::sync::Arc;

use nalgebra::{Matrix3x4, Matrix4, Point3, Vector4};

use crate::{Material, Mesh, Rgba};

/// Solids in the order of drawing.
#[derive(Clone, Debug, Default)]
pub struct Solids {
    shapes: Vec<Arc<Mesh>>,
    solids: Vec<Solid>,
}

/// One of [`Solids`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solid {
    /// The upper three rows of the matrix from the shape's frame to the fixed frame; the last one is 0, 0, 0, 1.
    pub fixed_from_shape: Matrix3x4<f64>,
    /// Diffuse colour and opacity.
    pub color: Rgba,
    /// Index of its shape.
    shape: u32,
}

impl Solids {
    /// Adds a solid at the end. `false`, and nothing is added, where the matrix has another last row than 0, 0, 0, 1.
    pub fn push(&mut self, shape: &Arc<Mesh>, fixed_from_shape: &Matrix4<f64>, color: Rgba) -> bool {
        if fixed_from_shape.row(3) != Vector4::w().transpose() {
            return false;
        }
        let known = self.shapes.iter().rposition(|known| Arc::ptr_eq(known, shape));
        let index = known.unwrap_or_else(|| {
            self.shapes.push(shape.clone());
            self.shapes.len() - 1
        });
        let fixed_from_shape = fixed_from_shape.fixed_view::<3, 4>(0, 0).into_owned();
        self.solids.push(Solid { fixed_from_shape, color, shape: index as u32 });
        true
    }

    /// Frees unused memory.
    pub fn shrink_to_fit(&mut self) {
        self.solids.shrink_to_fit();
    }

    /// All solids.
    pub fn as_slice(&self) -> &[Solid] {
        &self.solids
    }

    /// Number of solids.
    pub fn len(&self) -> usize {
        self.solids.len()
    }

    /// `true` without solids.
    pub fn is_empty(&self) -> bool {
        self.solids.is_empty()
    }

    /// The shapes, each once.
    pub fn shapes(&self) -> &[Arc<Mesh>] {
        &self.shapes
    }
}

impl Solid {
    /// Index of its shape in [`Solids::shapes`].
    #[inline]
    pub fn shape(&self) -> usize {
        self.shape as usize
    }

    /// `true` if it is drawn with the translucent drawables, by the rule of [`Material::lit`].
    #[inline]
    pub fn is_translucent(&self) -> bool {
        self.color.a < Material::OPAQUE_FROM_ALPHA
    }

    /// From the shape's frame to the fixed frame.
    pub fn matrix(&self) -> Matrix4<f64> {
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| self.fixed_from_shape.column(i).into_owned());
        Matrix4::from_columns(&[a.push(0.0), b.push(0.0), c.push(0.0), d.push(1.0)])
    }

    /// Its origin in the fixed frame, by whose distance to the eye it is sorted.
    pub fn sort_point(&self) -> Point3<f64> {
        Point3::from(self.fixed_from_shape.column(3).into_owned())
    }

    /// `true` if it is turned inside out.
    pub fn is_mirrored(&self) -> bool {
        self.fixed_from_shape.fixed_view::<3, 3>(0, 0).determinant() < 0.0
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    #[test]
    fn a_shape_is_kept_once_and_matrices_come_back_as_they_were() {
        let [cube, cone] = [(); 2].map(|()| Arc::new(Mesh::default()));
        let mut solids = Solids::default();
        let place = |x: f64| Matrix4::new_translation(&Vector3::new(x, 2.0, 3.0)) * Matrix4::new_scaling(-x);
        for (i, shape) in [&cube, &cone, &cube].into_iter().enumerate() {
            assert!(solids.push(shape, &place(i as f64 + 1.0), Rgba::WHITE));
        }
        assert!(!solids.push(&cube, &Matrix4::zeros(), Rgba::WHITE), "not affine");
        assert_eq!((solids.len(), solids.shapes().len()), (3, 2));
        assert_eq!(solids.as_slice().iter().map(Solid::shape).collect::<Vec<_>>(), [0, 1, 0]);
        let last = solids.as_slice()[2];
        assert_eq!((last.matrix(), last.sort_point()), (place(3.0), Point3::new(3.0, 2.0, 3.0)));
        assert!(last.is_mirrored() && !last.is_translucent());
    }
}
