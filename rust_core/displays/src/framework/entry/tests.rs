//! Tests of the messages that a display shows, before and after a panic.

use nalgebra::Matrix4;
use rcs_messages::visualization_msgs::Marker;
use rcs_messages::MessageKind;
use rcs_scene::{Drawable, Geometry, Material, Mesh};

use super::*;
use crate::framework::test_world::TestWorld;
use crate::parts::solids::drawable;
use crate::{Statuses, TopicRequest};

const TOPIC: &str = "/markers";

/// Draws its markers, each once. Panics with those that are named so.
#[derive(Default)]
struct Fragile {
    names: Vec<String>,
    drawables: Vec<Drawable>,
    statuses: Statuses,
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
        assert!(!self.names.iter().any(|name| name == "bad when updated"), "a test's panic");
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

struct Bench {
    entry: DisplayEntry,
    world: TestWorld,
}

impl Bench {
    fn new() -> Self {
        let make = || -> Option<Box<dyn Display>> { Some(Box::<Fragile>::default()) };
        let display = GuardedDisplay::new(Box::new(make)).unwrap();
        let listed = ListedDisplay { path: vec!["d".to_owned()], class: "test".to_owned(), topic: None };
        let settings = DisplaySettings::Unknown { topics: Vec::new() };
        let world = TestWorld::at(Time::from_secs_nanos(10, 0));
        Self { entry: DisplayEntry::new(0, listed, settings, display), world }
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
        (self.entry.display.drawables().len(), shown.map(secs), self.entry.age().current.map(secs))
    }

    fn level(&self) -> Level {
        self.entry.display.statuses().level()
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
