//! The name of the node that makes a live check: not the name of the node that it checks.
//!
//! A launch line may hold `__name:=X`, and two nodes of one name cannot run: the master ends the first. rosrust reads
//! the name from the process's arguments, so the process starts itself again with another name in them.

use std::ffi::OsString;
use std::io;

use rcs_ros::restart;

use crate::NODE_NAME;

/// ROS's special argument for the name.
const NAME_ARGUMENT: &str = "__name:=";

/// The names of the two nodes, without their namespace.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct NodeName {
    /// The name of this process's node.
    pub(crate) own: String,
    /// The name that the launch line gives to the node it starts.
    pub(crate) diagnosed: String,
}

impl NodeName {
    /// The names for this process. Where its arguments hold the other node's name, the process starts itself again with
    /// its own name in that place.
    ///
    /// # Errors
    /// When the process cannot start itself again.
    pub(crate) fn of_this_process() -> io::Result<Self> {
        let suffix = format!("_check_{}", std::process::id());
        let arguments: Vec<OsString> = std::env::args_os().collect();
        match renamed(&arguments, &suffix) {
            // Returns only if it fails. The process keeps its id, so it finds the name in place.
            Some(arguments) => Err(restart::<&str>(arguments.into_iter().skip(1), &[])),
            None => Ok(Self::from_arguments(&arguments, &suffix)),
        }
    }

    fn from_arguments(arguments: &[OsString], suffix: &str) -> Self {
        let given = arguments.iter().find_map(|argument| argument.to_str()?.strip_prefix(NAME_ARGUMENT));
        let diagnosed = given.and_then(|name| name.strip_suffix(suffix)).unwrap_or(NODE_NAME).to_owned();
        Self { own: format!("{diagnosed}{suffix}"), diagnosed }
    }
}

/// The arguments with the check's own name in place of the node's; `None` where no other name is given.
fn renamed(arguments: &[OsString], suffix: &str) -> Option<Vec<OsString>> {
    let is_other = |argument: &OsString| {
        argument.to_str().is_some_and(|text| text.starts_with(NAME_ARGUMENT) && !text.ends_with(suffix))
    };
    let rename = |argument: &OsString| {
        let mut argument = argument.clone();
        if is_other(&argument) {
            argument.push(suffix);
        }
        argument
    };
    arguments.iter().any(is_other).then(|| arguments.iter().map(rename).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_check_never_takes_the_name_of_the_node_that_it_checks() {
        let arguments = |name: &str| ["camera_stream", "check", name, "a:=b"].map(OsString::from).to_vec();
        let renamed = renamed(&arguments("__name:=eyes"), "_check_7").unwrap();
        assert_eq!(renamed, arguments("__name:=eyes_check_7"));
        assert_eq!(super::renamed(&renamed, "_check_7"), None, "once");
        let names = |own: &str, diagnosed: &str| NodeName { own: own.to_owned(), diagnosed: diagnosed.to_owned() };
        assert_eq!(NodeName::from_arguments(&renamed, "_check_7"), names("eyes_check_7", "eyes"));
        let unnamed = arguments("--live");
        assert_eq!(super::renamed(&unnamed, "_check_7"), None);
        assert_eq!(NodeName::from_arguments(&unnamed, "_check_7"), names("camera_stream_check_7", "camera_stream"));
    }
}
