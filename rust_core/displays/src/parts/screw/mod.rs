//! A linear and an angular vector as arrows, as WrenchStamped, TwistStamped and AccelStamped show them.
//!
//! The three differ in their message and in the names of its parts. A screw stands where its frame was at its stamp,
//! whatever the frame does later.

#[cfg(test)]
mod tests;
mod visual;

use std::marker::PhantomData;

use nalgebra::{Isometry3, Vector3};
use rcs_messages::{geometry_msgs, translation_xyz, TypedMessage};
use rcs_rviz_config::ScrewSettings;
use rcs_scene::{DisplayId, Drawable};

use crate::framework::message_display::{InvalidFloats, MessageDisplay, MessageVisual};
use crate::parts::history::History;

use visual::Look;

/// A message of a linear and an angular vector.
pub(crate) trait ScrewMessage: TypedMessage {
    /// The linear and the angular vector.
    fn parts(&self) -> (&geometry_msgs::Vector3, &geometry_msgs::Vector3);
}

/// A display of screws.
pub(crate) type ScrewDisplay<M> = MessageDisplay<ScrewVisual<M>>;

/// What a display of screws draws.
#[derive(Debug)]
pub(crate) struct ScrewVisual<M> {
    display: DisplayId,
    look: Look,
    history: History,
    message: PhantomData<fn(M)>,
}

impl<M: ScrewMessage> ScrewDisplay<M> {
    /// A display that has no message yet.
    pub(crate) fn of(display: DisplayId, settings: &ScrewSettings) -> Self {
        let history = History::new(Some(settings.history_length));
        let visual = ScrewVisual { display, look: Look::new(settings), history, message: PhantomData };
        Self::new(&settings.topic, settings.queue_size, visual)
    }
}

impl<M: ScrewMessage> MessageVisual for ScrewVisual<M> {
    type Message = M;

    fn show(&mut self, message: &M, fixed_from_frame: &Isometry3<f64>) -> Result<bool, InvalidFloats> {
        let (linear, angular) = message.parts();
        let [linear, angular] = [linear, angular].map(|vector| Vector3::from(translation_xyz(vector)));
        if !linear.iter().chain(&angular).all(|value| value.is_finite()) {
            return Err(InvalidFloats);
        }
        self.history.push(self.look.drawables(self.display, fixed_from_frame, linear, angular));
        Ok(true)
    }

    fn drawables(&self) -> &[Drawable] {
        self.history.drawables()
    }

    fn clear(&mut self) {
        self.history.clear();
    }
}
