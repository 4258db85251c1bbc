//! Meshes and textures by address, each loaded once.
//!
//! rviz keeps a loaded mesh for as long as it runs and so does this, but for a large one that is loaded in the
//! background: once nobody has used it for a while, its memory is given back. A failure is kept too, so that a marker
//! that is published ten times a second does not read and report a broken file ten times a second: its file is read
//! again when somebody asks for it and it is not the same any more.
//!
//! A store loads either on the thread that asks, which then has its answer at once: that is for pictures of bags, which
//! must not depend on how fast files are read. Or it loads in the background: whoever asks is told that the resource
//! is being loaded, and the store's waker is called when it is there. These threads are started when there is something
//! to load, run at a low priority, and end when there is nothing more; the last stays while something large is kept.

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
    loader::{Key, Kind, Loader, Outcome, Resource},
    LoadedMesh, PackageIndex, ResourceError, ResourceOptions,
};

/// The most resources that are kept. Then a quarter of those that nobody uses goes, which were asked for longest ago.
const MAX_RESOURCES: usize = 4096;
/// The most threads that load in the background.
const MAX_THREADS: usize = 4;
/// A thread that had nothing to load for so long ends.
const IDLE_TIME: Duration = Duration::from_secs(10);
/// A resource that takes so much memory is given back after [`UNUSED_TIME`], at the next [`IDLE_TIME`].
const LARGE_BYTES: usize = 4 << 20;
const UNUSED_TIME: Duration = Duration::from_secs(30);
/// A file that could not be used is looked at again after this time at the earliest.
const CHECK_INTERVAL: Duration = Duration::from_millis(500);
/// How nice the threads are to those that draw.
const NICENESS: i32 = 10;

/// Whether a file that could not be used is looked at again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Retry {
    /// Something new, such as a message, names the file.
    Yes,
    /// What was found out is asked for again.
    No,
}

/// A cache of meshes and textures. Cheap to share between threads: a thread that needs a mesh which another is loading
/// waits for that mesh only.
///
/// ```
/// use std::task::Poll;
///
/// use rcs_resources::{MeshStore, PackageIndex, ResourceError, Retry};
///
/// // One that loads while it is asked.
/// let store = MeshStore::new(PackageIndex::from_env(&[]));
/// match store.mesh("package://no_such_package/arm.stl", Retry::Yes) {
///     Poll::Ready(Ok(mesh)) => println!("{} parts", mesh.parts.len()),
///     Poll::Ready(Err(ResourceError::NoSuchPackage { package, .. })) => assert_eq!(package, "no_such_package"),
///     Poll::Ready(Err(error)) => panic!("{error}"),
///     Poll::Pending => panic!("a store in the background would load it now"),
/// }
/// ```
pub struct MeshStore {
    shared: Arc<Shared>,
    is_background: bool,
}

/// What the store and its threads share.
struct Shared {
    loader: Loader,
    state: Mutex<State>,
    /// There is something to load, or the store is gone.
    work: Condvar,
    /// Something was loaded.
    done: Condvar,
    /// Incremented when the answer to a question changes.
    version: AtomicU64,
    waker: Box<dyn Fn() + Send + Sync>,
}

#[derive(Default)]
struct State {
    slots: HashMap<Key, Slot>,
    /// What is to be loaded in the background, and when at the earliest. Each slot is there once at most.
    queue: Vec<(Instant, Key)>,
    threads: usize,
    waiting_threads: usize,
    /// How often something was asked for.
    questions: u64,
    search_packages: bool,
    has_ended: bool,
}

/// What is known about an address.
#[derive(Default)]
struct Slot {
    outcome: Option<Outcome>,
    /// The file's stamp when it could not be used.
    failed: Option<FileStamp>,
    /// When it may be looked at again.
    next_check: Option<Instant>,
    /// It is in the queue, or a thread is loading it.
    is_busy: bool,
    /// The last question.
    asked: u64,
    /// When it was found first that nobody uses what is large.
    unused_since: Option<Instant>,
}

impl Slot {
    /// What was loaded, if it takes much memory.
    fn large(&self) -> Option<&Resource> {
        let loaded = self.outcome.as_ref().and_then(|outcome| outcome.as_ref().ok());
        loaded.filter(|resource| resource.bytes() >= LARGE_BYTES)
    }
}

impl MeshStore {
    /// An empty store that loads on the thread that asks. It finds packages through `packages` and reads files that are
    /// in packages.
    pub fn new(packages: PackageIndex) -> Self {
        Self::with_options(packages, ResourceOptions::default())
    }

    /// As [`MeshStore::new`], with other rules for files.
    pub fn with_options(packages: PackageIndex, options: ResourceOptions) -> Self {
        Self::create(packages, options, Box::new(|| {}), false)
    }

    /// An empty store that loads in the background and then calls `waker`, on a thread of its own.
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
        let shared = Shared {
            loader: Loader::new(packages, options),
            state: Mutex::default(),
            work: Condvar::new(),
            done: Condvar::new(),
            version: AtomicU64::new(0),
            waker,
        };
        Self { shared: Arc::new(shared), is_background }
    }

    /// The packages that addresses are resolved with.
    pub fn packages(&self) -> &PackageIndex {
        &self.shared.loader.packages
    }

    /// The mesh at a `package://` or `file://` address; the same address gives the same meshes and textures. What is
    /// wrong with it but not fatal is logged once, when it is loaded, and kept in [`LoadedMesh::warnings`]. Pending
    /// while it is being loaded in the background.
    ///
    /// # Errors
    /// Any [`ResourceError`].
    pub fn mesh(&self, url: &str, retry: Retry) -> Poll<Result<Arc<LoadedMesh>, ResourceError>> {
        self.get(Kind::Mesh, url, retry).map_ok(|resource| match resource {
            Resource::Mesh(mesh) => mesh,
            Resource::Texture(_) => Arc::default(),
        })
    }

    /// The image at a `package://` or `file://` address, as with [`MeshStore::mesh`].
    ///
    /// # Errors
    /// Any [`ResourceError`].
    pub fn texture(&self, url: &str, retry: Retry) -> Poll<Result<Arc<Texture>, ResourceError>> {
        self.get(Kind::Texture, url, retry).map_ok(|resource| match resource {
            Resource::Texture(texture) => texture,
            Resource::Mesh(_) => crate::warning_texture(),
        })
    }

    /// Loads meshes on several processors. Unless the store loads in the background, [`MeshStore::mesh`] then returns
    /// each of them, or its error, at once.
    pub fn load_all<'a>(&self, urls: impl IntoIterator<Item = &'a str>, retry: Retry) {
        let mut urls: Vec<&str> = urls.into_iter().collect();
        urls.sort_unstable();
        urls.dedup();
        // The results are kept in the store.
        if self.is_background {
            urls.iter().for_each(|url| drop(self.mesh(url, retry)));
        } else {
            urls.par_iter().for_each(|url| drop(self.mesh(url, retry)));
        }
    }

    /// A number that changes when something was loaded in the background, or could not be.
    pub fn version(&self) -> u64 {
        self.shared.version.load(Ordering::Acquire)
    }

    /// Looks at all files and packages again that could not be used.
    pub fn retry_failures(&self) {
        let mut state = lock(&self.shared.state);
        state.search_packages = true;
        let failed = |slot: &Slot| matches!(slot.outcome, Some(Err(_)));
        let keys: Vec<Key> = state.slots.iter().filter(|(_, slot)| failed(slot)).map(|(key, _)| key.clone()).collect();
        let now = Instant::now();
        state.queue.iter_mut().for_each(|(due, _)| *due = now);
        for key in keys {
            let Some(slot) = state.slots.get_mut(&key) else { continue };
            slot.next_check = None;
            if self.is_background {
                Shared::enqueue(&self.shared, &mut state, key);
            }
        }
        self.shared.work.notify_all();
    }

    fn get(&self, kind: Kind, url: &str, retry: Retry) -> Poll<Outcome> {
        let key = Key { kind, url: url.to_owned() };
        let mut state = lock(&self.shared.state);
        if !state.slots.contains_key(&key) && !state.make_room() {
            return Poll::Ready(Err(ResourceError::TooMany { url: url.to_owned(), limit: MAX_RESOURCES }));
        }
        state.questions += 1;
        let asked = state.questions;
        let slot = state.slots.entry(key.clone()).or_default();
        slot.asked = asked;
        slot.unused_since = None;
        let is_wanted = match &slot.outcome {
            None => true,
            Some(Ok(_)) => false,
            Some(Err(_)) => retry == Retry::Yes,
        };
        if is_wanted && self.is_background {
            Shared::enqueue(&self.shared, &mut state, key.clone());
        } else if is_wanted {
            state = self.shared.load_now(state, &key);
        }
        match state.slots.get(&key).and_then(|slot| slot.outcome.clone()) {
            Some(outcome) => Poll::Ready(outcome),
            None => Poll::Pending,
        }
    }
}

impl State {
    /// Makes room for another resource, and for many more so that it is not looked for each time. Returns false where
    /// all are in use.
    fn make_room(&mut self) -> bool {
        if self.slots.len() < MAX_RESOURCES {
            return true;
        }
        let is_unused = |slot: &Slot| match &slot.outcome {
            _ if slot.is_busy => false,
            Some(Ok(resource)) => resource.is_unused(),
            Some(Err(_)) | None => true,
        };
        let unused = self.slots.iter().filter(|(_, slot)| is_unused(slot));
        let mut asked: Vec<u64> = unused.map(|(_, slot)| slot.asked).collect();
        asked.sort_unstable();
        let Some(&last) = asked.get(asked.len() / 4) else { return false };
        self.slots.retain(|_, slot| slot.asked > last || !is_unused(slot));
        true
    }

    /// Takes out what is large and was not used for a while, whose memory is given back when that is dropped.
    fn take_unused(&mut self, now: Instant) -> Vec<Slot> {
        for slot in self.slots.values_mut() {
            let is_unused = !slot.is_busy && slot.large().is_some_and(Resource::is_unused);
            slot.unused_since = is_unused.then(|| slot.unused_since.unwrap_or(now));
        }
        let is_over = |slot: &Slot| slot.unused_since.is_some_and(|since| now.duration_since(since) >= UNUSED_TIME);
        self.slots.extract_if(|_, slot| is_over(slot)).map(|(_, slot)| slot).collect()
    }

    /// Takes what is to be loaded next out of the queue, or returns when that will be.
    fn next(&mut self, now: Instant) -> Result<Key, Option<Instant>> {
        let first = self.queue.iter().enumerate().min_by_key(|(_, (due, _))| *due).map(|(i, (due, _))| (i, *due));
        match first {
            Some((i, due)) if due <= now => Ok(self.queue.remove(i).1),
            first => Err(first.map(|(_, due)| due)),
        }
    }
}

impl Shared {
    /// Has a slot loaded in the background, unless it is to be already.
    fn enqueue(shared: &Arc<Self>, state: &mut State, key: Key) {
        let now = Instant::now();
        let Some(slot) = state.slots.get_mut(&key).filter(|slot| !slot.is_busy) else { return };
        slot.is_busy = true;
        let due = slot.next_check.map_or(now, |next| next.max(now));
        state.queue.push((due, key));
        let threads = thread::available_parallelism().map_or(1, usize::from).clamp(2, MAX_THREADS);
        if state.queue.len() > state.waiting_threads && state.threads < threads {
            let own = Arc::clone(shared);
            match thread::Builder::new().name("mesh-loader".to_owned()).spawn(move || own.run()) {
                Ok(_) => state.threads += 1,
                Err(error) => log::warn!("no thread to load meshes with: {error}"),
            }
        }
        shared.work.notify_one();
    }

    /// Loads what is to be loaded, until there was nothing for a while.
    fn run(&self) {
        yield_to_others();
        let mut state = lock(&self.state);
        while !state.has_ended {
            let now = Instant::now();
            match state.next(now) {
                Ok(key) => {
                    drop(state);
                    self.load_queued(&key);
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
                    // Giving memory back takes a while, so not under the lock.
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

    /// Loads a slot of the queue, and wakes whoever asked for it.
    fn load_queued(&self, key: &Key) {
        let (failed, search_packages) = {
            let mut state = lock(&self.state);
            let failed = state.slots.get(key).and_then(|slot| slot.failed);
            (failed, std::mem::take(&mut state.search_packages))
        };
        if search_packages {
            self.loader.packages.search_again();
        }
        let loaded = self.loader.load(key, failed);
        let has_changed = self.keep(key, loaded);
        if has_changed {
            (self.waker)();
        }
    }

    /// Loads a slot on this thread, or waits for the thread that is loading it.
    fn load_now<'a>(&'a self, mut state: MutexGuard<'a, State>, key: &Key) -> MutexGuard<'a, State> {
        loop {
            let Some(slot) = state.slots.get_mut(key) else { return state };
            if !slot.is_busy {
                slot.is_busy = true;
                let failed = slot.failed;
                let search_packages = std::mem::take(&mut state.search_packages);
                drop(state);
                if search_packages {
                    self.loader.packages.search_again();
                }
                let loaded = self.loader.load(key, failed);
                self.keep(key, loaded);
                return lock(&self.state);
            }
            // The other thread ends with its file.
            state = wait_timeout(&self.done, state, IDLE_TIME);
            if state.slots.get(key).is_none_or(|slot| !slot.is_busy && slot.outcome.is_some()) {
                return state;
            }
        }
    }

    /// Keeps what was loaded. Returns whether the answer for the slot changed.
    fn keep(&self, key: &Key, loaded: Option<(Outcome, Option<FileStamp>)>) -> bool {
        let now = Instant::now();
        // A search for packages may hold this up, so not under the lock.
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

/// Lets other threads go first where processors are scarce, from now on until this thread ends.
pub fn yield_to_others() {
    if let Err(error) = rustix::process::setpriority_process(Some(rustix::thread::gettid()), NICENESS) {
        log::debug!("the priority of a thread in the background: {error}");
    }
}

impl Drop for MeshStore {
    /// Its threads end with the files that they are reading; nobody waits for them.
    fn drop(&mut self) {
        lock(&self.shared.state).has_ended = true;
        self.shared.work.notify_all();
    }
}

impl fmt::Debug for MeshStore {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("MeshStore")
            .field("loader", &self.shared.loader)
            .field("is_background", &self.is_background)
            .field("resources", &lock(&self.shared.state).slots.len())
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use rcs_scene::{Mesh, Vertex};

    use super::*;
    use crate::{MeshMaterial, MeshPart};

    /// A slot with a mesh of so many vertices.
    fn slot(vertices: usize) -> Slot {
        let mesh = Mesh { vertices: vec![Vertex::new([0.0; 3], [0.0; 3]); vertices], indices: Vec::new() };
        let part = MeshPart { mesh: Arc::new(mesh), material: MeshMaterial::none() };
        let mesh = LoadedMesh { parts: vec![part], warnings: Vec::new() };
        Slot { outcome: Some(Ok(Resource::Mesh(Arc::new(mesh)))), ..Slot::default() }
    }

    #[test]
    fn what_is_large_and_unused_for_a_while_is_given_back() {
        let large = LARGE_BYTES / size_of::<Vertex>() + 1;
        let key = |url: &str| Key { kind: Kind::Mesh, url: url.to_owned() };
        let mut state = State::default();
        let all = [("small", 8), ("unused", large), ("used", large), ("part", large), ("busy", large)];
        state.slots.extend(all.map(|(url, vertices)| (key(url), slot(vertices))));
        state.slots.get_mut(&key("busy")).unwrap().is_busy = true;
        let mesh = |state: &State, url| match &state.slots[&key(url)].outcome {
            Some(Ok(Resource::Mesh(mesh))) => Arc::clone(mesh),
            other => panic!("{other:?}"),
        };
        let (used, part) = (mesh(&state, "used"), Arc::clone(&mesh(&state, "part").parts[0].mesh));
        let begin = Instant::now();
        let given_back = |state: &mut State, secs| {
            let count = state.slots.len();
            drop(state.take_unused(begin + Duration::from_secs(secs)));
            count - state.slots.len()
        };
        assert_eq!([0, 29].map(|secs| given_back(&mut state, secs)), [0, 0]);
        // Somebody has asked for it meanwhile.
        state.slots.get_mut(&key("unused")).unwrap().unused_since = None;
        assert_eq!([30, 59, 60].map(|secs| given_back(&mut state, secs)), [0, 0, 1]);
        assert!(!state.slots.contains_key(&key("unused")));
        drop((used, part));
        assert_eq!([100, 129, 130].map(|secs| given_back(&mut state, secs)), [0, 0, 2]);
        let mut left: Vec<&str> = state.slots.keys().map(|key| key.url.as_str()).collect();
        left.sort_unstable();
        assert_eq!(left, ["busy", "small"]);
    }
}
