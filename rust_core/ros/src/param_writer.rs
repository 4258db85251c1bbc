//! Writing parameters on a thread of its own, because the master may be slow.
//!
//! Only the newest value of each parameter waits, so that a master that hangs costs no memory.

use crate::network::Network;
use crate::xmlrpc::Value;
use std::collections::VecDeque;
use std::panic::{catch_unwind, AssertUnwindSafe};
use std::sync::{Arc, Mutex};

use rcs_process::lock;

/// Whole name and value.
type Param = (String, Value);

/// Writer with a thread while values are waiting.
#[derive(Default)]
pub(crate) struct ParamWriter(Arc<Mutex<Waiting>>);

/// Parameters that are not written yet.
#[derive(Default)]
struct Waiting {
    params: VecDeque<Param>,
    has_thread: bool,
}

impl Waiting {
    fn put(&mut self, name: String, value: Value) {
        match self.params.iter_mut().find(|(waiting, _)| *waiting == name) {
            Some((_, old)) => *old = value,
            None => self.params.push_back((name, value)),
        }
    }

    /// The next parameter; without one the thread ends.
    fn next(&mut self) -> Option<Param> {
        let next = self.params.pop_front();
        self.has_thread = next.is_some();
        next
    }
}

impl ParamWriter {
    /// Sets a parameter soon, unless it is set to another value before. Failures are logged.
    pub(crate) fn set(&self, network: &Arc<Network>, name: String, value: Value) {
        let network = Arc::downgrade(network);
        self.set_with(name, value, move |name, value| {
            let Some(network) = network.upgrade() else { return };
            if let Err(error) = network.registrar().master().set_param(name, value) {
                log::warn!("parameter {name} cannot be set: {error}");
            }
        });
    }

    /// Calls `write` on the thread, for this parameter and those set meanwhile.
    fn set_with(&self, name: String, value: Value, write: impl Fn(&str, Value) + Send + 'static) {
        let mut waiting = lock(&self.0);
        waiting.put(name, value);
        if waiting.has_thread {
            return;
        }
        let shared = Arc::clone(&self.0);
        let writing = move || loop {
            let Some((name, value)) = lock(&shared).next() else { return };
            // A panic affects this value only.
            if catch_unwind(AssertUnwindSafe(|| write(&name, value))).is_err() {
                log::error!("parameter {name} cannot be set: writing it panicked");
            }
        };
        match std::thread::Builder::new().name("ros-params".to_owned()).spawn(writing) {
            Ok(_) => waiting.has_thread = true,
            Err(error) => log::warn!("parameters cannot be set: {error}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::channel;

    #[test]
    fn of_each_parameter_only_the_newest_value_waits_for_a_slow_master() {
        let writer = ParamWriter::default();
        let (written, is_written) = channel();
        let (answer, answers) = channel::<()>();
        writer.set_with("/first".to_owned(), Value::Int(0), move |name, value| {
            written.send((name.to_owned(), value)).unwrap();
            answers.recv().unwrap();
        });
        let next = || is_written.recv_timeout(crate::socket::TEST_PATIENCE).unwrap();
        assert_eq!(next(), ("/first".to_owned(), Value::Int(0)));
        // The thread waits for an answer.
        for value in 0..1000 {
            for name in ["/a", "/b"] {
                writer.set_with(name.to_owned(), Value::Int(value), |_, _| {});
            }
        }
        assert_eq!(lock(&writer.0).params.len(), 2);
        answer.send(()).unwrap();
        assert_eq!(next(), ("/a".to_owned(), Value::Int(999)));
        answer.send(()).unwrap();
        assert_eq!(next(), ("/b".to_owned(), Value::Int(999)));
        answer.send(()).unwrap();
    }

    #[test]
    fn a_panic_costs_one_value_and_the_next_ones_are_written() {
        let writer = ParamWriter::default();
        let (written, is_written) = channel();
        let set = |name: &str| {
            let written = written.clone();
            writer.set_with(name.to_owned(), Value::Int(1), move |name, _| {
                assert_ne!(name, "/bad");
                written.send(name.to_owned()).unwrap();
            });
        };
        set("/bad");
        set("/good");
        assert_eq!(is_written.recv_timeout(crate::socket::TEST_PATIENCE).unwrap(), "/good");
    }
}
