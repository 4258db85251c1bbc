//! Tests of the data that a display is given again after a panic.

use std::sync::atomic::{AtomicU64, Ordering};

use nalgebra::Matrix4;
use rcs_messages::visualization_msgs::Marker;
use rcs_messages::{AnyMessage, MessageKind};
use rcs_scene::{Drawable, Geometry, Material, Mesh};

use super::*;
use crate::framework::test_world::TestWorld;
use crate::parts::solids::drawable;
use crate::{Statuses, TopicRequest};

const TOPIC: &str = "/markers";
const PARAMETER: &str = "robot";

/// Draws its parameter and its markers, each once. Panics with those that are named so, and after an hour.
#[derive(Default)]
struct Fragile {
    names: Vec<String>,
    drawables: Vec<Drawable>,
    statuses: Statuses,
    panics: Arc<AtomicU64>,
}

impl Fragile {
    fn add(&mut self, name: &str) {
        self.fail_if(name == "bad when taken");
        self.names.push(name.to_owned());
    }

    fn fail_if(&self, fails: bool) {
        if fails {
            self.panics.fetch_add(1, Ordering::Relaxed);
            panic!("a test's panic");
        }
    }
}

impl Display for Fragile {
    fn topics(&self) -> Vec<TopicRequest> {
        TopicRequest::new(TOPIC, MessageKind::Marker, 1).into_iter().collect()
    }

    fn take(&mut self, message: &AnyMessage, _world: &World<'_>) {
        let AnyMessage::Marker(marker) = message else { return };
        self.add(&marker.ns);
    }

    fn parameters(&self) -> Vec<String> {
        vec![PARAMETER.to_owned()]
    }

    fn take_parameter(&mut self, _name: &str, text: Option<&Arc<str>>, _world: &World<'_>) {
        text.into_iter().for_each(|text| self.add(text));
    }

    fn update(&mut self, world: &World<'_>) -> bool {
        self.fail_if(self.names.iter().any(|name| name == "bad when updated"));
        self.fail_if(world.now > Time::from_secs_nanos(3600, 0));
        let mesh = || Geometry::Mesh { mesh: Arc::new(Mesh::default()), material: Arc::new(Material::unlit(false)) };
        let changed = self.drawables.len() != self.names.len();
        self.drawables = self.names.iter().map(|_| drawable(0, Matrix4::identity(), mesh())).collect();
        changed
    }

    fn drawables(&self) -> &[Drawable] {
        &self.drawables
    }

    fn reset(&mut self) {
        self.names.retain(|name| name == "description");
    }

    fn statuses(&self) -> &Statuses {
        &self.statuses
    }
}

struct Bench {
    entry: DisplayEntry,
    cache: MessageCache,
    world: TestWorld,
    panics: Arc<AtomicU64>,
}

impl Bench {
    fn new() -> Self {
        let panics = Arc::<AtomicU64>::default();
        let counted = Arc::clone(&panics);
        let make = move || -> Option<Box<dyn Display>> {
            Some(Box::new(Fragile { panics: Arc::clone(&counted), ..Fragile::default() }))
        };
        let display = GuardedDisplay::new(Box::new(make)).unwrap();
        let listed = ListedDisplay { path: vec!["d".to_owned()], class: "test".to_owned(), topic: None };
        let settings = DisplaySettings::Unknown { topics: Vec::new() };
        let world = TestWorld::at(Time::from_secs_nanos(10, 0));
        Self { entry: DisplayEntry::new(0, listed, settings, display), cache: MessageCache::default(), world, panics }
    }

    /// Sends a marker of this namespace, without an update.
    fn send(&mut self, name: &str) {
        let marker = Marker { ns: name.to_owned(), ..Marker::default() };
        let message = AnyMessage::Marker(Arc::new(marker));
        let kept = CachedMessage { number: self.cache.next_number(), topic: TOPIC, message: message.clone() };
        self.entry.take(&kept, Some(Instant::now()), &self.world.get());
        self.cache.keep(TOPIC, &message, self.world.now);
    }

    fn describe(&mut self, text: &str) {
        let text: Arc<str> = text.into();
        self.cache.keep_parameter(PARAMETER, Some(&text));
        self.entry.take_parameter(PARAMETER, Some(&text), &self.world.get());
    }

    /// Number of drawables after an update.
    fn update(&mut self) -> usize {
        self.entry.update(&self.cache, &self.world.get());
        self.entry.display.drawables().len()
    }

    fn level(&self) -> Level {
        self.entry.display.statuses().level()
    }

    fn panics(&self) -> u64 {
        self.panics.load(Ordering::Relaxed)
    }
}

#[test]
fn a_display_that_panics_gets_back_all_it_had_but_the_message_that_it_panicked_with() {
    for bad in ["bad when taken", "bad when updated"] {
        let mut bench = Bench::new();
        bench.describe("description");
        bench.send("latched");
        assert_eq!(bench.update(), 2, "{bad}");
        bench.send("as new");
        bench.send(bad);
        bench.send("newer");
        assert_eq!(bench.update(), 4, "{bad}");
        assert_eq!(bench.level(), Level::Ok, "{bad}: it shows something");
        let panics = bench.panics();
        bench.send("later");
        assert_eq!((bench.update(), bench.panics()), (5, panics), "{bad}: and is not given that message again");
        bench.send("bad when taken");
        assert_eq!((bench.update(), bench.panics()), (5, panics + 1), "{bad}: nor after another panic");
    }
}

#[test]
fn a_parameter_that_makes_it_panic_is_left_out_until_another_comes() {
    for bad in ["bad when taken", "bad when updated"] {
        let mut bench = Bench::new();
        bench.send("latched");
        bench.describe(bad);
        assert_eq!(bench.update(), 1, "{bad}");
        bench.describe("description");
        assert_eq!(bench.update(), 2, "{bad}");
    }
}

#[test]
fn a_display_that_panics_again_without_news_is_left_empty() {
    let mut bench = Bench::new();
    bench.describe("description");
    bench.send("latched");
    bench.update();
    bench.world.now = Time::from_secs_nanos(3601, 0);
    assert_eq!((bench.update(), bench.level()), (0, Level::Error));
    let panics = bench.panics();
    assert!(panics <= 2 + MOST_CAUSES as u64, "{panics}");
    for _ in 0..10 {
        bench.update();
    }
    assert_eq!(bench.panics(), panics + 10, "once for each update, and nothing is tried again");
}

#[test]
fn the_error_stays_through_a_jump_in_time_until_something_is_shown() {
    let mut bench = Bench::new();
    bench.send("bad when updated");
    assert_eq!((bench.update(), bench.level()), (0, Level::Error));
    bench.cache.forget_messages();
    bench.entry.reset();
    assert_eq!((bench.update(), bench.level()), (0, Level::Error));
    bench.send("good");
    assert_eq!((bench.update(), bench.level()), (1, Level::Ok));
}

#[test]
fn a_robot_is_back_after_a_panic_in_a_jump_of_time() {
    let mut bench = Bench::new();
    bench.describe("description");
    bench.update();
    bench.send("bad when taken");
    bench.cache.forget_messages();
    bench.entry.reset();
    assert_eq!((bench.update(), bench.level()), (1, Level::Ok));
}

#[test]
fn what_comes_back_is_as_old_as_before_or_older() {
    let mut bench = Bench::new();
    bench.send("latched");
    bench.update();
    assert!(bench.entry.age().current.unwrap().received.is_some());
    bench.send("bad when taken");
    bench.update();
    assert_eq!(bench.entry.age().current.unwrap().received, None, "when it was received is not known any more");
}
