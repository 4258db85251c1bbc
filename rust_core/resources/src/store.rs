//! Meshes and textures by address, each loaded once.
//!
//! Like rviz, the store keeps loaded meshes, except that in the background large ones that nothing uses any more are
//! dropped when something new is loaded. A failure is kept too, so a marker that is published ten times a second does
//! not read a broken file at each message: the file is read again when a message names it and it has changed, and after
//! a reload of the config.
//!
//! A store loads either on the calling thread, for images of bags, which must not depend on the speed of reading; or in
//! the background: a request then returns `Pending`, and the store's waker is called when the resource is loaded. The
//! loader threads run at a low priority.

use std::{
    collections::HashMap,
    fmt, mem,
    sync::{
        atomic::{AtomicU64, Ordering},
        Arc, Condvar, Mutex, MutexGuard,
    },
    task::Poll,
    thread,
};

use rayon::{
    iter::{IntoParallelRefIterator, ParallelIterator},
    ThreadPool, ThreadPoolBuilder,
};
use rcs_process::{lock, wait_while};
use rcs_scene::Texture;

use crate::{
    files::FileStamp,
    loader::{Loader, Outcome, Resource, ResourceKey, ResourceKind},
    LoadedMesh, PackageIndex, ResourceError, ResourceOptions,
};

/// Most resources that are kept. At the limit, all that nothing uses are dropped.
const MAX_RESOURCES: usize = 4096;
/// Most loader threads.
const MAX_THREADS: usize = 4;
/// Size of a large resource, which is dropped when nothing uses it any more and something new is loaded.
const LARGE_BYTES: usize = 4 << 20;
/// Niceness of the loader threads.
const NICENESS: i32 = 10;

/// Handling of a resource that failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Retry {
    /// Check the file again, because a new message names it.
    Yes,
    /// Return the known failure.
    No,
}

/// A cache of meshes and textures. Threads can share it: a request for a mesh that another thread is loading waits for
/// that mesh only.
///
/// ```
/// use std::task::Poll;
///
/// use rcs_resources::{MeshStore, PackageIndex, ResourceError, Retry};
///
/// // A store that loads on the calling thread.
/// let store = MeshStore::new(PackageIndex::from_env(&[]));
/// match store.mesh("package://no_such_package/arm.stl", Retry::Yes) {
///     Poll::Ready(Ok(mesh)) => println!("{} parts", mesh.parts.len()),
///     Poll::Ready(Err(ResourceError::NoSuchPackage { package, .. })) => assert_eq!(package, "no_such_package"),
///     Poll::Ready(Err(error)) => panic!("{error}"),
///     Poll::Pending => panic!("only with a store in the background"),
/// }
/// ```
pub struct MeshStore {
    core: Arc<StoreCore>,
    /// Loader threads; `None` if the store loads on the calling thread.
    loaders: Option<ThreadPool>,
}

/// The part of a store that its threads share.
struct StoreCore {
    loader: Loader,
    state: Mutex<StoreState>,
    /// Notified when something was loaded.
    done: Condvar,
    /// Incremented when the result of a request changes.
    version: AtomicU64,
    waker: Box<dyn Fn() + Send + Sync>,
}

#[derive(Default)]
struct StoreState {
    slots: HashMap<ResourceKey, CachedResource>,
    has_ended: bool,
}

/// The state of an address.
#[derive(Default)]
struct CachedResource {
    outcome: Option<Outcome>,
    /// The file's stamp at the failure.
    failed: Option<FileStamp>,
    /// `true` while it waits for a loader thread or is being loaded.
    is_busy: bool,
    /// `true` once a request has returned it.
    is_taken: bool,
}

impl CachedResource {
    /// `true` if nothing uses it.
    fn is_unused(&self) -> bool {
        !self.is_busy && !matches!(&self.outcome, Some(Ok(resource)) if !resource.is_unused())
    }

    /// `true` if it takes much memory and was used.
    fn is_large(&self) -> bool {
        self.is_taken && matches!(&self.outcome, Some(Ok(resource)) if resource.bytes() >= LARGE_BYTES)
    }
}

impl MeshStore {
    /// An empty store that loads on the calling thread, and reads files in packages.
    pub fn new(packages: PackageIndex) -> Self {
        Self::with_options(packages, ResourceOptions::default())
    }

    /// As [`MeshStore::new`], with other limits for files.
    pub fn with_options(packages: PackageIndex, options: ResourceOptions) -> Self {
        Self::create(packages, options, Box::new(|| {}), None)
    }

    /// An empty store that loads in the background and then calls `waker` on the loader thread.
    pub fn in_background(
        packages: PackageIndex,
        options: ResourceOptions,
        waker: impl Fn() + Send + Sync + 'static,
    ) -> Self {
        let threads = thread::available_parallelism().map_or(1, usize::from).clamp(2, MAX_THREADS);
        let loaders = ThreadPoolBuilder::new()
            .thread_name(|_| "mesh-loader".to_owned())
            .num_threads(threads)
            .start_handler(|_| yield_to_others())
            // The panic hook logs it. Without a handler it would end the process.
            .panic_handler(|_| {})
            .build();
        if let Err(error) = &loaders {
            log::warn!("cannot start the mesh loader threads, images wait for meshes: {error}");
        }
        Self::create(packages, options, Box::new(waker), loaders.ok())
    }

    fn create(
        packages: PackageIndex,
        options: ResourceOptions,
        waker: Box<dyn Fn() + Send + Sync>,
        loaders: Option<ThreadPool>,
    ) -> Self {
        let core = StoreCore {
            loader: Loader::new(packages, options),
            state: Mutex::default(),
            done: Condvar::new(),
            version: AtomicU64::new(0),
            waker,
        };
        Self { core: Arc::new(core), loaders }
    }

    /// The index that resolves addresses.
    pub fn packages(&self) -> &PackageIndex {
        &self.core.loader.packages
    }

    /// The mesh at a `package://` or `file://` address; one address gives the same mesh each time. Errors that are not
    /// fatal are logged once, and kept in [`LoadedMesh::warnings`]. Pending while it is being loaded in the background.
    ///
    /// # Errors
    /// Any [`ResourceError`].
    pub fn mesh(&self, url: &str, retry: Retry) -> Poll<Result<Arc<LoadedMesh>, ResourceError>> {
        self.get(ResourceKind::Mesh, url, retry).map_ok(|resource| match resource {
            Resource::Mesh(mesh) => mesh,
            Resource::Texture(_) => Arc::default(),
        })
    }

    /// The image at a `package://` or `file://` address, as with [`MeshStore::mesh`].
    ///
    /// # Errors
    /// Any [`ResourceError`].
    pub fn texture(&self, url: &str, retry: Retry) -> Poll<Result<Arc<Texture>, ResourceError>> {
        self.get(ResourceKind::Texture, url, retry).map_ok(|resource| match resource {
            Resource::Texture(texture) => texture,
            Resource::Mesh(_) => crate::warning_texture(),
        })
    }

    /// Loads meshes in parallel. Unless the store loads in the background, [`MeshStore::mesh`] then returns each of
    /// them, or its error, at once.
    pub fn load_all<'a>(&self, urls: impl IntoIterator<Item = &'a str>, retry: Retry) {
        let mut urls: Vec<&str> = urls.into_iter().collect();
        urls.sort_unstable();
        urls.dedup();
        let load =
            |url: &&str| drop(self.request(&ResourceKey { kind: ResourceKind::Mesh, url: (*url).to_owned() }, retry));
        if self.loaders.is_some() {
            urls.iter().for_each(load);
        } else {
            urls.par_iter().for_each(load);
        }
    }

    /// Faults of the loaded meshes that are not fatal, one line each, sorted by address.
    pub fn warnings(&self) -> Vec<String> {
        let state = lock(&self.core.state);
        let meshes = state.slots.iter().filter_map(|(key, slot)| match &slot.outcome {
            Some(Ok(Resource::Mesh(mesh))) => Some((key, mesh)),
            _ => None,
        });
        let line = |(key, mesh): (&ResourceKey, &Arc<LoadedMesh>)| {
            mesh.warnings.iter().map(|warning| format!("mesh {}: {warning}", key.url)).collect::<Vec<_>>()
        };
        let mut lines: Vec<String> = meshes.flat_map(line).collect();
        lines.sort_unstable();
        lines
    }

    /// A number that changes when a resource was loaded in the background, or failed.
    pub fn version(&self) -> u64 {
        self.core.version.load(Ordering::Acquire)
    }

    /// Forgets all failures, so that those that displays still need are loaded again.
    pub fn retry_failures(&self) {
        self.core.loader.packages.search_again();
        lock(&self.core.state).slots.retain(|_, slot| slot.is_busy || !matches!(slot.outcome, Some(Err(_))));
        self.core.version.fetch_add(1, Ordering::Release);
    }

    fn get(&self, kind: ResourceKind, url: &str, retry: Retry) -> Poll<Outcome> {
        let key = ResourceKey { kind, url: url.to_owned() };
        let mut state = match self.request(&key, retry) {
            Ok(state) => state,
            Err(error) => return Poll::Ready(Err(error)),
        };
        let Some(slot) = state.slots.get_mut(&key) else { return Poll::Pending };
        slot.is_taken = slot.outcome.is_some();
        slot.outcome.clone().map_or(Poll::Pending, Poll::Ready)
    }

    /// Loads a resource unless it is known, or queues it for loading in the background.
    ///
    /// # Errors
    /// [`ResourceError::TooMany`].
    fn request(&self, key: &ResourceKey, retry: Retry) -> Result<MutexGuard<'_, StoreState>, ResourceError> {
        let mut state = lock(&self.core.state);
        let mut unused = Vec::new();
        if !state.slots.contains_key(key) {
            unused = state.take_unused(self.loaders.is_some());
            if state.slots.len() >= MAX_RESOURCES {
                return Err(ResourceError::TooMany { url: key.url.clone(), limit: MAX_RESOURCES });
            }
        }
        let slot = state.slots.entry(key.clone()).or_default();
        let is_wanted = match &slot.outcome {
            None => true,
            Some(Ok(_)) => false,
            Some(Err(_)) => retry == Retry::Yes,
        };
        match &self.loaders {
            _ if !is_wanted || (self.loaders.is_some() && slot.is_busy) => {}
            Some(loaders) => {
                slot.is_busy = true;
                let (core, key) = (Arc::clone(&self.core), key.clone());
                loaders.spawn(move || core.load_in_background(&key, unused));
            }
            None => state = self.core.load_now(state, key),
        }
        Ok(state)
    }
}

impl StoreState {
    /// Removes what nothing uses: large resources if `with_large`, and all if the store is full.
    fn take_unused(&mut self, with_large: bool) -> Vec<CachedResource> {
        let is_full = self.slots.len() >= MAX_RESOURCES;
        let unused = self.slots.extract_if(|_, slot| slot.is_unused() && (is_full || with_large && slot.is_large()));
        unused.map(|(_, slot)| slot).collect()
    }
}

impl StoreCore {
    /// Loads a resource, on a loader thread. Drops `unused` before, because freeing memory takes a while.
    fn load_in_background(&self, key: &ResourceKey, unused: Vec<CachedResource>) {
        drop(unused);
        if !lock(&self.state).has_ended && self.load(key) {
            (self.waker)();
        }
    }

    /// Loads a resource on this thread, or waits for the thread that is loading it.
    fn load_now<'a>(&'a self, mut state: MutexGuard<'a, StoreState>, key: &ResourceKey) -> MutexGuard<'a, StoreState> {
        let Some(slot) = state.slots.get_mut(key) else { return state };
        if mem::replace(&mut slot.is_busy, true) {
            let is_busy = |state: &mut StoreState| state.slots.get(key).is_some_and(|slot| slot.is_busy);
            return wait_while(&self.done, state, is_busy);
        }
        drop(state);
        self.load(key);
        lock(&self.state)
    }

    /// Loads a resource and stores the result. Returns `true` if it differs from the last one.
    fn load(&self, key: &ResourceKey) -> bool {
        let failed = lock(&self.state).slots.get(key).and_then(|slot| slot.failed);
        let loaded = self.loader.load(key, failed);
        let mut state = lock(&self.state);
        let Some(slot) = state.slots.get_mut(key) else { return false };
        slot.is_busy = false;
        let mut has_changed = false;
        if let Some((outcome, stamp)) = loaded {
            let text = |outcome: &Outcome| outcome.as_ref().err().map(ToString::to_string);
            has_changed = slot.outcome.as_ref().map(text) != Some(text(&outcome));
            slot.failed = stamp.filter(|_| outcome.is_err());
            slot.outcome = Some(outcome);
        }
        if has_changed {
            self.version.fetch_add(1, Ordering::Release);
        }
        drop(state);
        self.done.notify_all();
        has_changed
    }
}

/// Lowers the priority of the calling thread for the rest of its life.
pub fn yield_to_others() {
    if let Err(error) = rustix::process::setpriority_process(Some(rustix::thread::gettid()), NICENESS) {
        log::debug!("cannot lower the priority of a background thread: {error}");
    }
}

impl Drop for MeshStore {
    /// Ends the loader threads after their current files, without waiting.
    fn drop(&mut self) {
        lock(&self.core.state).has_ended = true;
    }
}

impl fmt::Debug for MeshStore {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("MeshStore")
            .field("loader", &self.core.loader)
            .field("is_background", &self.loaders.is_some())
            .field("resources", &lock(&self.core.state).slots.len())
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use rcs_scene::{Mesh, Vertex};

    use super::*;
    use crate::{MeshMaterial, MeshPart};

    /// A slot with a mesh of `vertices` vertices.
    fn slot(vertices: usize) -> CachedResource {
        let mesh = Mesh { vertices: vec![Vertex::new([0.0; 3], [0.0; 3]); vertices], indices: Vec::new() };
        let part = MeshPart { mesh: Arc::new(mesh), material: MeshMaterial::none() };
        let mesh = LoadedMesh { parts: vec![part], warnings: Vec::new() };
        CachedResource {
            outcome: Some(Ok(Resource::Mesh(Arc::new(mesh)))),
            is_taken: true,
            ..CachedResource::default()
        }
    }

    fn key(url: &str) -> ResourceKey {
        ResourceKey { kind: ResourceKind::Mesh, url: url.to_owned() }
    }

    fn mesh(state: &StoreState, url: &str) -> Arc<LoadedMesh> {
        match &state.slots[&key(url)].outcome {
            Some(Ok(Resource::Mesh(mesh))) => Arc::clone(mesh),
            other => panic!("{other:?}"),
        }
    }

    fn left(state: &StoreState) -> Vec<&str> {
        let mut left: Vec<&str> = state.slots.keys().map(|key| key.url.as_str()).collect();
        left.sort_unstable();
        left
    }

    #[test]
    fn large_resources_that_nothing_uses_are_dropped_and_small_ones_when_the_store_is_full() {
        let large = LARGE_BYTES / size_of::<Vertex>() + 1;
        let mut state = StoreState::default();
        for url in ["unused", "used", "part", "new"] {
            state.slots.insert(key(url), slot(large));
        }
        for url in ["small", "small in use", "busy"] {
            state.slots.insert(key(url), slot(8));
        }
        state.slots.get_mut(&key("busy")).unwrap().is_busy = true;
        state.slots.get_mut(&key("new")).unwrap().is_taken = false;
        let used = (mesh(&state, "used"), mesh(&state, "small in use"));
        let part = Arc::clone(&mesh(&state, "part").parts[0].mesh);
        assert!(state.take_unused(false).is_empty());
        assert_eq!(state.take_unused(true).len(), 1);
        assert_eq!(left(&state), ["busy", "new", "part", "small", "small in use", "used"]);
        state.slots.extend((state.slots.len()..MAX_RESOURCES).map(|i| (key(&i.to_string()), slot(8))));
        assert_eq!(state.take_unused(false).len(), MAX_RESOURCES - 4);
        assert_eq!(left(&state), ["busy", "part", "small in use", "used"]);
        drop((used, part));
        assert_eq!(state.take_unused(true).len(), 2);
        assert_eq!(left(&state), ["busy", "small in use"]);
    }
}
