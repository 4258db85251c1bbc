//! Tests of editing a pose in place.

use super::*;
use proptest::prelude::*;
use std::f64::consts::FRAC_PI_2;

const HEAD: &str = "\
# Measured on Monday, größer als gedacht.
width:   1280   # native
height: 800
K: [1900, 0.0, 640, 0, 1900, 750, 0, 0, 1]
camera_info_topic: '/proj/camera_info'
frames:   # metres
";
const TAIL: &str = "  - {parent: proj_view, child: after, translation: [1, 2, 3]}   # another\nframe_id: proj_view\n";

/// A file whose frame `proj_view` has this entry.
fn file(entry: &str) -> String {
    let link = "  - {parent: base, child: proj_link, translation: [0.05, 0, 1.3], rotation_rpy: [0, 0.77, 0]}\n";
    [HEAD, link, entry, TAIL].concat()
}

fn pose(translation: [f64; 3], [roll, pitch, yaw]: [f64; 3]) -> Isometry3<f64> {
    Isometry3::from_parts(translation.into(), UnitQuaternion::from_euler_angles(roll, pitch, yaw))
}

fn edit(text: &str, pose: &Isometry3<f64>) -> Result<String, FileError> {
    text_with_pose(Path::new("projector.yaml"), text, "proj_view", pose)
}

/// The pose of the frame in a text.
fn pose_in(text: &str) -> Isometry3<f64> {
    let file = ProjectorFile::parse(Path::new("projector.yaml"), text).unwrap();
    file.frames.iter().find(|frame| frame.child == "proj_view").unwrap().parent_from_child()
}

#[test]
fn each_form_is_written_in_its_form_and_only_its_numbers_change() {
    let moved = pose([0.111, 0.06, 0.05], [-FRAC_PI_2, 0.0, -FRAC_PI_2]);
    let cases = [
        (
            "  - {parent: proj_link, child: proj_view, translation: [0.110 , 6e-2, 0.05], \
             rotation_rpy: [-1.5707963267948966, 0, -1.5707963267948966]}\n",
            "  - {parent: proj_link, child: proj_view, translation: [0.111 , 6e-2, 0.05], \
             rotation_rpy: [-1.5707963267948966, 0, -1.5707963267948966]}\n",
        ),
        (
            "  - parent: proj_link\n    # the lens\n    translation:\n      - 0.110   # right\n      - 0.06\n      - 0.05\n    \
             child: \"/proj_view\"\n    rotation_xyzw: [0.5, -0.5, 0.5, -0.5]\n",
            "  - parent: proj_link\n    # the lens\n    translation:\n      - 0.111   # right\n      - 0.06\n      - 0.05\n    \
             child: \"/proj_view\"\n    rotation_xyzw: [0.5, -0.5, 0.5, -0.5]\n",
        ),
        (
            "  - 0.11  .06 0.05 -1.5707963267948966 0 -1.5707963267948966 proj_link proj_view 100 # 10 Hz\n",
            "  - 0.111  .06 0.05 -1.5707963267948966 0 -1.5707963267948966 proj_link proj_view 100 # 10 Hz\n",
        ),
        (
            "  - '0.11 0.06 0.05 -0.5 0.5 -0.5 0.5 /proj_link /proj_view'  # 'measured'\n",
            "  - '0.111 0.06 0.05 -0.5 0.5 -0.5 0.5 /proj_link /proj_view'  # 'measured'\n",
        ),
        (
            "  - >\n    0.11 0.06 0.05 -0.5 0.5 -0.5 0.5\n    proj_link proj_view\n",
            "  - >\n    0.111 0.06 0.05 -0.5 0.5 -0.5 0.5\n    proj_link proj_view\n",
        ),
        (
            "  - {parent: proj_link, child: proj_view, transform: \"0.11 0.06 0.05 -1.5707963267948966 0 \
             -1.5707963267948966\"}\n",
            "  - {parent: proj_link, child: proj_view, transform: \"0.111 0.06 0.05 -1.5707963267948966 0 \
             -1.5707963267948966\"}\n",
        ),
    ];
    for (before, after) in cases {
        for (mark, line_end) in [("", "\n"), ("\u{feff}", "\r\n"), ("%YAML:1.0\n", "\n")] {
            let text = |entry: &str| format!("{mark}{}", file(entry).replace('\n', line_end));
            assert_eq!(edit(&text(before), &moved).unwrap(), text(after));
        }
    }
}

#[test]
fn a_missing_key_is_added_before_the_child() {
    let moved = pose([0.0, 0.25, 0.0], [0.0, 0.0, 0.5]);
    let added = "translation: [0.0, 0.25, 0.0]";
    let turned = "rotation_rpy: [0.0, 0.0, 0.5]";
    let cases = [
        (
            "  - {parent: proj_link, child: proj_view}\n",
            format!("  - {{parent: proj_link, {added}, {turned}, child: proj_view}}\n"),
        ),
        (
            "  -  child: proj_view   # lens\n     parent: proj_link\n",
            format!("  -  {added}\n     {turned}\n     child: proj_view   # lens\n     parent: proj_link\n"),
        ),
        (
            "  - {parent: proj_link, child: proj_view, translation: [0, 0.25, 0]}\n",
            format!("  - {{parent: proj_link, {turned}, child: proj_view, translation: [0, 0.25, 0]}}\n"),
        ),
    ];
    for (before, after) in cases {
        assert_eq!(edit(&file(before), &moved).unwrap(), file(&after));
    }
    let unchanged = file("  - {parent: proj_link, child: proj_view}\n");
    assert_eq!(edit(&unchanged, &Isometry3::identity()).unwrap(), unchanged);
}

#[test]
fn a_form_that_cannot_be_edited_is_refused() {
    let moved = pose([0.111, 0.06, 0.05], [0.0; 3]);
    let cases = [
        "  - &lens {parent: proj_link, child: proj_view, translation: &t [0, 0, 0]}\n  \
         - {parent: x, child: y, translation: *t}\n",
        "  - \"0 0 0 0 0 0\\x20proj_link proj_view\"\n",
    ];
    for entry in cases {
        let error = edit(&file(entry), &moved).unwrap_err().to_string();
        assert!(error.contains("frames: the entry of 'proj_view'") && error.contains("write it as"), "{error}");
    }
    let error = text_with_pose(Path::new("p.yaml"), &file(""), "nowhere", &moved).unwrap_err().to_string();
    assert_eq!(error, "p.yaml: frames: no entry has the child 'nowhere'");
}

#[test]
fn angles_stay_near_those_of_the_file_also_at_a_gimbal_lock() {
    for near in [
        [0.1, FRAC_PI_2, 0.3],
        [0.0, FRAC_PI_2 + 4e-6, 0.0],
        [PI, 0.0, -PI],
        [3.2, 2e-8 - FRAC_PI_2, 0.4],
        [7.0, 1.0, -6.0],
    ] {
        let rotation = UnitQuaternion::from_euler_angles(near[0], near[1], near[2]);
        let found = rpy_near(&rotation, near);
        for (found, near) in found.iter().zip(&near) {
            assert!((found - near).abs() < 1e-7, "{found} {near}");
        }
    }
}

#[test]
fn a_file_is_replaced_with_its_permissions_and_a_read_only_one_is_not() {
    use std::os::unix::fs::{symlink, PermissionsExt};

    let folder = tempfile::tempdir().unwrap();
    let (path, link) = (folder.path().join("projector.yaml"), folder.path().join("link.yaml"));
    let entry = "  - {parent: proj_link, child: proj_view, translation: [1, 2, 3]}\n";
    fs::write(&path, file(entry)).unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
    symlink("projector.yaml", &link).unwrap();
    let written = write_pose(&link, "/proj_view", &pose([1.0, 2.5, 3.0], [0.0; 3])).unwrap();
    assert_eq!(written, ProjectorFile::read(&path).unwrap());
    assert_eq!(fs::read_to_string(&path).unwrap(), file(&entry.replace("2,", "2.5,")));
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o640);

    fs::set_permissions(&path, fs::Permissions::from_mode(0o440)).unwrap();
    let error = write_pose(&path, "proj_view", &Isometry3::identity()).unwrap_err().to_string();
    assert!(error.ends_with("projector.yaml: cannot write: the file is read-only"), "{error}");
    assert_eq!(fs::read_to_string(&path).unwrap(), file(&entry.replace("2,", "2.5,")));
    assert!(check_writable(folder.path()).is_err() && check_writable(Path::new("missing.yaml")).is_err());
    assert_eq!(fs::read_to_string(folder.path().join("link.yaml.1")).unwrap(), file(entry));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 3);
}

proptest! {
    #[test]
    fn any_pose_is_written_and_all_other_bytes_stay(
        form in 0..6_usize,
        translation in prop::array::uniform3(-20.0..20.0),
        rpy in prop::array::uniform3(prop_oneof![-PI..PI, Just(FRAC_PI_2), Just(0.0)]),
        nudge in prop::array::uniform3(-0.5..0.5),
    ) {
        let [[x, y, z], [roll, pitch, yaw]] = [translation, rpy];
        let xyzw: [f64; 4] = UnitQuaternion::from_euler_angles(roll, pitch, yaw).coords.into();
        let [i, j, k, w] = xyzw;
        let head = "  - {parent: proj_link, child: proj_view";
        let entry = match form {
            0 => format!("{head}, translation: [{x}, {y}, {z}], rotation_rpy: [{roll}, {pitch}, {yaw}]}}\n"),
            1 => format!("{head}, translation: [{x}, {y}, {z}], rotation_xyzw: [{i}, {j}, {k}, {w}]}}\n"),
            2 => format!("{head}, transform: '{x} {y} {z} {yaw} {pitch} {roll}'}}\n"),
            3 => format!("{head}}}\n"),
            4 => format!("  - {x} {y} {z} {i} {j} {k} {w} proj_link proj_view\n"),
            _ => format!("  - {x} {y} {z} {yaw} {pitch} {roll} proj_link proj_view 50\n"),
        };
        let text = file(&entry);
        let moved = pose_in(&text) * pose(nudge, nudge);
        let edited = edit(&text, &moved).unwrap();
        let found = pose_in(&edited);
        prop_assert!((found.translation.vector - moved.translation.vector).norm() < 1e-11, "{edited}");
        prop_assert!(found.rotation.angle_to(&moved.rotation) < 1e-11, "{edited}");
        let [before, after] = [&text, &edited].map(|text| {
            text.lines().filter(|line| !line.contains("child: proj_view") && !line.contains("proj_link proj_view"))
                .map(str::to_owned).collect::<Vec<_>>()
        });
        prop_assert_eq!(before, after);
        // A second time, nothing is left to change.
        prop_assert_eq!(edit(&edited, &pose_in(&edited)).unwrap(), edited);
    }
}

#[test]
fn a_frame_is_written_where_it_is_and_added_where_it_is_not() {
    let moved = pose([0.5, 0.25, -1.0], [0.0, 0.0, 0.5]);
    let frame = |parent: &str, child: &str| StaticFrame {
        parent: parent.to_owned(),
        child: child.to_owned(),
        translation_m: moved.translation.vector.into(),
        rotation: moved.rotation,
    };
    let with_frame = |text: &str, frame: &StaticFrame| text_with_frame(Path::new("projector.yaml"), text, frame);
    let text = file("  - {parent: proj_link, child: proj_view, translation: [1, 2, 3], rotation_rpy: [0, 0, 0]}\n");
    let edited = with_frame(&text, &frame("/proj_link", "proj_view")).unwrap();
    assert!(edited.starts_with(HEAD) && edited.ends_with(TAIL) && pose_in(&edited).translation.x == 0.5, "{edited}");
    let error = with_frame(&text, &frame("base", "proj_view")).unwrap_err().to_string();
    assert!(error.contains("places proj_view in proj_link, not in base"), "{error}");
    // Without frames, and without a line end.
    let lens = "width: 1280 # native\nheight: 800\nK: [1900, 0, 640, 0, 1900, 750, 0, 0, 1]\nframe_id: proj_view";
    let edited = with_frame(lens, &frame("camera", "proj_view")).unwrap();
    assert!(edited.starts_with(lens) && pose_in(&edited).translation.y == 0.25, "{edited}");
    assert!(with_frame(&format!("{lens}\n---\n"), &frame("camera", "proj_view")).is_err());
}
