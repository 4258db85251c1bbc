//! One camera of the node: its topics, its trigger, its settings, its pace, and its last picture.

use std::collections::HashSet;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Result;
use rcs_displays::{CameraView, DisplaySet, Level};
use rcs_messages::dynamic_reconfigure::Config as Values;
use rcs_messages::sensor_msgs::CameraInfo;
use rcs_messages::stamp_nanos;
use rcs_render::{Renderer, View};
use rcs_ros::image_topic::{camera_info_topic, ImagePublisher, Picture as SentPicture, PublishError};
use rcs_ros::{RosNode, TriggerReply};
use rcs_rviz_config::{CameraPubSettings, Config, DisplaySettings};
use rcs_scene::{Camera, DisplayMask, Picture, Scene};
use rcs_transforms::Time;

use super::latency::{Latency, Update};
use super::pace::{Pace, Published};
use super::parameters::{ros_name, switches, unique, Switch};
use super::tuning::Tuning;
use crate::camera_stream::camera_pose::{rviz_differs, CameraProblem, Projection};
use crate::camera_stream::report::{self, Subject};
use crate::camera_stream::stage::Stage;
use crate::logging::one_line;

/// A camera with its publisher and its trigger service.
pub(super) struct CameraOutput {
    /// What it is known by when the config is read again, and below which its parameters are: its name as ROS takes it.
    id: String,
    view: CameraView,
    pace: Pace,
    global_frame_rate_hz: i32,
    tuning: Tuning,
    channel: Option<Channel>,
    /// The whole name of its trigger service; none where another camera has it.
    service: Option<Arc<str>>,
    triggered: bool,
    last_published: Option<Published>,
    last: Option<LastPicture>,
    in_flight: Option<Drawing>,
    problem: Option<CameraProblem>,
    /// What went wrong at the last picture.
    fault: Option<String>,
    said_projection: bool,
    drawn: u64,
    published: u64,
    latency: Latency,
}

/// Where pictures go out.
struct Channel {
    publisher: ImagePublisher,
    /// Somebody subscribed and has not seen a picture yet.
    new_subscriber: Arc<AtomicBool>,
}

/// What a config wants of a camera, with all names found valid.
pub(super) struct Plan {
    id: String,
    name: String,
    /// The names of the groups around it and its own.
    path: Vec<String>,
    settings: CameraPubSettings,
    /// The image topic as rosrust is to be given it, and the whole names of the image's and the CameraInfo's topic.
    topics: Option<(String, [String; 2])>,
    /// The whole name of the trigger service.
    service: String,
}

/// A drawn picture and what it was drawn of.
struct LastPicture {
    sent: SentPicture,
    scene_version: u64,
    camera: Camera,
    info: Arc<CameraInfo>,
}

/// What the renderer is drawing for a camera.
struct Drawing {
    scene_version: u64,
    camera: Camera,
    info: Arc<CameraInfo>,
}

/// The cameras' names, for the log.
pub(super) fn names(cameras: &[CameraOutput]) -> String {
    match cameras {
        [] => "no camera".to_owned(),
        cameras => cameras.iter().map(CameraOutput::name).collect::<Vec<_>>().join(", "),
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

/// What a config's enabled cameras want.
///
/// # Errors
/// The first name that ROS does not take.
pub(super) fn plans(ros: &RosNode, config: &Config) -> Result<Vec<Plan>> {
    let mut ids = HashSet::new();
    let mut plans = Vec::new();
    for placed in config.placed_displays().iter().filter(|placed| placed.enabled) {
        let DisplaySettings::CameraPub(settings) = &placed.display.settings else { continue };
        let topics = if settings.image_topic.is_empty() || settings.camera_info_topic.is_empty() {
            None
        } else {
            let topic = in_namespace(&settings.display_namespace, &settings.image_topic);
            let whole = [ros.resolve(&topic)?, ros.resolve(&camera_info_topic(&topic))?];
            Some((topic, whole))
        };
        plans.push(Plan {
            id: unique(ros_name(&placed.display.name, "camera_"), &mut ids),
            name: placed.display.name.clone(),
            path: placed.path.iter().map(|name| (*name).to_owned()).collect(),
            service: ros.resolve(&in_namespace(&settings.display_namespace, "camera_trigger"))?,
            settings: settings.clone(),
            topics,
        });
    }
    Ok(plans)
}

impl Plan {
    /// What the camera looks at, before it is known what its tick boxes show.
    fn view(&self) -> CameraView {
        let (name, path, settings) = (self.name.clone(), self.path.clone(), self.settings.clone());
        CameraView { name, path, settings, visible: DisplayMask::all() }
    }
}

/// Makes the cameras of a config out of those that there are. Topics, services and parameters that stay are not touched.
pub(super) fn rearrange(
    ros: &RosNode,
    plans: Vec<Plan>,
    mut old: Vec<CameraOutput>,
    config: &Config,
    displays: &DisplaySet,
) -> Vec<CameraOutput> {
    let mut channels: Vec<Channel> = old.iter_mut().filter_map(|camera| camera.channel.take()).collect();
    retain_channels(&mut channels, &plans);
    let mut services: Vec<Arc<str>> = old.iter_mut().filter_map(|camera| camera.service.take()).collect();
    services.retain(|service| {
        let wanted = plans.iter().any(|plan| *plan.service == **service);
        if !wanted {
            ros.stop_serving(service);
        }
        wanted
    });
    // Those that are gone take their parameters with them before others may use the names.
    old.retain(|camera| plans.iter().any(|plan| plan.id == camera.id));
    let switches: Arc<[Switch]> = switches(config).into();
    let mut taken: Vec<(String, String)> = Vec::new();
    let mut cameras = Vec::new();
    for plan in plans {
        let service = match taken.iter().find(|(service, _)| *service == plan.service) {
            Some((service, other)) => {
                log::warn!(
                    "cameras {other} and {} have the same display namespace \"{}\", so {service} triggers {other} only; \
                     make sure that the display namespace is unique",
                    plan.name,
                    plan.settings.display_namespace
                );
                None
            }
            None => {
                taken.push((plan.service.clone(), plan.name.clone()));
                take_where(&mut services, |service| **service == *plan.service).or_else(|| serve_trigger(ros, &plan))
            }
        };
        let channel = match &plan.topics {
            None => {
                log::error!("camera {}: Image Topic and Camera Info Topic must both be set", plan.name);
                None
            }
            Some((topic, whole)) => take_where(&mut channels, |channel| channel.topics() == *whole).or_else(|| {
                Channel::open(ros, topic).map_err(|error| log::error!("camera {}: {error}", plan.name)).ok()
            }),
        };
        let known = take_where(&mut old, |camera| camera.id == plan.id);
        let mut camera = known.unwrap_or_else(|| CameraOutput::new(ros, &plan, &switches));
        camera.tuning.follow(ros, &plan.settings, &switches);
        camera.view = plan.view();
        (camera.channel, camera.service) = (channel, service);
        camera.global_frame_rate_hz = config.global.frame_rate_hz;
        camera.tune(displays);
        cameras.push(camera);
    }
    cameras
}

fn take_where<T>(from: &mut Vec<T>, fits: impl Fn(&T) -> bool) -> Option<T> {
    from.iter().position(fits).map(|index| from.remove(index))
}

fn serve_trigger(ros: &RosNode, plan: &Plan) -> Option<Arc<str>> {
    let name = in_namespace(&plan.settings.display_namespace, "camera_trigger");
    ros.serve_trigger(&name).map_err(|error| log::error!("camera {}: {error}", plan.name)).ok()
}

/// Closes the channels that no plan wants. One that shares a topic with them goes, too, to be opened again: rosrust ends
/// a topic with the first of its publishers.
fn retain_channels(channels: &mut Vec<Channel>, plans: &[Plan]) {
    let mut wanted: Vec<&[String; 2]> = plans.iter().filter_map(|plan| Some(&plan.topics.as_ref()?.1)).collect();
    let mut is_wanted = |channel: &Channel| take_where(&mut wanted, |topics| **topics == channel.topics()).is_some();
    let (mut kept, mut gone): (Vec<Channel>, Vec<Channel>) = channels.drain(..).partition(|channel| is_wanted(channel));
    while let Some(index) = kept.iter().position(|channel| gone.iter().any(|other| channel.shares_topic(other))) {
        gone.push(kept.remove(index));
    }
    *channels = kept;
}

impl Channel {
    fn open(ros: &RosNode, topic: &str) -> Result<Self, PublishError> {
        let new_subscriber = Arc::new(AtomicBool::new(false));
        let (flag, events) = (new_subscriber.clone(), ros.events().clone());
        let on_subscriber = move |_: &str| {
            flag.store(true, Ordering::Release);
            events.wake();
        };
        Ok(Self { publisher: ImagePublisher::new(topic, on_subscriber)?, new_subscriber })
    }

    /// The whole names of its image and CameraInfo topics.
    fn topics(&self) -> [String; 2] {
        [self.publisher.topic(), self.publisher.info_topic()].map(str::to_owned)
    }

    fn shares_topic(&self, other: &Self) -> bool {
        let theirs = other.topics();
        self.topics().iter().any(|topic| theirs.contains(topic))
    }
}

impl CameraOutput {
    fn new(ros: &RosNode, plan: &Plan, switches: &Arc<[Switch]>) -> Self {
        Self {
            id: plan.id.clone(),
            pace: Pace::OnTrigger,
            global_frame_rate_hz: 0,
            tuning: Tuning::start(ros, &plan.id, &plan.settings, switches),
            view: plan.view(),
            channel: None,
            service: None,
            triggered: false,
            last_published: None,
            last: None,
            in_flight: None,
            problem: None,
            fault: None,
            said_projection: false,
            drawn: 0,
            published: 0,
            latency: Latency::default(),
        }
    }

    /// How it does, for those who look at its statuses.
    pub(super) fn subject(&self, stage: &Stage, projection: Projection) -> Subject<'static> {
        let mut subject = report::camera(stage, &self.view, projection);
        let statuses = subject.statuses.to_mut();
        match (&self.channel, &self.service) {
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
        if let Some(Channel { publisher, .. }) = &self.channel {
            subject.topic = publisher.topic().to_owned();
            subject.values.push(("subscribers", publisher.subscriber_count().to_string()));
        }
        subject.values.push(("frames drawn", self.drawn.to_string()));
        subject.values.push(("frames published", self.published.to_string()));
        subject.values.extend(self.latency.values());
        subject
    }

    /// Takes note of what an update of the scene brought.
    pub(super) fn follow(&mut self, update: &Update<'_>) {
        self.latency.follow(update, &self.view.visible);
    }

    /// The messages of before are forgotten.
    pub(super) fn forget_news(&mut self) {
        self.latency.forget();
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

    /// Goes over to the settings as they are now, with the next picture.
    fn tune(&mut self, displays: &DisplaySet) {
        self.tuning.write_to(&mut self.view.settings);
        self.view.visible = displays.mask(&self.view.settings.visibility);
        self.pace = Pace::new(self.view.settings.frame_rate_hz, self.global_frame_rate_hz);
        self.last = None;
    }

    /// Whether its parameters are served under this name.
    pub(super) fn has_parameters(&self, server: &str) -> bool {
        self.tuning.serves(server)
    }

    /// Takes a user's values. Returns those that hold now.
    pub(super) fn reconfigure(&mut self, request: &Values, displays: &DisplaySet, ros: &RosNode) -> Values {
        let values = self.tuning.take(ros, request);
        self.tune(displays);
        values
    }

    /// The display's name.
    pub(super) fn name(&self) -> &str {
        &self.view.name
    }

    /// Whether this is the camera of a trigger service.
    pub(super) fn serves(&self, service: &str) -> bool {
        self.service.as_deref() == Some(service)
    }

    /// Answers a call of the trigger service; the picture follows.
    pub(super) fn trigger(&mut self, reply: TriggerReply) {
        match &self.channel {
            Some(channel) => {
                self.triggered = true;
                reply.send(true, format!("New image will be published on: {}", channel.publisher.topic()));
            }
            None => reply.send(false, "Image publisher not configured"),
        }
    }

    fn has_subscribers(&self) -> bool {
        self.channel.as_ref().is_some_and(|channel| channel.publisher.subscriber_count() > 0)
    }

    /// How long until a picture is due by itself; `None` when that is never.
    pub(super) fn until_due(&self, now: Instant) -> Option<Duration> {
        // A camera that cannot see is tried again when a message comes.
        let waits = self.problem.is_some() || !self.has_subscribers();
        self.pace.until_due(self.last_published, now).filter(|_| !waits)
    }

    /// Begins a picture if one is due that has changed; [`Self::finish`] publishes it. One that has not goes out at once.
    /// `scene` is called for what is drawn. Returns whether a picture was begun.
    pub(super) fn begin_if_due(
        &mut self,
        stage: &Stage,
        scene_version: u64,
        scene: impl FnOnce() -> Arc<Scene>,
        projection: Projection,
        renderer: &mut dyn Renderer,
        ros: &RosNode,
    ) -> Result<bool> {
        if !self.has_subscribers() {
            self.triggered = false;
            self.latency.forget();
            return Ok(false);
        }
        let camera = match stage.camera(&self.view, projection) {
            Ok(camera) => camera,
            Err(problem) => {
                self.say(problem);
                return Ok(false);
            }
        };
        if self.problem.take().is_some() {
            log::info!("camera {}: ok", self.view.name);
        }
        let Some(info) = stage.camera_info(&self.view).cloned() else { return Ok(false) };
        let is_current = |last: &LastPicture| last.scene_version == scene_version && last.camera == camera;
        let changed = !self.last.as_ref().is_some_and(is_current);
        let now = Instant::now();
        let is_new = |channel: &Channel| channel.new_subscriber.swap(false, Ordering::AcqRel);
        let newcomer = self.pace != Pace::OnTrigger && self.channel.as_ref().is_some_and(is_new);
        if !(self.triggered || newcomer || self.pace.is_due(self.last_published, now, changed)) {
            return Ok(false);
        }
        // Also where drawing fails: it is tried again at this pace, not at once.
        self.last_published = Some(Published { at: now, was_new: changed });
        if changed {
            self.say_projection(&info, projection);
            let view = View {
                scene: &scene(),
                camera: &camera,
                visible: &self.view.visible,
                background: self.view.settings.background_color,
                encoding: self.view.settings.image_encoding,
            };
            renderer.submit(&view)?;
            self.in_flight = Some(Drawing { scene_version, camera, info });
            return Ok(true);
        }
        if let Some(last) = &mut self.last {
            last.info = info;
        }
        self.publish_last(None, ros)?;
        Ok(false)
    }

    /// Waits for the picture that was begun, which is the first of the renderer's, and publishes it.
    pub(super) fn finish(&mut self, renderer: &mut dyn Renderer, ros: &RosNode) -> Result<()> {
        let Some(Drawing { scene_version, camera, info }) = self.in_flight.take() else { return Ok(()) };
        // The last picture's memory serves again, unless it is still being sent.
        let recycled = self.last.take().and_then(|last| Arc::try_unwrap(last.sent.pixels).ok());
        let mut picture = Picture { data: recycled.unwrap_or_default(), ..Picture::default() };
        if !renderer.finish(&mut picture)? {
            return Ok(());
        }
        let sent = SentPicture {
            size_px: [picture.width_px, picture.height_px],
            encoding: picture.encoding.name(),
            step_bytes: picture.step() as u32,
            pixels: Arc::new(picture.data),
        };
        self.drawn += 1;
        self.last = Some(LastPicture { sent, scene_version, camera, info });
        self.publish_last(Some(Instant::now()), ros)
    }

    /// The picture that was begun is gone, with those of all cameras; the next look at this one begins it anew.
    pub(super) fn lose_picture(&mut self) {
        self.in_flight = None;
    }

    /// `drawn`: when the picture was, if it is a new one.
    fn publish_last(&mut self, drawn: Option<Instant>, ros: &RosNode) -> Result<()> {
        if let (Some(channel), Some(last)) = (&mut self.channel, &self.last) {
            let stamp = ros.now();
            channel.publisher.publish(&last.sent, &last.info, stamp)?;
            if let Some(drawn) = drawn {
                self.latency.measure(drawn, Instant::now(), Time::from_nanos(stamp_nanos(stamp)));
            }
            self.published += 1;
            self.triggered = false;
        }
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
        self.latency.forget();
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
