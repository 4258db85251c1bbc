//! The arguments of `camera_stream setup`, and the form of each answer.

use std::path::PathBuf;

use clap::Args;
use rcs_files::sizes::size_px;
use rcs_node_support::key_value;
use rcs_text::topic_name;

use crate::display_type::{self, DisplayType};
use crate::profile::Profile;

/// Answer for a camera or a monitor that is not there.
pub(crate) const NONE: &str = "none";

/// The arguments of `setup`.
#[derive(Args, Clone, Debug)]
pub struct SetupArgs {
    /// The folder to write; made if it does not exist
    #[arg(value_name = "FOLDER")]
    pub folder: PathBuf,
    /// Mount of the projector: a Fetch's torso, a stand or ceiling, another robot, or a robot with the
    /// projector at another computer
    #[arg(long, value_name = "fetch|fixed|mobile|two-computers", value_parser = Profile::parse)]
    pub profile: Option<Profile>,
    /// Link that the projector is mounted on [default: torso_lift_link (fetch); map or base_link (fixed)]
    #[arg(long, value_name = "FRAME", value_parser = frame)]
    pub mount: Option<String>,
    /// Fixed frame of the scene [default: base_link (fetch); the mount (fixed); else map, odom or base_link]
    #[arg(long, value_name = "FRAME", value_parser = frame)]
    pub fixed_frame: Option<String>,
    /// Native resolution of the projector [default: that of the monitor]
    #[arg(long, value_name = "WxH", value_parser = size_px)]
    pub size: Option<[u32; 2]>,
    /// Monitor that the projector is, or auto [default: the last that is not the primary, else auto]
    #[arg(long, value_name = "NAME", value_parser = monitor)]
    pub monitor: Option<String>,
    /// Colour image of the depth camera that calibrates, or none [default: a Fetch's head camera, else what is found]
    #[arg(long, value_name = "TOPIC", value_parser = image)]
    pub image: Option<String>,
    /// Depth image that is registered to it, or none [default: a Fetch's head camera, else what is found]
    #[arg(long, value_name = "TOPIC", value_parser = image)]
    pub depth: Option<String>,
    /// Topics to project, each with its type if nobody publishes it yet [default: a Fetch's detections, path and
    /// markers, else the results that are published]
    #[arg(long, value_name = "TOPIC[=TYPE]", num_args = 1.., value_parser = show)]
    pub show: Vec<Show>,
    /// Project a grid on the fixed frame's floor and the names of the frames, lit at once, before anything is detected
    #[arg(long = "try")]
    pub is_try: bool,
    /// Replace the files of an earlier setup; a calibrated projector.yaml is kept
    #[arg(long)]
    pub overwrite: bool,
}

/// A topic to project, as a user names it.
#[derive(Clone, Debug, PartialEq)]
pub struct Show {
    /// Whole name.
    pub(crate) topic: String,
    /// Its display, if the type is given.
    pub(crate) display: Option<&'static DisplayType>,
}

/// Checks a word that stands in launch and YAML files: letters, digits and a few signs.
pub(crate) fn plain(text: &str, signs: &str) -> Result<(), String> {
    match text.chars().find(|letter| !letter.is_alphanumeric() && !signs.contains(*letter)) {
        None => Ok(()),
        Some(letter) => Err(format!("'{text}' contains {letter:?}: use letters, digits and {signs}")),
    }
}

/// A frame's name, without the slash in front that tf2 does not allow.
pub(crate) fn frame(text: &str) -> Result<String, String> {
    let name = text.strip_prefix('/').unwrap_or(text);
    if name.is_empty() {
        return Err("a frame needs a name".to_owned());
    }
    plain(name, "_-./").map(|()| name.to_owned())
}

/// A monitor's name or number, or `auto`.
pub(crate) fn monitor(text: &str) -> Result<String, String> {
    if text.is_empty() {
        return Err("a monitor's name, or auto".to_owned());
    }
    plain(text, "_-.").map(|()| text.to_owned())
}

/// A topic of images, or `none`.
pub(crate) fn image(text: &str) -> Result<String, String> {
    if text == NONE {
        return Ok(text.to_owned());
    }
    topic_name(text)
}

/// `TOPIC` or `TOPIC=TYPE`.
pub(crate) fn show(text: &str) -> Result<Show, String> {
    let (topic, display) = match key_value::split(text) {
        Some((topic, name)) => (topic, Some(display_type::find(name)?)),
        None => (text, None),
    };
    Ok(Show { topic: topic_name(topic)?, display })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_topic_may_have_its_type() {
        let parsed = show("clouds=PointCloud2").unwrap();
        assert_eq!((&*parsed.topic, parsed.display.unwrap().class), ("/clouds", "rviz/PointCloud2"));
        assert_eq!(show("/a/b").unwrap(), Show { topic: "/a/b".to_owned(), display: None });
        for text in ["", "/a b", "/a=Joy", "/a=", "=Path"] {
            assert!(show(text).is_err(), "{text}");
        }
    }

    #[test]
    fn names_can_stand_in_launch_files() {
        assert_eq!(frame("/head_link"), Ok("head_link".to_owned()));
        for text in ["", "/", "a b", "$(env HOME)", "a\"", "<x>"] {
            assert!(frame(text).is_err(), "{text}");
        }
        assert!(monitor("HDMI-A-1").is_ok() && monitor("").is_err() && monitor("a b").is_err());
        assert_eq!(image("none"), Ok("none".to_owned()));
        assert_eq!(image("rgb/image_raw"), Ok("/rgb/image_raw".to_owned()));
    }
}
