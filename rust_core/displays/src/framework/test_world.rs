//! The world in which displays are tested: frames, a time, and no packages. Its meshes are loaded when they are asked
//! for, or in the background when a test lets them.

use std::path::Path;
use std::sync::{Arc, Condvar, Mutex};
use std::time::{Duration, Instant};

use rcs_resources::{MeshStore, PackageIndex, ResourceOptions, Retry};
use rcs_transforms::{RawTransform, Time, TransformTree};

use crate::World;

/// Owner of the parts of a [`World`].
#[derive(Debug)]
pub(crate) struct TestWorld {
    pub(crate) tree: TransformTree,
    pub(crate) now: Time,
    pub(crate) step: Option<usize>,
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
        Self { tree: TransformTree::new(), now, step: None, fixed_frame, meshes: MeshStore::new(PackageIndex::new([])) }
    }

    /// Loads meshes of a folder in the background from now on, but none before the gate is opened.
    pub(crate) fn load_behind_gate(&mut self, folder: &Path) -> Gate {
        let gate = Gate(Arc::default());
        let wait = Arc::clone(&gate.0);
        let waker = move || {
            let (is_open, opened) = &*wait;
            drop(opened.wait_while(is_open.lock().unwrap(), |is_open| !*is_open).unwrap());
        };
        let options = ResourceOptions { folders: vec![folder.to_owned()], ..ResourceOptions::default() };
        self.meshes = MeshStore::in_background(PackageIndex::new([]), options, waker);
        // Each of the threads is busy with calling the waker then.
        let threads = std::thread::available_parallelism().unwrap().get().clamp(2, 4);
        for i in 0..threads {
            assert!(self.meshes.mesh(&format!("http://busy/{i}"), Retry::Yes).is_pending());
        }
        self.wait_for_version(threads as u64);
        gate
    }

    /// Waits until `version` meshes were loaded or failed.
    pub(crate) fn wait_for_version(&self, version: u64) {
        let end = Instant::now() + Duration::from_secs(60);
        while self.meshes.version() < version {
            assert!(Instant::now() < end, "{} of {version}", self.meshes.version());
            std::thread::yield_now();
        }
    }

    /// Number of meshes that were loaded or failed.
    pub(crate) fn version(&self) -> u64 {
        self.meshes.version()
    }

    /// The world as displays see it.
    pub(crate) fn get(&self) -> World<'_> {
        let mut world = World::new(&self.tree, self.fixed_frame, self.now, &self.meshes);
        world.step = self.step;
        world
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

/// Holds up the threads that load meshes until it is opened.
pub(crate) struct Gate(Arc<(Mutex<bool>, Condvar)>);

impl Gate {
    pub(crate) fn open(&self) {
        let (is_open, opened) = &*self.0;
        *is_open.lock().unwrap() = true;
        opened.notify_all();
    }
}

impl Drop for Gate {
    fn drop(&mut self) {
        self.open();
    }
}

/// A text STL file of one triangle.
pub(crate) const STL: &str = "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n\
     endloop\nendfacet\nendsolid\n";
