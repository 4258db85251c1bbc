//! The markers of a display by namespace and id.
//!
//! There may be a hundred thousand of them. Each keeps little more than its numbers, an update visits only those that
//! can change by themselves, and a frame that many markers share is looked up once.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::Arc;
use std::time::Duration;

use indexmap::map::Entry;
use indexmap::IndexMap;
use nalgebra::Isometry3;
use rcs_messages::visualization_msgs::Marker;
use rcs_scene::{DisplayId, Drawable};
use rcs_transforms::{LookupError, Time};

use super::checks::check_marker;
use super::kind::MarkerKind;
use super::primitive::Parts;
use crate::framework::frame::problem;
use crate::framework::world::stamp;
use crate::parts::gathering::Gathering;
use crate::{Level, StatusText, Statuses, World};

/// Shorter lifetimes, zero above all, do not expire.
const MIN_LIFETIME: Duration = Duration::from_micros(100);

/// Number of markers for which memory is kept.
const FEW_MARKERS: usize = 1000;

/// The markers of a namespace, in one allocation, which is freed as a whole.
type Namespace = IndexMap<i32, StoredMarker>;

type MarkerId<'a> = (&'a str, i32);

/// All markers that are shown, or would be if their frame were known.
#[derive(Debug, Default)]
pub(super) struct MarkerStore {
    /// Markers by namespace and id. No namespace is empty.
    markers: BTreeMap<String, Namespace>,
    made: u64,
    changed: bool,
    /// Version of the meshes when missing ones were last checked.
    meshes_version: u64,
    locked: usize,
    /// Lower bound of all expiry times; `None` when no marker expires.
    first_expiry: Option<Time>,
    /// Frame of the last marker: many have the same.
    last_frame: Option<Arc<str>>,
}

#[derive(Debug)]
struct StoredMarker {
    /// Consecutive number: markers are drawn in the order in which they were made.
    number: u64,
    marker_type: i32,
    kind: MarkerKind,
    parts: Parts,
    frame: Arc<str>,
    /// `None` for a marker that follows its frame.
    stamp: Option<Time>,
    frame_locked: bool,
    frame_from_marker: Isometry3<f64>,
    fixed_from_marker: Option<Isometry3<f64>>,
    expires: Option<Time>,
    /// Status of the message's problems.
    finding: Option<Box<(Level, String)>>,
    /// Status while its mesh is loading or cannot be shown.
    missing: Option<Box<(Level, String)>>,
}

/// Frame lookups with a cache of the last one: markers of an array often have the same frame and stamp.
pub(super) struct FrameLookups<'w> {
    world: &'w World<'w>,
    last: Option<FrameLookup>,
}

struct FrameLookup {
    frame: Arc<str>,
    stamp: Option<Time>,
    fixed_from_frame: Result<Isometry3<f64>, LookupError>,
}

impl<'w> FrameLookups<'w> {
    pub(super) fn new(world: &'w World<'w>) -> Self {
        Self { world, last: None }
    }

    fn fixed_from(&mut self, frame: &Arc<str>, stamp: Option<Time>) -> Result<Isometry3<f64>, LookupError> {
        if let Some(last) = self.last.as_ref().filter(|last| last.stamp == stamp && last.frame == *frame) {
            return last.fixed_from_frame.clone();
        }
        let fixed_from_frame = match stamp {
            Some(stamp) => self.world.fixed_from(frame, stamp),
            None => self.world.fixed_from_moving_if_known(frame),
        };
        self.last = Some(FrameLookup { frame: frame.clone(), stamp, fixed_from_frame: fixed_from_frame.clone() });
        fixed_from_frame
    }
}

impl MarkerStore {
    /// Applies a message. `shows`: namespaces that are switched on.
    pub(super) fn process(
        &mut self,
        marker: &Marker,
        places: &mut FrameLookups<'_>,
        shows: impl Fn(&str) -> bool,
        statuses: &mut Statuses,
    ) {
        let id = (marker.ns.as_str(), marker.id);
        match u8::try_from(marker.action) {
            Ok(Marker::ADD) => {
                let findings = check_marker(marker);
                set_status(id, findings.status(), statuses);
                if findings.is_fatal() {
                    self.changed |= self.take(id).is_some();
                } else if shows(&marker.ns) {
                    self.add(id, marker, findings.status(), places, statuses);
                }
            }
            Ok(Marker::DELETE) => self.delete(id, statuses),
            Ok(Marker::DELETEALL) => {
                self.changed |= !self.markers.is_empty();
                for (namespace, markers) in &std::mem::take(&mut self.markers) {
                    for number in markers.keys() {
                        set_status((namespace, *number), None, statuses);
                    }
                }
                (self.locked, self.first_expiry) = (0, None);
            }
            _ => log::error!("marker {}/{}: unknown action {}", marker.ns, marker.id, marker.action),
        }
    }

    /// Removes a marker, if there is one of this id.
    fn take(&mut self, (namespace, number): MarkerId<'_>) -> Option<StoredMarker> {
        let markers = self.markers.get_mut(namespace)?;
        let taken = markers.swap_remove(&number);
        if markers.is_empty() {
            self.markers.remove(namespace);
        } else {
            shrink(markers);
        }
        self.locked -= usize::from(taken.as_ref().is_some_and(|taken| taken.frame_locked));
        taken
    }

    /// Reports a message that was dropped because its frame is unknown. One that deletes needs no frame and is applied.
    pub(super) fn drop_unplaced(
        &mut self,
        marker: &Marker,
        reason: StatusText,
        world: &World<'_>,
        statuses: &mut Statuses,
    ) {
        match u8::try_from(marker.action) {
            Ok(Marker::DELETE | Marker::DELETEALL) => {
                self.process(marker, &mut FrameLookups::new(world), |_| true, statuses);
            }
            _ => set_error((&marker.ns, marker.id), reason, statuses),
        }
    }

    fn delete(&mut self, id: MarkerId<'_>, statuses: &mut Statuses) {
        set_status(id, None, statuses);
        self.changed |= self.take(id).is_some();
    }

    fn add(
        &mut self,
        id: MarkerId<'_>,
        marker: &Marker,
        finding: Option<(Level, String)>,
        places: &mut FrameLookups<'_>,
        statuses: &mut Statuses,
    ) {
        self.changed = true;
        let frame = self.frame(&marker.header.frame_id);
        let (namespace, number) = id;
        if !self.markers.contains_key(namespace) {
            self.markers.insert(namespace.to_owned(), Namespace::new());
        }
        let Some(markers) = self.markers.get_mut(namespace) else { return };
        // A marker that is sent again is changed in place: most have only moved.
        let shown = match markers.entry(number) {
            Entry::Occupied(known) if known.get().marker_type == marker.type_ => known.into_mut(),
            entry => {
                let Some(kind) = MarkerKind::of(marker) else { return drop(self.take(id)) };
                self.made += 1;
                let shown = StoredMarker::new(self.made, marker.type_, kind, frame.clone());
                match entry {
                    Entry::Occupied(mut other) => {
                        self.locked -= usize::from(other.insert(shown).frame_locked);
                        other.into_mut()
                    }
                    Entry::Vacant(place) => place.insert(shown),
                }
            }
        };
        let was_locked = shown.frame_locked;
        (shown.frame, shown.finding) = (frame, finding.map(Box::new));
        let is_shown = shown.show(id, marker, places, statuses);
        self.locked = self.locked + usize::from(shown.frame_locked) - usize::from(was_locked);
        if is_shown {
            self.first_expiry = self.first_expiry.into_iter().chain(shown.expires).min();
        } else {
            self.take(id);
        }
    }

    /// Name of a frame, shared with the last marker where it is the same.
    fn frame(&mut self, name: &str) -> Arc<str> {
        match &self.last_frame {
            Some(frame) if **frame == *name => frame.clone(),
            _ => self.last_frame.insert(name.into()).clone(),
        }
    }

    /// Rebuilds markers whose meshes were loaded since the last call.
    fn build_loaded(&mut self, world: &World<'_>, statuses: &mut Statuses) {
        let version = world.meshes.version();
        if std::mem::replace(&mut self.meshes_version, version) == version {
            return;
        }
        for (namespace, markers) in &mut self.markers {
            for (number, shown) in markers.iter_mut().filter(|(_, shown)| shown.kind.is_missing()) {
                match shown.kind.rebuild(world.meshes) {
                    Ok(parts) => {
                        (shown.parts, shown.missing) = (parts, None);
                        self.changed = true;
                    }
                    Err(not_shown) => shown.missing = Some(Box::new(not_shown.status())),
                }
                // While it cannot be placed, its status is the reason.
                if shown.fixed_from_marker.is_some() {
                    set_status((namespace, *number), shown.status(), statuses);
                }
            }
        }
    }

    /// Removes expired markers, moves those that follow their frames, and shows those whose meshes were loaded. Returns
    /// whether anything changed since the last call.
    pub(super) fn update(&mut self, world: &World<'_>, statuses: &mut Statuses) -> bool {
        self.build_loaded(world, statuses);
        if self.first_expiry.is_some_and(|first| first <= world.now) {
            self.drop_expired(world.now, statuses);
        }
        if self.locked > 0 {
            self.follow_frames(world, statuses);
        }
        std::mem::take(&mut self.changed)
    }

    fn drop_expired(&mut self, now: Time, statuses: &mut Statuses) {
        for (namespace, markers) in &mut self.markers {
            markers.retain(|number, shown| {
                let is_alive = shown.expires.is_none_or(|expires| now < expires);
                if !is_alive {
                    set_status((namespace, *number), None, statuses);
                    self.locked -= usize::from(shown.frame_locked);
                    self.changed = true;
                }
                is_alive
            });
            shrink(markers);
        }
        self.markers.retain(|_, markers| !markers.is_empty());
        self.first_expiry = self.all().filter_map(|shown| shown.expires).min();
    }

    fn follow_frames(&mut self, world: &World<'_>, statuses: &mut Statuses) {
        let mut places = FrameLookups::new(world);
        for (namespace, markers) in &mut self.markers {
            for (number, shown) in markers.iter_mut().filter(|(_, shown)| shown.frame_locked) {
                let id = (namespace.as_str(), *number);
                let place = shown.locate(&mut places);
                match &place {
                    Err(error) => set_error(id, problem(error, world.fixed_frame), statuses),
                    Ok(_) if shown.fixed_from_marker.is_none() => {
                        set_status(id, shown.status(), statuses);
                    }
                    Ok(_) => {}
                }
                let place = place.ok();
                self.changed |= place != shown.fixed_from_marker;
                shown.fixed_from_marker = place;
            }
        }
    }

    fn all(&self) -> impl Iterator<Item = &StoredMarker> {
        self.markers.values().flat_map(Namespace::values)
    }

    /// Drawables of all markers, in the order in which they were made.
    pub(super) fn drawables(&self, display: DisplayId) -> Vec<Drawable> {
        let mut placed: Vec<(u64, &Isometry3<f64>, &Parts)> = self
            .all()
            .filter_map(|shown| Some((shown.number, shown.fixed_from_marker.as_ref()?, &shown.parts)))
            .collect();
        placed.sort_unstable_by_key(|(number, ..)| *number);
        let mut gathering = Gathering::new(display);
        for (_, fixed_from_marker, parts) in placed {
            parts.gather(display, fixed_from_marker, &mut gathering);
        }
        gathering.finish()
    }

    /// Time at which the next marker may expire.
    pub(super) fn next_change(&self) -> Option<Time> {
        self.first_expiry
    }

    pub(super) fn clear(&mut self) {
        *self = Self { made: self.made, changed: true, meshes_version: self.meshes_version, ..Self::default() };
    }
}

impl StoredMarker {
    fn new(number: u64, marker_type: i32, kind: MarkerKind, frame: Arc<str>) -> Self {
        Self {
            number,
            marker_type,
            kind,
            parts: Parts::none(),
            frame,
            stamp: None,
            frame_locked: false,
            frame_from_marker: Isometry3::identity(),
            fixed_from_marker: None,
            expires: None,
            finding: None,
            missing: None,
        }
    }

    /// Applies a message; its frame and finding are set already. Returns whether it may be drawn.
    fn show(
        &mut self,
        id: MarkerId<'_>,
        marker: &Marker,
        places: &mut FrameLookups<'_>,
        statuses: &mut Statuses,
    ) -> bool {
        if !self.kind.is_unchanged(marker) {
            (self.parts, self.missing) = match self.kind.parts(marker, places.world.meshes) {
                Ok(parts) => (parts, None),
                Err(not_shown) => {
                    let missing = not_shown.status();
                    set_status(id, Some(missing.clone()), statuses);
                    (Parts::none(), Some(Box::new(missing)))
                }
            };
        }
        // Points with an invalid pose are not drawn.
        let Some(frame_from_marker) = self.kind.frame_from_marker(marker) else { return false };
        self.frame_from_marker = frame_from_marker;
        self.frame_locked = marker.frame_locked;
        self.stamp = (!marker.frame_locked).then(|| stamp(&marker.header));
        self.expires = lifetime(marker).map(|lifetime| places.world.now.saturating_add(lifetime));
        let place = self.locate(places);
        if let Err(error) = &place {
            set_error(id, problem(error, places.world.fixed_frame), statuses);
        }
        self.fixed_from_marker = place.ok();
        true
    }

    fn status(&self) -> Option<(Level, String)> {
        self.missing.as_deref().or(self.finding.as_deref()).cloned()
    }

    fn locate(&self, places: &mut FrameLookups<'_>) -> Result<Isometry3<f64>, LookupError> {
        Ok(places.fixed_from(&self.frame, self.stamp)? * self.frame_from_marker)
    }
}

/// Frees memory after most markers were removed.
fn shrink(markers: &mut Namespace) {
    if markers.capacity() / 4 > markers.len().max(FEW_MARKERS) {
        markers.shrink_to(markers.len() * 2);
    }
}

/// Lifetime of a marker; `None` for ever.
fn lifetime(marker: &Marker) -> Option<Duration> {
    let nanos = i64::from(marker.lifetime.sec) * 1_000_000_000 + i64::from(marker.lifetime.nsec);
    let lifetime = Duration::from_nanos(u64::try_from(nanos).ok()?);
    (lifetime > MIN_LIFETIME).then_some(lifetime)
}

/// rviz names a marker's status after its namespace and id.
fn status_name((namespace, id): MarkerId<'_>) -> String {
    let mut name = String::with_capacity(namespace.len() + 12);
    // Writing to a string does not fail.
    let _ = write!(name, "{namespace}/{id}");
    name
}

fn set_status(id: MarkerId<'_>, status: Option<(Level, String)>, statuses: &mut Statuses) {
    match status {
        Some((level, text)) => statuses.set(level, &status_name(id), text),
        // Most namespaces have no status, and then no name is needed.
        None if !statuses.may_begin_with(id.0) => {}
        None => statuses.remove(&status_name(id)),
    }
}

fn set_error(id: MarkerId<'_>, text: impl Into<StatusText>, statuses: &mut Statuses) {
    statuses.set(Level::Error, &status_name(id), text);
}
