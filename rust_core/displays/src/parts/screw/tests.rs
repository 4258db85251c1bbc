//! Wrenches, twists and accelerations, by the drawables that they become.

use std::sync::Arc;

use rcs_messages::geometry_msgs::{TwistStamped, Vector3, WrenchStamped};
use rcs_messages::AnyMessage;
use rcs_transforms::Time;

use super::*;
use crate::framework::display::Display;
use crate::framework::test_world::TestWorld;
use crate::Level;

struct Bench {
    display: MessageDisplay<ScrewVisual<TwistStamped>>,
    world: TestWorld,
}

impl Bench {
    fn new(settings: &ScrewSettings) -> Self {
        let world = TestWorld::at(Time::from_secs_nanos(1, 0));
        let mut bench = Self { display: create(0, settings), world };
        bench.place(1.0);
        bench
    }

    /// Inserts the transform of the messages' frame.
    fn place(&mut self, x: f64) {
        self.world.place_static("base", [x, 0.0, 0.0]);
    }

    /// Sends twists at once; returns whether the image changed.
    fn send_all(&mut self, twists: &[([f64; 3], [f64; 3])]) -> bool {
        let vector = |[x, y, z]: [f64; 3]| Vector3 { x, y, z };
        for &(linear, angular) in twists {
            let mut twist = TwistStamped::default();
            twist.header.frame_id = "base".to_owned();
            (twist.twist.linear, twist.twist.angular) = (vector(linear), vector(angular));
            self.display.take(&AnyMessage::TwistStamped(Arc::new(twist)), &self.world.get());
        }
        self.display.update(&self.world.get())
    }

    fn send(&mut self, linear: [f64; 3], angular: [f64; 3]) -> bool {
        self.send_all(&[(linear, angular)])
    }

    fn status(&self) -> Vec<(Level, &str)> {
        self.display.statuses().iter().map(|(_, status)| (status.level, status.text.as_str())).collect()
    }
}

const LONG: [f64; 3] = [0.0, 1.0, 0.0];
const NONE: [f64; 3] = [0.0; 3];

#[test]
fn the_history_keeps_the_last_screws_where_their_frame_was() {
    let mut bench = Bench::new(&ScrewSettings { history_length: 2, ..ScrewSettings::default() });
    for x in [1.0, 2.0, 3.0] {
        bench.place(x);
        assert!(bench.send(LONG, NONE));
    }
    let xs: Vec<f64> = bench.display.drawables().iter().map(|drawable| drawable.sort_point.x).collect();
    assert_eq!(xs, [2.0, 2.0, 3.0, 3.0]);
    bench.display.reset();
    assert!(bench.display.drawables().is_empty() && bench.status().is_empty());
}

#[test]
fn a_screw_with_infinity_is_an_error_and_changes_nothing() {
    let mut bench = Bench::new(&ScrewSettings::default());
    assert!(bench.send(LONG, NONE));
    assert!(!bench.send([0.0, f64::INFINITY, 0.0], LONG));
    assert_eq!(bench.display.drawables().len(), 2);
    assert!(bench.status().contains(&(Level::Error, "Message contained invalid floating point values (nans or infs)")));
    assert!(bench.send(LONG, LONG));
    assert_eq!(bench.display.statuses().level(), Level::Ok);
}

/// A good screw left the error of a bad one before it in the same update.
#[test]
fn of_several_screws_in_one_update_the_last_decides_the_status() {
    let (good, bad) = ((LONG, NONE), (LONG, [f64::NAN; 3]));
    let mut bench = Bench::new(&ScrewSettings::default());
    assert!(bench.send_all(&[bad, good]));
    assert_eq!(bench.display.statuses().level(), Level::Ok);
    assert!(bench.send_all(&[good, bad]));
    assert_eq!(bench.display.statuses().level(), Level::Error);
}

#[test]
fn messages_of_another_kind_are_no_screws() {
    let mut bench = Bench::new(&ScrewSettings::default());
    let world = bench.world.get();
    bench.display.take(&AnyMessage::WrenchStamped(Arc::new(WrenchStamped::default())), &world);
    bench.display.take(&AnyMessage::Path(Arc::default()), &world);
    assert!(bench.status().is_empty() && !bench.display.is_waiting(Time::ZERO));
}
