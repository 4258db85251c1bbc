//! A dynamic_reconfigure server for rqt_reconfigure and dynparam.
//!
//! In its namespace are the latched topics `parameter_descriptions` and `parameter_updates`, the service
//! `set_parameters`, and its values as parameters. A call is a [`ServiceCall::Reconfigure`], which the owner answers
//! with the values that [`ReconfigureServer::set`] has published then.

use crate::error::NodeError;
use crate::events::ServiceCall;
use crate::network::Network;
use crate::node::RosNode;
use crate::publisher::Publisher;
use crate::settings::{config, description, named_values, settings, SettingGroup};
use rcs_messages::dynamic_reconfigure::{Config, ConfigDescription, Reconfigure};
use std::collections::HashMap;
use std::sync::Arc;

/// Queue size of both topics.
const QUEUE_SIZE: usize = 10;

/// Serves until it is dropped.
pub struct ReconfigureServer {
    name: Arc<str>,
    descriptions: Publisher<ConfigDescription>,
    updates: Publisher<Config>,
    service: ServiceGuard,
    groups: Vec<SettingGroup>,
}

impl RosNode {
    /// Starts a dynamic_reconfigure server in `namespace` and publishes its settings.
    ///
    /// # Errors
    /// [`NodeError::Name`].
    pub fn serve_reconfigure(
        &self,
        namespace: &str,
        groups: Vec<SettingGroup>,
    ) -> Result<ReconfigureServer, NodeError> {
        let name: Arc<str> = self.resolve(namespace)?.into();
        let (descriptions, updates) = (format!("{name}/parameter_descriptions"), format!("{name}/parameter_updates"));
        let mut server = ReconfigureServer {
            descriptions: self.latched_publisher(&descriptions, QUEUE_SIZE)?,
            updates: self.latched_publisher(&updates, QUEUE_SIZE)?,
            service: ServiceGuard { name: format!("{name}/set_parameters"), network: Arc::clone(self.network()) },
            groups: Vec::new(),
            name,
        };
        let server_name = Arc::clone(&server.name);
        self.serve_queued::<Reconfigure, _>(
            &server.service.name,
            move |caller, request, reply| ServiceCall::Reconfigure {
                server: Arc::clone(&server_name),
                request: named_values(request),
                caller,
                reply,
            },
            |config| config,
        );
        server.set(self, groups);
        Ok(server)
    }
}

/// Ends the service when it is dropped.
struct ServiceGuard {
    name: String,
    network: Arc<Network>,
}

impl Drop for ServiceGuard {
    fn drop(&mut self) {
        self.network.stop_serving(&self.name);
    }
}

impl ReconfigureServer {
    /// Whole name of the namespace.
    pub fn name(&self) -> &Arc<str> {
        &self.name
    }

    /// The settings, with the values that apply.
    pub fn groups(&self) -> &[SettingGroup] {
        &self.groups
    }

    /// Publishes the values, and the settings' descriptions if these changed; writes the values that changed to the
    /// parameter server. Returns the values for the answer to a call.
    pub fn set(&mut self, ros: &RosNode, groups: Vec<SettingGroup>) -> Config {
        let described = description(&groups);
        if described != description(&self.groups) {
            if let Err(error) = self.descriptions.send(described) {
                log::warn!("{}: cannot publish the parameters' descriptions: {error}", self.name);
            }
        }
        let known: HashMap<_, _> = settings(&self.groups).map(|setting| (&setting.name, &setting.value)).collect();
        for setting in settings(&groups) {
            if known.get(&setting.name) != Some(&&setting.value) {
                let name = format!("{}/{}", self.name, setting.name);
                ros.param_writer.set(ros.network(), name, setting.value.clone());
            }
        }
        let values = config(&groups, |setting| &setting.value);
        self.groups = groups;
        if let Err(error) = self.updates.send(values.clone()) {
            log::warn!("{}: cannot publish the parameters: {error}", self.name);
        }
        values
    }
}
