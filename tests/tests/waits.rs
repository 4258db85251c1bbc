//! Every wait has a limit, and every queue between threads a bound, as [reliability](../../docs/reliability.md) says.
//!
//! The programs' sources are searched for what waits for as long as it takes and for channels without a bound. What is
//! allowed all the same is listed here, with the reason.

use std::collections::BTreeMap;

use rcs_tests::sources::{code, missing, sources};

/// Channels that hold as much as is sent into them.
const UNBOUNDED: [&str; 4] = ["channel()", "channel::<", "unbounded(", "unbounded_channel("];

/// Calls that wait for as long as it takes. Those of `wait` and `poll` are looked at more closely, see [`endless`].
const ENDLESS: [&str; 19] = [
    ".recv()",
    ".wait_while(",
    ".join()",
    ".accept()",
    ".incoming()",
    ".output()",
    ".wait_with_output()",
    ".forever()",
    "block_on(",
    ".reply()",
    ".roundtrip(",
    ".blocking_dispatch(",
    ".wait_for_event()",
    "stdin()",
    "thread::park()",
    "TcpStream::connect(",
    ".to_socket_addrs()",
    ".set_read_timeout(None)",
    ".set_write_timeout(None)",
];

/// What has a method `wait` of this project's own, or of wgpu with a limit: what it waits for is found where that is.
const OWN_WAITS: [&str; 7] = ["self", "shared", "events()", "calls()", "pacing", "window", "device"];

/// What is allowed: where (a file or a folder), what, and why nothing hangs by it.
const ALLOWED: [(&str, &str, &str); 11] = [
    ("ros/src/acceptor.rs", ".accept()", "the socket does not block: `poll` has waited"),
    ("scene/src/threads.rs", ".join()", "the thread has ended"),
    ("app/src/projector_calibrate/manual/questions.rs", ".forever()", "a thread that only hands on a signal"),
    ("app/src/projector_calibrate/show.rs", ".forever()", "the same"),
    ("app/src/projector_calibrate/manual/questions.rs", "stdin()", "a user's answer; a signal ends the program"),
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
    ("scan/src/compare.rs", "self.differences.len()>LIKE_DIFFERENCES"),
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
    ("displays/src/framework/arrivals.rs", "self.pending.len()>=MOST_WAITING"),
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
fn waits_without_a_limit_and_queues_without_a_bound_are_recognised() {
    for (text, what) in [
        ("let (sender, receiver) = mpsc::channel();", "channel()"),
        ("let (open, is_closed) = channel::<()>();", "channel::<"),
        ("let (s, r) = crossbeam_channel::unbounded();", "unbounded("),
        ("let next = receiver\n    .recv()\n    .ok();", ".recv()"),
        ("guard = self.changed.wait(guard);", ".wait("),
        ("let _ = running.child.wait();", ".wait("),
        ("let guard = changed.wait_while(guard, is_idle);", ".wait_while("),
        ("match poll(&mut descriptors, None) {", "poll(…, None)"),
        ("rustix::event::poll(\n    &mut [PollFd::new(&stream, flags())],\n    None,\n)?;", "poll(…, None)"),
        ("let _ = thread.join();", ".join()"),
        ("let (stream, _) = listener.accept()?;", ".accept()"),
        ("TcpStream::connect(address)?", "TcpStream::connect("),
        ("stream.set_read_timeout(None)?;", ".set_read_timeout(None)"),
    ] {
        assert_eq!(endless(&code(text)), [what], "{text}");
    }
    for text in [
        "let (done, is_done) = sync_channel(1);",
        "let (open, is_closed) = mpsc::sync_channel::<()>(0);",
        "let red = layout.channel(\"r\");",
        "while let Ok(next) = receiver.recv_timeout(PERIOD) {}",
        "for event in node.events().wait(PERIOD) {}",
        "let guard = wait_while(&self.changed, guard, is_idle);",
        "let (guard, _) = changed.wait_timeout(guard, PERIOD)?;",
        "match poll(&mut descriptors, Some(&IDLE_TIMEOUT)) {",
        "let path = folder.join(name);",
        "// Not by thread.join().",
        "#[cfg(test)]\nmod tests {\n    thread.join().unwrap();\n}",
    ] {
        assert!(endless(&code(text)).is_empty(), "{text}: {:?}", endless(&code(text)));
    }
}

#[test]
fn every_wait_has_a_limit_and_every_channel_a_bound() {
    let mut used = [false; ALLOWED.len()];
    let mut wrong = Vec::new();
    for (file, code) in sources() {
        for what in endless(&code) {
            let is_this = |(place, allowed, _): &(&str, &str, &str)| {
                let name = file.strip_prefix("rust_core/").unwrap_or_default();
                *allowed == what && (name == *place || place.ends_with('/') && name.starts_with(place))
            };
            match ALLOWED.iter().position(is_this) {
                Some(row) => used[row] = true,
                None => wrong.push(format!("{file}: {what}")),
            }
        }
    }
    assert!(wrong.is_empty(), "without a limit or a bound:\n{}", wrong.join("\n"));
    for ((file, what, _), used) in ALLOWED.iter().zip(used) {
        assert!(used, "{file} no longer has {what}");
    }
}

#[test]
fn every_queue_has_a_bound() {
    let sources = sources();
    let with_queue = sources.iter().filter(|(_, code)| code.contains("push_back("));
    let found: BTreeMap<&str, &str> =
        with_queue.map(|(file, code)| (file.strip_prefix("rust_core/").unwrap_or_default(), code.as_str())).collect();
    for file in found.keys() {
        assert!(QUEUES.iter().any(|(known, _)| known == file), "{file} has a queue: what bounds it?");
    }
    for (file, bound) in QUEUES {
        let code = found.get(file).copied().unwrap_or_default();
        assert!(code.contains(bound), "{file} no longer has {bound}");
    }
    // A queue size without a limit in rviz has one here.
    for (file, code) in &sources {
        let unlimited = code.split("WaitingQueue::new(").skip(1).find(|rest| !rest.starts_with("bounded("));
        assert!(unlimited.is_none(), "{file} has a WaitingQueue that may be unlimited");
    }
}

/// Threads that have nothing to do wait for the same time.
#[test]
fn idle_threads_look_by_themselves() {
    let waits = [
        ("camera_stream/src/outputs/compressed.rs", "wait_while(&self.changed,"),
        ("logging/src/lines.rs", "wait_while(&self.changed,"),
        ("ros/src/acceptor.rs", "Some(&IDLE_TIMEOUT)"),
        ("ros/src/tcpros/publication.rs", "Some(&IDLE_TIMEOUT)"),
        ("ros/src/tcpros/subscription.rs", "set_read_timeout(Some(IDLE_PERIOD))"),
    ];
    assert_eq!(missing("rust_core", &waits), [""; 0]);
}
