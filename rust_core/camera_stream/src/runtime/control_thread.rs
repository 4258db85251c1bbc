//! The control thread: answers calls that must not wait for a frame.
//!
//! It handles signals and the calls of services, has the config read again, and monitors the scene's thread. When that
//! has been busy for [`REPEAT_AFTER`], the last frames are repeated from here at their frame rates; after
//! [`REPORT_AFTER`] `/diagnostics` says what takes so long, and later, in the log, the [watchdog](super::watchdog).

use std::path::Path;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use anyhow::{anyhow, Result};
use rcs_messages::dynamic_reconfigure::Config as Values;
use rcs_node_support::lifecycle::EndRequest;
use rcs_process::join_within;
use rcs_ros::settings::NamedValues;
use rcs_ros::{NodeError, Reply, RosNode, ServiceCall, TriggerReply};
use rcs_rviz_config::Config;

use crate::options::Options;
use crate::runtime::activity::Busy;
use crate::runtime::config_control::ConfigControl;
use crate::runtime::cue_thread;
use crate::runtime::shared::NodeState;
use crate::runtime::watchdog::Task;

/// The longest sleep: signals set a flag only.
const LONGEST_SLEEP: Duration = Duration::from_millis(100);
/// The longest sleep while the last frames are repeated from here.
const REPEAT_SLEEP: Duration = Duration::from_millis(10);
/// Busy time of the scene's thread after which the last frames are repeated from here.
const REPEAT_AFTER: Duration = Duration::from_millis(50);
/// Busy time of the scene's thread that is a status.
const REPORT_AFTER: Duration = Duration::from_secs(1);
const END_PATIENCE: Duration = Duration::from_millis(500);

pub(crate) struct ControlThread {
    shared: Arc<NodeState>,
    config: ConfigControl,
    services: Services,
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
    next_cue: Arc<str>,
    is_idle: Arc<str>,
    load_discarding: Arc<str>,
    save: Arc<str>,
}

impl Services {
    fn serve(ros: &RosNode) -> Result<Self, NodeError> {
        ros.serve_file_path("~load_config")?;
        // There are no shaders.
        ros.serve_nothing("~reload_shaders")?;
        Ok(Self {
            reload: ros.serve_trigger("~reload_config")?,
            blackout: ros.serve_set_bool("~blackout")?,
            pause: ros.serve_set_bool("~pause")?,
            test_image: ros.serve_trigger("~test_picture")?,
            next_cue: ros.serve_trigger("~next_cue")?,
            is_idle: ros.serve_trigger("~is_idle")?,
            load_discarding: ros.serve_file_path("~load_config_discarding_changes")?,
            save: ros.serve_file_path("~save_config")?,
        })
    }
}

impl ControlThread {
    /// Offers the node's services, and watches the config's file unless told not to.
    ///
    /// # Errors
    /// One line that names what failed.
    pub(crate) fn start(options: &Options, file: &Path, config: &Config, shared: &Arc<NodeState>) -> Result<Self> {
        Ok(Self {
            shared: Arc::clone(shared),
            config: ConfigControl::start(file, config, options.node.watches_config, shared)?,
            services: Services::serve(&shared.ros)?,
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
            self.config.answer_late();
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
            self.config.take();
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
            ServiceCall::Trigger { service, reply, .. } if service == self.services.reload => {
                self.config.reload(reply);
            }
            ServiceCall::Trigger { service, caller, reply } if service == self.services.test_image => {
                let test = self.shared.control.next_test_image(&caller);
                self.apply_control();
                reply.send(true, test.unwrap_or("the scene"));
            }
            ServiceCall::Trigger { service, caller, reply } if service == self.services.next_cue => {
                let answer = |shown: Result<String, String>| {
                    let (Ok(text) | Err(text)) = &shown;
                    reply.send(shown.is_ok(), text.as_str());
                };
                self.shared.cues.ask(None, &caller, Box::new(answer));
            }
            ServiceCall::Trigger { service, reply, .. } if service == self.services.is_idle => self.tell_idle(reply),
            ServiceCall::SetBool { service, value, caller, reply } => self.switch(&service, value, &caller, reply),
            ServiceCall::FilePath { service, path, reply, .. } if service == self.services.save => {
                self.config.save(path, reply);
            }
            ServiceCall::FilePath { service, path, reply, .. } => {
                self.config.load(path, service == self.services.load_discarding, reply);
            }
            ServiceCall::Trigger { service, reply, .. } => {
                match self.shared.cameras().iter_mut().find(|camera| camera.serves(&service)) {
                    Some(camera) => camera.trigger(reply),
                    None => reply.send(false, "Image publisher not configured"),
                }
            }
            ServiceCall::Reconfigure { server, request, caller, reply } => {
                if self.shared.settings().server(&server).is_some() {
                    return self.set_node(&request, &caller, reply);
                }
                let set = self.shared.cameras().iter_mut().find_map(|camera| {
                    camera.has_parameters(&server).then(|| camera.reconfigure(&server, &request, &caller))?
                });
                self.apply_control();
                cue_thread::follow(&self.shared);
                // Without an answer, the caller gets an error.
                if let Some(values) = set {
                    reply.answer(values);
                }
            }
        }
        self.shared.ros.events().wake();
    }

    /// Takes values of the settings of all cameras, a cue first. Without an answer, the caller gets an error.
    fn set_node(&self, request: &NamedValues, caller: &str, reply: Reply<Values>) {
        let (shared, request) = (Arc::clone(&self.shared), request.clone());
        let (cue, own_caller) = (shared.settings().other_cue(&request).map(str::to_owned), caller.to_owned());
        let set = move || {
            let set = shared.settings().set(&shared.ros, &shared.control, &request, &own_caller);
            match set {
                Ok(Some(values)) => reply.answer(values),
                Ok(None) => {}
                Err(error) => log::error!("nothing changed: {error}; set by {own_caller}"),
            }
        };
        match cue {
            Some(name) => {
                let done = move |shown: Result<String, String>| {
                    if shown.is_ok() {
                        set();
                    }
                };
                self.shared.cues.ask(Some(&name), caller, Box::new(done));
            }
            None => {
                set();
                cue_thread::follow(&self.shared);
            }
        }
        self.apply_control();
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
}
