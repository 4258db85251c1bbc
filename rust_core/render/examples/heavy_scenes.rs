//! Measures how long the heaviest scenes take to draw, on both renderers.
//!
//! `cargo run --release -p rcs_render --example heavy_scenes [-- FILTER] [--cpu | --gpu] [--pictures N] [--share S]`
//! prints a table: the longest and the shortest time of N images (3) of each scene whose name contains FILTER, with a
//! share S (1) of the number of things.

#[path = "../tests/heavy_common/mod.rs"]
mod heavy_common;

use std::error::Error;
use std::time::Instant;

use rcs_render::{CpuRenderer, GpuRenderer, Renderer, View};
use rcs_scene::{DisplayMask, Encoding, Image};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let after =
        |name: &str| arguments.iter().position(|a| a == name).and_then(|at| arguments.get(at + 1)?.parse::<f64>().ok());
    let has = |name: &str| arguments.iter().any(|argument| argument == name);
    let images = after("--pictures").map_or(3, |images| images as usize).max(1);
    let filter = arguments.first().filter(|first| !first.starts_with("--")).cloned().unwrap_or_default();
    let mut renderers: Vec<Box<dyn Renderer>> = Vec::new();
    if !has("--gpu") {
        renderers.push(Box::new(CpuRenderer::new()));
    }
    if !has("--cpu") {
        renderers.push(Box::new(GpuRenderer::new(false)?));
    }
    for renderer in &renderers {
        println!("{}", renderer.describe());
    }
    println!("| {:40} | longest, shortest ms of {images} on each | limit ms | picture |", "scene");
    for row in heavy_common::rows(after("--share").unwrap_or(1.0)) {
        if !row.name.contains(&filter) {
            continue;
        }
        print!("| {:40} |", row.name);
        let scene = row.scene();
        let mut hashes = Vec::new();
        for renderer in &mut renderers {
            let visible = DisplayMask::all();
            let view = View {
                scene: &scene,
                camera: &row.camera,
                visible: &visible,
                background: [20, 30, 40],
                encoding: Encoding::Rgb8,
            };
            let mut image = Image::default();
            let mut times_ms = Vec::new();
            for _ in 0..images {
                let start = Instant::now();
                renderer.render(&view, &mut image)?;
                times_ms.push(start.elapsed().as_secs_f64() * 1e3);
            }
            let longest = times_ms.iter().copied().fold(0.0, f64::max);
            let shortest = times_ms.iter().copied().fold(f64::INFINITY, f64::min);
            print!(" {longest:8.1} {shortest:8.1} |");
            hashes.push(hash(&image.data));
        }
        println!(" {:5.0} | {} |", row.limit_ms, hashes.join(" "));
    }
    Ok(())
}

/// A number that tells images apart.
fn hash(bytes: &[u8]) -> String {
    let mix = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
    format!("{:016x}", bytes.iter().fold(0xcbf2_9ce4_8422_2325, mix))
}
