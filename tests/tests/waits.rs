//! Every wait has a limit, and every queue between threads a bound, as [reliability](../../docs/reliability.md) says.
//!
//! clippy.toml forbids waits without a limit and channels without a bound. What no lint sees is searched for here.

use rcs_tests::sources::sources;

/// Queues that compare no length, and what bounds them.
const BOUND_OTHERWISE: [(&str, &str); 2] = [
    ("rust_core/ros/src/param_writer.rs", "has one entry for each name of a setting"),
    ("rust_core/transforms/src/history.rs", "is as long as a period"),
];

/// What has a method `wait` of this project's own, or of wgpu with a limit: what it waits for is found where that is.
const OWN_WAITS: [&str; 7] = ["self", "shared", "events()", "calls()", "pacing", "window", "device"];

/// What is allowed: where (a file or a folder), what, and why nothing hangs by it.
const ALLOWED: [(&str, &str, &str); 9] = [
    ("ros/src/acceptor.rs", ".accept()", "the socket does not block: `poll` has waited"),
    ("scene/src/waits.rs", ".join()", "the thread has ended"),
    ("calibrate/src/manual/questions.rs", "stdin()", "a user's answer; a signal ends the program"),
    ("ros/src/network.rs", ".to_socket_addrs()", "the resolver has limits; the start can be cancelled"),
    ("ros/src/xmlrpc/client.rs", ".to_socket_addrs()", "the resolver has limits; the caller has its own thread"),
    ("ros/src/tcpros/subscription.rs", ".to_socket_addrs()", "the same"),
    ("render/src/gpu/device.rs", "block_on(", "the GPU's driver, at the start; the second signal ends the program"),
    ("window/src/", ".roundtrip(", "the window's own thread, which the watchdog and WindowWatch look after"),
    ("window/src/", ".reply()", "the same"),
];

/// Everything that is put at the end of a queue, and what bounds that queue: a piece of the same file's code without
/// blanks.
const QUEUES: [(&str, &str); 24] = [
    ("camera_stream/src/scene/lazy_streams.rs", "arrivals.len()>=MESSAGES"),
    ("camera_stream/src/runtime/scene_thread.rs", "in_flight.len()>=self.renderer.frames_at_once()"),
    ("logging/src/lines.rs", "self.lines.len()>=MOST_LINES"),
    ("calibrate/src/clicks.rs", "waiting.len()==QUEUE_SIZE"),
    ("scan/src/compare.rs", "self.differences.len()>ALIKE_DIFFERENCES"),
    ("scan/src/measure_light.rs", "last.len()>AVERAGED"),
    ("samples/src/target/waiting.rs", "self.0.len()>=MOST_WAITING"),
    // A row of filters, which takes and gives one at a time.
    ("calibration/src/decode/mod.rs", "fnpush_back("),
    // Each of the picture's rims once.
    ("calibration/src/verification/rims.rs", "queue.pop_front()"),
    ("camera/src/picture_rate.rs", "self.published.len()==PICTURES"),
    ("displays/src/classes/depth_cloud/pairs.rs", "images.len()<=self.queue_size"),
    ("displays/src/classes/effort.rs", "self.shown.len()>=self.settings.history_lengthasusize"),
    ("displays/src/classes/interactive_markers/server.rs", "self.updates.len()>=MAX_UPDATES"),
    ("displays/src/framework/arrivals.rs", "self.on_the_way.len()>=MOST_WAITING"),
    ("displays/src/framework/message_cache.rs", "kept.len()>=most_kept(message.kind())"),
    // As many messages as the user asks for, in rviz without a bound, too.
    ("displays/src/parts/history.rs", "self.counts.len()>=self.length"),
    // As many pictures as a renderer works on at once.
    ("render/src/cpu/mod.rs", "self.finished.pop_front()"),
    ("render/src/gpu/mod.rs", "self.in_flight.pop_front()"),
    ("ros/src/events.rs", "queue_size.min(MOST_QUEUED)"),
    // One for each name of a setting.
    ("ros/src/param_writer.rs", "|(waiting,_)|*waiting==name"),
    ("ros/src/rosout.rs", "queue.lines.len()>=MAX_LINES"),
    ("ros/src/tcpros/publication.rs", "queue.len()>=queue_size"),
    // Ten seconds.
    ("transforms/src/history.rs", "stamp.saturating_add(cache_length)<newest"),
    ("transforms/src/waiting.rs", "self.messages.len()>self.queue_size"),
];

/// Where a call stands in code without blanks, in which it may follow a keyword directly: not as the end of a longer
/// name, nor as a method.
fn calls<'a>(code: &'a str, call: &'a str) -> impl Iterator<Item = usize> + 'a {
    let starts = |at: &usize| !code[..*at].ends_with(['_', '.']);
    code.match_indices(call).map(|(at, _)| at).filter(starts)
}

/// What stands between the parenthesis at the end of a call and the one that closes it.
fn arguments(after_parenthesis: &str) -> &str {
    let mut depth = 1;
    let end = after_parenthesis.find(|letter| {
        depth += i32::from(letter == '(') - i32::from(letter == ')');
        depth == 0
    });
    &after_parenthesis[..end.unwrap_or(after_parenthesis.len())]
}

/// The calls in this code, with blanks taken out, that wait without a limit or make a channel without a bound.
fn endless(code: &str) -> Vec<&'static str> {
    let mut found: Vec<&str> = Vec::new();
    for call in UNBOUNDED.iter().chain(&ENDLESS) {
        found.extend(calls(code, call).map(|_| *call));
    }
    // A condition variable's and a process's `wait`.
    let is_own = |at: usize| OWN_WAITS.iter().any(|own| code[..at].ends_with(own));
    found.extend(code.match_indices(".wait(").filter(|(at, _)| !is_own(*at)).map(|_| ".wait("));
    let without_limit = |at: &usize| arguments(&code[at + "poll(".len()..]).trim_end_matches(',').ends_with("None");
    found.extend(calls(code, "poll(").filter(without_limit).map(|_| "poll(…, None)"));
    found
}

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
        let unlimited = code.split("WaitingQueue::new(").skip(1).find(|rest| !rest.starts_with("bounded("));
        assert!(unlimited.is_none(), "{file} has a WaitingQueue that may be unlimited");
    }
}
