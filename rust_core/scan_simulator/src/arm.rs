//! Arm with a hand that reaches into the room, in front of something that the projector lights.

use nalgebra::{Isometry3, Point2, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};

use crate::room::{Shape, Solid};
use crate::surface::Surface;
use crate::{Random, Rig, Room};

/// Half the size of a hand's palm, metres: across, thick, along the arm.
const PALM_M: [f64; 3] = [0.042, 0.014, 0.05];
/// Radius and half the length of a finger, metres.
const FINGER_M: [f64; 2] = [0.009, 0.035];
/// Radius and half the length of the forearm, metres.
const FOREARM_M: [f64; 2] = [0.038, 0.3];
/// Distance that an arm moves in one step, metres.
const STEP_M: f64 = 0.06;

/// Forearm and hand, with the fingers along z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arm {
    /// Pose of the palm's centre.
    room_from_palm: Isometry3<f64>,
}

impl Arm {
    /// Random arm whose palm is 0.08 to 0.4 m before a surface that the projector lights; it comes from a side, and a
    /// little from the front. `None` where the room has no such place.
    pub fn reaching(room: &Room, rig: &Rig, seed: u64) -> Option<Self> {
        let random = &mut Random::new(&[seed, 0x0041_524d]);
        let mut uniform = |low, high| random.uniform(low, high);
        let size = rig.projector.size_px.map(f64::from);
        let pixel = Point2::new(size[0] * uniform(0.2, 0.8), size[1] * uniform(0.2, 0.8));
        let ray = rig.room_from_projector * rig.projector.ray(pixel)?.normalize();
        let lamp = Point3::from(rig.room_from_projector.translation.vector);
        let lit = room.hit(&lamp, &ray)?;
        let palm = lit.point - ray * uniform(0.08, 0.4_f64.min(0.5 * lit.distance));
        // From any side, the fingers ahead.
        let angle = uniform(0.0, std::f64::consts::TAU);
        let along = Vector3::new(angle.cos(), angle.sin(), uniform(-0.2, 0.6));
        let turned = Rotation3::rotation_between(&Vector3::z(), &along)?;
        let roll = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), uniform(0.0, std::f64::consts::TAU));
        let rotation = UnitQuaternion::from_rotation_matrix(&turned) * roll;
        Some(Self { room_from_palm: Isometry3::from_parts(Translation3::from(palm.coords), rotation) })
    }

    /// The arm further in by this number of steps of 6 cm.
    #[must_use]
    pub fn moved(&self, steps: f64) -> Self {
        let along = Translation3::new(0.0, 0.0, STEP_M * steps);
        Self { room_from_palm: self.room_from_palm * along }
    }

    /// The room with the arm in it.
    #[must_use]
    pub fn within(&self, room: &Room) -> Room {
        let [across, thick, along] = PALM_M;
        let part = |shape: Shape, place: [f64; 3]| {
            let centre = self.room_from_palm * Point3::from(place);
            Solid::new(shape, centre.coords, self.room_from_palm.rotation, Surface::plain(0.55))
        };
        let fingers = [-1.5, -0.5, 0.5, 1.5].map(|finger| {
            let [radius, half_length] = FINGER_M;
            part(Shape::Capsule(radius, half_length), [finger * 2.35 * radius, 0.0, along + half_length])
        });
        let palm = part(Shape::Cuboid(Vector3::new(across, thick, along)), [0.0; 3]);
        let [radius, half_length] = FOREARM_M;
        let forearm = part(Shape::Capsule(radius, half_length), [0.0, 0.0, -along - half_length]);
        room.with(fingers.into_iter().chain([palm, forearm]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arm_is_between_the_projector_and_what_it_lights() {
        for seed in 0..20 {
            let (room, rig) = (Room::cluttered(seed), Rig::random(seed));
            let arm = Arm::reaching(&room, &rig, seed).unwrap();
            let lamp = Point3::from(rig.room_from_projector.translation.vector);
            let palm = Point3::from(arm.room_from_palm.translation.vector);
            let hit = arm.within(&room).hit(&lamp, &(palm - lamp)).unwrap();
            assert!(hit.distance < 1.0 && room.hit(&lamp, &(palm - lamp)).unwrap().distance > 1.0, "seed {seed}");
            let moved = arm.moved(-1.0).room_from_palm.translation.vector - palm.coords;
            assert!((moved.norm() - STEP_M).abs() < 1e-12);
        }
    }
}
