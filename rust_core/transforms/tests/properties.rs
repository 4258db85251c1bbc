//! What holds for every tree, over random trees, times and malformed transforms.
#![expect(clippy::unwrap_used, reason = "a helper of tests may fail as they do")]

use std::time::Duration;

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use proptest::prelude::*;
use rcs_transforms::{LookupProblem, RawTransform, Time, TransformTree, WaitingQueue};

fn name(frame: usize) -> String {
    format!("frame_{frame}")
}

fn secs(secs: f64) -> Time {
    Time::from_secs_f64(secs)
}

prop_compose! {
    fn rotation()(v in prop::array::uniform4(-1.0..1.0_f64)
        .prop_filter("no direction", |v| v.iter().map(|x| x * x).sum::<f64>() > 1e-3)) -> UnitQuaternion<f64> {
        UnitQuaternion::from_quaternion(Quaternion::from(v))
    }
}

prop_compose! {
    fn isometry()(t in prop::array::uniform3(-100.0..100.0_f64), r in rotation()) -> Isometry3<f64> {
        Isometry3::from_parts(Translation3::from(t), r)
    }
}

fn raw<'a>(parent: &'a str, child: &'a str, stamp: Time, place: &Isometry3<f64>) -> RawTransform<'a> {
    let (translation, rotation_xyzw) = (place.translation.vector.into(), place.rotation.coords.into());
    RawTransform { parent, child, stamp, translation, rotation_xyzw }
}

/// One link: which earlier frame is the parent, whether static, and the places at 100 s and 104 s.
type Link = (prop::sample::Index, bool, [Isometry3<f64>; 2]);

fn links() -> impl Strategy<Value = Vec<Link>> {
    let link = (any::<prop::sample::Index>(), any::<bool>(), [isometry(), isometry()]);
    prop::collection::vec(link, 1..12)
}

/// Frame 0 is the root; link i places frame i + 1 in one of the frames before it.
fn tree_of(links: &[Link]) -> TransformTree {
    let mut tree = TransformTree::new();
    for (i, (parent, is_static, places)) in links.iter().enumerate() {
        for (place, stamp) in places.iter().zip([100.0, 104.0]) {
            let (parent, child) = (name(parent.index(i + 1)), name(i + 1));
            tree.insert(&raw(&parent, &child, secs(stamp), place), *is_static, "/generator").unwrap();
        }
    }
    tree
}

fn is_close(a: &Isometry3<f64>, b: &Isometry3<f64>) -> bool {
    (a.translation.vector - b.translation.vector).norm() < 1e-9 && a.rotation.angle_to(&b.rotation) < 1e-6
}

/// Numbers as a hostile message may hold them.
fn hostile() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -2.0..2.0_f64,
        1 => prop::sample::select(vec![
            f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN, f64::MIN_POSITIVE, 0.0, -0.0, 1e-300,
        ]),
    ]
}

fn hostile_rotation() -> impl Strategy<Value = [f64; 4]> {
    prop_oneof![
        3 => rotation().prop_map(|r| [r.i, r.j, r.k, r.w]),
        1 => prop::array::uniform4(hostile()),
    ]
}

fn hostile_time() -> impl Strategy<Value = Time> {
    prop_oneof![
        4 => (0..30_i64).prop_map(|s| Time::from_nanos(s * 1_000_000_000)),
        1 => any::<i64>().prop_map(Time::from_nanos),
        1 => (any::<u32>(), any::<u32>()).prop_map(|(s, n)| Time::from_secs_nanos(s, n)),
        1 => prop::sample::select(vec![i64::MIN, -1, 0, 1, i64::MAX]).prop_map(Time::from_nanos),
    ]
}

fn hostile_name() -> impl Strategy<Value = &'static str> {
    prop::sample::select(vec!["a", "b", "c", "d", "/a", "", "/", "//", "\u{0}", "é"])
}

proptest! {
    #[test]
    fn there_and_back_is_the_identity(links in links(), a in any::<prop::sample::Index>(), b in any::<prop::sample::Index>(), time in 100.0..=104.0_f64) {
        let tree = tree_of(&links);
        let (a, b) = (name(a.index(links.len() + 1)), name(b.index(links.len() + 1)));
        for time in [secs(time), Time::ZERO] {
            let a_from_b = tree.lookup(&a, &b, time).unwrap();
            let b_from_a = tree.lookup(&b, &a, time).unwrap();
            prop_assert!(is_close(&(a_from_b * b_from_a), &Isometry3::identity()));
            prop_assert!(tree.can_transform(&a, &b, time));
        }
    }

    #[test]
    fn any_frame_can_stand_between_two(links in links(), picks in prop::array::uniform3(any::<prop::sample::Index>()), time in 100.0..=104.0_f64) {
        let tree = tree_of(&links);
        let [a, b, c] = picks.map(|pick| name(pick.index(links.len() + 1)));
        let time = secs(time);
        let direct = tree.lookup(&a, &c, time).unwrap();
        let by_way_of_b = tree.lookup(&a, &b, time).unwrap() * tree.lookup(&b, &c, time).unwrap();
        prop_assert!(is_close(&direct, &by_way_of_b));
    }

    #[test]
    fn between_two_samples_a_frame_is_between_their_places(places in [isometry(), isometry()], ratio in 0.0..=1.0_f64, flip in any::<bool>()) {
        let mut tree = TransformTree::new();
        for (place, stamp) in places.iter().zip([100.0, 104.0]) {
            let mut raw = raw("map", "base", secs(stamp), place);
            if flip && stamp > 100.0 {
                raw.rotation_xyzw = raw.rotation_xyzw.map(|v| -v);
            }
            tree.insert(&raw, false, "/generator").unwrap();
        }
        let at = tree.lookup("map", "base", secs(100.0 + 4.0 * ratio)).unwrap();
        let [a, b] = places;
        let expected = a.translation.vector.lerp(&b.translation.vector, ratio);
        prop_assert!((at.translation.vector - expected).norm() < 1e-6);
        prop_assert!((at.rotation.norm() - 1.0).abs() < 1e-12);
        let whole = a.rotation.angle_to(&b.rotation);
        prop_assert!((a.rotation.angle_to(&at.rotation) - ratio * whole).abs() < 1e-6);
        prop_assert!((b.rotation.angle_to(&at.rotation) - (1.0 - ratio) * whole).abs() < 1e-6);
    }

    #[test]
    fn the_order_of_arrival_does_not_matter_within_the_cache(stamps in prop::collection::hash_set(1000..1100_u32, 1..40).prop_map(|s| s.into_iter().collect::<Vec<_>>()), query in 1000..1100_u32) {
        let tree_in_order = |stamps: &[u32]| {
            let mut tree = TransformTree::with_cache_length(Duration::from_secs(100));
            for &stamp in stamps {
                let place = Isometry3::translation(f64::from(stamp) * f64::from(stamp), 0.0, 0.0);
                tree.insert(&raw("map", "base", Time::from_secs_nanos(stamp, 0), &place), false, "/generator").unwrap();
            }
            tree
        };
        let mut sorted = stamps.clone();
        sorted.sort_unstable();
        let time = Time::from_secs_nanos(query, 0);
        prop_assert_eq!(
            tree_in_order(&stamps).lookup("map", "base", time),
            tree_in_order(&sorted).lookup("map", "base", time)
        );
    }

    #[test]
    fn nothing_that_is_published_or_looked_up_panics(
        published in prop::collection::vec(
            (hostile_name(), hostile_name(), hostile_time(), prop::array::uniform3(hostile()), hostile_rotation(), any::<bool>()), 0..40),
        clear_after in 0..80_usize,
        lookups in prop::collection::vec((hostile_name(), hostile_name(), hostile_time()), 1..20),
    ) {
        let mut tree = TransformTree::new();
        let mut queue = WaitingQueue::new(3);
        for (i, (parent, child, stamp, translation, rotation_xyzw, is_static)) in published.into_iter().enumerate() {
            let raw = RawTransform { parent, child, stamp, translation, rotation_xyzw };
            if let Err(error) = tree.insert(&raw, is_static, "/generator") {
                prop_assert!(error.to_string().contains("/generator"));
            }
            queue.push(child, stamp, i);
            queue.take_ready(&tree, "a");
            prop_assert!(queue.len() <= 3);
            if i == clear_after {
                tree.clear();
                queue.clear();
            }
        }
        for (target, source, time) in lookups {
            match tree.lookup_stamped(target, source, time) {
                Ok((found, _)) => {
                    prop_assert!(tree.can_transform(target, source, time));
                    prop_assert!((found.rotation.norm() - 1.0).abs() < 1e-6);
                }
                Err(error) => {
                    prop_assert!(!tree.can_transform(target, source, time));
                    let (target, source) = (strip(target), strip(source));
                    let text = error.to_string();
                    let has_both = text.contains(&format!("[{target}]")) && text.contains(&format!("[{source}]"));
                    prop_assert!(has_both, "{}", text);
                    if let LookupProblem::Extrapolation { known: Some((earliest, latest)), requested, .. } = error.problem {
                        prop_assert!(requested < earliest || requested > latest);
                    }
                }
            }
            tree.latest_common_time(target, source).ok();
            tree.parent_of(source, time);
            tree.newest_stamp_of(source);
        }
    }
}

fn strip(frame: &str) -> &str {
    frame.strip_prefix('/').unwrap_or(frame)
}
