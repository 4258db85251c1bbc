//! The markers of a display: by namespace and id, from the message that adds one to that which takes it away.

use std::collections::BTreeMap;
use std::time::Duration;

use nalgebra::Isometry3;
use rcs_messages::visualization_msgs::Marker;
use rcs_scene::{DisplayId, Drawable};
use rcs_transforms::{LookupError, Time};

use super::checks::check_marker;
use super::kind::Kind;
use super::primitive::Primitive;
use crate::framework::frame::problem;
use crate::framework::world::stamp;
use crate::{Level, StatusText, Statuses, World};

/// Markers of a shorter lifetime, zero above all, stay until they are deleted.
const MIN_LIFETIME: Duration = Duration::from_micros(100);

type MarkerId = (String, i32);

/// All markers that are shown or would be if their frame were known.
#[derive(Debug, Default)]
pub(super) struct MarkerStore {
    markers: BTreeMap<MarkerId, Shown>,
    /// How many markers were made so far.
    made: u64,
    changed: bool,
    /// That of the meshes when those that were missing were last looked for.
    meshes_version: u64,
}

/// A marker of a namespace and id.
#[derive(Debug)]
struct Shown {
    /// Counts markers; they are drawn in the order in which they were made.
    number: u64,
    marker_type: i32,
    kind: Kind,
    parts: Vec<Primitive>,
    frame: String,
    /// Zero for a marker that follows its frame.
    stamp: Time,
    frame_locked: bool,
    frame_from_marker: Isometry3<f64>,
    /// `None` while it cannot be placed.
    fixed_from_marker: Option<Isometry3<f64>>,
    expires: Option<Time>,
    /// What is wrong with the message.
    finding: Option<(Level, String)>,
    /// The status while its mesh is loading or cannot be shown.
    missing: Option<(Level, String)>,
}

impl MarkerStore {
    /// Applies a message. `shows` is whether a namespace is switched on.
    pub(super) fn process(
        &mut self,
        marker: &Marker,
        world: &World<'_>,
        shows: impl Fn(&str) -> bool,
        statuses: &mut Statuses,
    ) {
        let id = (marker.ns.clone(), marker.id);
        match u8::try_from(marker.action) {
            Ok(Marker::ADD) => {
                let findings = check_marker(marker);
                set_status(&id, findings.status(), statuses);
                if findings.is_fatal() {
                    self.changed |= self.markers.remove(&id).is_some();
                } else if shows(&marker.ns) {
                    self.add(id, marker, findings.status(), world, statuses);
                }
            }
            Ok(Marker::DELETE) => self.delete(&id, statuses),
            Ok(Marker::DELETEALL) => {
                self.changed |= !self.markers.is_empty();
                for id in std::mem::take(&mut self.markers).keys() {
                    set_status(id, None, statuses);
                }
            }
            _ => log::error!("marker {}/{}: there is no action {}", marker.ns, marker.id, marker.action),
        }
    }

    /// Reports a message that was dropped because its frame is not known. One that deletes needs no frame and is
    /// applied.
    pub(super) fn drop_unplaced(
        &mut self,
        marker: &Marker,
        reason: StatusText,
        world: &World<'_>,
        statuses: &mut Statuses,
    ) {
        match u8::try_from(marker.action) {
            Ok(Marker::DELETE | Marker::DELETEALL) => self.process(marker, world, |_| true, statuses),
            _ => set_error(&(marker.ns.clone(), marker.id), reason, statuses),
        }
    }

    fn delete(&mut self, id: &MarkerId, statuses: &mut Statuses) {
        set_status(id, None, statuses);
        self.changed |= self.markers.remove(id).is_some();
    }

    fn add(
        &mut self,
        id: MarkerId,
        marker: &Marker,
        finding: Option<(Level, String)>,
        world: &World<'_>,
        statuses: &mut Statuses,
    ) {
        self.changed = true;
        let old = self.markers.remove(&id).filter(|old| old.marker_type == marker.type_);
        let (number, kind) = match old {
            Some(old) => (old.number, Some(old.kind)),
            None => {
                self.made += 1;
                (self.made, Kind::of(marker))
            }
        };
        let Some(mut kind) = kind else { return };
        let (parts, missing) = match kind.primitives(marker, world.meshes) {
            Ok(parts) => (parts, None),
            Err(not_shown) => {
                let missing = not_shown.status();
                set_status(&id, Some(missing.clone()), statuses);
                (Vec::new(), Some(missing))
            }
        };
        // Points may have a pose that is not finite; they are not drawn.
        let Some(frame_from_marker) = kind.frame_from_marker(marker) else { return };
        let mut shown = Shown {
            number,
            marker_type: marker.type_,
            kind,
            parts,
            frame: marker.header.frame_id.clone(),
            stamp: if marker.frame_locked { Time::ZERO } else { stamp(&marker.header) },
            frame_locked: marker.frame_locked,
            frame_from_marker,
            fixed_from_marker: None,
            expires: lifetime(marker).map(|lifetime| world.now.saturating_add(lifetime)),
            finding,
            missing,
        };
        match shown.locate(world) {
            Ok(place) => shown.fixed_from_marker = Some(place),
            Err(error) => set_error(&id, problem(&error, world.fixed_frame), statuses),
        }
        self.markers.insert(id, shown);
    }

    /// Builds markers whose meshes were loaded since the last call.
    fn build_loaded(&mut self, world: &World<'_>, statuses: &mut Statuses) {
        let version = world.meshes.version();
        if std::mem::replace(&mut self.meshes_version, version) == version {
            return;
        }
        for (id, shown) in self.markers.iter_mut().filter(|(_, shown)| shown.kind.is_missing()) {
            match shown.kind.rebuild(world.meshes) {
                Ok(parts) => {
                    (shown.parts, shown.missing) = (parts, None);
                    self.changed = true;
                }
                Err(not_shown) => shown.missing = Some(not_shown.status()),
            }
            // While it cannot be placed, the status says why.
            if shown.fixed_from_marker.is_some() {
                set_status(id, shown.status(), statuses);
            }
        }
    }

    /// Drops markers whose lifetime is over, moves those that follow their frames, and shows those whose meshes were
    /// loaded. Returns whether anything changed since the last call.
    pub(super) fn update(&mut self, world: &World<'_>, statuses: &mut Statuses) -> bool {
        self.build_loaded(world, statuses);
        let before = self.markers.len();
        self.markers.retain(|id, shown| {
            let alive = shown.expires.is_none_or(|expires| world.now < expires);
            if !alive {
                set_status(id, None, statuses);
            }
            alive
        });
        self.changed |= self.markers.len() != before;
        for (id, shown) in self.markers.iter_mut().filter(|(_, shown)| shown.frame_locked) {
            let place = shown.locate(world);
            match &place {
                Err(error) => set_error(id, problem(error, world.fixed_frame), statuses),
                Ok(_) if shown.fixed_from_marker.is_none() => set_status(id, shown.status(), statuses),
                Ok(_) => {}
            }
            let place = place.ok();
            self.changed |= place != shown.fixed_from_marker;
            shown.fixed_from_marker = place;
        }
        std::mem::take(&mut self.changed)
    }

    /// The drawables of all markers, in the order in which they were made.
    pub(super) fn drawables(&self, display: DisplayId) -> Vec<Drawable> {
        let mut placed: Vec<(u64, &Isometry3<f64>, &[Primitive])> = self
            .markers
            .values()
            .filter_map(|shown| Some((shown.number, shown.fixed_from_marker.as_ref()?, shown.parts.as_slice())))
            .collect();
        placed.sort_unstable_by_key(|(number, ..)| *number);
        placed
            .into_iter()
            .flat_map(|(_, fixed_from_marker, parts)| parts.iter().map(|part| part.placed(display, fixed_from_marker)))
            .collect()
    }

    /// When the next lifetime is over.
    pub(super) fn next_change(&self) -> Option<Time> {
        self.markers.values().filter_map(|shown| shown.expires).min()
    }

    /// Forgets all markers.
    pub(super) fn clear(&mut self) {
        self.markers.clear();
        self.changed = true;
    }
}

impl Shown {
    /// Its status once it is placed.
    fn status(&self) -> Option<(Level, String)> {
        self.missing.clone().or_else(|| self.finding.clone())
    }

    fn locate(&self, world: &World<'_>) -> Result<Isometry3<f64>, LookupError> {
        Ok(world.fixed_from(&self.frame, self.stamp)? * self.frame_from_marker)
    }
}

/// How long a marker is shown; `None` for ever.
fn lifetime(marker: &Marker) -> Option<Duration> {
    let nanos = i64::from(marker.lifetime.sec) * 1_000_000_000 + i64::from(marker.lifetime.nsec);
    let lifetime = Duration::from_nanos(u64::try_from(nanos).ok()?);
    (lifetime > MIN_LIFETIME).then_some(lifetime)
}

/// rviz names a marker's status after its namespace and id.
fn status_name((ns, id): &MarkerId) -> String {
    format!("{ns}/{id}")
}

fn set_status(id: &MarkerId, status: Option<(Level, String)>, statuses: &mut Statuses) {
    let name = status_name(id);
    match status {
        Some((level, text)) => statuses.set(level, &name, text),
        None => statuses.remove(&name),
    }
}

fn set_error(id: &MarkerId, text: impl Into<StatusText>, statuses: &mut Statuses) {
    statuses.set(Level::Error, &status_name(id), text);
}
