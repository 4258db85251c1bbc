//! The glyphs of [`Text`] among the many small things: made ready in groups, drawn as
//! [rectangles](crate::cpu::raster::glyph) where they stand upright, else as two triangles.

use nalgebra::{Point3, Vector3};
use rcs_scene::{Aabb, Drawable, Glyph, Text};

use super::reach::{place_box, Placement};
use super::{BatchPiece, BatchView, InstanceContext, InstanceScratch, Instances, Placed, Source, Vertices};
use crate::cpu::raster::glyph::{are_upright, GlyphRect, Ink, Line, Place, Placer};
use crate::cpu::tile::band::Band;
use crate::cpu::tile::screen::Screen;

/// Glyphs that are sieved together.
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
            Source { vertices: Vertices::Text(text), material: text.material(), transform: &transform, surface };
        scratch.begin();
        let range = piece.range.clone();
        let (batch, item) = (piece.batch as u32, range.start as u32);
        let placer = are_upright(surface, &transform).then(|| Placer::new(text, &transform, screen));
        let (first, first_rect) = (self.next, self.rects.len());
        if placer.is_some() {
            self.rects.resize(first_rect + range.len(), GlyphRect::NONE);
        }
        let (mut is_seen, mut has_triangles) = (false, false);
        for begin in range.clone().step_by(GLYPHS_IN_GROUP) {
            let group = begin..range.end.min(begin + GLYPHS_IN_GROUP);
            let glyphs = text.glyphs().get(group.clone()).unwrap_or(&[]);
            let bounds = bounds_of_glyphs(glyphs, text.height_m());
            if place_box(&bounds, &transform.clip_from_object, screen) == Placement::Unseen {
                continue;
            }
            for (glyph, placed) in group.zip(glyphs) {
                let index = glyph - range.start;
                let number = first + 2 * index as u32;
                match placer.as_ref().map(|placer| placer.place(placed)) {
                    Some(Place::Unseen) => continue,
                    Some(Place::Seen(rect)) => {
                        self.add_rect(number, first_rect + index, rect, screen);
                        is_seen = true;
                        continue;
                    }
                    Some(Place::Cut) | None => {}
                }
                for (number, corners) in (number..).zip(glyph_triangles(glyph as u32)) {
                    has_triangles |= self.add_triangle(number, corners, &source, screen, scratch);
                }
            }
        }
        if !is_seen && !has_triangles {
            self.rects.truncate(first_rect);
            return;
        }
        let color = source.vertex(4 * item).map_or([1.0; 4], |vertex| source.color(&vertex));
        let upright = placer.map(|placer| {
            self.upright.push(UprightText { first_rect: first_rect as u32, line: placer.line(color), is_on_top });
            self.upright.len() as u32 - 1
        });
        let transform = has_triangles.then(|| self.keep(transform));
        self.placed.push(Placed { first, batch, item, may_be_cut: true, transform, upright });
        self.next += 2 * range.len() as u32;
    }

    /// Makes a glyph ready, under the number of the first of its triangles.
    fn add_rect(&mut self, number: u32, place: usize, rect: GlyphRect, screen: &Screen) {
        let (begin, end) = rect.rows();
        self.bin(number, begin, end, screen);
        if let Some(place) = self.rects.get_mut(place) {
            *place = rect;
        }
    }

    /// What draws the glyphs of a text that stand upright.
    pub(super) fn upright_glyphs<'s>(&'s self, placed: &Placed, view: &'s BatchView<'_>) -> Option<UprightGlyphs<'s>> {
        let text = self.upright.get(placed.upright? as usize)?;
        let ink = Ink::new(view.surface_of_texts(text.is_on_top)?, text.line)?;
        Some(UprightGlyphs { ink, rects: self.rects.get(text.first_rect as usize..)? })
    }
}

/// A text, or a part of one, whose glyphs stand upright.
#[derive(Clone, Copy, Debug)]
pub(in crate::cpu) struct UprightText {
    /// Index of its first glyph's rectangle.
    first_rect: u32,
    line: Line,
    is_on_top: bool,
}

/// The glyphs of an [`UprightText`].
pub(in crate::cpu) struct UprightGlyphs<'a> {
    ink: Ink<'a>,
    rects: &'a [GlyphRect],
}

impl UprightGlyphs<'_> {
    /// Draws a band's rows of the glyph that begins with a triangle, if it has not to be cut; says whether it did.
    #[inline]
    pub(in crate::cpu) fn draw(&self, triangle: u32, band: &mut Band<'_>) -> bool {
        let rect = self.rects.get(triangle as usize / 2).filter(|rect| rect.is_some());
        if let Some(rect) = rect {
            rect.draw(&self.ink, band);
        }
        rect.is_some()
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
