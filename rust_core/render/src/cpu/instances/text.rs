//! The glyphs of [`Text`] among the many small things: made ready in groups, drawn as [rectangles](super::glyphs) where
//! they stand upright, else as two triangles.

use nalgebra::Vector3;
use rcs_scene::{Drawable, Glyph, Text};

use super::glyphs::{are_upright, GlyphRect, Ink, Place};
use super::reach::{reach, Reach, ShapeBounds};
use super::{BatchPiece, BatchView, InstanceScratch, Instances, Placed, Source, Vertices};
use crate::cpu::band::Band;
use crate::cpu::screen::Screen;

/// Glyphs that are sieved together.
const GLYPHS_IN_GROUP: usize = 64;

impl Instances {
    /// Makes some glyphs of a text ready.
    pub(super) fn add_text(
        &mut self,
        text: &Text,
        drawable: &Drawable,
        piece: &BatchPiece,
        view: &BatchView<'_>,
        screen: &Screen,
        scratch: &mut InstanceScratch,
    ) {
        let Some(surface) = view.surface_of_text(text) else { return };
        let view_from_object = view.view.camera.view_from_facing(&drawable.fixed_from_object).cast();
        let transform = view.transform(&view_from_object);
        let source =
            Source { vertices: Vertices::Text(text), material: text.material(), transform: &transform, surface };
        scratch.begin();
        let range = piece.range.clone();
        let (batch, item) = (piece.batch as u32, range.start as u32);
        self.load.in_order = true;
        let (first, mut is_seen, is_upright) = (self.next, false, are_upright(surface, &transform));
        for begin in range.clone().step_by(GLYPHS_IN_GROUP) {
            let group = begin..range.end.min(begin + GLYPHS_IN_GROUP);
            let glyphs = text.glyphs().get(group.clone()).unwrap_or(&[]);
            if reach(&bounds_of_glyphs(glyphs, text.height_m()), &transform.clip_from_object, screen) == Reach::Unseen {
                continue;
            }
            for (glyph, placed) in group.zip(glyphs) {
                let number = first + 2 * (glyph - range.start) as u32;
                if is_upright {
                    match GlyphRect::place(text, placed, &transform, screen) {
                        Place::Unseen => continue,
                        Place::Seen(rect) => {
                            self.add_rect(number, &rect, screen);
                            is_seen = true;
                            continue;
                        }
                        Place::Cut => {}
                    }
                }
                for (number, corners) in (number..).zip(glyph_triangles(glyph as u32)) {
                    is_seen |= self.add_triangle(number, corners, &source, screen, scratch);
                }
            }
        }
        if is_seen {
            self.placed.push(Placed { first, batch, item, may_be_cut: true, is_small: false, transform });
            self.next += 2 * range.len() as u32;
        }
    }

    /// Makes a glyph ready, under the number of the first of its triangles.
    fn add_rect(&mut self, number: u32, rect: &GlyphRect, screen: &Screen) {
        let (begin, end) = rect.rows();
        let extent = rect.extent(screen);
        self.load.add(extent);
        self.load.add(extent);
        self.bin(number, begin, end, screen);
    }
}

impl Placed {
    /// Of a text whose glyphs are upright, what draws the glyph that begins with a triangle, if it has not to be cut;
    /// says whether it did.
    pub(super) fn rects<'s>(
        &self,
        source: &'s Source<'_>,
        screen: &'s Screen,
    ) -> Option<impl Fn(u32, &mut Band<'_>) -> bool + use<'s>> {
        let Vertices::Text(text) = source.vertices else { return None };
        let color = source.color(&source.vertex(4 * self.item)?);
        let ink = are_upright(source.surface, source.transform).then(|| Ink::new(source.surface, color))??;
        let first = self.item;
        Some(move |triangle: u32, band: &mut Band<'_>| {
            let Some(glyph) = text.glyphs().get((first + triangle / 2) as usize) else { return false };
            match GlyphRect::place(text, glyph, source.transform, screen) {
                Place::Seen(rect) => rect.draw(&ink, band),
                Place::Unseen => {}
                Place::Cut => return false,
            }
            true
        })
    }
}

/// The corners of both triangles of a glyph.
pub(super) fn glyph_triangles(glyph: u32) -> [[u32; 3]; 2] {
    let [a, b, c, d, e, f] = Text::QUAD_INDICES.map(|corner| 4 * glyph + corner as u32);
    [[a, b, c], [d, e, f]]
}

/// The box around glyphs; not finite where one of them is not.
fn bounds_of_glyphs(glyphs: &[Glyph], height_m: f32) -> ShapeBounds {
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
    ShapeBounds::new(low.add_scalar(poison), high)
}
