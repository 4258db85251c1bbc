//! Direction of rviz's main camera.
//!
//! An Ogre camera looks along its own -Z, and rviz attaches it to a node at the target frame. The node follows the
//! frame's position, in a ThirdPersonFollower its heading, and in FrameAligned its whole rotation.
//!
//! ```text
//! orbits:  camera at  focal + d·(cos yaw·cos pitch, sin yaw·cos pitch, sin pitch), looking back at the focal point
//! free:    camera turned by  Rz(yaw)·Ry(pitch)·Rx(roll)  from looking along +X
//! ortho:   camera above, turned around Z, looking along -Z
//! ```

use crate::view::{OrbitView, ViewConfig, ViewController};

impl ViewConfig {
    /// Unit vector along which the camera looks, in the axes of the view: the fixed frame's, rotated by the followed
    /// part of the target frame's rotation, as in [`Self::direction_in_fixed_frame`].
    pub fn direction_in_target_frame(&self) -> [f64; 3] {
        match &self.controller {
            ViewController::Orbit(orbit) | ViewController::ThirdPersonFollower(orbit) => self.orbit_direction(orbit),
            // rviz turns the camera only when an angle changes, so that one left at all zeros keeps Ogre's rest pose.
            ViewController::Fps(view) if [view.yaw_rad, view.pitch_rad, view.roll_rad] == [0.0; 3] => [0.0, 0.0, -1.0],
            ViewController::Fps(view) | ViewController::FrameAligned(view) => {
                let (yaw, pitch) = (f64::from(view.yaw_rad), f64::from(view.pitch_rad));
                [yaw.cos() * pitch.cos(), yaw.sin() * pitch.cos(), -pitch.sin()]
            }
            ViewController::TopDownOrtho => [0.0, 0.0, -1.0],
        }
    }

    fn orbit_direction(&self, orbit: &OrbitView) -> [f64; 3] {
        let sign = if self.invert_z { -1.0 } else { 1.0 };
        let yaw = sign * f64::from(orbit.yaw_rad);
        let pitch = sign * f64::from(orbit.pitch_rad);
        [-yaw.cos() * pitch.cos(), -yaw.sin() * pitch.cos(), -pitch.sin()]
    }

    /// Unit vector along which the camera looks, in the fixed frame. `fixed_from_target` is the rotation of the target
    /// frame as a unit quaternion x, y, z, w; the identity when it is the fixed frame or unknown.
    pub fn direction_in_fixed_frame(&self, fixed_from_target: [f64; 4]) -> [f64; 3] {
        let direction = self.direction_in_target_frame();
        let [x, y, z, w] = fixed_from_target;
        match &self.controller {
            ViewController::ThirdPersonFollower(_) => {
                let heading = f64::atan2(2.0 * (x * y + w * z), w * w + x * x - y * y - z * z) / 2.0;
                rotate([0.0, 0.0, heading.sin(), heading.cos()], direction)
            }
            ViewController::FrameAligned(_) => rotate(fixed_from_target, direction),
            ViewController::Orbit(_) | ViewController::Fps(_) | ViewController::TopDownOrtho => direction,
        }
    }
}

/// `v` rotated by the unit quaternion x, y, z, w: v + 2w(q×v) + 2q×(q×v).
fn rotate([x, y, z, w]: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    let cross = |b: [f64; 3]| [y * b[2] - z * b[1], z * b[0] - x * b[2], x * b[1] - y * b[0]];
    let once = cross(v);
    let twice = cross(once);
    [0, 1, 2].map(|i| v[i] + 2.0 * (w * once[i] + twice[i]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::FreeView;

    const IDENTITY: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

    fn assert_close(actual: [f64; 3], expected: [f64; 3]) {
        let distance: f64 = (0..3).map(|i| (actual[i] - expected[i]).abs()).sum();
        assert!(distance < 1e-6, "{actual:?} is not {expected:?}");
    }

    fn orbit(yaw_rad: f32, pitch_rad: f32) -> OrbitView {
        OrbitView { yaw_rad, pitch_rad }
    }

    fn view(controller: ViewController) -> ViewConfig {
        ViewConfig { controller, ..ViewConfig::default() }
    }

    fn fps(yaw_rad: f32, pitch_rad: f32, roll_rad: f32) -> ViewConfig {
        view(ViewController::Fps(FreeView { yaw_rad, pitch_rad, roll_rad }))
    }

    #[test]
    fn an_orbit_from_ahead_and_above_looks_back_and_down() {
        let at = view(ViewController::Orbit(orbit(0.0, std::f32::consts::FRAC_PI_4)));
        let half = 0.5_f64.sqrt();
        assert_close(at.direction_in_target_frame(), [-half, 0.0, -half]);
        let inverted = ViewConfig { invert_z: true, ..at };
        assert_close(inverted.direction_in_target_frame(), [-half, 0.0, half]);
    }

    #[test]
    fn a_free_camera_with_all_angles_zero_was_never_turned() {
        assert_close(fps(0.0, 0.0, 0.0).direction_in_target_frame(), [0.0, 0.0, -1.0]);
    }

    #[test]
    fn views_turn_with_the_frame_each_in_its_way() {
        // A frame turned left by a quarter and then rolled onto its side around its own X.
        let half = 0.5_f64.sqrt();
        let left = [0.0, 0.0, half, half];
        let left_on_its_side = [0.5, 0.5, 0.5, 0.5];
        let still = view(ViewController::Orbit(orbit(0.0, 0.0)));
        assert_close(still.direction_in_fixed_frame(left), [-1.0, 0.0, 0.0]);
        let follower = view(ViewController::ThirdPersonFollower(orbit(0.0, 0.0)));
        assert_close(follower.direction_in_fixed_frame(IDENTITY), [-1.0, 0.0, 0.0]);
        assert_close(follower.direction_in_fixed_frame(left), [0.0, -1.0, 0.0]);
        assert_close(follower.direction_in_fixed_frame(left_on_its_side), [0.0, -1.0, 0.0]);
        let turned = FreeView { yaw_rad: std::f32::consts::FRAC_PI_2, ..FreeView::default() };
        let aligned = view(ViewController::FrameAligned(turned));
        assert_close(aligned.direction_in_fixed_frame(left), [-1.0, 0.0, 0.0]);
        assert_close(aligned.direction_in_fixed_frame(left_on_its_side), [0.0, 0.0, 1.0]);
    }
}
