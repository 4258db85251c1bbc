//! `rviz/Marker` and `rviz/MarkerArray`: the twelve kinds of markers.
//!
//! Both are one display; a Marker display subscribes to single markers and to the arrays of the topic `…_array`, a
//! MarkerArray display to the arrays of its topic only. Markers wait one by one until their frame is known at their
//! stamp. A marker then stays where its frame was at that time; one with `frame_locked` follows the frame. Its
//! primitives are built once for each message.
//!
//! A large array may be placed in several updates ([`World::step`]); the drawables change with the last of them.
//!
//! Markers of a namespace that the config switches off are not kept, as in rviz. Messages that delete need no frame: as
//! in rviz those that the queue drops are applied at once, before the additions of the same array.

mod arrow;
mod checks;
mod control_marker;
mod kind;
mod lines;
mod mesh;
mod message_fields;
mod point_lists;
mod primitive;
mod shape;
mod store;
mod triangles;

#[cfg(test)]
mod tests;

pub(crate) use control_marker::ControlMarker;
pub(crate) use mesh::NotShown;
pub(crate) use message_fields::{is_finite_color, is_unit_quaternion};
pub(crate) use primitive::SortPoint;

use std::ops::Deref;
use std::sync::Arc;

use rcs_messages::visualization_msgs::{Marker, MarkerArray};
use rcs_messages::{AnyMessage, MessageKind};
use rcs_rviz_config::MarkerSettings;
use rcs_scene::{DisplayId, Drawable};
use rcs_transforms::{Time, WaitingQueue};

use crate::framework::display::{bounded, Display, TopicRequest};
use crate::framework::frame;
use crate::framework::world::stamp;
use crate::{Level, Statuses, World};
use store::{FrameLookups, MarkerStore};

#[derive(Clone, Debug)]
enum Arrived {
    Single(Arc<Marker>),
    /// The array and the marker's index, which is below the array's length.
    InArray(Arc<MarkerArray>, usize),
}

impl Deref for Arrived {
    type Target = Marker;

    fn deref(&self) -> &Marker {
        match self {
            Self::Single(marker) => marker,
            Self::InArray(array, index) => &array.markers[*index],
        }
    }
}

#[derive(Debug)]
pub(crate) struct MarkerDisplay {
    display: DisplayId,
    settings: MarkerSettings,
    takes_single_markers: bool,
    waiting: WaitingQueue<Arrived>,
    /// Markers whose frame is known, until they are processed.
    ready: Vec<Arrived>,
    /// Time of the last update, if ready markers were left for the next one.
    unfinished: Option<Time>,
    /// Makes the next update process all markers: a message came before those of the last one were processed, and the
    /// steps might never end.
    is_late: bool,
    store: MarkerStore,
    drawables: Vec<Drawable>,
    statuses: Statuses,
}

pub(crate) fn create(display: DisplayId, settings: &MarkerSettings) -> MarkerDisplay {
    MarkerDisplay::new(display, settings.clone(), true)
}

impl MarkerDisplay {
    pub(crate) fn new(display: DisplayId, settings: MarkerSettings, takes_single_markers: bool) -> Self {
        Self {
            display,
            takes_single_markers,
            waiting: WaitingQueue::new(bounded(settings.queue_size)).keeping_dropped(),
            settings,
            ready: Vec::new(),
            unfinished: None,
            is_late: false,
            store: MarkerStore::default(),
            drawables: Vec::new(),
            statuses: Statuses::default(),
        }
    }

    /// Sorts the markers of an array into ready and waiting ones.
    fn arrive_all(&mut self, array: &Arc<MarkerArray>, world: &World<'_>) {
        // Most have the frame and stamp of the previous one.
        let mut last: Option<(&str, Time, bool)> = None;
        for (index, marker) in array.markers.iter().enumerate() {
            let (frame, stamp) = (marker.header.frame_id.as_str(), stamp(&marker.header));
            let known = last.filter(|(known, time, _)| *time == stamp && *known == frame);
            let is_ready = known.map_or_else(
                || world.transforms.can_transform(world.fixed_frame, frame, stamp),
                |(.., is_ready)| is_ready,
            );
            last = Some((frame, stamp, is_ready));
            self.sort_in(Arrived::InArray(array.clone(), index), is_ready, world);
        }
    }

    /// Adds a marker to the ready or to the waiting ones.
    fn arrive(&mut self, marker: Arrived, world: &World<'_>) {
        let (frame, stamp) = (marker.header.frame_id.as_str(), stamp(&marker.header));
        let is_ready = world.transforms.can_transform(world.fixed_frame, frame, stamp);
        self.sort_in(marker, is_ready, world);
    }

    fn sort_in(&mut self, marker: Arrived, is_ready: bool, world: &World<'_>) {
        if is_ready {
            self.ready.push(marker);
            return;
        }
        let (frame, stamp) = (marker.header.frame_id.as_str(), stamp(&marker.header));
        let frame = frame.to_owned();
        self.waiting.push(&frame, stamp, marker);
        self.retry_waiting(world);
    }

    /// Moves waiting markers whose frames are known now to the ready ones, and reports those that the queue dropped.
    fn retry_waiting(&mut self, world: &World<'_>) {
        self.ready.extend(self.waiting.take_ready(world.transforms, world.fixed_frame));
        for (marker, reason) in self.waiting.take_dropped() {
            let reason = frame::drop_reason(&reason, world.fixed_frame);
            self.store.drop_unplaced(&marker, reason, world, &mut self.statuses);
        }
    }

    /// Processes up to `step` ready markers. Returns whether others may be left.
    fn process_ready(&mut self, world: &World<'_>, step: usize) -> bool {
        let mut places = FrameLookups::new(world);
        let rest = self.ready.split_off(step.min(self.ready.len()));
        let ready = std::mem::replace(&mut self.ready, rest);
        let is_whole_step = ready.len() == step;
        for marker in ready {
            let shows = |namespace: &str| self.settings.shows_namespace(namespace);
            self.store.process(&marker, &mut places, shows, &mut self.statuses);
        }
        is_whole_step
    }
}

impl Display for MarkerDisplay {
    fn topics(&self) -> Vec<TopicRequest> {
        let (topic, queue_size) = (&self.settings.topic, self.settings.queue_size);
        let single = TopicRequest::new(topic, MessageKind::Marker, queue_size);
        if !self.takes_single_markers {
            return TopicRequest::new(topic, MessageKind::MarkerArray, queue_size).into_iter().collect();
        }
        let arrays = single.as_ref().map(|request| TopicRequest {
            topic: format!("{}_array", request.topic),
            kind: MessageKind::MarkerArray,
            queue_size: request.queue_size,
        });
        single.into_iter().chain(arrays).collect()
    }

    fn take(&mut self, message: &AnyMessage, world: &World<'_>) {
        // Markers of earlier messages are processed before those of this one.
        self.is_late |= self.unfinished.is_some();
        self.process_ready(world, usize::MAX);
        self.statuses.set(Level::Ok, Statuses::TOPIC, "OK");
        match message {
            AnyMessage::Marker(marker) => self.arrive(Arrived::Single(marker.clone()), world),
            AnyMessage::MarkerArray(array) => {
                match checks::check_array(array).status() {
                    Some((level, text)) => self.statuses.set(level, "marker_array", text),
                    None => self.statuses.remove("marker_array"),
                }
                self.arrive_all(array, world);
            }
            _ => {}
        }
    }

    fn is_waiting(&self, stamp: Time) -> bool {
        self.unfinished.is_some() || self.waiting.stamps().any(|waiting| waiting == stamp)
    }

    fn update(&mut self, world: &World<'_>) -> bool {
        self.retry_waiting(world);
        let step = world.step.filter(|_| !std::mem::take(&mut self.is_late)).unwrap_or(usize::MAX);
        let is_whole_step = self.process_ready(world, step);
        frame::report_waiting(&self.waiting, world, &mut self.statuses);
        // As in rviz, all markers of an array appear at once.
        self.unfinished = is_whole_step.then_some(world.now);
        if is_whole_step {
            return false;
        }
        let changed = self.store.update(world, &mut self.statuses);
        if changed {
            self.drawables = self.store.drawables(self.display);
        }
        changed
    }

    fn drawables(&self) -> &[Drawable] {
        &self.drawables
    }

    fn next_change(&self) -> Option<Time> {
        self.unfinished.or_else(|| self.store.next_change())
    }

    fn reset(&mut self) {
        self.waiting.clear();
        self.ready.clear();
        (self.unfinished, self.is_late) = (None, false);
        self.store.clear();
        self.drawables.clear();
        self.statuses.clear();
    }

    fn statuses(&self) -> &Statuses {
        &self.statuses
    }
}
