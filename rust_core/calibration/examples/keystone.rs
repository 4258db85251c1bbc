//! Rates of detected keystone corrections and of false alarms, by the first stripes and by the whole scan.
//! `cargo run --release -p rcs_calibration --example keystone [ROOMS [FIRST_SEED]]`

use nalgebra::Matrix3;
use rcs_calibration::patterns::{gray_code, Pattern};
use rcs_calibration::{decode, points, solve, Images, Keystone, Report, SolveOptions};
use rcs_scan_simulator::{Conditions, DepthCamera, Rig, Room, Scan, SmoothError, View};

const PROJECTOR_PX: [u32; 2] = [1280, 800];
/// Coarse bits of each axis.
const COARSE_BITS: u32 = 5;
/// Smooth errors of the depth at 1 m, metres.
const SMOOTH_M: [f64; 3] = [0.0, 0.001, 0.002];

/// Reports of keystone corrections.
#[derive(Default)]
struct Counts {
    rooms: u32,
    early: [u32; 2],
    late: [u32; 2],
    refused: u32,
}

fn main() {
    let mut given = std::env::args().skip(1).filter_map(|number| number.parse::<u64>().ok());
    let (rooms, first) = (given.next().unwrap_or(100), given.next().unwrap_or(1000));
    let corrections = [
        ("none", [0.0, 0.0]),
        ("5 degrees horizontally", [0.0, 5.0]),
        ("5 degrees both ways", [5.0, 5.0]),
        ("10 degrees vertically", [10.0, 0.0]),
        ("20 degrees both ways", [20.0, -20.0]),
    ];
    for (name, [about_rows, about_columns]) in corrections {
        let mut counts = Counts::default();
        for seed in first..first + rooms {
            let smooth_m = SMOOTH_M[seed as usize % SMOOTH_M.len()];
            counts.add(seed, smooth_m, Conditions::keystone(about_rows, about_columns), name == "none");
        }
        let [skewed, stretched] = counts.early;
        let [skewed_late, stretched_late] = counts.late;
        println!(
            "{name}: {} rooms; by the first stripes {skewed} skewed, {stretched} stretched; by the whole scan \
             {skewed_late} skewed, {stretched_late} stretched, {} refused",
            counts.rooms, counts.refused
        );
    }
}

impl Counts {
    fn add(&mut self, seed: u64, smooth_m: f64, image_from_panel: Matrix3<f64>, names: bool) {
        let (room, rig) = (Room::cluttered(seed), Rig::random(seed));
        let view = View::new(&room, &rig);
        let patterns = gray_code(PROJECTOR_PX);
        let conditions = Conditions { image_from_panel, ..Conditions::random(seed) };
        let images = Scan::new(&view, conditions).capture_all(&patterns);
        let smooth_error = (smooth_m > 0.0).then_some(SmoothError { rms_m: smooth_m, seed });
        let depth_m = DepthCamera { frames: 10, smooth_error, ..DepthCamera::kinect(seed) }.capture(&view);
        let is_coarse =
            |pattern: &Pattern| !matches!(pattern, Pattern::GrayCode(stripes) if stripes.bit >= COARSE_BITS);
        let coarse: Vec<(Pattern, &[u8])> = (patterns.iter().zip(&images))
            .filter(|(pattern, _)| is_coarse(pattern))
            .map(|(pattern, image)| (*pattern, image.as_slice()))
            .collect();
        let (coarse, levels): (Vec<Pattern>, Vec<&[u8]>) = coarse.into_iter().unzip();
        let coarse = Images { size_px: view.size_px(), patterns: &coarse, levels };
        self.rooms += 1;
        match Keystone::find(&coarse, &depth_m, &rig.camera, PROJECTOR_PX) {
            Some(Keystone::Skewed(reason)) => {
                self.early[0] += 1;
                if names {
                    println!("seed {seed}, {smooth_m} m: {reason}");
                }
            }
            Some(Keystone::Stretched(_)) => self.early[1] += 1,
            None => {}
        }
        let levels = images.iter().map(Vec::as_slice).collect();
        let whole = Images { size_px: view.size_px(), patterns: &patterns, levels };
        let solved = decode(&whole, PROJECTOR_PX)
            .ok()
            .and_then(|decoded| points(&decoded, &depth_m, &rig.camera).ok())
            .and_then(|samples| Some((solve(&samples, &SolveOptions::new(PROJECTOR_PX)).ok()?, samples)));
        let Some((solution, samples)) = solved else {
            self.refused += 1;
            return;
        };
        let report = Report::new(&samples, solution);
        let says = |words: &str| u32::from(report.reasons.iter().any(|reason| reason.contains(words)));
        self.late[0] += says("skewed by");
        self.late[1] += says("fx and fy differ");
        if names && says("skewed by") > 0 {
            println!("seed {seed}, {smooth_m} m: {:?}", report.reasons);
        }
    }
}
