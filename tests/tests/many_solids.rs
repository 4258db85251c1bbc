//! Very many small solids are quick to show, take little memory, and give it back.
//!
//! A tenth of the scenes that `examples/many_solids.rs` measures, from a message to its picture on the CPU. Times are
//! the fastest of several, have about three times the room that they need on two cores, and are printed.
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

struct Limits {
    /// From the decoded message to the picture.
    time: Duration,
    /// For each marker, pose or character, everything from the message to the renderer included.
    bytes_each: usize,
}

fn live_bytes(stats: &Stats) -> usize {
    stats.bytes_allocated.saturating_sub(stats.bytes_deallocated)
}

struct Measured {
    /// The fastest of several times from the decoded message to the picture.
    time: Duration,
    /// What lives while it is shown, and what is left once it was deleted.
    bytes: usize,
    left_bytes: usize,
}

fn measure(name: &str, solids: &ManySolids, threads: usize) -> Measured {
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
    let mut times = Vec::new();
    let mut bytes = 0;
    for number in 0..5 {
        let message = solids.kind().decode(&solids.bytes(f64::from(number) * 1e-3)).unwrap();
        let start = Instant::now();
        pipeline.receive("/many", &message);
        rendering.draw_of(&pipeline.scene).unwrap();
        times.push(start.elapsed());
        drop(message);
        bytes = live_bytes(&region.change());
    }
    assert!(rendering.covered() > 1e-3, "{name}: nothing is seen");
    pipeline.receive("/many", &solids.removal());
    rendering.draw_of(&pipeline.scene).unwrap();
    Measured { time: times.into_iter().min().unwrap(), bytes, left_bytes: live_bytes(&region.change()) }
}

fn check(name: &str, content: Content, count: usize, limits: &Limits) {
    let _guard = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
    let solids = ManySolids { content, count };
    let Measured { time, bytes, .. } = measure(name, &solids, 2);
    // A thread makes its buffers (0.6 MB here) when it draws first. Of several, one may draw nothing until after the
    // first pictures, and its buffers would count as left.
    let Measured { left_bytes, .. } = measure(name, &solids, 1);
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
        check(name, Content::Markers(marker_type), 10_000, &limits(500, 3000));
    }
}

#[test]
fn spheres_that_take_turns_with_labels() {
    check("spheres with labels", Content::LabelledSpheres, 10_000, &limits(500, 3000));
}

#[test]
fn markers_that_change_fifty_times_a_second() {
    for (name, marker_type) in [("spheres", Marker::SPHERE), ("cubes", Marker::CUBE), ("arrows", Marker::ARROW)] {
        check(name, Content::Markers(marker_type), 3_000, &limits(250, 3000));
    }
}

#[test]
fn poses_of_paths_and_arrays() {
    for (name, content) in [
        ("path as axes", Content::PathAxes),
        ("path as arrows", Content::PathArrows),
        ("array as arrows", Content::PoseArrows),
    ] {
        check(name, content, 10_000, &limits(500, 2000));
    }
}

#[test]
fn a_long_text() {
    check("text", Content::Text, 1_000_000, &limits(300, 40));
}
