//! `rviz/Pose`: the last pose of a topic.

use nalgebra::Isometry3;
use rcs_messages::geometry_msgs::PoseStamped;
use rcs_messages::PlainTransform;
use rcs_rviz_config::PoseSettings;
use rcs_scene::{DisplayId, Drawable};

use crate::framework::display::Display;
use crate::framework::message_display::{InvalidFloats, MessageDisplay, MessageVisual};
use crate::framework::world::isometry;
use crate::parts::pose_symbol::PoseSymbol;

/// A Pose display.
pub(crate) type PoseDisplay = MessageDisplay<PoseVisual>;

/// What a Pose display draws.
#[derive(Debug)]
pub(crate) struct PoseVisual {
    display: DisplayId,
    symbol: PoseSymbol,
    drawables: Vec<Drawable>,
}

/// Makes a Pose display.
pub(crate) fn create(display: DisplayId, settings: &PoseSettings) -> Box<dyn Display> {
    Box::new(PoseDisplay::of(display, settings))
}

impl PoseDisplay {
    /// A display that has no message yet.
    pub(crate) fn of(display: DisplayId, settings: &PoseSettings) -> Self {
        let visual = PoseVisual { display, symbol: (&settings.symbol).into(), drawables: Vec::new() };
        Self::new(&settings.topic, settings.queue_size, visual)
    }
}

impl MessageVisual for PoseVisual {
    type Message = PoseStamped;

    fn show(&mut self, message: &PoseStamped, fixed_from_frame: &Isometry3<f64>) -> Result<bool, InvalidFloats> {
        let frame_from_pose = isometry(&PlainTransform::from(&message.pose)).ok_or(InvalidFloats)?;
        self.drawables = self.symbol.drawables(self.display, &(fixed_from_frame * frame_from_pose));
        Ok(true)
    }

    fn drawables(&self) -> &[Drawable] {
        &self.drawables
    }

    fn clear(&mut self) {
        self.drawables.clear();
    }
}
