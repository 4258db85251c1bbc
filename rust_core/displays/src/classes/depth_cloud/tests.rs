//! Depth images, by the points that are shown of them.

use std::sync::Arc;

use rcs_messages::sensor_msgs::{CameraInfo, CompressedImage};
use rcs_messages::std_msgs::Header;
use rcs_messages::{AnyMessage, Image, MessageKind};
use rcs_rviz_config::DepthCloudSettings;
use rcs_scene::{Geometry, PointStyle, Points};
use rcs_transforms::Time;

use super::{create, DepthCloudDisplay};
use crate::framework::display::Display;
use crate::framework::test_world::TestWorld;
use crate::Level;

/// A display with the world around it: the camera's frame is `camera`, and `map` is fixed.
struct Bench {
    display: DepthCloudDisplay,
    world: TestWorld,
}

impl Bench {
    fn new(settings: DepthCloudSettings) -> Self {
        let settings = DepthCloudSettings { depth_topic: "/cam/depth/image".to_owned(), ..settings };
        let world = TestWorld::at(Time::from_secs_nanos(1, 0));
        let mut bench = Self { display: create(0, &settings), world };
        bench.place(0, 0.0);
        bench
    }

    fn place(&mut self, secs: u32, x: f64) {
        self.world.place("camera", Time::from_secs_nanos(secs, 0), [x, 0.0, 0.0]);
    }

    fn send(&mut self, topic: &str, message: &AnyMessage) -> bool {
        self.display.take_from(topic, message, &self.world.get());
        self.display.update(&self.world.get())
    }

    fn info(&mut self, info: CameraInfo) -> bool {
        self.send("/cam/depth/camera_info", &AnyMessage::CameraInfo(Arc::new(info)))
    }

    fn depth(&mut self, image: Image) -> bool {
        self.send("/cam/depth/image", &AnyMessage::Image(Arc::new(image)))
    }

    fn color(&mut self, image: Image) -> bool {
        self.send("/cam/color", &AnyMessage::Image(Arc::new(image)))
    }

    fn points(&self) -> &Points {
        match self.display.drawables() {
            [drawable] => match &drawable.geometry {
                Geometry::Points(points) => points,
                other => panic!("{other:?}"),
            },
            other => panic!("{other:?}"),
        }
    }

    fn depths(&self) -> Vec<f32> {
        self.points().buffer.positions.iter().map(|position| position[2]).collect()
    }

    fn message_status(&self) -> (Level, &str) {
        let status = self.display.statuses().iter().find(|(known, _)| *known == "Message");
        status.map_or((Level::Ok, ""), |(_, status)| (status.level, status.text.as_str()))
    }
}

fn info(width: u32, height: u32) -> CameraInfo {
    let mut info = CameraInfo { width, height, ..CameraInfo::default() };
    info.P = [2.0, 0.0, 0.5, 0.0, 0.0, 4.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    info.K[0] = 2.0;
    info
}

fn image(encoding: &str, size_px: [u32; 2], data: Vec<u8>) -> Image {
    let header = Header { frame_id: "camera".to_owned(), ..Header::default() };
    let step = data.len() as u32 / size_px[1].max(1);
    Image::new(header, size_px, encoding, step, Arc::new(data))
}

fn millimetres(depths: &[u16]) -> Image {
    image("16UC1", [depths.len() as u32, 1], depths.iter().flat_map(|depth| depth.to_le_bytes()).collect())
}

fn with_color() -> DepthCloudSettings {
    DepthCloudSettings { color_topic: "/cam/color".to_owned(), ..DepthCloudSettings::default() }
}

#[test]
fn a_depth_lies_on_its_pixels_ray() {
    let mut bench = Bench::new(DepthCloudSettings::default());
    bench.info(info(2, 2));
    let metres = [1.0_f32, f32::NAN, f32::INFINITY, -2.0].iter().flat_map(|depth| depth.to_le_bytes()).collect();
    assert!(bench.depth(image("32FC1", [2, 2], metres)));
    assert_eq!(bench.points().buffer.positions, [[-0.25, 0.0, 1.0], [-0.5, -0.5, -2.0]]);
    assert!(bench.depth(image("16UC1", [2, 2], [0, 500, 2000, 0_u16].iter().flat_map(|d| d.to_le_bytes()).collect())));
    assert_eq!(bench.points().buffer.positions, [[0.125, 0.0, 0.5], [-0.5, 0.5, 2.0]]);
}

#[test]
fn points_are_as_large_as_their_pixels_unless_auto_size_is_off() {
    let drawn = |settings: DepthCloudSettings| {
        let mut bench = Bench::new(settings);
        bench.info(CameraInfo { binning_x: 2, ..info(2, 1) });
        bench.depth(millimetres(&[1000]));
        (bench.points().auto_size, bench.points().style)
    };
    let settings = DepthCloudSettings { auto_size_factor: 3.0, ..DepthCloudSettings::default() };
    assert_eq!(drawn(settings.clone()), (true, PointStyle::FlatSquares { side_m: 3.0 }));
    let settings = DepthCloudSettings { auto_size: false, ..settings };
    assert_eq!(drawn(settings), (false, PointStyle::FlatSquares { side_m: 0.01 }));
    for (focal, level) in [(2.0, Level::Ok), (0.0, Level::Warn), (-2.0, Level::Warn), (f64::NAN, Level::Warn)] {
        let mut bench = Bench::new(DepthCloudSettings::default());
        let mut info = info(2, 1);
        info.K[0] = focal;
        bench.info(info);
        bench.depth(millimetres(&[1000, 1000]));
        assert_eq!(bench.message_status().0, level, "{focal}");
    }
}

#[test]
fn colours_come_from_the_image_of_the_same_time_in_any_encoding() {
    for (encoding, pixels) in [
        ("rgb8", vec![1, 2, 3, 4, 5, 6]),
        ("bgr8", vec![3, 2, 1, 6, 5, 4]),
        ("8UC3", vec![3, 2, 1, 6, 5, 4]),
        ("rgba8", vec![1, 2, 3, 0, 4, 5, 6, 0]),
        ("bgra8", vec![3, 2, 1, 0, 6, 5, 4, 0]),
        ("rgb16", vec![9, 1, 9, 2, 9, 3, 9, 4, 9, 5, 9, 6]),
    ] {
        let mut bench = Bench::new(with_color());
        bench.info(info(2, 1));
        assert!(!bench.depth(millimetres(&[1000, 2000])), "without a partner");
        assert!(bench.color(image(encoding, [2, 1], pixels)));
        let colors = &bench.points().buffer.colors;
        assert_eq!([colors.get(0), colors.get(1)], [[1, 2, 3, 255], [4, 5, 6, 255]], "{encoding}");
    }
    let mut bench = Bench::new(with_color());
    bench.info(info(2, 1));
    bench.color(image("mono8", [2, 1], vec![7, 8]));
    bench.depth(millimetres(&[0, 2000]));
    assert_eq!(bench.points().buffer.colors.get(0), [8, 8, 8, 255]);
}

#[test]
fn images_wait_for_the_camera_info() {
    let mut bench = Bench::new(DepthCloudSettings::default());
    assert!(!bench.depth(millimetres(&[1000])) && !bench.depth(millimetres(&[2000])));
    assert!(bench.info(info(1, 1)));
    assert_eq!(bench.depths(), [2.0]);
}

#[test]
fn images_that_do_not_fit_are_errors_and_the_last_cloud_is_kept() {
    let mut bench = Bench::new(with_color());
    bench.info(info(2, 1));
    bench.color(image("mono8", [2, 1], vec![7, 8]));
    bench.depth(millimetres(&[1000, 2000]));
    let rgb = |size: [u32; 2]| image("rgb8", size, vec![0; (size[0] * size[1] * 3) as usize]);
    let short =
        Image::new(Header { frame_id: "camera".to_owned(), ..Header::default() }, [2, 1], "16UC1", 4, Arc::default());
    for (depth, color, text) in [
        (
            millimetres(&[1000]),
            rgb([2, 1]),
            "Depth image size and camera info don't match: 1 x 1 vs 2 x 1(binning: 1 x 1, ROI size: 2 x 1)",
        ),
        (millimetres(&[1, 2]), rgb([1, 1]), "Depth image resolution (2x1) does not match color image resolution (1x1)"),
        (
            image("mono8", [2, 1], vec![1, 2]),
            rgb([2, 1]),
            "Depth image has invalid format (only 16 bit and float are supported)!",
        ),
        (millimetres(&[1, 2]), image("32FC1", [2, 1], vec![0; 8]), "Color image has invalid bit depth"),
        (millimetres(&[1, 2]), image("pink", [2, 1], vec![0; 8]), "Unknown encoding pink"),
        (short, rgb([2, 1]), "Depth image has 0 bytes, too few for 2 x 1 pixels of 16UC1"),
    ] {
        bench.depth(depth);
        assert!(!bench.color(color), "{text}");
        assert_eq!(bench.message_status(), (Level::Error, format!("Error updating depth cloud: {text}").as_str()));
        assert_eq!(bench.depths(), [1.0, 2.0]);
    }
    for fault in [(0, 0.0), (5, 0.0), (0, f64::NAN), (2, f64::INFINITY), (6, f64::NAN)] {
        let mut without_rays = info(2, 1);
        without_rays.P[fault.0] = fault.1;
        bench.info(without_rays);
        bench.depth(millimetres(&[1, 2]));
        bench.color(rgb([2, 1]));
        let (level, text) = bench.message_status();
        assert!(level == Level::Error && text.contains("no pixel has a ray by the CameraInfo's P"), "{fault:?} {text}");
        assert_eq!(bench.depths(), [1.0, 2.0]);
    }
    bench.info(info(2, 1));
    let mut other = rgb([2, 1]);
    other.header.frame_id = "eye".to_owned();
    bench.depth(millimetres(&[3000, 0]));
    assert!(bench.color(other));
    let text = "Depth image frame id [camera] doesn't match color image frame id [eye]";
    assert_eq!(bench.message_status(), (Level::Warn, text));
}

#[test]
fn hidden_points_stay_darkened_until_they_are_too_old_or_the_camera_moves() {
    let settings = DepthCloudSettings { occlusion_compensation: true, occlusion_timeout_secs: 5.0, ..with_color() };
    let mut bench = Bench::new(settings);
    bench.info(info(1, 1));
    let show = |bench: &mut Bench, depth: u16| {
        bench.depth(millimetres(&[depth]));
        bench.color(image("rgb8", [1, 1], vec![200, 101, 50]));
        bench.depths()
    };
    assert_eq!(show(&mut bench, 2000), [2.0]);
    assert_eq!(show(&mut bench, 1000), [1.0, 2.0]);
    assert_eq!(bench.points().buffer.colors.get(1), [100, 50, 25, 255]);
    bench.world.now = Time::from_secs_nanos(6, 0);
    assert_eq!(show(&mut bench, 0), [2.0], "nothing is measured there, and the hidden point is five seconds old");
    bench.world.now = Time::from_secs_nanos(7, 0);
    assert_eq!(show(&mut bench, 1000), [1.0]);
    assert_eq!(show(&mut bench, 500), [0.5, 1.0]);
    bench.place(7, 0.02);
    assert_eq!(show(&mut bench, 500), [0.5]);
}

#[test]
fn transports_have_topics_of_their_own() {
    let topics = |depth_transport: &str, color_transport: &str| {
        let display = create(
            0,
            &DepthCloudSettings {
                depth_topic: "/cam/depth/image".to_owned(),
                depth_transport: depth_transport.to_owned(),
                color_transport: color_transport.to_owned(),
                ..with_color()
            },
        );
        let topics: Vec<_> = display.topics().into_iter().map(|request| (request.topic, request.kind)).collect();
        (topics, display.statuses().level())
    };
    let expected = |topics: &[(&str, MessageKind)]| -> Vec<_> {
        topics.iter().map(|(topic, kind)| ((*topic).to_owned(), *kind)).collect()
    };
    let info = ("/cam/depth/camera_info", MessageKind::CameraInfo);
    let raw = expected(&[("/cam/depth/image", MessageKind::Image), info, ("/cam/color", MessageKind::Image)]);
    assert_eq!(topics("raw", "raw"), (raw, Level::Ok));
    let packed = MessageKind::CompressedImage;
    let small = expected(&[("/cam/depth/image/compressedDepth", packed), info, ("/cam/color/compressed", packed)]);
    assert_eq!(topics("compressedDepth", "compressed"), (small, Level::Ok));
    assert_eq!(topics("theora", "raw"), (Vec::new(), Level::Error));
}

#[test]
fn a_compressed_image_that_cannot_be_read_is_an_error() {
    let settings =
        DepthCloudSettings { depth_transport: "compressedDepth".to_owned(), ..DepthCloudSettings::default() };
    let mut bench = Bench::new(settings);
    bench.info(info(1, 1));
    let damaged =
        CompressedImage { format: "16UC1; compressedDepth".to_owned(), data: vec![1; 40], ..Default::default() };
    let topic = "/cam/depth/image/compressedDepth";
    assert!(!bench.send(topic, &AnyMessage::CompressedImage(Arc::new(damaged))));
    let (level, text) = bench.message_status();
    assert!(level == Level::Error && text.starts_with("Cannot decode an image of /cam/depth/image/compressedDepth: "));
}
