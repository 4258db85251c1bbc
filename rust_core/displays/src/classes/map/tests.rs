//! Maps and their changes, by what is shown of them.

use std::sync::Arc;

use nalgebra::{Point3, Vector3};
use rcs_messages::map_msgs::OccupancyGridUpdate;
use rcs_messages::{AnyMessage, MessageKind, OccupancyGrid};
use rcs_rviz_config::{MapPalette, MapSettings};
use rcs_scene::{Blending, CellSheet, Geometry, RenderGroup};
use rcs_transforms::Time;

use super::{create, MapDisplay};
use crate::framework::display::Display;
use crate::framework::test_world::TestWorld;
use crate::{Level, Statuses};

/// A display with the world around it. The frame `odom` is fixed.
struct Bench {
    display: MapDisplay,
    world: TestWorld,
}

impl Bench {
    fn new(mut settings: MapSettings) -> Self {
        "/map".clone_into(&mut settings.topic);
        let world = TestWorld::fixed_in("odom", Time::from_secs_nanos(9, 0));
        let mut bench = Self { display: create(0, &settings), world };
        bench.place(1, 0.0);
        bench
    }

    fn place(&mut self, secs: u32, x: f64) {
        self.world.place("map", Time::from_secs_nanos(secs, 0), [x, 0.0, 0.0]);
    }

    /// Hands a message over and returns whether the scene changed.
    fn send(&mut self, message: &AnyMessage) -> bool {
        self.display.take(message, &self.world.get());
        self.display.update(&self.world.get())
    }

    fn map(&mut self, grid: OccupancyGrid) -> bool {
        self.send(&AnyMessage::OccupancyGrid(Arc::new(grid)))
    }

    fn change(&mut self, [x, y]: [i32; 2], [width, height]: [u32; 2], data: &[i8]) -> bool {
        let update = OccupancyGridUpdate { x, y, width, height, data: data.to_vec(), ..Default::default() };
        self.send(&AnyMessage::OccupancyGridUpdate(Arc::new(update)))
    }

    fn sheet(&self) -> &CellSheet {
        match self.display.drawables() {
            [drawable] => match &drawable.geometry {
                Geometry::Cells(sheet) => sheet,
                other => panic!("{other:?}"),
            },
            other => panic!("{other:?}"),
        }
    }

    fn corner(&self, x: f64, y: f64) -> Point3<f64> {
        self.display.drawables()[0].fixed_from_object.transform_point(&Point3::new(x, y, 0.0))
    }

    fn status(&self, name: &str) -> (Level, &str) {
        let status = self.display.statuses().iter().find(|(known, _)| *known == name);
        status.map_or((Level::Ok, ""), |(_, status)| (status.level, status.text.as_str()))
    }
}

fn grid(width: u32, height: u32, data: &[u8]) -> OccupancyGrid {
    let mut grid = OccupancyGrid::default().with_data(data.to_vec());
    grid.header.frame_id = "map".to_owned();
    grid.header.stamp.sec = 1;
    (grid.info.width, grid.info.height, grid.info.resolution) = (width, height, 0.5);
    grid.info.origin.position.y = 2.0;
    grid
}

#[test]
fn a_map_is_as_large_as_its_cells_and_follows_its_frame() {
    let mut bench = Bench::new(MapSettings::default());
    assert_eq!(bench.status("Message"), (Level::Warn, "No map received"));
    assert!(bench.map(grid(2, 3, &[0, 1, 2, 3, 4, 5])));
    assert_eq!([bench.status("Map").1, bench.status("Message").1], ["Map OK", "Map received"]);
    assert_eq!((bench.corner(0.0, 0.0), bench.corner(1.0, 1.0)), ([0.0, 2.0, 0.0].into(), [1.0, 3.5, 0.0].into()));
    let meanwhile = grid(0, 0, &[]);
    assert!(!bench.map(meanwhile), "nothing has changed");
    assert_eq!(bench.status("Map"), (Level::Warn, "Map of 0x0 cells has no data"));
    bench.place(5, 10.0);
    assert!(bench.map(grid(0, 0, &[])), "the frame has moved");
    assert_eq!(bench.corner(0.0, 0.0), [10.0, 2.0, 0.0].into());
    assert_eq!(bench.display.drawables()[0].sort_point, [10.0, 2.0, 0.0].into());
}

#[test]
fn cells_and_place_of_a_new_map_change_in_one_image() {
    let mut bench = Bench::new(MapSettings::default());
    bench.map(grid(1, 1, &[7]));
    bench.place(5, 10.0);
    let mut grown = grid(2, 1, &[7, 8]);
    grown.info.origin.position.x = -0.5;
    assert!(bench.map(grown));
    assert_eq!((bench.sheet().cells.width(), bench.corner(0.0, 0.0).x), (2, 9.5));
}

#[test]
fn with_use_timestamp_it_stays_where_it_was_at_its_stamp() {
    let mut bench = Bench::new(MapSettings { use_timestamp: true, ..MapSettings::default() });
    bench.place(5, 10.0);
    bench.map(grid(1, 1, &[0]));
    assert_eq!(bench.corner(0.0, 0.0).x, 0.0);
    let mut early = grid(1, 1, &[0]);
    early.header.stamp.nsec = 500_000_000;
    early.header.stamp.sec = 0;
    bench.map(early);
    assert_eq!(bench.corner(0.0, 0.0).x, 10.0, "where nothing is known of that time, the latest place");
}

#[test]
fn a_map_in_an_unknown_frame_lies_at_the_origin_with_an_error() {
    let mut bench = Bench::new(MapSettings::default());
    let mut elsewhere = grid(1, 1, &[0]);
    elsewhere.header.frame_id = "mars".to_owned();
    bench.map(elsewhere);
    assert_eq!(bench.corner(0.0, 0.0), Point3::origin());
    assert_eq!(bench.status(Statuses::TRANSFORM), (Level::Error, "No transform from [mars] to [odom]"));
    let mut unnamed = grid(1, 1, &[0]);
    unnamed.header.frame_id.clear();
    bench.map(unnamed);
    assert_eq!(bench.status(Statuses::TRANSFORM).1, "Transform OK", "no frame name stands for map");
}

#[test]
fn changes_replace_cells_and_those_that_reach_outside_do_not() {
    let mut bench = Bench::new(MapSettings::default());
    assert!(!bench.change([0, 0], [1, 1], &[7]), "before there is a map");
    bench.map(grid(2, 3, &[0, 1, 2, 3, 4, 5]));
    assert!(bench.change([1, 0], [1, 2], &[100, -1]));
    let cells =
        |bench: &Bench| [(0, 0), (1, 0), (0, 1), (1, 1), (0, 2), (1, 2)].map(|(x, y)| bench.sheet().cells.get(x, y));
    assert_eq!(cells(&bench), [0, 100, 2, 255, 4, 5]);
    for (place, size) in [([-1, 0], [1, 1]), ([1, 0], [2, 1]), ([0, 3], [1, 1]), ([1, 1], [u32::MAX, 1])] {
        assert!(!bench.change(place, size, &[9, 9]), "{place:?} {size:?}");
        assert_eq!(bench.status("Update"), (Level::Error, "Update area outside of original map area."));
        assert!(bench.change([0, 0], [1, 1], &[0]));
        assert_eq!(bench.status("Update"), (Level::Ok, ""));
    }
    assert!(!bench.change([0, 0], [2, 2], &[9, 9, 9]));
    assert_eq!(bench.status("Update").0, Level::Error);
    assert_eq!(cells(&bench), [0, 100, 2, 255, 4, 5]);
}

#[test]
fn a_bad_map_is_reported_and_the_last_good_one_stays() {
    let mut bench = Bench::new(MapSettings::default());
    bench.map(grid(1, 1, &[42]));
    let mut misplaced = grid(1, 1, &[0]);
    misplaced.info.origin.position.x = f64::NAN;
    let mut endless = grid(1, 1, &[0]);
    endless.info.resolution = f32::INFINITY;
    let not_finite = "Message contained invalid floating point values (nans or infs)";
    for (bad, text) in [
        (misplaced, not_finite),
        (endless, not_finite),
        (grid(0, 7, &[0]), "Map is zero-sized (0x7)"),
        (
            grid(65_536, 65_536, &[0]),
            "Data size doesn't match width*height: width = 65536, height = 65536, data size = 1",
        ),
        (grid(u32::MAX, 1, &[0]), "Map is too large (4294967295x1), at most 65536 cells a side"),
    ] {
        assert!(!bench.map(bad), "{text}");
        assert_eq!(bench.status("Map"), (Level::Error, text));
        assert!(!bench.change([0, 0], [1, 1], &[9]));
        assert_eq!(bench.sheet().cells.get(0, 0), 42);
    }
    let mut flat = grid(1, 1, &[7]);
    flat.info.resolution = 0.0;
    assert!(bench.map(flat), "it takes the place of the last one, as in rviz");
    assert_eq!(bench.status("Map"), (Level::Error, "Map has a resolution of 0 m, its cells are invisible."));
    assert!(bench.map(grid(2, 2, &[1])));
    let text = "Data size doesn't match width*height: width = 2, height = 2, data size = 1";
    assert_eq!(bench.status("Map"), (Level::Error, text));
    assert_eq!([bench.sheet().cells.get(0, 0), bench.sheet().cells.get(1, 1)], [1, 255]);
}

#[test]
fn only_an_opaque_map_that_is_not_behind_hides_anything() {
    let drawn = |alpha, palette, draw_behind| {
        let mut bench = Bench::new(MapSettings { alpha, palette, draw_behind, ..MapSettings::default() });
        bench.map(grid(1, 1, &[0]));
        let sheet = bench.sheet();
        (bench.display.drawables()[0].group, sheet.blending, sheet.depth_write)
    };
    assert_eq!(drawn(1.0, MapPalette::Map, false), (RenderGroup::Main, Blending::Replace, true));
    assert_eq!(drawn(1.0, MapPalette::Map, true), (RenderGroup::Behind, Blending::Replace, false));
    assert_eq!(drawn(0.7, MapPalette::Map, false), (RenderGroup::Main, Blending::Alpha, false));
    for palette in [MapPalette::Costmap, MapPalette::Raw] {
        assert_eq!(drawn(1.0, palette, false), (RenderGroup::Main, Blending::Alpha, false));
    }
}

#[test]
fn changes_come_on_a_topic_of_their_own() {
    let display = create(0, &MapSettings { topic: "/map".to_owned(), ..MapSettings::default() });
    let topics: Vec<_> = display.topics().into_iter().map(|request| (request.topic, request.kind)).collect();
    let expected = [("/map", MessageKind::OccupancyGrid), ("/map_updates", MessageKind::OccupancyGridUpdate)];
    assert_eq!(topics, expected.map(|(topic, kind)| (topic.to_owned(), kind)));
    assert!(create(0, &MapSettings::default()).topics().is_empty());
}

#[test]
fn a_turned_origin_turns_the_map() {
    let mut bench = Bench::new(MapSettings::default());
    let mut turned = grid(2, 1, &[0, 0]);
    (turned.info.origin.orientation.z, turned.info.origin.orientation.w) = (2.0, 2.0);
    bench.map(turned);
    assert!((bench.corner(1.0, 1.0) - Point3::from(Vector3::new(-0.5, 3.0, 0.0))).norm() < 1e-12);
}
