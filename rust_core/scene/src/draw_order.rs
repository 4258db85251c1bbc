//! In which order a scene's drawables are drawn.

use std::cmp::Ordering;

use nalgebra::Point3;

use crate::{DisplayMask, Drawable, Geometry, RenderGroup, Scene};

/// The drawables that a camera shows, in the order in which Ogre draws them: by group; in a group the opaque ones in
/// the scene's order, but clouds and cells (which have shaders) after the others; then the translucent ones from far to
/// near (equally far ones in the scene's order), with text, which Ogre takes for infinitely near, at the end.
///
/// A renderer keeps it from picture to picture for its memory.
#[derive(Clone, Debug, Default)]
pub struct DrawOrder {
    keys: Vec<Key>,
}

#[derive(Clone, Copy, Debug)]
struct Key {
    group: RenderGroup,
    is_translucent: bool,
    rank: f64,
    /// Of the drawable in the scene.
    index: usize,
}

impl Key {
    fn of(index: usize, drawable: &Drawable, eye: &Point3<f64>) -> Self {
        let is_translucent = drawable.geometry.is_translucent();
        let rank = match (&drawable.geometry, is_translucent) {
            (Geometry::Points(_) | Geometry::Cells(_), false) => 1.0,
            (_, false) | (Geometry::Text(_), true) => 0.0,
            (_, true) => -(drawable.sort_point - eye).norm_squared(),
        };
        Self { group: drawable.group, is_translucent, rank, index }
    }

    /// No two are equal: the scene's order is the last to decide.
    fn compare(&self, other: &Self) -> Ordering {
        let by_kind = (self.group, self.is_translucent).cmp(&(other.group, other.is_translucent));
        by_kind.then(self.rank.total_cmp(&other.rank)).then(self.index.cmp(&other.index))
    }
}

impl DrawOrder {
    /// Sorts a scene's drawables; `eye` is the camera's position in the fixed frame.
    pub fn sort(&mut self, scene: &Scene, visible: &DisplayMask, eye: &Point3<f64>) {
        self.keys.clear();
        let shown = scene.drawables.iter().enumerate().filter(|(_, drawable)| visible.shows(drawable.display));
        self.keys.extend(shown.map(|(index, drawable)| Key::of(index, drawable, eye)));
        self.keys.sort_unstable_by(Key::compare);
    }

    /// The drawables of the scene that was sorted.
    pub fn of<'s>(&self, scene: &'s Scene) -> impl Iterator<Item = &'s Drawable> + use<'_, 's> {
        self.keys.iter().filter_map(|key| scene.drawables.get(key.index))
    }
}
