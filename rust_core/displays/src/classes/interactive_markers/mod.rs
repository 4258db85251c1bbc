//! `rviz/InteractiveMarkers`: the handles by which a person moves things, as rviz shows them while nobody touches them.
//!
//! ```text
//!   …/update       ─┐
//!                   ├─ client ─ a server each ─ batches that wait for frames ─ shown markers ─ controls
//!   …/update_full  ─┘
//! ```
//!
//! The [`client`] speaks the protocol, [`complete`] and [`handles`] fill in what messages leave out, [`placed_marker`]
//! and [`control`] place the markers of the controls, which are those of the Marker display. A marker without a stamp
//! follows its frame, one with a stamp stays. Controls that face the view turn to each camera ([`rcs_scene::Facing`]).
//!
//! As in rviz a marker without controls, or a pose for a marker that does not exist, stops the display: it shows
//! nothing until it is reset.

mod batch;
mod client;
mod complete;
mod control;
mod handles;
mod placed_marker;
mod server;

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use rcs_messages::visualization_msgs::{InteractiveMarker, InteractiveMarkerPose};
use rcs_messages::{AnyMessage, MessageKind, PlainTransform};
use rcs_rviz_config::InteractiveMarkersSettings;
use rcs_scene::{DisplayId, Drawable};
use rcs_transforms::Time;

use crate::framework::display::{Display, TopicRequest};
use crate::framework::world::isometry;
use crate::{Level, StatusText, Statuses, World};
use batch::MarkerBatch;
use client::Client;
use placed_marker::PlacedMarker;
use server::MarkerChange;

const QUEUE_SIZE: u32 = 100;

#[derive(Debug)]
pub(crate) struct InteractiveMarkersDisplay {
    display: DisplayId,
    settings: InteractiveMarkersSettings,
    client: Client,
    markers: BTreeMap<String, BTreeMap<String, PlacedMarker>>,
    drawables: Vec<Drawable>,
    statuses: Statuses,
    changed: bool,
    /// Version of the meshes when missing ones were last checked.
    meshes_version: u64,
}

/// An error after which rviz ignores all messages: the name of the marker and the reason.
struct Fatal(String, &'static str);

pub(crate) fn create(display: DisplayId, settings: &InteractiveMarkersSettings) -> InteractiveMarkersDisplay {
    let mut statuses = Statuses::default();
    let client = Client::new(settings.enable_transparency, &mut statuses);
    let mut shown = InteractiveMarkersDisplay {
        display,
        settings: settings.clone(),
        client,
        markers: BTreeMap::new(),
        drawables: Vec::new(),
        statuses,
        changed: false,
        meshes_version: 0,
    };
    shown.check_topic();
    shown
}

impl InteractiveMarkersDisplay {
    fn check_topic(&mut self) {
        let topic = &self.settings.update_topic;
        if self.settings.namespace().is_none() && !topic.is_empty() {
            self.statuses.set(Level::Error, Statuses::TOPIC, format!("Invalid topic name: {topic}"));
        }
    }

    fn apply(&mut self, server: &str, step: MarkerChange, world: &World<'_>) -> Result<(), Fatal> {
        self.changed = true;
        match step {
            MarkerChange::Forget => {
                self.forget(server);
                Ok(())
            }
            MarkerChange::Replace(batch) => {
                self.forget(server);
                self.add(server, &batch.markers, world)
            }
            MarkerChange::Update(MarkerBatch { markers, poses, erases, .. }) => {
                self.add(server, &markers, world)?;
                self.set_poses(server, &poses, world)?;
                let shown = self.markers.entry(server.to_owned()).or_default();
                for name in &erases {
                    shown.remove(name);
                    self.statuses.remove(name);
                }
                Ok(())
            }
        }
    }

    fn forget(&mut self, server: &str) {
        for name in self.markers.remove(server).unwrap_or_default().keys() {
            self.statuses.remove(name);
        }
    }

    fn add(&mut self, server: &str, markers: &[InteractiveMarker], world: &World<'_>) -> Result<(), Fatal> {
        let shown = self.markers.entry(server.to_owned()).or_default();
        for marker in markers {
            if !complete::is_finite(marker) {
                self.statuses.set(Level::Error, &marker.name, "Marker contains invalid floats!");
                continue;
            }
            if marker.controls.is_empty() {
                return Err(Fatal(marker.name.clone(), "Marker empty."));
            }
            let (new, unplaced) = PlacedMarker::new(marker, world);
            let (level, text) = match unplaced {
                Some(error) => (Level::Error, StatusText::about_frame(error.to_string())),
                None => new.status(),
            };
            self.statuses.set(level, &marker.name, text);
            shown.insert(marker.name.clone(), new);
        }
        Ok(())
    }

    fn set_poses(&mut self, server: &str, poses: &[InteractiveMarkerPose], world: &World<'_>) -> Result<(), Fatal> {
        let shown = self.markers.entry(server.to_owned()).or_default();
        for message in poses {
            let refused = if !complete::is_finite_pose(&message.pose) {
                Some("Pose message contains invalid floats!")
            } else if !complete::is_rotation(&message.pose.orientation) {
                Some("Pose message contains invalid quaternions (length not equal to 1)!")
            } else {
                None
            };
            if let Some(text) = refused {
                self.statuses.set(Level::Error, &message.name, text);
                return Ok(());
            }
            let Some(marker) = shown.get_mut(&message.name) else {
                return Err(Fatal(message.name.clone(), "Pose received for non-existing marker"));
            };
            let pose = isometry(&PlainTransform::from(&message.pose)).unwrap_or_default();
            if let Err(error) = marker.set_pose(&message.header, pose, world) {
                self.statuses.set(Level::Error, &message.name, StatusText::about_frame(error.to_string()));
            }
        }
        Ok(())
    }

    fn stop(&mut self, Fatal(name, reason): Fatal) {
        self.client.stop();
        self.markers.clear();
        self.statuses.clear();
        self.statuses.set(Level::Error, &name, format!("{reason} Nothing more is shown until a reset."));
    }

    fn follow(&mut self, world: &World<'_>) {
        for (name, marker) in self.markers.values_mut().flatten() {
            let was_located = marker.is_located();
            match marker.follow(world) {
                Ok(has_moved) => self.changed |= has_moved,
                Err(error) => {
                    self.statuses.set(Level::Error, name, StatusText::about_frame(error.to_string()));
                    self.changed = true;
                }
            }
            if marker.is_located() && !was_located {
                let (level, text) = marker.status();
                self.statuses.set(level, name, text);
            }
        }
    }

    /// Rebuilds markers whose meshes were loaded since the last call.
    fn build_loaded(&mut self, world: &World<'_>) {
        let version = world.meshes.version();
        if std::mem::replace(&mut self.meshes_version, version) == version {
            return;
        }
        for (name, marker) in self.markers.values_mut().flatten() {
            if marker.rebuild(world) {
                self.changed = true;
                if marker.is_located() {
                    let (level, text) = marker.status();
                    self.statuses.set(level, name, text);
                }
            }
        }
    }
}

impl Display for InteractiveMarkersDisplay {
    fn topics(&self) -> Vec<TopicRequest> {
        let Some(namespace) = self.settings.namespace().filter(|namespace| !namespace.is_empty()) else {
            return Vec::new();
        };
        let request = |name, kind| TopicRequest::new(&format!("{namespace}/{name}"), kind, QUEUE_SIZE);
        let topics = [
            request("update", MessageKind::InteractiveMarkerUpdate),
            request("update_full", MessageKind::InteractiveMarkerInit),
        ];
        topics.into_iter().flatten().collect()
    }

    fn take(&mut self, message: &AnyMessage, world: &World<'_>) {
        match message {
            AnyMessage::InteractiveMarkerInit(init) => self.client.take_init(init, &mut self.statuses),
            AnyMessage::InteractiveMarkerUpdate(update) => {
                self.client.take_update(update, world.now, &mut self.statuses);
            }
            _ => {}
        }
    }

    /// As in rviz, all servers and their markers are removed and started again. A display that was stopped by an error
    /// stays stopped.
    fn publisher_left(&mut self, topic: &str) {
        let is_update_topic = self.topics().first().is_some_and(|request| request.topic == topic);
        if is_update_topic && !self.client.is_stopped() {
            self.reset();
            self.statuses.set(Level::Error, "General", "Server is offline. Resetting.");
        }
    }

    fn is_waiting(&self, _stamp: Time) -> bool {
        self.client.is_waiting()
    }

    fn update(&mut self, world: &World<'_>) -> bool {
        for (server, step) in self.client.update(world, &mut self.statuses) {
            if let Err(fatal) = self.apply(&server, step, world) {
                self.stop(fatal);
                break;
            }
        }
        self.follow(world);
        self.build_loaded(world);
        let changed = std::mem::take(&mut self.changed);
        if changed {
            let markers = self.markers.values().flat_map(BTreeMap::values);
            self.drawables = markers.flat_map(|marker| marker.drawables(self.display, &self.settings)).collect();
        }
        changed
    }

    fn drawables(&self) -> &[Drawable] {
        &self.drawables
    }

    fn next_change(&self) -> Option<Time> {
        self.client.next_change()
    }

    fn reset(&mut self) {
        self.markers.clear();
        self.drawables.clear();
        self.changed = true;
        self.statuses.clear();
        self.client.restart(&mut self.statuses);
        self.check_topic();
    }

    fn statuses(&self) -> &Statuses {
        &self.statuses
    }
}
