//! Where a program listens, by the names and addresses that ROS knows for it.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::process::Command;

use rcs_tests::programs::{program, repository};
use rcs_tests::ros::{wait_until, RosMaster, Running, PATIENCE};

/// How many ports a program listens on at each address, as Linux lists them: `0100007F` is 127.0.0.1.
fn ports(program: &Running) -> BTreeMap<String, usize> {
    let folder = format!("/proc/{}", program.id());
    let Ok(descriptors) = fs::read_dir(format!("{folder}/fd")) else { return BTreeMap::new() };
    let links = descriptors.filter_map(|entry| fs::read_link(entry.ok()?.path()).ok());
    let sockets: BTreeSet<String> = links.map(|link| link.to_string_lossy().into_owned()).collect();
    let mut found = BTreeMap::new();
    for table in ["tcp", "tcp6"].map(|kind| fs::read_to_string(format!("{folder}/net/{kind}")).unwrap_or_default()) {
        for fields in table.lines().skip(1).map(|line| line.split_whitespace().collect::<Vec<_>>()) {
            // Number, local address, remote address, state (0A: listening), six more, inode.
            if fields[3] == "0A" && sockets.contains(&format!("socket:[{}]", fields[9])) {
                *found.entry(fields[1].split(':').next().unwrap_or_default().to_owned()).or_default() += 1;
            }
        }
    }
    found
}

#[test]
fn a_node_listens_at_the_address_of_ros_hostname_or_of_its_arguments_and_at_no_other() {
    let master = RosMaster::start().unwrap();
    let own = BTreeMap::from([("0200007F".to_owned(), 2)]);
    let local = BTreeMap::from([("0100007F".to_owned(), 2)]);
    for (variables, argument, expected) in [
        (&[("ROS_HOSTNAME", "127.0.0.2")][..], "", &own),
        (&[("ROS_IP", "127.0.0.2")], "", &own),
        (&[("ROS_HOSTNAME", "localhost")], "", &local),
        // A name counts for more than an address, and an argument for more than either.
        (&[("ROS_HOSTNAME", "127.0.0.2"), ("ROS_IP", "127.0.0.3")], "", &own),
        (&[("ROS_HOSTNAME", "localhost")], "__hostname:=127.0.0.2", &own),
        (&[("ROS_IP", "127.0.0.3")], "__ip:=127.0.0.2", &own),
    ] {
        let mut command = master.environment(Command::new(program("projector")));
        command.env_remove("ROS_IP").env_remove("ROS_HOSTNAME").envs(variables.iter().copied());
        command.arg(repository().join("config/projector.yaml"));
        let mut node = Running::start(command.args(Some(argument).filter(|argument| !argument.is_empty()))).unwrap();
        // Its topics are announced at the address.
        let is_registered = || master.output("rosnode", &["list"]).is_ok_and(|nodes| nodes.contains("/projector"));
        assert!(wait_until(PATIENCE, is_registered), "{:?}", node.errors());
        assert_eq!(ports(&node), *expected, "{variables:?} {argument}: {:?}", node.errors());
        node.signal("TERM");
        assert!(node.wait(PATIENCE).is_some());
    }
}
