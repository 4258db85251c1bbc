//! Camera and projector, live on ROS topics: the projector shows what arrives on a topic or what a monitor shows, the
//! camera publishes what it sees of that, with depth.

use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use rcs_calibration::Lens;
use rcs_files::projector::ProjectorFile;
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_messages::std_msgs::Header;
use rcs_messages::{AnyMessage, Image, MessageKind};
use rcs_node_support::lifecycle::{self, EndRequest};
use rcs_ros::{NodeEvent, Publisher, RosNode, ServiceCall};
use rcs_scan_simulator::{Conditions, DepthCamera, Rig, Scan, View};
use rcs_window::ScreenGrabber;

/// Topic of the image that the projector shows.
const SHOWN: &str = "/projector/patterns";
/// Time from image to image.
const PERIOD: Duration = Duration::from_millis(100);
/// Depth images that differ in their noise.
const DEPTHS: u64 = 8;

/// Camera and projector with a quarter of the pixels.
pub(crate) fn small(rig: &Rig) -> Rig {
    let halved = |lens: &Lens| {
        let center_px = lens.center_px.map(|at| 0.5 * (at + 0.5) - 0.5);
        Lens { size_px: lens.size_px.map(|side| side / 2), focal_px: 0.5 * lens.focal_px, center_px, ..*lens }
    };
    Rig { camera: halved(&rig.camera), projector: halved(&rig.projector), ..rig.clone() }
}

/// Images of a simulated camera of one scene, and their depths.
struct Seen<'a> {
    scan: Scan<'a>,
    depths: Vec<Vec<f32>>,
}

impl<'a> Seen<'a> {
    fn new(view: &'a View, seed: u64) -> Self {
        let depth = |seed| DepthCamera::kinect(seed).capture(view);
        Self {
            scan: Scan::new(view, Conditions { interreflection: 0.0, ..Conditions::random(seed) }),
            depths: (seed..seed + DEPTHS).map(depth).collect(),
        }
    }
}

/// The optical frame of a camera.
pub(crate) fn camera_frame(camera: &str) -> String {
    format!("{camera}_rgb_optical_frame")
}

/// Runs camera and projector until a signal comes or ROS asks it to end. The camera sees the first view, and the next
/// one after each call of the service `~next_view`.
pub(crate) fn run(views: &[View], seed: u64, camera: &str, screen: Option<&str>) -> Result<()> {
    let screen = screen.map(ScreenGrabber::open).transpose()?;
    lifecycle::with_node("simulated_robot", |node, end| simulate(node, end, views, seed, camera, screen.as_ref()))
}

fn simulate(
    node: &RosNode,
    end: &EndRequest,
    views: &[View],
    seed: u64,
    camera: &str,
    screen: Option<&ScreenGrabber>,
) -> Result<()> {
    let shown = screen.is_none().then(|| node.subscribe(SHOWN, MessageKind::Image, 1)).transpose()?;
    let seen: Vec<Seen<'_>> = views.iter().map(|view| Seen::new(view, seed)).collect();
    let rig = views.first().context("no view")?.rig();
    let camera = DepthCameraTopics::new(node, rig.camera, camera)?;
    node.serve_trigger("~next_view")?;
    let (size_px, mut index) = (rig.projector.size_px, 0);
    let mut levels = vec![0; size_px[0] as usize * size_px[1] as usize];
    let mut light = seen[index].scan.light_of(&levels);
    let mut due = Instant::now();
    for frame in 0.. {
        due += PERIOD;
        let mut new = screen.map(|screen| screen.grey(size_px)).transpose()?;
        while !end.is_requested() && Instant::now() < due {
            for event in node.events().wait(due.saturating_duration_since(Instant::now())) {
                match (event, &shown) {
                    (NodeEvent::Message { topic, message: AnyMessage::Image(image), .. }, Some(shown))
                        if topic == *shown.topic() =>
                    {
                        new = Some(pixels_of(&image, size_px)?.to_vec());
                    }
                    _ => {}
                }
            }
        }
        if end.is_requested() {
            break;
        }
        let has_moved = next_view(node);
        if has_moved {
            index = (index + 1) % seen.len();
        }
        let new = new.filter(|new| *new != levels);
        if has_moved || new.is_some() {
            levels = new.unwrap_or(levels);
            light = seen[index].scan.light_of(&levels);
        }
        let Seen { scan, depths } = &seen[index];
        camera.send(scan.expose(&light, frame), &depths[frame as usize % depths.len()])?;
    }
    Ok(())
}

/// `true` if the service was called.
fn next_view(node: &RosNode) -> bool {
    let mut is_called = false;
    for call in node.calls().wait(Duration::ZERO) {
        if let ServiceCall::Trigger { reply, .. } = call {
            is_called = true;
            reply.send(true, "moved");
        }
    }
    is_called
}

/// The levels of an image for the projector.
fn pixels_of(image: &Image, size_px: [u32; 2]) -> Result<&[u8]> {
    let is_fitting = [image.width, image.height] == size_px && image.encoding == "mono8" && image.step == size_px[0];
    anyhow::ensure!(is_fitting, "{SHOWN}: the projector needs {}x{} pixels in mono8", size_px[0], size_px[1]);
    Ok(image.data())
}

/// The topics of an RGB-D camera, with the names that OpenNI's drivers give.
struct DepthCameraTopics {
    lens: Lens,
    frame: String,
    image: Publisher<Image>,
    depth: Publisher<Image>,
    info: Publisher<CameraInfo>,
}

impl DepthCameraTopics {
    fn new(node: &RosNode, lens: Lens, camera: &str) -> Result<Self> {
        Ok(Self {
            lens,
            frame: camera_frame(camera),
            image: node.latched_publisher(&format!("/{camera}/rgb/image_raw"), 1)?,
            depth: node.latched_publisher(&format!("/{camera}/depth_registered/image_raw"), 1)?,
            info: node.latched_publisher(&format!("/{camera}/rgb/camera_info"), 1)?,
        })
    }

    /// Sends an image, a depth image in metres, and the lens.
    fn send(&self, grey: Vec<u8>, depth_m: &[f32]) -> Result<()> {
        let size_px = self.lens.size_px;
        let stamp = rcs_ros::node_time().map(|time| time.stamp).unwrap_or_default();
        let header = || Header { seq: 0, stamp, frame_id: self.frame.clone() };
        let millimetres = depth_m.iter().flat_map(|depth| ((depth * 1000.0).round() as u16).to_le_bytes()).collect();
        self.depth.send(Image::new(header(), size_px, "16UC1", 2 * size_px[0], Arc::new(millimetres)))?;
        self.image.send(Image::new(header(), size_px, "mono8", size_px[0], Arc::new(grey)))?;
        let info = ProjectorFile::from_lens(&self.lens, &self.frame).camera_info;
        self.info.send(CameraInfo { header: header(), ..info })?;
        Ok(())
    }
}
