//! Calls of services of rospy and of this project's own node.

use std::time::Instant;

use crate::probe;
use rcs_tests::ros::{wait_until, RosMaster, PATIENCE, PROMPT};
use rcs_tests::ros_fixture::master_and_python;

/// A rospy server of three services: one answers, one fails, one hangs.
const SERVER: &str = "
from std_srvs.srv import Trigger, TriggerResponse, SetBool
def fail(_): raise ValueError('it is Sunday')
rospy.Service('/answers', Trigger, lambda _: TriggerResponse(True, 'grüße'))
rospy.Service('/fails', Trigger, fail)
rospy.Service('/hangs', Trigger, lambda _: time.sleep(1000))
rospy.Service('/other', SetBool, lambda _: None)
";

/// Waits until the master knows the probe's service: it registers beside what the node does.
fn wait_for_service(master: &RosMaster) {
    let is_known = || master.output("rosservice", &["list"]).unwrap().contains("/probe_trigger");
    assert!(wait_until(PATIENCE, is_known));
}

#[test]
fn a_service_is_called_and_its_faults_are_told_in_words() {
    let (master, _python) = master_and_python(SERVER);
    let call = |service: &str, timeout: &str| {
        let mut probe = probe(&master, &["call", service, timeout]);
        probe.wait(PATIENCE).unwrap();
        probe.lines().first().cloned().unwrap_or_else(|| format!("{:?}", probe.errors()))
    };
    assert_eq!(call("/answers", "60"), "answer true grüße");
    assert_eq!(call("/nobody", "60"), "error calling /nobody failed: no node offers it");
    let error = call("/fails", "60");
    assert!(error.starts_with("error calling /fails failed: it answered with an error: "), "{error}");
    assert!(error.contains("it is Sunday"), "{error}");
    let error = call("/other", "60");
    assert!(error.starts_with("error calling /other failed: it refused the call: "), "{error}");
    let started = Instant::now();
    assert_eq!(call("/hangs", "0.3"), "error calling /hangs failed: it did not answer in time");
    assert!(started.elapsed() < PROMPT);
    let listening = probe(&master, &["listen", "__name:=own"]);
    assert!(listening.line_with("ready").is_some());
    wait_for_service(&master);
    assert_eq!(call("/probe_trigger", "60"), "answer true received by /own");
}

#[test]
fn a_server_that_died_is_an_error() {
    let master = RosMaster::start().unwrap();
    let listening = probe(&master, &["listen", "__name:=own"]);
    assert!(listening.line_with("ready").is_some());
    wait_for_service(&master);
    // Killed, so that it stays registered.
    drop(listening);
    let mut probe = probe(&master, &["call", "/probe_trigger", "60"]);
    probe.wait(PATIENCE).unwrap();
    let line = probe.line_with("error").unwrap();
    assert!(line.starts_with("error calling /probe_trigger failed: its node at http://127.0.0.1:"), "{line}");
}
