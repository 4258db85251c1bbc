//! Options that may be given on the command line or as private ROS parameters; the command line wins.

use std::str::FromStr;

use anyhow::{anyhow, Result};
use clap::ValueEnum;
use rcs_render::RendererChoice;
use rcs_ros::RosNode;

use crate::camera_stream::camera_pose::Projection;

/// What draws: `--renderer`, else `~renderer`.
///
/// # Errors
/// When the parameter has no valid value; names the parameter.
pub(crate) fn renderer(ros: &RosNode, given: Option<RendererChoice>) -> Result<RendererChoice> {
    choose(ros, given, &["~renderer"], RendererChoice::from_str)
}

/// The projection: `--projection`, else the first of these parameters that is set.
///
/// # Errors
/// When the parameter has no valid value; names the parameter.
pub(crate) fn projection(ros: &RosNode, given: Option<Projection>, parameters: &[&str]) -> Result<Projection> {
    choose(ros, given, parameters, |text| Projection::from_str(text, true))
}

fn choose<T: Default>(
    ros: &RosNode,
    given: Option<T>,
    parameters: &[&str],
    parse: impl Fn(&str) -> Result<T, String>,
) -> Result<T> {
    if let Some(given) = given {
        return Ok(given);
    }
    let set = parameters.iter().find_map(|name| Some((name, ros.string_param(name)?)));
    set.map_or_else(
        || Ok(T::default()),
        |(name, text)| parse(&text).map_err(|error| anyhow!("parameter {name}: {error}")),
    )
}
