//! `std_msgs`.

use crate::message::ros_message;
use crate::Time;

ros_message! {
    /// Sequence number, time and frame of a message.
    "std_msgs/Header" "2176decaecbce78abc3b96ef049fabed" struct Header {
        seq: u32,
        stamp: Time,
        frame_id: String,
    }

    /// A colour; each part from 0 to 1.
    "std_msgs/ColorRGBA" "a29a96539573343b1310c73607334b00" struct ColorRGBA {
        r: f32,
        g: f32,
        b: f32,
        a: f32,
    }

    /// Text, such as a robot description.
    "std_msgs/String" "992ce8a1687cec8c8bd883ec73ca41d1" struct StringMessage {
        data: String,
    }
}
