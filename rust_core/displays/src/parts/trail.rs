//! The ribbon that follows a frame ("Show Trail" of Axes and of a robot's links).
//!
//! rviz uses an Ogre ribbon trail: two metres long, at most a hundred elements, 1 cm wide. An element is added each
//! time the frame has moved by a hundredth of the length; the oldest are removed where the trail grows longer than
//! that.

use std::collections::VecDeque;
use std::sync::Arc;

use nalgebra::{Matrix4, Vector3};
use rcs_scene::{Blending, DisplayId, Drawable, Geometry, RibbonElement, Ribbons};

use crate::parts::solids::drawable;

const LENGTH_M: f64 = 2.0;
const MAX_ELEMENTS: usize = 100;
const WIDTH_M: f32 = 0.01;

/// Places of a frame, newest first.
#[derive(Clone, Debug, Default)]
pub(crate) struct Trail {
    places: VecDeque<Vector3<f64>>,
}

impl Trail {
    /// Adds the frame's present place.
    pub(crate) fn follow(&mut self, place: Vector3<f64>) {
        match (self.places.get(1).copied(), self.places.front_mut()) {
            (_, None) => {
                self.places.extend([place, place]);
            }
            (Some(previous), Some(head)) if (place - previous).norm() < LENGTH_M / MAX_ELEMENTS as f64 => *head = place,
            (_, Some(head)) => {
                *head = place;
                self.places.push_front(place);
            }
        }
        let mut left_m = LENGTH_M;
        let mut count = 1;
        while count < self.places.len().min(MAX_ELEMENTS) && left_m > 0.0 {
            let (newer, older) = (self.places[count - 1], self.places[count]);
            let step_m = (older - newer).norm();
            if step_m > left_m {
                self.places[count] = newer + (older - newer) * (left_m / step_m);
            }
            left_m -= step_m;
            count += 1;
        }
        self.places.truncate(count);
    }

    /// The ribbon in a colour, red first; `None` while it is empty.
    pub(crate) fn drawable(&self, display: DisplayId, color: [u8; 4]) -> Option<Drawable> {
        let chain: Vec<RibbonElement> =
            self.places.iter().map(|place| RibbonElement { position: place.cast().into(), color }).collect();
        let ribbons = Ribbons { chains: vec![chain], width_m: WIDTH_M, blending: Blending::Replace };
        (self.places.len() > 1).then(|| drawable(display, Matrix4::identity(), Geometry::Ribbons(Arc::new(ribbons))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trail_is_never_longer_than_two_metres() {
        let mut trail = Trail::default();
        for i in 0..1000 {
            trail.follow(Vector3::new(f64::from(i) * 0.05, 0.0, 0.0));
        }
        let length: f64 = trail.places.iter().zip(trail.places.iter().skip(1)).map(|(a, b)| (a - b).norm()).sum();
        assert!((length - LENGTH_M).abs() < 1e-9, "{length}");
        assert!(trail.places.len() <= MAX_ELEMENTS);
        assert_eq!(trail.places[0].x, 999.0 * 0.05);
    }
}
