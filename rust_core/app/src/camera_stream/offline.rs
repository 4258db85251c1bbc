//! `camera_stream render`: pictures from a config and a bag, without ROS.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use anyhow::{bail, Context, Result};
use indicatif::{ProgressBar, ProgressStyle};
use rcs_bag::{Bag, BagMessage, Connection};
use rcs_displays::CameraView;
use rcs_messages::{stamp_nanos, AnyMessage, MessageKind};
use rcs_render::{Renderer, View};
use rcs_resources::PackageIndex;
use rcs_scene::Picture;
use rcs_transforms::Time;

use crate::camera_stream::camera_pose::Projection;
use crate::camera_stream::stage::Stage;
use crate::camera_stream::status_log::StatusLog;
use rcs_files::picture_file;

/// What is rendered, and where to.
#[derive(Clone, Debug)]
pub enum Target {
    /// One picture of a moment: that many seconds after the bag's first message (or at that ROS time, where it lies
    /// within the bag's times), or after its last message.
    Picture {
        /// The PNG file.
        file: PathBuf,
        /// When.
        at_secs: Option<f64>,
    },
    /// Pictures of the whole bag, numbered from 0: `frame_000000.png`.
    Sequence {
        /// The folder; it is made where it is missing.
        folder: PathBuf,
        /// Pictures a second.
        rate_hz: f64,
    },
}

/// Renders what one camera of the stage sees of a bag.
///
/// # Errors
/// One line that names the bag, the camera, the topic or the frame that is in the way.
pub fn render(
    stage: &mut Stage,
    bag_path: &Path,
    camera_name: Option<&str>,
    target: &Target,
    renderer: &mut dyn Renderer,
    projection: Projection,
) -> Result<()> {
    let camera = choose_camera(stage.cameras(), camera_name)?.clone();
    let bag = Bag::open(bag_path)?;
    let Some((start, end)) = bag.time_range() else { bail!("{}: the bag holds no messages", bag_path.display()) };
    let (start, end) = (time(start), time(end));
    let moments = moments(target, start, end)?;
    let progress = progress(moments.len());
    let mut player = Player::new(stage, &bag)?;
    let mut picture = Picture::default();
    for (i, moment) in moments.iter().enumerate() {
        player.play_until(stage, *moment)?;
        stage.update(*moment);
        let eye = stage.camera(&camera, projection).with_context(|| bag_path.display().to_string())?;
        let scene = stage.scene();
        let view = View {
            scene: &scene,
            camera: &eye,
            visible: &camera.visible,
            background: camera.settings.background_color,
            encoding: camera.settings.image_encoding,
        };
        renderer.render(&view, &mut picture)?;
        let file = match target {
            Target::Picture { file, .. } => file.clone(),
            Target::Sequence { folder, .. } => folder.join(format!("frame_{i:06}.png")),
        };
        picture_file::write(&file, &picture)?;
        progress.inc(1);
    }
    progress.finish_and_clear();
    let last = moments.last().copied().unwrap_or(end);
    player.status_log.conclude(&stage.subjects(last), last);
    Ok(())
}

/// The texts of parameters that are given as `NAME=FILE`, the file by its path or its `package://` address.
///
/// # Errors
/// One line that names the parameter and the file that cannot be read.
pub fn read_parameters(given: &[String], packages: &PackageIndex) -> Result<HashMap<String, Arc<str>>> {
    let read = |parameter: &String| {
        let (name, file) =
            parameter.split_once('=').with_context(|| format!("--param {parameter}: it is NAME=FILE"))?;
        let path = if file.contains("://") { packages.resolve(file)? } else { file.into() };
        let bytes = std::fs::read(&path).with_context(|| format!("--param {name}: {}", path.display()))?;
        let text = String::from_utf8_lossy(&bytes).into_owned();
        Ok((name.trim_start_matches('/').to_owned(), text.into()))
    };
    given.iter().map(read).collect()
}

/// Hands the stage the parameters that it asks for; those that are not among `parameters` do not exist.
pub fn hand_over(stage: &mut Stage, parameters: &HashMap<String, Arc<str>>) {
    for name in stage.parameters() {
        let text = parameters.get(name.trim_start_matches('/'));
        stage.take_parameter(&name, text, Time::ZERO);
    }
}

fn choose_camera<'a>(cameras: &'a [CameraView], name: Option<&str>) -> Result<&'a CameraView> {
    let names = || cameras.iter().map(|camera| camera.name.as_str()).collect::<Vec<_>>().join(", ");
    match (name, cameras) {
        (_, []) => bail!("the config has no enabled CameraPub display"),
        (Some(name), _) => match cameras.iter().find(|camera| camera.name == name) {
            Some(camera) => Ok(camera),
            None => bail!("the config has no enabled CameraPub display named {name}; it has: {}", names()),
        },
        (None, [camera]) => Ok(camera),
        (None, _) => bail!("the config has several cameras, choose one with --camera: {}", names()),
    }
}

fn time(stamp: rcs_messages::Time) -> Time {
    Time::from_nanos(stamp_nanos(stamp))
}

fn moments(target: &Target, start: Time, end: Time) -> Result<Vec<Time>> {
    match target {
        Target::Picture { at_secs: None, .. } => Ok(vec![end]),
        Target::Picture { at_secs: Some(secs), .. } => {
            let absolute = *secs >= start.as_secs_f64() && *secs <= end.as_secs_f64() + 1.0;
            let moment = if absolute { Time::from_secs_f64(*secs) } else { after(start, *secs) };
            if moment < start {
                bail!("--at {secs}: the bag begins at {start}");
            }
            Ok(vec![moment])
        }
        Target::Sequence { folder, rate_hz } => {
            if !rate_hz.is_finite() || *rate_hz <= 0.0 {
                bail!("--rate {rate_hz}: pictures a second, above 0");
            }
            std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
            let count = (end.secs_since(start) * rate_hz + 1e-9).floor() as u64 + 1;
            Ok((0..count).map(|i| after(start, i as f64 / rate_hz)).collect())
        }
    }
}

fn after(start: Time, secs: f64) -> Time {
    Duration::try_from_secs_f64(secs.abs()).map_or(start, |duration| {
        if secs < 0.0 {
            start.saturating_sub(duration)
        } else {
            start.saturating_add(duration)
        }
    })
}

/// A bar on a terminal for more than one picture, nothing on a pipe.
fn progress(pictures: usize) -> ProgressBar {
    if pictures < 2 {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} pictures, {eta} left");
    ProgressBar::new(pictures as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// Plays a bag's messages onto a stage.
struct Player {
    messages: std::iter::Peekable<rcs_bag::Messages>,
    /// The config's names of each topic of the bag, and what the config expects there.
    wanted: Vec<(String, String, MessageKind)>,
    /// When the first and the last of the transforms came that the displays have not seen yet.
    unseen_transforms: Option<(Time, Time)>,
    status_log: StatusLog,
}

/// The displays see the transforms of so much time at once, as in rviz those of one of its pictures.
const LOOK_PERIOD: Duration = Duration::from_millis(33);

/// A topic's full name in a bag or a config, without remapping: names without a slash are below the root.
fn full_name(topic: &str) -> String {
    format!("/{}", topic.trim_start_matches('/'))
}

fn is_transforms(connection: &Connection) -> bool {
    matches!(&*full_name(&connection.topic), "/tf" | "/tf_static")
}

impl Player {
    fn new(stage: &Stage, bag: &Bag) -> Result<Self> {
        let requests = stage.topics();
        let wanted: Vec<(String, String, MessageKind)> =
            requests.into_iter().map(|request| (full_name(&request.topic), request.topic, request.kind)).collect();
        for connection in bag.connections() {
            for (_, topic, kind) in wanted.iter().filter(|(name, ..)| *name == full_name(&connection.topic)) {
                if kind.ros_type() != &*connection.ros_type {
                    log::warn!("topic {topic} holds {} in the bag, not {}", connection.ros_type, kind.ros_type());
                }
            }
        }
        let names: Vec<String> = wanted.iter().map(|(name, ..)| name.clone()).collect();
        let messages =
            bag.messages(|connection| is_transforms(connection) || names.contains(&full_name(&connection.topic)));
        let (messages, status_log) = (messages.peekable(), StatusLog::default());
        Ok(Self { messages, wanted, unseen_transforms: None, status_log })
    }

    /// Plays all messages up to a time.
    fn play_until(&mut self, stage: &mut Stage, moment: Time) -> Result<()> {
        while let Some(next) = self.messages.peek() {
            if next.as_ref().is_ok_and(|message| time(message.time) > moment) {
                break;
            }
            match self.messages.next() {
                Some(Ok(message)) => {
                    self.play(stage, &message);
                    let now = time(message.time);
                    if self.status_log.is_due(now) {
                        self.status_log.look(&stage.subjects(now), now);
                    }
                }
                Some(Err(error)) => log::warn!("{error}"),
                None => break,
            }
        }
        self.show_transforms(stage);
        Ok(())
    }

    /// Lets the displays see the transforms that came since they looked last, at the time at which those came.
    fn show_transforms(&mut self, stage: &mut Stage) {
        if let Some((_, last)) = self.unseen_transforms.take() {
            stage.update(last);
        }
    }

    fn play(&mut self, stage: &mut Stage, message: &BagMessage) {
        let connection = &message.connection;
        let name = full_name(&connection.topic);
        let damaged = |error: &dyn std::fmt::Display| log::warn!("topic {name}: a message cannot be read: {error}");
        let now = time(message.time);
        if self.unseen_transforms.is_some_and(|(first, _)| now.saturating_since(first) >= LOOK_PERIOD) {
            self.show_transforms(stage);
        }
        if is_transforms(connection) {
            let first = self.unseen_transforms.map_or(now, |(first, _)| first);
            self.unseen_transforms = Some((first, now));
            match MessageKind::TFMessage.decode(&message.bytes) {
                Ok(AnyMessage::TFMessage(transforms)) => {
                    stage.take_transforms(&transforms, name == "/tf_static", &connection.publisher);
                }
                Ok(_) => {}
                Err(error) => damaged(&error),
            }
            return;
        }
        for (_, topic, kind) in self.wanted.iter().filter(|(full, ..)| *full == name) {
            if kind.ros_type() != &*connection.ros_type {
                continue;
            }
            match kind.decode(&message.bytes) {
                Ok(message) => stage.take(topic, &message, now),
                Err(error) => damaged(&error),
            }
        }
        self.unseen_transforms = None;
        stage.update(now);
    }
}
