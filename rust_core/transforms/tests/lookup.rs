//! Lookups in small trees by hand: what is found, at which time, and the texts of errors.
#![expect(clippy::unwrap_used, reason = "a helper of tests may fail as they do")]

use std::f64::consts::FRAC_1_SQRT_2;

use nalgebra::{Isometry3, Vector3};
use rcs_transforms::{LookupProblem, RawTransform, Time, TransformTree};

fn at(secs: f64) -> Time {
    Time::from_secs_f64(secs)
}

/// Inserts `child` in `parent`, a quarter turn about z and `x` along x; at no time if it is static.
fn turn(tree: &mut TransformTree, parent: &str, child: &str, secs: Option<f64>, x: f64) {
    let (translation, rotation_xyzw) = ([x, 0.0, 0.0], [0.0, 0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2]);
    let transform = RawTransform { parent, child, stamp: at(secs.unwrap_or(0.0)), translation, rotation_xyzw };
    tree.insert(&transform, secs.is_none(), "/test").unwrap();
}

/// map <- odom (5 s, 7 s) <- base (6 s, 8 s) <- camera (static); map <- table (4 s, 9 s); other <- island.
fn scene() -> TransformTree {
    let mut tree = TransformTree::new();
    for (parent, child, times) in [
        ("map", "odom", [5.0, 7.0]),
        ("odom", "base", [6.0, 8.0]),
        ("map", "table", [4.0, 9.0]),
        ("other", "island", [5.0, 8.0]),
    ] {
        for secs in times {
            turn(&mut tree, parent, child, Some(secs), secs);
        }
    }
    turn(&mut tree, "base", "camera", None, 1.0);
    tree
}

fn text_of(tree: &TransformTree, target: &str, source: &str, time: Time) -> String {
    let text = tree.lookup(target, source, time).unwrap_err().to_string();
    assert!(!tree.can_transform(target, source, time), "{text}");
    text
}

#[track_caller]
fn assert_contains(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "{part:?} is not in {text:?}");
    }
}

#[test]
fn time_zero_is_the_oldest_of_the_newest_stamps_on_the_way() {
    let tree = scene();
    for (target, source, secs) in [
        ("map", "odom", 7.0),
        ("odom", "map", 7.0),
        ("odom", "base", 8.0),
        ("table", "camera", 7.0),
        ("map", "table", 9.0),
        ("base", "camera", 0.0),
        ("base", "base", 8.0),
        ("camera", "camera", 0.0),
        ("map", "map", 0.0),
    ] {
        let common = tree.latest_common_time(target, source).unwrap();
        assert_eq!(common, at(secs), "{target} {source}");
        let (found, stamp) = tree.lookup_stamped(target, source, Time::ZERO).unwrap();
        assert_eq!(stamp, at(secs), "{target} {source}");
        assert_eq!(found, tree.lookup(target, source, stamp).unwrap());
        assert!(tree.can_transform(target, source, Time::ZERO));
    }
}

#[test]
fn a_time_that_is_given_is_the_stamp_of_the_answer() {
    let tree = scene();
    for (target, source) in [("map", "base"), ("base", "camera"), ("map", "map")] {
        let (_, stamp) = tree.lookup_stamped(target, source, at(6.5)).unwrap();
        assert_eq!(stamp, at(6.5));
    }
}

#[test]
fn a_frame_in_itself_is_the_identity_even_if_unknown() {
    let tree = TransformTree::new();
    for time in [Time::ZERO, at(3.0)] {
        let (found, stamp) = tree.lookup_stamped("/map", "map", time).unwrap();
        assert_eq!((found, stamp), (Isometry3::identity(), time));
        assert!(tree.can_transform("map", "/map", time));
    }
    let error = tree.latest_common_time("map", "map").unwrap_err();
    assert!(matches!(error.problem, LookupProblem::MissingFrame(_)));
}

#[test]
fn one_leading_slash_is_ignored() {
    let tree = scene();
    assert_eq!(tree.lookup("/map", "/camera", at(6.5)), tree.lookup("map", "camera", at(6.5)));
    assert_contains(&text_of(&tree, "map", "//camera", at(6.5)), &["[/camera] does not exist"]);
}

#[test]
fn an_empty_frame_name_is_an_invalid_argument() {
    let tree = scene();
    for (target, source) in [("", "map"), ("map", ""), ("/", "map"), ("", "")] {
        let error = tree.lookup(target, source, Time::ZERO).unwrap_err();
        assert!(matches!(error.problem, LookupProblem::EmptyName), "{error}");
        assert!(!tree.can_transform(target, source, Time::ZERO));
    }
    assert_contains(&text_of(&tree, "", "map", Time::ZERO), &["[]", "[map]", "empty"]);
}

#[test]
fn a_frame_that_does_not_exist_is_named_beside_both_frames() {
    let tree = scene();
    let error = tree.lookup("map", "laser", at(6.5)).unwrap_err();
    assert_eq!((error.target.as_str(), error.source.as_str()), ("map", "laser"));
    assert_eq!(error.problem, LookupProblem::MissingFrame("laser".to_owned()));
    let text = text_of(&tree, "nowhere", "map", at(6.5));
    assert_contains(&text, &["[map]", "frame [nowhere] does not exist"]);
}

#[test]
fn unconnected_frames_are_named_with_their_roots() {
    let tree = scene();
    for time in [Time::ZERO, at(6.5)] {
        let error = tree.lookup("base", "island", time).unwrap_err();
        let LookupProblem::Unconnected { target_root, source_root } = &error.problem else { panic!("{error:?}") };
        assert_eq!((target_root.as_str(), source_root.as_str()), ("map", "other"));
        let text = text_of(&tree, "base", "island", time);
        assert_contains(&text, &["[base]", "[island]", "[map]", "[other]"]);
    }
}

#[test]
fn a_time_after_the_newest_sample_is_not_extrapolated() {
    let tree = scene();
    let error = tree.lookup("map", "camera", at(7.5)).unwrap_err();
    let LookupProblem::Extrapolation { frame, requested, known } = &error.problem else { panic!("{error:?}") };
    assert_eq!((frame.as_str(), *requested), ("odom", at(7.5)));
    assert_eq!(*known, Some((at(5.0), at(7.0))));
    let text = text_of(&tree, "map", "camera", at(7.5));
    assert_contains(&text, &["[map]", "[camera]", "7.500000000", "until 7.000000000", "0.500000000 s earlier"]);
}

#[test]
fn a_time_before_the_oldest_sample_is_not_extrapolated() {
    let tree = scene();
    for (target, source) in [("map", "camera"), ("camera", "map")] {
        let text = text_of(&tree, target, source, at(5.5));
        assert_contains(
            &text,
            &["[map]", "[camera]", "frame [base]", "5.500000000", "from 6.000000000", "0.500000000 s later"],
        );
    }
}

#[test]
fn an_error_names_the_only_sample() {
    let mut tree = TransformTree::new();
    turn(&mut tree, "map", "odom", Some(5.0), 1.0);
    assert!(tree.can_transform("map", "odom", at(5.0)));
    let text = text_of(&tree, "map", "odom", at(5.1));
    assert_contains(&text, &["[map]", "[odom]", "known at 5.000000000 only"]);
}

#[test]
fn after_clearing_nothing_is_known_of_moving_frames() {
    let mut tree = scene();
    tree.clear();
    assert_contains(&text_of(&tree, "map", "base", at(6.5)), &["[map]", "[base]", "nothing is known"]);
    let error = tree.lookup("map", "base", Time::ZERO).unwrap_err();
    assert!(matches!(error.problem, LookupProblem::Unconnected { .. }), "{error}");
    assert!(tree.can_transform("camera", "base", at(6.5)));
}

#[test]
fn a_link_above_the_meeting_point_does_not_matter() {
    let tree = scene();
    // odom is unknown in map at 7.5 s, but the lookup does not need it.
    for (target, source) in [("odom", "camera"), ("camera", "odom")] {
        assert!(tree.lookup(target, source, at(7.5)).is_ok());
        assert!(tree.can_transform(target, source, at(7.5)));
    }
    let mut tree = tree;
    turn(&mut tree, "odom", "arm", None, 1.0);
    assert!(tree.lookup("arm", "camera", at(7.5)).is_ok());
}

#[test]
fn frames_may_change_their_parent() {
    let mut tree = TransformTree::new();
    turn(&mut tree, "map", "hand", None, 10.0);
    turn(&mut tree, "map", "cup", Some(5.0), 1.0);
    turn(&mut tree, "map", "cup", Some(6.0), 2.0);
    turn(&mut tree, "hand", "cup", Some(7.0), 3.0);
    let x = |secs| tree.lookup("map", "cup", at(secs)).unwrap().translation.x;
    assert!((x(5.5) - 1.5).abs() < 1e-12);
    assert!((x(6.9) - 2.0).abs() < 1e-12, "on the table until it is in the hand");
    let map_from_cup = tree.lookup("map", "cup", at(7.0)).unwrap();
    assert!((map_from_cup.translation.vector - Vector3::new(10.0, 3.0, 0.0)).norm() < 1e-12);
    assert_eq!(tree.parent_of("cup", at(6.9)), Some("map"));
    assert_eq!(tree.parent_of("cup", Time::ZERO), Some("hand"));
}

#[test]
fn a_loop_of_parents_is_an_error_and_not_a_hang() {
    let mut tree = TransformTree::new();
    turn(&mut tree, "a", "b", Some(5.0), 1.0);
    turn(&mut tree, "b", "a", Some(5.0), 1.0);
    turn(&mut tree, "a", "leaf", Some(5.0), 1.0);
    turn(&mut tree, "map", "odom", Some(5.0), 1.0);
    for time in [Time::ZERO, at(5.0)] {
        // Within the circle the other frame is met before it closes.
        assert!(tree.can_transform("a", "b", time) && tree.can_transform("b", "leaf", time));
        for (target, source) in [("map", "leaf"), ("leaf", "map"), ("odom", "a")] {
            let text = text_of(&tree, target, source, time);
            assert_contains(&text, &["loop", &format!("[{target}]"), &format!("[{source}]")]);
        }
    }
}

#[test]
fn a_chain_may_be_a_thousand_frames_deep() {
    let mut tree = TransformTree::new();
    for depth in 0..=1000 {
        let (parent, child) = (format!("f{depth}"), format!("f{}", depth + 1));
        turn(&mut tree, &parent, &child, None, 1.0);
    }
    assert!(tree.can_transform("f0", "f1000", Time::ZERO));
    assert!(tree.can_transform("f1000", "f0", Time::ZERO));
    assert_contains(&text_of(&tree, "f0", "f1001", Time::ZERO), &["loop"]);
}
