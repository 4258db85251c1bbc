//! `camera_stream render`: images of a config and a bag, without a ROS master.

mod moments;
mod player;
mod projector;
mod ros_time;

use std::collections::HashMap;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{anyhow, bail, Context, Error, Result};
use indicatif::{ProgressBar, ProgressStyle};
use rcs_bag::Bag;
use rcs_camera::CameraModel;
use rcs_displays::CameraView;
use rcs_light::{Content, Evidence, Generation, LightRules};
use rcs_node_support::key_value;
use rcs_node_support::lifecycle::EndRequest;
use rcs_render::{Orientation, PostProcess, Renderer};
use rcs_resources::PackageIndex;
use rcs_scene::Image;
use rcs_text::{full_name, topic_name};
use rcs_transforms::Time;

use crate::outputs::{FrameImage, ImageFile, ImageSequence, Output, OutputFrame, VideoFile};
use crate::projection_warning::ProjectionWarning;
use crate::safety::names::{of_camera, ForCamera};
use crate::scene::camera_pose::CameraProblem;
use crate::scene::{self, renderer_view, status_tree, SceneState};

pub use moments::BagSection;
use moments::{BagTimes, RenderTimes};
use player::Player;
use projector::ProjectorOverride;

/// Limit of the light of an image that is written to a file.
const FILE_LIMIT: Duration = Duration::from_secs(3600);

/// Output of `render`.
#[derive(Clone, Debug)]
pub enum RenderTarget {
    /// One image, by default after the bag's last message.
    Image {
        /// The PNG or JPEG file.
        file: PathBuf,
    },
    /// Images numbered from 0: `frame_000000.png`.
    Sequence {
        /// The folder; it is created if it does not exist.
        folder: PathBuf,
        /// Images per second.
        rate_hz: f64,
        /// Remove the images of an earlier sequence in the folder; otherwise they are an error.
        overwrite: bool,
    },
    /// A video.
    Video {
        /// The file.
        file: PathBuf,
        /// Images per second.
        rate_hz: f64,
    },
}

/// The input and output of `render`.
#[derive(Debug)]
pub struct RenderJob<'a> {
    /// The bag's files.
    pub bags: &'a [PathBuf],
    /// The bag's topics that get other names, see [`bag_names`].
    pub remappings: &'a HashMap<String, String>,
    /// The name of the camera; `None` if the config has only one.
    pub camera: Option<&'a str>,
    /// A projector's file that replaces the bag's CameraInfo and frames.
    pub projector: Option<&'a Path>,
    /// The part of the bag.
    pub section: BagSection,
    /// The output.
    pub target: &'a RenderTarget,
    /// Model of the projection.
    pub model: CameraModel,
    /// Orientations of images.
    pub orientations: Vec<ForCamera<Orientation>>,
}

/// Renders a bag as one camera of the scene sees it.
///
/// A sequence begins when the camera has a CameraInfo and a pose, if that is later than requested.
///
/// # Errors
/// One line that names the bag, the camera, the topic, the frame or the file that is the reason.
pub fn render(scene: &mut SceneState, job: &RenderJob<'_>, renderer: &mut dyn Renderer) -> Result<()> {
    scene.pack_points(renderer.takes_packed_points());
    let view = choose_camera(scene.cameras(), job.camera)?.clone();
    let orientation = of_camera(&job.orientations, &view.name).copied().unwrap_or_default();
    // In files nothing ages, and no eyes are near.
    let post = Arc::new(PostProcess { orientation, ..PostProcess::default() });
    let evidence = Evidence::unknown(&[], LightRules::none(FILE_LIMIT), post);
    let bag = job.open()?;
    let Some(times) = BagTimes::of(&bag).with_context(|| job.name())? else {
        bail!("{}: the bag holds no messages", job.name())
    };
    let projector = job.projector.map(|file| ProjectorOverride::read(file, &view)).transpose()?;
    if let Some(projector) = &projector {
        projector.place(scene, times.start);
    }
    let mut player = Player::new(scene, &bag, times, projector);
    let moments = job.moments(&mut player, scene, &view)?;
    // At the next image, so that unfinished files are removed.
    let end = EndRequest::watch_signals()?;
    let mut output = job.target.open()?;
    let progress = progress(moments.count());
    let (mut buffer, mut turned) = (Image::default(), Image::default());
    let mut projection = ProjectionWarning::default();
    for moment in moments.iter() {
        if end.is_requested() {
            bail!("interrupted at {moment}");
        }
        player.play_until(scene, moment).with_context(|| job.name())?;
        scene.update(moment);
        let camera = match scene::camera(scene, &view, job.model) {
            Ok(camera) => camera,
            Err(problem) => {
                // The scene is not needed any more: plays on until there is a camera.
                let is_missing =
                    matches!(problem, CameraProblem::NoCameraInfo { .. } | CameraProblem::NoTransform { .. });
                let begin = is_missing.then(|| player.play_until_camera(scene, &view, job.model, [moment, times.end]));
                return Err(job.no_camera_at(moment, problem, begin.and_then(Result::ok).flatten(), times.start));
            }
        };
        projection.check(scene, &view, job.model);
        let snapshot = scene.scene();
        renderer.render(&renderer_view(&view, &snapshot, &camera), &mut buffer)?;
        let size_px = [buffer.width_px, buffer.height_px];
        let grant = evidence.decide(Content::Scene, size_px, Ok(Generation::default()), Instant::now());
        let lit = grant.map_err(|dark| anyhow!("{dark}"))?.light(buffer, &mut turned);
        let image = FrameImage::lit(lit.context("the picture has another size than its camera")?);
        let (info, stamp) = (scene.camera_info(&view).cloned().unwrap_or_default(), ros_time(moment));
        let frame = OutputFrame { image, info, depth: None, stamp, shown: None };
        output.send(&frame)?;
        // Drawn into again, unless the output still writes it.
        buffer = Arc::try_unwrap(frame.image.into_memory()).unwrap_or_default();
        progress.inc(1);
    }
    output.finish()?;
    progress.finish_and_clear();
    // It is written: a closed pipe, as of `head`, is no error.
    let _ = writeln!(io::stdout(), "written: {}", job.target.described(moments.count()));
    player.status_log.conclude(&status_tree::scene(scene, moments.last()), moments.last());
    Ok(())
}

impl RenderJob<'_> {
    fn name(&self) -> String {
        self.bags.iter().map(|bag| bag.display().to_string()).collect::<Vec<_>>().join(", ")
    }

    fn open(&self) -> Result<Bag> {
        let bag = Bag::open_all(self.bags)?;
        for (from, to) in self.remappings {
            if !bag.connections().any(|connection| full_name(&connection.topic) == *from) {
                log::warn!("{from}:={to}: the bag has no topic {from}");
            }
        }
        Ok(bag.remapped(self.remappings))
    }

    /// The times to render. Plays the bag up to the first of a sequence.
    fn moments(&self, player: &mut Player, scene: &mut SceneState, view: &CameraView) -> Result<RenderTimes> {
        let times = player.times;
        let rate_hz = match self.target {
            RenderTarget::Image { .. } => return self.section.single(times),
            RenderTarget::Sequence { rate_hz, .. } | RenderTarget::Video { rate_hz, .. } => *rate_hz,
        };
        let [first, last] = self.section.bounds(times)?;
        let whole = RenderTimes::between([first, last], rate_hz)?;
        let begin = player.play_until_camera(scene, view, self.model, [first, last]);
        let Some(begin) = begin.with_context(|| self.name())? else {
            // The error of the first image says what is missing.
            return Ok(whole);
        };
        if begin > first {
            let late_secs = begin.secs_since(first);
            let is_missing_images = late_secs * rate_hz >= 1.0;
            let level = if is_missing_images { log::Level::Info } else { log::Level::Debug };
            log::log!(
                level,
                "the first picture is of {begin}: {late_secs:.3} s later the camera has its CameraInfo and pose"
            );
        }
        RenderTimes::between([begin, last], rate_hz)
    }

    /// The error of a time without a camera, which begins later or not at all in a bag from `start` on.
    fn no_camera_at(&self, moment: Time, problem: CameraProblem, begin: Option<Time>, start: Time) -> Error {
        let bag = self.name();
        match begin {
            Some(begin) => {
                // Rounded up, so that the moment is not before it.
                let secs = (begin.secs_since(start) * 1e3).ceil() / 1e3;
                anyhow!(
                    "{bag}: no picture at {moment}, because the camera has its CameraInfo (on {}) and pose only {secs} s \
                     after the bag's first message (--at {secs})",
                    problem.topic()
                )
            }
            None => Error::new(problem).context(bag),
        }
    }
}

impl RenderTarget {
    /// The files that this number of images is in.
    fn described(&self, images: u64) -> String {
        let [first, last] = [0, images.saturating_sub(1)].map(ImageSequence::name);
        match self {
            Self::Image { file } => file.display().to_string(),
            Self::Sequence { folder, .. } if images == 1 => folder.join(first).display().to_string(),
            Self::Sequence { folder, .. } => format!("{images} pictures, {} to {last}", folder.join(first).display()),
            Self::Video { file, rate_hz } => {
                let secs = images as f64 / rate_hz;
                format!("{} ({secs:.1} s at {rate_hz} Hz)", file.display())
            }
        }
    }

    fn open(&self) -> Result<Box<dyn Output>> {
        Ok(match self {
            Self::Image { file } => Box::new(ImageFile::new(file)),
            Self::Sequence { folder, overwrite, .. } => Box::new(ImageSequence::create(folder, *overwrite)?),
            Self::Video { file, rate_hz } => Box::new(VideoFile::create(file, *rate_hz)?),
        })
    }
}

/// Renamed topics of a bag by their whole names, from remappings such as `/robot1/points:=/points`.
///
/// # Errors
/// One line with the invalid name.
pub fn bag_names(remappings: &[(String, String)]) -> Result<HashMap<String, String>> {
    let whole = |(from, to): &(String, String)| {
        let name = |name: &String| {
            topic_name(name).map_err(|reason| anyhow!("{from}:={to}: '{name}' is no topic of a bag: {reason}"))
        };
        Ok((name(from)?, name(to)?))
    };
    remappings.iter().map(whole).collect()
}

/// Most bytes of a parameter's text.
const MAX_PARAMETER_BYTES: u64 = 64 << 20;

/// Reads parameters that are given as `NAME=FILE`, the file by its path or its `package://` address. The file
/// may be a pipe of the shell.
///
/// # Errors
/// One line that names the parameter and the file that cannot be read.
pub fn read_parameters(given: &[String], packages: &PackageIndex) -> Result<HashMap<String, Arc<str>>> {
    let read = |parameter: &String| {
        let (name, file) =
            key_value::split(parameter).with_context(|| format!("--param {parameter}: it is NAME=FILE"))?;
        let path = if file.contains("://") { packages.resolve(file)? } else { file.into() };
        let read = rcs_user_files::read_once(&path, MAX_PARAMETER_BYTES);
        let bytes = read.with_context(|| format!("--param {name}: {}", path.display()))?;
        let name = topic_name(name).map_err(|reason| anyhow!("--param {name}: '{name}' is not {reason}"))?;
        Ok((name, rcs_text::decode(&bytes).into()))
    };
    given.iter().map(read).collect()
}

/// Sets the parameters that the scene reads; those that are not among `parameters` are not set.
pub fn set_parameters(scene: &mut SceneState, parameters: &HashMap<String, Arc<str>>) {
    for name in scene.parameters() {
        let text = parameters.get(&full_name(&name));
        scene.take_parameter(&name, text, Time::ZERO);
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

/// A progress bar on a terminal for more than one image, nothing on a pipe.
fn progress(images: u64) -> ProgressBar {
    if images < 2 {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} pictures, {eta} left");
    ProgressBar::new(images).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}
