//! Options of `camera_stream` as they are given, for clap.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use clap::{ArgAction, Args};
use rcs_camera::Projection;
use rcs_render::RendererChoice;

use super::prediction::PredictionSettings;
use crate::control::brightness::LONGEST_FADE_SECS;
use crate::outputs::depth_image::DepthEncoding;
use crate::safety::ages::limits::AgeLimit;
use rcs_node_support::node_options::{within, COMMAND_LINE_ONLY};

/// Sizes in MB that a mesh file can be limited to.
pub(crate) const MESH_MB: RangeInclusive<u64> = 1..=4096;

/// How scenes are drawn, by the node and over a bag.
#[derive(Args, Clone, Debug)]
pub struct DrawingArgs {
    /// Renderer: the faster of the CPU and a hardware GPU (auto); the CPU (cpu); or any GPU driver (gpu)
    #[arg(long, value_name = "auto|cpu|gpu", default_value = "auto")]
    pub renderer: RendererChoice,
    /// How CameraInfos become images.
    #[command(flatten)]
    pub model: ModelArgs,
    /// Which mesh files may be read.
    #[command(flatten)]
    pub resources: ResourceArgs,
}

/// How CameraInfos become images.
#[derive(Args, Clone, Copy, Debug)]
pub struct ModelArgs {
    /// Use P as rviz does (half a pixel off, more with fx ≠ fy, P[7] ≠ 0, a skew or a mirror), or exactly
    #[arg(long, value_enum, default_value = "rviz")]
    pub projection: Projection,
    /// Correct for the projector's lens where the CameraInfo has D ≠ 0; P is used exactly then
    #[arg(long)]
    pub undistort: bool,
    #[arg(long, hide = true, overrides_with = "undistort")]
    no_undistort: bool,
}

/// Which mesh files, and files that these name, may be read.
#[derive(Args, Clone, Debug)]
pub struct ResourceArgs {
    /// Largest mesh or texture file that is read, 1 to 4096
    #[arg(long, value_name = "MB", default_value_t = 512, value_parser = mesh_mb)]
    pub max_mesh_mb: u64,
    /// Folder outside of ROS packages whose meshes and textures may be read; repeatable
    #[arg(long, value_name = "DIR")]
    pub mesh_folder: Vec<PathBuf>,
}

/// The arguments of the node.
#[derive(Args, Clone, Debug)]
pub struct NodeArgs {
    /// The .rviz config with CameraPub displays; a name without slashes is also looked for in ~/.rviz
    #[arg(short = 'd', long = "display-config", value_name = "FILE", help_heading = COMMAND_LINE_ONLY)]
    pub display_config: Option<PathBuf>,
    /// Fixed frame in place of the config's [default: none]
    #[arg(short = 'f', long = "fixed-frame", value_name = "FRAME")]
    pub fixed_frame: Option<String>,
    /// Do not reload the config when its file changes
    #[arg(long = "no-watch", action = ArgAction::SetFalse)]
    pub watches_config: bool,
    /// Receive clouds, scans and images also while nobody subscribes to an image
    #[arg(long = "no-lazy", action = ArgAction::SetFalse)]
    pub is_lazy: bool,
    /// Encoding of depth images: metres (32FC1) or millimetres (16UC1)
    #[arg(long, value_enum, value_name = "32FC1|16UC1", default_value = "32FC1")]
    pub depth_encoding: DepthEncoding,
    /// Windows of the node's own
    #[command(flatten)]
    pub windows: WindowArgs,
    /// Prediction of moving frames.
    #[command(flatten)]
    pub prediction: PredictionSettings,
    /// Where and when there may be light.
    #[command(flatten)]
    pub light: LightArgs,
    /// The operator's page.
    #[command(flatten)]
    pub web: WebArgs,
    /// How scenes are drawn.
    #[command(flatten)]
    pub drawing: DrawingArgs,
    /// Options of rviz's window: accepted and ignored
    #[command(flatten)]
    pub rviz: RvizArgs,
    /// Log debug messages, too
    #[arg(long, help_heading = COMMAND_LINE_ONLY)]
    pub log_level_debug: bool,
    #[command(flatten)]
    opposites: Opposites,
}

/// Switches that undo others: the last one of two counts.
#[derive(Args, Clone, Debug)]
struct Opposites {
    #[arg(long, hide = true, overrides_with = "watches_config")]
    watch: bool,
    #[arg(long, hide = true, overrides_with = "is_lazy")]
    lazy: bool,
    #[arg(long, hide = true, overrides_with = "set_mode")]
    no_set_mode: bool,
    #[arg(long, hide = true, overrides_with = "stale_note")]
    no_stale_note: bool,
    #[arg(long, hide = true, overrides_with = "blackout")]
    no_blackout: bool,
    #[arg(long, hide = true, overrides_with = "is_mask_required")]
    mask_required: bool,
}

/// Full-screen windows of the node's cameras.
#[derive(Args, Clone, Debug)]
pub struct WindowArgs {
    /// Show the image full screen on a monitor: name, number in projector_window --list-monitors, or auto (the last
    /// that is not primary); with CAMERA= where the config has several cameras; repeatable
    #[arg(long, value_name = "[CAMERA=]MONITOR")]
    pub window: Vec<String>,
    /// Set a monitor that runs another mode to its native one
    #[arg(long)]
    pub set_mode: bool,
}

/// Where and when there may be light, and how it is corrected.
#[derive(Args, Clone, Debug)]
pub struct LightArgs {
    /// Hide data, and black out cameras, whose data are older than this: 0 to 86400 seconds, or none (0: none)
    #[arg(long, value_name = "SECS", default_value = "none", value_parser = stale_timeout)]
    pub stale_timeout: AgeLimit,
    /// Limit for a single topic: seconds, held (as long as it has a publisher) or never; repeatable
    #[arg(long, value_name = "TOPIC=LIMIT")]
    pub stale_timeouts: Vec<String>,
    /// Write into a black image why it is black
    #[arg(long)]
    pub stale_note: bool,
    /// Start blacked out, until ~blackout releases it
    #[arg(long)]
    pub blackout: bool,
    /// Share of each level that is shown, 0 to 1
    #[arg(long, value_name = "SHARE", default_value_t = 1.0, value_parser = within(0.0, 1.0))]
    pub brightness: f64,
    /// Duration of a change of the brightness, 0 to 5 seconds
    #[arg(long, value_name = "SECS", default_value_t = 0.0, value_parser = within(0.0, LONGEST_FADE_SECS))]
    pub fade_seconds: f64,
    /// Topic of a mono8 image over the projector's image, dark where there must be no light; with CAMERA= for one
    #[arg(long, value_name = "[CAMERA=]TOPIC")]
    pub mask_topic: Vec<String>,
    /// No light within this distance of a frame's origin, in metres; repeatable
    #[arg(long, value_name = "FRAME=RADIUS")]
    pub keep_out: Vec<String>,
    /// Keep the last mask and keep-out place while the current one is missing or expired, instead of blacking out
    #[arg(long = "no-mask-required", action = ArgAction::SetFalse)]
    pub is_mask_required: bool,
    /// Grey image over the projector's image, dark or transparent where there must be no light; with CAMERA= for one
    #[arg(long, value_name = "[CAMERA=]FILE.png")]
    pub mask: Vec<String>,
    /// Projector's share of the light, from projector_blend: a grey image, white for all; with CAMERA= for one
    #[arg(long, value_name = "[CAMERA=]FILE.png")]
    pub blend: Vec<String>,
    /// Gamma of the projectors, 0.5 to 5: light is the level to this power
    #[arg(long, value_name = "GAMMA", default_value_t = 2.2, value_parser = gamma)]
    pub blend_gamma: f32,
    /// Turn the image clockwise by 0, 90, 180 or 270 degrees, or mirror it before: mirrored, mirrored-90,
    /// mirrored-180, mirrored-270; with CAMERA= for one [default: 0]
    #[arg(long, value_name = "[CAMERA=]ORIENTATION")]
    pub orientation: Vec<String>,
    /// Light that a depth camera confirms.
    #[command(flatten)]
    pub confirm: ConfirmArgs,
}

/// Light that a depth camera confirms.
#[derive(Args, Clone, Debug)]
pub struct ConfirmArgs {
    /// Topic of a depth camera, a depth image or an organised PointCloud2: light only what it confirms; with CAMERA=
    /// for one
    #[arg(long, value_name = "[CAMERA=]TOPIC")]
    pub surface: Vec<String>,
    /// Display or group whose light the surface must confirm, all, or none; repeatable [default: all]
    #[arg(long, value_name = "DISPLAY")]
    pub confirm: Vec<String>,
    /// Largest difference between an object's depth and the surface's in metres, 0.001 to 1; 1 % of the distance is
    /// added
    #[arg(long, value_name = "METRES", default_value_t = 0.03, value_parser = within(0.001, 1.0))]
    pub confirm_tolerance: f64,
    /// Pixels around what is in the way that stay dark, 0 to 100
    #[arg(long, value_name = "PIXELS", default_value_t = 4, value_parser = clap::value_parser!(u32).range(0..=100))]
    pub confirm_margin: u32,
    /// Light where the depth camera measures no surface
    #[arg(long, value_enum, value_name = "dark|light", default_value = "dark")]
    pub unseen: UnseenLight,
}

/// Light where the depth camera measures no surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum UnseenLight {
    /// None
    Dark,
    /// As drawn
    Light,
}

/// The operator's page.
#[derive(Args, Clone, Debug)]
pub struct WebArgs {
    /// Serve the operator's page at this port, of 127.0.0.1 unless an address is given; 0.0.0.0: of all [default: none]
    #[arg(long, value_name = "[ADDRESS:]PORT")]
    pub web: Option<String>,
    /// Name by which browsers reach the page, beside addresses, localhost and the machine's name; repeatable
    #[arg(long, value_name = "NAME")]
    pub web_hosts: Vec<String>,
}

/// Options of rviz that only concern its window: launch files may have them, so they are accepted and ignored.
#[derive(Args, Clone, Debug)]
pub struct RvizArgs {
    #[arg(short = 's', long, hide = true, value_name = "FILE")]
    splash_screen: Option<String>,
    #[arg(long, hide = true, value_name = "FILE")]
    help_file: Option<String>,
    #[arg(short = 'l', long, hide = true)]
    ogre_log: bool,
    #[arg(long, hide = true)]
    fullscreen: bool,
    #[arg(long, hide = true)]
    in_mc_wrapper: bool,
    #[arg(long, hide = true)]
    no_stereo: bool,
    #[arg(long, hide = true)]
    disable_anti_aliasing: bool,
    #[arg(short = 'v', long, hide = true)]
    verbose: bool,
    #[arg(long, hide = true, value_name = "VERSION")]
    opengl: Option<String>,
}

fn mesh_mb(text: &str) -> Result<u64, String> {
    let size = text.parse().ok().filter(|size| MESH_MB.contains(size));
    size.ok_or_else(|| "MB, a whole number from 1 to 4096".to_owned())
}

fn gamma(text: &str) -> Result<f32, String> {
    within(0.5, 5.0)(text).map(|gamma| gamma as f32)
}

fn stale_timeout(text: &str) -> Result<AgeLimit, String> {
    let limit = if text == "none" { Ok(AgeLimit::Never) } else { AgeLimit::of_secs(text) };
    limit.map_err(|_| "seconds from 0 to 86400, or none".to_owned())
}
