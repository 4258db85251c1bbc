//! The state that the scene's thread and the control thread share.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Instant;

use rcs_light::Pulse;
use rcs_process::lock;
use rcs_ros::{NodeError, RosNode};
use rcs_rviz_config::Config;

use super::activity::Activity;
use super::config_reply::ConfigReply;
use super::diagnostics::Diagnostics;
use super::node_settings::NodeSettings;
use super::watchdog;
use crate::camera::output::CameraPublisher;
use crate::control::cues::Cues;
use crate::control::Control;
use crate::options::arguments::LightArgs;
use crate::page::PageStatuses;

/// State shared by the scene's thread and the control thread. No lock is held for long: not while messages are taken,
/// displays are updated or images are drawn.
pub(crate) struct NodeState {
    pub(crate) ros: Arc<RosNode>,
    pub(super) activity: Arc<Activity>,
    /// The contents of the operator's page.
    pub(crate) page: PageStatuses,
    pub(crate) control: Arc<Control>,
    pub(crate) cues: Arc<Cues>,
    /// The control thread's beats, which show pauses of the process.
    pub(super) pulse: Pulse,
    settings: Mutex<NodeSettings>,
    cameras: Mutex<Vec<CameraPublisher>>,
    diagnostics: Mutex<Diagnostics>,
    requests: Mutex<Requests>,
    config_file: Mutex<PathBuf>,
}

/// Requests of the control thread to the scene's thread.
#[derive(Default)]
struct Requests {
    reload: Option<Reload>,
    /// Load meshes and textures again that could not be used.
    retry_resources: bool,
    end: bool,
}

/// Another config, which was read without an error.
pub(super) struct Reload {
    pub(super) config: Config,
    /// Answers who asked for it; `None` if the file changed, or if the answer could not wait.
    pub(super) reply: Option<ConfigReply>,
    /// Whether the cameras forget what services have changed.
    pub(super) discards_changes: bool,
}

impl NodeState {
    /// Without cameras, of the config in a file, with the blackout and the brightness of the options.
    ///
    /// # Errors
    /// The name of a topic.
    pub(super) fn new(ros: Arc<RosNode>, config_file: &Path, light: &LightArgs) -> Result<Self, NodeError> {
        let control = Arc::new(Control::start(&ros, light));
        let cues = Arc::new(Cues::start(&ros)?);
        let settings = Mutex::new(NodeSettings::start(&ros, &control));
        let diagnostics = Mutex::new(Diagnostics::start(&ros));
        let activity = Arc::<Activity>::default();
        watchdog::watch(&activity);
        let (page, cameras, requests) = (PageStatuses::new(), Mutex::default(), Mutex::default());
        let pulse = Pulse::start(Instant::now());
        let config_file = Mutex::new(config_file.to_owned());
        Ok(Self { ros, activity, control, cues, pulse, page, settings, cameras, diagnostics, requests, config_file })
    }

    /// The config's file was exchanged for another.
    pub(super) fn set_config_file(&self, file: &Path) {
        file.clone_into(&mut lock(&self.config_file));
    }

    /// The file of the config.
    pub(crate) fn config_file(&self) -> PathBuf {
        lock(&self.config_file).clone()
    }

    /// The config's name without its folder.
    pub(crate) fn config_name(&self) -> String {
        self.config_file().file_name().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// The cameras, in the config's order. Only the scene's thread adds and removes some.
    pub(crate) fn cameras(&self) -> MutexGuard<'_, Vec<CameraPublisher>> {
        lock(&self.cameras)
    }

    /// The settings that hold for all cameras.
    pub(crate) fn settings(&self) -> MutexGuard<'_, NodeSettings> {
        lock(&self.settings)
    }

    pub(super) fn diagnostics(&self) -> MutexGuard<'_, Diagnostics> {
        lock(&self.diagnostics)
    }

    /// Has the scene's thread apply another config. Returns one that it has not applied yet, which is obsolete.
    pub(super) fn request_reload(&self, reload: Reload) -> Option<Reload> {
        lock(&self.requests).reload.replace(reload)
    }

    /// The reply of a config that is not applied yet, for an earlier answer.
    pub(super) fn take_reload_reply(&self) -> Option<ConfigReply> {
        lock(&self.requests).reload.as_mut()?.reply.take()
    }

    /// Has the scene's thread load meshes and textures again that could not be used.
    pub(super) fn request_retry(&self) {
        lock(&self.requests).retry_resources = true;
    }

    /// The config to apply, and whether to load resources again; once for each request.
    pub(super) fn take_requests(&self) -> (Option<Reload>, bool) {
        let mut requests = lock(&self.requests);
        (requests.reload.take(), std::mem::take(&mut requests.retry_resources))
    }

    pub(super) fn end(&self) {
        lock(&self.requests).end = true;
        self.ros.events().wake();
    }

    pub(super) fn is_ending(&self) -> bool {
        lock(&self.requests).end
    }
}
