//! `rviz/PointCloud2`: a `sensor_msgs/PointCloud2`, whose points without a finite position are left out.

use std::sync::Arc;

use rcs_messages::PointCloud2;
use rcs_rviz_config::CloudSettings;
use rcs_scene::DisplayId;

use crate::parts::cloud::{CloudDisplay, CloudSource, NonFinite, PlacedCloud};
use crate::{StatusText, World};

/// `sensor_msgs/PointCloud2` as it is.
#[derive(Debug)]
pub(crate) struct PointCloud2Source;

pub(crate) fn create(display: DisplayId, settings: &CloudSettings) -> CloudDisplay<PointCloud2Source> {
    CloudDisplay::new(display, settings.clone())
}

impl CloudSource for PointCloud2Source {
    type Message = PointCloud2;
    const NON_FINITE: NonFinite = NonFinite::LeftOut;

    fn place(cloud: &Arc<PointCloud2>, world: &World<'_>) -> Result<PlacedCloud, StatusText> {
        PlacedCloud::at_stamp(cloud.clone(), world)
    }
}
