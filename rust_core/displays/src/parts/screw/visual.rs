//! Drawables of a screw.
//!
//! Reproduces rviz's `ScrewVisual`: an arrow for each part, whose shaft is as long as the scaled vector and whose head
//! sticks out by three tenths of that. Around the middle of the angular arrow goes seven eighths of a circle that
//! begins at a quarter turn and ends at a small arrow that shows the direction.

use std::f64::consts::TAU;
use std::sync::Arc;

use nalgebra::{Isometry3, Matrix4, UnitQuaternion, Vector3};
use rcs_rviz_config::ScrewSettings;
use rcs_scene::{Blending, DisplayId, Drawable, Geometry, Material, Rgba, RibbonElement, Ribbons};

use crate::parts::bounds::middle;
use crate::parts::solids::{arrow, arrow_pose, drawable, ArrowSize};

/// Proportions of an arrow; length and width scale it.
const ARROW: ArrowSize =
    ArrowSize { shaft_length_m: 1.0, shaft_diameter_m: 0.1, head_length_m: 0.3, head_diameter_m: 0.2 };

/// Length below which a vector has no direction in Ogre.
const SHORTEST_DIRECTION: f64 = 1e-6;

/// Segments of a full circle, which is drawn from the first to the last of these points.
const CIRCLE_SEGMENTS: f64 = 32.0;
const CIRCLE_POINTS: std::ops::RangeInclusive<u8> = 4..=32;

#[derive(Clone, Debug)]
pub(super) struct ScrewStyle {
    linear_scale: f64,
    angular_scale: f64,
    width_m: f64,
    hide_small_values: bool,
    linear_material: Arc<Material>,
    angular_material: Arc<Material>,
    angular_color: Rgba,
}

impl ScrewStyle {
    pub(super) fn new(settings: &ScrewSettings) -> Self {
        let angular_color = Rgba::from_rgb8(settings.angular_color, settings.alpha);
        let linear_color = Rgba::from_rgb8(settings.linear_color, settings.alpha);
        Self {
            linear_scale: settings.linear_scale.into(),
            angular_scale: settings.angular_scale.into(),
            width_m: settings.width_m.into(),
            hide_small_values: settings.hide_small_values,
            linear_material: Arc::new(Material::lit(linear_color)),
            angular_material: Arc::new(Material::lit(angular_color)),
            angular_color,
        }
    }

    pub(super) fn drawables(
        &self,
        display: DisplayId,
        fixed_from_screw: &Isometry3<f64>,
        linear: Vector3<f64>,
        angular: Vector3<f64>,
    ) -> Vec<Drawable> {
        let fixed_from_screw = fixed_from_screw.to_homogeneous();
        let mut drawn = Vec::new();
        let linear_length_m = linear.norm() * self.linear_scale;
        if self.shows(linear_length_m) {
            let material = &self.linear_material;
            drawn.extend(self.vector(display, &fixed_from_screw, &linear, linear_length_m, material));
        }
        let angular_length_m = angular.norm() * self.angular_scale;
        if self.shows(angular_length_m) {
            let material = &self.angular_material;
            drawn.extend(self.vector(display, &fixed_from_screw, &angular, angular_length_m, material));
            drawn.extend(self.circle(display, &fixed_from_screw, &angular, angular_length_m));
        }
        drawn
    }

    fn shows(&self, length_m: f64) -> bool {
        length_m > self.width_m || !self.hide_small_values
    }

    fn vector(
        &self,
        display: DisplayId,
        fixed_from_screw: &Matrix4<f64>,
        direction: &Vector3<f64>,
        length_m: f64,
        material: &Arc<Material>,
    ) -> [Drawable; 2] {
        let direction = if direction.norm() < SHORTEST_DIRECTION { Vector3::zeros() } else { *direction };
        let scale = Matrix4::new_nonuniform_scaling(&Vector3::new(self.width_m, self.width_m, length_m));
        let fixed_from_arrow = fixed_from_screw * arrow_pose(Vector3::zeros(), &direction) * scale;
        arrow(display, &fixed_from_arrow, &ARROW, material, material)
    }

    fn circle(
        &self,
        display: DisplayId,
        fixed_from_screw: &Matrix4<f64>,
        axis: &Vector3<f64>,
        length_m: f64,
    ) -> [Drawable; 3] {
        let half_turn = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::PI);
        let screw_from_circle = match axis.norm_squared() {
            0.0 => UnitQuaternion::identity(),
            _ => UnitQuaternion::rotation_between(&Vector3::z(), axis).unwrap_or(half_turn),
        };
        let at = |turn: f64| {
            let (sin, cos) = (turn * TAU).sin_cos();
            screw_from_circle * Vector3::new(cos * length_m / 4.0, sin * length_m / 4.0, length_m / 2.0)
        };
        let color = self.angular_color.to_rgba8();
        let points = CIRCLE_POINTS.map(|i| at(f64::from(i) / CIRCLE_SEGMENTS).cast::<f32>().into());
        let chain: Vec<RibbonElement> = points.map(|position| RibbonElement { position, color }).collect();
        let is_translucent = self.angular_color.a < Material::OPAQUE_FROM_ALPHA;
        // Chains are sorted by their middle in their own frame, as if it were a place in the fixed frame.
        let sort_point = middle(chain.iter().map(|element| element.position)).map(f64::from).into();
        let ribbons = Ribbons {
            chains: vec![chain],
            width_m: (self.width_m * 0.05) as f32,
            blending: if is_translucent { Blending::Alpha } else { Blending::Replace },
        };
        let circle = drawable(display, *fixed_from_screw, Geometry::Ribbons(Arc::new(ribbons)));

        let tip = ArrowSize {
            shaft_length_m: 0.0,
            shaft_diameter_m: self.width_m * 0.1,
            head_length_m: self.width_m * 0.1,
            head_diameter_m: self.width_m * 0.2,
        };
        let fixed_from_tip = fixed_from_screw * arrow_pose(at(0.0), &(screw_from_circle * Vector3::y()));
        let material = &self.angular_material;
        let [shaft, head] = arrow(display, &fixed_from_tip, &tip, material, material);
        [Drawable { sort_point, ..circle }, shaft, head]
    }
}
