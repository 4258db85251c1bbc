//! An interactive marker at its place, with its controls, axes and title.

use nalgebra::Isometry3;
use rcs_messages::std_msgs::Header;
use rcs_messages::visualization_msgs::InteractiveMarker;
use rcs_messages::PlainTransform;
use rcs_rviz_config::InteractiveMarkersSettings;
use rcs_scene::{DisplayId, Drawable};
use rcs_transforms::LookupError;

use super::complete::complete_control;
use super::control::PlacedControl;
use super::handles;
use crate::classes::marker::NotShown;
use crate::framework::world::{isometry, stamp};
use crate::parts::solids::{axes, axes_materials};
use crate::{Level, StatusText, World};

/// Thickness of the axes, in lengths of the axes.
const AXES_THICKNESS: f64 = 0.05;

#[derive(Debug)]
pub(super) struct PlacedMarker {
    frame: String,
    is_locked: bool,
    size_m: f64,
    reference_from_marker: Isometry3<f64>,
    /// Pose of its frame; `None` while unknown.
    fixed_from_reference: Option<Isometry3<f64>>,
    controls: Vec<PlacedControl>,
    title: Option<PlacedControl>,
    /// Meshes of the controls that are loading or cannot be shown.
    missing: Vec<NotShown>,
}

impl PlacedMarker {
    /// Builds a completed marker whose numbers are finite. Returns also the reason why it cannot be placed.
    pub(super) fn new(marker: &InteractiveMarker, world: &World<'_>) -> (Self, Option<LookupError>) {
        let mut shown = Self {
            frame: marker.header.frame_id.clone(),
            is_locked: stamp(&marker.header).is_zero(),
            size_m: f64::from(marker.scale),
            reference_from_marker: isometry(&PlainTransform::from(&marker.pose)).unwrap_or_default(),
            fixed_from_reference: None,
            controls: Vec::new(),
            title: None,
            missing: Vec::new(),
        };
        let unplaced = shown.locate(world).err();
        let mut missing = Vec::new();
        let fixed_from_reference = shown.fixed_from_reference.unwrap_or_default();
        let reference_from_marker = shown.reference_from_marker;
        let mut build =
            |control| PlacedControl::new(control, &reference_from_marker, &fixed_from_reference, world, &mut missing);
        shown.controls = marker.controls.iter().map(&mut build).collect();
        if !marker.description.is_empty() {
            let mut title = handles::title(marker);
            complete_control(shown.size_m, &mut title, true);
            shown.title = Some(build(&title));
        }
        shown.missing = missing;
        (shown, unplaced)
    }

    /// Rebuilds markers of the controls whose meshes were missing. Returns whether there were any.
    pub(super) fn rebuild(&mut self, world: &World<'_>) -> bool {
        self.missing.clear();
        let Self { controls, missing, .. } = self;
        let mut had_missing = false;
        for control in controls {
            had_missing |= control.rebuild(world, missing);
        }
        had_missing
    }

    /// Moves the marker to a pose in the frame of a header.
    ///
    /// # Errors
    /// The frame cannot be placed.
    pub(super) fn set_pose(
        &mut self,
        header: &Header,
        pose: Isometry3<f64>,
        world: &World<'_>,
    ) -> Result<(), LookupError> {
        header.frame_id.clone_into(&mut self.frame);
        self.is_locked = stamp(header).is_zero();
        self.reference_from_marker = pose;
        self.locate(world).map(|_| ())
    }

    /// Status: a mesh that cannot be shown, else one that is loading, else rviz's status of the position.
    pub(super) fn status(&self) -> (Level, StatusText) {
        let failed = self.missing.iter().find(|missing| matches!(missing, NotShown::Failed(_)));
        if let Some(missing) = failed.or(self.missing.first()) {
            let (level, text) = missing.clone().status();
            return (level, text.into());
        }
        let text =
            if self.is_locked { format!("Locked to frame {}", self.frame) } else { "Position is fixed.".to_owned() };
        (Level::Ok, text.into())
    }

    /// Follows the frame of a locked marker. Returns whether the marker moved, came or went.
    ///
    /// # Errors
    /// The frame cannot be placed any more.
    pub(super) fn follow(&mut self, world: &World<'_>) -> Result<bool, LookupError> {
        if !self.is_locked {
            return Ok(false);
        }
        let was_known = self.fixed_from_reference.is_some();
        match self.locate(world) {
            Ok(has_moved) => Ok(has_moved),
            Err(error) if was_known => Err(error),
            Err(_) => Ok(false),
        }
    }

    pub(super) fn is_located(&self) -> bool {
        self.fixed_from_reference.is_some()
    }

    fn locate(&mut self, world: &World<'_>) -> Result<bool, LookupError> {
        let before = self.fixed_from_reference.take();
        // A marker with a stamp is in the fixed frame already.
        let place = if self.frame == world.fixed_frame {
            Isometry3::identity()
        } else {
            world.fixed_from_moving_if_known(&self.frame)?
        };
        self.fixed_from_reference = Some(place);
        Ok(before != self.fixed_from_reference)
    }

    /// The drawables of the marker; none while its frame is not known.
    pub(super) fn drawables(&self, display: DisplayId, settings: &InteractiveMarkersSettings) -> Vec<Drawable> {
        let Some(fixed_from_reference) = &self.fixed_from_reference else { return Vec::new() };
        let mut drawables = Vec::new();
        if settings.show_axes {
            let fixed_from_axes = (fixed_from_reference * self.reference_from_marker).to_homogeneous();
            let thickness_m = self.size_m * AXES_THICKNESS;
            drawables.extend(axes(display, &fixed_from_axes, self.size_m, thickness_m, &axes_materials(1.0)));
        }
        let controls = self.controls.iter().filter(|control| control.always_visible || settings.interaction_enabled);
        for control in controls.chain(self.title.as_ref().filter(|_| settings.show_descriptions)) {
            drawables.extend(control.drawables(display, &self.reference_from_marker, fixed_from_reference));
        }
        drawables
    }
}
