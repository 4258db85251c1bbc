//! A look at a running ROS: subscribes for a while as the node would, and gives the statuses that it would have.

use std::ffi::OsString;
use std::time::{Duration, Instant};

use anyhow::Result;
use rcs_displays::time_from_stamp;
use rcs_node_support::lifecycle::EndRequest;
use rcs_node_support::node_options;
use rcs_resources::{MeshStore, PackageIndex};
use rcs_ros::RosNode;
use rcs_rviz_config::Config;
use rcs_transforms::Time;

use crate::check::observed::Observed;
use crate::options::Options;
use crate::scene::status_tree::{self, StatusEntry};
use crate::scene::subscriptions::Subscriptions;
use crate::scene::visibility::{self, PlacedCamera};
use crate::scene::{camera, SceneState};
use crate::{config_names, NODE_NAME};

const LONGEST_SLEEP: Duration = Duration::from_millis(100);

/// A node beside the one that is examined.
pub(crate) struct Session {
    pub(crate) ros: RosNode,
    /// Name of the examined node.
    pub(crate) checked_name: String,
    end: EndRequest,
}

impl Session {
    /// Connects to the master, with a name that the examined node does not have: the master would end that node.
    ///
    /// # Errors
    /// No master, or why the node cannot start.
    pub(crate) fn connect() -> Result<Self> {
        let suffix = format!("_check_{}", std::process::id());
        let end = EndRequest::watch_signals()?;
        rcs_process::name_threads();
        let ros = RosNode::connect_beside(NODE_NAME, &suffix, &|| end.is_requested())?;
        let checked_name = ros.name().strip_suffix(&suffix).unwrap_or_default().to_owned();
        Ok(Self { ros, checked_name, end })
    }

    /// Options of the examined node: the command line, then the parameters that a launch file set for it.
    ///
    /// # Errors
    /// An invalid parameter.
    pub(crate) fn options(&self, words: &[OsString], config: &Config) -> Result<Options> {
        let mut parameters = self.ros.parameters_of(&self.checked_name)?;
        parameters.extend(self.ros.parameters().clone());
        Ok(Options::of(&node_options::merge(words, &parameters)?, &config_names(config))?)
    }

    /// The scene of a config, without messages.
    pub(crate) fn scene(&self, config: &Config, options: &Options) -> SceneState {
        let (events, resources) = (self.ros.events().clone(), options.resources.clone());
        let meshes = MeshStore::in_background(PackageIndex::from_env(&[]), resources, move || events.wake());
        SceneState::new(config, options.fixed_frame.as_deref(), meshes)
    }

    /// Applies received messages to the scene for a while. Returns the subscriptions, which know their
    /// publishers, and what has arrived.
    ///
    /// # Errors
    /// Transforms cannot be subscribed to.
    pub(crate) fn listen(&self, scene: &mut SceneState, listen: Duration) -> Result<(Subscriptions, Observed)> {
        let ros = &self.ros;
        ros.subscribe_transforms()?;
        let (mut subscriptions, mut observed) = (Subscriptions::default(), Observed::default());
        subscriptions.update(ros, scene);
        let started = Instant::now();
        loop {
            let left = listen.saturating_sub(started.elapsed());
            for event in ros.events().wait(left.min(LONGEST_SLEEP)) {
                let now = self.now();
                observed.event(&event, now);
                subscriptions.apply(event, scene, now);
            }
            scene.update(self.now());
            observed.updated(scene, self.now());
            if left.is_zero() || self.end.is_requested() {
                return Ok((subscriptions, observed));
            }
        }
    }

    /// The statuses of everything but the cameras.
    pub(crate) fn display_entries<'s>(&self, scene: &'s SceneState, options: &Options) -> Vec<StatusEntry<'s>> {
        let mut entries = status_tree::scene(scene, self.now());
        let place = |view| PlacedCamera { view, camera: camera(scene, view, options.model).ok() };
        let placed: Vec<_> = scene.cameras().iter().map(place).collect();
        visibility::add(&mut entries, scene, &placed);
        entries
    }

    /// Adds what the master knows about the topics of entries.
    pub(crate) fn add_graph(&self, entries: &mut [StatusEntry<'_>]) {
        status_tree::add_ros_graph(entries, &self.ros);
        status_tree::add_unreachable_publishers(entries, &self.ros);
    }

    /// ROS time.
    pub(crate) fn now(&self) -> Time {
        time_from_stamp(self.ros.now())
    }

    /// Ends the node, and deletes the parameters that the arguments set for it: nobody uses its name again.
    pub(crate) fn end(&self) {
        self.ros.delete_parameters();
        self.ros.shutdown();
    }
}
