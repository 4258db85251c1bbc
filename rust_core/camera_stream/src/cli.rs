//! The command line of `camera_stream`.

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::builder::NonEmptyStringValueParser;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, ArgGroup, Args, CommandFactory, Parser, Subcommand};
use rcs_files::image_file::ImageFormat;
use rcs_render::RendererChoice;
use rcs_setup::SetupArgs;
use rcs_text::graph_name;
use rcs_window::MonitorChoice;

use crate::doctor::viewer::Viewer;
use crate::options::arguments::{DrawingArgs, NodeArgs};
use rcs_node_support::node_options::COMMAND_LINE_ONLY;
use rcs_node_support::ros_names::{configures, publishes, reads, serves, subscribes, RosName};

/// Topics, services and parameters of the node. IMAGE, INFO and NAMESPACE are a CameraPub's *Image Topic*, *Camera Info
/// Topic* and *Display namespace*.
pub const ROS_NAMES: &[RosName] = &[
    publishes("IMAGE", "sensor_msgs/Image", "a CameraPub's image, stamped when it is published"),
    publishes("IMAGE/compressed", "sensor_msgs/CompressedImage", "the image as JPEG or PNG, while subscribed to"),
    publishes("camera_info beside IMAGE", "sensor_msgs/CameraInfo", "the image's, with its stamp and frame"),
    publishes(
        "depth beside IMAGE",
        "sensor_msgs/Image",
        "distance along the optical axis (REP 118), NaN or 0 where nothing is drawn; while subscribed to",
    ),
    publishes(
        "shown beside IMAGE",
        "sensor_msgs/TimeReference",
        "of each new image, with its stamp: when it was on the screen; `CAMERA;why black;oldest stamp`",
    ),
    publishes(
        "confirmed beside IMAGE",
        "sensor_msgs/Image",
        "with `--surface`: 255 where light is confirmed or need not be, 0 where it is not; while subscribed to",
    ),
    publishes("~cue", "std_msgs/String", "latched: the current cue, empty without one"),
    publishes("/diagnostics", "diagnostic_msgs/DiagnosticArray", "status of each display and camera, once a second"),
    publishes("/tf_static", "tf2_msgs/TFMessage", "frames of turned images"),
    subscribes("INFO", "sensor_msgs/CameraInfo", "size, P and optical frame of the virtual camera"),
    subscribes("/tf, /tf_static", "tf2_msgs/TFMessage", "all frames"),
    subscribes("topics of the displays", "see the [displays](displays.md)", "paused while nobody watches"),
    subscribes("MASK", "sensor_msgs/Image", "with `--mask-topic`"),
    subscribes(
        "SURFACE",
        "sensor_msgs/Image, CompressedImage or PointCloud2",
        "with `--surface`: depth images, or organised clouds; paused while nobody watches",
    ),
    subscribes("camera_info beside SURFACE", "sensor_msgs/CameraInfo", "of depth images"),
    subscribes(
        "~patterns",
        "sensor_msgs/Image",
        "mono8 of the projector's size, in place of the scene for 3 s each: `projector_calibrate` sends them; \
         `frame_id` names the projector",
    ),
    subscribes("~set_cue", "std_msgs/String", "cue to show"),
    reads("parameters of the displays", "string", "such as `robot_description`, also when it is set later"),
    serves("NAMESPACE/camera_trigger", "std_srvs/Trigger", "publish one image now"),
    serves("~reload_config", "std_srvs/Trigger", "read the config again; answers what has changed"),
    serves(
        "~load_config, ~load_config_discarding_changes",
        "rviz/SendFilePath",
        "use another config; the first refuses to lose unsaved changes",
    ),
    serves(
        "~save_config",
        "rviz/SendFilePath",
        "save the config in a `.rviz` file, without comments, with what dynamic_reconfigure changed",
    ),
    serves("~reload_shaders", "std_srvs/Empty", "as in rviz; does nothing"),
    serves("~blackout", "std_srvs/SetBool", "black out all cameras, or release all blackouts"),
    serves("~pause", "std_srvs/SetBool", "keep the images that are shown"),
    serves("~test_picture", "std_srvs/Trigger", "show the next test picture"),
    serves("~is_idle", "std_srvs/Trigger", "true if all images are dark only because there is nothing to show"),
    serves("~next_cue", "std_srvs/Trigger", "show the next cue"),
    configures("~", "`brightness`, `fade_seconds` and `cue` of all cameras"),
    configures("~CAMERA", "a CameraPub's blackout, frame rate, background, encoding, near clip and visibility"),
    configures("IMAGE/compressed", "`format`, `jpeg_quality`, `png_level`"),
];

/// Draws what rviz's CameraPub virtual cameras see, without rviz, a window or a GPU.
///
/// Without a command it is a ROS node that publishes the images. ROS arguments (from:=to, _param:=value, __name:=,
/// __ns:=, __log:=) may stand anywhere.
///
/// Exit status: 0 success (a node: ended by SIGINT or SIGTERM), 1 failure, 2 invalid arguments or an unreadable config.
#[derive(Debug, Parser)]
#[command(
    name = "camera_stream",
    display_name = "rviz_camera_stream",
    version,
    args_conflicts_with_subcommands = true,
    before_help = "\
Examples:
  camera_stream setup my_scene
  camera_stream -d scene.rviz --window HDMI-1 --stale-timeout 2
  camera_stream render -d scene.rviz --bag scene.bag -o scene.png"
)]
pub struct Cli {
    /// What to do instead of running as a node.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// The node's arguments.
    #[command(flatten)]
    pub node: NodeArgs,
}

impl Cli {
    /// The config that is named, by whichever argument.
    pub(crate) fn config_mut(&mut self) -> Option<&mut PathBuf> {
        match &mut self.command {
            Some(Command::NewCamera(args)) => args.display_config.as_mut(),
            Some(Command::Check(args)) => args.config.as_mut().or(args.node.display_config.as_mut()),
            Some(Command::Doctor(args)) => args.node.display_config.as_mut(),
            Some(Command::Render(args)) => Some(&mut args.display_config),
            Some(Command::Setup(_)) => None,
            None => self.node.display_config.as_mut(),
        }
    }

    /// Whether debug messages are logged.
    pub fn is_debug(&self) -> bool {
        self.node.log_level_debug || self.node_args().log_level_debug
    }

    /// Whether images are drawn, perhaps with a GPU.
    pub fn may_use_gpu(&self) -> bool {
        let draws_nothing = matches!(
            self.command,
            Some(Command::Check(_) | Command::Doctor(_) | Command::NewCamera(_) | Command::Setup(_))
        );
        !draws_nothing && self.drawing().renderer != RendererChoice::Cpu
    }
}

/// What to do instead of running as a node.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Renders images from a bag, without ROS
    ///
    /// FROM:=TO, anywhere, renames a topic of the bag as with rosbag play: /robot1/points:=/points. Times are those of
    /// the bag's /clock if it has one, else those of recording (also with /clock:=/unused).
    #[command(before_help = "\
Examples:
  camera_stream render -d scene.rviz --bag scene.bag -o scene.png
  camera_stream render -d scene.rviz --bag scene.bag --video scene.mp4 \\
      --start 5")]
    Render(RenderArgs),
    /// Prints which parts of a config are understood and drawn; with --live the status of each display in a running ROS
    ///
    /// It takes all options of the node, so that `check --live` can stand in front of a launch line. Those that change
    /// nothing here are not listed.
    ///
    /// What changes no image, such as an unknown class of a disabled display, is a note and no failure.
    ///
    /// Exit status: 0 all is understood (and every status is Ok), 1 something is not or there is no camera with topics,
    /// 2 invalid arguments, an unreadable config or no ROS master.
    #[command(before_help = "\
Examples:
  camera_stream check scene.rviz
  camera_stream check --live -d scene.rviz")]
    Check(CheckArgs),
    /// Goes down the chain from the ROS master to the light and prints what is wrong and what to do about it
    ///
    /// It takes a folder that `camera_stream setup` wrote or arguments of projection.launch (NAME:=VALUE), both of
    /// which roslaunch reads, or with -d all options of the node. Each line is a check: ✓ well, ✗ wrong, ? not known.
    /// It runs without a graphical session.
    ///
    /// Exit status: 0 nothing is wrong, 1 something is, 2 invalid arguments, an unreadable file or no ROS master.
    #[command(before_help = "\
Examples:
  camera_stream doctor my_scene
  camera_stream doctor -d scene.rviz --window HDMI-1")]
    Doctor(DoctorArgs),
    /// Prints a CameraPub display to paste below a config's Displays; with -d it is added to the config
    ///
    /// Everything else in the config keeps its bytes. A name, an image topic or a namespace that a camera of the config
    /// has already is refused.
    #[command(before_help = "\
Examples:
  camera_stream new-camera -d scene.rviz --name Left --image-topic /left/image")]
    NewCamera(NewCameraArgs),
    /// Writes a folder with a first projector file, scene, launch file and the next commands
    ///
    /// Asks on the terminal for what the options leave open, and offers what it finds: the robot's description, TF, the
    /// topics that are published, the monitors. Without a terminal, the options and what is found are the answers, and
    /// all that is missing is one error. Nothing is written until all answers are valid.
    ///
    /// Exit status: 0 written, 1 refused (the folder has files, say), 2 invalid or missing answers.
    #[command(before_help = "\
Examples:
  camera_stream setup my_scene
  camera_stream setup my_scene --profile fixed --size 1280x800 --try")]
    Setup(SetupArgs),
}

/// The arguments of `new-camera`.
#[derive(Args, Clone, Debug)]
pub struct NewCameraArgs {
    /// The .rviz config to add the camera to
    #[arg(short = 'd', long = "display-config", value_name = "FILE")]
    pub display_config: Option<PathBuf>,
    /// The camera's name
    #[arg(long, value_name = "NAME", default_value = "Projector", value_parser = NonEmptyStringValueParser::new())]
    pub name: String,
    /// The topic of its CameraInfo: size, P and frame of the image
    #[arg(long, value_name = "TOPIC", default_value = "/proj_view/camera_info", value_parser = graph_name)]
    pub camera_info: String,
    /// The topic that its images are published on
    #[arg(long, value_name = "TOPIC", default_value = "/proj_view/image", value_parser = graph_name)]
    pub image_topic: String,
    /// The namespace of its service camera_trigger [default: that of the image topic]
    #[arg(long, value_name = "NAMESPACE", value_parser = namespace)]
    pub display_namespace: Option<String>,
}

/// The arguments of `render`.
#[derive(Args, Clone, Debug)]
#[command(group(ArgGroup::new("target").required(true).args(["output", "sequence", "video"])))]
#[command(override_usage = "\
camera_stream render [OPTIONS] -d <FILE> --bag <FILE>... -o <FILE.png>
       camera_stream render [OPTIONS] -d <FILE> --bag <FILE>... --sequence <DIR>
       camera_stream render [OPTIONS] -d <FILE> --bag <FILE>... --video <FILE>")]
pub struct RenderArgs {
    /// The .rviz config with a CameraPub display
    #[arg(short = 'd', long = "display-config", value_name = "FILE")]
    pub display_config: PathBuf,
    /// Fixed frame in place of the config's [default: none]
    #[arg(short = 'f', long = "fixed-frame", value_name = "FRAME")]
    pub fixed_frame: Option<String>,
    /// The bag with /tf, CameraInfo and the displays' messages, or several, such as the parts of a split recording:
    /// .bag or .mcap of ROS 1
    #[arg(long, value_name = "FILE.bag", required = true, num_args = 1..)]
    pub bag: Vec<PathBuf>,
    /// Write one image; its ending, .png, .jpg or .jpeg, is the format
    #[arg(short = 'o', long, value_name = "FILE.png", value_parser = image_file)]
    pub output: Option<PathBuf>,
    /// Write a sequence of numbered images into this folder, one million at most
    #[arg(long, value_name = "DIR")]
    pub sequence: Option<PathBuf>,
    /// Write a video with ffmpeg, which must be installed; its ending is the format
    #[arg(long, value_name = "FILE.mp4", value_parser = video_file)]
    pub video: Option<PathBuf>,
    /// Remove the images of an earlier sequence from the folder of --sequence
    #[arg(long, conflicts_with_all = ["output", "video"])]
    pub overwrite: bool,
    /// Render this moment alone, in seconds after the bag's first message or as ROS time [default for -o: the last
    /// message]
    #[arg(long, value_name = "SECS", allow_negative_numbers = true, value_parser = moment)]
    pub at: Option<f64>,
    /// Begin a sequence or video at this moment [default: the first message, or later when the camera has its
    /// CameraInfo and pose]
    #[arg(long, value_name = "SECS", conflicts_with_all = ["output", "at"], allow_negative_numbers = true, value_parser = moment)]
    pub start: Option<f64>,
    /// End a sequence or video at this moment [default: the last message]
    #[arg(long, value_name = "SECS", conflicts_with_all = ["output", "at"], allow_negative_numbers = true, value_parser = moment)]
    pub end: Option<f64>,
    /// Images a second for --sequence and --video, 1000 at most
    #[arg(long, value_name = "HZ", default_value_t = 30.0, allow_negative_numbers = true, value_parser = rate)]
    pub rate: f64,
    /// Take CameraInfo and frames from a projector's file, as the node projector publishes them, in place of the bag's
    #[arg(long, value_name = "FILE.yaml")]
    pub projector: Option<PathBuf>,
    /// The CameraPub display to render; required if the config has several
    #[arg(long, value_name = "NAME")]
    pub camera: Option<String>,
    /// Turn the image clockwise by 0, 90, 180 or 270 degrees, or mirror it before: mirrored, mirrored-90,
    /// mirrored-180, mirrored-270; with CAMERA= for one [default: 0]
    #[arg(long, value_name = "[CAMERA=]ORIENTATION")]
    pub orientation: Vec<String>,
    /// A parameter that displays read (robot_description, say), from a file
    #[arg(long, value_name = "NAME=FILE")]
    pub param: Vec<String>,
    /// Where package:// addresses are resolved before ROS_PACKAGE_PATH: a package or a folder of packages
    #[arg(long, value_name = "DIR")]
    pub package_path: Vec<PathBuf>,
    /// How scenes are drawn.
    #[command(flatten)]
    pub drawing: DrawingArgs,
}

/// The arguments of `check`.
#[derive(Args, Clone, Debug)]
pub struct CheckArgs {
    /// The .rviz config; -d FILE does the same
    #[arg(value_name = "FILE.rviz", required_unless_present = "display_config", conflicts_with = "display_config")]
    pub config: Option<PathBuf>,
    /// The arguments of the node that is diagnosed.
    #[command(flatten)]
    pub node: NodeArgs,
    /// Connect to the ROS master, subscribe for a while, and print each display's statuses as rviz would show them
    #[arg(long, help_heading = COMMAND_LINE_ONLY)]
    pub live: bool,
    /// How long --live subscribes
    #[arg(long, value_name = "SECS", default_value = "5", requires = "live", value_parser = seconds, help_heading = COMMAND_LINE_ONLY)]
    pub listen: Duration,
}

/// The arguments of `doctor`.
#[derive(Args, Clone, Debug)]
pub struct DoctorArgs {
    /// The folder that `camera_stream setup` wrote
    #[arg(value_name = "FOLDER", conflicts_with = "display_config")]
    pub folder: Option<PathBuf>,
    /// The arguments of the node that is examined.
    #[command(flatten)]
    pub node: NodeArgs,
    /// How long it listens
    #[arg(long, value_name = "SECS", default_value = "5", value_parser = seconds, help_heading = COMMAND_LINE_ONLY)]
    pub listen: Duration,
    /// The file of the node projector, of a launch file that is examined.
    #[arg(long, hide = true, value_name = "FILE")]
    pub(crate) projector_file: Option<PathBuf>,
    /// Viewer of the launch file [default: the window that the node has or that runs beside it]
    #[arg(long, value_enum, value_name = "VIEWER", help_heading = COMMAND_LINE_ONLY)]
    pub(crate) viewer: Option<Viewer>,
    /// Monitor of the viewer, by name or number, or auto [default: that of the running viewer, else auto]
    #[arg(long, value_name = "MONITOR", help_heading = COMMAND_LINE_ONLY)]
    pub(crate) monitor: Option<MonitorChoice>,
}

/// The heading in a command's help of the node's options that have an effect on the command.
const SHARED: &str = "Shared with the node";

/// Options of the node that have an effect on `check`.
const OF_CHECK: [&str; 7] =
    ["display_config", "fixed_frame", "projection", "undistort", "max_mesh_mb", "mesh_folder", "log_level_debug"];

/// Options of the node, beside those of [`OF_CHECK`], that have an effect on `doctor`.
const OF_DOCTOR: [&str; 4] = ["window", "stale_timeout", "stale_timeouts", "orientation"];

/// The command line.
pub fn command() -> clap::Command {
    let for_check = |id: &str| OF_CHECK.contains(&id);
    let for_doctor = |id: &str| for_check(id) || OF_DOCTOR.contains(&id);
    Cli::command()
        .mut_subcommand("check", |command| with_effects(command, for_check))
        .mut_subcommand("doctor", |command| with_effects(command, for_doctor))
        .mut_subcommand("render", |command| with_effects(command, |_| true))
}

/// A command whose help has the node's options below one heading, without those of no effect: `check` and `doctor` take
/// all, so that a launch line can be diagnosed.
fn with_effects(command: clap::Command, has_effect: impl Fn(&str) -> bool) -> clap::Command {
    let node = NodeArgs::augment_args(clap::Command::default());
    let is_of_node = |arg: &Arg| node.get_arguments().any(|other| other.get_id() == arg.get_id());
    command.mut_args(|arg| match (is_of_node(&arg), has_effect(arg.get_id().as_str())) {
        (false, _) => arg.help_heading(None::<&str>),
        (true, true) => arg.help_heading(SHARED),
        (true, false) => arg.hide(true),
    })
}

/// A clap error as it is, but for two hints: that a config is named with `-d`, and none at an option that help hides.
pub fn with_hints(mut error: clap::Error) -> clap::Error {
    if let (ErrorKind::InvalidSubcommand, Some(ContextValue::String(word))) =
        (error.kind(), error.get(ContextKind::InvalidSubcommand))
    {
        let hint = format!("a config is named with -d: camera_stream -d {word}");
        let is_config = word.ends_with(".rviz") || Path::new(word).is_file();
        if is_config {
            error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![hint.into()]));
        }
    }
    let command = command();
    let is_hidden = |suggested: &ContextValue| {
        let option = suggested.to_string();
        let mut hidden = command.get_arguments().filter(|arg| arg.is_hide_set()).filter_map(|arg| arg.get_long());
        hidden.any(|long| format!("--{long}") == option)
    };
    if error.get(ContextKind::SuggestedArg).is_some_and(is_hidden) {
        error.remove(ContextKind::SuggestedArg);
    }
    error
}

/// The highest `--rate` in images a second: no monitor or projector shows more.
const MAX_RATE_HZ: f64 = 1000.0;

/// Images a second: above 0 and not above [`MAX_RATE_HZ`].
fn rate(text: &str) -> Result<f64, String> {
    let rate_hz = text.parse::<f64>().ok().filter(|rate_hz| *rate_hz > 0.0 && *rate_hz <= MAX_RATE_HZ);
    rate_hz.ok_or_else(|| format!("pictures a second, above 0 and not above {MAX_RATE_HZ}"))
}

/// An image, whose name ends with a format's ending.
fn image_file(text: &str) -> Result<PathBuf, String> {
    match ImageFormat::of(Path::new(text)) {
        Ok(_) => Ok(text.into()),
        Err(_) => Err(format!("a picture's name ends with {}", ImageFormat::ENDINGS)),
    }
}

/// A video, whose name has an ending.
fn video_file(text: &str) -> Result<PathBuf, String> {
    match Path::new(text).extension() {
        Some(_) => Ok(text.into()),
        None => Err("a video's name has the ending of its format, such as .mp4".to_owned()),
    }
}

/// A namespace: empty, the root, or a ROS name.
fn namespace(text: &str) -> Result<String, String> {
    match text {
        "" | "/" => Ok(text.to_owned()),
        name => graph_name(name),
    }
}

/// Seconds, any finite number.
fn moment(text: &str) -> Result<f64, String> {
    text.parse::<f64>().ok().filter(|secs| secs.is_finite()).ok_or_else(|| "seconds, a finite number".to_owned())
}

/// Seconds on the command line: from 0 to a day.
fn seconds(text: &str) -> Result<Duration, String> {
    let secs = text.parse::<f64>().ok().filter(|secs| (0.0..=86_400.0).contains(secs));
    secs.map(Duration::from_secs_f64).ok_or_else(|| "seconds, from 0 to 86400".to_owned())
}

#[cfg(test)]
mod tests {
    use rcs_camera::Projection;

    use super::*;

    fn parse(args: &[&str]) -> Result<Cli, clap::Error> {
        Cli::try_parse_from(args)
    }

    #[test]
    fn a_launch_files_arguments_for_rviz_are_accepted() {
        let node = parse(&["camera_stream", "-d", "x.rviz", "-f", "map"]).unwrap().node;
        assert_eq!(node.display_config, Some(PathBuf::from("x.rviz")));
        assert_eq!(node.fixed_frame.as_deref(), Some("map"));
        let args = ["camera_stream", "--splash-screen", "", "--fullscreen", "-d", "x.rviz", "--renderer", "cpu"];
        let cli = parse(&args).unwrap();
        assert_eq!(cli.node.display_config, Some(PathBuf::from("x.rviz")));
        assert_eq!(cli.drawing().renderer, RendererChoice::Cpu);
    }

    #[test]
    fn render_takes_one_image_or_a_sequence() {
        let base = ["camera_stream", "render", "-d", "x.rviz", "--bag", "x.bag"];
        let with = |more: &[&str]| parse(&[&base[..], more].concat());
        assert!(with(&[]).is_err());
        assert!(with(&["-o", "a.png", "--sequence", "d"]).is_err());
        assert!(with(&["-o", "a.png", "--at", "1.5", "--renderer", "gpu"]).is_ok());
        assert!(with(&["-o", "a.jpeg"]).is_ok());
        assert!(with(&["-o", "a.bmp"]).unwrap_err().to_string().contains(".png, .jpg or .jpeg"));
        assert!(with(&["--sequence", "d", "--rate", "10"]).is_ok());
        assert!(with(&["--sequence", "d", "--start", "1", "--end", "2", "--overwrite"]).is_ok());
        assert!(with(&["--sequence", "d", "--at", "1"]).is_ok());
        assert!(with(&["--video", "v.mp4", "--start", "1"]).is_ok());
        let refused = [
            &["--sequence", "d", "--at", "1", "--end", "2"][..],
            &["-o", "a.png", "--start", "1"],
            &["-o", "a.png", "--overwrite"],
            &["--video", "video"],
            &["--video", "v.mp4", "--sequence", "d"],
        ];
        assert!(refused.iter().all(|args| with(args).is_err()));
        assert!(with(&["-o", "a.png", "--renderer", "voodoo"]).is_err());
    }

    #[test]
    fn rates_and_moments_are_finite_and_within_bounds() {
        let base = ["camera_stream", "render", "-d", "x.rviz", "--bag", "x.bag"];
        let exit_code =
            |more: &[&str]| parse(&[&base[..], more].concat()).map_or_else(|error| error.exit_code(), |_| 0);
        for rate in ["0.001", "30", "1000"] {
            assert_eq!(exit_code(&["--sequence", "d", "--rate", rate]), 0, "{rate}");
        }
        for rate in ["0", "-3", "NaN", "inf", "1001", "1e11", "1e300", "fast"] {
            assert_eq!(exit_code(&["--sequence", "d", "--rate", rate]), 2, "{rate}");
        }
        for secs in ["0", "-1", "1.5", "1e9"] {
            assert_eq!(exit_code(&["-o", "a.png", "--at", secs]), 0, "{secs}");
        }
        for secs in ["NaN", "inf", "-inf", "1e999", "soon"] {
            assert_eq!(exit_code(&["-o", "a.png", "--at", secs]), 2, "{secs}");
        }
    }

    #[test]
    fn check_takes_the_arguments_of_the_launch_line_that_it_diagnoses() {
        let check = |line: &str| {
            let args = ["camera_stream", "check", "--live"].into_iter().chain(line.split(' '));
            Cli::try_parse_from(args).map(|mut cli| {
                let file = cli.config_mut().cloned().unwrap_or_default();
                match cli.command {
                    Some(Command::Check(CheckArgs { node: NodeArgs { fixed_frame, drawing, .. }, .. })) => {
                        (file, fixed_frame, drawing.model.projection, drawing.renderer)
                    }
                    other => panic!("{other:?}"),
                }
            })
        };
        let line = "-d x.rviz -f map --projection exact --renderer cpu --no-watch --log-level-debug --splash-screen s \
                    --help-file h -l --fullscreen --in-mc-wrapper --no-stereo --disable-anti-aliasing -v --opengl 3";
        let (file, frame) = (PathBuf::from("x.rviz"), Some("map".to_owned()));
        let all = (file.clone(), frame, Projection::Exact, RendererChoice::Cpu);
        assert_eq!(check(line).unwrap(), all);
        assert_eq!(check("--display-config=x.rviz --fixed-frame=map").unwrap().0, file);
        assert_eq!(check("x.rviz").unwrap().0, file);
        assert!(check("x.rviz -d x.rviz").is_err() && check("-f map").is_err());
    }

    #[test]
    fn the_listening_time_is_in_seconds_and_only_for_live() {
        let check = |more: &[&str]| {
            parse(&[&["camera_stream", "check", "x.rviz"], more].concat()).map(|cli| match cli.command {
                Some(Command::Check(args)) => args,
                other => panic!("{other:?}"),
            })
        };
        assert_eq!(check(&["--live"]).unwrap().listen, Duration::from_secs(5));
        assert_eq!(check(&["--live", "--listen", "0.5"]).unwrap().listen, Duration::from_millis(500));
        let wrong: [&[&str]; 4] = [
            &["--listen", "2"],
            &["--live", "--listen", "-1"],
            &["--live", "--listen", "NaN"],
            &["--live", "--listen", "1e9"],
        ];
        for args in wrong {
            assert!(check(args).is_err(), "{args:?}");
        }
    }

    #[test]
    fn a_new_cameras_names_are_those_of_ros() {
        let exit_code = |option: &str, value: &str| {
            parse(&["camera_stream", "new-camera", option, value]).map_or_else(|error| error.exit_code(), |_| 0)
        };
        for option in ["--image-topic", "--camera-info"] {
            for good in ["/proj_view/image", "image", "~image", "~/image", "/a_1/B2", "/a//b", "/a/"] {
                assert_eq!(exit_code(option, good), 0, "{option} {good}");
            }
            for bad in ["", "/", "bad topic!", "1st", "_a", "/ä", "a~"] {
                assert_eq!(exit_code(option, bad), 2, "{option} {bad}");
            }
        }
        for (namespace, expected) in [("", 0), ("/", 0), ("/left/", 0), ("left", 0), ("my left", 2), ("a//b", 0)] {
            assert_eq!(exit_code("--display-namespace", namespace), expected, "{namespace}");
        }
    }

    #[test]
    fn an_error_says_how_a_config_is_named_and_suggests_nothing_hidden() {
        let printed = |args: &[&str]| with_hints(parse(args).unwrap_err()).to_string();
        let error = printed(&["camera_stream", "/a/scene.rviz"]);
        assert!(error.contains("tip: a config is named with -d: camera_stream -d /a/scene.rviz"), "{error}");
        assert!(!printed(&["camera_stream", "scene"]).contains("-d scene"));
        let error = printed(&["camera_stream", "--nope"]);
        assert!(error.contains("--nope") && !error.contains("--opengl"), "{error}");
        assert!(printed(&["camera_stream", "--fixed-fram"]).contains("--fixed-frame"));
    }

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
