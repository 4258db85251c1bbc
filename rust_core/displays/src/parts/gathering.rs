//! The drawables of a display that may have very many solids: those that follow one another become one drawable.

use std::sync::Arc;

use nalgebra::{Matrix4, Point3};
use rcs_scene::{DisplayId, Drawable, Geometry, Material, Mesh, RenderGroup, Rgba, Solids};

use crate::parts::solids::drawable;

/// Triangles above which a mesh stays a drawable of its own.
const MOST_TRIANGLES: usize = 1024;

/// Ordered drawables, with consecutive solids joined.
#[derive(Debug)]
pub(crate) struct Gathering {
    display: DisplayId,
    drawables: Vec<Drawable>,
    open: Solids,
}

impl Gathering {
    pub(crate) fn new(display: DisplayId) -> Self {
        Self { display, drawables: Vec::new(), open: Solids::default() }
    }

    /// Adds a lit solid that is sorted by its origin.
    pub(crate) fn solid(&mut self, mesh: &Arc<Mesh>, fixed_from_solid: &Matrix4<f64>, color: Rgba) {
        if !self.open.push(mesh, fixed_from_solid, color) {
            self.close();
            let geometry = Geometry::Mesh { mesh: mesh.clone(), material: Arc::new(Material::lit(color)) };
            self.drawables.push(drawable(self.display, *fixed_from_solid, geometry));
        }
    }

    pub(crate) fn drawable(&mut self, drawable: Drawable) {
        if let Geometry::Mesh { mesh, material } = &drawable.geometry {
            let origin = Point3::from(drawable.fixed_from_object.fixed_view::<3, 1>(0, 3).into_owned());
            if drawable.group == RenderGroup::Main && drawable.sort_point == origin {
                if let Some(color) = solid_color(mesh, material) {
                    return self.solid(mesh, &drawable.fixed_from_object, color);
                }
            }
        }
        // Text is drawn after all solids, opaque clouds after all opaque ones: their order among solids does not
        // matter.
        let is_independent = match &drawable.geometry {
            Geometry::Text(_) => true,
            Geometry::Points(points) => !points.blended,
            _ => false,
        };
        if !is_independent {
            self.close();
        }
        self.drawables.push(drawable);
    }

    fn close(&mut self) {
        if !self.open.is_empty() {
            let mut solids = std::mem::take(&mut self.open);
            solids.shrink_to_fit();
            let geometry = Geometry::Solids(Arc::new(solids));
            self.drawables.push(drawable(self.display, Matrix4::identity(), geometry));
        }
    }

    pub(crate) fn finish(mut self) -> Vec<Drawable> {
        self.close();
        self.drawables.shrink_to_fit();
        self.drawables
    }
}

/// Colour of a mesh that can be one of many solids; `None` for others.
pub(crate) fn solid_color(mesh: &Mesh, material: &Material) -> Option<Rgba> {
    material.as_lit().filter(|_| mesh.indices.len() / 3 <= MOST_TRIANGLES)
}

/// Drawables with each of many solids as one of its own, for tests.
#[cfg(test)]
pub(crate) fn singly(drawables: &[Drawable]) -> Vec<Drawable> {
    let each = |one: &Drawable| match &one.geometry {
        Geometry::Solids(solids) => solids
            .as_slice()
            .iter()
            .map(|solid| {
                let (mesh, material) = (solids.shapes()[solid.shape()].clone(), Arc::new(Material::lit(solid.color)));
                drawable(one.display, solid.matrix(), Geometry::Mesh { mesh, material })
            })
            .collect(),
        _ => vec![one.clone()],
    };
    drawables.iter().flat_map(each).collect()
}

#[cfg(test)]
mod tests {
    use rcs_scene::{Blending, HorizontalAlignment, LineTopology, Lines, Text, VerticalAlignment};

    use super::*;
    use crate::parts::solids::solid;
    use crate::SolidShape;

    fn kinds(drawables: &[Drawable]) -> String {
        let kind = |drawable: &Drawable| match &drawable.geometry {
            Geometry::Solids(solids) => format!("{} solids", solids.len()),
            Geometry::Text(_) => "text".to_owned(),
            Geometry::Mesh { .. } => "mesh".to_owned(),
            _ => "lines".to_owned(),
        };
        drawables.iter().map(kind).collect::<Vec<_>>().join(", ")
    }

    #[test]
    fn solids_come_together_unless_something_between_them_counts() {
        let lit = Arc::new(Material::lit(Rgba::WHITE));
        let solid = |material: &Arc<Material>| solid(0, SolidShape::Cone, Matrix4::identity(), material);
        let alignment = (HorizontalAlignment::Left, VerticalAlignment::Below);
        let text = Geometry::Text(Arc::new(Text::new("a", 1.0, Rgba::WHITE, alignment)));
        let (positions, colors) = (vec![[0.0; 3]; 2], vec![[255; 4]]);
        let (topology, blending) = (LineTopology::List, Blending::Replace);
        let lines = Geometry::Lines(Arc::new(Lines { positions, colors, topology, blending }));
        let of = |geometry: &Geometry| drawable(0, Matrix4::identity(), geometry.clone());
        let mut gathering = Gathering::new(0);
        let all =
            [solid(&lit), of(&text), solid(&lit), of(&lines), solid(&lit), solid(&Arc::new(Material::unlit(true)))];
        all.iter().cloned().for_each(|drawable| gathering.drawable(drawable));
        gathering.solid(&SolidShape::Cube.mesh(), &Matrix4::identity(), Rgba::WHITE);
        gathering.solid(&SolidShape::Cube.mesh(), &Matrix4::zeros(), Rgba::WHITE);
        let drawables = gathering.finish();
        assert_eq!(kinds(&drawables), "text, 2 solids, lines, 1 solids, mesh, 1 solids, mesh");
        assert_eq!(singly(&drawables).len(), 8);
    }
}
