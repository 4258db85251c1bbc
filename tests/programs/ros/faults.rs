//! Publishers and masters that hang, break or come back; peers that send garbage.

use crate::probe;
use crate::raw::{call, hanging_publisher, header, node_uri, topic_port};
use rcs_tests::ros::{wait_until, RosMaster, Running, PATIENCE};
use std::fs;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::time::{Duration, Instant};

const POINT: &str = "geometry_msgs/PointStamped";
/// Connections that send garbage, those that say nothing, and the memory that may be left of them.
const GARBAGE: usize = 805;
const SILENT: usize = 200;
const LEFT_KB: u64 = 30_000;

fn publish_points(master: &RosMaster, topic: &str, frame: &str) -> Running {
    let message = format!("{{header: {{frame_id: {frame}}}}}");
    Running::start(master.command("rostopic").args(["pub", "-r", "20", topic, POINT, &message])).unwrap()
}

fn descriptors_and_threads(program: &Running) -> [usize; 2] {
    ["fd", "task"].map(|kind| fs::read_dir(format!("/proc/{}/{kind}", program.id())).unwrap().count())
}

/// Its resident memory.
fn memory_kb(program: &Running) -> u64 {
    let status = fs::read_to_string(format!("/proc/{}/status", program.id())).unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    line.trim().trim_end_matches(" kB").parse().unwrap()
}

#[test]
fn a_dead_publishers_name_is_one_warning() {
    let master = RosMaster::start().unwrap();
    // A node with two topics, at one address.
    let listener = hanging_publisher(&master, "/dead", "/a", POINT);
    let uri = format!("http://{}/", listener.local_addr().unwrap());
    call(&master.uri(), "registerPublisher", &["/dead", "/b", POINT, &uri]).unwrap();
    drop(listener);
    let probe = probe(&master, &["listen", "/a", POINT, "1", "/b", POINT, "1"]);
    let warnings = || probe.errors().iter().filter(|line| line.starts_with("WARN")).count();
    assert!(wait_until(PATIENCE, || warnings() > 0));
    std::thread::sleep(Duration::from_secs(4));
    println!("{} lines after 4 s", probe.errors().len());
    assert_eq!(warnings(), 1, "{:?}", probe.errors());
    let warning = probe.errors().into_iter().find(|line| line.starts_with("WARN")).unwrap();
    let expected = format!("WARN Failed to contact publisher [/dead] at {uri} for topics [/a], [/b]: ");
    assert!(warning.starts_with(&expected) && warning.contains("refused"), "{warning}");
    assert!(probe.errors().iter().all(|line| !line.starts_with("ERROR")), "{:?}", probe.errors());
}

#[test]
fn a_master_that_hangs_stops_neither_messages_nor_the_end() {
    let master = RosMaster::start().unwrap();
    let mut probe = probe(&master, &["listen", "/a", POINT, "1"]);
    let _points = publish_points(&master, "/a", "seen");
    assert!(probe.line_with("frame seen").is_some());
    master.signal("STOP");
    std::thread::sleep(Duration::from_secs(3));
    assert!(probe.prints_again("frame seen"));
    probe.end("TERM").unwrap();
    master.signal("CONT");
}

/// The address of a server that answers each request with the next of these, or says nothing where that is empty.
fn no_master(answers: &'static [&[u8]]) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let uri = format!("http://{}/", listener.local_addr().unwrap());
    std::thread::spawn(move || {
        let mut silent = Vec::new();
        for (stream, answer) in listener.incoming().zip(answers.iter().cycle()) {
            let mut stream = stream.unwrap();
            if answer.is_empty() {
                silent.push(stream);
                continue;
            }
            // All of the request, or what it has not read would break the connection.
            let (mut request, mut piece) = (String::new(), [0; 4096]);
            while !request.contains("</methodCall>") {
                let len = stream.read(&mut piece).unwrap_or_default();
                assert!(len > 0, "{request}");
                request += &String::from_utf8_lossy(&piece[..len]);
            }
            let _ = stream.write_all(answer);
        }
    });
    uri
}

#[test]
fn what_is_no_master_is_one_line() {
    const NOT_FOUND: &[u8] = b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n";
    const BUSY: &[u8] = b"HTTP/1.1 503 Service Unavailable\r\nContent-Length: 0\r\n\r\n";
    let master = RosMaster::reserve().unwrap();
    // What it answers, what the first line says of it, and the number of lines.
    let cases: [(&[&[u8]], &str, usize); 7] = [
        (&[NOT_FOUND], "404", 1),
        (&[b"\x16\x03\x01\x02\0\x01\0\x01\xfc\n\n\xff\xfe\r\n\r\n"], "not HTTP", 1),
        (&[b"SSH-2.0-OpenSSH_9.2p1 Debian-2\r\n"], "not HTTP", 1),
        (&[b"HTTP/1.1 200 OK\r\nContent-Length: 25\r\n\r\n<html>\n<body>It works!\n\n\n"], "not XML", 1),
        (&[b"HTTP/1.1 200 OK\r\nContent-Length: 99999999999\r\n\r\n"], "too long", 1),
        (&[b""], "timed out", 1),
        (&[NOT_FOUND, BUSY], "404", 2),
    ];
    let mut probes = cases.map(|(answers, reason, lines)| {
        let uri = no_master(answers);
        let mut command = master.environment(std::process::Command::new(env!("CARGO_BIN_EXE_ros_probe")));
        (Running::start(command.arg("listen").env("ROS_MASTER_URI", &uri)).unwrap(), uri, reason, lines)
    });
    assert!(wait_until(PATIENCE, || probes.iter().all(|(probe, .., lines)| probe.errors().len() >= *lines)));
    // Long enough for each to be asked again, also where that takes the time of a call without an answer.
    std::thread::sleep(Duration::from_secs(4));
    for (probe, uri, reason, lines) in &mut probes {
        let errors = probe.errors();
        println!("{errors:?}");
        assert!(errors.len() == *lines && errors[0].contains(*reason) && errors[0].contains(&*uri), "{errors:?}");
        probe.end("TERM").unwrap();
    }
}

#[test]
fn a_restarted_master_knows_everything_again_and_costs_nothing() {
    let mut master = RosMaster::start().unwrap();
    let probe = probe(&master, &["listen", "/a", POINT, "1"]);
    assert!(probe.line_with("ready").is_some());
    let is_known = |master: &RosMaster| {
        let answer = call(&master.uri(), "lookupService", &["/raw", "/probe_trigger"]);
        answer.is_ok_and(|xml| xml.contains("rosrpc://"))
    };
    assert!(wait_until(PATIENCE, || is_known(&master)));
    // It does not register again, as no node of roscpp or rospy does, and its connection is kept all the same.
    let _before = publish_points(&master, "/a", "before");
    assert!(probe.line_with("frame before").is_some(), "{:?}", probe.errors());
    let mut counts = Vec::new();
    for _ in 0..3 {
        master.restart().unwrap();
        let begin = Instant::now();
        assert!(wait_until(PATIENCE, || is_known(&master)), "{:?}", probe.errors());
        let took = begin.elapsed();
        assert!(probe.prints_again("frame before"), "{:?}", probe.errors());
        counts.push(descriptors_and_threads(&probe));
        println!("registered again after {took:.0?}, descriptors and threads: {:?}", counts.last());
    }
    let points = publish_points(&master, "/a", "after");
    assert!(probe.line_with("frame after").is_some(), "{:?}", probe.errors());
    drop(points);
    assert!(counts[2][0] <= counts[0][0] + 1 && counts[2][1] <= counts[0][1] + 1, "{counts:?}");
}

#[test]
fn a_second_node_of_the_name_has_its_services_when_the_first_has_ended() {
    let master = RosMaster::start().unwrap();
    let mut first = probe(&master, &["listen"]);
    assert!(first.line_with("ready").is_some());
    assert!(wait_until(PATIENCE, || master.output("rosservice", &["list"]).unwrap().contains("/probe_trigger")));
    let second = probe(&master, &["listen"]);
    assert!(second.line_with("ready").is_some());
    let begin = Instant::now();
    assert!(first.wait(PATIENCE).is_some(), "the first node still runs");
    println!("the first node ended {:.0?} after the second one was ready", begin.elapsed());
    assert!(
        first.errors().iter().any(|line| line.contains("new node registered with same name")),
        "{:?}",
        first.errors()
    );
    let printed = master.output("rosservice", &["call", "/probe_trigger", "{}"]).unwrap();
    assert!(printed.contains("success: True"), "{printed}");
}

#[test]
fn rosnode_info_lists_the_connections() {
    let master = RosMaster::start().unwrap();
    let probe = probe(&master, &["image", "/view/image", "64", "48", "10"]);
    let _viewer = crate::raw::subscribe(&master, "/probe", "/view/image", "/viewer");
    assert!(probe.line_with("subscriber /viewer").is_some());
    let printed = master.output("rosnode", &["info", "/probe"]).unwrap();
    for text in ["Connections:", "topic: /view/image", "to: /viewer", "direction: outbound", "transport: TCPROS"] {
        assert!(printed.contains(text), "{text}: {printed}");
    }
    let stats = call(&node_uri(&master, "/probe"), "getBusStats", &["/raw"]).unwrap();
    assert!(stats.contains("/view/image"), "{stats}");
}

/// roswtf reports a missing connection otherwise: the master names the node as publisher and as subscriber.
#[test]
fn a_topic_that_a_node_publishes_and_subscribes_to_is_a_connection_with_itself() {
    let master = RosMaster::start().unwrap();
    let probe = probe(&master, &["image", "/view/image", "64", "48", "10"]);
    assert!(probe.line_with("published").is_some(), "{:?}", probe.errors());
    let uri = node_uri(&master, "/probe");
    let info = call(&uri, "getBusInfo", &["/raw"]).unwrap();
    assert_eq!((info.matches("INTRAPROCESS").count(), info.matches("/view/camera_info").count()), (2, 2), "{info}");
    assert!(info.contains(">/probe<") && info.contains(&format!(">{uri}<")), "{info}");
    let printed = master.output("rosnode", &["info", "/probe"]).unwrap();
    for text in ["topic: /view/camera_info", "direction: inbound", "direction: outbound", "transport: INTRAPROCESS"] {
        assert!(printed.contains(text), "{text}: {printed}");
    }
}

#[test]
fn garbage_on_its_ports_leaves_nothing_behind() {
    let master = RosMaster::start().unwrap();
    let probe = probe(&master, &["image", "/view/image", "64", "48", "10"]);
    assert!(probe.line_with("ready").is_some());
    let topics = topic_port(&master, "/probe", "/view/image");
    let api: u16 = node_uri(&master, "/probe").trim_end_matches('/').rsplit(':').next().unwrap().parse().unwrap();
    let (before, memory_before) = (descriptors_and_threads(&probe), memory_kb(&probe));
    let deep = format!("<methodCall>{}", "<value><array><data>".repeat(20_000));
    let deep = format!("POST / HTTP/1.1\r\nContent-Length: {}\r\n\r\n{deep}", deep.len());
    let half = header(&[("callerid", "/x"), ("topic", "/view/image")]);
    let garbage: [(u16, &[u8]); 7] = [
        (topics, &u32::MAX.to_le_bytes()),
        (topics, &half[..half.len() / 2]),
        (topics, &[0, 0, 0]),
        (topics, &header(&[("service", "/none"), ("md5sum", "*")])),
        (api, deep.as_bytes()),
        (api, b"POST / HTTP/1.1\r\nContent-Length: 99999999999\r\n\r\n"),
        (api, b"\x16\x03\x01\x02\0\x01\0\x01\xfc"),
    ];
    let mut most_kb = memory_before;
    for _ in 0..GARBAGE / garbage.len() {
        for (port, bytes) in garbage {
            // It may be refused before all of it is written.
            let _ = TcpStream::connect(("127.0.0.1", port)).unwrap().write_all(bytes);
        }
        most_kb = most_kb.max(memory_kb(&probe));
    }
    // More that stay open and say nothing, longer than anything waits for them.
    let silent: Vec<TcpStream> =
        (0..SILENT).map(|index| TcpStream::connect(("127.0.0.1", [topics, api][index % 2])).unwrap()).collect();
    assert!(probe.prints_again("published"));
    most_kb = most_kb.max(memory_kb(&probe));
    let is_clean = || {
        let now = descriptors_and_threads(&probe);
        now[0] <= before[0] + 1 && now[1] <= before[1] + 1
    };
    assert!(wait_until(PATIENCE, is_clean), "{before:?} {:?}", descriptors_and_threads(&probe));
    drop(silent);
    let mut viewer = crate::raw::subscribe(&master, "/probe", "/view/image", "/viewer");
    crate::raw::read_framed(&mut viewer).unwrap();
    let after_kb = memory_kb(&probe);
    println!(
        "descriptors and threads {before:?}, then {:?}; {memory_before} kB, at most {most_kb} kB, then {after_kb} kB",
        descriptors_and_threads(&probe)
    );
    assert!(after_kb < memory_before + LEFT_KB, "{memory_before} kB, then {after_kb} kB");
}
