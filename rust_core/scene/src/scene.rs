//! A scene: what is drawn, in the fixed frame, and the light on it.

use std::sync::Arc;

use nalgebra::{Matrix4, Point3, Vector3};

use crate::{Blending, CellSheet, Facing, Lines, Material, Mesh, Points, Ribbons, Solids, Text};

/// Which display a drawable came from: its index in the config's tree order.
pub type DisplayId = u32;

/// Which displays a camera shows (its "Visibility" property).
///
/// ```
/// use rcs_scene::DisplayMask;
///
/// let mut visible = DisplayMask::all();
/// visible.set(3, false);
/// assert!(visible.shows(0) && !visible.shows(3));
/// ```
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

    /// Whether a display is shown; one that was never set is.
    pub fn shows(&self, display: DisplayId) -> bool {
        !self.hidden.get(display as usize).copied().unwrap_or(false)
    }
}

/// The order of drawing: groups are drawn one after another, whatever the depths in them.
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
    /// Whether it goes with the translucent drawables: those come after the opaque ones of their group, sorted from
    /// far to near. Ogre's rule: it blends, and does not write depth or does not test it. Each of several solids has a
    /// place of its own; [`Solid::is_translucent`](crate::Solid::is_translucent) says which.
    pub fn is_translucent(&self) -> bool {
        match self {
            Self::Points(points) => points.blended,
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

/// One thing to draw.
#[derive(Clone, Debug)]
pub struct Drawable {
    /// Whose it is.
    pub display: DisplayId,
    /// From the geometry's own frame to the fixed frame; affine, and may scale.
    pub fixed_from_object: Matrix4<f64>,
    /// By whose distance to the eye translucent drawables are sorted, in the fixed frame. Mostly the object's origin;
    /// Ogre takes other points for clouds and chains.
    pub sort_point: Point3<f64>,
    /// When it is drawn.
    pub group: RenderGroup,
    /// What is drawn.
    pub geometry: Geometry,
}

/// Light from one direction, white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectionalLight {
    /// Unit vector along which the light travels, in the fixed frame.
    pub direction: Vector3<f64>,
}

/// What is drawn and the light on it. Drawables of equal depth are drawn in this order, the later one wins.
///
/// ```
/// use std::sync::Arc;
///
/// use nalgebra::{Matrix4, Point3, Vector3};
/// use rcs_scene::{Drawable, Geometry, Material, Mesh, RenderGroup, Rgba, Scene, Vertex};
///
/// let corner = |x, y| Vertex::new([x, y, 0.0], [0.0, 0.0, 1.0]);
/// let mesh = Mesh { vertices: vec![corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0)], indices: vec![0, 1, 2] };
/// let place = Vector3::new(0.0, 0.0, 2.0);
/// let triangle = Drawable {
///     display: 0,
///     fixed_from_object: Matrix4::new_translation(&place),
///     sort_point: Point3::from(place),
///     group: RenderGroup::Main,
///     geometry: Geometry::Mesh { mesh: Arc::new(mesh), material: Arc::new(Material::lit(Rgba::WHITE)) },
/// };
/// assert!(!triangle.geometry.is_translucent());
/// let scene = Scene { drawables: vec![triangle], light: None };
/// # assert_eq!(scene.drawables.len(), 1);
/// ```
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// In the order of the displays, and within one in the order in which it made them.
    pub drawables: Vec<Drawable>,
    /// rviz's default light, which follows the camera of its main window; `None` when it is switched off.
    pub light: Option<DirectionalLight>,
}
