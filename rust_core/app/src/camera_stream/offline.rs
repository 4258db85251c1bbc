//! `camera_stream render`: pictures from a config and a bag, without a ROS master.

use std::collections::HashMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use anyhow::{bail, Context, Result};
use indicatif::{ProgressBar, ProgressStyle};
use rcs_bag::{Bag, BagMessage, Connection};
use rcs_displays::{time_from_stamp, CameraView};
use rcs_messages::{AnyMessage, MessageKind};
use rcs_render::Renderer;
use rcs_resources::PackageIndex;
use rcs_scene::Picture;
use rcs_transforms::Time;

use crate::camera_stream::camera_pose::Projection;
use crate::camera_stream::outputs::{Frame, Output, PngFile, PngSequence};
use crate::camera_stream::stage::{renderer_view, Stage};
use crate::camera_stream::status_log::StatusLog;

/// The most pictures of a sequence: their numbers have six digits.
const MAX_PICTURES: u64 = 1_000_000;

/// Which moments are rendered, and where to.
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
        /// The folder; it is created if it does not exist.
        folder: PathBuf,
        /// Pictures a second.
        rate_hz: f64,
    },
}

/// Renders what one camera of the stage sees of a bag.
///
/// # Errors
/// One line that names the bag, the camera, the topic or the frame that is the reason.
pub fn render(
    stage: &mut Stage,
    bag_path: &Path,
    camera_name: Option<&str>,
    target: &Target,
    renderer: &mut dyn Renderer,
    projection: Projection,
) -> Result<()> {
    let view = choose_camera(stage.cameras(), camera_name)?.clone();
    let bag = Bag::open(bag_path)?;
    let Some((start, end)) = bag.time_range() else { bail!("{}: the bag holds no messages", bag_path.display()) };
    let (start, end) = (time_from_stamp(start), time_from_stamp(end));
    let moments = Moments::of(target, start, end)?;
    let mut output = target.open()?;
    let progress = progress(moments.count);
    let mut player = Player::new(stage, &bag);
    let mut picture = Arc::new(Picture::default());
    for moment in moments.iter() {
        player.play_until(stage, moment);
        stage.update(moment);
        let camera = stage.camera(&view, projection).with_context(|| bag_path.display().to_string())?;
        let scene = stage.scene();
        renderer.render(&renderer_view(&view, &scene, &camera), Arc::make_mut(&mut picture))?;
        let info = stage.camera_info(&view).cloned().unwrap_or_default();
        output.send(&Frame { picture: Arc::clone(&picture), info, stamp: ros_time(moment) })?;
        progress.inc(1);
    }
    progress.finish_and_clear();
    player.status_log.conclude(&stage.status_entries(moments.last()), moments.last());
    Ok(())
}

impl Target {
    fn open(&self) -> Result<Box<dyn Output>> {
        Ok(match self {
            Self::Picture { file, .. } => Box::new(PngFile::new(file)),
            Self::Sequence { folder, .. } => {
                Box::new(PngSequence::create(folder).with_context(|| folder.display().to_string())?)
            }
        })
    }
}

/// The most bytes of a parameter's text.
const MAX_PARAMETER_BYTES: u64 = 64 << 20;

/// The texts of parameters that are given as `NAME=FILE`, the file by its path or its `package://` address. The user's
/// own file may be anything that can be read, such as the output of another program.
///
/// # Errors
/// One line that names the parameter and the file that cannot be read.
pub fn read_parameters(given: &[String], packages: &PackageIndex) -> Result<HashMap<String, Arc<str>>> {
    let read = |parameter: &String| {
        let (name, file) =
            parameter.split_once('=').with_context(|| format!("--param {parameter}: it is NAME=FILE"))?;
        let path = if file.contains("://") { packages.resolve(file)? } else { file.into() };
        let mut bytes = Vec::new();
        let opened = File::open(&path);
        let read = opened.and_then(|file| file.take(MAX_PARAMETER_BYTES + 1).read_to_end(&mut bytes));
        read.with_context(|| format!("--param {name}: {}", path.display()))?;
        if bytes.len() as u64 > MAX_PARAMETER_BYTES {
            bail!("--param {name}: {}: larger than {} MB", path.display(), MAX_PARAMETER_BYTES >> 20);
        }
        let text = String::from_utf8_lossy(&bytes).into_owned();
        Ok((name.trim_start_matches('/').to_owned(), text.into()))
    };
    given.iter().map(read).collect()
}

/// Sets the parameters that the stage reads; those that are not among `parameters` are not set.
pub fn set_parameters(stage: &mut Stage, parameters: &HashMap<String, Arc<str>>) {
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

fn ros_time(time: Time) -> rcs_messages::Time {
    let (sec, nsec) = time.as_secs_nanos();
    rcs_messages::Time { sec, nsec }
}

/// The moments that are rendered: evenly spaced, one at least.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Moments {
    first: Time,
    rate_hz: f64,
    count: u64,
}

impl Moments {
    fn of(target: &Target, start: Time, end: Time) -> Result<Self> {
        let single = |first| Ok(Self { first, rate_hz: 1.0, count: 1 });
        match target {
            Target::Picture { at_secs: None, .. } => single(end),
            Target::Picture { at_secs: Some(secs), .. } => {
                let absolute = *secs >= start.as_secs_f64() && *secs <= end.as_secs_f64() + 1.0;
                let moment = if absolute { Time::from_secs_f64(*secs) } else { after(start, *secs) };
                if moment < start {
                    bail!("--at {secs}: the bag begins at {start}");
                }
                single(moment)
            }
            Target::Sequence { rate_hz, .. } => {
                let length_secs = end.secs_since(start);
                // The last one is drawn although its time is rounded.
                let count = (length_secs * rate_hz + 1e-9).floor() + 1.0;
                if !(count >= 1.0 && count <= MAX_PICTURES as f64) {
                    bail!("--rate {rate_hz}: {count} pictures of {length_secs} s, more than {MAX_PICTURES}");
                }
                Ok(Self { first: start, rate_hz: *rate_hz, count: count as u64 })
            }
        }
    }

    fn at(&self, index: u64) -> Time {
        after(self.first, index as f64 / self.rate_hz)
    }

    fn iter(&self) -> impl Iterator<Item = Time> + '_ {
        (0..self.count).map(|index| self.at(index))
    }

    fn last(&self) -> Time {
        self.at(self.count.saturating_sub(1))
    }
}

/// The time so many seconds after another, before it if they are negative; the last or first of all times where there
/// is none.
fn after(start: Time, secs: f64) -> Time {
    let duration = Duration::try_from_secs_f64(secs.abs()).unwrap_or(Duration::MAX);
    if secs < 0.0 {
        start.saturating_sub(duration)
    } else {
        start.saturating_add(duration)
    }
}

/// A progress bar on a terminal for more than one picture, nothing on a pipe.
fn progress(pictures: u64) -> ProgressBar {
    if pictures < 2 {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} pictures, {eta} left");
    ProgressBar::new(pictures).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// Plays a bag's messages to a stage.
struct Player {
    messages: std::iter::Peekable<rcs_bag::Messages>,
    /// The topics of the config: the full name, the config's name, and the type that it expects.
    wanted: Vec<(String, String, MessageKind)>,
    /// When the first and the last of the transforms were recorded that the displays were not yet updated with.
    unseen_transforms: Option<(Time, Time)>,
    status_log: StatusLog,
}

/// The displays are updated with the transforms of so much time at once, as rviz is once a picture.
const UPDATE_PERIOD: Duration = Duration::from_millis(33);

/// A topic's full name in a bag or a config, without remapping: names without a slash are below the root.
fn full_name(topic: &str) -> String {
    format!("/{}", topic.trim_start_matches('/'))
}

fn is_transforms(connection: &Connection) -> bool {
    matches!(&*full_name(&connection.topic), "/tf" | "/tf_static")
}

impl Player {
    fn new(stage: &Stage, bag: &Bag) -> Self {
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
        Self { messages, wanted, unseen_transforms: None, status_log }
    }

    /// Plays all messages up to a time.
    fn play_until(&mut self, stage: &mut Stage, moment: Time) {
        while let Some(next) = self.messages.peek() {
            if next.as_ref().is_ok_and(|message| time_from_stamp(message.time) > moment) {
                break;
            }
            match self.messages.next() {
                Some(Ok(message)) => {
                    self.play(stage, &message);
                    let now = time_from_stamp(message.time);
                    if self.status_log.is_due(now) {
                        self.status_log.check(&stage.status_entries(now), now);
                    }
                }
                Some(Err(error)) => log::warn!("{error}"),
                None => break,
            }
        }
        self.update_with_transforms(stage);
    }

    /// Updates the displays with the transforms since their last update, at the time of the last of those.
    fn update_with_transforms(&mut self, stage: &mut Stage) {
        if let Some((_, last)) = self.unseen_transforms.take() {
            stage.update(last);
        }
    }

    fn play(&mut self, stage: &mut Stage, message: &BagMessage) {
        let connection = &message.connection;
        let name = full_name(&connection.topic);
        let damaged = |error: &dyn std::fmt::Display| log::warn!("topic {name}: cannot decode a message: {error}");
        let now = time_from_stamp(message.time);
        if self.unseen_transforms.is_some_and(|(first, _)| now.saturating_since(first) >= UPDATE_PERIOD) {
            self.update_with_transforms(stage);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_moment_beyond_all_times_is_after_or_before_the_bag() {
        let at = |secs| Time::from_secs_nanos(secs, 0);
        let moments = |secs| {
            let target = Target::Picture { file: PathBuf::new(), at_secs: Some(secs) };
            Moments::of(&target, at(100), at(103))
        };
        let first = |secs| moments(secs).unwrap().first;
        assert_eq!([first(0.0), first(1.5), first(102.0)].map(|time| time.as_secs_f64()), [100.0, 101.5, 102.0]);
        for secs in [1e9, 1e20, 1e300] {
            assert!(first(secs) > at(1_000_000_000), "{secs}");
            assert!(moments(-secs).unwrap_err().to_string().contains("the bag begins at 100"), "{secs}");
        }
    }

    #[test]
    fn a_sequence_covers_the_bag_and_has_a_limit() {
        let at = |secs| Time::from_secs_nanos(secs, 0);
        let moments = |rate_hz, end| {
            let target = Target::Sequence { folder: PathBuf::new(), rate_hz };
            Moments::of(&target, at(100), at(end))
        };
        let times: Vec<f64> = moments(2.0, 102).unwrap().iter().map(Time::as_secs_f64).collect();
        assert_eq!(times, [100.0, 100.5, 101.0, 101.5, 102.0]);
        assert_eq!(moments(2.0, 102).unwrap().last(), at(102));
        assert_eq!(moments(30.0, 100).unwrap().count, 1);
        assert_eq!(moments(1000.0, 1099).unwrap().count, 999_001);
        for (rate_hz, end) in [(1000.0, 1101), (1e300, 101), (f64::NAN, 101), (1e11, 4_000_000_000)] {
            let error = moments(rate_hz, end).unwrap_err().to_string();
            assert!(error.contains("1000000"), "{error}");
        }
    }
}
