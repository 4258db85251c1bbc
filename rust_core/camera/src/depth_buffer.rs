//! Conversion of depth buffer values to metres.

/// Distance in metres along the optical axis of a value in the depth buffer of a perspective camera: 0 at `near_m`, 1
/// at `far_m`. NaN where nothing was drawn (1 or more) and for invalid values.
#[inline]
pub fn metres_of_depth_buffer(depth: f32, near_m: f64, far_m: f64) -> f32 {
    if !(0.0..1.0).contains(&depth) {
        return f32::NAN;
    }
    (near_m * far_m / (far_m - f64::from(depth) * (far_m - near_m))) as f32
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Point3};
    use rcs_scene::{Camera, Intrinsics, FAR_CLIP_M};

    use super::*;

    #[test]
    fn a_depth_is_what_the_projection_made_of_the_distance() {
        let p = [500.0, 0.0, 320.0, 0.0, 0.0, 500.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        let camera = Camera::new(Intrinsics::from_p(640, 480, &p).unwrap(), &Isometry3::identity(), 0.05);
        for distance_m in [0.05001, 0.1, 1.0, 7.5, 60.0] {
            let clip = camera.clip_from_view() * Point3::new(0.1, 0.2, -distance_m).to_homogeneous();
            let depth = (0.5 + 0.5 * clip.z / clip.w) as f32;
            let back = f64::from(metres_of_depth_buffer(depth, camera.near_m(), FAR_CLIP_M));
            // A depth of 32 bits near 1 is good to 2^-25, which far away is much.
            let tolerance_m = 1e-6 + distance_m * distance_m * 6e-8 / 0.05;
            assert!((back - distance_m).abs() < tolerance_m, "{back} instead of {distance_m}");
        }
    }

    #[test]
    fn nothing_is_nowhere() {
        for depth in [1.0, 1.5, -0.1, f32::NAN, f32::INFINITY] {
            assert!(metres_of_depth_buffer(depth, 0.01, 100.0).is_nan());
        }
    }
}
