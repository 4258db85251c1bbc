//! What `camera_stream` is told to do: its command line and its private parameters, read once, merged by
//! [`node_options`](rcs_node_support::node_options), and checked against the config's cameras.
//!
//! [`arguments`] holds the values as clap reads them. Those that are not final there, because they need the config or
//! have several forms, become fields of [`Options`].

pub(crate) mod arguments;
pub(crate) mod config_file;
pub(crate) mod prediction;
pub(crate) mod rviz_arguments;
mod web;

use std::path::{Path, PathBuf};

use rcs_camera::CameraModel;
use rcs_confirm::{ConfirmSettings, Unseen};
use rcs_render::{Orientation, RendererChoice};
use rcs_resources::ResourceOptions;
use rcs_window::MonitorChoice;

use crate::cli::{Cli, Command};
use crate::safety::ages::limits::StaleTimeout;
use crate::safety::confirmed_displays::ConfirmedDisplays;
use crate::safety::names::{ConfigNames, ForCamera, NONE};
use crate::safety::rules::KeepOutFrame;
use arguments::{ConfirmArgs, DrawingArgs, LightArgs, ModelArgs, NodeArgs, ResourceArgs, UnseenLight};
use rcs_node_support::node_options::{InvalidOption, NodeOptions};
pub(crate) use web::WebOptions;

/// All options of the node.
#[derive(Clone, Debug)]
pub(crate) struct Options {
    /// The arguments, for the values that are final there.
    pub(crate) node: NodeArgs,
    /// Overrides the config's fixed frame.
    pub(crate) fixed_frame: Option<String>,
    /// CPU or GPU.
    pub(crate) renderer: RendererChoice,
    /// Projection from CameraInfos.
    pub(crate) model: CameraModel,
    /// Limits for mesh files.
    pub(crate) resources: ResourceOptions,
    /// Monitors that show cameras full screen.
    pub(crate) windows: Vec<ForCamera<MonitorChoice>>,
    /// Where and when there may be light.
    pub(crate) light: LightOptions,
    /// The operator's page, if there is one.
    pub(crate) web: Option<WebOptions>,
}

/// Where and when there may be light, and how it is corrected. Files are not read and topics not resolved yet.
#[derive(Clone, Debug)]
pub(crate) struct LightOptions {
    /// The limit for all topics, then those of single ones.
    pub(crate) stale_timeouts: Vec<StaleTimeout>,
    /// Topics of masks.
    pub(crate) mask_topics: Vec<ForCamera<String>>,
    /// Frames around which there must be no light.
    pub(crate) keep_out: Vec<KeepOutFrame>,
    /// Mask files.
    pub(crate) masks: Vec<ForCamera<PathBuf>>,
    /// Files of weights where projectors overlap.
    pub(crate) blends: Vec<ForCamera<PathBuf>>,
    /// Orientations of images.
    pub(crate) orientations: Vec<ForCamera<Orientation>>,
    /// Light that a depth camera confirms.
    pub(crate) confirm: ConfirmOptions,
}

/// Light that a depth camera confirms. Topics are not resolved yet.
#[derive(Clone, Debug)]
pub(crate) struct ConfirmOptions {
    /// Topics of depth cameras; none where nothing is to be confirmed.
    pub(crate) surfaces: Vec<ForCamera<String>>,
    /// Displays whose light must be confirmed.
    pub(crate) displays: ConfirmedDisplays,
    /// What counts as agreement.
    pub(crate) settings: ConfirmSettings,
}

impl Options {
    /// The options of a command line and the parameters behind it, for a config with these names.
    ///
    /// # Errors
    /// [`InvalidOption`], such as a camera that the config does not have.
    pub(crate) fn of(given: &NodeOptions<Cli>, names: &ConfigNames) -> Result<Self, InvalidOption> {
        Self::new(&given.arguments, names, &|option| given.name_of(option))
    }

    /// The options of a command line alone.
    ///
    /// # Errors
    /// [`InvalidOption`].
    pub(crate) fn of_command_line(cli: &Cli, names: &ConfigNames) -> Result<Self, InvalidOption> {
        Self::new(cli, names, &|option| format!("--{option}"))
    }

    fn new(cli: &Cli, names: &ConfigNames, name_of: &dyn Fn(&str) -> String) -> Result<Self, InvalidOption> {
        let node = cli.node_args();
        Ok(Self {
            fixed_frame: node.fixed_frame.clone().filter(|frame| !["", NONE].contains(&frame.as_str())),
            renderer: node.drawing.renderer,
            model: node.drawing.model.model(),
            resources: node.drawing.resources.options(),
            windows: ForCamera::read_all(&name_of("window"), &node.windows.window, &names.cameras)?,
            light: LightOptions::new(&node.light, names, name_of)?,
            web: WebOptions::new(&node.web, name_of)?,
            node: node.clone(),
        })
    }
}

impl LightOptions {
    fn new(args: &LightArgs, names: &ConfigNames, name_of: &dyn Fn(&str) -> String) -> Result<Self, InvalidOption> {
        let cameras = &names.cameras;
        let general = StaleTimeout { topic: None, limit: args.stale_timeout };
        let of_topic = |text: &str| match text.parse::<StaleTimeout>()? {
            StaleTimeout { topic: None, .. } => Err("not TOPIC=LIMIT".to_owned()),
            of_topic => Ok(of_topic),
        };
        let of_topics = parse_all(&name_of("stale-timeouts"), &args.stale_timeouts, of_topic)?;
        Ok(Self {
            stale_timeouts: std::iter::once(general).chain(of_topics).collect(),
            mask_topics: ForCamera::read_all(&name_of("mask-topic"), &args.mask_topic, cameras)?,
            keep_out: parse_all(&name_of("keep-out"), &args.keep_out, str::parse)?,
            masks: ForCamera::read_all(&name_of("mask"), &args.mask, cameras)?,
            blends: ForCamera::read_all(&name_of("blend"), &args.blend, cameras)?,
            orientations: ForCamera::read_all(&name_of("orientation"), &args.orientation, cameras)?,
            confirm: ConfirmOptions::new(&args.confirm, names, name_of)?,
        })
    }
}

impl ConfirmOptions {
    fn new(args: &ConfirmArgs, names: &ConfigNames, name_of: &dyn Fn(&str) -> String) -> Result<Self, InvalidOption> {
        let surfaces = ForCamera::read_all(&name_of("surface"), &args.surface, &names.cameras)?;
        let displays = ConfirmedDisplays::read(&args.confirm, names)
            .map_err(|(value, reason)| InvalidOption::new(&name_of("confirm"), &value, reason))?;
        if let (ConfirmedDisplays::Named(listed), true) = (&displays, surfaces.is_empty()) {
            let reason = format!("it needs {} as well, the topic of a depth camera", name_of("surface"));
            return Err(InvalidOption::new(&name_of("confirm"), &listed.join(", "), reason));
        }
        let unseen = match args.unseen {
            UnseenLight::Dark => Unseen::Dark,
            UnseenLight::Light => Unseen::Light,
        };
        let surfaces = if displays == ConfirmedDisplays::None { Vec::new() } else { surfaces };
        let (tolerance_m, margin_px) = (args.confirm_tolerance, args.confirm_margin);
        let settings = ConfirmSettings { tolerance_m, margin_px, unseen, ..ConfirmSettings::default() };
        Ok(Self { surfaces, displays, settings })
    }
}

/// The values of an option; [`NONE`] is no value.
fn parse_all<T>(
    option: &str,
    texts: &[String],
    parse: impl Fn(&str) -> Result<T, String>,
) -> Result<Vec<T>, InvalidOption> {
    let parse = |text: &String| parse(text).map_err(|reason| InvalidOption::new(option, text, reason));
    texts.iter().filter(|text| *text != NONE).map(parse).collect()
}

impl Cli {
    /// The arguments of the node: its own, or those that `check` or `doctor` diagnoses.
    pub(crate) fn node_args(&self) -> &NodeArgs {
        match &self.command {
            Some(Command::Check(args)) => &args.node,
            Some(Command::Doctor(args)) => &args.node,
            _ => &self.node,
        }
    }

    /// How `render` or the node draws.
    pub(crate) fn drawing(&self) -> &DrawingArgs {
        match &self.command {
            Some(Command::Render(args)) => &args.drawing,
            _ => &self.node_args().drawing,
        }
    }
}

impl ModelArgs {
    /// How CameraInfos become images.
    pub(crate) fn model(&self) -> CameraModel {
        CameraModel { projection: self.projection, undistort: self.undistort }
    }
}

impl ResourceArgs {
    /// The options for the store of meshes.
    pub(crate) fn options(&self) -> ResourceOptions {
        let folders = self.mesh_folder.iter().filter(|folder| folder.as_os_str() != NONE);
        ResourceOptions { max_file_bytes: self.max_mesh_mb << 20, folders: folders.cloned().collect() }
    }

    /// As [`options`](Self::options), for a program that a user runs with own files: meshes may lie beside these, too.
    pub(crate) fn options_beside(&self, files: &[&Path]) -> ResourceOptions {
        let mut options = self.options();
        // A name without a folder is in the working directory.
        let folder = |file: &&Path| match file.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
            _ => PathBuf::from("."),
        };
        options.folders.extend(files.iter().map(folder));
        options
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::options::prediction::Lead;

    fn options(args: &[&str]) -> Result<Options, String> {
        let words = [&["camera_stream", "-d", "x.rviz"], args].concat();
        let cli = Cli::try_parse_from(words).map_err(|error| error.to_string())?;
        let cameras = ["Left", "Right"].map(str::to_owned).to_vec();
        let displays = ["markers", "path", "robot"].map(str::to_owned).to_vec();
        Options::of_command_line(&cli, &ConfigNames { cameras, displays }).map_err(|error| error.to_string())
    }

    #[test]
    fn a_value_that_names_no_camera_is_refused_with_the_cameras() {
        for option in ["--window", "--mask-topic", "--mask", "--blend", "--orientation", "--surface"] {
            let error = options(&[option, "Lef=90"]).unwrap_err();
            let expected =
                format!("invalid value 'Lef=90' for {option}: the config has no camera 'Lef'; cameras: Left, Right");
            assert_eq!(error, expected);
        }
        assert!(options(&["--keep-out", "head=0"]).unwrap_err().starts_with("invalid value 'head=0' for --keep-out: "));
    }

    #[test]
    fn a_display_to_confirm_is_one_of_the_config_and_needs_a_surface() {
        let error = options(&["--surface", "/depth", "--confirm", "markrs"]).unwrap_err();
        let expected =
            "invalid value 'markrs' for --confirm: the config has no display 'markrs'; did you mean 'markers'? \
                        displays: markers, path, robot";
        assert_eq!(error, expected);
        let error = options(&["--confirm", "markers"]).unwrap_err();
        assert!(error.contains("it needs --surface as well"), "{error}");
        let mixed = options(&["--surface", "/depth", "--confirm", "all", "--confirm", "path"]).unwrap_err();
        assert!(mixed.contains("all and none stand alone"), "{mixed}");
        let confirm = |args: &[&str]| options(&[&["--surface", "Left=/depth"], args].concat()).unwrap().light.confirm;
        assert_eq!(confirm(&[]).displays, ConfirmedDisplays::All);
        assert_eq!(confirm(&["--confirm", "path"]).displays, ConfirmedDisplays::Named(vec!["path".to_owned()]));
        assert!(confirm(&["--confirm", "none"]).surfaces.is_empty() && confirm(&[]).surfaces.len() == 1);
    }

    #[test]
    fn none_is_no_value() {
        let lists = [
            "--window",
            "--mask-topic",
            "--mask",
            "--blend",
            "--orientation",
            "--keep-out",
            "--stale-timeouts",
            "--surface",
        ];
        let single = ["--fixed-frame", "--stale-timeout", "--predict", "--mesh-folder", "--web", "--web-hosts"];
        let args: Vec<&str> = lists.iter().chain(&single).flat_map(|option| [*option, "none"]).collect();
        let (all, default) = (options(&args).unwrap(), options(&[]).unwrap());
        assert_eq!(all.node.prediction, default.node.prediction);
        let all = Options { node: default.node.clone(), ..all };
        assert_eq!(format!("{all:?}"), format!("{default:?}"));
        assert_eq!((all.fixed_frame, all.node.prediction.lead), (None, Lead::Off));
        assert_eq!(options(&["-f", ""]).unwrap().fixed_frame, None, "as for rviz");
        assert!(all.windows.is_empty() && options(&["--window", "Left=none"]).unwrap().windows.is_empty());
    }

    #[test]
    fn of_a_switch_and_its_opposite_the_last_counts() {
        let switches = |args: &[&str]| {
            let Options { node, model, .. } = options(args).unwrap();
            let NodeArgs { light, windows, watches_config, is_lazy, .. } = node;
            assert!(!light.blackout);
            ([is_lazy, watches_config, light.is_mask_required], [windows.set_mode, light.stale_note, model.undistort])
        };
        assert_eq!(switches(&[]), ([true; 3], [false; 3]));
        let changed = ["--no-lazy", "--no-watch", "--no-mask-required", "--set-mode", "--stale-note", "--undistort"];
        let undone = ["--lazy", "--watch", "--mask-required", "--no-set-mode", "--no-stale-note", "--no-undistort"];
        assert_eq!(switches(&changed), ([false; 3], [true; 3]));
        assert_eq!(switches(&[changed, undone].concat()), switches(&[]));
        assert_eq!(switches(&[undone, changed].concat()), switches(&changed));
    }

    #[test]
    fn the_size_of_meshes_has_bounds_and_folders_add_up() {
        assert_eq!(options(&["--max-mesh-mb", "2"]).unwrap().resources.max_file_bytes, 2 << 20);
        assert_eq!(options(&[]).unwrap().resources.max_file_bytes, ResourceOptions::default().max_file_bytes);
        for wrong in ["0", "4097", "-1", "1.5", "much"] {
            assert!(options(&["--max-mesh-mb", wrong]).is_err(), "{wrong}");
        }
        let args = ["camera_stream", "render", "--bag", "/b/x.bag", "-d", "x.rviz", "-o", "a.png"];
        let folders = ["--mesh-folder", "/a", "--mesh-folder", "/c"];
        let cli = Cli::try_parse_from([&args[..], &folders].concat()).unwrap();
        let options = cli.drawing().resources.options_beside(&[Path::new("x.rviz"), Path::new("/b/x.bag")]);
        assert_eq!(options.folders, ["/a", "/c", ".", "/b"].map(PathBuf::from));
    }
}
