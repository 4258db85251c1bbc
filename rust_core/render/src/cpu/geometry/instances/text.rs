//! The glyphs of [`Text`] among the many small things: made ready in groups, drawn as two triangles each.

use nalgebra::{Point3, Vector3};
use rcs_scene::{Aabb, Drawable, Glyph, Text};

use super::placement::{place_box, Placement};
use super::{BatchPiece, CornerSource, InstanceContext, InstanceScratch, Instances, Placed, Vertices};

/// Glyphs that are tested together.
const GLYPHS_IN_GROUP: usize = 64;

impl Instances {
    /// Makes some glyphs of a text ready.
    pub(in crate::cpu) fn add_text(
        &mut self,
        text: &Text,
        drawable: &Drawable,
        piece: &BatchPiece,
        &InstanceContext { view, screen, .. }: &InstanceContext<'_>,
        scratch: &mut InstanceScratch,
    ) {
        let is_on_top = !text.material().depth_test;
        let Some(surface) = view.surface_of_texts(is_on_top) else { return };
        let view_from_object = view.view.camera.view_from_facing(&drawable.fixed_from_object).cast();
        let transform = view.transform(&view_from_object);
        let source =
            CornerSource { vertices: Vertices::Text(text), material: text.material(), transform: &transform, surface };
        scratch.begin();
        let (range, first) = (piece.range.clone(), self.next);
        let mut is_seen = false;
        for begin in range.clone().step_by(GLYPHS_IN_GROUP) {
            let group = begin..range.end.min(begin + GLYPHS_IN_GROUP);
            let bounds = bounds_of_glyphs(text.glyphs().get(group.clone()).unwrap_or(&[]), text.height_m());
            if place_box(&bounds, &transform.clip_from_object, screen) == Placement::Unseen {
                continue;
            }
            for glyph in group {
                let number = first + 2 * (glyph - range.start) as u32;
                for (number, corners) in (number..).zip(glyph_triangles(glyph as u32)) {
                    is_seen |= self.add_triangle(number, corners, &source, screen, scratch);
                }
            }
        }
        if is_seen {
            let (batch, item, transform) = (piece.batch as u32, range.start as u32, self.keep(transform));
            self.placed.push(Placed { first, batch, item, may_be_cut: true, transform });
            self.next += 2 * range.len() as u32;
        }
    }
}

/// The corners of both triangles of a glyph.
pub(in crate::cpu) fn glyph_triangles(glyph: u32) -> [[u32; 3]; 2] {
    let [a, b, c, d, e, f] = Text::QUAD_INDICES.map(|corner| 4 * glyph + corner as u32);
    [[a, b, c], [d, e, f]]
}

/// The box around glyphs; not finite where one of them is not.
fn bounds_of_glyphs(glyphs: &[Glyph], height_m: f32) -> Aabb {
    let infinity = Vector3::repeat(f32::INFINITY);
    let (mut low, mut high) = (infinity, -infinity);
    let mut poison = 0.0;
    for glyph in glyphs {
        let bottom_m = glyph.top_m - height_m;
        // Edges change sides in text of a negative height.
        low = low.inf(&Vector3::new(glyph.left_m.min(glyph.right_m), glyph.top_m.min(bottom_m), 0.0));
        high = high.sup(&Vector3::new(glyph.left_m.max(glyph.right_m), glyph.top_m.max(bottom_m), 0.0));
        poison += (glyph.left_m + glyph.right_m + glyph.top_m + bottom_m) * 0.0;
    }
    Aabb::new(Point3::from(low.add_scalar(poison)).cast(), Point3::from(high).cast())
}
