//! A linear and an angular vector as arrows, as WrenchStamped, TwistStamped and AccelStamped show them.
//!
//! The three differ in their message and in the names of its parts. A screw stays where its frame was at its stamp.

#[cfg(test)]
mod tests;
mod visual;

use std::marker::PhantomData;

use nalgebra::Isometry3;
use rcs_messages::{geometry_msgs, translation_xyz, TypedMessage};
use rcs_rviz_config::ScrewSettings;
use rcs_scene::DisplayId;

use crate::framework::message_display::{DrawResult, InvalidFloats, MessageDisplay, MessageVisual};
use crate::framework::world::all_finite;
use visual::ScrewStyle;

/// A message of a linear and an angular vector.
pub(crate) trait ScrewMessage: TypedMessage {
    fn parts(&self) -> (&geometry_msgs::Vector3, &geometry_msgs::Vector3);
}

#[derive(Debug)]
pub(crate) struct ScrewVisual<M> {
    display: DisplayId,
    style: ScrewStyle,
    message: PhantomData<fn(M)>,
}

pub(crate) fn create<M: ScrewMessage>(display: DisplayId, settings: &ScrewSettings) -> MessageDisplay<ScrewVisual<M>> {
    let visual = ScrewVisual { display, style: ScrewStyle::new(settings), message: PhantomData };
    MessageDisplay::new(&settings.topic, settings.queue_size, Some(settings.history_length), visual)
}

impl<M: ScrewMessage> MessageVisual for ScrewVisual<M> {
    type Message = M;

    fn draw(&mut self, message: &M, fixed_from_frame: &Isometry3<f64>) -> DrawResult {
        let (linear, angular) = message.parts();
        let [linear, angular] = [linear, angular].map(translation_xyz);
        if !all_finite(&linear) || !all_finite(&angular) {
            return Err(InvalidFloats);
        }
        Ok(Some(self.style.drawables(self.display, fixed_from_frame, linear.into(), angular.into())))
    }
}
