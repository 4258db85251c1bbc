//! Looking ahead of the newest transforms: what is led on, how far, and what is not.
#![allow(clippy::unwrap_used, reason = "a test whose set-up fails has failed")]

use std::time::Duration;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rcs_transforms::{Prediction, RawTransform, Time, TransformTree};

/// The transforms of one link in the order of their stamps, 50 a second, and what is predicted after them.
struct Link {
    tree: TransformTree,
    /// The newest stamp, in milliseconds.
    millis: u32,
}

const PERIOD_MILLIS: u32 = 20;
const LIMIT: Duration = Duration::from_millis(100);

fn time(millis: u32) -> Time {
    Time::from_secs_nanos(100, 0).saturating_add(Duration::from_millis(u64::from(millis)))
}

fn insert(tree: &mut TransformTree, [parent, child]: [&str; 2], stamp: Time, pose: &Isometry3<f64>) {
    tree.insert(&raw([parent, child], stamp, pose), false, "/test").unwrap();
}

fn raw<'a>([parent, child]: [&'a str; 2], stamp: Time, pose: &Isometry3<f64>) -> RawTransform<'a> {
    let (translation, rotation_xyzw) = (pose.translation.vector.into(), pose.rotation.coords.into());
    RawTransform { parent, child, stamp, translation, rotation_xyzw }
}

impl Link {
    fn new() -> Self {
        Self { tree: TransformTree::new(), millis: 0 }
    }

    /// Places `base` in `odom` one period later.
    fn place(&mut self, pose: &Isometry3<f64>) {
        self.millis += PERIOD_MILLIS;
        insert(&mut self.tree, ["odom", "base"], time(self.millis), pose);
    }

    fn place_at(&mut self, x: f64) {
        self.place(&Isometry3::translation(x, 0.0, 0.0));
    }

    fn drive(xs: impl IntoIterator<Item = f64>) -> Self {
        let mut link = Self::new();
        xs.into_iter().for_each(|x| link.place_at(x));
        link
    }

    /// So much later than the newest transform; all of it is lead.
    fn predicted(&self, ahead_millis: u64) -> Isometry3<f64> {
        let lead = Duration::from_millis(ahead_millis);
        let prediction = Prediction { now: time(self.millis), lead, limit: LIMIT };
        self.tree.predict("odom", "base", &prediction).unwrap()
    }

    fn x(&self, ahead_millis: u64) -> f64 {
        self.predicted(ahead_millis).translation.x
    }
}

/// Places of 10 mm a step, which is 0.5 m/s.
fn steady(count: u32) -> impl Iterator<Item = f64> {
    (0..count).map(|step| f64::from(step) * 0.01)
}

#[track_caller]
fn assert_near(actual: f64, expected: f64) {
    assert!((actual - expected).abs() < 1e-9, "{actual}, not {expected}");
}

#[test]
fn a_steady_motion_is_led_on_up_to_the_limit() {
    let link = Link::drive(steady(10));
    for (ahead, expected) in [(0, 0.09), (20, 0.10), (55, 0.1175), (100, 0.14), (101, 0.14), (5000, 0.14)] {
        assert_near(link.x(ahead), expected);
    }
}

#[test]
fn a_base_that_turns_is_followed_along_its_arc() {
    let (speed, turn) = (0.5, 0.5);
    let at = |secs: f64| {
        let (radius, angle) = (speed / turn, turn * secs);
        let place = Vector3::new(radius * angle.sin(), radius * (1.0 - angle.cos()), 0.0);
        Isometry3::from_parts(Translation3::from(place), UnitQuaternion::from_scaled_axis(Vector3::z() * angle))
    };
    let mut link = Link::new();
    (0..10).for_each(|step| link.place(&at(f64::from(step) * 0.02)));
    let (predicted, truth) = (link.predicted(100), at(0.28));
    assert!((predicted.translation.vector - truth.translation.vector).norm() < 1e-5);
    assert!(predicted.rotation.angle_to(&truth.rotation) < 1e-6);
}

#[test]
fn a_stop_is_followed_with_the_first_transform_that_stands_still() {
    let mut link = Link::drive(steady(10));
    link.place_at(0.09);
    assert_near(link.x(50), 0.09);
    link.place_at(0.09);
    assert_near(link.x(50), 0.09);
    // The last step before it, cut short by the stop, is no motion to go by.
    let mut link = Link::drive(steady(10));
    link.place_at(0.094);
    assert_near(link.x(50), 0.094);
}

#[test]
fn a_motion_is_led_on_once_two_steps_agree() {
    let mut link = Link::drive([0.0; 10]);
    link.place_at(0.01);
    assert_near(link.x(50), 0.01);
    link.place_at(0.02);
    assert_near(link.x(50), 0.045);
}

#[test]
fn no_jump_is_taken_for_a_motion() {
    // From rest, and the small corrections of a localization.
    for jump in [0.001, 0.03, 0.5, 20.0] {
        let mut link = Link::drive([0.0; 10]);
        for _ in 0..8 {
            link.place_at(jump);
            assert_near(link.x(50), jump);
        }
    }
    // Within a motion: a velocity is never that of the jump.
    for jump in [-2.0, -0.1, 0.1, 2.0] {
        let mut link = Link::drive(steady(10));
        for step in 10..20 {
            let x = jump + f64::from(step) * 0.01;
            link.place_at(x);
            let ahead = link.x(50) - x;
            let expected = if step < 12 { 0.0 } else { 0.025 };
            assert_near(ahead, expected);
        }
    }
}

#[test]
fn a_new_parent_ends_a_motion() {
    let mut link = Link::drive(steady(10));
    insert(&mut link.tree, ["map", "base"], time(link.millis + 20), &Isometry3::translation(7.0, 0.0, 0.0));
    insert(&mut link.tree, ["map", "odom"], time(link.millis + 20), &Isometry3::identity());
    let prediction = Prediction { now: time(link.millis + 20), lead: Duration::from_millis(50), limit: LIMIT };
    assert_near(link.tree.predict("map", "base", &prediction).unwrap().translation.x, 7.0);
}

#[test]
fn a_frame_that_fell_silent_stays_where_it_was() {
    let link = Link::drive(steady(10));
    let at = |silent_millis: u32| {
        let now = time(link.millis + silent_millis);
        let prediction = Prediction { now, lead: Duration::from_millis(30), limit: LIMIT };
        link.tree.predict("odom", "base", &prediction).unwrap().translation.x
    };
    assert_near(at(40), 0.125);
    assert_near(at(140), 0.14);
    assert_near(at(141), 0.09);
}

#[test]
fn noise_around_a_place_is_not_led_on() {
    // Steps of a small generator, in one dimension, where noise leads somewhere most often.
    let mut state = 1_u64;
    let mut noise = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(u32::MAX >> 1) - 0.5
    };
    let mut link = Link::new();
    let (mut count, mut led_on) = (0, 0);
    for _ in 0..5000 {
        let x = noise() * 0.002;
        link.place_at(x);
        count += 1;
        led_on += usize::from(link.x(50) != x);
    }
    assert!(led_on * 20 < count, "{led_on} of {count}");
    // The same noise upon a motion that is larger disturbs it little.
    let mut link = Link::new();
    let (mut squares, mut squares_without) = (0.0, 0.0);
    for step in 0..5000 {
        let x = f64::from(step) * 0.01;
        link.place_at(x + noise() * 0.002);
        if step > 10 {
            squares += (link.x(50) - (x + 0.025)).powi(2);
            squares_without += 0.025_f64.powi(2);
        }
    }
    let ratio = (squares_without / squares).sqrt();
    assert!(ratio > 10.0, "{ratio}");
}

#[test]
fn links_of_different_rates_and_delays_meet_at_the_same_time() {
    let mut tree = TransformTree::new();
    let turned = |angle: f64| Isometry3::rotation(Vector3::z() * angle);
    for step in 0..30_u32 {
        let secs = f64::from(step) * 0.01;
        let stamp = time(step * 10);
        // 100 a second, 20 a second of which the last is late, and one that is from the future.
        if step % 5 == 0 && step < 25 {
            insert(&mut tree, ["odom", "base"], stamp, &Isometry3::translation(0.5 * secs, 0.0, 0.0));
        }
        insert(&mut tree, ["base", "turret"], stamp, &turned(secs));
        let future = stamp.saturating_add(Duration::from_millis(50));
        insert(&mut tree, ["map", "odom"], future, &Isometry3::translation(0.0, secs + 0.05, 0.0));
    }
    let prediction = Prediction { now: time(290), lead: Duration::from_millis(10), limit: LIMIT };
    let map_from_turret = tree.predict("map", "turret", &prediction).unwrap();
    assert!((map_from_turret.translation.vector - Vector3::new(0.15, 0.3, 0.0)).norm() < 1e-6, "{map_from_turret}");
    assert!((map_from_turret.rotation.angle() - 0.3).abs() < 1e-6);
    let turret_from_map = tree.predict("turret", "map", &prediction).unwrap();
    assert!((turret_from_map * map_from_turret).translation.vector.norm() < 1e-9);
}

#[test]
fn what_is_static_or_unknown_is_as_without_prediction() {
    let mut tree = TransformTree::new();
    let mount = RawTransform {
        parent: "base",
        child: "lens",
        stamp: Time::ZERO,
        translation: [0.1, 0.2, 0.3],
        rotation_xyzw: [0.0, 0.0, 0.6, 0.8],
    };
    tree.insert(&mount, true, "/test").unwrap();
    let prediction = Prediction { now: time(0), lead: LIMIT, limit: LIMIT };
    let known = tree.lookup("base", "lens", Time::ZERO);
    assert_eq!(tree.predict("/base", "lens", &prediction), known);
    for (target, source) in [("base", "nowhere"), ("", "base"), ("base", "")] {
        assert_eq!(tree.predict(target, source, &prediction), tree.lookup(target, source, Time::ZERO));
    }
    // One sample, then none: time jumped back.
    insert(&mut tree, ["odom", "base"], time(10), &Isometry3::identity());
    assert!(tree.predict("odom", "lens", &prediction).is_ok());
    tree.clear();
    assert_eq!(
        tree.predict("odom", "lens", &prediction).unwrap_err().to_string(),
        tree.lookup("odom", "lens", Time::ZERO).unwrap_err().to_string()
    );
}

#[test]
fn stamps_that_repeat_or_almost_do_are_no_velocity() {
    let mut link = Link::drive(steady(10));
    let newest = time(link.millis);
    let again = raw(["odom", "base"], newest, &Isometry3::translation(5.0, 0.0, 0.0));
    assert!(link.tree.insert(&again, false, "/test").is_err());
    assert_near(link.x(50), 0.115);
    let soon = newest.saturating_add(Duration::from_micros(10));
    insert(&mut link.tree, ["odom", "base"], soon, &Isometry3::translation(0.091, 0.0, 0.0));
    assert!((link.x(50) - 0.091).abs() < 1e-9, "{}", link.x(50));
    // A late one, in between, changes nothing where it fits.
    let mut link = Link::drive(steady(10));
    let between = time(link.millis - 30);
    insert(&mut link.tree, ["odom", "base"], between, &Isometry3::translation(0.075, 0.0, 0.0));
    assert_near(link.x(50), 0.115);
}
