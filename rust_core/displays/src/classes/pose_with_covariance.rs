//! `rviz/PoseWithCovariance`: the last pose of a topic and how sure it is.

use nalgebra::Isometry3;
use rcs_messages::geometry_msgs::PoseWithCovarianceStamped;
use rcs_rviz_config::PoseWithCovarianceSettings;
use rcs_scene::{DisplayId, Drawable};

use crate::framework::display::Display;
use crate::framework::message_display::{InvalidFloats, MessageDisplay, MessageVisual};
use crate::parts::covariance::{uncertain_pose, CovarianceScales, CovarianceSymbol};
use crate::parts::pose_symbol::PoseSymbol;

/// A PoseWithCovariance display.
pub(crate) type PoseWithCovarianceDisplay = MessageDisplay<PoseWithCovarianceVisual>;

/// What a PoseWithCovariance display draws.
#[derive(Debug)]
pub(crate) struct PoseWithCovarianceVisual {
    display: DisplayId,
    symbol: PoseSymbol,
    covariance: CovarianceSymbol,
    /// From message to message: a covariance that is none leaves the sizes of the one before it.
    scales: CovarianceScales,
    drawables: Vec<Drawable>,
}

/// Makes a PoseWithCovariance display.
pub(crate) fn create(display: DisplayId, settings: &PoseWithCovarianceSettings) -> Box<dyn Display> {
    Box::new(PoseWithCovarianceDisplay::of(display, settings))
}

impl PoseWithCovarianceDisplay {
    /// A display that has no message yet.
    pub(crate) fn of(display: DisplayId, settings: &PoseWithCovarianceSettings) -> Self {
        let visual = PoseWithCovarianceVisual {
            display,
            symbol: (&settings.symbol).into(),
            covariance: CovarianceSymbol::new(display, &settings.covariance),
            scales: CovarianceScales::default(),
            drawables: Vec::new(),
        };
        Self::new(&settings.topic, settings.queue_size, visual)
    }
}

impl MessageVisual for PoseWithCovarianceVisual {
    type Message = PoseWithCovarianceStamped;

    fn show(
        &mut self,
        message: &PoseWithCovarianceStamped,
        fixed_from_frame: &Isometry3<f64>,
    ) -> Result<bool, InvalidFloats> {
        let (frame_from_pose, covariance) = uncertain_pose(&message.pose).ok_or(InvalidFloats)?;
        self.drawables = self.symbol.drawables(self.display, &(fixed_from_frame * frame_from_pose));
        let scales = &mut self.scales;
        self.drawables.extend(self.covariance.drawables(fixed_from_frame, &frame_from_pose, &covariance, scales));
        Ok(true)
    }

    fn drawables(&self) -> &[Drawable] {
        &self.drawables
    }

    fn clear(&mut self) {
        self.drawables.clear();
    }
}
