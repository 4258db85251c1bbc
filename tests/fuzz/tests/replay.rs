//! Inputs run again on stable Rust: the seeds of fuzzing, at most ten for each target, which reach most of what its
//! corpus did, and those that once failed.
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::any::Any;
use std::collections::BTreeSet;
use std::fs;
use std::panic::{catch_unwind, AssertUnwindSafe};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use rcs_fuzz_harness::{is_of_decoder, Target, TARGETS};

/// An input that takes longer than this hangs: a thousand times what most take.
const HANG_TIME: Duration = Duration::from_secs(60);
/// The stack of the threads that answer calls in `rcs_ros`; no thread has a smaller one.
const STACK_BYTES: usize = 512 << 10;

/// Panics so far, but for those of decoders. The node catches panics of a display, which are faults all the same.
static PANICS: AtomicUsize = AtomicUsize::new(0);

fn count_panics() {
    let report = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if !is_of_decoder(panic) {
            PANICS.fetch_add(1, Ordering::SeqCst);
            report(panic);
        }
    }));
}

fn fuzz_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz")
}

/// The files of a folder by name; none where there is no such folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

fn message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
    text.unwrap_or("a panic without text").to_owned()
}

/// Runs an input. The time that it took.
fn replay(target: &'static Target, bytes: &[u8]) -> Result<Duration, String> {
    let (begin, panics) = (Instant::now(), PANICS.load(Ordering::SeqCst));
    catch_unwind(AssertUnwindSafe(|| target.run(bytes))).map_err(|panic| message(&*panic))?;
    match PANICS.load(Ordering::SeqCst) > panics {
        true => Err("it panics, and the panic is caught".to_owned()),
        false => Ok(begin.elapsed()),
    }
}

/// Runs all inputs of a target on a thread, and gives those that failed. The others' number is printed.
fn replay_all(target: &'static Target) -> Vec<String> {
    let inputs: Vec<PathBuf> =
        ["seeds", "regressions"].iter().flat_map(|kind| files(&fuzz_folder().join(kind).join(target.name))).collect();
    let (sender, receiver) = mpsc::channel();
    let paths = inputs.clone();
    let run = move || {
        for path in paths {
            let bytes = fs::read(&path).unwrap();
            if sender.send(replay(target, &bytes)).is_err() {
                return;
            }
        }
    };
    thread::Builder::new().stack_size(STACK_BYTES).spawn(run).unwrap();
    let mut failures = Vec::new();
    let mut slowest = Duration::ZERO;
    for path in &inputs {
        let place = path.strip_prefix(fuzz_folder()).unwrap_or(path).display();
        match receiver.recv_timeout(HANG_TIME) {
            Ok(Ok(time)) => slowest = slowest.max(time),
            Ok(Err(error)) => failures.push(format!("fuzz/{place}: {error}")),
            Err(_) => {
                failures.push(format!("fuzz/{place}: it does not end within {} s", HANG_TIME.as_secs()));
                break;
            }
        }
    }
    println!("{}: {} inputs, the slowest took {:.1} ms", target.name, inputs.len(), slowest.as_secs_f64() * 1e3);
    failures
}

/// One after the other, because what they allocate is counted.
#[test]
fn every_seed_and_regression_runs_through() {
    count_panics();
    let failures: Vec<String> = TARGETS.iter().flat_map(replay_all).collect();
    assert!(failures.is_empty(), "{} inputs fail:\n{}", failures.len(), failures.join("\n"));
}

#[test]
fn every_target_has_a_binary_and_few_seeds_and_nothing_is_left_over() {
    let names: BTreeSet<String> = TARGETS.iter().map(|target| target.name.to_owned()).collect();
    let stems = |folder: &str| -> BTreeSet<String> {
        let stem = |path: &PathBuf| path.file_stem().unwrap().to_string_lossy().into_owned();
        files(&fuzz_folder().join(folder)).iter().map(stem).collect()
    };
    assert_eq!(stems("fuzz_targets"), names);
    assert_eq!(stems("seeds"), names);
    assert!(stems("regressions").is_subset(&names));
    let manifest = fs::read_to_string(fuzz_folder().join("Cargo.toml")).unwrap();
    for name in &names {
        let seeds = files(&fuzz_folder().join("seeds").join(name)).len();
        assert!((1..=10).contains(&seeds), "{name} has {seeds} seeds");
        let source = fs::read_to_string(fuzz_folder().join(format!("fuzz_targets/{name}.rs"))).unwrap();
        let run = format!("rcs_fuzz_harness::{}.run(data)", name.to_uppercase());
        assert!(source.contains(&run), "{name}.rs runs another target");
        assert!(manifest.contains(&format!("name = \"{name}\"")), "{name} is not in fuzz/Cargo.toml");
    }
}
