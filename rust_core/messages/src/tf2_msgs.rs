//! `tf2_msgs`.

use crate::geometry_msgs::TransformStamped;
use crate::message::ros_message;

ros_message! {
    /// Transforms, on `/tf` and `/tf_static`.
    "tf2_msgs/TFMessage" "94810edda583a504dfda3829e70d7eec" struct TFMessage {
        transforms: Vec<TransformStamped>,
    }
}
