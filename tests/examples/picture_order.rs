//! What is noticed of a capture whose pictures are not in the order that it says.
//! `cargo run --release -p rcs_tests --example picture_order still|swapped FOLDER|SEED...`

use std::path::Path;

use rcs_calibration::patterns::{gray_code, Axis, Pattern};
use rcs_calibration::{decode, Decoded, Pictures};
use rcs_files::capture::Capture;
use rcs_scan_simulator::{Conditions, Rig, Room, Scan, View};

/// A capture and where its light comes from.
struct Known {
    name: String,
    size_px: [u32; 2],
    projector_px: [u32; 2],
    patterns: Vec<Pattern>,
    greys: Vec<Vec<u8>>,
    truth: Vec<Option<[f64; 2]>>,
}

impl Known {
    fn new(name: &str) -> Self {
        if let Ok(seed) = name.parse::<u64>() {
            return Self::simulated(seed, None);
        }
        if let Some((seed, exposure)) = name.split_once(':') {
            return Self::simulated(seed.parse().unwrap(), exposure.parse().ok());
        }
        let capture = Capture::read(Path::new(name)).unwrap();
        let patterns: Vec<Pattern> = capture.pictures.iter().map(|picture| picture.pattern).collect();
        let greys: Vec<Vec<u8>> = capture.pictures.into_iter().map(|picture| picture.grey).collect();
        let truth = by_signs(&patterns, &greys);
        Self {
            name: name.to_owned(),
            size_px: capture.camera.size_px,
            projector_px: capture.projector_size_px,
            patterns,
            greys,
            truth,
        }
    }

    fn simulated(seed: u64, exposure: Option<f64>) -> Self {
        let view = View::new(&Room::cluttered(seed), &Rig::random(seed));
        let patterns = gray_code([1280, 800]);
        let mut conditions = Conditions::random(seed);
        if let Some(exposure) = exposure {
            conditions.exposure = exposure;
        }
        let greys = Scan::new(&view, conditions).capture_all(&patterns);
        let [width, height] = view.size_px();
        let truth = (0..width * height).map(|pixel| view.truth(pixel % width, pixel / width).map(|at| [at.x, at.y]));
        Self {
            name: format!("{seed} {exposure:?}"),
            size_px: view.size_px(),
            projector_px: [1280, 800],
            truth: truth.collect(),
            patterns,
            greys,
        }
    }

    /// Decodes with the pictures in another order.
    fn decode(&self, order: &[usize]) -> Decoded {
        let levels = order.iter().map(|picture| self.greys[*picture].as_slice()).collect();
        let pictures = Pictures { size_px: self.size_px, patterns: &self.patterns, levels };
        decode(&pictures, self.projector_px).unwrap()
    }

    /// Shares of the known pixels that are decoded, and of those that are off by more than 2 px.
    fn score(&self, decoded: &Decoded) -> [f64; 2] {
        let known = self.truth.iter().zip(&decoded.pixels).filter_map(|(truth, pixel)| Some((truth.as_ref()?, pixel)));
        let (mut all, mut found, mut wrong) = (0_u32, 0_u32, 0_u32);
        for (truth, pixel) in known {
            all += 1;
            if pixel.is_decoded() {
                found += 1;
                wrong += u32::from((0..2).any(|axis| (f64::from(pixel.at[axis]) - truth[axis]).abs() > 2.0));
            }
        }
        [f64::from(found) / f64::from(all.max(1)), f64::from(wrong) / f64::from(found.max(1))]
    }
}

/// Where light comes from by the signs of stripes less their inverse, where all are clear.
fn by_signs(patterns: &[Pattern], greys: &[Vec<u8>]) -> Vec<Option<[f64; 2]>> {
    let find = |wanted: Pattern| patterns.iter().position(|pattern| *pattern == wanted).unwrap();
    let (white, black) = (find(Pattern::White), find(Pattern::Black));
    let mut axes = [Vec::new(), Vec::new()];
    for (picture, pattern) in patterns.iter().enumerate() {
        if let Pattern::GrayCode(stripes) = pattern {
            if !stripes.inverted {
                axes[stripes.axis.index()].push((stripes, picture, find(Pattern::GrayCode(stripes.inverse()))));
            }
        }
    }
    let at = |pixel: usize, axis: Axis| {
        let (mut place, mut bit) = (0_u32, 0);
        let range = i32::from(greys[white][pixel]) - i32::from(greys[black][pixel]);
        for (stripes, lit, inverse) in &axes[axis.index()] {
            let difference = i32::from(greys[*lit][pixel]) - i32::from(greys[*inverse][pixel]);
            if range < 10 || (difference.abs() < 3 && stripes.width_px() < 5.0) || (difference.abs() * 4 < range && stripes.width_px() > 5.0) {
                return None;
            }
            bit ^= u32::from(difference > 0);
            place = 2 * place + bit;
        }
        Some(f64::from(place))
    };
    (0..greys[white].len()).map(|pixel| Some([at(pixel, Axis::X)?, at(pixel, Axis::Y)?])).collect()
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let what = arguments.next().unwrap_or_default();
    for name in arguments {
        let known = Known::new(&name);
        let order: Vec<usize> = (0..known.greys.len()).collect();
        match what.as_str() {
            "still" => show(&known, "", &order),
            "swapped" => {
                for (how, order) in swaps(&order) {
                    show(&known, &how, &order);
                }
            }
            _ => panic!("still or swapped"),
        }
    }
}

fn show(known: &Known, how: &str, order: &[usize]) {
    let decoded = known.decode(order);
    let [found, wrong] = known.score(&decoded);
    let problems: Vec<String> = decoded.quality.problems().iter().map(|problem| format!("{}{problem}", if problem.is_fatal() { "REFUSED " } else { "" })).collect();
    println!(
        "{} {how}: lit {} known {:.3} decoded {:.3} (of lit {:.3}), wrong {:.4}; moved {:.2} exposure {:.3} clipped {:.3} contradicted {:.3} gamma {:.2}; {problems:?}",
        known.name,
        decoded.lit,
        known.truth.iter().flatten().count() as f64 / decoded.lit.max(1) as f64,
        found,
        decoded.count() as f64 / decoded.lit.max(1) as f64,
        wrong,
        decoded.quality.moved_px,
        decoded.quality.exposure_change,
        decoded.quality.clipped,
        decoded.quality.contradicted,
        decoded.quality.gamma,
    );
}

/// Orders in which one picture, or a pair, is that beside it.
fn swaps(order: &[usize]) -> Vec<(String, Vec<usize>)> {
    let mut all = Vec::new();
    let mut add = |name: String, changes: &[(usize, usize)]| {
        let mut other = order.to_vec();
        for (at, by) in changes {
            other[*at] = order[*by];
        }
        all.push((name, other));
    };
    let last = order.len() - 1;
    for at in 0..order.len() {
        if at > 0 {
            add(format!("c{at:02} := c{:02}", at - 1), &[(at, at - 1)]);
        }
        if at < last {
            add(format!("c{at:02} := c{:02}", at + 1), &[(at, at + 1)]);
        }
    }
    for at in (2..last).step_by(2) {
        if at > 2 {
            add(format!("pair c{at:02} := c{:02}", at - 2), &[(at, at - 2), (at + 1, at - 1)]);
        }
        if at + 2 < last {
            add(format!("pair c{at:02} := c{:02}", at + 2), &[(at, at + 2), (at + 1, at + 3)]);
        }
        if at + 4 < last {
            add(format!("two pairs c{at:02} := next"), &[(at, at + 2), (at + 1, at + 3), (at + 2, at + 4), (at + 3, at + 5)]);
        }
    }
    all
}
