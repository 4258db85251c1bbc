//! What is done to each camera's finished pictures: where light is forbidden, and how the projector is mounted.
//!
//! Light is forbidden by masks, images on topics, and around frames. Both age like the data of displays
//! ([`super::freshness`]), after a second where nothing else is set. What is missing or too old makes all black, unless
//! `~mask_required` is false: then the last mask and the last place hold.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use anyhow::{anyhow, Context, Result};
use rcs_camera::NoLens;
use rcs_displays::{time_from_stamp, ShownMessage};
use rcs_files::blend_file::BlendFile;
use rcs_messages::{AnyMessage, MessageKind};
use rcs_render::{Blend, KeepOut, LastStep, LightMask, Orientation, Sphere};
use rcs_ros::{NodeEvent, RosNode, TopicSubscription};
use rcs_scene::Camera;

use super::freshness::limits::Limits;
use super::freshness::{Freshness, Now, State};
use crate::camera_stream::cli::NodeArgs;
use crate::camera_stream::light_arguments::{of_camera, ForCamera, Gamma, KeepOutFrame};
use crate::camera_stream::mask_image::{light_mask, painted_mask};
use crate::camera_stream::private_parameters::{blend_gamma, switch, texts};
use crate::camera_stream::stage::Stage;
use crate::camera_stream::subscriptions::Source;

/// When masks and keep-out frames are too old, where no other limit is set for all topics.
const EYE_SAFETY_LIMIT: Duration = Duration::from_secs(1);

/// The last steps of all cameras.
pub(super) struct LastSteps {
    orientations: Vec<ForCamera<Orientation>>,
    blends: Vec<ForCamera<Arc<Blend>>>,
    /// Those of files.
    painted_masks: Vec<ForCamera<Arc<LightMask>>>,
    mask_topics: Vec<ForCamera<String>>,
    /// By the topic's whole name.
    masks: BTreeMap<String, Mask>,
    keep_out: Vec<KeepOutFrame>,
    is_required: bool,
    freshness: Option<Freshness>,
}

/// A topic of masks, and the last of them.
struct Mask {
    subscription: TopicSubscription,
    last: Option<Arc<LightMask>>,
    received: Option<ShownMessage>,
    /// Why the last message is no mask.
    problem: Option<String>,
    state: State,
}

/// The last step of a camera at one moment.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct CameraStep {
    pub(super) step: Arc<LastStep>,
    /// Why there must be no light at all.
    pub(super) dark: Option<String>,
    /// Until when that holds if nothing new arrives.
    pub(super) until: Option<std::time::Instant>,
}

/// Where a camera's pictures send light.
pub(super) struct LitView<'a> {
    /// The camera's name.
    pub(super) name: &'a str,
    /// Its directions; none for one that cannot draw, or where they do not matter.
    pub(super) camera: Option<&'a Camera>,
    /// Why the directions may be others.
    pub(super) unknown_lens: Option<NoLens>,
}

/// Reads values from the command line, and from a parameter where there are none.
fn values<T: std::str::FromStr<Err = String> + Clone>(ros: &RosNode, given: &[T], parameter: &str) -> Result<Vec<T>> {
    if !given.is_empty() {
        return Ok(given.to_vec());
    }
    let read = |text: String| text.parse().map_err(|error| anyhow!("parameter {parameter}: {error}"));
    texts(ros, parameter)?.into_iter().map(read).collect()
}

impl LastSteps {
    /// Reads what the command line and the parameters ask for, and subscribes to masks.
    ///
    /// # Errors
    /// A parameter without a valid value, or a topic that cannot be subscribed to.
    pub(super) fn start(ros: &RosNode, args: &NodeArgs) -> Result<Self> {
        let mut mask_topics = values(ros, &args.eye_safety.mask_topic, "~mask_topic")?;
        let mut masks = BTreeMap::new();
        for ForCamera { value: topic, .. } in &mut mask_topics {
            let subscription = ros.subscribe(topic, MessageKind::Image, 1)?;
            *topic = subscription.topic().to_string();
            let (last, received, problem, state) = (None, None, None, State::Undated);
            masks.insert(topic.clone(), Mask { subscription, last, received, problem, state });
        }
        let limits = Limits::read(ros, &args.stale)?.or_after(EYE_SAFETY_LIMIT);
        let gamma = blend_gamma(ros, args.blend.blend_gamma)?;
        let files = values(ros, &args.blend.blend, "~blend")?;
        let painted = values(ros, &args.blend.mask, "~mask")?;
        let read_mask = |ForCamera { camera, value: path }: ForCamera<PathBuf>| -> Result<_> {
            Ok(ForCamera { camera, value: Arc::new(painted_mask(&path)?) })
        };
        Ok(Self {
            blends: files.into_iter().map(|file| read_blend(file, gamma)).collect::<Result<_>>()?,
            painted_masks: painted.into_iter().map(read_mask).collect::<Result<_>>()?,
            orientations: values(ros, &args.mounting.orientation, "~orientation")?,
            mask_topics,
            masks,
            keep_out: values(ros, &args.eye_safety.keep_out, "~keep_out")?,
            is_required: switch(ros, args.eye_safety.mask_required, "~mask_required")?.unwrap_or(true),
            freshness: Freshness::new(limits),
        })
    }

    /// How a camera's pictures are turned.
    pub(super) fn orientation(&self, camera: &str) -> Orientation {
        of_camera(&self.orientations, camera).copied().unwrap_or_default()
    }

    /// Whether light is forbidden somewhere for the sake of eyes.
    pub(super) fn protects_eyes(&self) -> bool {
        !self.masks.is_empty() || !self.keep_out.is_empty()
    }

    /// Whether pictures stay as they are drawn, all of them and always.
    pub(super) fn is_nothing(&self) -> bool {
        self.orientations.is_empty() && self.blends.is_empty() && self.painted_masks.is_empty() && !self.protects_eyes()
    }

    /// Takes what is new in an event.
    pub(super) fn take(&mut self, event: &NodeEvent) {
        match event {
            NodeEvent::Message { topic, message: AnyMessage::Image(image), received, .. } => {
                let Some(mask) = self.masks.get_mut(&**topic) else { return };
                let problem = match light_mask(image) {
                    Ok(light) => {
                        // One that says the same again keeps pictures that were drawn with it.
                        if mask.last.as_deref() != Some(&light) {
                            mask.last = Some(Arc::new(light));
                        }
                        let stamp = time_from_stamp(image.header.stamp);
                        mask.received = Some(ShownMessage { stamp, received: Some(*received) });
                        None
                    }
                    Err(problem) => Some(format!("mask on {topic}: {problem}")),
                };
                if let Some(problem) = problem.as_ref().filter(|problem| mask.problem.as_ref() != Some(problem)) {
                    log::error!("{problem}");
                }
                mask.problem = problem;
            }
            NodeEvent::TimeJumpedBack { .. } => self.freshness.iter_mut().for_each(Freshness::reset),
            _ => {}
        }
    }

    /// Looks at how old the masks are.
    fn look_at_masks(&mut self, now: Now) {
        let Some(freshness) = &mut self.freshness else { return };
        for (topic, mask) in &mut self.masks {
            let source = || Source { topic: topic.clone(), publishing: mask.subscription.publishing() };
            mask.state = match (mask.received, &mask.problem) {
                (None, Some(problem)) => State::Stale(problem.clone()),
                (None, None) => State::Stale(format!("no mask on {topic} yet")),
                (Some(received), _) => {
                    let topics = [(topic.as_str(), MessageKind::Image)];
                    freshness.data("mask", topics, received, &|_, _| Some(source()), now)
                }
            };
        }
    }

    /// The last step of each camera, in their order.
    pub(super) fn assess<'v>(
        &mut self,
        views: impl Iterator<Item = LitView<'v>>,
        stage: &Stage,
        now: Now,
    ) -> Vec<CameraStep> {
        self.look_at_masks(now);
        let (spheres, around) = self.spheres(stage, now);
        views.map(|view| self.of_view(view, &spheres, &around)).collect()
    }

    fn of_view(&self, view: LitView<'_>, spheres: &[Sphere], around: &State) -> CameraStep {
        let LitView { name, camera, unknown_lens } = view;
        let mask = of_camera(&self.mask_topics, name).and_then(|topic| self.masks.get(topic));
        let lens = unknown_lens.filter(|_| !spheres.is_empty()).map_or(State::Undated, |why| {
            State::Stale(format!("where the lens sends light around keep-out frames is not known: {why}"))
        });
        let state = mask.map_or(State::Undated, |mask| mask.state.clone()).and(around.clone()).and(lens);
        let step = LastStep {
            mask: mask.and_then(|mask| mask.last.clone()),
            keep_out: camera.and_then(|camera| KeepOut::new(camera, spheres)),
            orientation: self.orientation(name),
            blend: of_camera(&self.blends, name).cloned(),
            painted_mask: of_camera(&self.painted_masks, name).cloned(),
        };
        let (dark, until) = match state {
            State::Stale(why) if self.is_required => (Some(why), None),
            State::Current(until) if self.is_required => (None, until),
            _ => (None, None),
        };
        CameraStep { step: Arc::new(step), dark, until }
    }

    /// Where no light may be, as far as that is known, and the state of that.
    fn spheres(&mut self, stage: &Stage, now: Now) -> (Vec<Sphere>, State) {
        let (mut spheres, mut state) = (Vec::new(), State::Undated);
        for KeepOutFrame { frame, radius_m } in &self.keep_out {
            let place = stage.place_of(frame);
            match (place, &mut self.freshness) {
                (None, _) => state = state.and(State::Stale(format!("keep-out frame {frame}: its place is not known"))),
                (Some(_), Some(freshness)) => state = state.and(freshness.frame(frame, stage, now)),
                (Some(_), None) => {}
            }
            spheres.extend(place.map(|center| Sphere { center, radius_m: *radius_m }));
        }
        (spheres, state)
    }
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
