//! `rviz/PoseWithCovariance`: the last pose of a topic with its covariance.

use nalgebra::Isometry3;
use rcs_messages::geometry_msgs::PoseWithCovarianceStamped;
use rcs_rviz_config::PoseWithCovarianceSettings;
use rcs_scene::DisplayId;

use crate::framework::message_display::{DrawResult, InvalidFloats, MessageDisplay, MessageVisual};
use crate::parts::covariance::{uncertain_pose, CovarianceScales, CovarianceSymbol};
use crate::parts::pose_symbol::PoseSymbol;

#[derive(Debug)]
pub(crate) struct PoseWithCovarianceVisual {
    display: DisplayId,
    symbol: PoseSymbol,
    covariance: CovarianceSymbol,
    /// Kept between messages: an invalid covariance has the sizes of the one before it.
    scales: CovarianceScales,
}

pub(crate) fn create(
    display: DisplayId,
    settings: &PoseWithCovarianceSettings,
) -> MessageDisplay<PoseWithCovarianceVisual> {
    let visual = PoseWithCovarianceVisual {
        display,
        symbol: (&settings.symbol).into(),
        covariance: CovarianceSymbol::new(display, &settings.covariance),
        scales: CovarianceScales::default(),
    };
    MessageDisplay::new(&settings.topic, settings.queue_size, Some(1), visual)
}

impl MessageVisual for PoseWithCovarianceVisual {
    type Message = PoseWithCovarianceStamped;

    fn draw(&mut self, message: &PoseWithCovarianceStamped, fixed_from_frame: &Isometry3<f64>) -> DrawResult {
        let (frame_from_pose, covariance) = uncertain_pose(&message.pose).ok_or(InvalidFloats)?;
        let mut drawables = self.symbol.drawables(self.display, &(fixed_from_frame * frame_from_pose));
        let scales = &mut self.scales;
        drawables.extend(self.covariance.drawables(fixed_from_frame, &frame_from_pose, &covariance, scales));
        Ok(Some(drawables))
    }
}
