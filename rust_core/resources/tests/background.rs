//! Stores that load in the background: requests do not wait, and the waker is called.
#![expect(clippy::unwrap_used, reason = "a test that cannot be set up fails")]

#[expect(dead_code, reason = "other tests use the rest")]
mod common;

use std::{
    fs,
    path::Path,
    sync::{
        mpsc::{channel, Receiver},
        Arc,
    },
    task::Poll,
    time::{Duration, Instant},
};

use common::{binary_stl, get, store_of, TEXT_STL, TRIANGLES};
use rcs_resources::{LoadedMesh, MeshStore, PackageIndex, ResourceError, ResourceOptions, Retry};

/// Waits for longer than any machine needs.
const PATIENCE: Duration = Duration::from_secs(60);

/// A store, and where its waker is heard.
fn background(roots: &[&Path], folder: &Path) -> (MeshStore, Receiver<()>) {
    let (sender, woken) = channel();
    let options = ResourceOptions { folders: vec![folder.to_owned()], ..ResourceOptions::default() };
    let packages = PackageIndex::new(roots.iter().map(|root| root.to_path_buf()));
    (MeshStore::in_background(packages, options, move || sender.send(()).unwrap_or(())), woken)
}

/// The answer once it is there, asked for again only when the store says so.
fn wait(store: &MeshStore, woken: &Receiver<()>, url: &str) -> Result<Arc<LoadedMesh>, ResourceError> {
    loop {
        if let Poll::Ready(result) = store.mesh(url, Retry::No) {
            return result;
        }
        woken.recv_timeout(PATIENCE).unwrap();
    }
}

#[test]
fn a_request_for_a_large_mesh_does_not_wait_and_gives_the_same_mesh() {
    let dir = tempfile::tempdir().unwrap();
    let triangles: Vec<_> = TRIANGLES.iter().copied().cycle().take(300_000).collect();
    fs::write(dir.path().join("big.stl"), binary_stl(b"", &triangles)).unwrap();
    let url = format!("file://{}/big.stl", dir.path().display());
    let (store, woken) = background(&[], dir.path());
    let version = store.version();
    assert!(store.mesh(&url, Retry::Yes).is_pending());
    let mesh = wait(&store, &woken, &url).unwrap();
    assert_ne!(store.version(), version);
    let at_once = get(&store_of(dir.path()), &url).unwrap();
    assert_eq!(mesh.parts[0].mesh, at_once.parts[0].mesh);
    // Shared, however many ask.
    let again = store.mesh(&url, Retry::Yes);
    assert!(matches!(again, Poll::Ready(Ok(again)) if Arc::ptr_eq(&again, &mesh)));
}

#[test]
fn a_missing_package_is_searched_for_once_in_the_background() {
    let dir = tempfile::tempdir().unwrap();
    // Many folders, so that a search takes a while.
    for i in 0..1500 {
        fs::create_dir_all(dir.path().join(format!("a{i}/b/c"))).unwrap();
    }
    let searching = Instant::now();
    PackageIndex::new([dir.path().to_owned()]).package("late");
    let search = searching.elapsed();
    println!("a search takes {search:?}");
    let url = "package://late/a.stl";
    // Many markers of that package, of different files. Where others keep the processors busy, the best of some rounds
    // counts.
    let asked = || {
        let (store, woken) = background(&[dir.path()], dir.path());
        let asking = Instant::now();
        let urls = || (0..200).map(|i| format!("package://late/{i}.stl"));
        let time_of = |url: String| {
            let begin = Instant::now();
            let _ = store.mesh(&url, Retry::Yes);
            begin.elapsed()
        };
        let longest = urls().map(time_of).max().unwrap();
        for url in urls() {
            assert!(matches!(wait(&store, &woken, &url), Err(ResourceError::NoSuchPackage { .. })));
        }
        let all = asking.elapsed();
        println!("the longest of 200 questions took {longest:?}, all are answered after {all:?}");
        (longest < search / 2 && all < search * 20, store, woken)
    };
    let (is_quick, store, woken) = (0..10).map(|_| asked()).find(|round| round.0).unwrap_or_else(asked);
    assert!(is_quick, "a question waits for a search, or there is more than one");
    let _ = store.mesh(url, Retry::Yes);
    assert!(matches!(wait(&store, &woken, url), Err(ResourceError::NoSuchPackage { .. })));

    // It is installed, deep in the tree, and the config is reloaded.
    fs::create_dir_all(dir.path().join("x/y/late")).unwrap();
    fs::write(dir.path().join("x/y/late/package.xml"), "<package><name>late</name></package>").unwrap();
    fs::write(dir.path().join("x/y/late/a.stl"), TEXT_STL).unwrap();
    store.retry_failures();
    let end = Instant::now() + PATIENCE;
    while !matches!(store.mesh(url, Retry::No), Poll::Ready(Ok(_))) {
        woken.recv_timeout(end.saturating_duration_since(Instant::now())).unwrap();
    }
}

#[test]
fn a_failure_stays_until_its_file_changes_and_is_requested() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.stl");
    let url = format!("file://{}", path.display());
    fs::write(&path, "no mesh").unwrap();
    let (store, woken) = background(&[], dir.path());
    assert!(store.mesh(&url, Retry::Yes).is_pending());
    assert!(wait(&store, &woken, &url).is_err());
    let version = store.version();
    // Markers go on naming it: the result is the failure, without another wake-up.
    for _ in 0..1000 {
        assert!(matches!(store.mesh(&url, Retry::Yes), Poll::Ready(Err(_))));
    }
    assert!(woken.recv_timeout(Duration::from_millis(700)).is_err());
    assert_eq!(store.version(), version);
    // It is corrected.
    fs::write(&path, TEXT_STL).unwrap();
    assert!(matches!(store.mesh(&url, Retry::No), Poll::Ready(Err(_))), "not requested");
    assert!(matches!(store.mesh(&url, Retry::Yes), Poll::Ready(Err(_))), "not yet");
    woken.recv_timeout(PATIENCE).unwrap();
    assert!(matches!(store.mesh(&url, Retry::No), Poll::Ready(Ok(_))));
}

#[test]
fn addresses_without_end_do_not_take_memory_without_end() {
    let dir = tempfile::tempdir().unwrap();
    let store = store_of(dir.path());
    for i in 0..10_000 {
        assert!(get(&store, &format!("http://localhost/{i}.stl")).is_err());
    }
    let text = format!("{store:?}");
    let count = text.split("resources: ").nth(1).and_then(|rest| rest.split(',').next()).unwrap();
    assert!((1..=4096).contains(&count.trim().parse::<usize>().unwrap()), "{text}");
}

#[test]
fn a_store_that_is_dropped_while_it_loads_does_not_block() {
    let dir = tempfile::tempdir().unwrap();
    let triangles: Vec<_> = TRIANGLES.iter().copied().cycle().take(100_000).collect();
    for i in 0..20 {
        fs::write(dir.path().join(format!("{i}.stl")), binary_stl(b"", &triangles)).unwrap();
    }
    let (store, woken) = background(&[], dir.path());
    let urls: Vec<_> = (0..20).map(|i| format!("file://{}/{i}.stl", dir.path().display())).collect();
    store.load_all(urls.iter().map(String::as_str), Retry::Yes);
    drop(store);
    // The waker is dropped with the last thread, so nothing keeps on loading.
    let end = Instant::now() + PATIENCE;
    let mut loaded = 0;
    while woken.recv_timeout(end.saturating_duration_since(Instant::now())).is_ok() {
        loaded += 1;
    }
    assert!(Instant::now() < end, "its threads end");
    assert!(loaded < 20, "{loaded}");
}
