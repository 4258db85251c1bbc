//! Unregistering in batches.
//!
//! rosmaster takes several calls in one (`system.multicall`, an extension of XML-RPC), so that a node with hundreds of
//! topics ends in time. A master that refuses gets one call after the other.

use std::time::Instant;

use rcs_process::lock;

use super::entry::Entry;
use super::Registrar;
use crate::xmlrpc::CallError;

/// Registrations in a batch.
const BATCH: usize = 1000;

impl Registrar {
    /// Unregisters what is no longer wanted, if there are several entries and the master takes several calls at once.
    ///
    /// # Errors
    /// The master does not answer.
    pub(super) fn unregister_together(&self) -> Result<(), CallError> {
        loop {
            let surplus: Vec<Entry> = {
                let state = lock(&self.state);
                let surplus = state.registered.difference(&state.wanted).take(BATCH);
                if state.has_no_batches {
                    Vec::new()
                } else {
                    surplus.cloned().collect()
                }
            };
            if surplus.len() < 2 {
                return Ok(());
            }
            let calls: Vec<_> = surplus.iter().map(|entry| self.unregistration(entry)).collect();
            let result = self.master.call_together(&calls);
            let mut state = lock(&self.state);
            match result {
                Ok(()) => state.registered.retain(|entry| !surplus.iter().any(|other| other.shares_place(entry))),
                Err(error) if matches!(error, CallError::Connection(_)) => return Err(error),
                Err(_) => state.has_no_batches = true,
            }
            state.answered = Some(Instant::now());
            drop(state);
            self.changed.notify_all();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Master;
    use super::*;
    use crate::xmlrpc::{parse_call, Server, Value};
    use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
    use std::sync::Arc;
    use std::time::Duration;

    /// Registrations left after the end at a master that needs 0.3 s for each call.
    fn left_at_a_slow_master(takes_batches: bool) -> usize {
        let (is_slow, registered) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicUsize::new(0)));
        let (slow, count) = (Arc::clone(&is_slow), Arc::clone(&registered));
        let server = Server::start("master", "127.0.0.1:0".parse().unwrap(), move |text| {
            if slow.load(Ordering::Acquire) {
                std::thread::sleep(Duration::from_millis(300));
            }
            let (method, params) = parse_call(text).unwrap();
            match method.as_str() {
                "registerPublisher" => drop(count.fetch_add(1, Ordering::AcqRel)),
                "unregisterPublisher" => drop(count.fetch_sub(1, Ordering::AcqRel)),
                "system.multicall" if takes_batches => {
                    let calls = params[0].as_array().unwrap();
                    count.fetch_sub(calls.len(), Ordering::AcqRel);
                    let Value::Struct(call) = &calls[0] else { panic!("{calls:?}") };
                    assert_eq!(call["methodName"].as_str(), Some("unregisterPublisher"));
                    assert_eq!(call["params"].as_array().unwrap().len(), 3);
                    return Value::Array(Vec::new());
                }
                "system.multicall" => return Value::Other("fault", String::new()),
                _ => {}
            }
            Value::Array(vec![Value::Int(1), "".into(), "http://127.0.0.1:1/".into()])
        });
        let server = server.unwrap();
        let master = Master {
            uri: format!("http://{}/", server.address()),
            node_name: "/node".to_owned(),
            node_uri: "http://127.0.0.1:1/".to_owned(),
        };
        let registrar = Registrar::new(master, Arc::default(), |_| {});
        let running = Arc::clone(&registrar);
        std::thread::spawn(move || running.run());
        for number in 0..200 {
            let (topic, ros_type) = (format!("/view{number}"), "sensor_msgs/Image".to_owned());
            registrar.add(Entry::Publisher { topic, ros_type, number });
        }
        let begin = Instant::now();
        while registered.load(Ordering::Acquire) < 200 {
            assert!(begin.elapsed() < crate::socket::TEST_PATIENCE);
            std::thread::sleep(Duration::from_millis(10));
        }
        is_slow.store(true, Ordering::Release);
        // Time for sixteen calls.
        registrar.end(Duration::from_secs(5), Duration::from_secs(5));
        registered.load(Ordering::Acquire)
    }

    #[test]
    fn hundreds_of_topics_are_unregistered_in_time_at_a_slow_master() {
        assert_eq!(left_at_a_slow_master(true), 0);
        assert!((150..200).contains(&left_at_a_slow_master(false)), "one after the other, as long as there is time");
    }
}
