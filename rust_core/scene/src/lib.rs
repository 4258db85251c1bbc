//! Scenes, cameras and images, as plain data.
//!
//! A [`Scene`] is a list of [`Drawable`]s in the fixed frame and the light that falls on them; a [`Camera`] sees it.
//! Nothing here knows of messages, topics or a drawing backend: displays fill a scene, a renderer reads it. Geometry is
//! shared by [`std::sync::Arc`], so that a scene is cheap to rebuild for every image and a renderer can keep derived
//! data (such as a GPU buffer) for as long as the geometry lives.
//!
//! Conventions: metres and radians; colours are not gamma-corrected (rviz blends and lights the stored values);
//! `f32` for geometry in an object's own frame, `f64` for where the object stands. The view frame is OpenGL's: x to
//! the right, y up, looking along negative z.
#![forbid(unsafe_code)]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod aabb;
mod camera;
mod cells;
mod color;
mod draw_order;
mod facing;
mod flip;
mod font;
mod image;
mod lettering;
mod lines;
mod material;
mod mesh;
mod mip;
mod packed_points;
mod pixel_map;
mod point_bytes;
mod points;
mod ribbons;
mod scene;
mod solids;
mod text;

pub use aabb::{Aabb, InFrustum};
pub use camera::{require_finite, Camera, CameraError, Intrinsics, FAR_CLIP_M};
pub use cells::{CellSheet, CellTile, Cells, TILE_SIDE, UNSET_CELL};
pub use color::Rgba;
pub use draw_order::{DrawOrder, Ordered};
pub use flip::Flip;
pub use font::{glyph_atlas, GlyphAtlas, GlyphBox};
pub use image::{resize_block, DepthImage, Encoding, Image, PixelOrder, MAX_SIDE_PX};
pub use lettering::{letters, Letter, LETTER_ASCENT_EM, LETTER_DESCENT_EM};
pub use lines::{LineTopology, Lines};
pub use material::{Blending, CullMode, Filtering, Lighting, Material, Texture, Wrapping};
pub use mesh::{Mesh, Vertex};
pub use packed_points::{rainbow, rgb_at, AxisRainbow, PackedColors, PackedPoints, SharedBytes};
pub use pixel_map::{MapRun, PixelMap};
pub use point_bytes::{bytes_at, has_finite_position, PointBytes, PositionLayout, POINTS_PER_SHARE};
pub use points::{PointBuffer, PointColors, PointLook, PointStyle, Points, MAX_POINT_SIZE_PX};
pub use ribbons::{RibbonElement, Ribbons};
pub use scene::{DirectionalLight, DisplayId, DisplayMask, Drawable, Facing, FacingPart, Geometry, RenderGroup, Scene};
pub use solids::{Solid, Solids};
pub use text::{Glyph, HorizontalAlignment, Text, VerticalAlignment};
