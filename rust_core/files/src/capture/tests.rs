//! Tests of capture folders: what was written is read back, and what is wrong is reported with file and line.

use std::fs;
use std::path::Path;

use nalgebra::UnitQuaternion;
use proptest::prelude::*;
use rcs_calibration::patterns::{gray_code, shifted_gray_code, Axis, Pattern, Stripes};
use rcs_calibration::{Distortion, Lens};
use rcs_scene::{Encoding, Image};
use tempfile::{tempdir, TempDir};

use super::*;
use crate::image_file;
use crate::projector::StaticFrame;

const SIZE: [u32; 2] = [6, 4];

fn capture() -> Capture {
    let lens = Lens::pinhole(SIZE, [525.0, 520.5], [2.5, 1.5]);
    let images = gray_code([5, 3]).into_iter().enumerate().map(|(index, pattern)| {
        let grey = (0..24).map(|pixel| (pixel * 7 + index * 31) as u8).collect();
        PatternImage { pattern, grey }
    });
    Capture {
        projector_size_px: [5, 3],
        camera: Lens { distortion: Distortion::plumb_bob([-0.2, 0.1, 0.001, 0.0, 0.0]), ..lens },
        is_camera_calibrated: true,
        camera_frame_id: "head_camera_rgb_optical_frame".to_owned(),
        images: images.collect(),
        depth_m: Some((0..24_u16).map(|value| f32::from(value) * 0.25).collect()),
        robot: robot(),
        warnings: Vec::new(),
    }
}

fn robot() -> CapturedRobot {
    let frame = |parent: &str, child: &str, motion, joint: Option<&str>| {
        let rotation = UnitQuaternion::from_euler_angles(0.1, -0.7, 2.0);
        let (parent, child) = (parent.to_owned(), child.to_owned());
        let frame = StaticFrame { parent, child, translation_m: [0.1, -1e-7, 0.333], rotation };
        CapturedFrame { frame, motion, joint: joint.map(str::to_owned) }
    };
    CapturedRobot {
        description: Some("<robot name=\"ü\"/>\n".to_owned()),
        frames: vec![
            frame("head", "head_camera_rgb_optical_frame", FrameMotion::Fixed, None),
            frame("torso", "head", FrameMotion::Revolute, Some("pan \"joint\"")),
            frame("odom", "torso", FrameMotion::Moving, None),
        ],
    }
}

fn written() -> TempDir {
    let folder = tempdir().unwrap();
    capture().write(folder.path()).unwrap();
    folder
}

fn error(folder: &TempDir) -> String {
    let error = Capture::read(folder.path()).unwrap_err().to_string();
    assert!(!error.contains('\n'), "{error}");
    error.replace(&format!("{}/", folder.path().display()), "")
}

fn error_after(change: impl Fn(String) -> String) -> String {
    let folder = written();
    let path = folder.path().join(CAPTURE_FILE);
    fs::write(&path, change(fs::read_to_string(&path).unwrap())).unwrap();
    error(&folder)
}

#[test]
fn what_was_written_is_read_back() {
    let folder = written();
    assert_eq!(Capture::read(folder.path()).unwrap(), capture());
    let mut flat = capture();
    flat.depth_m = None;
    flat.camera_frame_id.clear();
    flat.robot = CapturedRobot::default();
    flat.write(folder.path()).unwrap();
    assert_eq!(Capture::read(folder.path()).unwrap(), flat);
}

#[test]
fn frames_must_be_a_chain_of_numbers_and_known_motions() {
    let wrong = |from: &str, to: &str, expected: &str| {
        let error = error_after(|text| text.replacen(from, to, 1));
        assert!(error.starts_with("capture.yaml: ") && error.contains(expected), "{error}");
    };
    wrong("child: \"head\"", "child: \"neck\"", "frame 'neck' follows 'head_camera_rgb_optical_frame', whose parent");
    wrong("motion: revolute", "motion: turning", "turning");
    wrong("0.333", ".nan", "not a finite number");
    wrong("parent: \"head\"", "parent: \"\"", "need names");
    let mut unwritable = capture();
    unwritable.robot.frames.remove(1);
    let error = unwritable.write(tempdir().unwrap().path()).unwrap_err().to_string();
    assert!(error.contains("frame 'torso' follows"), "{error}");
}

fn any_pattern() -> impl Strategy<Value = Pattern> {
    let stripes =
        (any::<bool>(), 1..=16_u32, any::<prop::sample::Index>(), 1..=16_384_u32, 0..=32_768_u32, any::<bool>());
    let stripes = stripes.prop_map(|(is_x, bits, bit, step, offset, inverted)| {
        let (axis, bit) = (if is_x { Axis::X } else { Axis::Y }, bit.index(bits as usize) as u32);
        Pattern::GrayCode(Stripes { axis, bits, bit, step, offset, inverted })
    });
    prop_oneof![Just(Pattern::White), Just(Pattern::Black), stripes]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn any_capture_is_read_back(
        projector_size_px in prop::array::uniform2(1..=MOST_PIXELS),
        size_px in prop::array::uniform2(1..9_u32),
        patterns in prop::collection::vec(any_pattern(), 1..12),
        depth_values in proptest::option::of(prop::collection::vec(any::<u16>(), 64)),
        frame in "[a-z/\"\\\\ ]{0,5}",
        seed in any::<u8>(),
    ) {
        let count = (size_px[0] * size_px[1]) as usize;
        let depth_m = depth_values.map(|values| {
            let metres = values.iter().take(count).map(|value| (f64::from(*value) * DEPTH_SCALE_M) as f32);
            metres.collect()
        });
        let grey: Vec<u8> = (0..count).map(|index| (index as u8).wrapping_mul(29).wrapping_add(seed)).collect();
        let images = patterns.into_iter().map(|pattern| PatternImage { pattern, grey: grey.clone() });
        let capture = Capture {
            projector_size_px,
            camera: Lens::pinhole(size_px, [500.25, 501.0], [-3.0, 1e3]),
            is_camera_calibrated: true,
            camera_frame_id: frame,
            images: images.collect(),
            depth_m,
            robot: CapturedRobot::default(),
            warnings: Vec::new(),
        };
        let folder = tempdir().unwrap();
        capture.write(folder.path()).unwrap();
        prop_assert_eq!(Capture::read(folder.path()).unwrap(), capture);
    }

    #[test]
    fn nothing_in_the_file_panics(position in any::<prop::sample::Index>(), garbage in "\\PC{0,6}") {
        let folder = written();
        let path = folder.path().join(CAPTURE_FILE);
        let mut text = fs::read_to_string(&path).unwrap();
        let at = position.index(text.len());
        text.replace_range(at..(at + garbage.len()).min(text.len()), &garbage);
        fs::write(&path, text).unwrap();
        if let Err(error) = Capture::read(folder.path()) {
            prop_assert!(error.to_string().starts_with(&folder.path().display().to_string()), "{error}");
        }
    }
}

#[test]
fn depths_that_are_none_are_zero() {
    let mut capture = capture();
    capture.depth_m = Some([f32::NAN, f32::INFINITY, -1.0, 0.0, 6.6, 1.000_04].repeat(4));
    let folder = tempdir().unwrap();
    capture.write(folder.path()).unwrap();
    let read = Capture::read(folder.path()).unwrap().depth_m.unwrap();
    assert_eq!(read[..6], [0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
}

#[test]
fn a_capture_is_replaced_and_its_files_are_gone() {
    let folder = written();
    fs::write(folder.path().join("notes.png"), "mine").unwrap();
    let count = || fs::read_dir(folder.path()).unwrap().count();
    let before = count();
    let mut changed = capture();
    for round in 1..4 {
        changed.images[0].grey[0] = round;
        changed.write(folder.path()).unwrap();
        assert_eq!(Capture::read(folder.path()).unwrap(), changed);
        assert_eq!(count(), before, "no file of the capture before is left");
    }
}

/// Found by fuzzing: `c7.d/grey` went, because its last point was taken for that of an ending.
#[test]
fn images_of_names_that_no_writer_gives_stay_when_a_capture_is_replaced() {
    let names = ["c7.d/grey", "c7.png", "c001.PNG", "depth.d/c000.png", "camera_info.d/0", "camera_info_2.png"];
    let folder = written();
    let image = fs::read(folder.path().join("c000.png")).unwrap();
    let path = folder.path().join(CAPTURE_FILE);
    let mut text = "projector: {width: 5, height: 3}\ncamera_info: camera_info.yaml\npatterns:\n".to_owned();
    for name in names {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, &image).unwrap();
        text += &format!("  - {{file: {name}, kind: white}}\n");
    }
    fs::write(&path, text).unwrap();
    assert_eq!(Capture::read(folder.path()).unwrap().images.len(), names.len());
    capture().write(folder.path()).unwrap();
    assert_eq!(Capture::read(folder.path()).unwrap(), capture());
    let gone: Vec<_> = names.into_iter().filter(|name| !folder.path().join(name).exists()).collect();
    assert!(gone.is_empty(), "{gone:?}");
    assert!(!folder.path().join("camera_info.yaml").exists(), "the one before is replaced by another");
}

#[test]
fn an_interrupted_writer_leaves_the_capture_of_before() {
    let folder = written();
    let mut changed = capture();
    changed.images[0].grey[0] = 77;
    // The last file cannot be written where a folder is in the way of the unfinished one.
    let in_the_way = folder.path().join(format!(".{CAPTURE_FILE}.{}.part", std::process::id()));
    fs::create_dir(&in_the_way).unwrap();
    changed.write(folder.path()).unwrap_err();
    assert_eq!(Capture::read(folder.path()).unwrap(), capture());
    fs::remove_dir(&in_the_way).unwrap();
    changed.write(folder.path()).unwrap();
    assert_eq!(Capture::read(folder.path()).unwrap(), changed);
}

#[test]
fn colours_become_luma_and_opacity_does_not_count() {
    let folder = written();
    let pixels: Vec<u8> = [[255, 0, 0], [0, 255, 0], [0, 0, 255]].concat().repeat(8);
    let image = Image { width_px: 6, height_px: 4, encoding: Encoding::Rgb8, data: pixels };
    image_file::write(&folder.path().join("c000.png"), &image).unwrap();
    let rgba = image::RgbaImage::from_pixel(6, 4, image::Rgba([10, 20, 30, 0]));
    rgba.save(folder.path().join("c001.png")).unwrap();
    let read = Capture::read(folder.path()).unwrap();
    assert_eq!(read.images[0].grey[..3], [76, 150, 29]);
    assert_eq!(read.images[1].grey[0], 18);
}

#[test]
fn a_list_without_indentation_and_depth_is_read() {
    let folder = written();
    let path = folder.path().join(CAPTURE_FILE);
    let text = fs::read_to_string(&path).unwrap();
    let text = text.lines().filter(|line| !line.starts_with("depth")).map(|line| line.trim_start().to_owned() + "\r\n");
    fs::write(&path, text.collect::<String>()).unwrap();
    let read = Capture::read(folder.path()).unwrap();
    assert_eq!((read.images, read.depth_m), (capture().images, None));
}

#[test]
fn a_camera_without_camera_info_is_read_back() {
    let folder = tempdir().unwrap();
    let uncalibrated = Capture { is_camera_calibrated: false, ..capture() };
    uncalibrated.write(folder.path()).unwrap();
    assert_eq!(Capture::read(folder.path()).unwrap(), uncalibrated);
}

#[test]
fn a_byte_order_mark_before_the_list_changes_nothing() {
    let folder = written();
    let path = folder.path().join(CAPTURE_FILE);
    fs::write(&path, format!("\u{feff}{}", fs::read_to_string(&path).unwrap())).unwrap();
    assert_eq!(Capture::read(folder.path()).unwrap().images, capture().images);
}

#[test]
fn a_missing_scale_is_a_tenth_of_a_millimetre_and_unknown_keys_are_warnings() {
    let folder = written();
    let path = folder.path().join(CAPTURE_FILE);
    let text = fs::read_to_string(&path).unwrap().replace("depth_scale_m: 0.0001\n", "\"gam\\nma\": 2.2\n");
    fs::write(&path, text.replacen("kind: white", "kind: white, exposure: 3", 1)).unwrap();
    let read = Capture::read(folder.path()).unwrap();
    assert_eq!(read.depth_m, capture().depth_m);
    let warnings = read.warnings.join("\n");
    assert!(warnings.contains("capture.yaml: key 'gam ma' is not known"), "{warnings}");
    assert!(warnings.contains("key 'patterns.0.exposure' is not known"), "{warnings}");
}

#[test]
fn what_is_wrong_in_the_list_is_said_with_its_line() {
    let change = |from: &'static str, to: &'static str| {
        error_after(move |text| {
            assert!(text.contains(from), "{from}\n{text}");
            text.replacen(from, to, 1)
        })
    };
    for (from, to, expected) in [
        ("bit: 0", "bit: 3", "there is no bit 3 of 3"),
        ("step: 1", "step: 0", "a whole number from 1 to"),
        ("bits: 3", "bits: 17", "a whole number from 1 to 16"),
        ("offset: 0", "offset: -1", "a whole number from 0 to"),
        ("kind: gray_code", "kind: grey_code", "unknown variant `grey_code`"),
        ("kind: white", "kind: \"w\\nhite\"", "unknown variant `w hite`"),
        ("axis: x", "axis: z", "unknown variant `z`"),
        ("axis: x, ", "", "missing field `axis`"),
        (", inverted: false", "", "missing field `inverted`"),
        ("step: 1", "step: 1, step: 2", "duplicate"),
        ("file: c002.png, ", "", "missing field `file`"),
        ("file: c002.png", "file: ../c002.png", "\"../c002.png\" is not in the folder"),
        ("file: c002.png", "file: /etc/passwd", "\"/etc/passwd\" is not in the folder"),
        ("file: c002.png", "file: c001.png", "\"c001.png\" is listed twice"),
        ("file: c002.png", "file: \"c\\n2.png\"", "\"c\\n2.png\" is not a file's name"),
        ("file: c002.png", "file: ''", "\"\" is not a file's name"),
        ("width: 5", "width: 0", "a whole number from 1 to 16384"),
        ("width: 5", "width: 5.5", "a whole number"),
        ("depth_scale_m: 0.0001", "depth_scale_m: .nan", "a finite number above 0"),
        ("depth_scale_m: 0.0001", "depth_scale_m: .inf", "a finite number above 0"),
        ("depth_scale_m: 0.0001", "depth_scale_m: -1", "a finite number above 0"),
        ("camera_info: camera_info.yaml\n", "", "missing field `camera_info`"),
        ("projector: {width: 5, height: 3}\n", "", "missing field `projector`"),
        ("camera_info: ", "camera_info: x\ncamera_info: ", "duplicate"),
        ("patterns:\n", "patterns: []\nx:\n", "the list is empty"),
    ] {
        let error = change(from, to);
        assert!(error.starts_with("capture.yaml: ") && error.contains(expected), "{to}: {error}");
        // The whole file has no line.
        assert!(error.contains(" line ") || error.contains("field `"), "{to}: {error}");
    }
    let many = |text: String| {
        let entry = |index| format!("  - {{file: m{index}.png, kind: white}}\n");
        text.replacen("patterns:\n", &format!("patterns:\n{}", (0..1001).map(entry).collect::<String>()), 1)
    };
    assert!(error_after(many).contains("more than 1000 patterns"));
    assert!(error_after(|text| text + &"# long\n".repeat(700_000)).contains("larger than 4 MB"));
}

#[test]
fn what_is_wrong_with_a_image_is_said_with_its_file() {
    let with = |name: &str, make: &dyn Fn(&Path)| {
        let folder = written();
        let path = folder.path().join(name);
        fs::remove_file(&path).unwrap();
        make(&path);
        error(&folder)
    };
    let save16 = |path: &Path| image::ImageBuffer::<image::Luma<u16>, _>::new(6, 4).save(path).unwrap();
    let save8 = |path: &Path| image::GrayImage::new(6, 4).save(path).unwrap();
    let save_small = |path: &Path| image::GrayImage::new(5, 4).save(path).unwrap();
    assert_eq!(with("c003.png", &save16), "c003.png: 1 channel of 16 bits where 8 bits is needed");
    assert_eq!(with("c003.png", &save_small), "c003.png: 5x4 pixels where the CameraInfo says 6x4");
    assert_eq!(with("depth.png", &save8), "depth.png: 1 channel of 8 bits where 16-bit grey is needed");
    assert!(with("c003.png", &|_| ()).starts_with("c003.png: No such file"));
    assert!(with("capture.yaml", &|_| ()).starts_with("capture.yaml: No such file"));
    assert!(with("camera_info.yaml", &|_| ()).starts_with("camera_info.yaml: No such file"));
    assert_eq!(
        with("c003.png", &|path| fs::create_dir(path).unwrap()),
        "c003.png: it is a folder, only regular files are read"
    );
    let garbage = |path: &Path| fs::write(path, "GIF89a").unwrap();
    assert!(with("c003.png", &garbage).starts_with("c003.png: invalid image: "));
    let cut = |path: &Path| {
        let whole = fs::read(path.with_file_name("c000.png")).unwrap();
        fs::write(path, &whole[..whole.len() - 30]).unwrap();
    };
    assert!(with("c003.png", &cut).starts_with("c003.png: invalid image: "));
    let bad =
        |path: &Path| fs::write(path, "width: 6\nheight: 4\nK: [0, 0, 0, 0, 0, 0, 0, 0, 0]\nP: [1, 0, 0]\n").unwrap();
    assert!(with("camera_info.yaml", &bad).contains("line 4"), "{}", with("camera_info.yaml", &bad));
    let uncalibrated =
        |path: &Path| fs::write(path, "width: 6\nheight: 4\nP: [9, 0, 3, 0, 0, -9, 2, 0, 0, 0, 1, 0]\n").unwrap();
    let error = with("camera_info.yaml", &uncalibrated);
    assert!(error.starts_with("camera_info.yaml: K: the focal lengths"), "{error}");
    let huge = |path: &Path| fs::write(path, "width: 16385\nheight: 4\nK: [9, 0, 3, 0, 9, 2, 0, 0, 1]\n").unwrap();
    assert!(with("camera_info.yaml", &huge).contains("16385x4 pixels; the most is 16384"));
    let huge = |path: &Path| fs::write(path, "width: 16384\nheight: 16384\nK: [9, 0, 3, 0, 9, 2, 0, 0, 1]\n").unwrap();
    assert_eq!(with("camera_info.yaml", &huge), "c000.png: 6x4 pixels where the CameraInfo says 16384x16384");
}

#[test]
fn images_are_read_in_each_lossless_format_that_holds_them() {
    use image::ImageFormat::{Bmp, Png, Pnm, Tiff, WebP};
    let folder = written();
    let expected = Capture::read(folder.path()).unwrap();
    for (name, formats) in [("c003.png", &[Pnm, WebP, Bmp, Tiff, Png][..]), ("depth.png", &[Pnm, Tiff])] {
        for format in formats {
            let path = folder.path().join(name);
            let image = image::ImageReader::open(&path).unwrap().with_guessed_format().unwrap().decode().unwrap();
            image.save_with_format(&path, *format).unwrap();
            assert_eq!(Capture::read(folder.path()).unwrap(), expected, "{name} as {format:?}");
        }
    }
}

#[test]
fn what_could_not_be_read_again_is_not_written() {
    type Change = fn(&mut Capture);
    let cases: [(Change, &str); 6] = [
        (|capture| capture.projector_size_px[1] = 0, "a projector of 5x0 pixels"),
        (|capture| capture.images.clear(), "0 patterns"),
        (|capture| capture.images[2].grey.truncate(5), "picture 2 has 5 pixels, but the camera 6x4"),
        (|capture| capture.depth_m = Some(vec![1.0]), "the depth has 1 pixels"),
        (|capture| capture.camera.focal_px.x = f64::NAN, "the camera's K"),
        (
            |capture| {
                let stripes = Stripes { axis: Axis::X, bits: 3, bit: 3, step: 1, offset: 0, inverted: false };
                capture.images[1].pattern = Pattern::GrayCode(stripes);
            },
            "pattern 1 is invalid",
        ),
    ];
    for (change, expected) in cases {
        let folder = tempdir().unwrap();
        let mut capture = capture();
        change(&mut capture);
        let error = capture.write(folder.path()).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }
    let error = capture().write(Path::new("missing/folder")).unwrap_err().to_string();
    assert!(error.starts_with("missing/folder: cannot write: "), "{error}");
}

#[test]
fn patterns_are_written_as_images_with_a_list() {
    let folder = tempdir().unwrap();
    for patterns in [gray_code([37, 23]), shifted_gray_code([37, 23], 4)] {
        write_patterns(folder.path(), [37, 23], &patterns).unwrap();
        let list = read_patterns(&folder.path().join(PATTERNS_FILE)).unwrap();
        assert_eq!((list.projector_size_px, list.warnings.len()), ([37, 23], 0));
        assert_eq!(list.patterns.len(), patterns.len());
        for ((path, read), pattern) in list.patterns.iter().zip(&patterns) {
            assert_eq!(read, pattern);
            assert_eq!(image::open(path).unwrap().into_luma8().into_raw(), pattern.image([37, 23]));
        }
    }
}

#[test]
fn a_list_of_patterns_looks_like_the_documented_one() {
    let folder = tempdir().unwrap();
    write_patterns(folder.path(), [1280, 800], &gray_code([1280, 800])).unwrap();
    let text = fs::read_to_string(folder.path().join(PATTERNS_FILE)).unwrap();
    let documented = "\
projector: {width: 1280, height: 800}
patterns:
  - {file: p000.png, kind: white}
  - {file: p001.png, kind: black}
  - {file: p002.png, kind: gray_code, axis: x, bits: 11, bit: 0, step: 1, offset: 0, inverted: false}
";
    assert!(text.starts_with(documented), "{text}");
    assert_eq!(text.lines().count(), 46);
}

#[test]
fn links_that_lead_out_of_the_folder_are_refused_and_others_are_followed() {
    use std::os::unix::fs::symlink;

    let (folder, elsewhere) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let path = |name: &str| folder.path().join(name);
    capture().write(folder.path()).unwrap();
    for name in ["c001.png", "camera_info.yaml", "depth.png"] {
        fs::rename(path(name), path("moved")).unwrap();
        symlink("moved", path(name)).unwrap();
        Capture::read(folder.path()).unwrap();
        let outside = elsewhere.path().join("other");
        fs::rename(path("moved"), &outside).unwrap();
        fs::remove_file(path(name)).unwrap();
        symlink(&outside, path(name)).unwrap();
        let error = Capture::read(folder.path()).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains("which is not in the capture's folder"), "{error}");
        // A folder of the name, which the name leads into, is no better.
        fs::remove_file(path(name)).unwrap();
        fs::rename(&outside, path(name)).unwrap();
    }
    symlink(elsewhere.path(), path("sub")).unwrap();
    fs::copy(path("c001.png"), elsewhere.path().join("c001.png")).unwrap();
    let yaml = fs::read_to_string(path(CAPTURE_FILE)).unwrap().replace("c001.png", "sub/c001.png");
    fs::write(path(CAPTURE_FILE), yaml).unwrap();
    let error = Capture::read(folder.path()).unwrap_err().to_string();
    assert!(error.contains("sub/c001.png: a link to"), "{error}");
}

#[test]
fn a_capture_and_patterns_are_not_written_where_links_lead() {
    use std::os::unix::fs::symlink;

    let (folder, elsewhere) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let names = ["c000.png", "camera_info.yaml", "depth.png", CAPTURE_FILE, "p000.png", PATTERNS_FILE];
    for name in names {
        fs::write(elsewhere.path().join(name), "of somebody else").unwrap();
        symlink(elsewhere.path().join(name), folder.path().join(name)).unwrap();
    }
    capture().write(folder.path()).unwrap();
    write_patterns(folder.path(), [8, 8], &[Pattern::White]).unwrap();
    for name in names {
        assert_eq!(fs::read_to_string(elsewhere.path().join(name)).unwrap(), "of somebody else", "{name}");
        assert!(fs::symlink_metadata(folder.path().join(name)).unwrap().is_file(), "{name}");
    }
    assert_eq!(Capture::read(folder.path()).unwrap().images, capture().images);
}
