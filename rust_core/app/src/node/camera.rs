//! One camera of the node: its topics, its trigger, its pace, and its last picture.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Result;
use rcs_displays::{CameraView, Level};
use rcs_input::live::{RosNode, TriggerReply};
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_output::image_topic::{ImagePublisher, Picture as SentPicture};
use rcs_render::{Renderer, View};
use rcs_scene::{Camera, Picture, Scene};

use super::pace::Pace;
use crate::camera_pose::{rviz_differs, CameraProblem, Projection};
use crate::logging::one_line;
use crate::offline::encoding;
use crate::report::{self, Subject};
use crate::stage::Stage;

/// A camera with its publisher and its trigger service.
pub(super) struct CameraOutput {
    view: CameraView,
    pace: Pace,
    publisher: Option<ImagePublisher>,
    /// The whole name of its trigger service; none where another camera has it.
    service: Option<Arc<str>>,
    /// Somebody subscribed and has not seen a picture yet.
    new_subscriber: Arc<AtomicBool>,
    triggered: bool,
    last_published: Option<Instant>,
    last: Option<LastPicture>,
    problem: Option<CameraProblem>,
    /// What went wrong at the last picture.
    fault: Option<String>,
    said_projection: bool,
    drawn: u64,
    published: u64,
}

/// A drawn picture and what it was drawn of.
struct LastPicture {
    sent: SentPicture,
    scene_version: u64,
    camera: Camera,
    info: Arc<CameraInfo>,
}

/// The cameras' names, for the log.
pub(super) fn names(cameras: &[CameraOutput]) -> String {
    match cameras {
        [] => "no camera".to_owned(),
        cameras => cameras.iter().map(|camera| camera.view.name.as_str()).collect::<Vec<_>>().join(", "),
    }
}

/// A name of a display in its namespace: as roscpp resolves a name in a node handle of that namespace.
fn in_namespace(namespace: &str, name: &str) -> String {
    let namespace = namespace.trim_end_matches('/');
    if namespace.is_empty() || name.starts_with(['/', '~']) {
        name.to_owned()
    } else {
        format!("{namespace}/{name}")
    }
}

/// Opens the cameras' topics and services.
pub(super) fn outputs(ros: &RosNode, views: &[CameraView], global_frame_rate_hz: i32) -> Result<Vec<CameraOutput>> {
    let mut services: HashMap<String, String> = HashMap::new();
    let mut outputs = Vec::new();
    for view in views {
        let namespace = &view.settings.display_namespace;
        let service_name = ros.resolve(&in_namespace(namespace, "camera_trigger"))?;
        let service = match services.get(&service_name) {
            Some(other) => {
                log::warn!(
                    "cameras {other} and {} have the same display namespace \"{namespace}\", so {service_name} \
                     triggers {other} only; make sure that the display namespace is unique",
                    view.name
                );
                None
            }
            None => {
                services.insert(service_name, view.name.clone());
                Some(ros.serve_trigger(&in_namespace(namespace, "camera_trigger"))?)
            }
        };
        outputs.push(CameraOutput::new(ros, view, service, global_frame_rate_hz));
    }
    Ok(outputs)
}

impl CameraOutput {
    fn new(ros: &RosNode, view: &CameraView, service: Option<Arc<str>>, global_frame_rate_hz: i32) -> Self {
        let settings = &view.settings;
        let new_subscriber = Arc::new(AtomicBool::new(false));
        let publisher = if settings.image_topic.is_empty() || settings.camera_info_topic.is_empty() {
            log::error!("camera {}: Image Topic and Camera Info Topic must both be set", view.name);
            None
        } else {
            let (flag, events) = (new_subscriber.clone(), ros.events().clone());
            let on_subscriber = move |_: &str| {
                flag.store(true, Ordering::Release);
                events.wake();
            };
            let topic = in_namespace(&settings.display_namespace, &settings.image_topic);
            ImagePublisher::new(&topic, on_subscriber)
                .map_err(|error| log::error!("camera {}: {error}", view.name))
                .ok()
        };
        Self {
            pace: Pace::new(settings.frame_rate_hz, global_frame_rate_hz),
            view: view.clone(),
            publisher,
            service,
            new_subscriber,
            triggered: false,
            last_published: None,
            last: None,
            problem: None,
            fault: None,
            said_projection: false,
            drawn: 0,
            published: 0,
        }
    }

    /// How it does, for those who look at its statuses.
    pub(super) fn subject(&self, stage: &Stage, projection: Projection) -> Subject<'static> {
        let mut subject = report::camera(stage, &self.view, projection);
        let statuses = subject.statuses.to_mut();
        match (&self.publisher, &self.service) {
            (None, _) if statuses.level() < Level::Error => {
                statuses.set(Level::Error, "Output Topic", "Image publisher not configured");
            }
            (_, None) => {
                let text = "Could not create trigger. Make sure that display namespace is unique!";
                statuses.set(Level::Warn, "Display namespace", text);
            }
            _ => statuses.set(Level::Ok, "Display namespace", "OK"),
        }
        if let Some(fault) = &self.fault {
            statuses.set(Level::Error, "Picture", fault.clone());
        }
        if let Some(publisher) = &self.publisher {
            subject.topic = publisher.topic().to_owned();
            subject.values.push(("subscribers", publisher.subscriber_count().to_string()));
        }
        subject.values.push(("frames drawn", self.drawn.to_string()));
        subject.values.push(("frames published", self.published.to_string()));
        subject
    }

    /// Takes how drawing and publishing went. What goes wrong is said once.
    pub(super) fn note(&mut self, done: Result<()>) {
        self.fault = done.err().map(|error| {
            let fault = one_line(&error);
            if self.fault.as_ref() != Some(&fault) {
                log::error!("camera {}: {fault}", self.view.name);
            }
            fault
        });
    }

    /// Whether this is the camera of a trigger service.
    pub(super) fn serves(&self, service: &str) -> bool {
        self.service.as_deref() == Some(service)
    }

    /// Answers a call of the trigger service; the picture follows.
    pub(super) fn trigger(&mut self, reply: TriggerReply) {
        match &self.publisher {
            Some(publisher) => {
                self.triggered = true;
                reply.send(true, format!("New image will be published on: {}", publisher.topic()));
            }
            None => reply.send(false, "Image publisher not configured"),
        }
    }

    fn has_subscribers(&self) -> bool {
        self.publisher.as_ref().is_some_and(|publisher| publisher.subscriber_count() > 0)
    }

    /// How long until a picture is due by itself; `None` when that is never.
    pub(super) fn until_due(&self, now: Instant) -> Option<Duration> {
        // A camera that cannot see is tried again when a message comes.
        let waits = self.problem.is_some() || !self.has_subscribers();
        self.pace.until_due(self.last_published, now).filter(|_| !waits)
    }

    /// Draws and publishes a picture if one is due. `scene` is called for what is drawn.
    pub(super) fn publish_if_due(
        &mut self,
        stage: &Stage,
        scene_version: u64,
        scene: impl FnOnce() -> Arc<Scene>,
        projection: Projection,
        renderer: &mut dyn Renderer,
        ros: &RosNode,
    ) -> Result<()> {
        if !self.has_subscribers() {
            self.triggered = false;
            return Ok(());
        }
        let camera = match stage.camera(&self.view, projection) {
            Ok(camera) => camera,
            Err(problem) => {
                self.say(problem);
                return Ok(());
            }
        };
        if self.problem.take().is_some() {
            log::info!("camera {}: ok", self.view.name);
        }
        let Some(info) = stage.camera_info(&self.view).cloned() else { return Ok(()) };
        let is_current = |last: &LastPicture| last.scene_version == scene_version && last.camera == camera;
        let changed = !self.last.as_ref().is_some_and(is_current);
        let now = Instant::now();
        let newcomer = self.pace != Pace::OnTrigger && self.new_subscriber.swap(false, Ordering::AcqRel);
        if !(self.triggered || newcomer || self.pace.is_due(self.last_published, now, changed)) {
            return Ok(());
        }
        // Also where drawing fails: it is tried again at this pace, not at once.
        self.last_published = Some(now);
        if changed {
            self.say_projection(&info, projection);
            self.draw(&camera, info, scene_version, &scene(), renderer)?;
        } else if let Some(last) = &mut self.last {
            last.info = info;
        }
        if let (Some(publisher), Some(last)) = (&mut self.publisher, &self.last) {
            publisher.publish(&last.sent, &last.info, ros.now())?;
            self.published += 1;
            self.triggered = false;
        }
        Ok(())
    }

    fn draw(
        &mut self,
        camera: &Camera,
        info: Arc<CameraInfo>,
        scene_version: u64,
        scene: &Scene,
        renderer: &mut dyn Renderer,
    ) -> Result<()> {
        let encoding = encoding(&self.view);
        let view = View {
            scene,
            camera,
            visible: &self.view.visible,
            background: self.view.settings.background_color,
            encoding,
        };
        // The last picture's memory serves again, unless it is still being sent.
        let recycled = self.last.take().and_then(|last| Arc::try_unwrap(last.sent.pixels).ok());
        let mut picture = Picture { data: recycled.unwrap_or_default(), ..Picture::default() };
        renderer.render(&view, &mut picture)?;
        let sent = SentPicture {
            size_px: [picture.width_px, picture.height_px],
            encoding: encoding.name(),
            step_bytes: picture.step() as u32,
            pixels: Arc::new(picture.data),
        };
        self.drawn += 1;
        self.last = Some(LastPicture { sent, scene_version, camera: camera.clone(), info });
        Ok(())
    }

    /// Says what keeps the camera from seeing, when it is something new. The last picture is not shown for a current one.
    fn say(&mut self, problem: CameraProblem) {
        let same_kind = |known: &CameraProblem| std::mem::discriminant(known) == std::mem::discriminant(&problem);
        let is_new = match (&self.problem, &problem) {
            (Some(known @ CameraProblem::NoTransform { .. }), _) => !same_kind(known),
            // By what is said: a NaN in a problem is not equal to itself.
            (known, _) => known.as_ref().map(ToString::to_string) != Some(problem.to_string()),
        };
        if is_new {
            match problem {
                CameraProblem::BadCameraInfo { .. } => log::error!("camera {}: {problem}", self.view.name),
                _ => log::warn!("camera {}: {problem}", self.view.name),
            }
        }
        self.problem = Some(problem);
        self.last = None;
    }

    /// Says once where rviz's projection is not the one that the CameraInfo asks for.
    fn say_projection(&mut self, info: &CameraInfo, projection: Projection) {
        if projection == Projection::Rviz && rviz_differs(info) && !self.said_projection {
            self.said_projection = true;
            log::warn!(
                "camera {}: P on [{}] has fx ≠ fy or P[7] ≠ 0, which rviz's CameraPub does not project exactly; \
                 --projection exact (or _projection:=exact) does",
                self.view.name,
                self.view.settings.camera_info_topic
            );
        }
    }
}
