//! `nav_msgs`.

use crate::geometry_msgs::PoseStamped;
use crate::message::ros_message;
use crate::std_msgs::Header;

ros_message! {
    /// A path to follow, pose by pose.
    "nav_msgs/Path" "6227e2b7e9cce15051f669a5e197bbf7" struct Path {
        header: Header,
        poses: Vec<PoseStamped>,
    }
}
