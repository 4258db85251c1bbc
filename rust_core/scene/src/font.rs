//! The glyphs that text is drawn with.
//!
//! rviz draws text with an Ogre font: Liberation Sans, rendered once at 18 pt and 96 dpi (24 pixels to the em) with
//! hinting into one texture, every glyph in a cell of equal height and of the width of its advance. The same cells
//! are made here from the same typeface, for the code points 0 to 999 that rviz asks for. Around the glyphs the texture
//! is black and transparent, so that interpolation darkens their outlines a little, as in rviz.
//!
//! The releases of that typeface differ a little in their hints. So that text is the same as in the rviz of the same
//! machine, rviz's font file is used where there is one, and a built-in release elsewhere.

use std::io::Read as _;
use std::sync::{Arc, OnceLock};

use ab_glyph_rasterizer::{point, Point, Rasterizer};
use skrifa::instance::{LocationRef, Size};
use skrifa::outline::{DrawSettings, HintingInstance, HintingOptions, OutlineGlyphCollection, OutlinePen};
use skrifa::{FontRef, GlyphId, MetadataProvider};

use crate::{Filtering, Texture, Wrapping};

/// Code points below this have a glyph.
const GLYPH_COUNT: u32 = 1000;

const EM_PX: f32 = 24.0;
const ATLAS_WIDTH_PX: u32 = 1024;
const SPACING_PX: u32 = 1;
/// Bytes read of a font's file at most.
const MOST_FONT_BYTES: u64 = 64 << 20;

/// Paths of rviz's font: in ROS installations, and on Debian, whose rviz uses the system's.
const RVIZ_FONTS: [&str; 5] = [
    "/opt/ros/one/share/rviz/ogre_media/fonts/liberation-sans/LiberationSans-Regular.ttf",
    "/opt/ros/noetic/share/rviz/ogre_media/fonts/liberation-sans/LiberationSans-Regular.ttf",
    "/opt/ros/melodic/share/rviz/ogre_media/fonts/liberation-sans/LiberationSans-Regular.ttf",
    "/usr/share/rviz/ogre_media/fonts/liberation-sans/LiberationSans-Regular.ttf",
    "/usr/share/fonts/truetype/liberation/LiberationSans-Regular.ttf",
];

/// Height of the cells and of the baseline below their top.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct GlyphCell {
    height_px: u32,
    baseline_px: i32,
}

/// The cells that rviz gets from release 1 of the typeface. The built-in release 2 has a few taller letters, which are
/// cut, so that text has the same size.
const BUILT_IN_CELL: GlyphCell = GlyphCell { height_px: 28, baseline_px: 24 };

pub(crate) static FONT: &[u8] = include_bytes!("../assets/LiberationSans-Regular.ttf");

/// Cell of a glyph in the atlas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlyphBox {
    /// Texture coordinates of the cell's left, top, right and bottom edge.
    pub uv: [f32; 4],
    /// Width of the cell over its height.
    pub aspect: f32,
}

/// All glyphs in one texture: white with the coverage as alpha, black and transparent around them.
#[derive(Debug)]
pub struct GlyphAtlas {
    texture: Arc<Texture>,
    /// By code point.
    boxes: Vec<Option<GlyphBox>>,
}

impl GlyphAtlas {
    /// The texture.
    pub fn texture(&self) -> &Arc<Texture> {
        &self.texture
    }

    /// The cell of a character; `None` where rviz has no glyph for it either.
    pub fn glyph(&self, character: char) -> Option<GlyphBox> {
        self.boxes.get(character as usize).copied().flatten()
    }
}

/// The atlas, made at its first use.
pub fn glyph_atlas() -> &'static GlyphAtlas {
    static ATLAS: OnceLock<GlyphAtlas> = OnceLock::new();
    ATLAS.get_or_init(|| {
        let rvizs = RVIZ_FONTS.iter().filter_map(|file| build(&read(file).ok()?, None)).next();
        rvizs.or_else(|| build(FONT, Some(BUILT_IN_CELL))).unwrap_or_else(|| pack(&[], BUILT_IN_CELL))
    })
}

/// The contents of a font's file, cut at [`MOST_FONT_BYTES`].
fn read(file: &str) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    std::fs::File::open(file)?.take(MOST_FONT_BYTES).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// A glyph's coverage, in pixels to the right of its origin and below its baseline.
pub(crate) struct Bitmap {
    pub(crate) left_px: i32,
    pub(crate) top_px: i32,
    pub(crate) width_px: u32,
    pub(crate) height_px: u32,
    pub(crate) coverage: Vec<u8>,
}

struct Glyph {
    character: char,
    advance_px: u32,
    bitmap: Bitmap,
}

/// The atlas of a font file; `None` for an invalid one. Without a given cell, it follows from the glyphs as in Ogre.
fn build(file: &[u8], cell: Option<GlyphCell>) -> Option<GlyphAtlas> {
    let font = FontRef::new(file).ok()?;
    let outlines = font.outline_glyphs();
    let size = Size::new(EM_PX);
    let hinting = HintingInstance::new(&outlines, size, LocationRef::default(), HintingOptions::default()).ok()?;
    let charmap = font.charmap();
    let metrics = font.glyph_metrics(size, LocationRef::default());
    let glyphs: Vec<Glyph> = (0..GLYPH_COUNT)
        .filter_map(char::from_u32)
        .filter_map(|character| {
            let id = charmap.map(character).unwrap_or(GlyphId::NOTDEF);
            let bitmap = rasterize(&outlines, DrawSettings::hinted(&hinting, false), id)?;
            let advance_px = metrics.advance_width(id)?.round().max(0.0) as u32;
            Some(Glyph { character, advance_px, bitmap })
        })
        .collect();
    Some(pack(&glyphs, cell.unwrap_or_else(|| cell_of(&glyphs))))
}

/// Ogre's rule: the cell is high enough for the glyph whose height and depth below the baseline are the most.
fn cell_of(glyphs: &[Glyph]) -> GlyphCell {
    let height = glyphs.iter().map(|glyph| 2 * glyph.bitmap.height_px as i32 + glyph.bitmap.top_px).max();
    let baseline = glyphs.iter().map(|glyph| -glyph.bitmap.top_px).max();
    GlyphCell { height_px: height.unwrap_or(0).max(1) as u32, baseline_px: baseline.unwrap_or(0) }
}

/// Ogre's layout: glyphs stand in rows in the order of their code.
fn pack(glyphs: &[Glyph], cell: GlyphCell) -> GlyphAtlas {
    let cell_height = cell.height_px;
    let mut places = Vec::with_capacity(glyphs.len());
    let (mut x, mut y) = (0, 0);
    for glyph in glyphs {
        if x + glyph.advance_px + 1 > ATLAS_WIDTH_PX {
            (x, y) = (0, y + cell_height + SPACING_PX);
        }
        places.push((x, y));
        x += glyph.advance_px + SPACING_PX;
    }
    let height = y + 2 * cell_height + SPACING_PX;
    let mut rgba = vec![[0; 4]; (ATLAS_WIDTH_PX * height) as usize];
    let mut boxes = vec![None; GLYPH_COUNT as usize];
    for (glyph, (x, y)) in glyphs.iter().zip(places) {
        let bitmap = &glyph.bitmap;
        for row in 0..bitmap.height_px {
            for column in 0..bitmap.width_px {
                let cell_x = bitmap.left_px.max(0) + column as i32 + bitmap.left_px.min(0);
                let cell_y = cell.baseline_px + bitmap.top_px + row as i32;
                if (0..glyph.advance_px as i32).contains(&cell_x) && (0..cell_height as i32).contains(&cell_y) {
                    let texel = (y + cell_y as u32) * ATLAS_WIDTH_PX + x + cell_x as u32;
                    if let Some(texel) = rgba.get_mut(texel as usize) {
                        *texel = [255, 255, 255, bitmap.coverage[(row * bitmap.width_px + column) as usize]];
                    }
                }
            }
        }
        let (u, v) = (1.0 / ATLAS_WIDTH_PX as f32, 1.0 / height as f32);
        let uv = [x as f32 * u, y as f32 * v, (x + glyph.advance_px) as f32 * u, (y + cell_height) as f32 * v];
        let aspect = glyph.advance_px as f32 / cell_height as f32;
        if let Some(place) = boxes.get_mut(glyph.character as usize) {
            *place = Some(GlyphBox { uv, aspect });
        }
    }
    GlyphAtlas {
        texture: Arc::new(Texture {
            width: ATLAS_WIDTH_PX,
            height,
            rgba,
            filtering: Filtering::Bilinear,
            wrapping: Wrapping::Clamp,
        }),
        boxes,
    }
}

pub(crate) fn rasterize(
    outlines: &OutlineGlyphCollection<'_>,
    settings: DrawSettings<'_>,
    id: GlyphId,
) -> Option<Bitmap> {
    let mut path = Path::default();
    outlines.get(id)?.draw(settings, &mut path).ok()?;
    let bounds = |axis: fn(&Point) -> f32| {
        let low = path.points().map(|p| axis(&p)).fold(f32::INFINITY, f32::min);
        let high = path.points().map(|p| axis(&p)).fold(f32::NEG_INFINITY, f32::max);
        if low <= high {
            (low.floor() as i32, high.ceil() as i32)
        } else {
            (0, 0)
        }
    };
    let ((left, right), (bottom, top)) = (bounds(|p| p.x), bounds(|p| p.y));
    let (width, height) = ((right - left) as usize, (top - bottom) as usize);
    let mut raster = Rasterizer::new(width, height);
    let place = |p: Point| point(p.x - left as f32, top as f32 - p.y);
    for segment in &path.segments {
        match *segment {
            Segment::Line(a, b) => raster.draw_line(place(a), place(b)),
            Segment::Quad(a, b, c) => raster.draw_quad(place(a), place(b), place(c)),
            Segment::Cubic(a, b, c, d) => raster.draw_cubic(place(a), place(b), place(c), place(d)),
        }
    }
    let mut coverage = vec![0; width * height];
    raster.for_each_pixel(|i, value| coverage[i] = (value.clamp(0.0, 1.0) * 255.0).round() as u8);
    Some(Bitmap { left_px: left, top_px: -top, width_px: width as u32, height_px: height as u32, coverage })
}

enum Segment {
    Line(Point, Point),
    Quad(Point, Point, Point),
    Cubic(Point, Point, Point, Point),
}

/// An outline as segments in pixels, y up.
#[derive(Default)]
struct Path {
    segments: Vec<Segment>,
    start: Point,
    here: Point,
}

impl Path {
    fn points(&self) -> impl Iterator<Item = Point> + '_ {
        self.segments.iter().flat_map(|segment| match *segment {
            Segment::Line(a, b) => [a, b, a, b],
            Segment::Quad(a, b, c) => [a, b, c, c],
            Segment::Cubic(a, b, c, d) => [a, b, c, d],
        })
    }
}

impl OutlinePen for Path {
    fn move_to(&mut self, x: f32, y: f32) {
        self.start = point(x, y);
        self.here = self.start;
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.segments.push(Segment::Line(self.here, point(x, y)));
        self.here = point(x, y);
    }

    fn quad_to(&mut self, cx: f32, cy: f32, x: f32, y: f32) {
        self.segments.push(Segment::Quad(self.here, point(cx, cy), point(x, y)));
        self.here = point(x, y);
    }

    fn curve_to(&mut self, ax: f32, ay: f32, bx: f32, by: f32, x: f32, y: f32) {
        self.segments.push(Segment::Cubic(self.here, point(ax, ay), point(bx, by), point(x, y)));
        self.here = point(x, y);
    }

    fn close(&mut self) {
        self.segments.push(Segment::Line(self.here, self.start));
        self.here = self.start;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_have_boxes_of_their_advance_inside_the_atlas() {
        for atlas in [glyph_atlas(), &build(FONT, Some(BUILT_IN_CELL)).unwrap(), &build(FONT, None).unwrap()] {
            check_boxes(atlas);
        }
        assert!(build(b"no font", None).is_none());
    }

    fn check_boxes(atlas: &GlyphAtlas) {
        let [m, i] = ['m', 'i'].map(|c| atlas.glyph(c).unwrap());
        assert!(m.aspect > 3.0 * i.aspect, "{m:?} {i:?}");
        for code in (0..GLYPH_COUNT).filter_map(char::from_u32) {
            let uv = atlas.glyph(code).unwrap().uv;
            assert!(uv.iter().all(|c| (0.0..=1.0).contains(c)), "{code:?} {uv:?}");
        }
        assert_eq!(atlas.glyph('世'), None);
    }

    #[test]
    fn a_letter_is_inked_and_a_space_is_not() {
        let atlas = glyph_atlas();
        let ink = |c: char| {
            let GlyphBox { uv: [left, top, right, bottom], .. } = atlas.glyph(c).unwrap();
            let texture = atlas.texture();
            let (w, h) = (texture.width as f32, texture.height as f32);
            let mut sum = 0_u32;
            for y in (top * h).round() as u32..(bottom * h).round() as u32 {
                for x in (left * w).round() as u32..(right * w).round() as u32 {
                    sum += u32::from(texture.rgba[(y * texture.width + x) as usize][3]);
                }
            }
            sum
        };
        assert_eq!(ink(' '), 0);
        assert!(ink('H') > 255 * 40);
    }
}
