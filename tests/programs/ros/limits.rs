//! What strangers may take of a node: threads by naming publishers, connections, descriptors; and where it listens.

use crate::probe;
use crate::raw::{call_xml, node_uri, topic_port};
use rcs_tests::ros::{wait_until, RosMaster, Running, PATIENCE};
use std::collections::BTreeSet;
use std::fs;
use std::net::{TcpListener, TcpStream};
use std::process::Command;
use std::time::{Duration, Instant};

const POINT: &str = "geometry_msgs/PointStamped";

fn threads(program: &Running) -> usize {
    fs::read_dir(format!("/proc/{}/task", program.id())).unwrap().count()
}

/// Tells a node that a topic has publishers at these addresses, as the master does.
fn name_publishers(uri: &str, topic: &str, publishers: impl Iterator<Item = String>) {
    let values: String = publishers.map(|publisher| format!("<value><string>{publisher}</string></value>")).collect();
    let value = |text: &str| format!("<param><value><string>{text}</string></value></param>");
    let list = format!("<param><value><array><data>{values}</data></array></value></param>");
    let params = format!("{}{}{list}", value("/master"), value(topic));
    call_xml(uri, "publisherUpdate", &params).unwrap();
}

#[test]
fn thousands_of_made_up_publishers_are_a_few_hundred_threads_and_forgotten() {
    let master = RosMaster::start().unwrap();
    let probe = probe(&master, &["listen", "/a", POINT, "1"]);
    assert!(probe.line_with("ready").is_some());
    let mut publish = master.command("rostopic");
    let _points = Running::start(publish.args(["pub", "-r", "20", "/a", POINT, "{header: {frame_id: real}}"])).unwrap();
    assert!(probe.line_with("frame real").is_some(), "{:?}", probe.errors());
    let (uri, before) = (node_uri(&master, "/probe"), threads(&probe));
    // They accept and never answer.
    let silent = TcpListener::bind("0.0.0.0:0").unwrap();
    let port = silent.local_addr().unwrap().port();
    let mut most = before;
    for round in 0..4 {
        let address = |index: usize| format!("http://127.{}.{}.{round}:{port}/", 1 + index / 200, 1 + index % 200);
        name_publishers(&uri, "/a", (0..6000).map(address));
        most = most.max(threads(&probe));
        assert!(threads(&probe) < before + 600, "{}", threads(&probe));
    }
    let warnings = || probe.errors().iter().filter(|line| line.contains("6000 publishers are named")).count();
    assert!(wait_until(PATIENCE, || warnings() == 1), "{:?}", probe.errors());
    // They do not answer, so the master is asked again, and those that it does not name are forgotten.
    let (begin, is_forgotten) = (Instant::now(), || threads(&probe) <= before + 2);
    assert!(wait_until(PATIENCE, is_forgotten), "{before} {}", threads(&probe));
    println!("{before} threads, then {most}, then {} after {:.1?}", threads(&probe), begin.elapsed());
    assert!(probe.prints_again("frame real"), "{:?}", probe.errors());
    assert_eq!(warnings(), 1, "{:?}", probe.errors());
}

#[test]
fn connections_that_cannot_be_served_are_one_warning_and_then_others_are() {
    let master = RosMaster::start().unwrap();
    let probe = probe(&master, &["image", "/view/image", "64", "48", "10"]);
    assert!(probe.line_with("ready").is_some());
    let topics = topic_port(&master, "/probe", "/view/image");
    let id = probe.id().to_string();
    let status = Command::new("prlimit").args(["--pid", &id, "--nofile=40:40"]).status().unwrap();
    assert!(status.success());
    let viewers: Vec<TcpStream> = (0..60).map(|_| TcpStream::connect(("127.0.0.1", topics)).unwrap()).collect();
    let warnings = || probe.errors().iter().filter(|line| line.contains("connections cannot be accepted")).count();
    assert!(wait_until(PATIENCE, || warnings() > 0), "{:?}", probe.errors());
    std::thread::sleep(Duration::from_secs(2));
    assert_eq!(warnings(), 1, "{:?}", probe.errors());
    let begin = Instant::now();
    drop(viewers);
    crate::raw::read_framed(&mut crate::raw::subscribe(&master, "/probe", "/view/image", "/viewer")).unwrap();
    println!("a picture {:.0?} after the others have left", begin.elapsed());
}

/// The addresses at which a program listens, as Linux lists them: `0100007F` is 127.0.0.1.
fn listening_addresses(program: &Running) -> BTreeSet<String> {
    let folder = format!("/proc/{}", program.id());
    let descriptors = fs::read_dir(format!("{folder}/fd")).unwrap();
    let links = descriptors.filter_map(|entry| fs::read_link(entry.ok()?.path()).ok());
    let sockets: BTreeSet<String> = links.map(|link| link.to_string_lossy().into_owned()).collect();
    let tables = ["tcp", "tcp6"].map(|kind| fs::read_to_string(format!("{folder}/net/{kind}")).unwrap_or_default());
    let lines = tables.iter().flat_map(|table| table.lines().skip(1));
    let listening = lines.map(|line| line.split_whitespace().collect::<Vec<_>>());
    // Number, local address, remote address, state (0A: listening), six more, inode.
    let own = listening.filter(|fields| fields[3] == "0A" && sockets.contains(&format!("socket:[{}]", fields[9])));
    own.map(|fields| fields[1].split(':').next().unwrap_or_default().to_owned()).collect()
}

#[test]
fn a_node_listens_where_variables_or_its_arguments_say_and_warns_where_it_cannot() {
    let master = RosMaster::start().unwrap();
    let (local, own, any) = ("0100007F", "0200007F", "00000000");
    for (variables, argument, address, warnings) in [
        (&[("ROS_IP", "127.0.0.1")][..], "", local, 0),
        (&[("ROS_IP", "")], "", any, 0),
        // An address of a network for examples.
        (&[("ROS_IP", "192.0.2.1")], "", any, 1),
        (&[("ROS_IP", "127.0.0.2")], "", own, 0),
        (&[("ROS_HOSTNAME", "127.0.0.2")], "", own, 0),
        (&[("ROS_HOSTNAME", "localhost")], "", local, 0),
        // A name counts for more than an address, and an argument for more than either.
        (&[("ROS_HOSTNAME", "127.0.0.2"), ("ROS_IP", "127.0.0.3")], "", own, 0),
        (&[("ROS_HOSTNAME", "localhost")], "__hostname:=127.0.0.2", own, 0),
        (&[("ROS_IP", "127.0.0.3")], "__ip:=127.0.0.2", own, 0),
    ] {
        let mut command = master.environment(Command::new(env!("CARGO_BIN_EXE_ros_probe")));
        command.env_remove("ROS_IP").envs(variables.iter().copied()).arg("listen");
        let probe = Running::start(command.args(Some(argument).filter(|argument| !argument.is_empty()))).unwrap();
        // Then its topics are announced at the address.
        assert!(probe.line_with("ready").is_some(), "{:?}", probe.errors());
        let found = listening_addresses(&probe);
        assert_eq!(found, BTreeSet::from([address.to_owned()]), "{variables:?} {argument}: {:?}", probe.errors());
        let is_warning = |line: &&String| line.starts_with("WARN") && line.contains("listening at all");
        assert_eq!(probe.errors().iter().filter(is_warning).count(), warnings, "{:?}", probe.errors());
    }
}
