//! `rviz/Axes`: a frame's axes as three cylinders.

use std::sync::Arc;

use nalgebra::Isometry3;
use rcs_rviz_config::AxesSettings;
use rcs_scene::{DisplayId, Drawable, Material};

use crate::framework::display::Display;
use crate::framework::frame;
use crate::parts::solids::{axes, axes_materials};
use crate::parts::trail::Trail;
use crate::{Statuses, World};

const TRAIL_COLOR: [u8; 4] = [0, 255, 0, 0];

#[derive(Debug)]
pub(crate) struct AxesDisplay {
    display: DisplayId,
    settings: AxesSettings,
    materials: [Arc<Material>; 3],
    trail: Option<Trail>,
    place: Option<Isometry3<f64>>,
    drawables: Vec<Drawable>,
    statuses: Statuses,
}

pub(crate) fn create(display: DisplayId, settings: &AxesSettings) -> AxesDisplay {
    AxesDisplay {
        display,
        materials: axes_materials(settings.alpha),
        trail: settings.show_trail.then(Trail::default),
        settings: settings.clone(),
        place: None,
        drawables: Vec::new(),
        statuses: Statuses::default(),
    }
}

impl Display for AxesDisplay {
    fn update(&mut self, world: &World<'_>) -> bool {
        let reference_frame = self.settings.reference_frame.as_deref();
        let place = frame::follow(reference_frame, world, self.place, &mut self.statuses);
        if self.place == Some(place) && !self.drawables.is_empty() {
            return false;
        }
        self.place = Some(place);
        self.drawables.clear();
        let (length_m, diameter_m) = (f64::from(self.settings.length_m), f64::from(self.settings.radius_m));
        let fixed_from_axes = place.to_homogeneous();
        self.drawables.extend(axes(self.display, &fixed_from_axes, length_m, diameter_m, &self.materials));
        if let Some(trail) = &mut self.trail {
            trail.follow(place.translation.vector);
            self.drawables.extend(trail.drawable(self.display, TRAIL_COLOR));
        }
        true
    }

    fn drawables(&self) -> &[Drawable] {
        &self.drawables
    }

    fn reset(&mut self) {
        self.place = None;
        self.drawables.clear();
        if let Some(trail) = &mut self.trail {
            *trail = Trail::default();
        }
    }

    fn statuses(&self) -> &Statuses {
        &self.statuses
    }
}
