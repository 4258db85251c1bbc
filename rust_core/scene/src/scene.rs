//! A scene: drawables in the fixed frame, and the light on them.

use std::sync::Arc;

use nalgebra::{Matrix4, Point3, Vector3};

use crate::{Blending, CellSheet, Lines, Material, Mesh, PackedPoints, Points, Ribbons, Solids, Text};

/// Number of a display: its index in the config's tree order.
pub type DisplayId = u32;

/// Displays that a camera shows (its "Visibility" property).
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct DisplayMask {
    hidden: Vec<bool>,
}

impl DisplayMask {
    /// All displays are shown.
    pub fn all() -> Self {
        Self::default()
    }

    /// Hides or shows a display.
    pub fn set(&mut self, display: DisplayId, shown: bool) {
        let index = display as usize;
        if index >= self.hidden.len() {
            self.hidden.resize(index + 1, false);
        }
        self.hidden[index] = !shown;
    }

    /// `true` if a display is shown; one that was never set is.
    pub fn shows(&self, display: DisplayId) -> bool {
        !self.hidden.get(display as usize).copied().unwrap_or(false)
    }
}

/// Groups that are drawn one after another, whatever the depths in them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub enum RenderGroup {
    /// Before everything else (a Map's "Draw Behind").
    Behind,
    /// Nearly everything.
    #[default]
    Main,
    /// After everything else (overlays of interactive markers).
    Above,
}

/// The geometry of a drawable with its material.
#[derive(Clone, Debug)]
pub enum Geometry {
    /// A point cloud.
    Points(Points),
    /// A point cloud in the bytes of its message.
    Packed(Arc<PackedPoints>),
    /// Lines of one pixel.
    Lines(Arc<Lines>),
    /// Wide lines that turn to the eye.
    Ribbons(Arc<Ribbons>),
    /// Triangles.
    Mesh {
        /// The triangles.
        mesh: Arc<Mesh>,
        /// How they are coloured.
        material: Arc<Material>,
    },
    /// Many lit meshes, each at its own place in the fixed frame and sorted by its own origin: their drawable's matrix
    /// and sort point do not count.
    Solids(Arc<Solids>),
    /// Text that turns to the eye.
    Text(Arc<Text>),
    /// Cells coloured by a palette.
    Cells(CellSheet),
    /// Drawables that turn to the camera together; [`Scene::seen_from`] replaces the group by them.
    Facing(Arc<Facing>),
}

impl Geometry {
    /// `true` if it is drawn with the translucent drawables: after the opaque ones of its group, sorted from far to
    /// near. Ogre's rule: it blends, and does not write depth or does not test it. Solids are sorted one by one, see
    /// [`Solid::is_translucent`](crate::Solid::is_translucent).
    pub fn is_translucent(&self) -> bool {
        match self {
            Self::Points(points) => points.blended,
            Self::Packed(points) => points.look().blended,
            Self::Lines(lines) => lines.blending == Blending::Alpha,
            Self::Ribbons(ribbons) => ribbons.blending == Blending::Alpha,
            Self::Mesh { material, .. } => {
                material.blending == Blending::Alpha && (!material.depth_write || !material.depth_test)
            }
            Self::Text(_) => true,
            Self::Cells(sheet) => sheet.blending == Blending::Alpha && !sheet.depth_write,
            Self::Solids(_) | Self::Facing(_) => false,
        }
    }
}

/// A group that turns about its origin, which is that of its drawable; that drawable's rotation does not count.
#[derive(Clone, Debug)]
pub struct Facing {
    /// Direction in the group's frame that is turned away from the camera.
    pub forward: Vector3<f64>,
    /// Direction in the group's frame, perpendicular to `forward`, that is turned up on the image.
    pub up: Vector3<f64>,
    /// Drawables of the group.
    pub parts: Vec<FacingPart>,
}

/// One drawable of a group.
#[derive(Clone, Debug)]
pub struct FacingPart {
    /// Takes the geometry to the group's frame.
    pub group_from_part: Matrix4<f64>,
    /// Like [`Drawable::sort_point`], in the fixed frame; `None` for the part's origin, wherever that turns.
    pub sort_point: Option<Point3<f64>>,
    /// Geometry; a group within a group is not drawn.
    pub geometry: Geometry,
}

/// A geometry at its place in the scene.
#[derive(Clone, Debug)]
pub struct Drawable {
    /// The display that made it.
    pub display: DisplayId,
    /// From the geometry's own frame to the fixed frame; affine, and may scale.
    pub fixed_from_object: Matrix4<f64>,
    /// Point in the fixed frame by whose distance to the eye translucent drawables are sorted. Mostly the object's
    /// origin; Ogre takes other points for clouds and chains.
    pub sort_point: Point3<f64>,
    /// Its place in the order of drawing.
    pub group: RenderGroup,
    /// Its shape and material.
    pub geometry: Geometry,
}

/// Light from one direction, white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectionalLight {
    /// Unit vector along which the light travels, in the fixed frame.
    pub direction: Vector3<f64>,
}

/// Drawables and the light on them. Those of equal depth are drawn in this order, the later one wins.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// In the order of the displays, and within one in the order in which it made them.
    pub drawables: Vec<Drawable>,
    /// rviz's default light, which follows the camera of its main window; `None` when it is switched off.
    pub light: Option<DirectionalLight>,
}
