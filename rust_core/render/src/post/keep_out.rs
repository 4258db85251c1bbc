//! No light on things in space: spheres, a person's head say, whose silhouettes in the image stay dark.
//!
//! A sphere hides a cone of the directions from the lens. A pixel is dark if its direction is in the cone, or as near
//! to it as [`MARGIN_PX`] pixels, so that no part of a pixel that touches the silhouette is lit. Behind a lens with
//! distortion, a pixel's direction is that of its place in what was drawn ([`PixelMap`]). Where the image is flipped
//! when it is finished, a row's factors are those of the row that it was before, from the other end.

use std::sync::Arc;

use nalgebra::{Matrix2, Point3, Vector3};
use rcs_scene::{Camera, Flip, Intrinsics, MapRun, PixelMap};

/// How far around a silhouette it is dark, in pixels of what is drawn: a pixel's half diagonal and what fixed-point
/// places are off. Lenses bend one pixel to less than two.
const MARGIN_PX: f64 = 1.0;
const MARGIN_BEHIND_LENS_PX: f64 = 2.0;

/// Pixels of a row that are compared with a cone together, without a lens.
const RUN_PX: usize = 32;

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
    cones: Vec<Cone>,
    directions: Directions,
    height_px: usize,
    lens: Option<Arc<PixelMap>>,
    flip: Flip,
}

/// The directions (x, y, 1) of the places in what is drawn, in pixels from its upper left corner.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Directions {
    /// The change of x and y by a pixel to the right, and by one down.
    by_px: [[f64; 2]; 2],
    /// The x and y of the corner's direction.
    first: [f64; 2],
}

impl Directions {
    fn new(intrinsics: &Intrinsics) -> Self {
        let first = intrinsics.plane([0.0; 2]);
        let by_px = [[1.0, 0.0], [0.0, 1.0]].map(|place| {
            let [x, y] = intrinsics.plane(place);
            [x - first[0], y - first[1]]
        });
        Self { by_px, first }
    }

    #[inline(always)]
    fn of(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let [right, down] = self.by_px;
        [0, 1].map(|axis| self.first[axis] + right[axis] * u + down[axis] * v)
    }

    /// The most that the angle of a direction changes over `step` pixels.
    fn extent(&self, step: [f64; 2]) -> f64 {
        let [right, down] = self.by_px;
        step[0].abs() * right[0].hypot(right[1]) + step[1].abs() * down[0].hypot(down[1])
    }

    /// The most that the angle of a direction changes by a pixel in any direction: in the middle of the view.
    fn widest(&self) -> f64 {
        let [right, down] = self.by_px;
        Matrix2::new(right[0], down[0], right[1], down[1]).singular_values().max()
    }
}

/// Directions around an axis, in the optical frame: x right, y down, z along the view.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cone {
    /// Of length one.
    axis: Vector3<f64>,
    /// Cosine of the angle between the axis and the outermost direction. All directions are in a cone whose cosine is
    /// below −1.
    cos: f64,
}

impl Cone {
    /// All directions: the lens is inside of the sphere.
    const ALL: Self = Self { axis: Vector3::new(0.0, 0.0, 1.0), cos: -2.0 };

    fn new(center: &Vector3<f64>, radius_m: f64, margin: f64) -> Self {
        let distance_m = center.norm();
        // Also where a number is not finite.
        if !(distance_m > radius_m && distance_m.is_finite()) {
            return Self::ALL;
        }
        let angle = (radius_m / distance_m).asin() + margin;
        Self { axis: center / distance_m, cos: angle.cos() }
    }

    /// True if the direction (x, y, 1) is in it.
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

    /// True if all directions within this angle of (x, y, 1) are outside of it.
    fn is_far_from(&self, x: f64, y: f64, angle: f64) -> bool {
        let wider_cos = self.cos - angle;
        self.axis.x * x + self.axis.y * y + self.axis.z < wider_cos * (x * x + y * y + 1.0).sqrt()
    }
}

impl KeepOut {
    /// The directions that a camera must not light; `None` without spheres.
    pub fn new(camera: &Camera, spheres: &[Sphere]) -> Option<Self> {
        let (directions, lens) = (Directions::new(camera.intrinsics()), camera.lens().cloned());
        let margin_px = if lens.is_some() { MARGIN_BEHIND_LENS_PX } else { MARGIN_PX };
        let margin = margin_px * directions.widest();
        let cone = |sphere: &Sphere| {
            let view = camera.fixed_from_view().inverse_transform_point(&sphere.center);
            // The view frame's y points up and its z backwards.
            Cone::new(&Vector3::new(view.x, -view.y, -view.z), sphere.radius_m, margin)
        };
        let cones: Vec<Cone> = spheres.iter().map(cone).collect();
        let (height_px, flip) = (lens.as_ref().map_or(camera.height_px(), |lens| lens.size_px()[1]), camera.flip());
        (!cones.is_empty()).then_some(Self { cones, directions, height_px: height_px as usize, lens, flip })
    }

    /// Sets the factors of what must stay dark in a row of the image to zero.
    pub(super) fn write(&self, row: usize, factors: &mut [u16]) {
        let row = self.flip.row(self.height_px, row);
        if self.flip.is_left_right {
            factors.reverse();
            self.write_unflipped(row, factors);
            factors.reverse();
        } else {
            self.write_unflipped(row, factors);
        }
    }

    fn write_unflipped(&self, row: usize, factors: &mut [u16]) {
        match &self.lens {
            None => {
                for (factors, column) in factors.chunks_mut(RUN_PX).zip((0..).step_by(RUN_PX)) {
                    self.write_run([f64::from(column) + 0.5, row as f64 + 0.5], [1.0, 0.0], factors);
                }
            }
            Some(map) => {
                const ONE: f64 = 65536.0;
                let (columns, runs) = map.runs(row as u32);
                let columns = columns.start as usize..columns.end as usize;
                // Where the light of a pixel goes to is not known beyond what the lens shows: it stays dark.
                factors.get_mut(..columns.start).unwrap_or_default().fill(0);
                factors.get_mut(columns.end..).unwrap_or_default().fill(0);
                let factors = factors.get_mut(columns).unwrap_or_default();
                for (factors, run) in factors.chunks_mut(MapRun::PIXELS).zip(runs) {
                    let place = run.place.map(|place| f64::from(place) / ONE + 0.5);
                    self.write_run(place, run.step.map(|step| f64::from(step) / ONE), factors);
                }
            }
        }
    }

    /// Writes pixels of a row, given the place of the first one and the distance to the next.
    fn write_run(&self, place: [f64; 2], step: [f64; 2], factors: &mut [u16]) {
        let extent = factors.len() as f64 * self.directions.extent(step);
        let [x, y] = self.directions.of(place);
        for cone in self.cones.iter().filter(|cone| !cone.is_far_from(x, y, extent)) {
            for (index, factor) in factors.iter_mut().enumerate() {
                let at = index as f64;
                let [x, y] = self.directions.of([place[0] + at * step[0], place[1] + at * step[1]]);
                *factor = if cone.has(x, y) { 0 } else { *factor };
            }
        }
    }
}
