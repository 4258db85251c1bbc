//! The name of the node that makes a live check: the launch line's name with a suffix.
//!
//! A launch line may hold `__name:=X`, and the master ends the first of two nodes of one name. The name is read
//! from the process's arguments, so the process restarts itself with another name in them.

use std::ffi::OsString;
use std::io;

use rcs_ros::restart;

use crate::NODE_NAME;

/// ROS's special argument for the name.
const NAME_ARGUMENT: &str = "__name:=";

/// The names of this process's node and of the one that it checks, without their namespace. Where the arguments hold
/// the latter, the process restarts itself with its own name in that place.
///
/// # Errors
/// The process cannot be restarted.
pub(super) fn node_names() -> io::Result<[String; 2]> {
    let suffix = format!("_check_{}", std::process::id());
    let mut arguments: Vec<OsString> = std::env::args_os().collect();
    let Some(checked) = rename(&mut arguments, &suffix) else {
        // Returns only if it fails. The process keeps its id, so it finds the name in place.
        return Err(restart::<&str>(arguments.into_iter().skip(1), &[]));
    };
    Ok([format!("{checked}{suffix}"), checked])
}

/// The name of the checked node, if this process's arguments have no name without the suffix; else adds the suffix.
fn rename(arguments: &mut [OsString], suffix: &str) -> Option<String> {
    let given = arguments.iter_mut().find(|argument| argument.to_string_lossy().starts_with(NAME_ARGUMENT));
    let Some(argument) = given else { return Some(NODE_NAME.to_owned()) };
    let checked = argument.to_str().and_then(|text| text.strip_prefix(NAME_ARGUMENT)?.strip_suffix(suffix));
    let checked = checked.map(str::to_owned);
    if checked.is_none() {
        argument.push(suffix);
    }
    checked
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_check_never_takes_the_name_of_the_node_that_it_checks() {
        let mut arguments = ["camera_stream", "check", "__name:=eyes", "a:=b"].map(OsString::from);
        assert_eq!(rename(&mut arguments, "_check_7"), None);
        assert_eq!(arguments, ["camera_stream", "check", "__name:=eyes_check_7", "a:=b"]);
        assert_eq!(rename(&mut arguments, "_check_7").as_deref(), Some("eyes"), "once");
        assert_eq!(rename(&mut ["check".into()], "_check_7").as_deref(), Some("camera_stream"));
    }
}
