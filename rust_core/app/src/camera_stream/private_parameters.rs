//! Options that may be given on the command line or as private ROS parameters; the command line wins.

use std::path::PathBuf;
use std::str::FromStr;

use anyhow::{anyhow, Result};
use clap::ValueEnum;
use rcs_render::RendererChoice;
use rcs_resources::ResourceOptions;
use rcs_ros::RosNode;

use crate::camera_stream::camera_pose::{CameraModel, Projection};
use crate::camera_stream::cli::{ModelArgs, ResourceArgs, MESH_MB};
use crate::camera_stream::window_arguments::ScreenArgs;

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
    let undistort = choose(ros, given.undistort.then_some(true), &names("undistort"), |text| match text {
        "true" | "1" => Ok(true),
        "false" | "0" => Ok(false),
        _ => Err(format!("{text} is not true or false")),
    })?;
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
    if args.max_mesh_mb.is_none() && ros.has_param(SIZE) {
        let size = ros.int_param(SIZE).and_then(|size| u64::try_from(size).ok()).filter(|size| MESH_MB.contains(size));
        args.max_mesh_mb = Some(size.ok_or_else(|| anyhow!("parameter {SIZE}: {}", ResourceArgs::SIZE_RANGE))?);
    }
    if ros.has_param(FOLDERS) {
        let folders = ros.strings_param(FOLDERS);
        let folders = folders.ok_or_else(|| anyhow!("parameter {FOLDERS}: it is a list of folders"))?;
        args.mesh_folder.extend(folders.into_iter().map(PathBuf::from));
    }
    Ok(args.options())
}

/// The node's windows: `--window`, else `~window`, one or a list; `--set-mode` or `~set_mode`.
///
/// # Errors
/// When a parameter has no valid value; names the parameter.
pub(crate) fn windows(ros: &RosNode, given: &ScreenArgs) -> Result<ScreenArgs> {
    const WINDOW: &str = "~window";
    let mut args = given.clone();
    args.set_mode |= ros.bool_param("~set_mode").unwrap_or(false);
    if args.windows.is_empty() && ros.has_param(WINDOW) {
        // A monitor's number is no string.
        let texts = ros.strings_param(WINDOW).or_else(|| Some(vec![ros.text_param(WINDOW)?]));
        let texts = texts.ok_or_else(|| anyhow!("parameter {WINDOW}: it is MONITOR, or a list of CAMERA=MONITOR"))?;
        args.windows = texts.iter().flat_map(|text| text.parse()).collect();
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
    let text = |name: &str| if name.starts_with('~') { ros.text_param(name) } else { ros.other_text_param(name) };
    let set = parameters.iter().map(AsRef::as_ref).find_map(|name| Some((name, text(name)?)));
    set.map(|(name, text)| parse(&text).map_err(|error| anyhow!("parameter {name}: {error}"))).transpose()
}
