//! Correctness of the standard deviations of calibrations: errors over deviations of many simulated scans should have
//! an RMS of one. `cargo run --release -p rcs_calibration --example true_deviations [COUNT [FIRST_SEED]]`

use rcs_calibration::patterns::gray_code;
use rcs_calibration::{decode, points, solve, Images, Parameter, SolveOptions};
use rcs_scan_simulator::{Conditions, DepthCamera, LightError, Rig, Room, Scan, View};

const PROJECTOR_PX: [u32; 2] = [1280, 800];
const NAMES: [&str; 10] = ["fx", "fy", "cx", "cy", "x", "y", "z", "about x", "about y", "about z"];

/// Calibrations with an error above this number of deviations are printed.
const REMARKABLE: f64 = 3.5;

fn main() {
    let mut given = std::env::args().skip(1).filter_map(|number| number.parse::<u64>().ok());
    let (count, first) = (given.next().unwrap_or(100), given.next().unwrap_or(1000));
    let mut ratios: [Vec<f64>; 10] = Default::default();
    let (mut light, mut refused) = (Vec::new(), 0);
    for seed in first..first + count {
        match calibrate(seed) {
            Ok((errors, light_error)) => {
                let worst = errors.iter().fold(0.0, |worst: f64, error| worst.max(error.abs()));
                if worst > REMARKABLE {
                    println!("seed {seed}: {}", errors.map(|error| format!("{error:.1}")).join(" "));
                }
                ratios.iter_mut().zip(errors).for_each(|(ratios, error)| ratios.push(error));
                light.push(light_error);
            }
            Err(reason) => {
                refused += 1;
                println!("seed {seed}: {reason}");
            }
        }
    }
    println!("{} calibrations, {refused} refused", light.len());
    let mut all = Vec::new();
    for (name, ratios) in NAMES.iter().zip(&ratios) {
        println!(
            "{name:8} errors over deviations: {:.2} RMS, {:.2} of them below 1 (0.68)",
            rms(ratios),
            below_one(ratios)
        );
        all.extend_from_slice(ratios);
    }
    println!("{:8} {:.2} RMS, {:.2} below 1", "all", rms(&all), below_one(&all));
    for (unit, index) in [("px", 0), ("mm", 1)] {
        let mut values: Vec<f64> = light.iter().map(|error| error[index]).collect();
        values.sort_by(f64::total_cmp);
        let at = |share: f64| values[((values.len() - 1) as f64 * share) as usize];
        println!(
            "light lands within (RMS over the volume) {:.3} {unit} median, {:.3} p90, {:.3} most",
            at(0.5),
            at(0.9),
            at(1.0)
        );
    }
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

fn below_one(values: &[f64]) -> f64 {
    values.iter().filter(|value| value.abs() < 1.0).count() as f64 / values.len().max(1) as f64
}

/// Errors over deviations, and projection error (RMS in pixels and millimetres).
fn calibrate(seed: u64) -> Result<([f64; 10], [f64; 2]), String> {
    let (room, rig) = (Room::cluttered(seed), Rig::random(seed));
    let view = View::new(&room, &rig);
    let patterns = gray_code(PROJECTOR_PX);
    let images = Scan::new(&view, Conditions::random(seed)).capture_all(&patterns);
    let levels = images.iter().map(Vec::as_slice).collect();
    let decoded = decode(&Images { size_px: view.size_px(), patterns: &patterns, levels }, PROJECTOR_PX)
        .map_err(|error| error.to_string())?;
    let depth_m = DepthCamera { frames: 10, ..DepthCamera::kinect(seed) }.capture(&view);
    let samples = points(&decoded, &depth_m, &rig.camera).map_err(|error| error.to_string())?;
    let solution = solve(&samples, &SolveOptions::new(PROJECTOR_PX)).map_err(|error| error.to_string())?;
    let (lens, truth) = (&solution.lens, &rig.projector);
    let sigma = |wanted: Parameter| {
        let estimate = solution.estimates.iter().find(|estimate| estimate.parameter == wanted);
        estimate.map_or(f64::NAN, |estimate| estimate.sigma)
    };
    let pose = &solution.poses[0];
    let (found, right) = (pose.projector_from_camera, rig.projector_from_camera());
    let moved = found.inverse().translation.vector - right.inverse().translation.vector;
    let turned = (found.rotation * right.rotation.inverse()).scaled_axis();
    let [x, y, z] = pose.position_sigma_m;
    let [about_x, about_y, about_z] = pose.orientation_sigma_rad;
    let errors = [
        (lens.focal_px.x - truth.focal_px.x) / sigma(Parameter::Fx),
        (lens.focal_px.y - truth.focal_px.y) / sigma(Parameter::Fy),
        (lens.center_px.x - truth.center_px.x) / sigma(Parameter::Cx),
        (lens.center_px.y - truth.center_px.y) / sigma(Parameter::Cy),
        moved.x / x,
        moved.y / y,
        moved.z / z,
        turned.x / about_x,
        turned.y / about_y,
        turned.z / about_z,
    ];
    let light = LightError::between((truth, &right), (lens, &found));
    Ok((errors, [light.rms_px, 1000.0 * light.rms_m]))
}
