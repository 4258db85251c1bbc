//! `rviz/PointCloud2`: a `sensor_msgs/PointCloud2`, whose points without a finite position are left out.

use std::sync::Arc;

use rcs_messages::std_msgs::Header;
use rcs_messages::{AnyMessage, MessageKind, PointCloud2};

use crate::parts::cloud::{CloudSource, Nowhere, PlacedCloud};
use crate::World;

/// `sensor_msgs/PointCloud2` as it is.
#[derive(Debug)]
pub(crate) struct PointCloud2Source;

impl CloudSource for PointCloud2Source {
    type Message = PointCloud2;
    const KIND: MessageKind = MessageKind::PointCloud2;
    const NOWHERE: Nowhere = Nowhere::LeftOut;

    fn message(any: &AnyMessage) -> Option<&Arc<PointCloud2>> {
        match any {
            AnyMessage::PointCloud2(cloud) => Some(cloud),
            _ => None,
        }
    }

    fn header(cloud: &PointCloud2) -> &Header {
        &cloud.header
    }

    fn place(cloud: &Arc<PointCloud2>, world: &World<'_>) -> Result<PlacedCloud, String> {
        PlacedCloud::at_stamp(cloud.clone(), world)
    }
}
