//! Tests of the messages that a display shows, before and after a panic.

use nalgebra::Matrix4;
use rcs_messages::visualization_msgs::Marker;
use rcs_messages::MessageKind;
use rcs_scene::{Geometry, Material, Mesh};

use super::*;
use crate::framework::test_world::TestWorld;
use crate::parts::solids::drawable;

const TOPIC: &str = "/markers";

/// Draws its markers, each once. Panics with those that are named so.
#[derive(Default)]
struct Fragile {
    names: Vec<String>,
    drawables: Vec<Drawable>,
    statuses: Statuses,
}

impl Fragile {
    fn has(&self, name: &str) -> bool {
        self.names.iter().any(|known| known == name)
    }
}

impl Display for Fragile {
    fn topics(&self) -> Vec<TopicRequest> {
        TopicRequest::new(TOPIC, MessageKind::Marker, 1).into_iter().collect()
    }

    fn take(&mut self, message: &AnyMessage, _world: &World<'_>) {
        let AnyMessage::Marker(marker) = message else { return };
        assert!(marker.ns != "bad when taken", "a test's panic");
        self.names.push(marker.ns.clone());
    }

    fn update(&mut self, _world: &World<'_>) -> bool {
        assert!(!self.has("bad when updated"), "a test's panic");
        let mesh = || Geometry::Mesh { mesh: Arc::new(Mesh::default()), material: Arc::new(Material::unlit(false)) };
        let changed = self.drawables.len() != self.names.len();
        self.drawables = self.names.iter().map(|_| drawable(0, Matrix4::identity(), mesh())).collect();
        changed
    }

    fn drawables(&self) -> &[Drawable] {
        &self.drawables
    }

    fn statuses(&self) -> &Statuses {
        &self.statuses
    }
}

impl Drop for Fragile {
    fn drop(&mut self) {
        assert!(!self.has("bad when dropped"), "a test's panic");
    }
}

struct Bench {
    entry: DisplayEntry,
    world: TestWorld,
}

impl Bench {
    fn new() -> Self {
        let listed = ListedDisplay { path: vec!["d".to_owned()], class: "test".to_owned(), topic: None };
        let settings = DisplaySettings::Unknown { topics: Vec::new() };
        let entry = DisplayEntry::new(0, listed, settings, |_, _| Some(Box::<Fragile>::default())).unwrap();
        Self { entry, world: TestWorld::at(Time::from_secs_nanos(10, 0)) }
    }

    /// Sends a marker of this namespace and stamp, without an update.
    fn send(&mut self, name: &str, stamp_secs: u32) {
        let mut marker = Marker { ns: name.to_owned(), ..Marker::default() };
        marker.header.stamp.sec = stamp_secs;
        let message = AnyMessage::Marker(Arc::new(marker));
        self.entry.take(TOPIC, &message, Some(Instant::now()), &self.world.get());
    }

    /// Number of drawables after an update, and the stamps of the message that is new and of the one that it ages by.
    fn update(&mut self) -> (usize, Option<u32>, Option<u32>) {
        let secs = |shown: ShownMessage| shown.stamp.as_secs_nanos().0;
        let (_, shown) = self.entry.update(&self.world.get());
        (self.entry.drawables().len(), shown.map(secs), self.entry.age().current.map(secs))
    }

    /// Whether an update changed the drawables.
    fn has_changed(&mut self) -> bool {
        self.entry.update(&self.world.get()).0
    }

    fn level(&self) -> Level {
        self.entry.statuses().level()
    }

    fn fault(&self) -> Option<&str> {
        self.entry.statuses().get(Statuses::FAULT).map(|status| status.text.as_str())
    }
}

#[test]
fn a_display_that_panics_is_empty_without_an_age_and_takes_later_messages() {
    for bad in ["bad when taken", "bad when updated"] {
        let mut bench = Bench::new();
        bench.send("latched", 1);
        assert_eq!(bench.update(), (1, Some(1), Some(1)), "{bad}");
        bench.send("lost", 2);
        bench.send(bad, 3);
        assert_eq!((bench.update(), bench.level()), ((0, None, None), Level::Error), "{bad}");
        bench.send("later", 4);
        assert_eq!((bench.update(), bench.level()), ((1, Some(4), Some(4)), Level::Ok), "{bad}");
    }
}

#[test]
fn a_message_after_a_panic_in_the_same_update_is_shown_and_ages() {
    let mut bench = Bench::new();
    bench.send("bad when taken", 1);
    bench.send("later", 2);
    assert_eq!((bench.update(), bench.level()), ((1, Some(2), Some(2)), Level::Ok));
}

#[test]
fn a_display_that_panics_is_emptied_and_failed_until_it_shows_something() {
    let mut bench = Bench::new();
    bench.send("shown", 1);
    assert!(bench.has_changed() && !bench.entry.has_failed());
    bench.send("bad when taken", 2);
    assert!(bench.entry.has_failed() && bench.entry.drawables().is_empty());
    assert!(bench.has_changed(), "what it showed is gone");
    assert!(!bench.has_changed(), "once");
    assert_eq!((bench.level(), bench.fault()), (Level::Error, Some(FAILED)));
    // Time jumps back.
    bench.entry.reset();
    bench.has_changed();
    assert_eq!((bench.entry.drawables().len(), bench.level()), (0, Level::Error), "nothing is shown");
    bench.send("shown", 1);
    assert!(bench.has_changed() && !bench.entry.has_failed());
    assert_eq!((bench.entry.drawables().len(), bench.level()), (1, Level::Ok));
}

#[test]
fn a_panic_while_what_is_broken_is_dropped_is_caught() {
    let mut bench = Bench::new();
    bench.send("bad when dropped", 1);
    assert_eq!(bench.update().0, 1);
    bench.send("bad when updated", 2);
    assert!(bench.has_changed() && bench.entry.has_failed() && bench.entry.drawables().is_empty());
}

#[test]
fn after_a_second_panic_within_a_minute_it_takes_nothing() {
    // At nine seconds, the time has jumped back.
    for (again_secs, is_off) in [(69, true), (70, false), (9, false)] {
        let mut bench = Bench::new();
        bench.send("bad when taken", 1);
        bench.world.now = Time::from_secs_nanos(again_secs, 0);
        bench.send("bad when taken", 2);
        assert_eq!(bench.fault(), Some(if is_off { OFF } else { FAILED }), "{again_secs}");
        bench.send("later", 3);
        bench.has_changed();
        bench.entry.reset();
        assert_eq!((bench.entry.drawables().is_empty(), bench.entry.has_failed()), (is_off, is_off), "{again_secs}");
    }
}
