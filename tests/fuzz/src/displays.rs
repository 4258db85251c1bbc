//! Displays that are sent foreign messages: from the bytes to the image, as in the node.
//!
//! An input of these targets chooses one of several configs, each with a display, by its first byte; the second says
//! what else happens. The rest are messages (see [`Record`]) on the topics to which the display subscribes.

use std::cell::RefCell;
use std::sync::{Arc, OnceLock};

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use rcs_camera::Projection;
use rcs_camera_stream::scene::{self, SceneState};
use rcs_messages::sensor_msgs::{CameraInfo, CompressedImage};
use rcs_messages::tf2_msgs::TFMessage;
use rcs_messages::{AnyMessage, MessageKind};
use rcs_render::{CpuRenderer, Renderer, View};
use rcs_resources::{MeshStore, PackageIndex};
use rcs_rviz_config::Config;
use rcs_scene::{Camera, DisplayMask, Encoding, Image, Intrinsics};
use rcs_transforms::Time;

use crate::first_byte;
use crate::resources::{is_large, is_large_image};
use crate::stream::Record;

/// The one of the golden cases, so that their messages are shown.
pub(crate) const FIXED_FRAME: &str = "base_link";

/// What `compressedDepth` has before the image, bytes.
const DEPTH_HEADER_LEN: usize = 12;

/// The displays of each target, one in each config.
const CONFIGS: [(&str, &[&str]); 7] = [
    (
        "clouds",
        &[
            "Class: rviz/PointCloud2, Style: Points, Color Transformer: RGB8, Size (Pixels): 3",
            "Class: rviz/PointCloud2, Style: Flat Squares, Color Transformer: Intensity, Decay Time: 1, Size (m): 0.1",
            "Class: rviz/PointCloud2, Style: Spheres, Color Transformer: AxisColor, Alpha: 0.5, Size (m): 0.1",
            "Class: rviz/PointCloud2, Style: Boxes, Color Transformer: MONO8, Selectable: false, Size (m): 0.1",
            "Class: rviz/PointCloud2, Style: Squares, Color Transformer: RGBF32, Size (m): 0.1",
            "Class: rviz/PointCloud, Color Transformer: Intensity, Use rainbow: false, Size (m): 0.1",
            "Class: rviz/LaserScan, Color Transformer: Intensity, Channel Name: intensity, Size (m): 0.1",
            "Class: rviz/LaserScan, Color Transformer: AxisColor, Position Transformer: XYZ, Style: Boxes, Decay Time: 5",
            "Class: rviz/FluidPressure",
            "Class: rviz/Illuminance",
            "Class: rviz/RelativeHumidity",
            "Class: rviz/Temperature",
        ],
    ),
    (
        "markers",
        &[
            "Class: rviz/Marker, Marker Topic: /topic",
            "Class: rviz/MarkerArray, Marker Topic: /topic",
            "Class: rviz/MarkerArray, Marker Topic: /topic, Namespaces: {a: false}",
        ],
    ),
    (
        "interactive",
        &[
            "Class: rviz/InteractiveMarkers, Update Topic: /server/update",
            "Class: rviz/InteractiveMarkers, Update Topic: /server/update, Show Axes: true, Show Descriptions: false",
        ],
    ),
    (
        "maps",
        &[
            "Class: rviz/Map, Alpha: 0.7",
            "Class: rviz/Map, Color Scheme: costmap, Draw Behind: true",
            "Class: rviz/Map, Color Scheme: raw, Alpha: 1, Use Timestamp: true",
            "Class: rviz/GridCells",
        ],
    ),
    (
        "poses",
        &[
            "Class: rviz/Path",
            "Class: rviz/Path, Line Style: Billboards, Pose Style: Axes, Buffer Length: 3",
            "Class: rviz/Path, Pose Style: Arrows",
            "Class: rviz/Pose",
            "Class: rviz/Pose, Shape: Axes",
            "Class: rviz/PoseArray",
            "Class: rviz/PoseArray, Shape: Arrow (3D)",
            "Class: rviz/PoseArray, Shape: Axes",
            "Class: rviz/PoseWithCovariance, Covariance: {Value: true, Position: {Value: true}, Orientation: {Value: true}}",
            "Class: rviz/PoseWithCovariance, Shape: Axes, \
             Covariance: {Value: true, Orientation: {Value: true, Frame: Fixed, Color Style: RGB}}",
            "Class: rviz/Odometry, Keep: 3, Position Tolerance: 0, Angle Tolerance: 0",
            "Class: rviz/Odometry, Shape: {Value: Axes}, Covariance: {Value: true}",
            "Class: rviz/PointStamped, History Length: 3",
            "Class: rviz/Polygon",
            "Class: rviz/Range, Buffer Length: 3",
            "Class: rviz/WrenchStamped, History Length: 3",
            "Class: rviz/TwistStamped",
            "Class: rviz/AccelStamped",
            "Class: rviz/Effort",
        ],
    ),
    (
        "depth",
        &[
            "Class: rviz/DepthCloud, Depth Map Topic: /d/image, Color Image Topic: /c/image, Color Transformer: RGB8",
            "Class: rviz/DepthCloud, Depth Map Topic: /d/image, Occlusion Compensation: {Value: true}",
            "Class: rviz/DepthCloud, Depth Map Topic: /d/image, Color Image Topic: /c/image, Color Transformer: RGB8, \
             Depth Map Transport Hint: compressedDepth, Color Transport Hint: compressed",
        ],
    ),
    (
        "frames",
        &[
            "Class: rviz/TF, Frame Timeout: 5, Marker Scale: 1",
            "Class: rviz/TF, Show Names: false, Frames: {All Enabled: false, a: {Value: true}}",
            "Class: rviz/Axes, Reference Frame: a",
        ],
    ),
];

/// The topics of each display of a target, as the records of an input number them: first those of the display, then
/// that of the camera's CameraInfo. The next numbers are static transforms, other transforms, and other events.
pub fn display_topics(name: &str) -> Vec<Vec<(String, MessageKind)>> {
    let topics = |config: &Config| -> Vec<_> {
        Shown::new(config).stage.topics().into_iter().map(|request| (request.topic, request.kind)).collect()
    };
    configs(name).iter().map(topics).collect()
}

/// A config with a display, and a camera that looks at it.
pub(crate) fn config(display: &str) -> Config {
    let text = format!(
        "Visualization Manager:\n  Global Options: {{Fixed Frame: {FIXED_FRAME}}}\n  Displays:\n  - {display}\n  \
         - {{Class: rviz_camera_stream/CameraPub, Name: eye, Enabled: true, Image Topic: /image, Camera Info Topic: /info}}\n"
    );
    rcs_rviz_config::parse(&text, "fuzz.rviz").unwrap_or_else(|error| panic!("{error} in\n{text}"))
}

/// All configs of a target, read once.
fn configs(name: &str) -> &'static [Config] {
    static ALL: OnceLock<Vec<(&str, Vec<Config>)>> = OnceLock::new();
    let read = |display: &&str| {
        let topic = if display.contains("Topic:") { "" } else { "Topic: /topic, " };
        config(&format!("{{Name: d, Enabled: true, {topic}{display}}}"))
    };
    let all = ALL.get_or_init(|| {
        CONFIGS.iter().map(|(target, displays)| (*target, displays.iter().map(read).collect())).collect()
    });
    all.iter().find(|(target, _)| *target == name).map_or(&[], |(_, configs)| configs)
}

/// The renderer, and its last image.
struct Screen {
    renderer: CpuRenderer,
    image: Image,
}

thread_local! {
    static SCREEN: RefCell<Screen> =
        RefCell::new(Screen { renderer: CpuRenderer::with_threads(1), image: Image::default() });
}

/// A stage and the time on it.
pub(crate) struct Shown {
    stage: SceneState,
    now_nanos: i64,
}

impl Shown {
    pub(crate) fn new(config: &Config) -> Self {
        let meshes = MeshStore::new(PackageIndex::new([]));
        Self { stage: SceneState::new(config, None, meshes), now_nanos: 100_000_000_000 }
    }

    fn now(&self) -> Time {
        Time::from_nanos(self.now_nanos)
    }

    pub(crate) fn take(&mut self, topic: &str, message: &AnyMessage) {
        self.stage.take(topic, message, self.now());
    }

    pub(crate) fn take_transforms(&mut self, message: &TFMessage, is_static: bool) {
        self.stage.take_transforms(message, is_static, "/fuzz");
    }

    pub(crate) fn take_parameter(&mut self, name: &str, text: &Arc<str>) {
        self.stage.take_parameter(name, Some(text), self.now());
    }

    pub(crate) fn reconfigure(&mut self, config: &Config) -> rcs_displays::Reconfigured {
        self.stage.reconfigure(config, None, self.now())
    }

    /// Brings the scene up to date, a thirtieth of a second later.
    pub(crate) fn advance(&mut self) {
        self.now_nanos += 33_333_333;
        self.stage.update(self.now());
    }

    /// What is neither a message nor a transform.
    fn happen(&mut self, what: u8, config: &Config) {
        match what {
            0 => self.stage.reset(),
            1 => self.stage.publisher_left("/topic"),
            2 => self.now_nanos += 10_000_000_000,
            3 => self.now_nanos -= 10_000_000_000,
            _ => drop(self.reconfigure(config)),
        }
    }

    /// Draws one input out of four, whichever its bytes say: drawing takes most of the time of most inputs.
    pub(crate) fn draw_some(&self, data: &[u8]) {
        if data.iter().fold(0, |sum: u8, byte| sum.wrapping_add(*byte)) & 3 == 0 {
            self.draw();
        }
    }

    /// Draws a small image, and asks what each display reports: the node does this twice a second.
    fn draw(&self) {
        let scene = self.stage.scene();
        let p = [8.0, 0.0, 8.0, 0.0, 0.0, 8.0, 8.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        let intrinsics = Intrinsics::from_p(16, 16, &p).unwrap_or_else(|error| panic!("{error}"));
        // Before the origin and above it, so that it sees what is upright and what lies flat.
        let ahead = UnitQuaternion::from_quaternion(Quaternion::new(0.5, -0.5, 0.5, -0.5));
        let pose = Isometry3::from_parts(
            Translation3::new(-2.0, 0.3, 1.5),
            UnitQuaternion::from_euler_angles(0.0, 0.6, 0.0) * ahead,
        );
        let camera = Camera::new(intrinsics, &pose, 0.01);
        draw(&scene, &camera);
        for report in self.stage.reports() {
            let _ = self.stage.in_view(report.id, &camera);
            for (_, status) in report.statuses.iter() {
                assert!(!status.one_line().contains('\n'));
            }
        }
        // A camera of the messages, if it is small.
        for view in self.stage.cameras() {
            for projection in [Projection::Rviz, Projection::Exact] {
                match scene::camera(&self.stage, view, projection) {
                    Ok(camera) if camera.width_px().max(camera.height_px()) <= 64 => draw(&scene, &camera),
                    Ok(_) => {}
                    Err(problem) => assert!(!problem.to_string().is_empty()),
                }
            }
        }
    }
}

fn draw(scene: &rcs_scene::Scene, camera: &Camera) {
    let visible = DisplayMask::all();
    let view = View { scene, camera, visible: &visible, background: [48; 3], encoding: Encoding::Rgb8 };
    SCREEN.with_borrow_mut(|Screen { renderer, image }| {
        renderer.render(&view, image).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(image.data.len(), camera.width_px() as usize * camera.height_px() as usize * 3);
    });
}

/// Shows a stream of messages.
pub(crate) fn show(target: &str, data: &[u8]) {
    let configs = configs(target);
    let (choice, data) = first_byte(data);
    let (flags, data) = first_byte(data);
    let Some(config) = configs.get(usize::from(choice) % configs.len().max(1)) else { return };
    let mut shown = Shown::new(config);
    if flags & 2 != 0 {
        // As the node does it, if with more.
        shown.stage.limit_markers_per_update(2);
    }
    let topics = shown.stage.topics();
    for record in Record::read_all(data) {
        match topics.get(usize::from(record.topic) % (topics.len() + 3)) {
            Some(request) => {
                if let Ok(message) = request.kind.decode(record.bytes) {
                    shown.take(&request.topic, &message);
                }
            }
            None if usize::from(record.topic) % (topics.len() + 3) == topics.len() + 2 => {
                shown.happen(first_byte(record.bytes).0, config);
            }
            None => {
                let is_static = usize::from(record.topic) % (topics.len() + 3) == topics.len();
                if let Ok(AnyMessage::TFMessage(message)) = MessageKind::TFMessage.decode(record.bytes) {
                    shown.take_transforms(&message, is_static);
                }
            }
        }
        if flags & 1 == 0 {
            shown.advance();
        }
    }
    shown.advance();
    shown.draw_some(data);
}

/// Whether an RVL image [is large](is_large): thirty bytes can be.
fn is_large_rvl(data: &[u8]) -> bool {
    let side = |at: usize| data.get(at..at + 4).and_then(|bytes| Some(u32::from_le_bytes(bytes.try_into().ok()?)));
    side(0).zip(side(4)).is_some_and(is_large)
}

/// An image of the transports `compressed` and `compressedDepth`: the first byte chooses the format.
pub(crate) fn compressed_image(data: &[u8]) {
    const FORMATS: [(&str, &str); 8] = [
        ("/d/image/compressedDepth", "16UC1; compressedDepth png"),
        ("/d/image/compressedDepth", "32FC1; compressedDepth png"),
        ("/d/image/compressedDepth", "16UC1; compressedDepth rvl"),
        ("/d/image/compressedDepth", "32FC1; compressedDepth rvl"),
        ("/c/image/compressed", "rgb8; jpeg compressed bgr8"),
        ("/c/image/compressed", "bgr8; png compressed bgr8"),
        ("/c/image/compressed", "mono16; png compressed "),
        ("/c/image/compressed", "jpeg"),
    ];
    let configs = configs("depth");
    let Some(config) = configs.last() else { return };
    let (choice, data) = first_byte(data);
    let (topic, format) = FORMATS[usize::from(choice) % FORMATS.len()];
    let header_len = if topic.starts_with("/d") { DEPTH_HEADER_LEN } else { 0 };
    let packed = data.get(header_len..).unwrap_or_default();
    let is_large = if format.ends_with("rvl") { is_large_rvl(packed) } else { is_large_image(packed, None) };
    if is_large {
        return;
    }
    let mut shown = Shown::new(config);
    // An image of 4 × 4 on the other topic, so that there is a pair.
    let mut info = CameraInfo { width: 4, height: 4, ..CameraInfo::default() };
    info.header.frame_id = FIXED_FRAME.to_owned();
    info.P = [4.0, 0.0, 2.0, 0.0, 0.0, 4.0, 2.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    info.K = [4.0, 0.0, 2.0, 0.0, 4.0, 2.0, 0.0, 0.0, 1.0];
    let image = |format: &str, data: &[u8]| {
        let mut image =
            CompressedImage { format: format.to_owned(), data: data.to_vec(), ..CompressedImage::default() };
        image.header.frame_id = FIXED_FRAME.to_owned();
        AnyMessage::CompressedImage(image.into())
    };
    if topic.starts_with("/c") {
        let rvl = [vec![0; 12], vec![4, 0, 0, 0, 4, 0, 0, 0], vec![0x11; 16]].concat();
        shown.take("/d/image/compressedDepth", &image("16UC1; compressedDepth rvl", &rvl));
    }
    shown.take("/d/camera_info", &AnyMessage::CameraInfo(info.into()));
    shown.take(topic, &image(format, data));
    shown.advance();
    shown.draw_some(data);
}
