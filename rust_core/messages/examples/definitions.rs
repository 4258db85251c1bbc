//! Prints each message type with its checksum and the text of its definition, for comparison with ROS's own tools.

use rcs_messages::MessageKind;

fn main() {
    for kind in MessageKind::ALL {
        println!("### {} {}", kind.ros_type(), kind.md5sum());
        println!("{}", kind.definition());
    }
}
