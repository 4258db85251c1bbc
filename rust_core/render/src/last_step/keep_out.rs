//! No light on things in space: spheres, a person's head say, whose silhouettes in the picture stay dark.
//!
//! A sphere hides a cone of the directions from the lens. A pixel is dark if its direction is in the cone, or as near
//! to it as [`MARGIN_PX`] pixels, so that no part of a pixel that touches the silhouette is lit. Behind a lens with
//! distortion, a pixel's direction is that of its place in what was drawn ([`PixelMap`]).

use std::ops::Range;
use std::sync::Arc;

use nalgebra::{Point3, Vector3};
use rcs_scene::{Camera, Intrinsics, MapRun, PixelMap};

/// How far around a silhouette it is dark, in pixels of what is drawn: a pixel's half diagonal and what fixed-point
/// places are off. Lenses bend one pixel to less than two.
const MARGIN_PX: f64 = 1.0;
const MARGIN_BEHIND_LENS_PX: f64 = 2.0;

/// A ball in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// In the fixed frame, metres.
    pub center: Point3<f64>,
    /// Metres.
    pub radius_m: f64,
}

/// The directions of what a camera must not light.
#[derive(Clone, Debug, PartialEq)]
pub struct KeepOut {
    /// Each with the columns of what is drawn that it may lie in.
    cones: Vec<(Cone, Range<usize>)>,
    intrinsics: Intrinsics,
    lens: Option<Arc<PixelMap>>,
}

/// Directions around an axis, in the optical frame: x right, y down, z along the view.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cone {
    /// Of length one.
    axis: Vector3<f64>,
    /// Cosine and sine of the angle between the axis and the outermost direction. All directions are in a cone whose
    /// cosine is below −1.
    cos: f64,
    sin: f64,
}

impl Cone {
    /// All directions: the lens is inside of the sphere.
    const ALL: Self = Self { axis: Vector3::new(0.0, 0.0, 1.0), cos: -2.0, sin: 0.0 };

    fn new(center: &Vector3<f64>, radius_m: f64, margin: f64) -> Self {
        let distance_m = center.norm();
        // Also where a number is not finite.
        if !(distance_m > radius_m && distance_m.is_finite()) {
            return Self::ALL;
        }
        let angle = (radius_m / distance_m).asin() + margin;
        let (sin, cos) = angle.sin_cos();
        Self { axis: center / distance_m, cos, sin }
    }

    /// Whether the direction (x, y, 1) is in it.
    #[inline(always)]
    fn has(&self, x: f64, y: f64) -> bool {
        let along = self.axis.x * x + self.axis.y * y + self.axis.z;
        // Squares, for a root costs more than all the rest.
        let (far, bound) = (along * along, self.cos * self.cos * (x * x + y * y + 1.0));
        if self.cos > 0.0 {
            along > 0.0 && far >= bound
        } else {
            along >= 0.0 || far <= bound
        }
    }

    /// Whether no direction (·, y, 1) can be in it: the plane of those lies beside the cone.
    fn is_beside_row(&self, y: f64) -> bool {
        self.cos > 0.0 && (self.axis.y - y * self.axis.z).abs() > self.sin * (1.0 + y * y).sqrt()
    }

    /// The same for the directions (x, ·, 1).
    fn is_beside_column(&self, x: f64) -> bool {
        self.cos > 0.0 && (self.axis.x - x * self.axis.z).abs() > self.sin * (1.0 + x * x).sqrt()
    }

    /// Whether all directions within this angle of (x, y, 1) are outside of it.
    fn is_far_from(&self, x: f64, y: f64, angle: f64) -> bool {
        let wider_cos = self.cos - angle;
        self.axis.x * x + self.axis.y * y + self.axis.z < wider_cos * (x * x + y * y + 1.0).sqrt()
    }
}

impl KeepOut {
    /// What a camera must not light; none without spheres.
    pub fn new(camera: &Camera, spheres: &[Sphere]) -> Option<Self> {
        let (intrinsics, lens) = (*camera.intrinsics(), camera.lens().cloned());
        let margin_px = if lens.is_some() { MARGIN_BEHIND_LENS_PX } else { MARGIN_PX };
        // A pixel is widest in the middle of the view.
        let margin = margin_px / intrinsics.fx_px.abs().min(intrinsics.fy_px.abs());
        let cone = |sphere: &Sphere| {
            let view = camera.fixed_from_view().inverse_transform_point(&sphere.center);
            // The view frame's y points up and its z backwards.
            Cone::new(&Vector3::new(view.x, -view.y, -view.z), sphere.radius_m, margin)
        };
        let columns = |cone: &Cone| {
            let x = |column: u32| (f64::from(column) + 0.5 - intrinsics.cx_px) / intrinsics.fx_px;
            let mut beside = (0..intrinsics.width_px).map(|column| cone.is_beside_column(x(column)));
            let begin = beside.position(|is_beside| !is_beside);
            let end = beside.rposition(|is_beside| !is_beside);
            begin.map_or(0..0, |begin| begin..begin + end.map_or(1, |end| end + 2))
        };
        let cones: Vec<_> = spheres.iter().map(cone).map(|cone| (cone, columns(&cone))).collect();
        (!cones.is_empty()).then_some(Self { cones, intrinsics, lens })
    }

    /// Sets the factors of what must stay dark in a row of the picture to zero.
    pub(super) fn write(&self, row: usize, factors: &mut [u16]) {
        match &self.lens {
            None => self.write_straight(row, factors),
            Some(map) => {
                let (columns, runs) = map.runs(row as u32);
                let columns = columns.start as usize..columns.end as usize;
                // Where the light of a pixel goes to is not known beyond what the lens shows: it stays dark.
                factors.get_mut(..columns.start).unwrap_or_default().fill(0);
                factors.get_mut(columns.end..).unwrap_or_default().fill(0);
                let factors = factors.get_mut(columns).unwrap_or_default();
                for (factors, run) in factors.chunks_mut(MapRun::PIXELS).zip(runs) {
                    self.write_run(run, factors);
                }
            }
        }
    }

    fn write_straight(&self, row: usize, factors: &mut [u16]) {
        let y = self.y(row as f64 + 0.5);
        for (cone, columns) in self.cones.iter().filter(|(cone, _)| !cone.is_beside_row(y)) {
            let begin = columns.start;
            for (column, factor) in factors.get_mut(columns.clone()).unwrap_or_default().iter_mut().enumerate() {
                let is_dark = cone.has(self.x((begin + column) as f64 + 0.5), y);
                *factor = if is_dark { 0 } else { *factor };
            }
        }
    }

    fn write_run(&self, run: MapRun, factors: &mut [u16]) {
        const ONE: f64 = 65536.0;
        let [fx, fy] = [self.intrinsics.fx_px.abs(), self.intrinsics.fy_px.abs()];
        let place = run.place.map(|place| f64::from(place) / ONE + 0.5);
        let step = run.step.map(|step| f64::from(step) / ONE);
        let reach = factors.len() as f64 * (step[0].abs() / fx + step[1].abs() / fy);
        let (x, y) = (self.x(place[0]), self.y(place[1]));
        for (cone, _) in self.cones.iter().filter(|(cone, _)| !cone.is_far_from(x, y, reach)) {
            for (index, factor) in factors.iter_mut().enumerate() {
                let at = index as f64;
                if cone.has(self.x(place[0] + at * step[0]), self.y(place[1] + at * step[1])) {
                    *factor = 0;
                }
            }
        }
    }

    /// The direction of a place in what is drawn, in pixels from its left edge.
    #[inline(always)]
    fn x(&self, u: f64) -> f64 {
        (u - self.intrinsics.cx_px) / self.intrinsics.fx_px
    }

    #[inline(always)]
    fn y(&self, v: f64) -> f64 {
        (v - self.intrinsics.cy_px) / self.intrinsics.fy_px
    }
}
