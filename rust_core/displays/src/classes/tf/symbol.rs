//! Symbol of a frame: axes, a name below its origin and an arrow to its parent.

use std::sync::Arc;

use nalgebra::{Isometry3, Matrix4, Translation3, Vector3};
use rcs_rviz_config::TfSettings;
use rcs_scene::{DisplayId, Drawable, Geometry, HorizontalAlignment, Material, Rgba, Text, VerticalAlignment};

use super::age::Fade;
use crate::parts::solids::{arrow, arrow_pose, axes, drawable, ArrowSize};

const AXIS_LENGTH_M: f64 = 0.2;
const AXIS_DIAMETER_M: f64 = 0.02;
const NAME_HEIGHT_M: f32 = 0.1;
const SHAFT_DIAMETER_M: f64 = 0.01;
const HEAD_DIAMETER_M: f64 = 0.04;
const HEAD_LENGTH_M: f64 = 0.1;
/// Share of the head in an arrow no longer than a head, times the scale.
const SHORT_HEAD_SHARE: f64 = 0.1;

const SHAFT_COLOR: Rgba = Rgba::new(0.8, 0.8, 0.3, 1.0);
const HEAD_COLOR: Rgba = Rgba::new(1.0, 0.1, 0.6, 1.0);

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FramePlace {
    pub(super) fixed_from_frame: Isometry3<f64>,
    /// From the frame to its parent in the fixed frame, where there is a parent far enough away for an arrow.
    pub(super) to_parent_m: Option<Vector3<f64>>,
}

#[derive(Clone, Debug)]
struct Colors {
    axes: [Arc<Material>; 3],
    shaft: Arc<Material>,
    head: Arc<Material>,
    name: Rgba,
}

impl Colors {
    fn new(marker_alpha: f32, fade: Fade) -> Self {
        let material = |color: Rgba| Arc::new(Material::lit(fade.apply(color)));
        let axis = |r, g, b| material(Rgba::new(r, g, b, marker_alpha));
        Self {
            axes: [axis(1.0, 0.0, 0.0), axis(0.0, 1.0, 0.0), axis(0.0, 0.0, 1.0)],
            shaft: material(SHAFT_COLOR),
            head: material(HEAD_COLOR),
            name: fade.apply(Rgba::WHITE),
        }
    }
}

/// Settings of all symbols of a display.
#[derive(Debug)]
pub(super) struct Symbols {
    shows_names: bool,
    shows_axes: bool,
    shows_arrows: bool,
    scale: f64,
    marker_alpha: f32,
    /// Colours of frames that do not fade.
    fresh: Colors,
}

impl Symbols {
    pub(super) fn new(settings: &TfSettings) -> Self {
        Self {
            shows_names: settings.show_names,
            shows_axes: settings.show_axes,
            shows_arrows: settings.show_arrows,
            scale: settings.marker_scale.into(),
            marker_alpha: settings.marker_alpha,
            fresh: Colors::new(settings.marker_alpha, Fade::Fresh),
        }
    }

    fn arrow_size(&self, distance_m: f64) -> ArrowSize {
        let head_length_m = HEAD_LENGTH_M * self.scale;
        let is_short = distance_m < head_length_m;
        let head_length_m = if is_short { SHORT_HEAD_SHARE * self.scale * distance_m } else { head_length_m };
        ArrowSize {
            shaft_length_m: distance_m - head_length_m,
            shaft_diameter_m: SHAFT_DIAMETER_M * self.scale,
            head_length_m,
            head_diameter_m: HEAD_DIAMETER_M * self.scale,
        }
    }
}

#[derive(Debug, Default)]
pub(super) struct Symbol {
    shown: Option<(FramePlace, Fade)>,
    /// Laid-out name in a colour.
    name: Option<(Rgba, Arc<Text>)>,
    drawables: Vec<Drawable>,
}

impl Symbol {
    pub(super) fn drawables(&self) -> &[Drawable] {
        &self.drawables
    }

    /// Removes the drawables. Returns whether there were any.
    pub(super) fn hide(&mut self) -> bool {
        self.drawables = Vec::new();
        self.name = None;
        self.shown.take().is_some()
    }

    /// Draws the frame. Returns whether that changed anything.
    pub(super) fn show(
        &mut self,
        display: DisplayId,
        name: &str,
        place: FramePlace,
        fade: Fade,
        symbols: &Symbols,
    ) -> bool {
        if self.shown == Some((place, fade)) {
            return false;
        }
        self.shown = Some((place, fade));
        self.drawables.clear();
        let faded = (fade != Fade::Fresh).then(|| Colors::new(symbols.marker_alpha, fade));
        let colors = faded.as_ref().unwrap_or(&symbols.fresh);
        let scaling = Matrix4::new_scaling(symbols.scale);
        let position = place.fixed_from_frame.translation;
        if symbols.shows_axes {
            let fixed_from_axes = place.fixed_from_frame.to_homogeneous() * scaling;
            self.drawables.extend(axes(display, &fixed_from_axes, AXIS_LENGTH_M, AXIS_DIAMETER_M, &colors.axes));
        }
        if let Some(to_parent) = place.to_parent_m.filter(|_| symbols.shows_arrows) {
            let size = symbols.arrow_size(to_parent.norm());
            let fixed_from_arrow = arrow_pose(position.vector, &to_parent);
            self.drawables.extend(arrow(display, &fixed_from_arrow, &size, &colors.shaft, &colors.head));
        }
        if symbols.shows_names {
            let text = self.text(name, colors.name);
            let fixed_from_name = Translation3::from(position.vector).to_homogeneous() * scaling;
            self.drawables.push(drawable(display, fixed_from_name, Geometry::Text(text)));
        }
        true
    }

    fn text(&mut self, name: &str, color: Rgba) -> Arc<Text> {
        match &self.name {
            Some((known, text)) if *known == color => text.clone(),
            _ => {
                let alignment = (HorizontalAlignment::Center, VerticalAlignment::Below);
                let text = Arc::new(Text::new(name, NAME_HEIGHT_M, color, alignment));
                self.name = Some((color, text.clone()));
                text
            }
        }
    }
}
