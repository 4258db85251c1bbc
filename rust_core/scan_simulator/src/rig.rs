//! Camera and projector with their lenses and poses.

use nalgebra::{Isometry3, Point2, Point3, Translation3, Unit, UnitQuaternion, Vector3};
use rcs_calibration::{Distortion, Lens};

use crate::Random;

/// Image size of the camera, pixels.
const CAMERA_SIZE_PX: [u32; 2] = [640, 480];
/// Image size of a webcam, pixels.
const WEBCAM_SIZE_PX: [u32; 2] = [1280, 720];
/// Image size of the projector, pixels.
const PROJECTOR_SIZE_PX: [u32; 2] = [1280, 800];

/// Camera and projector in a room.
#[derive(Debug, Clone, PartialEq)]
pub struct Rig {
    /// Colour lens of the camera, to which its depth image is registered.
    pub camera: Lens,
    /// Projector lens.
    pub projector: Lens,
    /// Camera pose.
    pub room_from_camera: Isometry3<f64>,
    /// Projector pose.
    pub room_from_projector: Isometry3<f64>,
    /// Common target, in the room's frame, metres.
    pub target: Point3<f64>,
    /// Seed of the rig and its other places.
    pub seed: u64,
}

impl Rig {
    /// Random rig: a camera of 640×480 pixels like a Kinect's and, 0.1 to 0.35 m beside it, a projector of 1280×800
    /// pixels that mostly throws upwards. Both look at about the same place, 1.3 m away.
    pub fn random(seed: u64) -> Self {
        let random = &mut Random::new(&[seed, 0x0052_4947]);
        let (camera, projector) = (camera_lens(random), projector_lens(random));
        let mut uniform = |low, high| random.uniform(low, high);
        let target = Point3::new(uniform(-0.05, 0.05), uniform(-0.05, 0.05), 1.3);
        let from = Point3::new(uniform(-0.1, 0.1), uniform(-0.1, 0.1), uniform(-0.05, 0.05));
        // Beside, above or below, rarely at a slant.
        let quarter = uniform(0.0, 4.0).floor();
        let angle = std::f64::consts::FRAC_PI_2 * (quarter + uniform(-0.2, 0.2));
        let baseline = uniform(0.1, 0.35);
        let beside = Vector3::new(baseline * angle.cos(), baseline * angle.sin(), uniform(-0.03, 0.03));
        let mut near_target = || target + Vector3::new(uniform(-0.06, 0.06), uniform(-0.05, 0.05), 0.0);
        let (lit, seen) = (near_target(), near_target());
        let (projector_roll, camera_roll) = (uniform(-0.06, 0.06), uniform(-0.03, 0.03));
        Self {
            room_from_camera: looking_at(&camera, &(from + beside), &seen, camera_roll),
            room_from_projector: looking_at(&projector, &from, &lit, projector_roll),
            camera,
            projector,
            target,
            seed,
        }
    }

    /// [`Self::random`] with a webcam of 1280×720 pixels and its barrel distortion, in the same place.
    pub fn webcam(seed: u64) -> Self {
        let rig = Self::random(seed);
        let random = &mut Random::new(&[seed, 0x0057_4542]);
        let mut uniform = |low, high| random.uniform(low, high);
        let fx = uniform(950.0, 1150.0);
        let center = [639.5 + uniform(-20.0, 20.0), 359.5 + uniform(-15.0, 15.0)];
        let pinhole = Lens::pinhole(WEBCAM_SIZE_PX, [fx, fx * uniform(0.998, 1.002)], center);
        let terms = [uniform(-0.2, 0.05), uniform(-0.05, 0.1), uniform(-1e-3, 1e-3), uniform(-1e-3, 1e-3), 0.0];
        let camera = Lens { distortion: Distortion::plumb_bob(terms), ..pinhole };
        let from = Point3::from(rig.room_from_camera.translation.vector);
        let seen = rig.target + Vector3::new(uniform(-0.03, 0.03), uniform(-0.03, 0.03), 0.0);
        Self { room_from_camera: looking_at(&camera, &from, &seen, uniform(-0.03, 0.03)), camera, ..rig }
    }

    /// Rig with the camera at another place with about the same view; the projector stays. Place 0 is the first one.
    pub fn at_place(&self, place: u32) -> Self {
        if place == 0 {
            return self.clone();
        }
        let random = &mut Random::new(&[self.seed, u64::from(place), 0x504c_4143]);
        let mut uniform = |low, high| random.uniform(low, high);
        let from = Point3::new(uniform(-0.45, 0.45), uniform(-0.35, 0.2), uniform(-0.25, 0.1));
        let seen = self.target + Vector3::new(uniform(-0.12, 0.12), uniform(-0.1, 0.1), 0.0);
        let roll = uniform(-0.15, 0.15);
        Self { room_from_camera: looking_at(&self.camera, &from, &seen, roll), ..self.clone() }
    }

    /// Projector pose, from the camera's optical frame.
    pub fn projector_from_camera(&self) -> Isometry3<f64> {
        self.room_from_projector.inv_mul(&self.room_from_camera)
    }
}

/// Random lens of a colour camera with little or no distortion.
fn camera_lens(random: &mut Random) -> Lens {
    let fx = random.uniform(525.0, 570.0);
    let fy = fx * random.uniform(0.997, 1.003);
    let center = [319.5 + random.uniform(-8.0, 8.0), 239.5 + random.uniform(-8.0, 8.0)];
    let pinhole = Lens::pinhole(CAMERA_SIZE_PX, [fx, fy], center);
    if random.happens(0.5) {
        return pinhole;
    }
    let mut uniform = |most: f64| random.uniform(-most, most);
    let distortion = Distortion::plumb_bob([uniform(0.04), uniform(0.04), uniform(0.001), uniform(0.001), 0.0]);
    Lens { distortion, ..pinhole }
}

/// Random lens of a projector, with a distortion that is valid in and around the image.
fn projector_lens(random: &mut Random) -> Lens {
    loop {
        let mut uniform = |low, high| random.uniform(low, high);
        let fx = uniform(1100.0, 1900.0);
        let fy = fx * uniform(0.996, 1.004);
        let center = [639.5 + uniform(-25.0, 25.0), uniform(400.0, 850.0)];
        let [k1, k2] = [uniform(-0.15, 0.1), uniform(-0.03, 0.03)];
        let [p1, p2] = [uniform(-0.0015, 0.0015), uniform(-0.0015, 0.0015)];
        let distortion = Distortion::plumb_bob([k1, k2, p1, p2, 0.0]);
        let lens = Lens { distortion, ..Lens::pinhole(PROJECTOR_SIZE_PX, [fx, fy], center) };
        let [width, height] = PROJECTOR_SIZE_PX.map(f64::from);
        let is_valid = [[-80.0, -80.0], [width + 80.0, -80.0], [-80.0, height + 80.0], [width + 80.0, height + 80.0]]
            .iter()
            .all(|corner| {
                let place = lens.plane(Point2::from(*corner));
                place.is_some_and(|place| place.coords.norm() < 0.9 * distortion.valid_radius())
            });
        if is_valid {
            return lens;
        }
    }
}

/// Pose `room_from_lens` with the image's centre at a target; roll about that line in radians.
fn looking_at(lens: &Lens, from: &Point3<f64>, target: &Point3<f64>, roll: f64) -> Isometry3<f64> {
    let middle = Point2::from(lens.size_px.map(|size| 0.5 * (f64::from(size) - 1.0)));
    let ray = lens.ray(middle).unwrap_or_else(Vector3::z);
    let towards = Unit::new_normalize(target - from);
    let turned = UnitQuaternion::rotation_between(&ray, &towards).unwrap_or_else(UnitQuaternion::identity);
    let rotation = UnitQuaternion::from_axis_angle(&towards, roll) * turned;
    Isometry3::from_parts(Translation3::from(from.coords), rotation)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_look_at_the_target_from_every_place() {
        for seed in 0..50 {
            let rig = Rig::random(seed);
            let baseline = rig.projector_from_camera().translation.vector.norm();
            assert!((0.1..0.36).contains(&baseline), "seed {seed}: {baseline}");
            for place in 0..4 {
                let rig = rig.at_place(place);
                for (lens, pose) in [(&rig.camera, rig.room_from_camera), (&rig.projector, rig.room_from_projector)] {
                    let pixel = lens.project(&pose.inverse_transform_point(&rig.target)).unwrap();
                    assert!(lens.contains(pixel), "seed {seed}, place {place}: {pixel}");
                }
            }
            assert_eq!(rig.at_place(0), rig);
            assert_eq!(rig.at_place(2).room_from_projector, rig.room_from_projector);
            assert_ne!(rig.at_place(2).room_from_camera, rig.at_place(1).room_from_camera);
        }
    }

    #[test]
    fn every_pixel_of_the_projector_has_a_ray() {
        for seed in 0..50 {
            let lens = Rig::random(seed).projector;
            for pixel in [[-0.5, -0.5], [1279.5, -0.5], [-0.5, 799.5], [1279.5, 799.5], [640.0, 400.0]] {
                let pixel = Point2::from(pixel);
                let ray = lens.ray(pixel).unwrap();
                assert!((lens.project(&Point3::from(ray)).unwrap() - pixel).norm() < 1e-6);
            }
        }
    }
}
