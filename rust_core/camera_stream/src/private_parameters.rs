//! Options that may be given on the command line or as private ROS parameters; the command line wins.

use std::path::PathBuf;
use std::str::FromStr;

use anyhow::{anyhow, Result};
use clap::ValueEnum;
use rcs_camera::{CameraModel, Projection};
use rcs_render::RendererChoice;
use rcs_resources::ResourceOptions;
use rcs_ros::RosNode;

use crate::cli::{mesh_mb, ModelArgs, ResourceArgs};
use crate::light_arguments::Gamma;
use crate::outputs::depth_image::DepthEncoding;
use crate::window_arguments::ScreenArgs;
use rcs_node_support::node_options::yes_or_no;

/// What draws: `--renderer`, else `~renderer`.
///
/// # Errors
/// When the parameter has no valid value; names the parameter.
pub(crate) fn renderer(ros: &RosNode, given: Option<RendererChoice>) -> Result<RendererChoice> {
    Ok(choose(ros, given, &["~renderer"], RendererChoice::from_str)?.unwrap_or_default())
}

/// How CameraInfos become pictures: `--projection`, else `~projection`; `--undistort` or `~undistort`. Parameters that
/// are not set are those of another node where one is given.
///
/// # Errors
/// When a parameter has no valid value; names the parameter.
pub(crate) fn camera_model(ros: &RosNode, given: &ModelArgs, other_node: Option<&str>) -> Result<CameraModel> {
    let names = |name: &str| {
        let of_other = other_node.map(|node| format!("{node}/{name}"));
        std::iter::once(format!("~{name}")).chain(of_other).collect::<Vec<_>>()
    };
    let projection = choose(ros, given.projection, &names("projection"), |text| Projection::from_str(text, true))?;
    let undistort = choose(ros, given.undistort.then_some(true), &names("undistort"), yes_or_no)?;
    Ok(CameraModel { projection: projection.unwrap_or_default(), undistort: undistort.unwrap_or_default() })
}

/// Which mesh files may be read: `--max-mesh-mb`, else `~max_mesh_mb`; the folders of `--mesh-folder` and
/// `~mesh_folders`.
///
/// # Errors
/// When a parameter has no valid value; names the parameter.
pub(crate) fn resources(ros: &RosNode, given: &ResourceArgs) -> Result<ResourceOptions> {
    const SIZE: &str = "~max_mesh_mb";
    const FOLDERS: &str = "~mesh_folders";
    let mut args = given.clone();
    args.max_mesh_mb = choose(ros, args.max_mesh_mb, &[SIZE], mesh_mb)?;
    if ros.has_param(FOLDERS) {
        let folders = ros.strings_param(FOLDERS);
        let folders = folders.ok_or_else(|| anyhow!("parameter {FOLDERS}: it is a list of folders"))?;
        args.mesh_folder.extend(folders.into_iter().map(PathBuf::from));
    }
    Ok(args.options())
}

/// A switch that is on by an option or by its parameter.
///
/// # Errors
/// When the parameter is neither true nor false; names the parameter.
pub(crate) fn flag(ros: &RosNode, given: bool, parameter: &str) -> Result<bool> {
    Ok(switch(ros, given.then_some(true), parameter)?.unwrap_or_default())
}

/// The gamma of the projectors: `--blend-gamma`, else `~blend_gamma`.
///
/// # Errors
/// When the parameter has no valid value; names the parameter.
pub(crate) fn blend_gamma(ros: &RosNode, given: Option<Gamma>) -> Result<Gamma> {
    Ok(choose(ros, given, &["~blend_gamma"], str::parse)?.unwrap_or_default())
}

/// How depths are written: `--depth-encoding`, else `~depth_encoding`.
///
/// # Errors
/// When the parameter has no valid value; names the parameter.
pub(crate) fn depth_encoding(ros: &RosNode, given: Option<DepthEncoding>) -> Result<DepthEncoding> {
    Ok(choose(ros, given, &["~depth_encoding"], str::parse)?.unwrap_or_default())
}

/// A parameter's list of strings; empty where it is not set.
///
/// # Errors
/// When the parameter is something else; names the parameter.
pub(crate) fn strings(ros: &RosNode, parameter: &str) -> Result<Vec<String>> {
    if !ros.has_param(parameter) {
        return Ok(Vec::new());
    }
    ros.strings_param(parameter).ok_or_else(|| anyhow!("parameter {parameter}: it is a list of strings"))
}

/// A switch by an option, else by its parameter; none where neither is given.
///
/// # Errors
/// When the parameter is neither true nor false; names the parameter.
pub(crate) fn switch(ros: &RosNode, given: Option<bool>, parameter: &str) -> Result<Option<bool>> {
    choose(ros, given, &[parameter], yes_or_no)
}

/// The node's windows: `--window`, else `~window`, one or a list; `--set-mode` or `~set_mode`.
///
/// # Errors
/// When a parameter has no valid value; names the parameter.
pub(crate) fn windows(ros: &RosNode, given: &ScreenArgs) -> Result<ScreenArgs> {
    const WINDOW: &str = "~window";
    let mut args = given.clone();
    args.set_mode = flag(ros, args.set_mode, "~set_mode")?;
    if args.windows.is_empty() && ros.has_param(WINDOW) {
        // A monitor's number is no string.
        args.windows = ros.texts_param(WINDOW)?;
    }
    Ok(args)
}

/// What is given, else what the first of the parameters that is set says, if any is.
///
/// # Errors
/// When that parameter has no valid value; names the parameter.
pub(crate) fn choose<T>(
    ros: &RosNode,
    given: Option<T>,
    parameters: &[impl AsRef<str>],
    parse: impl Fn(&str) -> Result<T, String>,
) -> Result<Option<T>> {
    if given.is_some() {
        return Ok(given);
    }
    for name in parameters.iter().map(AsRef::as_ref) {
        let text = if name.starts_with('~') { ros.text_param(name) } else { ros.other_text_param(name) };
        if let Some(text) = text? {
            return parse(&text).map(Some).map_err(|error| anyhow!("parameter {name}: {error}"));
        }
    }
    Ok(None)
}
