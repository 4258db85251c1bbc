//! A linear and an angular vector as arrows, as WrenchStamped, TwistStamped and AccelStamped show them.
//!
//! The three differ in their message and in the names of its parts. A screw stands where its frame was at its stamp,
//! whatever the frame does later.

#[cfg(test)]
mod tests;
mod visual;

use std::collections::VecDeque;
use std::sync::Arc;

use nalgebra::Vector3;
use rcs_messages::std_msgs::Header;
use rcs_messages::{geometry_msgs, AnyMessage, MessageKind};
use rcs_rviz_config::ScrewSettings;
use rcs_scene::{DisplayId, Drawable};
use rcs_transforms::Time;

use crate::framework::display::{Display, TopicRequest};
use crate::framework::waiting_messages::WaitingMessages;
use crate::{Level, Statuses, World};

use visual::Look;

/// What the three messages have in common.
#[derive(Debug)]
struct Screw {
    header: Header,
    linear: Vector3<f64>,
    angular: Vector3<f64>,
}

impl Screw {
    fn read(message: &AnyMessage) -> Option<Self> {
        let screw = |header: &Header, linear: &geometry_msgs::Vector3, angular: &geometry_msgs::Vector3| {
            let [linear, angular] = [linear, angular].map(|v| Vector3::new(v.x, v.y, v.z));
            Some(Self { header: header.clone(), linear, angular })
        };
        match message {
            AnyMessage::WrenchStamped(m) => screw(&m.header, &m.wrench.force, &m.wrench.torque),
            AnyMessage::TwistStamped(m) => screw(&m.header, &m.twist.linear, &m.twist.angular),
            AnyMessage::AccelStamped(m) => screw(&m.header, &m.accel.linear, &m.accel.angular),
            _ => None,
        }
    }

    fn is_finite(&self) -> bool {
        self.linear.iter().chain(&self.angular).all(|value| value.is_finite())
    }
}

/// A display of screws.
#[derive(Debug)]
pub(crate) struct ScrewDisplay {
    display: DisplayId,
    settings: ScrewSettings,
    kind: MessageKind,
    look: Look,
    incoming: WaitingMessages<Screw>,
    /// What each of the last screws is drawn with, oldest first.
    history: VecDeque<Vec<Drawable>>,
    drawables: Vec<Drawable>,
    statuses: Statuses,
}

impl ScrewDisplay {
    /// A display of one of the three kinds of message.
    pub(crate) fn new(display: DisplayId, settings: ScrewSettings, kind: MessageKind) -> Self {
        Self {
            display,
            kind,
            look: Look::new(&settings),
            incoming: WaitingMessages::new(settings.queue_size),
            settings,
            history: VecDeque::new(),
            drawables: Vec::new(),
            statuses: Statuses::default(),
        }
    }
}

impl Display for ScrewDisplay {
    fn topics(&self) -> Vec<TopicRequest> {
        TopicRequest::new(&self.settings.topic, self.kind, self.settings.queue_size).into_iter().collect()
    }

    fn take(&mut self, message: &AnyMessage, _world: &World<'_>) {
        if let Some(screw) = Screw::read(message) {
            let header = screw.header.clone();
            self.incoming.push(&header, Arc::new(screw), &mut self.statuses);
        }
    }

    fn is_waiting(&self, stamp: Time) -> bool {
        self.incoming.is_waiting(stamp)
    }

    fn update(&mut self, world: &World<'_>) -> bool {
        let mut changed = false;
        for screw in self.incoming.take_ready(world, &mut self.statuses) {
            if !screw.is_finite() {
                let text = "Message contained invalid floating point values (nans or infs)";
                self.statuses.set(Level::Error, "Topic", text);
                continue;
            }
            let Ok(fixed_from_screw) = world.fixed_from_header(&screw.header) else { continue };
            while self.history.len() >= self.settings.history_length.max(1) as usize {
                self.history.pop_front();
            }
            self.history.push_back(self.look.drawables(self.display, &fixed_from_screw, screw.linear, screw.angular));
            changed = true;
        }
        if changed {
            self.drawables = self.history.iter().flatten().cloned().collect();
        }
        changed
    }

    fn drawables(&self) -> &[Drawable] {
        &self.drawables
    }

    fn reset(&mut self) {
        self.incoming.clear();
        self.history.clear();
        self.drawables.clear();
        self.statuses.clear();
    }

    fn statuses(&self) -> &Statuses {
        &self.statuses
    }
}
