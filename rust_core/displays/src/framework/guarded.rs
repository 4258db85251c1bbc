//! A display whose panics end neither the other displays nor the program.
//!
//! The state of a display after a panic is unreliable. So it is replaced by a new, empty one, whose status is an error
//! until it shows something. After a second panic within a minute it is off: it takes nothing until the config makes it
//! anew.

use std::panic::{catch_unwind, AssertUnwindSafe};
use std::sync::Arc;

use rcs_messages::AnyMessage;
use rcs_scene::Drawable;
use rcs_transforms::Time;

use crate::framework::display::Display;
use crate::{Level, Statuses, TopicRequest, World};

const FAILED: &str = "This display panicked, see the log. It shows nothing until its next message.";
const OFF: &str = "This display panicked twice within a minute, see the log. It is off until the config is reloaded.";

/// ROS time after a panic in which another one switches the display off.
const PROBATION_SECS: f64 = 60.0;

/// Makes a display with its settings; always or never.
type Make = Box<dyn Fn() -> Option<Box<dyn Display>> + Send>;

pub(crate) struct GuardedDisplay {
    make: Make,
    display: Box<dyn Display>,
    panics: u64,
    /// ROS time of the last message or update, and of the last panic.
    now: Time,
    panicked_at: Option<Time>,
    /// `true` after a panic within [`PROBATION_SECS`] of another one.
    is_off: bool,
    /// Statuses since a panic, until it shows something.
    failed: Option<Statuses>,
    /// The drawables are gone, which the next update reports.
    is_emptied: bool,
}

impl GuardedDisplay {
    pub(crate) fn new(make: Make) -> Option<Self> {
        let (display, now) = (make()?, Time::ZERO);
        Some(Self { display, make, panics: 0, now, panicked_at: None, is_off: false, failed: None, is_emptied: false })
    }

    /// `true` if it panicked and has shown nothing since then.
    pub(crate) fn has_failed(&self) -> bool {
        self.failed.is_some()
    }

    /// Number of panics, each of which lost its state.
    pub(crate) fn panics(&self) -> u64 {
        self.panics
    }

    /// Runs `work` on the display; `None` if it panics or is off.
    fn guard<T>(&mut self, work: impl FnOnce(&mut dyn Display) -> T) -> Option<T> {
        if self.is_off {
            return None;
        }
        let display = self.display.as_mut();
        if let Ok(result) = catch_unwind(AssertUnwindSafe(|| work(display))) {
            return Some(result);
        }
        self.begin_anew();
        self.panics += 1;
        let now = self.now;
        let last = self.panicked_at.replace(now);
        self.is_off = last.is_some_and(|last| (0.0..PROBATION_SECS).contains(&now.secs_since(last)));
        let mut statuses = Statuses::default();
        statuses.set(Level::Error, Statuses::FAULT, if self.is_off { OFF } else { FAILED });
        (self.failed, self.is_emptied) = (Some(statuses), true);
        None
    }

    fn begin_anew(&mut self) {
        if let Some(new) = (self.make)() {
            let old = std::mem::replace(&mut self.display, new);
            // Dropping a broken display may panic, too.
            let _ = catch_unwind(AssertUnwindSafe(|| drop(old)));
        }
    }

    /// Like [`guard`](Self::guard), at the time of a world.
    fn guard_at<T>(&mut self, world: &World<'_>, work: impl FnOnce(&mut dyn Display) -> T) -> Option<T> {
        self.now = world.now;
        self.guard(work)
    }
}

impl Display for GuardedDisplay {
    fn topics(&self) -> Vec<TopicRequest> {
        self.display.topics()
    }

    fn take(&mut self, message: &AnyMessage, world: &World<'_>) {
        self.guard_at(world, |display| display.take(message, world));
    }

    fn take_from(&mut self, topic: &str, message: &AnyMessage, world: &World<'_>) {
        self.guard_at(world, |display| display.take_from(topic, message, world));
    }

    fn is_waiting(&self, stamp: Time) -> bool {
        self.display.is_waiting(stamp)
    }

    fn publisher_left(&mut self, topic: &str) {
        self.guard(|display| display.publisher_left(topic));
    }

    fn is_replaced_by_newest(&self) -> bool {
        self.display.is_replaced_by_newest()
    }

    fn parameters(&self) -> Vec<String> {
        self.display.parameters()
    }

    fn take_parameter(&mut self, name: &str, text: Option<&Arc<str>>, world: &World<'_>) {
        self.guard_at(world, |display| display.take_parameter(name, text, world));
    }

    fn update(&mut self, world: &World<'_>) -> bool {
        let updated = self.guard_at(world, |display| display.update(world));
        if updated.is_some() && !self.display.drawables().is_empty() {
            self.failed = None;
        }
        updated.unwrap_or_default() | std::mem::take(&mut self.is_emptied)
    }

    fn drawables(&self) -> &[Drawable] {
        self.display.drawables()
    }

    fn next_change(&self) -> Option<Time> {
        self.display.next_change()
    }

    fn reset(&mut self) {
        self.guard(|display| display.reset());
    }

    fn statuses(&self) -> &Statuses {
        self.failed.as_ref().unwrap_or_else(|| self.display.statuses())
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix4;
    use rcs_messages::{geometry_msgs, nav_msgs, MessageKind};
    use rcs_scene::{Geometry, Material, Mesh};

    use super::*;
    use crate::framework::test_world::TestWorld;
    use crate::parts::solids::drawable;

    const TOPIC: &str = "/path";

    /// Shows something since it took a Path. It panics when it takes one with poses, in an update at three seconds, and
    /// when it is dropped with something that it took at two.
    #[derive(Default)]
    struct Fragile {
        drawables: Vec<Drawable>,
        statuses: Statuses,
        now: Time,
    }

    fn secs(secs: i64) -> Time {
        Time::from_nanos(secs * 1_000_000_000)
    }

    impl Display for Fragile {
        fn topics(&self) -> Vec<TopicRequest> {
            TopicRequest::new(TOPIC, MessageKind::Path, 1).into_iter().collect()
        }

        fn take(&mut self, message: &AnyMessage, world: &World<'_>) {
            self.now = world.now;
            let AnyMessage::Path(path) = message else { return };
            assert!(path.poses.is_empty(), "a test's panic");
            let mesh = Geometry::Mesh { mesh: Arc::new(Mesh::default()), material: Arc::new(Material::unlit(false)) };
            self.drawables = vec![drawable(0, Matrix4::identity(), mesh)];
            self.statuses.set(Level::Ok, "Path", "Shown");
        }

        fn update(&mut self, world: &World<'_>) -> bool {
            assert!(world.now != secs(3), "a test's panic");
            false
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
            assert!(self.drawables.is_empty() || self.now != secs(2), "a test's panic");
        }
    }

    fn path(poses: usize) -> AnyMessage {
        let poses = vec![geometry_msgs::PoseStamped::default(); poses];
        AnyMessage::Path(Arc::new(nav_msgs::Path { poses, ..nav_msgs::Path::default() }))
    }

    fn fragile() -> GuardedDisplay {
        GuardedDisplay::new(Box::new(|| Some(Box::new(Fragile::default())))).unwrap()
    }

    #[test]
    fn a_display_that_panics_is_emptied_and_failed_until_it_shows_something() {
        let world = TestWorld::at(secs(1));
        let world = world.get();
        let mut display = fragile();
        display.take_from(TOPIC, &path(0), &world);
        assert!(!display.update(&world) && !display.has_failed());
        assert_eq!((display.drawables().len(), display.statuses().level()), (1, Level::Ok));

        display.take_from(TOPIC, &path(1), &world);
        assert!(display.has_failed() && display.drawables().is_empty());
        assert_eq!(display.panics(), 1);
        assert!(display.update(&world), "what it showed is gone");
        assert!(!display.update(&world), "once");
        assert_eq!(display.statuses().get(Statuses::FAULT).map(|status| status.level), Some(Level::Error));
        assert_eq!(display.topics().len(), 1, "it goes on to listen");

        // Time jumps back.
        display.reset();
        display.update(&world);
        assert_eq!((display.drawables().len(), display.statuses().level()), (0, Level::Error), "nothing is shown");

        display.take_from(TOPIC, &path(0), &world);
        display.update(&world);
        assert!(!display.has_failed());
        assert_eq!((display.drawables().len(), display.statuses().level()), (1, Level::Ok));
    }

    #[test]
    fn panics_in_an_update_and_while_what_is_broken_is_dropped_are_caught() {
        let mut world = TestWorld::at(secs(2));
        let mut display = fragile();
        display.take_from(TOPIC, &path(0), &world.get());
        world.now = secs(3);
        assert!(display.update(&world.get()) && display.has_failed() && display.drawables().is_empty());
    }

    #[test]
    fn after_a_second_panic_within_a_minute_it_takes_nothing() {
        // At nine seconds, the time has jumped back.
        for (again_secs, is_off) in [(69, true), (70, false), (9, false)] {
            let mut world = TestWorld::at(secs(10));
            let mut display = fragile();
            display.take_from(TOPIC, &path(1), &world.get());
            world.now = secs(again_secs);
            display.take_from(TOPIC, &path(1), &world.get());
            let fault = display.statuses().get(Statuses::FAULT).map(|status| status.text.clone());
            assert_eq!(fault.as_deref(), Some(if is_off { OFF } else { FAILED }), "{again_secs}");
            assert_eq!(display.topics().len(), 1);
            display.take_from(TOPIC, &path(0), &world.get());
            display.update(&world.get());
            display.reset();
            assert_eq!((display.drawables().is_empty(), display.has_failed()), (is_off, is_off), "{again_secs}");
        }
    }
}
