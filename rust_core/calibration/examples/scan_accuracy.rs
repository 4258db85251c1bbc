//! Accuracy of decoded simulated scans: `cargo run --release -p rcs_calibration --example scan_accuracy [SEED...]`.

use std::time::Instant;

use rcs_calibration::patterns::gray_code;
use rcs_calibration::statistics::median;
use rcs_calibration::{decode, Pictures};
use rcs_scan_simulator::{Conditions, Rig, Room, Scan, View};

fn main() {
    let given: Vec<u64> = std::env::args().skip(1).filter_map(|seed| seed.parse().ok()).collect();
    let seeds = if given.is_empty() { (0..6).collect() } else { given };
    let patterns = gray_code([1280, 800]);
    println!(
        "seed    lit  decoded %  unlit %  within 1 px %  rms px  pull u  pull v  gamma  moved px  exposure %  time ms"
    );
    for seed in seeds {
        let (room, rig) = (Room::cluttered(seed), Rig::random(seed));
        let view = View::new(&room, &rig);
        let scan = Scan::new(&view, Conditions::random(seed));
        let pictures = scan.capture_all(&patterns);
        let size_px = view.size_px();
        let pictures = Pictures { size_px, patterns: &patterns, levels: pictures.iter().map(Vec::as_slice).collect() };
        let start = Instant::now();
        let decoded = decode(&pictures, [1280, 800]).unwrap_or_else(|error| panic!("{error}"));
        let time = start.elapsed();
        let (mut lit, mut count, mut unlit, mut right, mut squares) = (0_u32, 0_u32, 0_u32, 0_u32, 0.0_f64);
        let mut pulls = [Vec::new(), Vec::new()];
        for (index, pixel) in decoded.pixels.iter().enumerate() {
            let truth = view.truth(index as u32 % size_px[0], index as u32 / size_px[0]);
            lit += u32::from(truth.is_some());
            if !pixel.is_decoded() {
                continue;
            }
            count += 1;
            let Some(truth) = truth else {
                unlit += 1;
                continue;
            };
            let error = [f64::from(pixel.at[0]) - truth.x, f64::from(pixel.at[1]) - truth.y];
            if error.iter().all(|error| error.abs() <= 1.0) {
                right += 1;
                squares += error[0] * error[0] + error[1] * error[1];
                for axis in 0..2 {
                    pulls[axis].push((error[axis] / f64::from(pixel.sigma[axis])).abs());
                }
            }
        }
        let pull = pulls.map(|mut pulls| median(&mut pulls) / 0.6745);
        println!(
            "{seed:4} {lit:6} {:10.1} {:8.2} {:14.2} {:7.3} {:7.2} {:7.2} {:6.2} {:9.2} {:11.2} {:8}",
            100.0 * f64::from(count - unlit) / f64::from(lit),
            100.0 * f64::from(unlit) / f64::from(count),
            100.0 * f64::from(right) / f64::from(count),
            (squares / f64::from(right)).sqrt(),
            pull[0],
            pull[1],
            decoded.quality.gamma,
            decoded.quality.moved_px,
            100.0 * decoded.quality.exposure_change,
            time.as_millis(),
        );
    }
}
