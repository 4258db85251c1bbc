//! Frames that come, move, fade and are switched off, by what is shown of them.

use rcs_rviz_config::FrameFilter;
use rcs_scene::{Geometry, Lighting, Rgba};
use rcs_transforms::RawTransform;

use super::*;
use crate::framework::test_world::TestWorld;

struct Bench {
    display: TfDisplay,
    world: TestWorld,
}

fn at(secs: f64) -> Time {
    Time::from_secs_f64(1000.0 + secs)
}

impl Bench {
    fn new(settings: &TfSettings) -> Self {
        Self { display: create(0, settings), world: TestWorld::at(at(0.0)) }
    }

    fn publish(&mut self, parent: &str, child: &str, secs: f64, x: f64, is_static: bool) {
        let transform = RawTransform {
            parent,
            child,
            stamp: at(secs),
            translation: [x, 0.0, 0.0],
            rotation_xyzw: [0.0, 0.0, 0.0, 1.0],
        };
        self.world.tree.insert(&transform, is_static, "/a").unwrap();
    }

    /// Looks at the frames; returns whether the image changed.
    fn update(&mut self, secs: f64) -> bool {
        self.world.now = at(secs);
        self.display.update(&self.world.get())
    }

    fn status(&self, frame: &str) -> (Level, &str) {
        let (_, status) = self.display.statuses.iter().find(|(name, _)| *name == frame).unwrap();
        (status.level, &status.text)
    }

    /// Number of shown frames (by their names) and arrows; each frame has three axes.
    fn shown(&self) -> (usize, usize) {
        let is_text = |drawable: &&Drawable| matches!(drawable.geometry, Geometry::Text(_));
        let names = self.display.drawables().iter().filter(is_text).count();
        let parts = self.display.drawables().len() - 4 * names;
        assert_eq!(parts % 2, 0);
        (names, parts / 2)
    }

    fn colors(&self) -> Vec<Rgba> {
        let color = |drawable: &Drawable| match &drawable.geometry {
            Geometry::Mesh { material, .. } => match material.lighting {
                Lighting::Lit { diffuse, .. } => Some(diffuse),
                Lighting::Unlit => None,
            },
            _ => None,
        };
        self.display.drawables().iter().filter_map(color).collect()
    }
}

fn timeout(frame_timeout_s: f32) -> TfSettings {
    TfSettings { frame_timeout_s, ..TfSettings::default() }
}

#[test]
fn static_frames_never_age_and_are_looked_up_once() {
    let mut bench = Bench::new(&timeout(3.0));
    bench.publish("map", "base", 0.0, 1.0, true);
    assert!(bench.update(0.0));
    assert_eq!(bench.shown(), (2, 1));
    assert_eq!(bench.display.next_change(), None);
    assert!(!bench.update(100.0));
    assert_eq!(bench.shown(), (2, 1));
}

#[test]
fn a_frame_turns_grey_fades_and_is_gone_and_comes_back() {
    let mut bench = Bench::new(&timeout(3.0));
    bench.publish("map", "base", 0.0, 1.0, false);
    assert!(bench.update(0.0));
    assert!(!bench.update(0.9));
    let next = bench.display.next_change().unwrap();
    assert!(next > at(0.99) && next < at(1.01), "{next}");

    assert!(bench.update(1.5));
    let grey = |a: f32, b: f32| (a - b).abs() < 2e-3;
    // Sorted by name: the axes of base, the arrow of base, the axes of map.
    let colors = bench.colors();
    assert!(grey(colors[0].r, 0.85) && grey(colors[0].g, 0.35) && grey(colors[4].g, 0.4));
    assert_eq!(colors[5], Rgba::new(1.0, 0.0, 0.0, 1.0), "the fixed frame itself is static");
    let next = bench.display.next_change().unwrap();
    assert!(next > at(1.5) && next < at(1.6), "{next}");

    assert!(bench.update(2.75));
    assert!(bench.colors()[..5].iter().all(|c| grey(c.r, 0.7) && grey(c.b, 0.7) && grey(c.a, 0.25)));
    assert!(bench.update(3.1));
    assert_eq!((bench.shown(), bench.display.next_change()), ((1, 0), None));
    assert_eq!(bench.status("base"), (Level::Ok, "Transform OK"));

    bench.publish("map", "base", 3.2, 2.0, false);
    assert!(bench.update(3.2));
    assert_eq!(bench.shown(), (2, 1));
    assert_eq!(bench.colors()[0], Rgba::new(1.0, 0.0, 0.0, 1.0));
}

#[test]
fn what_a_moving_frame_carries_ages_with_it_and_not_by_repeated_transforms() {
    let mut bench = Bench::new(&timeout(3.0));
    bench.publish("map", "base", 0.0, 1.0, false);
    bench.publish("base", "laser", 0.0, 1.0, true);
    assert!(bench.update(0.0));
    bench.publish("map", "base", 0.0, 1.0, false);
    assert!(bench.update(3.5));
    assert_eq!(bench.shown(), (1, 0));
}

#[test]
fn frames_of_another_tree_are_hidden_and_reported() {
    let mut bench = Bench::new(&timeout(3.0));
    bench.publish("map", "base", 0.0, 1.0, true);
    bench.publish("moon", "crater", 0.0, 1.0, false);
    assert!(bench.update(0.0));
    assert_eq!(bench.shown(), (2, 1));
    for frame in ["moon", "crater"] {
        let text = format!("No transform from [{frame}] to frame [map]");
        assert_eq!(bench.status(frame), (Level::Warn, &*text));
    }
    assert_eq!(bench.display.next_change(), None);
}

#[test]
fn frames_that_are_switched_off_are_hidden_one_by_one() {
    let hidden_frames = ["base".to_owned()].into();
    let mut bench = Bench::new(&TfSettings { hidden_frames, ..timeout(15.0) });
    bench.publish("map", "base", 0.0, 1.0, false);
    bench.publish("base", "laser", 0.0, 1.0, true);
    assert!(bench.update(0.0));
    assert_eq!(bench.shown(), (2, 1), "the arrow from the laser still points at where base is");
    assert_eq!(bench.status("base"), (Level::Ok, "Transform OK"));
}

#[test]
fn frames_are_updated_once_per_update_interval() {
    let mut bench = Bench::new(&TfSettings { update_interval_s: 2.0, ..timeout(30.0) });
    bench.publish("map", "base", 0.0, 1.0, false);
    assert!(bench.update(0.0));
    bench.publish("map", "base", 0.1, 2.0, false);
    assert!(bench.update(0.0), "many messages of a bag may have one time");
    bench.publish("map", "base", 0.2, 3.0, false);
    assert!(!bench.update(1.0));
    assert_eq!(bench.display.next_change(), Some(at(2.0)));
    assert!(bench.update(2.0));
    bench.publish("base", "laser", 2.1, 3.0, true);
    assert!(bench.update(2.1), "a new frame does not wait");
    bench.display.reset();
    assert!(bench.display.drawables().is_empty() && bench.display.next_change().is_none());
}

#[test]
fn made_up_frames_are_gone_once_they_are_old_and_come_back() {
    let mut bench = Bench::new(&timeout(3.0));
    bench.publish("map", "base", 0.0, 1.0, false);
    for number in 0..4000_u32 {
        let secs = f64::from(number) / 2000.0;
        if number % 100 == 0 {
            bench.publish("map", "base", secs, 1.0 + secs, false);
            bench.update(secs);
        }
        bench.publish("base", &format!("box_{number}"), secs, 1.0, false);
    }
    assert!(bench.shown().0 > 1000, "{:?}", bench.shown());
    // Only the robot goes on.
    for tick in 0..100 {
        let secs = 15.0 + f64::from(tick);
        bench.publish("map", "base", secs, 1.0 + secs, false);
        bench.update(secs);
    }
    assert_eq!(bench.shown(), (2, 1));
    assert_eq!(bench.display.statuses.iter().count(), bench.display.frames.len());
    // A frame that was gone is back with its next transform.
    bench.publish("base", "box_5", 115.0, 1.0, false);
    bench.publish("map", "base", 115.0, 9.0, false);
    assert!(bench.update(115.0));
    assert_eq!(bench.shown(), (3, 2));
}

#[test]
fn filters_leave_frames_out_with_their_statuses_and_their_arrows_but_not_the_arrows_to_them() {
    let filter = |text: &str| FrameFilter::new(text).unwrap();
    let settings = TfSettings { whitelist: filter("^lamp|map"), blacklist: filter("_2$"), ..TfSettings::default() };
    let mut bench = Bench::new(&settings);
    bench.publish("map", "laser", 0.0, 1.0, true);
    bench.publish("laser", "lamp_1", 0.0, 1.0, true);
    bench.publish("map", "lamp_2", 0.0, 3.0, true);
    assert!(bench.update(0.0));
    assert_eq!(bench.shown(), (2, 1), "map, lamp_1 and its arrow to laser");
    let named: Vec<&str> = bench.display.statuses.iter().map(|(name, _)| name).collect();
    assert_eq!(named, ["lamp_1", "map"]);
    bench.publish("map", "lamp_3", 0.0, 4.0, true);
    assert!(bench.update(1.0), "a frame that comes later is filtered, too");
    bench.publish("map", "camera", 0.0, 5.0, true);
    assert!(!bench.update(2.0));
    assert_eq!(bench.shown(), (3, 2));
}
