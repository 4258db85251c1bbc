//! Meshes and textures by address, each loaded once.
//!
//! Like rviz, the store keeps loaded meshes, except for large ones that are loaded in the background and unused for a
//! while. A failure is kept too, so a marker that is published ten times a second does not read a broken file at each
//! message: the file is read again when it is requested and has changed.
//!
//! A store loads either on the calling thread, for images of bags, which must not depend on the speed of reading; or in
//! the background: a request then returns `Pending`, and the store's waker is called when the resource is loaded. The
//! loader threads start when there is something to load, run at a low priority, and end when idle; the last one stays
//! while a large resource is kept.

use std::{
    collections::HashMap,
    fmt,
    sync::{
        atomic::{AtomicU64, Ordering},
        Arc, Condvar, Mutex, MutexGuard, PoisonError,
    },
    task::Poll,
    thread,
    time::{Duration, Instant},
};

use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use rcs_scene::{lock, wait_timeout, Texture};

use crate::{
    files::FileStamp,
    loader::{Loader, Outcome, Resource, ResourceKey, ResourceKind},
    LoadedMesh, PackageIndex, ResourceError, ResourceOptions,
};

/// Most resources that are kept. At the limit, the least recently requested quarter of the unused ones is dropped.
const MAX_RESOURCES: usize = 4096;
/// Most loader threads.
const MAX_THREADS: usize = 4;
/// Time without work after which a loader thread ends.
const IDLE_TIME: Duration = Duration::from_secs(10);
/// Size of a large resource, which is dropped after [`UNUSED_TIME`], at the next [`IDLE_TIME`].
const LARGE_BYTES: usize = 4 << 20;
const UNUSED_TIME: Duration = Duration::from_secs(30);
/// Shortest time between two checks of a file that failed.
const CHECK_INTERVAL: Duration = Duration::from_millis(500);
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
    is_background: bool,
}

/// The part of a store that its threads share.
struct StoreCore {
    loader: Loader,
    state: Mutex<StoreState>,
    /// Notified when there is something to load, and when the store is dropped.
    work: Condvar,
    /// Notified when something was loaded.
    done: Condvar,
    /// Incremented when the result of a request changes.
    version: AtomicU64,
    waker: Box<dyn Fn() + Send + Sync>,
}

#[derive(Default)]
struct StoreState {
    slots: HashMap<ResourceKey, CachedResource>,
    /// Resources to load in the background, each at most once, with the earliest time.
    queue: Vec<(Instant, ResourceKey)>,
    threads: usize,
    waiting_threads: usize,
    /// Number of requests.
    requests: u64,
    has_ended: bool,
}

/// The state of an address.
#[derive(Default)]
struct CachedResource {
    outcome: Option<Outcome>,
    /// The file's stamp at the failure.
    failed: Option<FileStamp>,
    /// Earliest time of the next check.
    next_check: Option<Instant>,
    /// `true` in the queue and while a thread is loading it.
    is_busy: bool,
    /// Number of the last request.
    last_request: u64,
    /// Time at which a large resource was first found unused.
    unused_since: Option<Instant>,
}

impl CachedResource {
    /// The resource, if it takes much memory.
    fn large(&self) -> Option<&Resource> {
        let loaded = self.outcome.as_ref().and_then(|outcome| outcome.as_ref().ok());
        loaded.filter(|resource| resource.bytes() >= LARGE_BYTES)
    }
}

impl MeshStore {
    /// An empty store that loads on the calling thread, and reads files in packages.
    pub fn new(packages: PackageIndex) -> Self {
        Self::with_options(packages, ResourceOptions::default())
    }

    /// As [`MeshStore::new`], with other limits for files.
    pub fn with_options(packages: PackageIndex, options: ResourceOptions) -> Self {
        Self::create(packages, options, Box::new(|| {}), false)
    }

    /// An empty store that loads in the background and then calls `waker` on the loader thread.
    pub fn in_background(
        packages: PackageIndex,
        options: ResourceOptions,
        waker: impl Fn() + Send + Sync + 'static,
    ) -> Self {
        Self::create(packages, options, Box::new(waker), true)
    }

    fn create(
        packages: PackageIndex,
        options: ResourceOptions,
        waker: Box<dyn Fn() + Send + Sync>,
        is_background: bool,
    ) -> Self {
        let core = StoreCore {
            loader: Loader::new(packages, options),
            state: Mutex::default(),
            work: Condvar::new(),
            done: Condvar::new(),
            version: AtomicU64::new(0),
            waker,
        };
        Self { core: Arc::new(core), is_background }
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
        if self.is_background {
            urls.iter().for_each(|url| drop(self.mesh(url, retry)));
        } else {
            urls.par_iter().for_each(|url| drop(self.mesh(url, retry)));
        }
    }

    /// A number that changes when a resource was loaded in the background, or failed.
    pub fn version(&self) -> u64 {
        self.core.version.load(Ordering::Acquire)
    }

    /// Checks all files and packages that failed again.
    pub fn retry_failures(&self) {
        self.core.loader.packages.search_again();
        let mut state = lock(&self.core.state);
        let failed = |slot: &CachedResource| matches!(slot.outcome, Some(Err(_)));
        let keys: Vec<ResourceKey> =
            state.slots.iter().filter(|(_, slot)| failed(slot)).map(|(key, _)| key.clone()).collect();
        let now = Instant::now();
        state.queue.iter_mut().for_each(|(due, _)| *due = now);
        for key in keys {
            let Some(slot) = state.slots.get_mut(&key) else { continue };
            slot.next_check = None;
            if self.is_background {
                StoreCore::enqueue(&self.core, &mut state, key);
            }
        }
        self.core.work.notify_all();
    }

    fn get(&self, kind: ResourceKind, url: &str, retry: Retry) -> Poll<Outcome> {
        let key = ResourceKey { kind, url: url.to_owned() };
        let mut state = lock(&self.core.state);
        if !state.slots.contains_key(&key) && !state.make_room() {
            return Poll::Ready(Err(ResourceError::TooMany { url: url.to_owned(), limit: MAX_RESOURCES }));
        }
        state.requests += 1;
        let request = state.requests;
        let slot = state.slots.entry(key.clone()).or_default();
        slot.last_request = request;
        slot.unused_since = None;
        let is_wanted = match &slot.outcome {
            None => true,
            Some(Ok(_)) => false,
            Some(Err(_)) => retry == Retry::Yes,
        };
        if is_wanted && self.is_background {
            StoreCore::enqueue(&self.core, &mut state, key.clone());
        } else if is_wanted {
            state = self.core.load_now(state, &key);
        }
        match state.slots.get(&key).and_then(|slot| slot.outcome.clone()) {
            Some(outcome) => Poll::Ready(outcome),
            None => Poll::Pending,
        }
    }
}

impl StoreState {
    /// Makes room for a number of resources if the store is full; `false` if all are in use.
    fn make_room(&mut self) -> bool {
        if self.slots.len() < MAX_RESOURCES {
            return true;
        }
        let is_unused = |slot: &CachedResource| match &slot.outcome {
            _ if slot.is_busy => false,
            Some(Ok(resource)) => resource.is_unused(),
            Some(Err(_)) | None => true,
        };
        let unused = self.slots.iter().filter(|(_, slot)| is_unused(slot));
        let mut requests: Vec<u64> = unused.map(|(_, slot)| slot.last_request).collect();
        requests.sort_unstable();
        let Some(&last) = requests.get(requests.len() / 4) else { return false };
        self.slots.retain(|_, slot| slot.last_request > last || !is_unused(slot));
        true
    }

    /// Removes large resources that are unused for a while; dropping them frees their memory.
    fn take_unused(&mut self, now: Instant) -> Vec<CachedResource> {
        for slot in self.slots.values_mut() {
            let is_unused = !slot.is_busy && slot.large().is_some_and(Resource::is_unused);
            slot.unused_since = is_unused.then(|| slot.unused_since.unwrap_or(now));
        }
        let is_over =
            |slot: &CachedResource| slot.unused_since.is_some_and(|since| now.duration_since(since) >= UNUSED_TIME);
        self.slots.extract_if(|_, slot| is_over(slot)).map(|(_, slot)| slot).collect()
    }

    /// Takes the next due resource out of the queue, or returns its time.
    fn next(&mut self, now: Instant) -> Result<ResourceKey, Option<Instant>> {
        let first = self.queue.iter().enumerate().min_by_key(|(_, (due, _))| *due).map(|(i, (due, _))| (i, *due));
        match first {
            Some((i, due)) if due <= now => Ok(self.queue.remove(i).1),
            first => Err(first.map(|(_, due)| due)),
        }
    }
}

impl StoreCore {
    /// Queues a resource for loading in the background, unless it is queued already.
    fn enqueue(core: &Arc<Self>, state: &mut StoreState, key: ResourceKey) {
        let now = Instant::now();
        let Some(slot) = state.slots.get_mut(&key).filter(|slot| !slot.is_busy) else { return };
        slot.is_busy = true;
        let due = slot.next_check.map_or(now, |next| next.max(now));
        state.queue.push((due, key));
        let threads = thread::available_parallelism().map_or(1, usize::from).clamp(2, MAX_THREADS);
        if state.queue.len() > state.waiting_threads && state.threads < threads {
            let own = Arc::clone(core);
            match thread::Builder::new().name("mesh-loader".to_owned()).spawn(move || own.run()) {
                Ok(_) => state.threads += 1,
                Err(error) => log::warn!("cannot start the mesh loader thread: {error}"),
            }
        }
        core.work.notify_one();
    }

    /// Loads queued resources until the queue is empty for [`IDLE_TIME`].
    fn run(&self) {
        yield_to_others();
        let mut state = lock(&self.state);
        while !state.has_ended {
            let now = Instant::now();
            match state.next(now) {
                Ok(key) => {
                    if self.load(state, &key) {
                        (self.waker)();
                    }
                    state = lock(&self.state);
                }
                Err(due) => {
                    let timeout = due.map_or(IDLE_TIME, |due| due.saturating_duration_since(now));
                    state.waiting_threads += 1;
                    let (woken, result) =
                        self.work.wait_timeout(state, timeout).unwrap_or_else(PoisonError::into_inner);
                    state = woken;
                    state.waiting_threads -= 1;
                    if due.is_some() || !result.timed_out() || !state.queue.is_empty() {
                        continue;
                    }
                    let unused = state.take_unused(Instant::now());
                    let ends = state.threads > 1 || state.slots.values().all(|slot| slot.large().is_none());
                    state.threads -= usize::from(ends);
                    // Freeing memory takes a while, so not under the lock.
                    drop(state);
                    drop(unused);
                    if ends {
                        return;
                    }
                    state = lock(&self.state);
                }
            }
        }
        state.threads -= 1;
    }

    /// Loads a resource, without the lock. Returns `true` if its result changed.
    fn load(&self, state: MutexGuard<'_, StoreState>, key: &ResourceKey) -> bool {
        let failed = state.slots.get(key).and_then(|slot| slot.failed);
        drop(state);
        let loaded = self.loader.load(key, failed);
        self.keep(key, loaded)
    }

    /// Loads a resource on this thread, or waits for the thread that is loading it.
    fn load_now<'a>(&'a self, mut state: MutexGuard<'a, StoreState>, key: &ResourceKey) -> MutexGuard<'a, StoreState> {
        loop {
            let Some(slot) = state.slots.get_mut(key) else { return state };
            if !slot.is_busy {
                slot.is_busy = true;
                self.load(state, key);
                return lock(&self.state);
            }
            state = wait_timeout(&self.done, state, IDLE_TIME);
            if state.slots.get(key).is_none_or(|slot| !slot.is_busy && slot.outcome.is_some()) {
                return state;
            }
        }
    }

    /// Stores the result of loading. Returns `true` if it differs from the last one.
    fn keep(&self, key: &ResourceKey, loaded: Option<(Outcome, Option<FileStamp>)>) -> bool {
        let now = Instant::now();
        // May wait for a search of packages, so not under the lock.
        let next_search = match &loaded {
            Some((Err(ResourceError::NoSuchPackage { .. }), _)) => self.loader.packages.next_search(),
            _ => None,
        };
        let mut state = lock(&self.state);
        let Some(slot) = state.slots.get_mut(key) else { return false };
        slot.is_busy = false;
        slot.next_check = Some(next_search.unwrap_or(now + CHECK_INTERVAL));
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
        self.core.work.notify_all();
    }
}

impl fmt::Debug for MeshStore {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("MeshStore")
            .field("loader", &self.core.loader)
            .field("is_background", &self.is_background)
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
        CachedResource { outcome: Some(Ok(Resource::Mesh(Arc::new(mesh)))), ..CachedResource::default() }
    }

    #[test]
    fn a_large_resource_that_is_unused_for_a_while_is_dropped() {
        let large = LARGE_BYTES / size_of::<Vertex>() + 1;
        let key = |url: &str| ResourceKey { kind: ResourceKind::Mesh, url: url.to_owned() };
        let mut state = StoreState::default();
        let all = [("small", 8), ("unused", large), ("used", large), ("part", large), ("busy", large)];
        state.slots.extend(all.map(|(url, vertices)| (key(url), slot(vertices))));
        state.slots.get_mut(&key("busy")).unwrap().is_busy = true;
        let mesh = |state: &StoreState, url| match &state.slots[&key(url)].outcome {
            Some(Ok(Resource::Mesh(mesh))) => Arc::clone(mesh),
            other => panic!("{other:?}"),
        };
        let (used, part) = (mesh(&state, "used"), Arc::clone(&mesh(&state, "part").parts[0].mesh));
        let begin = Instant::now();
        let dropped = |state: &mut StoreState, secs| {
            let count = state.slots.len();
            drop(state.take_unused(begin + Duration::from_secs(secs)));
            count - state.slots.len()
        };
        assert_eq!([0, 29].map(|secs| dropped(&mut state, secs)), [0, 0]);
        // It was requested meanwhile.
        state.slots.get_mut(&key("unused")).unwrap().unused_since = None;
        assert_eq!([30, 59, 60].map(|secs| dropped(&mut state, secs)), [0, 0, 1]);
        assert!(!state.slots.contains_key(&key("unused")));
        drop((used, part));
        assert_eq!([100, 129, 130].map(|secs| dropped(&mut state, secs)), [0, 0, 2]);
        let mut left: Vec<&str> = state.slots.keys().map(|key| key.url.as_str()).collect();
        left.sort_unstable();
        assert_eq!(left, ["busy", "small"]);
    }
}
