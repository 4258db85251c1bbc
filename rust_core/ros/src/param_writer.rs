//! Writes parameters to the parameter server on a thread of its own, because the master may be slow to answer.

use crate::lock;
use crate::network::Network;
use crate::xmlrpc::Value;
use std::sync::mpsc::{channel, Sender};
use std::sync::{Arc, Mutex, Weak};

/// A whole name and a value.
type Param = (String, Value);

/// Started with the first parameter.
#[derive(Default)]
pub(crate) struct ParamWriter(Mutex<Option<Sender<Param>>>);

impl ParamWriter {
    /// Sets a parameter soon, after those that were set before. A failure is logged.
    pub(crate) fn set(&self, network: &Arc<Network>, name: String, value: Value) {
        let mut sender = lock(&self.0);
        let sent = sender.as_ref().is_some_and(|sender| sender.send((name.clone(), value.clone())).is_ok());
        if !sent {
            *sender = start(Arc::downgrade(network));
            // The thread has just begun; if there is none, `start` has logged that.
            let _ = sender.as_ref().map(|sender| sender.send((name, value)));
        }
    }
}

fn start(network: Weak<Network>) -> Option<Sender<Param>> {
    let (sender, params) = channel::<Param>();
    let writing = move || {
        for (name, value) in params {
            let Some(network) = network.upgrade() else { return };
            if let Err(error) = network.registrar().master().set_param(&name, value) {
                log::warn!("parameter {name} cannot be set: {error}");
            }
        }
    };
    match std::thread::Builder::new().name("ros-params".to_owned()).spawn(writing) {
        Ok(_) => Some(sender),
        Err(error) => {
            log::warn!("parameters cannot be set: {error}");
            None
        }
    }
}
