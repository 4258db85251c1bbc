//! Reads the [rules](super::rules) from the command line and the private parameters, and subscribes to masks.

use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;

use anyhow::{anyhow, Context, Result};
use rcs_files::blend_file::BlendFile;
use rcs_messages::MessageKind;
use rcs_render::Blend;
use rcs_ros::{RosNode, TopicSubscription};

use crate::cli::NodeArgs;
use crate::light_arguments::{Gamma, StaleArgs};
use crate::private_parameters::{blend_gamma, flag, strings, switch};
use crate::safety::ages::limits::{AgeLimit, AgeLimits, StaleTimeout};
use crate::safety::ages::TopicSource;
use crate::safety::names::{CameraValue, ForCamera};
use crate::safety::painted_mask;
use crate::safety::rules::Rules;

/// The subscriptions to masks.
pub(crate) struct MaskTopics(Vec<TopicSubscription>);

impl MaskTopics {
    /// The publishers of a mask's topic, by its whole name.
    pub(crate) fn source(&self, topic: &str) -> Option<TopicSource> {
        let found = self.0.iter().find(|subscription| &**subscription.topic() == topic)?;
        Some(TopicSource { topic: topic.to_owned(), publishing: found.publishing() })
    }
}

/// Reads the rules for a config with these cameras.
///
/// # Errors
/// A parameter without a valid value, a camera that the config does not have, a file that cannot be read, a topic that
/// cannot be subscribed to.
pub(crate) fn read(ros: &RosNode, args: &NodeArgs, cameras: &[String]) -> Result<(Rules, MaskTopics)> {
    let mut mask_topics = for_cameras::<String>(ros, &args.eye_safety.mask_topic, "mask_topic", cameras)?;
    let mut subscriptions = Vec::new();
    for ForCamera { value: topic, .. } in &mut mask_topics {
        let subscription = ros.subscribe(topic, MessageKind::Image, 1)?;
        *topic = subscription.topic().to_string();
        subscriptions.push(subscription);
    }
    let gamma = blend_gamma(ros, args.blend.blend_gamma)?;
    let blends = for_cameras::<PathBuf>(ros, &args.blend.blend, "blend", cameras)?;
    let painted = for_cameras::<PathBuf>(ros, &args.blend.mask, "mask", cameras)?;
    let read_mask = |ForCamera { camera, value: path }: ForCamera<PathBuf>| -> Result<_> {
        Ok(ForCamera { camera, value: Arc::new(painted_mask(&path)?) })
    };
    let rules = Rules {
        limits: limits(ros, &args.stale)?,
        orientations: for_cameras(ros, &args.mounting.orientation, "orientation", cameras)?,
        blends: blends.into_iter().map(|file| read_blend(file, gamma)).collect::<Result<_>>()?,
        painted_masks: painted.into_iter().map(read_mask).collect::<Result<_>>()?,
        mask_topics,
        keep_out: values(ros, &args.eye_safety.keep_out, "~keep_out")?,
        is_required: switch(ros, args.eye_safety.mask_required, "~mask_required")?.unwrap_or(true),
    };
    Ok((rules, MaskTopics(subscriptions)))
}

/// Reads the values of an option with `CAMERA=`, or of its parameter where there are none.
fn for_cameras<T: CameraValue>(
    ros: &RosNode,
    given: &[String],
    name: &str,
    cameras: &[String],
) -> Result<Vec<ForCamera<T>>> {
    if given.is_empty() {
        let texts = ros.texts_param(&format!("~{name}"))?;
        return ForCamera::read_all(&texts, cameras).map_err(|error| anyhow!("parameter ~{name}: {error}"));
    }
    ForCamera::read_all(given, cameras).map_err(|error| anyhow!("--{}: {error}", name.replace('_', "-")))
}

/// Reads values from the command line, and from a parameter where there are none.
fn values<T: FromStr<Err = String> + Clone>(ros: &RosNode, given: &[T], parameter: &str) -> Result<Vec<T>> {
    if !given.is_empty() {
        return Ok(given.to_vec());
    }
    let read = |text: String| text.parse().map_err(|error| anyhow!("parameter {parameter}: {error}"));
    ros.texts_param(parameter)?.into_iter().map(read).collect()
}

/// The limits of the command line, else of the node's parameters.
fn limits(ros: &RosNode, args: &StaleArgs) -> Result<AgeLimits> {
    const GENERAL: &str = "~stale_timeout";
    const TOPICS: &str = "~stale_timeouts";
    let mut limits = AgeLimits::off();
    let mut set = |timeout| limits.set(timeout, |topic| ros.resolve(topic));
    if let Some(text) = ros.text_param(GENERAL)? {
        match text.parse() {
            Ok(AgeLimit::Held) | Err(_) => return Err(anyhow!("parameter {GENERAL}: seconds from 0 (off) to 86400")),
            Ok(limit) => set(StaleTimeout { topic: None, limit })?,
        }
    }
    for text in strings(ros, TOPICS)? {
        set(text.parse().map_err(|error| anyhow!("parameter {TOPICS}: {error}"))?)?;
    }
    args.stale_timeout.iter().cloned().try_for_each(set)?;
    limits.has_note = flag(ros, args.stale_note, "~stale_note")?;
    Ok(limits)
}

/// Reads a camera's weights.
fn read_blend(
    ForCamera { camera, value: path }: ForCamera<PathBuf>,
    Gamma(gamma): Gamma,
) -> Result<ForCamera<Arc<Blend>>> {
    let BlendFile { size_px, weights, lifts } = BlendFile::read(&path)?;
    let blend = Blend::new(size_px, &weights, &lifts, gamma).with_context(|| path.display().to_string())?;
    Ok(ForCamera { camera, value: Arc::new(blend) })
}
