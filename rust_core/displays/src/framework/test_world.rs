//! The world in which displays are tested: frames, a time, and no packages.

use rcs_resources::{MeshStore, PackageIndex};
use rcs_transforms::{RawTransform, Time, TransformTree};

use crate::World;

/// What a [`World`] borrows.
#[derive(Debug)]
pub(crate) struct TestWorld {
    pub(crate) tree: TransformTree,
    pub(crate) now: Time,
    fixed_frame: &'static str,
    meshes: MeshStore,
}

impl TestWorld {
    /// One without frames, in which `map` is fixed.
    pub(crate) fn at(now: Time) -> Self {
        Self::fixed_in("map", now)
    }

    /// One without frames, in which another frame is fixed.
    pub(crate) fn fixed_in(fixed_frame: &'static str, now: Time) -> Self {
        Self { tree: TransformTree::new(), now, fixed_frame, meshes: MeshStore::new(PackageIndex::new([])) }
    }

    /// The world as displays see it.
    pub(crate) fn get(&self) -> World<'_> {
        World { transforms: &self.tree, fixed_frame: self.fixed_frame, now: self.now, meshes: &self.meshes }
    }

    /// Inserts where a frame stood at a time in the fixed frame, from which it is not turned.
    pub(crate) fn place(&mut self, child: &str, stamp: Time, translation: [f64; 3]) {
        self.insert(child, stamp, translation, false);
    }

    /// Inserts where a frame always stands in the fixed frame, from which it is not turned.
    pub(crate) fn place_static(&mut self, child: &str, translation: [f64; 3]) {
        self.insert(child, Time::ZERO, translation, true);
    }

    fn insert(&mut self, child: &str, stamp: Time, translation: [f64; 3], is_static: bool) {
        let rotation_xyzw = [0.0, 0.0, 0.0, 1.0];
        let transform = RawTransform { parent: self.fixed_frame, child, stamp, translation, rotation_xyzw };
        self.tree.insert(&transform, is_static, "/test").unwrap();
    }
}
