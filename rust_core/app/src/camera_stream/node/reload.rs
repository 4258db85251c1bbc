//! Reloading the config while the node runs.
//!
//! Only what differs changes: subscriptions, publishers and services that are kept are not touched, and displays that
//! are kept show what they did. If the file cannot be read, nothing changes.

use anyhow::{Context, Result};
use rcs_displays::Reconfigured;

use super::{camera_plan, Node};

impl Node<'_> {
    /// Reloads the config. Returns in one line what changed; `None` if nothing did.
    ///
    /// # Errors
    /// What is wrong with the file; nothing has changed then.
    pub(super) fn reload(&mut self) -> Result<Option<String>> {
        let config = rcs_rviz_config::load(&self.file)?;
        self.stage.retry_resources();
        let plans = camera_plan::plans(self.ros, &config).with_context(|| config.source.clone())?;
        if config == self.config {
            return Ok(None);
        }
        for finding in config.findings.iter().filter(|finding| !self.config.findings.contains(finding)) {
            log::warn!("{}: {finding}", config.source);
        }
        let known_parameters = self.stage.parameters();
        let now = self.now();
        let changed = self.stage.reconfigure(&config, self.fixed_frame.as_deref(), now);
        self.subscriptions.update(self.ros, self.stage.topics());
        let is_new = |name: &String| !known_parameters.contains(name);
        self.ros.follow_parameters(self.stage.parameters().into_iter().filter(is_new).collect());
        let cameras = std::mem::take(&mut self.cameras);
        self.cameras = camera_plan::rearrange(self.ros, plans, cameras, &config, self.stage.displays());
        self.config = config;
        self.scene_version += 1;
        let Reconfigured { kept, added, removed } = changed;
        Ok(Some(format!("{}: {kept} displays kept, {added} added, {removed} removed", self.config.source)))
    }

    /// Reloads the config because its file changed, and logs the result.
    pub(super) fn reload_changed_file(&mut self) {
        match self.reload() {
            Ok(Some(changed)) => log::info!("the config changed: {changed}"),
            Ok(None) => {}
            Err(error) => {
                let error = crate::logging::one_line(&error);
                log::warn!("the config changed but cannot be read, so the previous one is kept: {error}");
            }
        }
    }
}
