//! The node's config while it runs: it is read again when its file changes or a service asks, and rviz's services load
//! another one and save it with what dynamic_reconfigure has changed.
//!
//! rviz asks at its window before a loaded config takes unsaved changes away. Here nobody can be asked, so such a
//! config is refused, unless it was loaded to discard the changes.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Context, Error, Result};
use rcs_files::atomic_file::write_atomically;
use rcs_logging::one_line;
use rcs_ros::{Reply, TriggerReply};
use rcs_rviz_config::Config;

use super::config_reader::{ConfigRead, ConfigReader};
use super::config_reply::ConfigReply;
use super::shared::{NodeState, Reload};
use crate::camera::plan;
use crate::log_findings;

/// Time that a caller of `reload_config` waits for the scene's thread.
const RELOAD_PATIENCE: Duration = Duration::from_millis(150);
/// The answer for a caller whose config is not the newest.
const READ_AGAIN: &str = "the config was read again since";
/// Time that a caller waits for the config to be read.
const READ_PATIENCE: Duration = Duration::from_secs(1);

/// Reads the node's config anew, loads another one and saves it.
pub(super) struct ConfigControl {
    shared: Arc<NodeState>,
    /// As it was last read.
    config: Config,
    is_watched: bool,
    reader: ConfigReader,
    /// The caller of `reload_config` for whom the config is being read.
    reload_reply: Option<TriggerReply>,
    /// Another config that is being read.
    loading: Option<Loading>,
    /// Latest time of an answer to who asked for the config.
    answer_at: Option<Instant>,
}

/// A config that is read to replace the node's.
struct Loading {
    file: PathBuf,
    reader: ConfigReader,
    reply: ConfigReply,
}

impl ConfigControl {
    /// Watches the config's file if `is_watched`.
    ///
    /// # Errors
    /// One line: the thread that reads cannot be started.
    pub(super) fn start(file: &Path, config: &Config, is_watched: bool, shared: &Arc<NodeState>) -> Result<Self> {
        Ok(Self {
            shared: Arc::clone(shared),
            config: config.clone(),
            is_watched,
            reader: start_reader(file, is_watched, shared)?,
            reload_reply: None,
            loading: None,
            answer_at: None,
        })
    }

    /// Has the config read again for the caller of a service, who is answered when it is applied.
    pub(super) fn reload(&mut self, reply: TriggerReply) {
        if let Some(obsolete) = self.reload_reply.replace(reply) {
            obsolete.send(true, READ_AGAIN);
        }
        self.answer_at = Some(Instant::now() + READ_PATIENCE);
        self.reader.request();
    }

    /// Has another config read for the caller of a service, who is answered when it is applied.
    pub(super) fn load(&mut self, file: PathBuf, discards_changes: bool, reply: Reply<bool>) {
        let reply = ConfigReply::Load(reply);
        let cameras = self.shared.cameras();
        let unsaved = cameras.iter().find(|camera| camera.is_unsaved()).map(|camera| camera.view().name.clone());
        drop(cameras);
        if let (Some(camera), false) = (unsaved, discards_changes) {
            let why = format!("the settings of camera {camera} are changed and not saved");
            let remedy = "call save_config or load_config_discarding_changes";
            return reply.send(false, format!("{} is not loaded: {why}; {remedy}", file.display()));
        }
        match start_reader(&file, self.is_watched, &self.shared) {
            Ok(reader) => {
                reader.request();
                if let Some(obsolete) = self.loading.replace(Loading { file, reader, reply }) {
                    let (old, new) = (obsolete.file.display(), "another config was asked for");
                    obsolete.reply.send(false, format!("{old} is not loaded: {new}"));
                }
            }
            Err(error) => reply.send(false, one_line(&error)),
        }
    }

    /// Saves the config with what services have changed in its cameras, on a thread of its own: the file may be on a
    /// network share that hangs. Callers may be anybody, so only configs are replaced.
    pub(super) fn save(&self, file: PathBuf, reply: Reply<bool>) {
        if file.extension().is_none_or(|ending| ending != "rviz") {
            log::error!("{} is not saved: a config's name ends with .rviz", file.display());
            return reply.answer(false);
        }
        let (mut config, mut current) = (self.config.clone(), Vec::new());
        for camera in self.shared.cameras().iter_mut() {
            current.push((camera.view().name.clone(), camera.current_settings()));
            camera.set_saved(true);
        }
        config.enabled_cameras_mut(&mut |name, settings| {
            if let Some(index) = current.iter().position(|(camera, _)| camera == name) {
                *settings = current.remove(index).1;
            }
        });
        let shared = Arc::clone(&self.shared);
        let saving = move || {
            let saved = save(&config, &file).with_context(|| format!("{} is not saved", file.display()));
            match &saved {
                Ok(()) => log::info!("the config is saved in {}", file.display()),
                Err(error) => {
                    log::error!("{}", one_line(error));
                    shared.cameras().iter_mut().for_each(|camera| camera.set_saved(false));
                }
            }
            reply.answer(saved.is_ok());
        };
        // Where it cannot be started, the caller gets an error.
        if let Err(error) = std::thread::Builder::new().name("config-save".to_owned()).spawn(saving) {
            log::error!("cannot start the thread that saves the config: {error}");
        }
    }

    /// Hands over a config that was read.
    pub(super) fn take(&mut self) {
        if let Some(read) = self.reader.take() {
            self.take_again(read);
        }
        if let Some(read) = self.loading.as_ref().and_then(|loading| loading.reader.take()) {
            self.take_loaded(read);
        }
    }

    /// An error is answered to the caller, and logged if the file had changed.
    fn take_again(&mut self, ConfigRead { config, has_changed }: ConfigRead) {
        let reply = self.reload_reply.take().map(ConfigReply::Reload);
        match config.map_err(Error::from).and_then(|config| self.check(config)) {
            Ok(config) if config != self.config => self.hand_over(Reload { config, reply, discards_changes: false }),
            Ok(_) => {
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

    fn take_loaded(&mut self, read: ConfigRead) {
        let Some(Loading { file, reader, reply }) = self.loading.take() else { return };
        match read.config.map_err(Error::from).and_then(|config| self.check(config)) {
            Ok(config) => {
                self.reader = reader;
                self.shared.set_config_file(&file);
                if let Some(obsolete) = self.reload_reply.take() {
                    obsolete.send(true, READ_AGAIN);
                }
                self.hand_over(Reload { config, reply: Some(reply), discards_changes: true });
            }
            Err(error) => {
                reply.send(false, format!("not loaded, so the previous config is kept: {}", one_line(&error)));
            }
        }
    }

    /// A config that was read.
    ///
    /// # Errors
    /// A camera's topic is no valid name; nothing has changed then.
    fn check(&self, config: Config) -> Result<Config> {
        self.shared.request_retry();
        self.shared.ros.events().wake();
        plan::plans(&self.shared.ros, &config).with_context(|| config.source.clone())?;
        Ok(config)
    }

    /// Hands another config to the scene's thread.
    fn hand_over(&mut self, reload: Reload) {
        log_findings(&reload.config, &self.config.findings);
        self.config = reload.config.clone();
        self.answer_at = reload.reply.as_ref().map(|_| Instant::now() + RELOAD_PATIENCE);
        let obsolete = self.shared.request_reload(reload);
        if let Some(reply) = obsolete.and_then(|obsolete| obsolete.reply) {
            reply.send(true, READ_AGAIN);
        }
        self.shared.ros.events().wake();
    }

    /// Answers who asked for the config while it is still being read, or the scene's thread busy.
    pub(super) fn answer_late(&mut self) {
        if self.answer_at.is_none_or(|at| Instant::now() < at) {
            return;
        }
        self.answer_at = None;
        let source = &self.config.source;
        if let Some(reply) = self.reload_reply.take() {
            reply.send(false, format!("{source}: still being read; it is applied afterwards"));
        }
        if let Some(reply) = self.shared.take_reload_reply() {
            reply.send(true, format!("{source}: read; it is applied after the picture that is being drawn"));
        }
    }
}

fn start_reader(file: &Path, is_watched: bool, shared: &Arc<NodeState>) -> Result<ConfigReader> {
    let calls = Arc::clone(shared.ros.calls());
    let reader = ConfigReader::start(file.to_owned(), is_watched, move || calls.wake());
    reader.context("cannot start the thread that reads the config")
}

fn save(config: &Config, file: &Path) -> Result<()> {
    let text = config.saved_text()?;
    write_atomically(file, |out| out.write_all(text.as_bytes()), |error| error)?;
    Ok(())
}
