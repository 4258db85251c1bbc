//! Answers of tf2 0.7.6 (Debian 12's `tf2_py.BufferCore`) to eight lookups in one scene, to nine decimals.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rcs_transforms::{RawTransform, Time, TransformTree};

/// Parent, child, stamp in seconds, whether static, translation, rotation xyzw.
type Published = (&'static str, &'static str, f64, bool, [f64; 3], [f64; 4]);

const PUBLISHED: [Published; 9] = [
    ("map", "odom", 20.0, false, [-1.057, -2.095, 0.906], [0.865163689, 0.423409936, -0.178585222, 0.200806215]),
    ("map", "odom", 21.0, false, [0.045, -2.775, -0.398], [0.205302896, 0.096380513, -0.866448255, 0.444779652]),
    ("map", "odom", 23.0, false, [-2.257, -1.661, 0.765], [0.40936026, -0.139555198, -0.718227803, 0.545066369]),
    ("odom", "torso", 20.25, false, [-2.721, 2.151, -1.262], [0.161856263, 0.20665928, -0.346641168, 0.900518958]),
    ("odom", "torso", 22.5, false, [-1.916, 0.49, 0.833], [-0.669991184, 0.69226846, 0.247502969, 0.103045973]),
    ("map", "table", 19.0, false, [-1.764, 1.082, -0.434], [-0.330952558, 0.776170867, -0.513632183, 0.155599388]),
    ("map", "table", 24.0, false, [1.766, 1.194, -1.535], [-0.537788144, -0.271568407, 0.564860688, -0.563885552]),
    ("torso", "camera", 0.0, true, [-1.272, 2.881, -2.292], [-0.716972565, 0.405243631, 0.327650391, 0.463004495]),
    ("table", "cup", 0.0, true, [-2.765, 1.009, 1.587], [-0.715436206, -0.353424966, -0.234998978, 0.554993071]),
];

/// Target, source, time in seconds; then tf2's stamp in seconds, translation and rotation xyzw.
type Answer = (&'static str, &'static str, f64, f64, [f64; 3], [f64; 4]);

const ANSWERS: [Answer; 8] = [
    (
        "map",
        "camera",
        21.75,
        21.75,
        [2.539826047, 1.102821921, 4.065938187],
        [0.241762989, 0.509483764, 0.76407293, 0.313320141],
    ),
    (
        "camera",
        "map",
        21.75,
        21.75,
        [0.740494769, -2.877431477, -3.920566474],
        [-0.241762989, -0.509483764, -0.76407293, 0.313320141],
    ),
    (
        "cup",
        "camera",
        20.5,
        20.5,
        [1.70192612, -3.833608186, -5.424345412],
        [0.169268447, -0.592608051, 0.787480234, -0.006226743],
    ),
    (
        "torso",
        "cup",
        22.5,
        22.5,
        [-0.055087453, 0.711810901, 4.426791208],
        [-0.065759282, 0.022846364, -0.786560542, 0.613576624],
    ),
    (
        "table",
        "odom",
        0.0,
        23.0,
        [-0.55863313, -3.351127093, 3.43650346],
        [0.402242235, -0.331816651, 0.187369906, 0.832461058],
    ),
    (
        "cup",
        "camera",
        0.0,
        22.5,
        [-2.316847246, -0.92091421, -6.716587575],
        [-0.735705033, -0.347418334, 0.575488001, 0.08277781],
    ),
    (
        "camera",
        "torso",
        0.0,
        0.0,
        [-0.555818372, -1.338613335, -3.615326997],
        [0.716972565, -0.405243631, -0.327650391, 0.463004495],
    ),
    ("map", "odom", 21.0, 21.0, [0.045, -2.775, -0.398], [0.205302896, 0.096380513, -0.866448255, 0.444779652]),
];

#[test]
fn lookups_agree_with_tf2() {
    let mut tree = TransformTree::new();
    for (parent, child, secs, is_static, translation, rotation_xyzw) in PUBLISHED {
        let raw = RawTransform { parent, child, stamp: Time::from_secs_f64(secs), translation, rotation_xyzw };
        tree.insert(&raw, is_static, "/test").unwrap();
    }
    for (target, source, secs, stamp, translation, [x, y, z, w]) in ANSWERS {
        let found = tree.lookup_stamped(target, source, Time::from_secs_f64(secs));
        let (found, found_stamp) = found.unwrap();
        let at = format!("{target} from {source} at {secs}: {found}");
        assert_eq!(found_stamp, Time::from_secs_f64(stamp), "{at}");
        let off = found.translation.vector - Vector3::from(translation);
        // Rotations of nine decimals are not quite of norm one, which tf2 keeps and this crate does not.
        assert!(off.norm() < 1e-7, "{at}");
        let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        assert!((found.rotation.into_inner() - rotation.into_inner()).norm() < 1e-7, "{at}");
    }
}
