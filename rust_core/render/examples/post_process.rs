//! Cost of post-processing: milliseconds for an image of 1280×800 in rgb8, the median of many.
//!
//! ```text
//! cargo run --release -p rcs_render --example post_process
//! ```
#![expect(clippy::unwrap_used, reason = "a measurement that cannot begin measures nothing")]

use std::sync::Arc;
use std::time::Instant;

use nalgebra::{Isometry3, Point3};
use rcs_render::{Blend, KeepOut, LightMask, PostProcess, Sphere};
use rcs_scene::{Camera, Encoding, Image, Intrinsics};

const SIZE: [u32; 2] = [1280, 800];
const RUNS: usize = 200;

/// The median time of a step, milliseconds.
fn median_ms(step: &PostProcess) -> f64 {
    let (mut image, mut spare) = (Image::default(), Image::default());
    let mut times: Vec<f64> = (0..RUNS)
        .map(|_| {
            image.reset(SIZE[0], SIZE[1], Encoding::Rgb8);
            image.data.fill(77);
            let begun = Instant::now();
            step.apply(&mut image, &mut spare);
            begun.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[RUNS / 2]
}

fn main() {
    let pixels = (SIZE[0] * SIZE[1]) as usize;
    let p = [1900.0, 0.0, 640.0, 0.0, 0.0, 1900.0, 750.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let camera = Camera::new(Intrinsics::from_p(SIZE[0], SIZE[1], &p).unwrap(), &Isometry3::identity(), 0.01);
    let head = |x: f64| Sphere { center: Point3::new(x, -0.2, 2.0), radius_m: 0.3 };
    let nothing = PostProcess::default;
    // A ramp over a quarter of the image, one elsewhere.
    let ramp = |at: usize| ((at % SIZE[0] as usize) * 4 * 65535 / SIZE[0] as usize).min(65535) as u16;
    let weights: Vec<u16> = (0..pixels).map(ramp).collect();
    let lifts: Vec<u16> = weights.iter().map(|weight| if *weight == 65535 { 300 } else { 0 }).collect();
    let mask: Vec<u8> = (0..pixels).map(|at| if at / SIZE[0] as usize % 400 < 100 { 0 } else { 255 }).collect();
    let steps = [
        ("nothing", nothing()),
        ("mask", PostProcess { masks: LightMask::new(SIZE, mask).map(Arc::new).into_iter().collect(), ..nothing() }),
        (
            "two keep-out spheres",
            PostProcess { keep_out: KeepOut::new(&camera, &[head(-0.2), head(0.4)]), ..nothing() },
        ),
        ("blend", PostProcess { blend: Blend::new(SIZE, &weights, &[], 2.2).ok().map(Arc::new), ..nothing() }),
        (
            "blend with lift",
            PostProcess { blend: Blend::new(SIZE, &weights, &lifts, 2.2).ok().map(Arc::new), ..nothing() },
        ),
        ("180", PostProcess { orientation: "180".parse().unwrap(), ..nothing() }),
        ("mirrored", PostProcess { orientation: "mirrored".parse().unwrap(), ..nothing() }),
        ("90", PostProcess { orientation: "90".parse().unwrap(), ..nothing() }),
    ];
    for (name, step) in &steps {
        println!("{name:22} {:6.3} ms", median_ms(step));
    }
}
