//! Going over to the config as it is now, while the node runs.
//!
//! Only what differs changes: subscriptions, publishers and services that stay are not touched, and displays that stay
//! keep what they show. A file that cannot be read leaves everything as it is.

use anyhow::{Context, Result};
use rcs_displays::Reconfigured;

use super::{camera, Node};

impl Node<'_> {
    /// Reads the config again. Returns in one line what that changed; `None` when it changed nothing.
    ///
    /// # Errors
    /// What is wrong with the file; everything is as before then.
    pub(super) fn reload(&mut self) -> Result<Option<String>> {
        let config = rcs_rviz_config::load(&self.file)?;
        let plans = camera::plans(self.ros, &config).with_context(|| config.source.clone())?;
        if config == self.config {
            return Ok(None);
        }
        for finding in config.findings.iter().filter(|finding| !self.config.findings.contains(finding)) {
            log::warn!("{}: {finding}", config.source);
        }
        let known_parameters = self.stage.parameters();
        let now = self.now();
        let changed = self.stage.reconfigure(&config, self.fixed_frame.as_deref(), now);
        self.subscriptions.follow(self.ros, self.stage.topics());
        let is_new = |name: &String| !known_parameters.contains(name);
        self.ros.follow_parameters(self.stage.parameters().into_iter().filter(is_new).collect());
        let cameras = std::mem::take(&mut self.cameras);
        self.cameras = camera::rearrange(self.ros, plans, cameras, &config, self.stage.displays());
        self.config = config;
        self.scene_version += 1;
        let Reconfigured { kept, added, removed } = changed;
        Ok(Some(format!("{}: {kept} displays kept, {added} added, {removed} removed", self.config.source)))
    }

    /// Reads the config again because its file changed, and says in the log what came of it.
    pub(super) fn follow_file(&mut self) {
        match self.reload() {
            Ok(Some(changed)) => log::info!("the config was written again: {changed}"),
            Ok(None) => {}
            Err(error) => {
                let error = crate::logging::one_line(&error);
                log::warn!("the config was written again and cannot be read, everything stays as it is: {error}");
            }
        }
    }
}
