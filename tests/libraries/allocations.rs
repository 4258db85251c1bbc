//! In the steady state a frame allocates nothing that grows with the scene.
//!
//! Every allocation of the process is counted while frames take the same path as in the node, except for the
//! connections to ROS: a message's bytes as a connection hands them over, the message, its display, the scene, the CPU
//! renderer, the image, the image's bytes on the wire. Each kind of scene is rendered small and large; a frame of
//! the large one may allocate no more than one of the small one, except for what a thread pool allocates now and then.
//!
//! What is left out, and why:
//!
//! - The connections, which read a message into the bytes that it keeps, and send an image's from where they are.
//! - The GPU renderer: the driver's allocations are not ours.
//! - Loading meshes and textures, and laying out text: that happens once.
//! - What a display makes of a new message, and the list of drawables of a scene in which something has changed.
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::alloc::System;
use std::sync::{Arc, Mutex};

use rcs_camera::Projection;
use rcs_camera_stream::scene::{self, SceneState};
use rcs_messages::geometry_msgs::{Quaternion, Transform, TransformStamped, Vector3};
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_messages::std_msgs::Header;
use rcs_messages::tf2_msgs::TFMessage;
use rcs_messages::visualization_msgs::{Marker, MarkerArray};
use rcs_messages::{AnyMessage, Image as ImageMessage};
use rcs_process::lock;
use rcs_render::CpuRenderer;
use rcs_resources::{MeshStore, PackageIndex};
use rcs_scene::{Drawable, Image};
use rcs_tests::big_robot;
use rcs_tests::scenes::clouds::{drawable, in_rows, STYLES};
use rcs_tests::scenes::display_pipeline::DisplayPipeline;
use rcs_tests::scenes::rendering::{camera, moving_camera, Rendering};
use rcs_tests::scenes::solids;
use rcs_transforms::Time;
use stats_alloc::{Region, StatsAlloc, INSTRUMENTED_SYSTEM};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// The allocations of all threads are counted together, so only one test runs at a time.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

/// Bytes that a frame may allocate, however small its scene is: texts of statuses, tasks of a thread pool.
const MAX_FRAME_BYTES: usize = 16 << 10;
/// Bytes that a frame of a large scene may allocate beyond those of a small one: a thread pool's queue grows in blocks.
const MAX_GROWTH_BYTES: usize = 2 << 10;

const SIZE_PX: [u32; 2] = [640, 400];
const FOCAL_PX: f64 = 950.0;
const VIEW: [f64; 2] = [0.67, 0.42];
const SMALL: usize = 10_000;
const LARGE: usize = 300_000;
/// Frames until everything that is kept has been allocated (content and cameras repeat after eight), and frames that
/// are measured then.
const WARM_UP: usize = 16;
const FRAMES: usize = 9;

/// The bytes that a frame in the middle of many allocates, given their numbers.
fn bytes_of_a_frame(mut frame: impl FnMut(usize)) -> usize {
    (0..WARM_UP).for_each(&mut frame);
    let mut all: Vec<usize> = (WARM_UP..WARM_UP + FRAMES)
        .map(|number| {
            let region = Region::new(ALLOCATOR);
            frame(number);
            region.change().bytes_allocated
        })
        .collect();
    all.sort_unstable();
    all[FRAMES / 2]
}

/// Fails if the bytes of a frame grow with the scene, or are too many in a small one.
fn assert_steady(name: &str, of: impl Fn(usize) -> usize, [small, large]: [usize; 2]) {
    let [of_small, of_large] = [of(small), of(large)];
    println!("{name}: {of_small} bytes a frame for {small}, {of_large} for {large}");
    assert!(of_small <= MAX_FRAME_BYTES, "{name}: {of_small} bytes a frame for {small}");
    assert!(of_large <= of_small + MAX_GROWTH_BYTES, "{name}: {of_small} bytes for {small}, {of_large} for {large}");
}

fn rendering(drawables: Vec<Drawable>) -> Rendering {
    Rendering::new(drawables, camera(SIZE_PX, FOCAL_PX).unwrap(), Box::new(CpuRenderer::with_threads(2)))
}

/// Draws a scene again and again, if `is_moving` each time from another place.
fn bytes_of_drawing(drawables: Vec<Drawable>, is_moving: bool) -> usize {
    let mut rendering = rendering(drawables);
    let bytes = bytes_of_a_frame(|frame| {
        if is_moving {
            rendering.camera = moving_camera(SIZE_PX, FOCAL_PX, frame).unwrap();
        }
        rendering.draw().unwrap();
    });
    assert!(rendering.covered() > 1e-4, "the picture is not empty");
    bytes
}

#[test]
fn an_unchanged_cloud_in_any_style_allocates_nothing_per_point() {
    let _guard = lock(&ONE_AT_A_TIME);
    for (name, style) in STYLES {
        for is_moving in [false, true] {
            let of = |count| bytes_of_drawing(vec![drawable(in_rows(count), style)], is_moving);
            assert_steady(&format!("{name}, moving: {is_moving}"), of, [SMALL, LARGE]);
        }
    }
}

#[test]
fn a_moving_camera_allocates_nothing_per_triangle_line_or_label() {
    let _guard = lock(&ONE_AT_A_TIME);
    let one = |geometry| bytes_of_drawing(vec![solids::drawable(geometry)], true);
    assert_steady("triangles", |count| one(solids::triangles(count, 4.0, FOCAL_PX, VIEW)), [SMALL, LARGE]);
    assert_steady("lines", |count| one(solids::lines(count, 10.0, FOCAL_PX, VIEW)), [SMALL, LARGE]);
    assert_steady("ribbons", |count| one(solids::ribbons(count, VIEW)), [1000, 30_000]);
    assert_steady("labels", |count| bytes_of_drawing(solids::labels(count, VIEW), true), [10, 1000]);
    assert_steady("boxes", |count| bytes_of_drawing(solids::boxes(count, VIEW), true), [10, 3000]);
}

#[test]
fn unchanged_markers_allocate_nothing_per_marker() {
    let _guard = lock(&ONE_AT_A_TIME);
    let display = "  - {Class: rviz/MarkerArray, Name: m, Enabled: true, Marker Topic: /m}\n";
    let of = |count: usize| {
        let marker = |id: usize| {
            let mut marker = Marker { id: id as i32, type_: i32::from(Marker::CUBE), ..Marker::default() };
            marker.header.frame_id = "map".to_owned();
            (marker.scale.x, marker.scale.y, marker.scale.z, marker.color.a) = (0.01, 0.01, 0.01, 1.0);
            (marker.color.r, marker.pose.orientation.w) = (1.0, 1.0);
            let position = &mut marker.pose.position;
            (position.x, position.y, position.z) = (id as f64 * 1e-4 - 0.1, 0.0, 1.5);
            marker
        };
        let message = AnyMessage::MarkerArray(Arc::new(MarkerArray { markers: (0..count).map(marker).collect() }));
        let mut pipeline = DisplayPipeline::new(display);
        pipeline.receive("/m", &message);
        let mut rendering = rendering(Vec::new());
        let bytes = bytes_of_a_frame(|_| {
            let scene = pipeline.advance();
            rendering.draw_of(scene).unwrap();
        });
        assert!(rendering.covered() > 1e-4);
        bytes
    };
    assert_steady("markers", of, [10, 2000]);
}

/// 250,000 triangles in 25 links, seen from a frame that moves.
#[test]
fn a_still_robot_before_a_moving_camera_allocates_nothing_per_triangle() {
    const CONFIG: &str = "
Visualization Manager:
  Global Options: {Fixed Frame: base}
  Displays:
  - {Class: rviz/RobotModel, Name: robot, Enabled: true, Robot Description: robot_description}
  - {Class: rviz_camera_stream/CameraPub, Name: eye, Enabled: true, Image Topic: /image, Camera Info Topic: /info}
";
    let _guard = lock(&ONE_AT_A_TIME);
    let folder = tempfile::tempdir().unwrap();
    let joints = big_robot::write(folder.path()).unwrap();
    let description = std::fs::read_to_string(folder.path().join("big_robot/robot.urdf")).unwrap();
    let config = rcs_rviz_config::parse(CONFIG, "robot").unwrap();
    let mut stage = SceneState::new(&config, None, MeshStore::new(PackageIndex::new([folder.path().to_owned()])));
    stage.take_parameter("robot_description", Some(&description.as_str().into()), Time::ZERO);
    let mut info = CameraInfo { width: SIZE_PX[0], height: SIZE_PX[1], ..CameraInfo::default() };
    info.header.frame_id = "eye".to_owned();
    info.P = [500.0, 0.0, 320.0, 0.0, 0.0, 500.0, 200.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    stage.take("/info", &AnyMessage::CameraInfo(info.into()), Time::ZERO);
    let placed = |parent: &str, child: &str, [x, y, z]: [f64; 3], [qx, qy, qz, qw]: [f64; 4], frame: usize| {
        let stamp = rcs_messages::Time { sec: 100 + frame as u32, nsec: 0 };
        let translation = Vector3 { x, y, z };
        let transform = Transform { translation, rotation: Quaternion { x: qx, y: qy, z: qz, w: qw } };
        let header = Header { stamp, frame_id: parent.to_owned(), ..Header::default() };
        TransformStamped { header, child_frame_id: child.to_owned(), transform }
    };
    let links = joints.iter().map(|joint| placed(&joint.parent, &joint.child, joint.origin_m, [0.0, 0.0, 0.0, 1.0], 0));
    stage.take_transforms(&TFMessage { transforms: links.collect() }, true, "test");
    let camera = stage.cameras()[0].clone();
    let mut rendering = rendering(Vec::new());
    let bytes = bytes_of_a_frame(|frame| {
        // Before the robot, at half its height, looking at it.
        let place = [1.8 + 0.01 * (frame % 8) as f64, 0.0, 0.6];
        let eye = placed("base", "eye", place, [-0.5, -0.5, 0.5, 0.5], frame);
        stage.take_transforms(&TFMessage { transforms: vec![eye] }, false, "test");
        if stage.update(Time::from_secs_nanos(100 + frame as u32, 0)) {
            rendering.scene = stage.scene();
        }
        rendering.camera = scene::camera(&stage, &camera, Projection::Rviz).unwrap();
        rendering.draw().unwrap();
    });
    assert!(rendering.covered() > 0.05, "{}", rendering.covered());
    println!("robot: {bytes} bytes a frame");
    assert!(bytes <= MAX_FRAME_BYTES, "{bytes} bytes a frame");
}

#[test]
fn an_encoded_image_is_copied_only_once() {
    let _guard = lock(&ONE_AT_A_TIME);
    let mut rendering = rendering(vec![drawable(in_rows(SMALL), STYLES[0].1)]);
    rendering.draw().unwrap();
    let Image { width_px, height_px, encoding, .. } = rendering.image;
    let step_bytes = rendering.image.step() as u32;
    let pixels = Arc::new(std::mem::take(&mut rendering.image.data));
    let bytes = bytes_of_a_frame(|_| {
        let size_px = [width_px, height_px];
        let image = ImageMessage::new(Header::default(), size_px, encoding.name(), step_bytes, Arc::clone(&pixels));
        let (beginning, rest) = image.parts();
        assert!(!beginning.is_empty() && (*rest).as_ref().len() == pixels.len());
    });
    assert!(bytes < pixels.len() + 1024, "{bytes} bytes for a picture of {}", pixels.len());
}
