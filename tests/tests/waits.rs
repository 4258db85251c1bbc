//! Every wait has a limit, and every queue between threads a bound, as
//! [reliability](../../docs/explanation/reliability.md) says.
//!
//! clippy.toml forbids waits without a limit and channels without a bound. What no lint sees is searched for here.

use rcs_tests::sources::sources;

/// Queues that compare no length, and what bounds them.
const BOUND_OTHERWISE: [(&str, &str); 3] = [
    ("rust_core/render/src/gpu/mod.rs", "has the images that its caller has in flight"),
    ("rust_core/ros/src/param_writer.rs", "has one entry for each name of a setting"),
    ("rust_core/transforms/src/history.rs", "is as long as a period"),
];

#[test]
fn every_limit_is_given() {
    for (file, code) in sources() {
        let mut polls = code.split("poll(").skip(1).filter_map(|rest| rest.split(';').next());
        let unlimited = polls.find(|rest| rest.contains(",None)") || rest.contains(",None,)"));
        assert_eq!(unlimited, None, "{file}");
        for timeout in [".set_read_timeout(None)", ".set_write_timeout(None)"] {
            assert!(!code.contains(timeout), "{file} has {timeout}");
        }
    }
}

#[test]
fn every_queue_has_a_bound() {
    let sources = sources();
    let with_queue: Vec<_> = sources.iter().filter(|(_, code)| code.contains("push_back(")).collect();
    assert!(with_queue.len() > 10, "{} queues", with_queue.len());
    for (file, code) in with_queue {
        let is_compared = [">", ">=", "==", "<="].iter().any(|sign| code.contains(&format!(".len(){sign}")));
        let is_bound_otherwise = BOUND_OTHERWISE.iter().any(|(other, _)| other == file);
        assert!(is_compared || is_bound_otherwise, "{file} has a queue: what bounds it?");
    }
    // A queue size without a limit in rviz has one here.
    for (file, code) in &sources {
        let unlimited = code
            .split("WaitingQueue::new(")
            .skip(1)
            .find(|rest| !["bounded(", "QUEUE_SIZE)"].iter().any(|start| rest.starts_with(start)));
        assert!(unlimited.is_none(), "{file} has a WaitingQueue that may be unlimited");
    }
}
