//! Very many small solids are quick to show, take little memory, and give it back.
//!
//! Scenes that `examples/many_solids.rs` measures, some of them with a tenth of their things, from a message's bytes to
//! its picture on the CPU. Times are the fastest of several and are printed. They may be about three times what two
//! cores need, and always less than before, when each solid was a mesh of its own (16 to 37 µs and more).
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::alloc::System;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use rcs_messages::visualization_msgs::Marker;
use rcs_render::CpuRenderer;
use rcs_tests::scenes::display_pipeline::DisplayPipeline;
use rcs_tests::scenes::many_solids::{many_solids_camera, Content, ManySolids};
use rcs_tests::scenes::rendering::Rendering;
use stats_alloc::{Region, Stats, StatsAlloc, INSTRUMENTED_SYSTEM};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Allocations are counted for the whole process, so only one test runs at a time.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

/// What may stay of a scene that was deleted: buffers that every picture needs, and lists with a few bytes for each
/// thing that was drawn.
const LEFT_BYTES: usize = 1 << 20;

/// How many times a scene is measured.
const LEAST_TIMES: u32 = 5;
const MOST_TIMES: u32 = 25;

struct Limits {
    /// From the message's bytes to the picture.
    time: Duration,
    /// For each marker, pose or character, everything from the message to the renderer included.
    bytes_each: usize,
}

fn live_bytes(stats: &Stats) -> usize {
    stats.bytes_allocated.saturating_sub(stats.bytes_deallocated)
}

struct Measured {
    /// The fastest of several times from the message's bytes to the picture.
    time: Duration,
    /// What lives while it is shown, and what is left once it was deleted.
    bytes: usize,
    left_bytes: usize,
}

/// The processor time of this process's threads so far, where the system tells.
fn processor_time() -> Option<Duration> {
    let threads = std::fs::read_dir("/proc/self/task").ok()?.flatten();
    let nanos = threads.filter_map(|thread| {
        let line = std::fs::read_to_string(thread.path().join("schedstat")).ok()?;
        line.split_whitespace().next()?.parse::<u64>().ok()
    });
    Some(Duration::from_nanos(nanos.sum()))
}

/// How long something takes, or the processor time of all threads if that is less, as it is where others keep the
/// processors busy.
fn time_of(work: impl FnOnce()) -> Duration {
    let (start, before) = (Instant::now(), processor_time());
    work();
    let elapsed = start.elapsed();
    let used = processor_time().zip(before).map(|(after, before)| after.saturating_sub(before));
    // Counted from one tick of the system to another.
    used.filter(|used| *used > Duration::from_millis(10)).map_or(elapsed, |used| used.min(elapsed))
}

/// Measures five times, and again where others keep the processors busy, until the time is short enough.
fn measure(name: &str, solids: &ManySolids, threads: usize, enough: Duration) -> Measured {
    let mut pipeline = DisplayPipeline::new(&solids.config());
    let mut rendering =
        Rendering::new(Vec::new(), many_solids_camera().unwrap(), Box::new(CpuRenderer::with_threads(threads)));
    // What is made once, whatever the scene: glyphs, shapes, buffers for the picture.
    let warm = ManySolids { count: 2_000, ..*solids };
    pipeline.receive("/many", &warm.kind().decode(&warm.bytes(0.0)).unwrap());
    rendering.draw_of(&pipeline.scene).unwrap();
    pipeline.receive("/many", &warm.removal());
    rendering.draw_of(&pipeline.scene).unwrap();

    let region = Region::new(ALLOCATOR);
    let mut time = Duration::MAX;
    let mut bytes = 0;
    for number in 0..MOST_TIMES {
        if number >= LEAST_TIMES && time <= enough {
            break;
        }
        let message = solids.bytes(f64::from(number) * 1e-3);
        time = time.min(time_of(|| {
            pipeline.receive("/many", &solids.kind().decode(&message).unwrap());
            rendering.draw_of(&pipeline.scene).unwrap();
        }));
        drop(message);
        bytes = live_bytes(&region.change());
    }
    assert!(rendering.covered() > 1e-3, "{name}: nothing is seen");
    pipeline.receive("/many", &solids.removal());
    rendering.draw_of(&pipeline.scene).unwrap();
    Measured { time, bytes, left_bytes: live_bytes(&region.change()) }
}

fn check(name: &str, content: Content, count: usize, limits: &Limits) {
    let _guard = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
    let solids = ManySolids { content, count };
    let Measured { time, bytes, .. } = measure(name, &solids, 2, limits.time);
    // A thread makes its buffers (0.6 MB here) when it draws first. Of several, one may draw nothing until after the
    // first pictures, and its buffers would count as left.
    let Measured { left_bytes, .. } = measure(name, &solids, 1, Duration::MAX);
    println!("{name}: {time:?}, {} bytes each, {left_bytes} bytes left", bytes / count);
    assert!(time <= limits.time, "{name}: {time:?}, {:?} are allowed", limits.time);
    assert!(bytes / count <= limits.bytes_each, "{name}: {} bytes each", bytes / count);
    assert!(left_bytes <= LEFT_BYTES, "{name}: {left_bytes} bytes are left of it");
}

fn limits(millis: u64, bytes_each: usize) -> Limits {
    Limits { time: Duration::from_millis(millis), bytes_each }
}

#[test]
fn arrays_of_markers() {
    for (name, marker_type) in
        [("spheres", Marker::SPHERE), ("arrows", Marker::ARROW), ("texts", Marker::TEXT_VIEW_FACING)]
    {
        check(name, Content::Markers(marker_type), 10_000, &limits(90, 3000));
    }
}

#[test]
fn spheres_that_take_turns_with_labels() {
    check("spheres with labels", Content::LabelledSpheres, 10_000, &limits(90, 3000));
}

#[test]
fn markers_that_change_fifty_times_a_second() {
    for (name, marker_type) in [("spheres", Marker::SPHERE), ("cubes", Marker::CUBE), ("arrows", Marker::ARROW)] {
        check(name, Content::Markers(marker_type), 3_000, &limits(35, 3000));
    }
}

#[test]
fn poses_of_paths_and_arrays() {
    for (name, content) in [
        ("path as axes", Content::PathAxes),
        ("path as arrows", Content::PathArrows),
        ("array as arrows", Content::PoseArrows),
    ] {
        check(name, content, 10_000, &limits(90, 2000));
    }
}

#[test]
fn poses_as_lines() {
    check("path as a line", Content::PathLine, 200_000, &limits(150, 300));
    check("array as flat arrows", Content::FlatArrows, 200_000, &limits(55, 300));
}

#[test]
fn a_long_text() {
    check("text", Content::Text, 1_000_000, &limits(60, 40));
}
