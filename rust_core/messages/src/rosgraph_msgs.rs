//! `rosgraph_msgs`.

use crate::message::ros_message;
use crate::std_msgs::Header;
use crate::Time;

ros_message! {
    /// The simulation's time.
    "rosgraph_msgs/Clock" "a9c97c1d230cfc112e270351a944ee47" struct Clock {
        clock: Time,
    }

    /// A line of a node's log, on `/rosout`.
    "rosgraph_msgs/Log" "acffd30cd6b6de30f120938c17c593fb" struct Log {
        [
            DEBUG: u8 = 1,
            INFO: u8 = 2,
            WARN: u8 = 4,
            ERROR: u8 = 8,
            FATAL: u8 = 16,
        ]
        header: Header,
        level: u8,
        name: String,
        msg: String,
        file: String,
        function: String,
        line: u32,
        topics: Vec<String>,
    }
}
