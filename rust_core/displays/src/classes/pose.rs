//! `rviz/Pose`: the last pose of a topic.

use nalgebra::Isometry3;
use rcs_messages::geometry_msgs::PoseStamped;
use rcs_messages::PlainTransform;
use rcs_rviz_config::PoseSettings;
use rcs_scene::DisplayId;

use crate::framework::message_display::{DrawResult, InvalidFloats, MessageDisplay, MessageVisual};
use crate::framework::world::isometry;
use crate::parts::pose_symbol::PoseSymbol;

#[derive(Debug)]
pub(crate) struct PoseVisual {
    display: DisplayId,
    symbol: PoseSymbol,
}

pub(crate) fn create(display: DisplayId, settings: &PoseSettings) -> MessageDisplay<PoseVisual> {
    let visual = PoseVisual { display, symbol: (&settings.symbol).into() };
    MessageDisplay::new(&settings.topic, settings.queue_size, Some(1), visual)
}

impl MessageVisual for PoseVisual {
    type Message = PoseStamped;

    fn draw(&mut self, message: &PoseStamped, fixed_from_frame: &Isometry3<f64>) -> DrawResult {
        let frame_from_pose = isometry(&PlainTransform::from(&message.pose)).ok_or(InvalidFloats)?;
        Ok(Some(self.symbol.drawables(self.display, &(fixed_from_frame * frame_from_pose))))
    }
}
