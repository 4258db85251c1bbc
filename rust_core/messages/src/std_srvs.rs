//! `std_srvs`.

use crate::message::ros_message;
use crate::Service;

ros_message! {
    /// Nothing: a [`Trigger`] is asked without words.
    "std_srvs/TriggerRequest" "d41d8cd98f00b204e9800998ecf8427e" struct TriggerRequest {
    }

    /// Whether it worked, and a word about it.
    "std_srvs/TriggerResponse" "937c9679a518e3a18d831e57125ea522" struct TriggerResponse {
        success: bool,
        message: String,
    }
}

/// ROS service `std_srvs/Trigger`: do it once.
#[derive(Clone, Copy, Debug)]
pub struct Trigger;

impl Service for Trigger {
    const TYPE: &'static str = "std_srvs/Trigger";
    const MD5SUM: &'static str = "937c9679a518e3a18d831e57125ea522";
    type Request = TriggerRequest;
    type Response = TriggerResponse;
}
