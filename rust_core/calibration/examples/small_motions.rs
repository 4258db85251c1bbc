//! Rates of detected small motions during a scan, and of false alarms.
//! `cargo run --release -p rcs_calibration --example small_motions still|moved [ROOMS [FIRST_SEED]]`

use nalgebra::{Isometry3, Point2, Point3, Vector2, Vector3};
use rcs_calibration::patterns::gray_code;
use rcs_calibration::{
    decode, points, solve, Decoded, DistortionTerms, Pictures, Refusal, Report, Sample, SolveOptions,
};
use rcs_scan_simulator::{Conditions, DepthCamera, Random, Rig, Room, Scan, SmoothError, View};

const PROJECTOR_PX: [u32; 2] = [1280, 800];
const CENTER: Vector2<f64> = Vector2::new(639.5, 399.5);
/// Approximate number of samples of a scan.
const SAMPLES: usize = 6000;

/// Decoded scan of a room, for several depth cameras.
struct DecodedRoom {
    view: View,
    rig: Rig,
    decoded: Decoded,
}

/// Results of one variant.
#[derive(Debug, Default)]
struct Counts {
    name: String,
    rooms: u32,
    refused: u32,
    warned: u32,
    otherwise: u32,
}

fn main() {
    let is_still = std::env::args().nth(1).is_none_or(|what| what == "still");
    let mut given = std::env::args().skip(2).filter_map(|number| number.parse::<u64>().ok());
    let (rooms, first) = (given.next().unwrap_or(60), given.next().unwrap_or(5000));
    let mut all: Vec<Counts> = Vec::new();
    for seed in first..first + rooms {
        eprintln!("room {seed}");
        let Some(room) = DecodedRoom::new(seed) else { continue };
        let variants = if is_still { still(&room, seed) } else { moved(&room, seed) };
        for (index, (name, samples, options)) in variants.into_iter().enumerate() {
            if all.len() == index {
                all.push(Counts { name: name.clone(), ..Counts::default() });
            }
            all[index].add(&samples, &options);
        }
    }
    println!("| samples | scans | refused | warned of | refused for another reason |\n|---|--:|--:|--:|--:|");
    for Counts { name, rooms, refused, warned, otherwise } in &all {
        println!("| {name} | {rooms} | {refused} | {warned} | {otherwise} |");
    }
}

impl Counts {
    fn add(&mut self, samples: &[Sample], options: &SolveOptions) {
        self.rooms += 1;
        match solve(samples, options) {
            Err(reason) => {
                eprintln!("{}: {reason}", self.name);
                let is_motion = matches!(reason, Refusal::Moved { .. } | Refusal::TwoPoses { .. });
                *(if is_motion { &mut self.refused } else { &mut self.otherwise }) += 1;
            }
            Ok(solution) => {
                let report = Report::new(samples, solution);
                if let Some(reason) = report.reasons.iter().find(|reason| reason.contains("may have moved")) {
                    eprintln!("{}: {reason}", self.name);
                    self.warned += 1;
                }
            }
        }
    }
}

impl DecodedRoom {
    fn new(seed: u64) -> Option<Self> {
        let (room, rig) = (Room::cluttered(seed), Rig::random(seed));
        let view = View::new(&room, &rig);
        let patterns = gray_code(PROJECTOR_PX);
        let pictures = Scan::new(&view, Conditions::random(seed)).capture_all(&patterns);
        let levels = pictures.iter().map(Vec::as_slice).collect();
        let decoded = decode(&Pictures { size_px: view.size_px(), patterns: &patterns, levels }, PROJECTOR_PX).ok()?;
        Some(Self { view, rig, decoded })
    }

    fn depth_m(&self, camera: &DepthCamera) -> Vec<f32> {
        camera.capture(&self.view)
    }

    fn samples(&self, camera: &DepthCamera) -> Vec<Sample> {
        points(&self.decoded, &self.depth_m(camera), &self.rig.camera).unwrap_or_default()
    }

    /// Points as by another tool: each pixel's own depth of one image, without deviations.
    fn raw(&self, camera: &DepthCamera) -> Vec<Sample> {
        let width = self.decoded.size_px[0] as usize;
        let depth_m = self.depth_m(camera);
        let sample = |(index, depth): (usize, &f32)| {
            let pixel = self.decoded.pixels.get(index).filter(|pixel| pixel.is_decoded() && *depth > 0.0)?;
            let ray = self.rig.camera.ray(Point2::new((index % width) as f64, (index / width) as f64))?;
            let at = pixel.at.map(|at| f64::from(at).round());
            Some(Sample::new(Point2::from(at), Point3::from(ray * f64::from(*depth))))
        };
        depth_m.iter().enumerate().filter_map(sample).collect()
    }
}

type Variant = (String, Vec<Sample>, SolveOptions);

/// Scans without motion.
fn still(room: &DecodedRoom, seed: u64) -> Vec<Variant> {
    let kinect = DepthCamera { frames: 10, ..DepthCamera::kinect(seed) };
    let smooth = |rms_m| DepthCamera { smooth_error: Some(SmoothError { rms_m, seed }), frames: 3, ..kinect.clone() };
    let noisy = |noise_m| DepthCamera { noise_m, frames: 1, ..DepthCamera::kinect(seed) };
    let options = SolveOptions::new(PROJECTOR_PX);
    let pinhole = SolveOptions { distortion: DistortionTerms::None, ..options.clone() };
    let plain = room.samples(&kinect);
    let mut random = Random::new(&[seed, 1]);
    let gross = |samples: &[Sample], random: &mut Random| {
        let mut samples = thinned(samples);
        for sample in &mut samples {
            if random.happens(0.3) {
                sample.pixel = Point2::new(random.uniform(-0.5, 1279.5), random.uniform(-0.5, 799.5));
            }
        }
        samples
    };
    let distorted = |samples: &[Sample]| {
        let mut samples = thinned(samples);
        for sample in &mut samples {
            let centred = (sample.pixel.coords - CENTER) / 1400.0;
            sample.pixel.coords += centred * (1400.0 * -0.02 * centred.norm_squared());
        }
        samples
    };
    let variant = |name: &str, samples: Vec<Sample>| (name.to_owned(), samples, options.clone());
    let smooth_2mm = room.samples(&smooth(0.002));
    vec![
        variant("still", thinned(&plain)),
        variant("still, shuffled", shuffled(thinned(&plain), seed)),
        variant("still, 30 % gross errors", gross(&plain, &mut random)),
        variant("still, smooth error of 1 mm", thinned(&room.samples(&smooth(0.001)))),
        variant("still, smooth error of 2 mm", thinned(&smooth_2mm)),
        variant("still, smooth error of 2 mm, 30 % gross errors", gross(&smooth_2mm, &mut random)),
        variant("still, depth noise of 5 mm", thinned(&room.samples(&noisy(0.005)))),
        variant("still, raw depth, whole pixels", thinned(&room.raw(&noisy(0.0014)))),
        variant("still, raw depth without noise, whole pixels", thinned(&room.raw(&noisy(0.0)))),
        variant("still, raw depth, noise of 5 mm", thinned(&room.raw(&noisy(0.005)))),
        ("still, distortion not modelled".to_owned(), distorted(&plain), pinhole),
        variant("still, two places, numbered", two_places(room, seed)),
        wall_with_steps(room, seed),
    ]
}

/// Numbered scans from two camera poses.
fn two_places(room: &DecodedRoom, seed: u64) -> Vec<Sample> {
    let camera = |place| DepthCamera { frames: 3, ..DepthCamera::kinect(seed + u64::from(place)) };
    let scan = |place| {
        let view = View::new(room.view.room(), &room.rig.at_place(place));
        let samples = exact_pixels(&view, &camera(place), seed);
        samples.into_iter().map(move |sample| Sample { scan: place, ..sample })
    };
    scan(0).chain(scan(1)).collect()
}

/// Wall before a known projector, with quantised depth nearly without noise.
fn wall_with_steps(room: &DecodedRoom, seed: u64) -> Variant {
    let view = View::new(&Room::wall(1.3, [0.0, 0.0]), &room.rig);
    let camera = DepthCamera { noise_m: 0.0003, ..DepthCamera::kinect(seed) };
    let options = SolveOptions { known_lens: Some(room.rig.projector), ..SolveOptions::new(PROJECTOR_PX) };
    ("still, a wall in steps of depth, known lens".to_owned(), exact_pixels(&view, &camera, seed), options)
}

/// Points of every sixth pixel with its own depth, and projector pixels with errors of 0.2 px.
fn exact_pixels(view: &View, camera: &DepthCamera, seed: u64) -> Vec<Sample> {
    let mut random = Random::new(&[seed, 4]);
    let depths = camera.capture(view);
    let [width, height] = view.size_px();
    let pixels = (0..height).step_by(6).flat_map(|v| (0..width).step_by(6).map(move |u| (u, v)));
    let sample = |(u, v)| {
        let depth_m = f64::from(depths[(v * width + u) as usize]);
        let ray = view.rig().camera.ray(Point2::new(f64::from(u), f64::from(v))).filter(|_| depth_m > 0.0)?;
        let noise = Vector2::new(random.normal(), random.normal()) * 0.2;
        Some(Sample::new(view.truth(u, v)? + noise, Point3::from(ray * depth_m)))
    };
    pixels.filter_map(sample).filter(is_inside).collect()
}

fn is_inside(sample: &Sample) -> bool {
    sample.pixel.x > -0.5 && sample.pixel.x < 1279.5 && sample.pixel.y > -0.5 && sample.pixel.y < 799.5
}

/// Scans with a motion of part of the samples.
fn moved(room: &DecodedRoom, seed: u64) -> Vec<Variant> {
    let kinect = DepthCamera { frames: 10, ..DepthCamera::kinect(seed) };
    let smooth = DepthCamera { smooth_error: Some(SmoothError { rms_m: 0.001, seed }), ..kinect.clone() };
    let options = SolveOptions::new(PROJECTOR_PX);
    let cameras = [
        ("", thinned(&room.samples(&kinect))),
        (", smooth error of 1 mm", thinned(&room.samples(&smooth))),
        (", raw depth, whole pixels", thinned(&room.raw(&DepthCamera::kinect(seed)))),
    ];
    let mut variants = Vec::new();
    for (camera, samples) in &cameras {
        let clusters = [("any half", false, 0.5), ("any quarter", false, 0.25), ("second half", true, 0.5)];
        let clusters = if camera.is_empty() {
            &clusters[..]
        } else if camera.contains("raw") {
            &clusters[2..]
        } else {
            &clusters[..1]
        };
        for &(name, in_order, share) in clusters {
            for (what, degrees, mm, zoom) in MOTIONS {
                let mut random = Random::new(&[seed, 2]);
                let mut direction = || Vector3::new(random.normal(), random.normal(), random.normal()).normalize();
                let motion = Isometry3::new(direction() * mm * 1e-3, direction() * f64::to_radians(degrees));
                let samples = shuffled(samples.clone(), seed);
                let count = samples.len();
                let is_moved = |index: usize, random: &mut Random| {
                    if in_order {
                        index >= count / 2
                    } else {
                        random.happens(share)
                    }
                };
                let samples = samples.into_iter().enumerate().map(|(index, mut sample)| {
                    if is_moved(index, &mut random) {
                        sample.point = motion * sample.point;
                        sample.pixel = Point2::from(CENTER + (sample.pixel.coords - CENTER) * zoom);
                    }
                    sample
                });
                let samples = samples.filter(is_inside);
                variants.push((format!("{what}, {name}{camera}"), samples.collect(), options.clone()));
            }
        }
    }
    variants
}

/// Names, degrees, millimetres and zoom of motions.
const MOTIONS: [(&str, f64, f64, f64); 7] = [
    ("0.1°", 0.1, 0.0, 1.0),
    ("0.2°", 0.2, 0.0, 1.0),
    ("0.5°", 0.5, 0.0, 1.0),
    ("1 mm", 0.0, 1.0, 1.0),
    ("2 mm", 0.0, 2.0, 1.0),
    ("5 mm", 0.0, 5.0, 1.0),
    ("zoom 1 %", 0.0, 0.0, 1.01),
];

fn thinned(samples: &[Sample]) -> Vec<Sample> {
    samples.iter().copied().step_by((samples.len() / SAMPLES).max(1)).collect()
}

fn shuffled(mut samples: Vec<Sample>, seed: u64) -> Vec<Sample> {
    let mut random = Random::new(&[seed, 3]);
    for i in (1..samples.len()).rev() {
        samples.swap(i, random.integer(0, i as u32) as usize);
    }
    samples
}
