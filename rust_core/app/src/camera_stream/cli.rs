//! The command line of `camera_stream`.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, Parser, Subcommand};
use rcs_render::RendererChoice;

use crate::camera_stream::camera_pose::Projection;

/// Draws what rviz's CameraPub virtual cameras see, without rviz, a window or a GPU.
///
/// Without a command it is a ROS node that publishes the pictures. ROS arguments (from:=to, _param:=value, __name:=,
/// __ns:=, __log:=) may stand anywhere.
///
/// Exit status: 0 done (a node: ended by SIGINT or SIGTERM), 1 something is wrong, 2 unusable arguments or an unreadable
/// config.
#[derive(Debug, Parser)]
#[command(name = "camera_stream", version, args_conflicts_with_subcommands = true)]
pub struct Cli {
    /// What to do in place of running as a node.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// The node's arguments.
    #[command(flatten)]
    pub node: NodeArgs,
    /// What draws: a hardware GPU where there is one and else the CPU (auto), cpu, or any GPU driver (gpu)
    #[arg(long, global = true, value_name = "auto|cpu|gpu")]
    pub renderer: Option<RendererChoice>,
    /// How a CameraInfo's P is used: as rviz does (the same picture), or exactly (for fx ≠ fy or P[7] ≠ 0)
    #[arg(long, global = true, value_enum)]
    pub projection: Option<Projection>,
}

/// The arguments of the node: those of rviz.
#[derive(Args, Clone, Debug)]
pub struct NodeArgs {
    /// The .rviz config with CameraPub displays
    #[arg(short = 'd', long = "display-config", value_name = "FILE")]
    pub display_config: Option<PathBuf>,
    /// The fixed frame, instead of the config's
    #[arg(short = 'f', long = "fixed-frame", value_name = "FRAME")]
    pub fixed_frame: Option<String>,
    /// Do not read the config again when its file changes
    #[arg(long)]
    pub no_watch: bool,
    /// Options of rviz's window: taken and without effect
    #[command(flatten)]
    pub window: WindowArgs,
    /// Log what only concerns developers, too
    #[arg(long)]
    pub log_level_debug: bool,
}

/// Options of rviz that only concern its window: launch files may hold them, so they are taken, and have no effect.
#[derive(Args, Clone, Debug)]
pub struct WindowArgs {
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

/// What to do in place of running as a node.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Draws pictures of a bag, without ROS
    Render(RenderArgs),
    /// Prints what of a config is understood and drawn, or with --live how its displays do in a running ROS
    ///
    /// Exit status: 0 all is understood (and every status is Ok), 1 something is not, 2 the config cannot be read or there
    /// is no ROS master.
    Check(CheckArgs),
}

/// The arguments of `render`.
#[derive(Args, Clone, Debug)]
pub struct RenderArgs {
    /// The .rviz config with a CameraPub display
    #[arg(short = 'd', long = "display-config", value_name = "FILE")]
    pub display_config: PathBuf,
    /// The fixed frame, instead of the config's
    #[arg(short = 'f', long = "fixed-frame", value_name = "FRAME")]
    pub fixed_frame: Option<String>,
    /// The bag with /tf, CameraInfo and the displays' messages
    #[arg(long, value_name = "FILE.bag")]
    pub bag: PathBuf,
    /// The picture to write
    #[arg(short = 'o', long, value_name = "FILE.png", required_unless_present = "frames", conflicts_with = "frames")]
    pub output: Option<PathBuf>,
    /// Draw the moment this many seconds after the bag's first message; without it, after its last message
    #[arg(long, value_name = "SECS", conflicts_with = "frames", allow_negative_numbers = true)]
    pub at: Option<f64>,
    /// Write a numbered picture of every moment into this folder
    #[arg(long, value_name = "DIR")]
    pub frames: Option<PathBuf>,
    /// Pictures a second for --frames
    #[arg(long, value_name = "HZ", default_value_t = 30.0)]
    pub rate: f64,
    /// The CameraPub display to draw; needed when the config has several
    #[arg(long, value_name = "NAME")]
    pub camera: Option<String>,
    /// A parameter that displays read (robot_description, say), from a file
    #[arg(long, value_name = "NAME=FILE")]
    pub param: Vec<String>,
    /// Where package:// addresses are looked for before ROS_PACKAGE_PATH: a package or a folder of packages
    #[arg(long, value_name = "DIR")]
    pub package_path: Vec<PathBuf>,
}

/// The arguments of `check`.
#[derive(Args, Clone, Debug)]
pub struct CheckArgs {
    /// The .rviz config
    #[arg(value_name = "FILE.rviz")]
    pub config: PathBuf,
    /// Connect to the ROS master, listen for a while, and print each display's statuses as rviz would show them
    #[arg(long)]
    pub live: bool,
    /// How long --live listens
    #[arg(long, value_name = "SECS", default_value = "5", requires = "live", value_parser = seconds)]
    pub listen: Duration,
}

/// Seconds on the command line: from 0 to a day.
fn seconds(text: &str) -> Result<Duration, String> {
    let secs = text.parse::<f64>().ok().filter(|secs| (0.0..=86_400.0).contains(secs));
    secs.map(Duration::from_secs_f64).ok_or_else(|| "seconds, from 0 to 86400".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(args: &[&str]) -> Result<Cli, clap::Error> {
        Cli::try_parse_from(args)
    }

    #[test]
    fn a_launch_files_arguments_for_rviz_are_taken() {
        let node = parse(&["camera_stream", "-d", "x.rviz", "-f", "map"]).unwrap().node;
        assert_eq!(node.display_config, Some(PathBuf::from("x.rviz")));
        assert_eq!(node.fixed_frame.as_deref(), Some("map"));
        let args = ["camera_stream", "--splash-screen", "", "--fullscreen", "-d", "x.rviz", "--renderer", "cpu"];
        let cli = parse(&args).unwrap();
        assert_eq!(cli.node.display_config, Some(PathBuf::from("x.rviz")));
        assert_eq!(cli.renderer, Some(RendererChoice::Cpu));
    }

    #[test]
    fn render_takes_one_picture_or_a_sequence() {
        let base = ["camera_stream", "render", "-d", "x.rviz", "--bag", "x.bag"];
        let with = |more: &[&str]| parse(&[&base[..], more].concat());
        assert!(with(&[]).is_err());
        assert!(with(&["-o", "a.png", "--frames", "d"]).is_err());
        assert!(with(&["-o", "a.png", "--at", "1.5", "--renderer", "gpu"]).is_ok());
        assert!(with(&["--frames", "d", "--rate", "10"]).is_ok());
        assert!(with(&["-o", "a.png", "--renderer", "voodoo"]).is_err());
    }

    #[test]
    fn how_long_to_listen_is_seconds_and_only_for_live() {
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
    fn the_command_line_is_consistent() {
        use clap::CommandFactory;
        Cli::command().debug_assert();
    }
}
