//! A dynamic_reconfigure server, as rqt_reconfigure and dynparam expect it.
//!
//! In a namespace of its own it has the latched topics `parameter_descriptions` and `parameter_updates`, the service
//! `set_parameters`, and its values as parameters. What a value means and which bounds it has is its owner's business:
//! a call is a [`NodeEvent::Reconfigure`], which the owner answers with the values that hold then, and a change is told
//! to all with [`ReconfigureServer::set_config`].

use crate::{NodeError, NodeEvent, Reply, RosNode, REPLY_TIMEOUT};
use rcs_messages::dynamic_reconfigure::{Config, ConfigDescription, Reconfigure};
use rosrust::Publisher;
use std::collections::HashMap;
use std::sync::Arc;
use xml_rpc::Value;

/// Descriptions and values are few; the last one of each is kept for those who come later.
const QUEUE_SIZE: usize = 10;

/// Serves until it is dropped.
pub struct ReconfigureServer {
    name: Arc<str>,
    descriptions: Publisher<ConfigDescription>,
    updates: Publisher<Config>,
    _service: rosrust::Service,
    described: ConfigDescription,
    on_parameter_server: HashMap<String, Value>,
}

impl RosNode {
    /// Starts a dynamic_reconfigure server in `namespace`; it tells its first values.
    ///
    /// # Errors
    /// [`NodeError`] when the name is none or rosrust refuses.
    pub fn serve_reconfigure(
        &self,
        namespace: &str,
        description: ConfigDescription,
        config: Config,
    ) -> Result<ReconfigureServer, NodeError> {
        let name: Arc<str> = self.resolve(namespace)?.into();
        let (sender, server) = (self.shared.events.sender(0), Arc::clone(&name));
        let failed = |error| NodeError::ros(format!("cannot serve the parameters of {name}"), &error);
        let service = rosrust::service::<Reconfigure, _>(&format!("{name}/set_parameters"), move |request| {
            let (reply, answer) = Reply::new();
            sender.push(NodeEvent::Reconfigure { server: Arc::clone(&server), request, reply });
            answer.recv_timeout(REPLY_TIMEOUT).map_err(|_| format!("{server}: the node is busy"))
        });
        let mut server = ReconfigureServer {
            descriptions: latched(&format!("{name}/parameter_descriptions")).map_err(failed)?,
            updates: latched(&format!("{name}/parameter_updates")).map_err(failed)?,
            _service: service.map_err(failed)?,
            described: ConfigDescription::default(),
            on_parameter_server: HashMap::new(),
            name,
        };
        server.set_description(description);
        server.set_config(self, config);
        Ok(server)
    }
}

fn latched<T: rosrust::Message>(topic: &str) -> rosrust::api::error::Result<Publisher<T>> {
    let mut publisher = rosrust::publish::<T>(topic, QUEUE_SIZE)?;
    publisher.set_latching(true);
    Ok(publisher)
}

/// The values of a message, by name.
fn values(config: &Config) -> impl Iterator<Item = (&String, Value)> {
    let bools = config.bools.iter().map(|param| (&param.name, Value::Bool(param.value)));
    let ints = config.ints.iter().map(|param| (&param.name, Value::Int(param.value)));
    let strs = config.strs.iter().map(|param| (&param.name, Value::String(param.value.clone())));
    let doubles = config.doubles.iter().map(|param| (&param.name, Value::Double(param.value)));
    bools.chain(ints).chain(strs).chain(doubles)
}

impl ReconfigureServer {
    /// The whole name of its namespace.
    pub fn name(&self) -> &Arc<str> {
        &self.name
    }

    /// Tells what parameters there are, if that is something new.
    pub fn set_description(&mut self, description: ConfigDescription) {
        if description != self.described {
            if let Err(error) = self.descriptions.send(description.clone()) {
                log::warn!("{}: cannot describe the parameters: {error}", self.name);
            }
            self.described = description;
        }
    }

    /// Tells the values on the topic; those that are new are written to the parameter server, too.
    pub fn set_config(&mut self, ros: &RosNode, config: Config) {
        for (name, value) in values(&config) {
            if self.on_parameter_server.get(name) != Some(&value) {
                ros.param_writer.set(format!("{}/{name}", self.name), value.clone());
                self.on_parameter_server.insert(name.clone(), value);
            }
        }
        if let Err(error) = self.updates.send(config) {
            log::warn!("{}: cannot tell the parameters: {error}", self.name);
        }
    }
}
