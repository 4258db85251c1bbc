//! Where messages come from: [`live`] topics of a ROS master, or a [`bag`] file without any ROS.
//!
//! Both give the same messages ([`rcs_messages::AnyMessage`]); what is made of them does not know which it was.

pub mod bag;
pub mod live;
