//! The control thread: answers calls that must not wait for a frame.
//!
//! It handles signals and the calls of services, has the config read again, and monitors the scene's thread. When that
//! has been busy for [`REPEAT_AFTER`], the last frames are repeated from here at their frame rates; after
//! [`REPORT_AFTER`] `/diagnostics` says what takes so long, and later, in the log, the [watchdog](super::watchdog).

use std::path::Path;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use anyhow::{anyhow, Context, Result};
use rcs_logging::one_line;
use rcs_node_support::lifecycle::EndRequest;
use rcs_process::join_within;
use rcs_ros::{NodeError, RosNode, ServiceCall, TriggerReply};
use rcs_rviz_config::Config;

use crate::camera::plan;
use crate::log_findings;
use crate::options::Options;
use crate::runtime::activity::Busy;
use crate::runtime::config_reader::{ConfigRead, ConfigReader};
use crate::runtime::shared::{NodeState, Reload};
use crate::runtime::watchdog::Task;

/// The longest sleep: signals set a flag only.
const LONGEST_SLEEP: Duration = Duration::from_millis(100);
/// The longest sleep while the last frames are repeated from here.
const REPEAT_SLEEP: Duration = Duration::from_millis(10);
/// Busy time of the scene's thread after which the last frames are repeated from here.
const REPEAT_AFTER: Duration = Duration::from_millis(50);
/// Busy time of the scene's thread that is a status.
const REPORT_AFTER: Duration = Duration::from_secs(1);
/// Time that a caller of `reload_config` waits for the scene's thread.
const RELOAD_PATIENCE: Duration = Duration::from_millis(150);
/// The answer for a caller whose config is not the newest.
const READ_AGAIN: &str = "the config was read again since";
/// Time that a caller waits for the config to be read.
const READ_PATIENCE: Duration = Duration::from_secs(1);
const END_PATIENCE: Duration = Duration::from_millis(500);

pub(crate) struct ControlThread {
    shared: Arc<NodeState>,
    /// As it was last read.
    config: Config,
    reader: ConfigReader,
    /// The caller of `reload_config` for whom the config is being read.
    reload_reply: Option<TriggerReply>,
    services: Services,
    /// Latest time of an answer to the caller of `reload_config`.
    answer_reload_at: Option<Instant>,
    /// Restarts of the master that were noticed.
    master_restarts: u64,
    task: Arc<Task>,
}

/// Whole names of the node's services.
struct Services {
    reload: Arc<str>,
    blackout: Arc<str>,
    pause: Arc<str>,
    test_image: Arc<str>,
    is_idle: Arc<str>,
}

impl Services {
    fn serve(ros: &RosNode) -> Result<Self, NodeError> {
        Ok(Self {
            reload: ros.serve_trigger("~reload_config")?,
            blackout: ros.serve_set_bool("~blackout")?,
            pause: ros.serve_set_bool("~pause")?,
            test_image: ros.serve_trigger("~test_picture")?,
            is_idle: ros.serve_trigger("~is_idle")?,
        })
    }
}

impl ControlThread {
    /// Offers the node's services, and watches the config's file unless told not to.
    ///
    /// # Errors
    /// One line that names what failed.
    pub(crate) fn start(options: &Options, file: &Path, config: &Config, shared: &Arc<NodeState>) -> Result<Self> {
        let calls = Arc::clone(shared.ros.calls());
        let reader = ConfigReader::start(file.to_owned(), options.node.watches_config, move || calls.wake());
        Ok(Self {
            shared: Arc::clone(shared),
            config: config.clone(),
            reader: reader.context("cannot start the thread that reads the config")?,
            reload_reply: None,
            services: Services::serve(&shared.ros)?,
            answer_reload_at: None,
            master_restarts: 0,
            task: Task::watched("answering calls"),
        })
    }

    /// Runs until the end is requested or the scene's thread has ended.
    ///
    /// # Errors
    /// The scene's thread has panicked.
    pub(crate) fn run(mut self, scene: JoinHandle<()>, end: &EndRequest) -> Result<()> {
        let shared = Arc::clone(&self.shared);
        while !end.is_requested() && !scene.is_finished() {
            self.task.begin();
            shared.pulse.beat(Instant::now());
            self.tell_blackout_anew();
            let busy = shared.activity.busy_for(REPEAT_AFTER);
            self.repeat_frames(busy.as_ref());
            self.answer_late_reload();
            rcs_logging::report_suppressed();
            let sleep = if busy.is_some() { REPEAT_SLEEP } else { LONGEST_SLEEP };
            self.task.wait_for_work();
            let calls = shared.ros.calls().wait(sleep);
            shared.pulse.beat(Instant::now());
            self.task.begin();
            // Keys and the page wake this thread, too.
            self.apply_control();
            for call in calls {
                self.answer(call);
            }
            self.take_config();
        }
        shared.end();
        // A thread that still draws ends with the process.
        let ended = join_within(scene, END_PATIENCE);
        ended.unwrap_or(Ok(())).map_err(|_| anyhow!("the scene's thread has panicked"))
    }

    /// Tells a master that was restarted of the blackout.
    fn tell_blackout_anew(&mut self) {
        let restarts = self.shared.ros.master_restarts();
        if std::mem::replace(&mut self.master_restarts, restarts) != restarts {
            self.shared.control.tell_parameter();
        }
    }

    /// Repeats frames and reports for the scene's thread while it is busy.
    fn repeat_frames(&self, busy: Option<&Busy>) {
        let Some(busy) = busy else { return };
        for camera in self.shared.cameras().iter_mut() {
            if let Err(error) = camera.repeat_if_due() {
                camera.record_error(&error);
            }
        }
        let busy_for = busy.since.elapsed();
        if busy_for >= REPORT_AFTER {
            let text = format!("busy for {:.1} s, at present {}", busy_for.as_secs_f64(), busy.step);
            self.shared.diagnostics().report_busy(&self.shared.ros, &text);
        }
    }

    fn answer(&mut self, call: ServiceCall) {
        match call {
            ServiceCall::Trigger { service, reply, .. } if service == self.services.reload => self.reload(reply),
            ServiceCall::Trigger { service, caller, reply } if service == self.services.test_image => {
                let test = self.shared.control.next_test_image(&caller);
                self.apply_control();
                reply.send(true, test.unwrap_or("the scene"));
            }
            ServiceCall::Trigger { service, reply, .. } if service == self.services.is_idle => self.tell_idle(reply),
            ServiceCall::SetBool { service, value, caller, reply } => self.switch(&service, value, &caller, reply),
            ServiceCall::Trigger { service, reply, .. } => {
                match self.shared.cameras().iter_mut().find(|camera| camera.serves(&service)) {
                    Some(camera) => camera.trigger(reply),
                    None => reply.send(false, "Image publisher not configured"),
                }
            }
            ServiceCall::Reconfigure { server, request, caller, reply } => {
                let set = self.shared.cameras().iter_mut().find_map(|camera| {
                    camera.has_parameters(&server).then(|| camera.reconfigure(&server, &request, &caller))?
                });
                self.apply_control();
                // Without an answer, the caller gets an error.
                if let Some(values) = set {
                    reply.answer(values);
                }
            }
        }
        self.shared.ros.events().wake();
    }

    /// Tells whether all cameras are dark only because there is nothing to show.
    fn tell_idle(&self, reply: TriggerReply) {
        let cameras = self.shared.cameras();
        let busy = cameras.iter().find_map(|camera| Some((camera.view().name.clone(), camera.why_busy()?)));
        match busy {
            Some((camera, why)) => reply.send(false, format!("camera {camera}: {why}")),
            None => reply.send(true, "nothing to show"),
        }
    }

    /// Switches the blackout or the pause of all cameras.
    fn switch(&self, service: &Arc<str>, on: bool, caller: &str, reply: TriggerReply) {
        let control = &self.shared.control;
        let mut kept = Ok(());
        let done = if *service == self.services.blackout {
            kept = control.set_blackout(on, caller);
            ["all blackouts are released", "all cameras are black"]
        } else if *service == self.services.pause {
            control.set_pause(on, caller);
            ["no camera is paused", "all cameras are paused"]
        } else {
            return;
        };
        self.apply_control();
        let done = done[usize::from(on)];
        match kept {
            Ok(()) => reply.send(true, done),
            Err(error) => reply.send(false, format!("{done}, but {error}")),
        }
    }

    /// Applies to the outputs what the operator has changed, whatever the scene's thread does.
    fn apply_control(&self) {
        if !self.shared.control.take_change() {
            return;
        }
        self.shared.page.pages().state_changed();
        for camera in self.shared.cameras().iter_mut() {
            if let Err(error) = camera.apply_control() {
                camera.record_error(&error);
            }
        }
    }

    /// Has the config read again for the caller of a service, who is answered when it is applied.
    fn reload(&mut self, reply: TriggerReply) {
        if let Some(obsolete) = self.reload_reply.replace(reply) {
            obsolete.send(true, READ_AGAIN);
        }
        self.answer_reload_at = Some(Instant::now() + READ_PATIENCE);
        self.reader.request();
    }

    /// Hands over a config that was read. An error is answered to the caller, and logged if the file had changed.
    fn take_config(&mut self) {
        let Some(ConfigRead { config, has_changed }) = self.reader.take() else { return };
        let reply = self.reload_reply.take();
        match config.map_err(anyhow::Error::from).and_then(|config| self.check(config)) {
            Ok(Some(config)) => {
                self.answer_reload_at = reply.as_ref().map(|_| Instant::now() + RELOAD_PATIENCE);
                self.hand_over(Reload { config, reply });
            }
            Ok(None) => {
                if let Some(reply) = reply {
                    reply.send(true, "nothing changed");
                }
            }
            Err(error) => {
                let error = one_line(&error);
                if has_changed {
                    log::warn!("the config changed but cannot be read, so the previous one is kept: {error}");
                }
                if let Some(reply) = reply {
                    reply.send(false, error);
                }
            }
        }
    }

    /// A config that was read; `None` if it is the same as before.
    ///
    /// # Errors
    /// A camera's topic is no valid name; nothing has changed then.
    fn check(&mut self, config: Config) -> Result<Option<Config>> {
        self.shared.request_retry();
        self.shared.ros.events().wake();
        plan::plans(&self.shared.ros, &config).with_context(|| config.source.clone())?;
        if config == self.config {
            return Ok(None);
        }
        log_findings(&config, &self.config.findings);
        self.config = config.clone();
        Ok(Some(config))
    }

    /// Hands another config to the scene's thread.
    fn hand_over(&mut self, reload: Reload) {
        let obsolete = self.shared.request_reload(reload);
        if let Some(reply) = obsolete.and_then(|obsolete| obsolete.reply) {
            reply.send(true, READ_AGAIN);
        }
        self.shared.ros.events().wake();
    }

    /// Answers the caller of `reload_config` while the config is still being read, or the scene's thread busy.
    fn answer_late_reload(&mut self) {
        if self.answer_reload_at.is_none_or(|at| Instant::now() < at) {
            return;
        }
        self.answer_reload_at = None;
        let source = &self.config.source;
        if let Some(reply) = self.reload_reply.take() {
            reply.send(false, format!("{source}: still being read; it is applied afterwards"));
        }
        if let Some(reply) = self.shared.take_reload_reply() {
            reply.send(true, format!("{source}: read; it is applied after the picture that is being drawn"));
        }
    }
}
