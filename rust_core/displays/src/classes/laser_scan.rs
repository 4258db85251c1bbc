//! `rviz/LaserScan`: the points that a `sensor_msgs/LaserScan` hit, each where the scanner was when it measured it.
//!
//! Reproduces `laser_geometry`'s projection with TF: the scanner's poses at the first and at the last ray are looked
//! up, and each ray in between is taken from a pose in between (straight in translation, the shorter way in rotation).
//! The points are then in the fixed frame, and so are the sides of squares and boxes and the positions that colour
//! them. Rays count when `range_min ≤ range < range_max`.
//!
//! rviz accepts a scan as soon as its first ray can be placed, and loses it where the last one cannot be yet; here a
//! scan waits for both.

use std::cmp::Ordering;
use std::sync::Arc;

use nalgebra::{Isometry3, Point3};
use rcs_messages::sensor_msgs::{LaserScan, PointField};
use rcs_messages::PointCloud2;
use rcs_rviz_config::CloudSettings;
use rcs_scene::DisplayId;
use rcs_transforms::{interpolate, Time};

use crate::framework::frame;
use crate::framework::world::stamp;
use crate::parts::cloud::{one_row, CloudDisplay, CloudSource, NonFinite, PlacedCloud};
use crate::{Level, StatusText, Statuses, World};

const SCAN: &str = "Scan";
const SCAN_TIME: &str = "Scan Time";
/// Duration from which a scan has that status.
const LONG_SCAN_SECS: f64 = 2.0;

/// `sensor_msgs/LaserScan` as a cloud in the fixed frame.
#[derive(Debug)]
pub(crate) struct LaserScanSource;

pub(crate) fn create(display: DisplayId, settings: &CloudSettings) -> CloudDisplay<LaserScanSource> {
    CloudDisplay::new(display, settings.clone())
}

impl CloudSource for LaserScanSource {
    type Message = LaserScan;
    const NON_FINITE: NonFinite = NonFinite::FarAway;

    /// Time of the last ray. A scan with an invalid time does not wait: it is refused when it is placed.
    fn end(scan: &LaserScan) -> Time {
        last_ray(scan).unwrap_or(stamp(&scan.header))
    }

    /// rviz's warning (since 1.14.21) for a scan of two seconds or more.
    fn announce(scan: &LaserScan, statuses: &mut Statuses) {
        let secs = f64::from(scan.time_increment) * scan.ranges.len() as f64;
        if secs >= LONG_SCAN_SECS {
            let text = format!(
                "The scan takes {secs:.1} s, its time_increment of {} s for each of {} rays, and is shown that much later",
                scan.time_increment,
                scan.ranges.len()
            );
            statuses.set(Level::Warn, SCAN_TIME, text);
        } else {
            statuses.remove(SCAN_TIME);
        }
        match fault(scan) {
            Some(text) => statuses.set(Level::Warn, SCAN, text),
            None => statuses.remove(SCAN),
        }
    }

    fn place(scan: &Arc<LaserScan>, world: &World<'_>) -> Result<PlacedCloud, StatusText> {
        let end = last_ray(scan).ok_or_else(|| {
            format!("The scan's time increment of {} s leads to no time. Dropping message.", scan.time_increment)
        })?;
        let frame_id = &scan.header.frame_id;
        let poses = [stamp(&scan.header), end].map(|time| world.fixed_from(frame_id, time));
        let [Ok(first), Ok(last)] = poses else {
            return Err(frame::transform_failed(frame_id, world));
        };
        let cloud = Arc::new(project(scan, &first, &last));
        Ok(PlacedCloud { cloud, fixed_from_cloud: Isometry3::identity() })
    }
}

/// Fault by which no ray is seen, or all in one place; rviz says nothing of it.
fn fault(scan: &LaserScan) -> Option<String> {
    let LaserScan { angle_min, angle_increment, range_min, range_max, ranges, .. } = scan;
    if ranges.is_empty() {
        None
    } else if !angle_min.is_finite() || !angle_increment.is_finite() {
        Some(format!("Rays have no direction: angle_min is {angle_min} and angle_increment {angle_increment}"))
    } else if ranges.len() > 1 && *angle_increment == 0.0 {
        Some(format!("All {} rays have one direction: angle_increment is 0", ranges.len()))
    } else if range_min.partial_cmp(range_max) != Some(Ordering::Less) {
        Some(format!("No range is shown: range_min is {range_min} and range_max {range_max}"))
    } else if ranges.iter().all(|range| range.is_nan()) {
        Some(format!("No range is shown: all {} are NaN", ranges.len()))
    } else {
        None
    }
}

/// Time of the last ray; `None` if it is invalid.
fn last_ray(scan: &LaserScan) -> Option<Time> {
    let start = stamp(&scan.header);
    let duration_secs = scan.ranges.len().saturating_sub(1) as f64 * f64::from(scan.time_increment);
    let duration = std::time::Duration::try_from_secs_f64(duration_secs.abs()).ok()?;
    // ROS counts durations in 32 bits of seconds.
    (duration.as_secs() < 1 << 31).then_some(())?;
    Some(if duration_secs < 0.0 { start.saturating_sub(duration) } else { start.saturating_add(duration) })
}

/// Points in the fixed frame, with their intensities where the scan has any (0 for missing ones).
fn project(scan: &LaserScan, fixed_from_first: &Isometry3<f64>, fixed_from_last: &Isometry3<f64>) -> PointCloud2 {
    let has_intensity = !scan.intensities.is_empty();
    let fields = [("x", 0), ("y", 4), ("z", 8), ("intensity", 12)].map(|(name, at)| (name, at, PointField::FLOAT32));
    let (fields, point_step) = if has_intensity { (&fields[..], 16) } else { (&fields[..3], 12) };
    let is_moving = fixed_from_first != fixed_from_last;
    let mut data = Vec::with_capacity(scan.ranges.len() * point_step as usize);
    for (i, &range) in scan.ranges.iter().enumerate() {
        if !(range >= scan.range_min && range < scan.range_max) {
            continue;
        }
        let angle = f64::from(scan.angle_min) + i as f64 * f64::from(scan.angle_increment);
        let (sin, cos) = angle.sin_cos();
        // rviz rounds to single precision in the scanner's frame, and again in the fixed one.
        let in_scanner = Point3::new(f64::from(range) * cos, f64::from(range) * sin, 0.0).cast::<f32>().cast::<f64>();
        // NaN for a scan of one ray, which rviz does not show.
        let share = i as f64 * (scan.ranges.len() as f64 - 1.0).recip();
        let in_fixed = if is_moving || share.is_nan() {
            interpolate(fixed_from_first, fixed_from_last, share) * in_scanner
        } else {
            fixed_from_first * in_scanner
        };
        data.extend(in_fixed.cast::<f32>().iter().flat_map(|value| value.to_le_bytes()));
        if has_intensity {
            data.extend(scan.intensities.get(i).copied().unwrap_or(0.0).to_le_bytes());
        }
    }
    one_row(&scan.header, fields, point_step, data)
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;
    use rcs_rviz_config::{AxisColorSettings, ColorTransformer};
    use rcs_scene::{Geometry, PointBuffer};
    use rcs_transforms::RawTransform;

    use rcs_messages::AnyMessage;

    use super::*;
    use crate::framework::display::Display;
    use crate::framework::test_world::TestWorld;

    /// A display of scans, and a scanner that drives in `map` and turns.
    struct Bench {
        display: CloudDisplay<LaserScanSource>,
        world: TestWorld,
    }

    impl Bench {
        fn new(settings: CloudSettings) -> Self {
            let display = CloudDisplay::new(0, CloudSettings { topic: "/scan".to_owned(), ..settings });
            Self { display, world: TestWorld::at(Time::from_secs_nanos(100, 0)) }
        }

        /// Inserts the transform of the scanner in `map`, with its yaw in degrees.
        fn place(&mut self, secs: u32, translation: [f64; 3], yaw_deg: f64) {
            let turn = UnitQuaternion::from_euler_angles(0.0, 0.0, yaw_deg.to_radians());
            let transform = RawTransform {
                parent: "map",
                child: "laser",
                stamp: Time::from_secs_nanos(secs, 0),
                translation,
                rotation_xyzw: turn.coords.into(),
            };
            self.world.tree.insert(&transform, false, "/test").unwrap();
        }

        fn show(&mut self, scan: Option<LaserScan>) -> Option<Arc<PointBuffer>> {
            let world = self.world.get();
            if let Some(scan) = scan {
                self.display.take(&AnyMessage::LaserScan(Arc::new(scan)), &world);
            }
            self.display.update(&world);
            let drawable = self.display.drawables().first()?;
            let Geometry::Points(points) = &drawable.geometry else { panic!("points") };
            Some(points.buffer.clone())
        }
    }

    fn scan(secs: u32, ranges: &[f32]) -> LaserScan {
        let mut scan = LaserScan { ranges: ranges.to_vec(), range_min: 0.1, range_max: 10.0, ..LaserScan::default() };
        scan.header.frame_id = "laser".to_owned();
        scan.header.stamp.sec = secs;
        scan
    }

    fn assert_near(positions: &[[f32; 3]], expected: &[[f64; 3]]) {
        assert_eq!(positions.len(), expected.len());
        for (position, expected) in positions.iter().zip(expected) {
            let off_m = (Point3::from(*position).cast::<f64>() - Point3::from(*expected)).norm();
            assert!(off_m < 2e-6, "{position:?} instead of {expected:?}");
        }
    }

    #[test]
    fn rays_may_be_measured_backwards_in_time() {
        let mut bench = Bench::new(CloudSettings::default());
        bench.place(10, [0.0, 0.0, 0.0], 0.0);
        bench.place(12, [4.0, 0.0, 0.0], 0.0);
        let backwards = LaserScan { time_increment: -1.0, ..scan(12, &[1.0, 1.0, 1.0]) };
        let positions = bench.show(Some(backwards)).unwrap().positions.clone();
        assert_near(&positions, &[[5.0, 0.0, 0.0], [3.0, 0.0, 0.0], [1.0, 0.0, 0.0]]);
    }

    #[test]
    fn a_scan_waits_for_the_pose_at_its_last_ray() {
        let mut bench = Bench::new(CloudSettings::default());
        bench.place(10, [0.0, 0.0, 0.0], 0.0);
        assert!(bench.show(Some(LaserScan { time_increment: 1.0, ..scan(10, &[1.0, 1.0]) })).is_none());
        let level =
            |statuses: &Statuses| statuses.iter().find(|(name, _)| *name == Statuses::TRANSFORM).map(|(_, s)| s.level);
        assert_eq!(level(bench.display.statuses()), Some(Level::Warn));
        bench.place(11, [1.0, 0.0, 0.0], 0.0);
        assert_near(&bench.show(None).unwrap().positions, &[[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
        assert_eq!(level(bench.display.statuses()), Some(Level::Ok));
    }

    #[test]
    fn intensities_color_their_own_rays_and_those_that_are_missing_are_zero() {
        let mut bench = Bench::new(CloudSettings::default());
        bench.place(10, [0.0, 0.0, 0.0], 0.0);
        let intensities = vec![5.0, 99.0, 10.0];
        let buffer = bench.show(Some(LaserScan { intensities, ..scan(10, &[1.0, 0.0, 1.0, 1.0]) })).unwrap();
        let colors: Vec<[u8; 4]> = (0..3).map(|i| buffer.colors.get(i)).collect();
        // From 0 to 10: 5 is in the middle, 10 magenta at the end, and the missing one red.
        assert_eq!((colors[1], colors[2]), ([255, 0, 255, 255], [255, 0, 0, 255]));
        assert_eq!(colors[0], [0, 255, 127, 255]);
    }

    #[test]
    fn axes_color_by_positions_in_the_fixed_frame_even_where_the_own_frame_is_asked_for() {
        let axis_color = AxisColorSettings { use_fixed_frame: false, ..AxisColorSettings::default() };
        let color_transformer = Some(ColorTransformer::AxisColor);
        let mut bench = Bench::new(CloudSettings { axis_color, color_transformer, ..CloudSettings::default() });
        bench.place(10, [0.0, 0.0, 0.0], 0.0);
        bench.place(11, [0.0, 0.0, 1.0], 0.0);
        let buffer = bench.show(Some(LaserScan { time_increment: 1.0, ..scan(10, &[1.0, 1.0]) })).unwrap();
        assert_eq!((buffer.colors.get(0), buffer.colors.get(1)), ([255, 0, 0, 255], [255, 0, 255, 255]));
    }

    #[test]
    fn a_scan_without_a_time_is_refused() {
        let mut bench = Bench::new(CloudSettings::default());
        bench.place(10, [0.0, 0.0, 0.0], 0.0);
        for time_increment in [f32::NAN, f32::INFINITY, 1e30] {
            assert!(bench.show(Some(LaserScan { time_increment, ..scan(10, &[1.0, 1.0]) })).is_none());
            let statuses = bench.display.statuses();
            assert_eq!(statuses.level(), Level::Error, "{statuses:?}");
        }
        assert!(bench.show(Some(LaserScan { angle_increment: 0.1, ..scan(10, &[1.0, 1.0]) })).is_some());
        assert_eq!(bench.display.statuses().level(), Level::Ok);
    }

    #[test]
    fn a_scan_whose_rays_cannot_be_seen_is_a_warning() {
        let mut bench = Bench::new(CloudSettings::default());
        bench.place(10, [0.0, 0.0, 0.0], 0.0);
        let good = LaserScan { angle_increment: 0.1, range_max: f32::INFINITY, ..scan(10, &[1.0, 2.0]) };
        let mut said = |scan: LaserScan| {
            let count = bench.show(Some(scan)).unwrap().positions.len();
            let text = |name| bench.display.statuses().get(name).map_or(String::new(), |status| status.text.clone());
            (count, bench.display.statuses().level(), text("Scan").split(':').next().map(str::to_owned).unwrap())
        };
        let warned = |count: usize, text: &str| (count, Level::Warn, text.to_owned());
        let fine = |count: usize| (count, Level::Ok, String::new());
        assert_eq!(said(good.clone()), fine(2));
        for angle in [f32::NAN, f32::INFINITY] {
            assert_eq!(said(LaserScan { angle_min: angle, ..good.clone() }).2, "Rays have no direction");
            assert_eq!(said(LaserScan { angle_increment: angle, ..good.clone() }).2, "Rays have no direction");
        }
        let all_ahead = LaserScan { angle_increment: 0.0, ..good.clone() };
        assert_eq!(said(all_ahead), warned(2, "All 2 rays have one direction"));
        for [range_min, range_max] in [[0.0, 0.0], [5.0, 1.0], [f32::NAN, 9.0], [0.0, f32::NAN], [f32::INFINITY; 2]] {
            let limited = LaserScan { range_min, range_max, ..good.clone() };
            assert_eq!(said(limited), warned(0, "No range is shown"), "{range_min} {range_max}");
        }
        assert_eq!(said(LaserScan { ranges: vec![f32::INFINITY; 2], ..good.clone() }), fine(0), "nothing is in reach");
        assert_eq!(said(LaserScan { ranges: vec![f32::NAN; 2], ..good.clone() }), warned(0, "No range is shown"));
        assert_eq!(said(LaserScan { ranges: vec![], ..LaserScan { angle_min: f32::NAN, ..good.clone() } }), fine(0));
        assert_eq!(said(good), fine(2));
    }

    #[test]
    fn a_scan_that_takes_seconds_is_a_warning_until_a_shorter_one_comes() {
        let mut bench = Bench::new(CloudSettings::default());
        bench.place(10, [0.0, 0.0, 0.0], 0.0);
        bench.place(20, [0.0, 0.0, 0.0], 0.0);
        let mut status = |time_increment: f32, rays: usize| {
            bench.show(Some(LaserScan { time_increment, ..scan(10, &vec![1.0; rays]) }));
            bench.display.statuses().get("Scan Time").map(|status| (status.level, status.text.clone()))
        };
        assert_eq!(status(1.0, 1), None);
        let text =
            "The scan takes 360.0 s, its time_increment of 1 s for each of 360 rays, and is shown that much later";
        assert_eq!(status(1.0, 360), Some((Level::Warn, text.to_owned())), "while it waits");
        assert_eq!(status(0.001, 360), None);
        assert_eq!(status(1.0, 2).map(|(level, _)| level), Some(Level::Warn));
        assert_eq!(status(-1.0, 2), None, "rays backwards in time delay nothing");
    }
}
