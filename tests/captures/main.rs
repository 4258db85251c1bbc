//! Captures that other tools made, and captures whose images are not in the order that they say. `tests/captures`
//! says where the former come from.
#![expect(clippy::unwrap_used, reason = "a test that cannot be set up fails")]

use std::path::{Path, PathBuf};

use rcs_calibration::{points, solve, Decoded, ImageFault, ScanProblem, SolveOptions};
use rcs_scan_simulator::{has_many_seeds, seeds, DepthCamera, LightError, Rig, Room, View};
use rcs_tests::captures::KnownCapture;

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("captures").join(name)
}

fn read(name: &str) -> KnownCapture {
    KnownCapture::read(&folder(name)).unwrap()
}

/// The problems for which a capture with this order is refused.
fn refusals(capture: &KnownCapture, order: &[usize]) -> Vec<ScanProblem> {
    let problems = capture.decode(order).unwrap().quality.problems();
    problems.into_iter().filter(|problem| problem.is_fatal()).collect()
}

#[test]
fn captures_of_other_tools_are_decoded_with_a_warning_of_what_is_clipped() {
    for (name, least_decoded, is_clipped) in [("gsoup", 0.8, true), ("kamino", 0.9, false)] {
        let capture = read(name);
        let decoded = capture.decode(&capture.in_order()).unwrap();
        let shares = capture.shares(&decoded);
        println!("{name}: {shares:?}, {:?}", decoded.quality);
        assert!(shares.decoded > least_decoded && shares.wrong < 0.002, "{name}: {shares:?}");
        let problems = decoded.quality.problems();
        let expected = matches!(problems[..], [ScanProblem::Clipped(share)] if share > 0.8);
        assert!(if is_clipped { expected } else { problems.is_empty() }, "{name}: {problems:?}");
    }
}

#[test]
fn an_exposure_that_settles_is_no_motion() {
    let mut capture = read("kamino");
    for (image, grey) in capture.greys.iter_mut().enumerate() {
        let brighter = 1.0 + 0.25 * (-(image as f64) / 6.0).exp();
        grey.iter_mut().for_each(|level| *level = (f64::from(*level) * brighter).round().min(255.0) as u8);
    }
    let decoded = capture.decode(&capture.in_order()).unwrap();
    let (shares, problems) = (capture.shares(&decoded), decoded.quality.problems());
    assert!(matches!(problems[..], [ScanProblem::Exposure(change)] if change < 0.3), "{problems:?}");
    assert!(shares.decoded > 0.9 && shares.wrong < 0.002, "{shares:?}");
}

#[test]
fn a_camera_that_moves_by_a_pixel_is_still_noticed() {
    let mut capture = read("kamino");
    let width = capture.size_px[0] as usize;
    for grey in &mut capture.greys[14..] {
        // By a pixel down and to the right.
        grey.rotate_right(width + 1);
    }
    let refusals = refusals(&capture, &capture.in_order());
    assert!(matches!(refusals[..], [ScanProblem::Moved(px), ..] if (0.7..2.5).contains(&px)), "{refusals:?}");
}

#[test]
fn a_real_captures_wrong_image_is_named() {
    let capture = read("kamino");
    // Images, by how much they are another, and those that have to be named.
    let lapses = [(15, -1, &[14, 15][..]), (15, 1, &[15]), (10, -1, &[10]), (28, -1, &[28]), (33, -1, &[32, 33])];
    for (image, by, named) in lapses {
        let mut order = capture.in_order();
        order[image] = image.checked_add_signed(by).unwrap();
        let refusals = refusals(&capture, &order);
        let [ScanProblem::WrongImage(misplaced), ..] = refusals[..] else { panic!("{image} {by}: {refusals:?}") };
        let images_named = match misplaced.fault {
            ImageFault::Copy([image, _]) => vec![image],
            ImageFault::NoInverse(both) | ImageFault::Alike(both, _) => both.to_vec(),
        };
        assert_eq!(images_named, named, "{image} {by}: {misplaced:?}");
        let message = misplaced.describe(|index| format!("c{index:02}.png"));
        assert!(named.iter().all(|index| message.contains(&format!("c{index:02}.png"))), "{message}");
    }
}

#[test]
fn pairs_in_another_order_are_refused_for_it() {
    let capture = read("kamino");
    let pairs = |moves: &[(usize, usize)]| {
        let mut order = capture.in_order();
        for (to, from) in moves {
            (order[*to], order[to + 1]) = (*from, from + 1);
        }
        order
    };
    let count = capture.greys.len();
    let inverses_first = |images: std::ops::Range<usize>| {
        let mut order = capture.in_order();
        images.step_by(2).for_each(|image| order.swap(image, image + 1));
        order
    };
    let mut axes_swapped = capture.in_order();
    axes_swapped[2..].rotate_left((count - 2) / 2);
    let mut orders = vec![axes_swapped, inverses_first(0..2), inverses_first(2..22), inverses_first(22..42)];
    orders.extend([inverses_first(2..42), inverses_first(4..5), inverses_first(28..29)]);
    orders
        .extend([(2, 4), (8, 10), (12, 10), (14, 16), (22, 24), (30, 32), (32, 30), (22, 20)].map(|one| pairs(&[one])));
    // Both coarsest pairs of x come one too early.
    orders.push(pairs(&[(2, 4), (4, 6)]));
    for order in orders {
        let refusals = refusals(&capture, &order);
        let is_named = match &refusals[..] {
            [ScanProblem::Order | ScanProblem::WrongImage(_), ..] => true,
            [beyond @ ScanProblem::Beyond { .. }, ..] => beyond.to_string().contains("order"),
            _ => false,
        };
        assert!(is_named, "{order:?}: {refusals:?}");
    }
}

#[test]
fn two_bits_exchanged_are_refused_or_do_no_harm() {
    let mut harmful = Vec::new();
    for name in ["gsoup", "kamino"] {
        let capture = read(name);
        let bits = (capture.greys.len() - 2) / 4;
        let every = if has_many_seeds() { 1 } else { 7 };
        let pairs = (0..bits).flat_map(|one| (one + 1..bits).map(move |other| [one, other]));
        let along_both = pairs.flat_map(|pair| [0, bits].map(|axis| pair.map(|bit| 2 + 2 * (axis + bit))));
        for [one, other] in along_both.step_by(every) {
            let mut order = capture.in_order();
            order.swap(one, other);
            order.swap(one + 1, other + 1);
            let decoded = capture.decode(&order).unwrap();
            let is_refused = decoded.quality.problems().into_iter().any(ScanProblem::is_fatal);
            let shares = capture.shares(&decoded);
            // Few wrong points are outliers to the solver.
            let does_no_harm = shares.decoded * shares.wrong < 0.05;
            if !is_refused && !does_no_harm {
                harmful.push(format!("{name}: {one} and {other}: {shares:?}"));
            }
        }
    }
    assert!(harmful.is_empty(), "{harmful:#?}");
}

#[test]
fn mirrored_images_are_refused_as_such() {
    let mut capture = read("kamino");
    let width = capture.size_px[0] as usize;
    capture.greys.iter_mut().flat_map(|grey| grey.chunks_mut(width)).for_each(<[u8]>::reverse);
    assert_eq!(refusals(&capture, &capture.in_order()), [ScanProblem::Order]);
    // Upside down as well, it is turned.
    capture.greys.iter_mut().flat_map(|grey| grey.chunks_mut(width)).for_each(<[u8]>::reverse);
    capture.greys.iter_mut().for_each(|grey| grey.reverse());
    assert_eq!(refusals(&capture, &capture.in_order()), []);
}

#[test]
fn rooms_whose_images_are_in_order_are_not_suspected() {
    for seed in seeds(3000, 3, 120) {
        let capture = KnownCapture::simulated(seed);
        let quality = capture.decode(&capture.in_order()).unwrap().quality;
        let problems = quality.problems();
        assert!(!problems.iter().any(|problem| problem.is_fatal()), "seed {seed}: {problems:?}");
    }
}

#[test]
fn a_lapse_is_refused_or_does_no_harm() {
    for seed in seeds(3200, 2, 8) {
        let capture = KnownCapture::simulated(seed);
        let every = if has_many_seeds() { 1 } else { 11 };
        for (name, _, order) in capture.lapses().into_iter().skip(seed as usize % every).step_by(every) {
            let decoded = capture.decode(&order).unwrap();
            let is_refused = decoded.quality.problems().into_iter().any(ScanProblem::is_fatal);
            let shares = capture.shares(&decoded);
            let few_are_wrong = shares.decoded < 0.05 || shares.wrong < 0.05;
            if !is_refused && !few_are_wrong {
                // Two fine bits that are off fit the camera's pixels, and then no projector.
                let off_px = solved_off_px(seed, &decoded);
                assert!(off_px.is_none_or(|px| px < 0.2), "seed {seed}: {name}: {shares:?}, light {off_px:?} px off");
            }
        }
    }
}

/// RMS error of the light after solving, projector pixels; `None` if solving refuses the scan.
fn solved_off_px(seed: u64, decoded: &Decoded) -> Option<f64> {
    let (rig, depth_camera) = (Rig::random(seed), DepthCamera { frames: 10, ..DepthCamera::kinect(seed) });
    let depth = depth_camera.capture(&View::new(&Room::cluttered(seed), &rig));
    let samples = points(decoded, &depth, &rig.camera).ok()?;
    let solution = solve(&samples, &SolveOptions::new(rig.projector.size_px)).ok()?;
    let truth = (&rig.projector, &rig.projector_from_camera());
    Some(LightError::between(truth, (&solution.lens, &solution.poses[0].projector_from_camera)).rms_px)
}
