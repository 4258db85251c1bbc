//! Markers of every kind and action, by the drawables that they become.

use std::sync::Arc;

use nalgebra::{Point3, Vector3};
use rcs_messages::geometry_msgs::Point;
use rcs_messages::std_msgs::ColorRGBA;
use rcs_messages::visualization_msgs::{Marker, MarkerArray};
use rcs_messages::{AnyMessage, MessageKind};
use rcs_rviz_config::MarkerSettings;
use rcs_scene::{Drawable, Geometry, Lighting, Material};
use rcs_transforms::Time;

use super::MarkerDisplay;
use crate::framework::display::Display;
use crate::framework::test_world::TestWorld;
use crate::parts::gathering::singly;
use crate::{Level, Statuses};

mod meshes;

/// A display with the world around it. The frame `map` is fixed.
struct Bench {
    display: MarkerDisplay,
    world: TestWorld,
}

impl Bench {
    fn with(display: MarkerDisplay) -> Self {
        Self { display, world: TestWorld::at(Time::from_secs_nanos(100, 0)) }
    }

    fn new() -> Self {
        Self::with(MarkerDisplay::new(3, MarkerSettings::array_default(), false))
    }

    /// Sends an array, without an update.
    fn send(&mut self, markers: &[Marker]) {
        let array = MarkerArray { markers: markers.to_vec() };
        self.display.take(&AnyMessage::MarkerArray(Arc::new(array)), &self.world.get());
    }

    fn update(&mut self) -> bool {
        self.display.update(&self.world.get())
    }

    /// Sends an array and returns all that is shown after it.
    fn show(&mut self, markers: &[Marker]) -> Vec<Drawable> {
        self.send(markers);
        self.update();
        self.drawn()
    }

    /// Drawables, each solid by itself.
    fn drawn(&self) -> Vec<Drawable> {
        singly(self.display.drawables())
    }

    fn only(&mut self, marker: &Marker) -> Drawable {
        let [drawable] = self.show(std::slice::from_ref(marker)).try_into().expect("one drawable");
        drawable
    }

    fn status(&self, name: &str) -> Option<(Level, String)> {
        let status = self.display.statuses().iter().find(|(known, _)| *known == name)?.1;
        Some((status.level, status.text.clone()))
    }

    fn place(&mut self, child: &str, secs: u32, x: f64) {
        self.world.place(child, Time::from_secs_nanos(secs, 0), [x, 0.0, 0.0]);
    }
}

fn marker(marker_type: u8, id: i32) -> Marker {
    let mut marker = Marker { type_: marker_type.into(), id, ns: "n".to_owned(), ..Marker::default() };
    marker.header.frame_id = "map".to_owned();
    marker.pose.orientation.w = 1.0;
    (marker.scale.x, marker.scale.y, marker.scale.z) = (1.0, 1.0, 1.0);
    marker.color = color(1.0, 0.5, 0.0, 1.0);
    marker
}

fn color(r: f32, g: f32, b: f32, a: f32) -> ColorRGBA {
    ColorRGBA { r, g, b, a }
}

fn points(coordinates: &[[f64; 3]]) -> Vec<Point> {
    coordinates.iter().map(|&[x, y, z]| Point { x, y, z }).collect()
}

fn deleting(id: i32) -> Marker {
    Marker { action: Marker::DELETE.into(), ..marker(Marker::CUBE, id) }
}

fn delete_all() -> Marker {
    let mut marker = Marker { action: Marker::DELETEALL.into(), ..Marker::default() };
    marker.header.frame_id = String::new();
    marker
}

fn at(drawable: &Drawable, [x, y, z]: [f64; 3]) -> [f64; 3] {
    let point = drawable.fixed_from_object.transform_point(&Point3::new(x, y, z));
    point.coords.map(|value| (value * 1e6).round() / 1e6).into()
}

fn material(drawable: &Drawable) -> &Material {
    let Geometry::Mesh { material, .. } = &drawable.geometry else { panic!("no mesh: {:?}", drawable.geometry) };
    material
}

fn diffuse(drawable: &Drawable) -> [f32; 4] {
    let Lighting::Lit { diffuse, .. } = material(drawable).lighting else { panic!("unlit") };
    diffuse.to_array()
}

#[test]
fn a_marker_display_subscribes_to_markers_and_arrays_and_an_array_display_only_to_arrays() {
    let single = MarkerDisplay::new(0, MarkerSettings { topic: "/m".to_owned(), ..MarkerSettings::default() }, true);
    let subscribed: Vec<_> = single.topics().into_iter().map(|t| (t.topic, t.kind)).collect();
    assert_eq!(subscribed, [("/m".into(), MessageKind::Marker), ("/m_array".into(), MessageKind::MarkerArray)]);
    let array = MarkerDisplay::new(0, MarkerSettings::array_default(), false);
    let subscribed: Vec<_> = array.topics().into_iter().map(|t| (t.topic, t.kind)).collect();
    assert_eq!(subscribed, [("visualization_marker_array".to_owned(), MessageKind::MarkerArray)]);

    let mut bench = Bench::with(single);
    let message = AnyMessage::Marker(Arc::new(marker(Marker::CUBE, 1)));
    let world = bench.world.get();
    bench.display.take(&message, &world);
    assert!(bench.update() && bench.drawn().len() == 1);
    assert!(!bench.update(), "nothing new");
}

#[test]
fn quaternions_are_normalised_and_zero_ones_are_no_rotation_with_a_warning() {
    let mut bench = Bench::new();
    let mut cube = marker(Marker::CUBE, 1);
    (cube.pose.orientation.w, cube.pose.orientation.z) = (3.0, 3.0);
    let turned = bench.only(&cube);
    assert_eq!(at(&turned, [0.5, 0.0, 0.0]), [0.0, 0.5, 0.0]);
    assert_eq!(bench.status("n/1").unwrap().0, Level::Warn);
    (cube.pose.orientation.w, cube.pose.orientation.z) = (0.0, 0.0);
    assert_eq!(at(&bench.only(&cube), [0.5, 0.0, 0.0]), [0.5, 0.0, 0.0]);
    assert_eq!(bench.status("n/1").unwrap().0, Level::Warn);
    cube.pose.orientation.w = 1.0;
    bench.only(&cube);
    assert_eq!(bench.status("n/1"), None);
}

#[test]
fn a_marker_of_a_wrong_number_of_points_is_an_error_and_the_old_one_is_gone() {
    for (kind, text) in [
        (Marker::ARROW, "an arrow has 0 or 2 points, not 3"),
        (Marker::LINE_LIST, "two points a line, but there are 3"),
    ] {
        let mut marker = marker(kind, 1);
        marker.points = points(&[[0.0; 3], [2.0, 0.0, 0.0]]);
        let mut bench = Bench::new();
        assert!(!bench.show(&[marker.clone()]).is_empty());
        marker.points.push(Point::default());
        assert!(bench.show(&[marker]).is_empty());
        let (level, found) = bench.status("n/1").unwrap();
        assert!(level == Level::Error && found.contains(text), "{found}");
    }
}

#[test]
fn a_marker_sent_again_in_any_order_looks_as_one_sent_for_the_first_time() {
    let mut all = Vec::new();
    for marker_type in [Marker::ARROW, Marker::SPHERE, Marker::CUBE, Marker::ARROW] {
        for (scale, red, alpha, x) in [
            (1.0, 1.0, 1.0, 0.0),
            (1.0, 1.0, 1.0, 2.0),
            (3.0, 1.0, 1.0, 2.0),
            (3.0, 0.5, 1.0, 2.0),
            (3.0, 0.5, 0.5, 2.0),
        ] {
            let mut marker = marker(marker_type, 1);
            (marker.scale.y, marker.color, marker.pose.position.x) = (scale, color(red, 0.5, 0.0, alpha), x);
            all.push(marker);
        }
    }
    let mut by_points = marker(Marker::ARROW, 1);
    by_points.points = points(&[[0.0; 3], [0.0, 2.0, 0.0]]);
    all.insert(2, by_points);
    let looks = |drawn: &[Drawable]| -> Vec<_> {
        let mesh = |drawable: &Drawable| match &drawable.geometry {
            Geometry::Mesh { mesh, .. } => Arc::as_ptr(mesh),
            other => panic!("{other:?}"),
        };
        drawn.iter().map(|one| (one.fixed_from_object, one.sort_point, diffuse(one), mesh(one))).collect()
    };
    for first in &all {
        for second in &all {
            let mut bench = Bench::new();
            bench.show(std::slice::from_ref(first));
            let shown = bench.show(std::slice::from_ref(second));
            let expected = Bench::new().show(std::slice::from_ref(second));
            // An arrow by two points keeps the scale of one by pose.
            let keeps = second.points.len() == 2 && first.type_ == second.type_ && first.scale.y != 1.0;
            assert_eq!(looks(&shown) == looks(&expected), !keeps, "{first:?}, then {second:?}");
        }
    }
}

#[test]
fn markers_are_replaced_by_namespace_and_id_and_change_their_type() {
    let mut bench = Bench::new();
    let other_namespace = Marker { ns: "other".to_owned(), ..marker(Marker::CUBE, 1) };
    assert_eq!(bench.show(&[marker(Marker::CUBE, 1), marker(Marker::CUBE, 1), other_namespace]).len(), 2);
    assert_eq!(bench.status("marker_array").unwrap().0, Level::Warn);
    let mut moved = marker(Marker::CUBE, 1);
    moved.pose.position.x = 5.0;
    let drawn = bench.show(&[moved]);
    assert_eq!((drawn.len(), at(&drawn[0], [0.0; 3])), (2, [5.0, 0.0, 0.0]), "a moved marker keeps its turn");
    assert_eq!(bench.status("marker_array"), None);
    let drawn = bench.show(&[marker(Marker::ARROW, 1)]);
    assert_eq!((drawn.len(), drawn[0].sort_point.x), (3, 0.0), "a marker of another type is a new one");
}

#[test]
fn deleting_takes_one_or_all_away_in_any_order() {
    let mut bench = Bench::new();
    assert_eq!(bench.show(&[deleting(1), marker(Marker::CUBE, 1), marker(Marker::CUBE, 2)]).len(), 2);
    assert_eq!(bench.show(&[deleting(1), deleting(9)]).len(), 1);
    let in_frame = Marker { header: marker(Marker::CUBE, 0).header, ..delete_all() };
    assert_eq!(bench.show(&[in_frame.clone(), marker(Marker::CUBE, 3)]).len(), 1);
    assert_eq!(bench.show(&[marker(Marker::CUBE, 4), in_frame]).len(), 0);
    assert_eq!(bench.status("marker_array").unwrap().0, Level::Warn);
}

#[test]
fn delete_all_without_a_frame_comes_before_what_its_array_adds_and_after_earlier_messages() {
    let mut bench = Bench::new();
    bench.send(&[marker(Marker::CUBE, 1)]);
    bench.send(&[marker(Marker::CUBE, 2), delete_all()]);
    bench.update();
    assert_eq!(bench.drawn().len(), 1);
    assert_eq!(bench.status("/0"), None);
    // Adding without a frame is an error.
    let mut lost = marker(Marker::CUBE, 5);
    lost.header.frame_id.clear();
    assert_eq!(bench.show(&[lost]).len(), 1);
    assert_eq!(bench.status("n/5").unwrap().0, Level::Error);
}

#[test]
fn a_marker_goes_when_its_lifetime_is_over_in_ros_time() {
    let mut bench = Bench::new();
    let mut short = marker(Marker::CUBE, 1);
    (short.lifetime.sec, short.lifetime.nsec) = (1, 500_000_000);
    let mut negative = marker(Marker::CUBE, 2);
    negative.lifetime.sec = -1;
    assert_eq!(bench.show(&[short.clone(), negative]).len(), 2);
    assert_eq!(bench.display.next_change(), Some(Time::from_secs_nanos(101, 500_000_000)));
    bench.world.now = Time::from_secs_nanos(101, 499_999_999);
    assert!(!bench.update());
    assert_eq!(bench.show(&[short]).len(), 2, "seen again, it lives on");
    bench.world.now = Time::from_secs_nanos(102, 0);
    assert!(!bench.update());
    bench.world.now = Time::from_secs_nanos(103, 0);
    assert!(bench.update());
    assert_eq!((bench.drawn().len(), bench.display.next_change()), (1, None));
}

#[test]
fn a_locked_marker_follows_its_frame_and_another_stays() {
    let mut bench = Bench::new();
    bench.place("arm", 99, 1.0);
    let mut fixed = marker(Marker::CUBE, 1);
    fixed.header.frame_id = "arm".to_owned();
    let locked = Marker { id: 2, frame_locked: true, ..fixed.clone() };
    bench.show(&[fixed, locked]);
    let before = bench.drawn();
    bench.place("arm", 100, 2.0);
    assert!(bench.update());
    let x = |drawable: &Drawable| at(drawable, [0.0; 3])[0];
    assert_eq!(bench.drawn().iter().map(x).collect::<Vec<_>>(), [1.0, 2.0]);
    let shared = |drawable: &Drawable| match &drawable.geometry {
        Geometry::Mesh { mesh, .. } => Arc::as_ptr(mesh),
        other => panic!("{other:?}"),
    };
    assert_eq!(shared(&before[1]), shared(&bench.drawn()[1]), "nothing is built again");
    assert!(!bench.update());
}

#[test]
fn markers_wait_for_their_frame_and_the_oldest_are_dropped_by_name() {
    let settings = MarkerSettings { queue_size: 2, ..MarkerSettings::array_default() };
    let mut bench = Bench::with(MarkerDisplay::new(0, settings, false));
    let waiting: Vec<Marker> = (1..=3)
        .map(|id| {
            let mut marker = marker(Marker::CUBE, id);
            marker.header.frame_id = "arm".to_owned();
            marker
        })
        .collect();
    let placed: Vec<Marker> = (11..=15).map(|id| marker(Marker::CUBE, id)).collect();
    assert_eq!(bench.show(&[placed, waiting].concat()).len(), 5, "what can be placed needs no room in the queue");
    assert_eq!(bench.status(Statuses::TRANSFORM).unwrap().0, Level::Warn);
    assert!(bench.status("n/1").unwrap().1.contains("[arm]"));
    bench.place("arm", 99, 1.0);
    assert!(bench.update());
    assert_eq!(bench.drawn().len(), 7);
    assert_eq!(bench.status(Statuses::TRANSFORM), None);
}

#[test]
fn what_is_not_finite_is_an_error_and_the_others_are_shown() {
    let mut bench = Bench::new();
    let mut bad = [marker(Marker::CUBE, 1), marker(Marker::SPHERE, 2), marker(Marker::CYLINDER, 3)];
    bad[0].pose.position.x = f64::NAN;
    bad[1].scale.y = 1e300;
    bad[2].color.g = f32::INFINITY;
    let unknown = Marker { type_: 12, id: 4, ..marker(Marker::CUBE, 4) };
    let drawn = bench.show(&[&bad[..], &[unknown, marker(Marker::CUBE, 5)]].concat());
    assert_eq!(drawn.len(), 1);
    for id in 1..=4 {
        assert_eq!(bench.status(&format!("n/{id}")).unwrap().0, Level::Error, "{id}");
    }
    assert_eq!(bench.status("n/5"), None);
}

#[test]
fn a_zero_scale_is_drawn_with_a_warning() {
    let mut bench = Bench::new();
    let mut flat = marker(Marker::CUBE, 1);
    flat.scale.z = 0.0;
    let drawn = bench.only(&flat);
    assert_eq!(at(&drawn, [0.5, 0.5, 0.5]), [0.5, -0.5, 0.0]);
    assert_eq!(bench.status("n/1").unwrap().0, Level::Warn);
}

#[test]
fn forgetting_everything_leaves_an_empty_scene() {
    let mut bench = Bench::new();
    bench.show(&[marker(Marker::CUBE, 1)]);
    bench.display.reset();
    assert!(bench.drawn().is_empty() && bench.update());
    assert!(bench.drawn().is_empty());
    let world = bench.world.get();
    assert_eq!(world.fixed_from("map", Time::ZERO).map(|place| place.translation.vector), Ok(Vector3::zeros()));
}

#[test]
fn a_large_array_is_placed_in_steps_and_appears_at_once() {
    let cubes = |x: f64| -> Vec<Marker> {
        let at = |id| {
            let mut cube = marker(Marker::CUBE, id);
            cube.pose.position.x = x;
            cube
        };
        (0..50).map(at).collect()
    };
    let mut bench = Bench::new();
    bench.world.step = Some(20);
    let updates = |bench: &mut Bench| -> Vec<bool> {
        std::iter::from_fn(|| {
            let changed = bench.update();
            let is_due = bench.display.next_change() == Some(bench.world.now);
            assert_eq!(bench.display.is_waiting(Time::ZERO), is_due);
            is_due.then_some(changed)
        })
        .collect()
    };
    let places = |bench: &Bench| -> Vec<f64> {
        let mut places: Vec<f64> = bench.drawn().iter().map(|cube| at(cube, [0.0; 3])[0]).collect();
        places.dedup();
        places
    };
    bench.send(&cubes(1.0));
    assert_eq!(updates(&mut bench), [false, false]);
    assert_eq!((bench.drawn().len(), places(&bench)), (50, vec![1.0]));
    assert_eq!(bench.display.next_change(), None);
    // The markers of before are shown meanwhile.
    bench.send(&cubes(2.0));
    assert!(!bench.update());
    assert_eq!((bench.drawn().len(), places(&bench)), (50, vec![1.0]));
    // Another message does not overtake the one before.
    bench.send(&[deleting(49), marker(Marker::SPHERE, 50)]);
    assert!(bench.update());
    let drawn = bench.drawn();
    assert_eq!((drawn.len(), places(&bench)), (50, vec![2.0, 0.0]));
    // Arrays that come faster than they are placed in steps are shown, every second one at least.
    for x in [3.0, 5.0, 7.0] {
        bench.send(&cubes(x));
        assert!(!bench.update());
        bench.send(&cubes(x + 1.0));
        assert!(bench.update());
        assert_eq!((bench.drawn().len(), places(&bench)), (51, vec![x + 1.0, 0.0, x + 1.0]));
    }
    // Forgotten in between.
    bench.send(&cubes(9.0));
    assert!(!bench.update());
    bench.display.reset();
    assert!(updates(&mut bench).is_empty());
    assert!(bench.drawn().is_empty());
}
