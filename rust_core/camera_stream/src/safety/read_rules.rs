//! Reads the files of the light's rules, and subscribes to masks and surfaces.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context, Result};
use rcs_files::blend_file::BlendFile;
use rcs_messages::MessageKind;
use rcs_node_support::user_file;
use rcs_render::Blend;
use rcs_ros::{RosNode, TopicSubscription};

use crate::options::{ConfirmOptions, Options};
use crate::safety::ages::limits::AgeLimits;
use crate::safety::eyes::MaskPublishers;
use crate::safety::names::ForCamera;
use crate::safety::painted_mask;
use crate::safety::rules::Rules;
use crate::safety::surface::{ConfirmRules, SurfaceTopics};

/// The subscriptions to masks and surfaces.
pub(crate) struct LightTopics {
    masks: Vec<TopicSubscription>,
    pub(crate) surfaces: SurfaceTopics,
}

impl LightTopics {
    /// The publishers of a mask's topic: those that are connected, and those that the master lists.
    pub(crate) fn publishers(&self, ros: &RosNode, topic: &str) -> MaskPublishers {
        let masks = self.masks.iter().filter(|mask| &**mask.topic() == topic);
        let mut names: BTreeSet<Arc<str>> = masks.flat_map(TopicSubscription::connected_publishers).collect();
        let publications = ros.dated_publications();
        let listed = publications.as_ref().and_then(|(_, all)| all.get(topic));
        names.extend(listed.into_iter().flat_map(|listed| &listed.nodes).map(|node| node.as_str().into()));
        MaskPublishers { names, listed_at: publications.map(|(at, _)| at) }
    }
}

/// Reads the files of the rules, and subscribes to masks. Surfaces are subscribed to when they have publishers.
///
/// # Errors
/// A file that cannot be read, a topic that cannot be subscribed to.
pub(crate) fn read(ros: &RosNode, options: &Options) -> Result<(Rules, LightTopics)> {
    let (args, light) = (&options.node.light, &options.light);
    let mut mask_topics = light.mask_topics.clone();
    let mut masks = Vec::new();
    for ForCamera { value: topic, .. } in &mut mask_topics {
        let subscription = ros.subscribe(topic, MessageKind::Image, 1)?;
        *topic = subscription.topic().to_string();
        masks.push(subscription);
    }
    let mut surfaces = SurfaceTopics::default();
    let ConfirmOptions { surfaces: mut surface_topics, displays, settings } = light.confirm.clone();
    for ForCamera { value: topic, .. } in &mut surface_topics {
        *topic = surfaces.add(ros, topic)?;
    }
    let read_mask = |ForCamera { camera, value: path }: &ForCamera<PathBuf>| -> Result<_> {
        Ok(ForCamera { camera: camera.clone(), value: Arc::new(painted_mask(path)?) })
    };
    let blend = |file: &ForCamera<PathBuf>| read_blend(file, args.blend_gamma);
    let rules = Rules {
        limits: age_limits(ros, options)?,
        orientations: light.orientations.clone(),
        blends: light.blends.iter().map(blend).collect::<Result<_>>()?,
        painted_masks: light.masks.iter().map(read_mask).collect::<Result<_>>()?,
        mask_topics,
        keep_out: light.keep_out.clone(),
        is_required: args.is_mask_required,
        confirm: ConfirmRules { surfaces: surface_topics, displays, settings },
    };
    Ok((rules, LightTopics { masks, surfaces }))
}

/// The limits of the age of data, with the topics' whole names.
///
/// # Errors
/// A topic whose name ROS does not allow.
pub(crate) fn age_limits(ros: &RosNode, options: &Options) -> Result<AgeLimits> {
    let mut limits = AgeLimits::off();
    limits.has_note = options.node.light.stale_note;
    let mut timeouts = options.light.stale_timeouts.iter().cloned();
    timeouts.try_for_each(|timeout| limits.set(timeout, |topic| ros.resolve(topic)))?;
    Ok(limits)
}

/// Reads a camera's weights.
fn read_blend(ForCamera { camera, value: path }: &ForCamera<PathBuf>, gamma: f32) -> Result<ForCamera<Arc<Blend>>> {
    user_file::check(path)?;
    let BlendFile { size_px, weights, lifts } = BlendFile::read(path)?;
    let blend = Blend::new(size_px, &weights, &lifts, gamma).with_context(|| path.display().to_string())?;
    Ok(ForCamera { camera: camera.clone(), value: Arc::new(blend) })
}
