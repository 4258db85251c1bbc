//! Order in which a scene's drawables are drawn.

use std::cmp::Ordering;
use std::ops::Range;

use nalgebra::Point3;

use crate::{DisplayMask, Drawable, Geometry, RenderGroup, Scene, Solids};

/// The drawables that a camera shows, in the order in which Ogre draws them: by group; in a group the opaque ones in
/// the scene's order, but clouds and cells (which have shaders) after the others; then the translucent ones from far to
/// near (equally far ones in the scene's order), with text, which Ogre takes for infinitely near, at the end.
///
/// Each of [`Solids`] has its own place in that order; consecutive ones are joined. A renderer keeps it from image to
/// image for its memory.
#[derive(Clone, Debug, Default)]
pub struct DrawOrder {
    keys: Vec<Key>,
}

/// A drawable in the order of drawing.
#[derive(Clone, Debug)]
pub struct Ordered<'s> {
    /// The drawable.
    pub drawable: &'s Drawable,
    /// Range of its [`Solids`]; of no meaning for others.
    pub solids: Range<usize>,
}

/// Keys for which memory is always kept.
const RESERVED_KEYS: usize = 4096;

#[derive(Clone, Copy, Debug)]
struct Key {
    rank: f64,
    /// Index of the drawable in the scene.
    index: u32,
    /// The first of its solids.
    first: u32,
    /// Number of its solids.
    count: u32,
    group: RenderGroup,
    is_translucent: bool,
}

impl Key {
    fn of(index: u32, drawable: &Drawable, eye: &Point3<f64>) -> Self {
        let is_translucent = drawable.geometry.is_translucent();
        let rank = match (&drawable.geometry, is_translucent) {
            (Geometry::Points(_) | Geometry::Packed(_) | Geometry::Cells(_), false) => 1.0,
            (_, false) | (Geometry::Text(_), true) => 0.0,
            (_, true) => rank_of_distance(&drawable.sort_point, eye),
        };
        Self { group: drawable.group, is_translucent, rank, index, first: 0, count: 0 }
    }

    /// No two are equal: the scene's order is the last to decide.
    fn compare(&self, other: &Self) -> Ordering {
        let by_kind = (self.group, self.is_translucent).cmp(&(other.group, other.is_translucent));
        let by_place = || (self.index, self.first).cmp(&(other.index, other.first));
        by_kind.then(self.rank.total_cmp(&other.rank)).then_with(by_place)
    }

    /// Takes the solids of another key into this one, where they are the next to be drawn.
    fn join(&mut self, next: &Self) -> bool {
        let is_same = (self.index, self.is_translucent) == (next.index, next.is_translucent);
        let is_next = is_same && next.count > 0 && self.first + self.count == next.first;
        if is_next {
            self.count += next.count;
        }
        is_next
    }
}

/// Rank of a translucent drawable: from far to near.
fn rank_of_distance(sort_point: &Point3<f64>, eye: &Point3<f64>) -> f64 {
    -(sort_point - eye).norm_squared()
}

impl DrawOrder {
    /// Sorts a scene's drawables; `eye` is the camera's position in the fixed frame.
    pub fn sort(&mut self, scene: &Scene, visible: &DisplayMask, eye: &Point3<f64>) {
        // The memory of a much larger scene is given back.
        let used = self.keys.len();
        self.keys.clear();
        if self.keys.capacity() > 4 * used + RESERVED_KEYS {
            self.keys.shrink_to(used);
        }
        let shown = (0..).zip(&scene.drawables).filter(|(_, drawable)| visible.shows(drawable.display));
        for (index, drawable) in shown {
            let key = Key::of(index, drawable, eye);
            match &drawable.geometry {
                Geometry::Solids(solids) => self.add_solids(key, solids, eye),
                _ => self.keys.push(key),
            }
        }
        self.keys.sort_unstable_by(Key::compare);
        self.keys.dedup_by(|next, key| key.join(next));
    }

    /// Adds a key for each translucent solid, and one for all opaque ones that lie side by side.
    fn add_solids(&mut self, key: Key, solids: &Solids, eye: &Point3<f64>) {
        let mut opaque = Key { count: 0, ..key };
        for (first, solid) in (0..).zip(solids.as_slice()) {
            if solid.is_translucent() {
                let rank = rank_of_distance(&solid.sort_point(), eye);
                self.keys.push(Key { is_translucent: true, rank, first, count: 1, ..key });
            } else if opaque.count > 0 && opaque.first + opaque.count == first {
                opaque.count += 1;
            } else {
                self.keys.extend((opaque.count > 0).then_some(opaque));
                opaque = Key { first, count: 1, ..key };
            }
        }
        self.keys.extend((opaque.count > 0).then_some(opaque));
    }

    /// The drawables of the scene that was sorted.
    pub fn of<'s>(&self, scene: &'s Scene) -> impl Iterator<Item = Ordered<'s>> + use<'_, 's> {
        self.keys.iter().filter_map(|key| {
            let drawable = scene.drawables.get(key.index as usize)?;
            Some(Ordered { drawable, solids: key.first as usize..(key.first + key.count) as usize })
        })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use nalgebra::{Matrix4, Vector3};

    use super::*;
    use crate::{Mesh, Rgba};

    fn solids(display: u32, places: &[(f64, f32)]) -> Drawable {
        let (mesh, mut solids) = (Arc::new(Mesh::default()), Solids::default());
        for &(x, alpha) in places {
            let place = Matrix4::new_translation(&Vector3::new(x, 0.0, 0.0));
            assert!(solids.push(&mesh, &place, Rgba::WHITE.with_alpha(alpha)));
        }
        Drawable {
            display,
            fixed_from_object: Matrix4::identity(),
            sort_point: Point3::origin(),
            group: RenderGroup::Main,
            geometry: Geometry::Solids(Arc::new(solids)),
        }
    }

    #[test]
    fn opaque_solids_come_in_runs_and_translucent_ones_of_all_drawables_from_far_to_near() {
        let first = solids(0, &[(1.0, 1.0), (2.0, 1.0), (3.0, 0.5), (4.0, 1.0), (4.0, 0.5), (4.0, 0.5)]);
        let second = solids(1, &[(3.5, 0.5), (9.0, 1.0)]);
        let scene = Scene { drawables: vec![first, second, solids(2, &[(5.0, 0.5)])], light: None };
        let mut visible = DisplayMask::all();
        let mut order = DrawOrder::default();
        let mut runs = |visible: &DisplayMask| {
            order.sort(&scene, visible, &Point3::origin());
            order.of(&scene).map(|next| (next.drawable.display, next.solids)).collect::<Vec<_>>()
        };
        let opaque = [(0, 0..2), (0, 3..4), (1, 1..2)];
        let translucent = [(2, 0..1), (0, 4..6), (1, 0..1), (0, 2..3)];
        assert_eq!(runs(&visible), [&opaque[..], &translucent].concat());
        visible.set(1, false);
        let rest = [opaque[0].clone(), opaque[1].clone()];
        let translucent = [translucent[0].clone(), translucent[1].clone(), translucent[3].clone()];
        assert_eq!(runs(&visible), [&rest[..], &translucent].concat());
    }
}
