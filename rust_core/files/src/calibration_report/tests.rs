//! Tests of the report: a synthetic calibration, and empty or invalid ones.

use std::fs;

use nalgebra::{Isometry3, Point2, Point3, Vector2, Vector3};
use proptest::prelude::*;
use rcs_calibration::{
    Coverage, Distortion, DistortionTerms, Estimate, Lens, Parameter, Residual, ScanPose, Skew, Solution, Verdict,
};
use serde_yaml_ng::Value;

use super::*;

/// Pseudo-random numbers from 0 to 1.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.next()).sum::<f64>() - 6.0
    }
}

/// A projector above a table with boxes before a wall, seen by cameras beside it.
fn scanned(lens: &Lens, points_per_scan: usize, scans: u32) -> (Vec<Sample>, Vec<Residual>, Vec<ScanPose>) {
    let mut chance = Chance(7);
    let (mut samples, mut residuals, mut poses) = (Vec::new(), Vec::new(), Vec::new());
    for scan in 0..scans {
        let aside = f64::from(scan) - 0.5 * f64::from(scans.saturating_sub(1));
        let camera =
            Isometry3::new(Vector3::new(0.16 + 0.22 * aside, -0.06, 0.04), Vector3::new(0.1, -0.12 * aside, 0.02));
        for _ in 0..points_per_scan {
            let pixel = Point2::new(1280.0 * chance.next() - 0.5, 800.0 * chance.next() - 0.5);
            let is_box = (pixel.x - 500.0).abs() < 180.0 && pixel.y > 300.0;
            let depth = if is_box { 0.9 + 0.0003 * pixel.y } else { 1.9 - 0.0006 * pixel.y - 0.0002 * pixel.x };
            let point = Point3::from(lens.ray(pixel).unwrap() * depth);
            let off = (pixel - Point2::new(640.0, 400.0)) / 640.0;
            let noise = Vector2::new(chance.normal(), chance.normal()) * (0.12 + 0.08 * off.norm_squared());
            let error_px = noise + off * off.norm_squared() * 0.12;
            residuals.push(Residual {
                sample: samples.len(),
                error_px,
                error_m: error_px * depth / 1900.0,
                depth_m: depth,
                is_inlier: true,
            });
            samples.push(Sample { scan, ..Sample::new(pixel + error_px, camera.inverse() * point) });
        }
        poses.push(ScanPose {
            scan,
            projector_from_camera: camera,
            position_sigma_m: [0.000_21, 0.000_19, 0.000_62],
            orientation_sigma_rad: [0.000_12, 0.000_15, 0.000_05],
            inliers: points_per_scan,
        });
    }
    (samples, residuals, poses)
}

fn report(points_per_scan: usize, scans: u32) -> (Report, Vec<Sample>) {
    let lens = Lens {
        distortion: Distortion::plumb_bob([-0.08, 0.0, 0.0, 0.0, 0.0]),
        ..Lens::pinhole([1280, 800], [1900.0, 1895.0], [640.0, 750.0])
    };
    let (samples, residuals, poses) = scanned(&lens, points_per_scan, scans);
    let squared = residuals.iter().map(|residual| residual.error_px.norm_squared()).sum::<f64>();
    let rms_px = (squared / residuals.len().max(1) as f64).sqrt();
    let max_px = residuals.iter().map(|residual| residual.error_px.norm()).fold(0.0, f64::max);
    let estimate = |(parameter, value, sigma)| Estimate { parameter, value, sigma };
    let estimates = [
        (Parameter::Fx, 1900.0, 0.42),
        (Parameter::Fy, 1895.0, 0.44),
        (Parameter::Cx, 640.0, 0.31),
        (Parameter::Cy, 750.0, 0.0),
        (Parameter::K1, -0.08, 0.0011),
    ];
    let (points, inliers) = (samples.len() + samples.len() / 50, samples.len());
    let solution = Solution {
        lens,
        estimates: estimates.map(estimate).to_vec(),
        distortion: DistortionTerms::K1,
        poses,
        residuals,
        rms_px,
        held_out_rms_px: 1.03 * rms_px,
        prediction_sigma_px: 0.21,
        max_px,
        inliers,
        skew: Some(Skew { value_px: -0.31, sigma_px: 0.12 }),
    };
    let reasons = vec![
        "the depth camera's smooth error seems to be 2.1 mm RMS: average 5 scans".to_owned(),
        "\"quotes\", <tags> & 'others': # % @".to_owned(),
    ];
    let report = Report {
        solution,
        points,
        coverage: Coverage { image: 0.979, depth_m: [0.97, 1.88], scans: scans as usize },
        smooth_depth_error_m: 0.0021,
        rms_m: rms_px * 1.4 / 1900.0,
        verdict: Verdict::Usable,
        reasons,
    };
    (report, samples)
}

fn parsed(report: &Report) -> Value {
    let text = yaml::yaml(report);
    serde_yaml_ng::from_str(&text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

#[test]
fn programs_read_every_figure() {
    let (report, _) = report(500, 2);
    let yaml = parsed(&report);
    assert_eq!(yaml["verdict"], "usable");
    assert_eq!(yaml["reasons"][1].as_str().unwrap(), report.reasons[1]);
    for (key, value) in [
        ("rms_px", report.solution.rms_px),
        ("held_out_rms_px", report.solution.held_out_rms_px),
        ("prediction_sigma_px", report.solution.prediction_sigma_px),
        ("max_px", report.solution.max_px),
        ("rms_mm", 1000.0 * report.rms_m),
        ("smooth_depth_error_m", 0.0021),
    ] {
        assert!((yaml[key].as_f64().unwrap() / value - 1.0).abs() < 1e-5, "{key}");
    }
    assert_eq!((yaml["points"].as_u64(), yaml["inliers"].as_u64()), (Some(1020), Some(1000)));
    assert_eq!(yaml["coverage"]["picture"].as_f64(), Some(0.979));
    assert_eq!(yaml["coverage"]["depth_m"][1].as_f64(), Some(1.88));
    assert_eq!(yaml["coverage"]["scans"].as_u64(), Some(2));
    assert_eq!(yaml["parameters"]["fx"]["value"].as_f64(), Some(1900.0));
    assert_eq!(yaml["parameters"]["k1"]["sigma"].as_f64(), Some(0.0011));
    assert_eq!(yaml["skew_px"]["value"].as_f64(), Some(-0.31));
    assert_eq!(yaml["skew_px"]["sigma"].as_f64(), Some(0.12));
    let pose = &yaml["poses"][1];
    let expected = report.solution.poses[1].projector_from_camera.inverse();
    assert_eq!(pose["scan"].as_u64(), Some(1));
    for axis in 0..3 {
        assert_eq!(pose["position_m"][axis].as_f64(), Some(expected.translation.vector[axis]));
    }
    assert_eq!(pose["rotation_xyzw"][3].as_f64(), Some(expected.rotation.w));
    assert_eq!(pose["position_sigma_m"][2].as_f64(), Some(0.000_62));
    assert_eq!(pose["orientation_sigma_rad"][0].as_f64(), Some(0.000_12));
}

#[test]
fn the_page_is_one_file_with_everything_in_it() {
    let (report, samples) = report(500, 2);
    let page = page::page(&report, &samples, "");
    for expected in
        ["Usable.", "&lt;tags&gt; &amp; &#39;others&#39;", "camera of scan 1 and its points", "px</small>", ">fixed<"]
    {
        assert!(page.contains(expected), "{expected}");
    }
    for (tag, count) in [("<svg", 4), ("</svg>", 4), ("<html", 1), ("</html>", 1), ("<table>", 2), ("</table>", 2)] {
        assert_eq!(page.matches(tag).count(), count, "{tag}");
    }
    let without_namespace = page.replace("http://www.w3.org/2000/svg", "");
    for outside in ["http:", "https:", "<script", "url(", "@import", "src=", "href=", "NaN", "inf\""] {
        assert!(!without_namespace.contains(outside), "{outside}");
    }
}

#[test]
fn drawings_are_well_formed() {
    let (report, samples) = report(2000, 5);
    let page = page::page(&report, &samples, "");
    for svg in page.split("<svg").skip(1) {
        let svg = svg.split("</svg>").next().unwrap();
        assert_eq!(svg.matches('<').count(), svg.matches('>').count() - 1);
        assert_eq!(svg.matches('"').count() % 2, 0);
        assert_eq!(svg.matches("<text").count(), svg.matches("</text>").count());
    }
    assert!(page.len() < 400_000, "{} bytes", page.len());
}

#[test]
fn both_files_are_written_into_a_new_folder() {
    let folder = tempfile::tempdir().unwrap();
    let (report, samples) = report(100, 1);
    let path = folder.path().join("report");
    write(&path, &report, &samples).unwrap();
    write(&path, &report, &samples).unwrap();
    assert!(fs::read_to_string(path.join(PAGE_FILE)).unwrap().starts_with("<!DOCTYPE html>"));
    assert!(fs::read_to_string(path.join(YAML_FILE)).unwrap().contains("verdict: usable\n"));
    assert_eq!(fs::read_dir(&path).unwrap().count(), 2);
    let error = write(Path::new("missing/report"), &report, &samples).unwrap_err().to_string();
    assert!(error.starts_with("missing/report: cannot write: "), "{error}");
}

#[test]
fn a_calibration_with_nothing_to_show_has_a_page_too() {
    let (mut report, mut samples) = report(0, 0);
    assert!(page::page(&report, &samples, "").contains("</html>"));
    assert_eq!(parsed(&report)["poses"], Value::Sequence(Vec::new()));
    report.solution.estimates.clear();
    report.reasons.clear();
    report.coverage.depth_m = [f64::NAN; 2];
    report.solution.rms_px = f64::NAN;
    report.solution.held_out_rms_px = f64::INFINITY;
    assert!(parsed(&report)["rms_px"].as_f64().unwrap().is_nan());
    let _ = page::page(&report, &samples, "");
    // Residuals without a sample, and numbers that are none.
    let miss = Vector2::new(f64::NAN, 1.0);
    let strange = |sample| Residual { sample, error_px: miss, error_m: miss, depth_m: f64::NAN, is_inlier: true };
    report.solution.residuals = vec![strange(0), strange(1_000_000)];
    samples.push(Sample::new(Point2::new(1e9, f64::NAN), Point3::new(f64::INFINITY, 0.0, 1.0)));
    let _ = page::page(&report, &samples, "");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_figures_are_valid_yaml_and_drawn(
        figures in prop::array::uniform6(any::<f64>()),
        reasons in prop::collection::vec("\\PC{0,12}", 0..3),
        pixel in prop::array::uniform2(any::<f64>()),
        size_px in prop::array::uniform2(1..20_000_u32),
    ) {
        let (mut report, mut samples) = report(20, 1);
        let [rms, held_out, near, far, depth, miss] = figures;
        (report.solution.rms_px, report.solution.held_out_rms_px) = (rms, held_out);
        report.coverage.depth_m = [near, far];
        report.solution.residuals[0].depth_m = depth;
        report.solution.residuals[1].error_px.x = miss;
        report.solution.lens.size_px = size_px;
        samples[2].pixel = pixel.into();
        report.reasons = reasons;
        let read = parsed(&report);
        for (index, reason) in report.reasons.iter().enumerate() {
            prop_assert_eq!(read["reasons"][index].as_str(), Some(reason.as_str()));
        }
        prop_assert!(page::page(&report, &samples, "").ends_with("</html>\n"));
    }
}
