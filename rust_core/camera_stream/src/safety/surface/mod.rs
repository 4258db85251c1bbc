//! Confirmed light: whether the surface that a depth camera measures is where the scene's light is meant to fall.
//!
//! Each camera (projector) with a `~surface` has a [`Confirmer`]. A depth image waits for the transforms of its own
//! stamp, becomes points, and is given to the confirmer as the projector sees it. The frame that is shown is compared
//! with it ([`SurfaceCheck`]), when it is drawn and when the next depth image arrives.
//!
//! A missing, invalid or stale surface makes the camera dark. Without a limit of its own, a depth image is stale after
//! [`SURFACE_LIMIT`]. Latching does not keep it current: it is a measurement.

mod grid;
mod topics;

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use rcs_confirm::{ConfirmSettings, Confirmation, Confirmer, ObjectDepths};
use rcs_displays::time_from_stamp;
use rcs_light::{Condition, Measured, Now};
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_messages::{header, AnyMessage};
use rcs_process::lock;
use rcs_scene::{Camera, DepthImage, DisplayMask};
use rcs_transforms::WaitingQueue;

use self::grid::GridDecoder;
use self::topics::info_topic;
pub(crate) use self::topics::SurfaceTopics;
use super::ages::limits::AgeLimits;
use super::confirmed_displays::ConfirmedDisplays;
use super::names::{of_camera, ConfigNames, ForCamera};
use super::LitView;
use crate::scene::SceneState;

/// Age at which a depth image is stale, where its topic has no limit of its own.
const SURFACE_LIMIT: Duration = Duration::from_millis(500);
/// Depth images that may wait for transforms.
const QUEUE_SIZE: usize = 5;

/// The rules of confirmed light.
#[derive(Clone, Debug)]
pub(crate) struct ConfirmRules {
    /// The topics of depth cameras, by whole names.
    pub(crate) surfaces: Vec<ForCamera<String>>,
    pub(crate) displays: ConfirmedDisplays,
    pub(crate) settings: ConfirmSettings,
}

/// The measured surface that a camera's light is checked against.
#[derive(Clone, Debug)]
pub(crate) struct SurfaceCheck {
    confirmer: Arc<Mutex<Confirmer>>,
    /// Counts the depth images.
    pub(crate) version: u64,
    /// Displays whose light must be confirmed.
    pub(crate) displays: DisplayMask,
    /// `true` if light without a depth to compare is dark.
    is_strict: bool,
}

impl SurfaceCheck {
    /// Compares an image with the surface. The image is given by the depths of what the listed displays light.
    pub(crate) fn confirm(&self, objects: &DepthImage) -> Confirmation {
        let size_px = [objects.width_px, objects.height_px];
        let objects = ObjectDepths { size_px, depths_m: &objects.depths_m, is_strict: self.is_strict };
        lock(&self.confirmer).confirm(&objects)
    }
}

/// The surfaces of all cameras.
#[derive(Debug)]
pub(super) struct Surfaces {
    rules: ConfirmRules,
    /// By the topic's whole name.
    inputs: BTreeMap<String, SurfaceInput>,
    /// By the camera's name.
    cameras: BTreeMap<String, CameraSurface>,
    limits: AgeLimits,
    /// Beginning of the confirmers' time.
    started: Instant,
}

/// The last messages of a depth camera.
#[derive(Debug, Default)]
struct SurfaceInput {
    last: Option<AnyMessage>,
    info: Option<Arc<CameraInfo>>,
}

/// A depth image and its arrival.
type Received = (AnyMessage, Instant);

/// The surface as a camera sees it.
#[derive(Debug)]
struct CameraSurface {
    topic: String,
    waiting: WaitingQueue<Received>,
    decoder: GridDecoder,
    confirmer: Arc<Mutex<Confirmer>>,
    version: u64,
    /// The depth image that the confirmer has, and the transform that placed it.
    placed: Option<[Measured; 2]>,
    /// Why there is none.
    problem: Option<String>,
}

impl Surfaces {
    pub(super) fn new(rules: ConfirmRules, limits: AgeLimits) -> Self {
        let inputs = rules.surfaces.iter().map(|surface| (surface.value.clone(), SurfaceInput::default())).collect();
        Self { rules, inputs, cameras: BTreeMap::new(), limits, started: Instant::now() }
    }

    pub(super) fn is_some(&self) -> bool {
        !self.inputs.is_empty()
    }

    /// `true` if the light of a camera must be confirmed.
    pub(super) fn has(&self, camera: &str) -> bool {
        of_camera(&self.rules.surfaces, camera).is_some()
    }

    /// The listed displays that a config does not have.
    pub(super) fn unmatched(&self, names: &ConfigNames) -> Option<String> {
        self.rules.displays.unmatched(names).filter(|_| self.is_some())
    }

    /// Forgets all depth images: the time jumped back.
    pub(super) fn reset(&mut self) {
        self.cameras.clear();
    }

    /// Takes a message, if its topic is a depth camera's. Returns `true` for one that was taken before: a topic that a
    /// display shows as well comes to both.
    pub(super) fn take(&mut self, topic: &str, message: &AnyMessage, received: Instant) -> bool {
        if let AnyMessage::CameraInfo(info) = message {
            for (_, input) in self.inputs.iter_mut().filter(|(of, _)| info_topic(of) == topic) {
                input.info = Some(Arc::clone(info));
            }
            return false;
        }
        let Some(input) = self.inputs.get_mut(topic) else { return false };
        if input.last.as_ref().is_some_and(|last| is_same(last, message)) {
            return true;
        }
        input.last = Some(message.clone());
        if let Some(header) = header(message) {
            for camera in self.cameras.values_mut().filter(|camera| camera.topic == topic) {
                let (stamp, entry) = (time_from_stamp(header.stamp), (message.clone(), received));
                camera.waiting.push(&header.frame_id, stamp, entry);
            }
        }
        false
    }

    /// Gives a camera's confirmer the newest depth image whose place is known.
    pub(super) fn observe(&mut self, lit: &LitView<'_>, scene: &SceneState) {
        let Some(topic) = of_camera(&self.rules.surfaces, &lit.view.name) else { return };
        let max_gap = self.limits.of_measurement(topic, SURFACE_LIMIT);
        let new = || CameraSurface::new(topic, ConfirmSettings { max_gap, ..self.rules.settings });
        let surface = self.cameras.entry(lit.view.name.clone()).or_insert_with(new);
        if !lit.is_watched {
            surface.waiting.clear();
            return;
        }
        let (Some(info), Some(camera)) = (scene.camera_info(lit.view), lit.camera) else { return };
        let of_sensor = self.inputs.get(topic).and_then(|input| input.info.as_ref());
        surface.observe(camera, scene, &info.header.frame_id, of_sensor, self.started);
    }

    /// Whether a camera's surface is there and current.
    pub(super) fn condition(&mut self, lit: &LitView<'_>, now: Now) -> Condition {
        let camera = lit.view.name.as_str();
        let Some(topic) = of_camera(&self.rules.surfaces, camera) else { return Condition::Always };
        if let Some(why) = &lit.unknown_lens {
            return Condition::Dark(format!("where the lens sends light is not known: {why}"));
        }
        let Some(surface) = self.cameras.get_mut(camera) else {
            return Condition::Dark(format!("no surface on {topic} yet"));
        };
        let condition = match lit.is_watched {
            true => surface.condition(self.limits.of_measurement(topic, SURFACE_LIMIT), now),
            // Nothing is received.
            false => Condition::Dark("nobody watches".to_owned()),
        };
        if matches!(condition, Condition::Dark(_)) && surface.placed.take().is_some() {
            lock(&surface.confirmer).forget();
        }
        condition
    }

    /// Surface that a camera's frames are checked against; `None` if nothing has to be confirmed.
    pub(super) fn check(&self, camera: &str, displays: &SceneState) -> Option<SurfaceCheck> {
        let surface = self.cameras.get(camera).filter(|_| self.has(camera))?;
        Some(SurfaceCheck {
            confirmer: Arc::clone(&surface.confirmer),
            version: surface.version,
            displays: self.rules.displays.mask(displays),
            is_strict: self.rules.displays == ConfirmedDisplays::All,
        })
    }
}

impl CameraSurface {
    fn new(topic: &str, settings: ConfirmSettings) -> Self {
        Self {
            topic: topic.to_owned(),
            waiting: WaitingQueue::new(QUEUE_SIZE),
            decoder: GridDecoder::default(),
            confirmer: Arc::new(Mutex::new(Confirmer::new(settings))),
            version: 0,
            placed: None,
            problem: None,
        }
    }

    /// Takes the newest depth image that can be placed in the projector's frame.
    fn observe(
        &mut self,
        camera: &Camera,
        scene: &SceneState,
        optical_frame: &str,
        info: Option<&Arc<CameraInfo>>,
        started: Instant,
    ) {
        let (transforms, _) = scene.frames();
        let Some((message, received)) = self.waiting.take_ready(transforms, optical_frame).pop() else {
            let is_waiting = self.waiting.waiting_reason(transforms, optical_frame).is_some();
            if is_waiting && self.placed.is_none() && self.problem.is_none() {
                self.problem = Some(format!("no transform to {optical_frame} at the stamp of its depth images"));
            }
            return;
        };
        let Some(header) = header(&message) else { return };
        let stamp = time_from_stamp(header.stamp);
        let Ok((projector_from_sensor, known_at)) = transforms.lookup_stamped(optical_frame, &header.frame_id, stamp)
        else {
            return;
        };
        match self.decoder.decode(&self.topic, &message, info) {
            Ok(grid) => {
                let now = received.saturating_duration_since(started);
                lock(&self.confirmer).observe(camera, &projector_from_sensor, &grid, now);
                self.version += 1;
                // Without a stamp, it was placed by the newest transform, which may be old.
                self.placed = Some([stamp, known_at].map(|stamp| Measured { stamp, received }));
                self.problem = None;
            }
            Err(problem) => {
                self.placed = None;
                self.problem = Some(problem);
            }
        }
    }

    fn condition(&self, limit: Duration, now: Now) -> Condition {
        let Self { topic, placed, problem, .. } = self;
        match (placed, problem) {
            (_, Some(problem)) => Condition::Dark(format!("surface on {topic}: {problem}")),
            (None, None) => Condition::Dark(format!("no current surface on {topic}")),
            (Some([image, transform]), None) => {
                let of_image = image.condition(&format!("surface on {topic}"), limit, now);
                of_image.and(transform.condition(&format!("transform of the surface on {topic}"), limit, now))
            }
        }
    }
}

/// `true` if both are one message, not only equal ones.
fn is_same(a: &AnyMessage, b: &AnyMessage) -> bool {
    match (a, b) {
        (AnyMessage::PointCloud2(a), AnyMessage::PointCloud2(b)) => Arc::ptr_eq(a, b),
        (AnyMessage::Image(a), AnyMessage::Image(b)) => Arc::ptr_eq(a, b),
        (AnyMessage::CompressedImage(a), AnyMessage::CompressedImage(b)) => Arc::ptr_eq(a, b),
        _ => false,
    }
}
