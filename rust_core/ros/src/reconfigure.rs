//! A dynamic_reconfigure server for rqt_reconfigure and dynparam.
//!
//! In its namespace are the latched topics `parameter_descriptions` and `parameter_updates`, the service
//! `set_parameters`, and its values as parameters. A call is a [`ServiceCall::Reconfigure`], which the owner answers
//! with the values that apply then; [`ReconfigureServer::set_config`] publishes a change.

use crate::error::NodeError;
use crate::events::ServiceCall;
use crate::network::Network;
use crate::node::RosNode;
use crate::publisher::Publisher;
use crate::xmlrpc::Value;
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
    described: ConfigDescription,
    config: Config,
    on_parameter_server: HashMap<String, Value>,
}

impl RosNode {
    /// Starts a dynamic_reconfigure server in `namespace` and publishes its first values.
    ///
    /// # Errors
    /// [`NodeError::Name`].
    pub fn serve_reconfigure(
        &self,
        namespace: &str,
        description: ConfigDescription,
        config: Config,
    ) -> Result<ReconfigureServer, NodeError> {
        let name: Arc<str> = self.resolve(namespace)?.into();
        let (descriptions, updates) = (format!("{name}/parameter_descriptions"), format!("{name}/parameter_updates"));
        let mut server = ReconfigureServer {
            descriptions: self.latched_publisher(&descriptions, QUEUE_SIZE)?,
            updates: self.latched_publisher(&updates, QUEUE_SIZE)?,
            service: ServiceGuard { name: format!("{name}/set_parameters"), network: Arc::clone(self.network()) },
            described: ConfigDescription::default(),
            config: Config::default(),
            on_parameter_server: HashMap::new(),
            name,
        };
        let server_name = Arc::clone(&server.name);
        self.serve_queued::<Reconfigure, _>(
            &server.service.name,
            move |caller, request, reply| ServiceCall::Reconfigure {
                server: Arc::clone(&server_name),
                request,
                caller,
                reply,
            },
            |config| config,
        );
        server.set_description(description);
        server.set_config(self, config);
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

/// Values of a message by name.
fn values(config: &Config) -> impl Iterator<Item = (&String, Value)> {
    let bools = config.bools.iter().map(|param| (&param.name, Value::Bool(param.value)));
    let ints = config.ints.iter().map(|param| (&param.name, Value::Int(param.value)));
    let strs = config.strs.iter().map(|param| (&param.name, Value::String(param.value.clone())));
    let doubles = config.doubles.iter().map(|param| (&param.name, Value::Double(param.value)));
    bools.chain(ints).chain(strs).chain(doubles)
}

impl ReconfigureServer {
    /// Whole name of the namespace.
    pub fn name(&self) -> &Arc<str> {
        &self.name
    }

    /// The parameters' descriptions.
    pub fn description(&self) -> &ConfigDescription {
        &self.described
    }

    /// The values that apply.
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// Publishes the parameters' descriptions, if they changed.
    pub fn set_description(&mut self, description: ConfigDescription) {
        if description != self.described {
            if let Err(error) = self.descriptions.send(description.clone()) {
                log::warn!("{}: cannot publish the parameters' descriptions: {error}", self.name);
            }
            self.described = description;
        }
    }

    /// Publishes the values, and writes those that changed to the parameter server.
    pub fn set_config(&mut self, ros: &RosNode, config: Config) {
        for (name, value) in values(&config) {
            if self.on_parameter_server.get(name) != Some(&value) {
                ros.param_writer.set(ros.network(), format!("{}/{name}", self.name), value.clone());
                self.on_parameter_server.insert(name.clone(), value);
            }
        }
        self.config = config.clone();
        if let Err(error) = self.updates.send(config) {
            log::warn!("{}: cannot publish the parameters: {error}", self.name);
        }
    }
}
