//! Tests of correspondence files.

use std::fs;

use nalgebra::{Point2, Point3};
use proptest::prelude::*;

use super::*;

fn parse(text: &str) -> Result<Correspondences, PointsError> {
    Correspondences::parse(Path::new("points.csv"), text.as_bytes())
}

fn sample(u: f64, z: f64) -> Sample {
    Sample::new(Point2::new(u, 2.0), Point3::new(0.25, -0.5, z))
}

prop_compose! {
    fn any_sample()(
        pixel in prop::array::uniform2(-20_000_000..20_000_000_i64),
        point in prop::array::uniform3(-20_000_000..20_000_000_i64),
        scan in prop_oneof![0..3_u32, any::<u32>()],
        (sigma_px, sigma_m) in (1..30_000_u32, 0..30_000_u32),
    ) -> Sample {
        Sample {
            pixel: pixel.map(|value| value as f64 / 1e4).into(),
            point: point.map(|value| value as f64 / 1e6).into(),
            scan,
            sigma_px: f64::from(sigma_px) / 1e4,
            sigma_m: f64::from(sigma_m) / 1e6,
        }
    }
}

proptest! {
    #[test]
    fn what_was_written_is_read_back(samples in prop::collection::vec(any_sample(), 0..50), with_sigmas in any::<bool>()) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("points.csv");
        let columns = if with_sigmas { PointColumns::WithSigmas } else { PointColumns::Plain };
        write_points(&path, &samples, columns).unwrap();
        let read = Correspondences::read(&[&path]).unwrap();
        let is_one_scan = distinct_scans(&samples).len() < 2;
        let mut expected = samples;
        for sample in &mut expected {
            if !with_sigmas {
                (sample.sigma_px, sample.sigma_m) = (Sample::SIGMA_PX, 0.0);
            }
            if is_one_scan {
                sample.scan = 0;
            }
        }
        prop_assert_eq!(read.samples, expected);
        prop_assert!(read.warnings.is_empty());
    }

    #[test]
    fn nothing_in_a_file_panics(text in "[u_pxvyzmscan0-9,.\\-#eE\n\r \"ä]{0,60}", rows in "[0-9,.eE\\-\nnaif]{0,60}") {
        let _ = parse(&text);
        let _ = parse(&format!("u_px,v_px,x_m,y_m,z_m\n{rows}"));
    }

    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..80)) {
        let _ = Correspondences::parse(Path::new("points.csv"), &bytes);
        let text = [b"u_px,v_px,x_m,y_m,z_m,scan\n".as_slice(), &bytes].concat();
        let _ = Correspondences::parse(Path::new("points.csv"), &text);
    }
}

#[test]
fn columns_come_in_any_order_with_comments_and_any_end_of_line() {
    let plain = parse("u_px,v_px,x_m,y_m,z_m\n1,2,0.25,-0.5,1.5\n").unwrap();
    assert_eq!(plain.samples, [sample(1.0, 1.5)]);
    for text in [
        "\u{feff}# of a head camera\r\n\r\n z_m , y_m,x_m, v_px,u_px\r\n1.5,-0.5,.25, 2 ,1\r\n",
        "u_px,v_px,x_m,y_m,z_m\n\n  # a comment, with commas\n1.0,2e0,0.25,-5E-1,+1.5",
        "u_px,v_px,x_m,y_m,z_m,scan\n1,2,0.25,-0.5,1.5,0.0\n   \n",
    ] {
        assert_eq!(parse(text).unwrap(), plain, "{text}");
    }
    let all = parse("sigma_m,u_px,v_px,x_m,y_m,z_m,scan,sigma_px\n0.001,1,2,0.25,-0.5,1.5,7,0.1\n").unwrap();
    assert_eq!(all.samples, [Sample { scan: 7, sigma_px: 0.1, sigma_m: 0.001, ..sample(1.0, 1.5) }]);
    let more = parse("u_px,v_px,x_m,y_m,z_m,colour\n1,2,0.25,-0.5,1.5,red\n").unwrap();
    assert_eq!(more.samples, plain.samples);
    assert_eq!(more.warnings, ["points.csv: column 'colour' is not known and is ignored"]);
    assert_eq!(parse("u_px,v_px,x_m,y_m,z_m\n").unwrap(), Correspondences::default());
}

#[test]
fn what_is_wrong_is_said_with_its_line_and_refused_is_not_unreadable() {
    for (text, is_refused, expected) in [
        ("", false, "points.csv: it is empty"),
        ("# only\n\n", false, "points.csv: it is empty"),
        ("u_px,v_px,x_m,y_m\n", false, "points.csv:1: the header has no column z_m"),
        ("\n1,2,3,4,5\n", false, "points.csv:2: the header has no column u_px"),
        ("u_px,v_px,x_m,y_m,z_m,u_px\n", false, "points.csv:1: the header has the column u_px twice"),
        ("u_px,v_px,x_m,y_m,z_m\n1,2,3,4,5\n1,2,3,4\n", false, "points.csv:3: 4 fields, but the header has 5"),
        ("u_px,v_px,x_m,y_m,z_m\n#\n\n1,2,3,4,5,6,7\n", false, "points.csv:4: 7 fields, but the header has 5"),
        ("u_px,v_px,x_m,y_m,z_m\r\n1,2,3,4,\r\n", false, "points.csv:2: z_m: '' is not a number"),
        ("u_px,v_px,x_m,y_m,z_m\n1,\"2\",3,4,5\n", false, "points.csv:2: v_px: '\\\"2\\\"' is not a number"),
        ("u_px,v_px,x_m,y_m,z_m,scan\n1,2,3,4,5,-1\n", false, "points.csv:2: scan: '-1' is not a whole number"),
        ("u_px,v_px,x_m,y_m,z_m,scan\n1,2,3,4,5,1.5\n", false, "points.csv:2: scan: '1.5' is not a whole number"),
        ("u_px,v_px,x_m,y_m,z_m\n1,2,3,4,nan\n", true, "points.csv:2: z_m is nan"),
        ("u_px,v_px,x_m,y_m,z_m\n1,2,-inf,4,5\n", true, "points.csv:2: x_m is -inf"),
        ("u_px,v_px,x_m,y_m,z_m\n1,2,1e999,4,5\n", true, "points.csv:2: x_m is 1e999"),
        ("u_px,v_px,x_m,y_m,z_m,scan\n1,2,3,4,5,NaN\n", true, "points.csv:2: scan is NaN"),
        ("u_px,v_px,x_m,y_m,z_m\n1,2,3,4e7,5\n", true, "points.csv:2: y_m is 4e7; no projector"),
        ("u_px,v_px,x_m,y_m,z_m,sigma_px\n1,2,3,4,5,0\n", true, "points.csv:2: sigma_px is 0; a deviation"),
        ("u_px,v_px,x_m,y_m,z_m,sigma_m\n1,2,3,4,5,-1\n", true, "points.csv:2: sigma_m is -1; a deviation"),
    ] {
        let error = parse(text).unwrap_err();
        assert_eq!(error.is_refused(), is_refused, "{error}");
        assert!(error.to_string().starts_with(expected), "{error}\n{expected}");
    }
    let long = format!("u_px,v_px,x_m,y_m,z_m\n1,2,3,4,{}\n", "xy".repeat(500));
    let error = parse(&long).unwrap_err().to_string();
    assert!(error.len() < 120 && !error.contains('\n'), "{error}");
    let error = Correspondences::read(&["missing/points.csv"]).unwrap_err();
    assert!(error.to_string().starts_with("missing/points.csv: ") && !error.is_refused(), "{error}");
}

#[test]
fn the_line_of_an_error_is_right_in_a_long_file() {
    let mut text = "# comment\nu_px,v_px,x_m,y_m,z_m\n".to_owned();
    for row in 0..60_000 {
        text += if row % 7 == 0 { "\n" } else { "100.5,200.5,0.123456,0.2,1.5\n" };
    }
    assert_eq!(parse(&text).unwrap().samples.len(), 60_000 - 60_000_usize.div_ceil(7));
    let error = parse(&format!("{text}1,2,3,4,nan\n1,2\n")).unwrap_err().to_string();
    assert_eq!(error, "points.csv:60003: z_m is nan");
}

#[test]
fn scans_of_different_files_are_different_scans() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, scans: &[u32]| {
        let path = folder.path().join(name);
        let rows = scans.iter().map(|scan| format!("1,2,3,4,5,{scan}\n"));
        fs::write(&path, format!("u_px,v_px,x_m,y_m,z_m,scan\n{}", rows.collect::<String>())).unwrap();
        path
    };
    let plain = |name: &str| {
        let path = folder.path().join(name);
        fs::write(&path, "u_px,v_px,x_m,y_m,z_m\n1,2,3,4,5\n").unwrap();
        path
    };
    let numbers = |paths: &[PathBuf]| -> Vec<u32> {
        Correspondences::read(paths).unwrap().samples.iter().map(|sample| sample.scan).collect()
    };
    let (a, b, c) = (plain("a.csv"), plain("b.csv"), plain("c.csv"));
    assert_eq!(numbers(&[a.clone(), b.clone(), c.clone()]), [0, 1, 2]);
    let (kept, same, apart) = (file("kept.csv", &[7, 3, 7]), file("same.csv", &[3, 5]), file("apart.csv", &[1]));
    assert_eq!(numbers(&[kept.clone(), apart.clone()]), [7, 3, 7, 1], "numbers stay if they are not shared");
    assert_eq!(numbers(&[kept.clone(), same.clone(), a.clone(), b.clone()]), [7, 3, 7, 8, 10, 0, 11]);
    assert_eq!(numbers(&[a.clone(), a.clone()]), [0, 1], "a file that is given twice is two scans");
    let scans = Correspondences::read(&[&kept, &same]).unwrap().scans;
    let described: Vec<_> = scans.iter().map(|scan| (scan.number, scan.number_in_file, scan.path.clone())).collect();
    assert_eq!(described, [(3, 3, kept.clone()), (7, 7, kept), (8, 3, same.clone()), (10, 5, same)]);
    let largest = file("largest.csv", &[u32::MAX]);
    let error = Correspondences::read(&[&largest, &largest]).unwrap_err().to_string();
    assert!(error.contains("too large"), "{error}");
}

#[test]
fn files_have_the_documented_columns() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("points.csv");
    let one = Sample { sigma_m: 0.0012, ..sample(612.25, 1.254) };
    let text = |samples: &[Sample], columns| {
        write_points(&path, samples, columns).unwrap();
        fs::read_to_string(&path).unwrap()
    };
    let row = "612.2500,2.0000,0.250000,-0.500000,1.254000";
    assert_eq!(text(&[one], PointColumns::Plain), format!("u_px,v_px,x_m,y_m,z_m\n{row}\n"));
    let several = text(&[one, Sample { scan: 4, ..one }], PointColumns::WithSigmas);
    let header = "u_px,v_px,x_m,y_m,z_m,scan,sigma_px,sigma_m";
    assert_eq!(several, format!("{header}\n{row},0,0.3000,0.001200\n{row},4,0.3000,0.001200\n"));
    write_pixels(&path, [([3, 4], Point2::new(10.25, 7.125))]).unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "cam_u_px,cam_v_px,u_px,v_px\n3,4,10.2500,7.1250\n");
    let error = write_points(Path::new("missing/points.csv"), &[], PointColumns::Plain).unwrap_err().to_string();
    assert!(error.starts_with("missing/points.csv: cannot write: "), "{error}");
}

#[test]
fn places_need_no_pixels() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("things.csv");
    std::fs::write(&path, "name,z_m,x_m,y_m\nmug,1.5,0.25,-0.5\n\nbox,2,0,1\n").unwrap();
    let places = read_places(&path).unwrap();
    assert_eq!(places, [Point3::new(0.25, -0.5, 1.5), Point3::new(0.0, 1.0, 2.0)]);
    std::fs::write(&path, "x_m,y_m\n1,2\n").unwrap();
    assert!(read_places(&path).unwrap_err().to_string().ends_with("things.csv:1: the header has no column z_m"));
}
