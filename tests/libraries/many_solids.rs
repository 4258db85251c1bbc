//! Very many small solids take little memory, and give it back.
//!
//! Scenes that `examples/many_solids.rs` measures, some of them with a tenth of their things, from a message's bytes to
//! its image on the CPU.
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::alloc::System;
use std::sync::Mutex;

use rcs_messages::visualization_msgs::Marker;
use rcs_process::lock;
use rcs_render::CpuRenderer;
use rcs_tests::scenes::display_pipeline::DisplayPipeline;
use rcs_tests::scenes::many_solids::{many_solids_camera, Content, ManySolids};
use rcs_tests::scenes::rendering::Rendering;
use stats_alloc::{Region, Stats, StatsAlloc, INSTRUMENTED_SYSTEM};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Allocations are counted for the whole process, so only one test runs at a time.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

/// What may stay of a scene that was deleted: buffers that every image needs, and lists with a few bytes for each
/// thing that was drawn.
const LEFT_BYTES: usize = 1 << 20;

/// How many messages of a scene come, one after the other.
const MESSAGES: u32 = 3;

fn live_bytes(stats: &Stats) -> usize {
    stats.bytes_allocated.saturating_sub(stats.bytes_deallocated)
}

/// The bytes that live while a scene is shown, and those that are left once it was deleted.
fn measure(name: &str, solids: &ManySolids, threads: usize) -> [usize; 2] {
    let mut pipeline = DisplayPipeline::new(&solids.config());
    let mut rendering =
        Rendering::new(Vec::new(), many_solids_camera().unwrap(), Box::new(CpuRenderer::with_threads(threads)));
    // What is made once, whatever the scene: glyphs, shapes, buffers for the image.
    let warm = ManySolids { count: 2_000, ..*solids };
    pipeline.receive("/many", &warm.kind().decode(&warm.bytes(0.0)).unwrap());
    rendering.draw_of(&pipeline.scene).unwrap();
    pipeline.receive("/many", &warm.removal());
    rendering.draw_of(&pipeline.scene).unwrap();

    let region = Region::new(ALLOCATOR);
    let mut bytes = 0;
    for number in 0..MESSAGES {
        let message = solids.bytes(f64::from(number) * 1e-3);
        pipeline.receive("/many", &solids.kind().decode(&message).unwrap());
        rendering.draw_of(&pipeline.scene).unwrap();
        drop(message);
        bytes = live_bytes(&region.change());
    }
    assert!(rendering.covered() > 1e-3, "{name}: nothing is seen");
    pipeline.receive("/many", &solids.removal());
    rendering.draw_of(&pipeline.scene).unwrap();
    [bytes, live_bytes(&region.change())]
}

/// `most_bytes`: for each marker, pose or character, everything from the message to the renderer included.
fn check(name: &str, content: Content, count: usize, most_bytes: usize) {
    let _guard = lock(&ONE_AT_A_TIME);
    let solids = ManySolids { content, count };
    let [bytes, _] = measure(name, &solids, 2);
    // A thread makes its buffers (0.6 MB here) when it draws first. Of several, one may draw nothing until after the
    // first images, and its buffers would count as left.
    let [_, left_bytes] = measure(name, &solids, 1);
    println!("{name}: {} bytes each, {left_bytes} bytes left", bytes / count);
    assert!(bytes / count <= most_bytes, "{name}: {} bytes each", bytes / count);
    assert!(left_bytes <= LEFT_BYTES, "{name}: {left_bytes} bytes are left of it");
}

#[test]
fn arrays_of_markers() {
    for (name, marker_type) in
        [("spheres", Marker::SPHERE), ("arrows", Marker::ARROW), ("texts", Marker::TEXT_VIEW_FACING)]
    {
        check(name, Content::Markers(marker_type), 10_000, 3000);
    }
}

#[test]
fn spheres_that_take_turns_with_labels() {
    check("spheres with labels", Content::LabelledSpheres, 10_000, 3000);
}

#[test]
fn markers_that_change_fifty_times_a_second() {
    for (name, marker_type) in [("spheres", Marker::SPHERE), ("cubes", Marker::CUBE), ("arrows", Marker::ARROW)] {
        check(name, Content::Markers(marker_type), 3_000, 3000);
    }
}

#[test]
fn poses_of_paths_and_arrays() {
    for (name, content) in [
        ("path as axes", Content::PathAxes),
        ("path as arrows", Content::PathArrows),
        ("array as arrows", Content::PoseArrows),
    ] {
        check(name, content, 10_000, 2000);
    }
}

#[test]
fn poses_as_lines() {
    check("path as a line", Content::PathLine, 200_000, 300);
    check("array as flat arrows", Content::FlatArrows, 200_000, 300);
}

#[test]
fn a_long_text() {
    check("text", Content::Text, 1_000_000, 40);
}
