//! `rviz/Odometry`: the poses that a robot went through, each where its frame was when it was there.
//!
//! A pose is added when it is far enough from the last added one, compared as the messages have them, whatever their
//! frames.

use nalgebra::{Isometry3, Quaternion, Vector3};
use rcs_messages::geometry_msgs::Twist;
use rcs_messages::nav_msgs::Odometry;
use rcs_messages::{translation_xyz, PlainTransform};
use rcs_rviz_config::OdometrySettings;
use rcs_scene::DisplayId;

use crate::framework::message_display::{DrawResult, InvalidFloats, MessageDisplay, MessageVisual};
use crate::framework::world::all_finite;
use crate::parts::covariance::{uncertain_pose, CovarianceScales, CovarianceSymbol};
use crate::parts::pose_symbol::PoseSymbol;

#[derive(Debug)]
pub(crate) struct OdometryVisual {
    display: DisplayId,
    settings: OdometrySettings,
    symbol: PoseSymbol,
    covariance: CovarianceSymbol,
    /// Last added pose, as in the message.
    last: Option<PlainTransform>,
}

pub(crate) fn create(display: DisplayId, settings: &OdometrySettings) -> MessageDisplay<OdometryVisual> {
    let visual = OdometryVisual {
        display,
        symbol: (&settings.symbol).into(),
        covariance: CovarianceSymbol::new(display, &settings.covariance),
        settings: settings.clone(),
        last: None,
    };
    // "Keep: 0" keeps all.
    let history_length = Some(settings.keep).filter(|&keep| keep > 0);
    MessageDisplay::new(&settings.topic, settings.queue_size, history_length, visual)
}

impl OdometryVisual {
    /// `true` if two poses differ by less than the tolerances.
    fn is_near(&self, a: &PlainTransform, b: &PlainTransform) -> bool {
        let single = |pose: &PlainTransform| Vector3::from(pose.translation).cast::<f32>();
        (single(a) - single(b)).norm() < self.settings.position_tolerance_m
            && angle_rad(a, b) < self.settings.angle_tolerance_rad
    }
}

impl MessageVisual for OdometryVisual {
    type Message = Odometry;

    fn draw(&mut self, message: &Odometry, fixed_from_frame: &Isometry3<f64>) -> DrawResult {
        let (frame_from_pose, covariance) = uncertain_pose(&message.pose).ok_or(InvalidFloats)?;
        if !is_finite(&message.twist.twist) {
            return Err(InvalidFloats);
        }
        let pose = PlainTransform::from(&message.pose.pose);
        if self.last.as_ref().is_some_and(|last| self.is_near(last, &pose)) {
            return Ok(None);
        }
        let symbol = self.symbol.drawables(self.display, &(fixed_from_frame * frame_from_pose));
        let mut scales = CovarianceScales::default();
        let covariance = self.covariance.drawables(fixed_from_frame, &frame_from_pose, &covariance, &mut scales);
        self.last = Some(pose);
        Ok(Some(symbol.into_iter().chain(covariance).collect()))
    }

    fn reset(&mut self) {
        self.last = None;
    }
}

/// Angle between two orientations, 0 to π; quaternions need not be of unit length.
fn angle_rad(a: &PlainTransform, b: &PlainTransform) -> f32 {
    let [a, b] = [a, b].map(|pose| {
        let [x, y, z, w] = pose.rotation_xyzw.map(|value| value as f32);
        Quaternion::new(w, x, y, z)
    });
    let between = a * b.conjugate();
    2.0 * between.imag().norm().atan2(between.w.abs())
}

fn is_finite(twist: &Twist) -> bool {
    [&twist.linear, &twist.angular].iter().all(|vector| all_finite(&translation_xyz(vector)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::framework::display::Display;
    use crate::parts::gathering::singly;
    use rcs_rviz_config::CovarianceSettings;

    fn odometry(x: f64, yaw_rad: f64) -> Odometry {
        let mut message = Odometry::default();
        message.pose.pose.position.x = x;
        (message.pose.pose.orientation.z, message.pose.pose.orientation.w) = (yaw_rad / 2.0).sin_cos();
        message
    }

    fn display(keep: u32) -> MessageDisplay<OdometryVisual> {
        let settings = OdometrySettings {
            keep,
            position_tolerance_m: 0.5,
            angle_tolerance_rad: 0.3,
            covariance: CovarianceSettings { position: None, orientation: None },
            ..OdometrySettings::default()
        };
        create(0, &settings)
    }

    fn shown(display: &mut MessageDisplay<OdometryVisual>, message: &Odometry) -> Result<bool, InvalidFloats> {
        display.show(message, &Isometry3::identity())
    }

    #[test]
    fn a_pose_within_both_tolerances_of_the_last_that_was_added_is_left_out() {
        let mut display = display(0);
        // The creeping 0.4 m steps count from the last pose that was added, not from the last message.
        let added = [(0.0, 0.0), (0.4, 0.0), (0.8, 0.0), (0.9, 0.2), (0.9, 0.35), (0.9, 0.35)]
            .map(|(x, yaw_rad)| shown(&mut display, &odometry(x, yaw_rad)));
        assert_eq!(added, [Ok(true), Ok(false), Ok(true), Ok(false), Ok(true), Ok(false)]);
        assert_eq!(singly(display.drawables()).len(), 3 * 2);
    }

    #[test]
    fn the_oldest_pose_is_dropped_unless_all_are_kept() {
        for (keep, expected) in [(0, 9), (1, 1), (4, 4)] {
            let mut display = display(keep);
            for i in 0..9 {
                assert_eq!(shown(&mut display, &odometry(f64::from(i), 0.0)), Ok(true));
            }
            let drawn = singly(display.drawables());
            assert_eq!(drawn.len(), expected * 2, "keep {keep}");
            let last = drawn.last().map(|head| head.fixed_from_object[(0, 3)]);
            assert!(last.is_some_and(|x| (x - 9.15).abs() < 1e-6), "{last:?}");
        }
    }

    #[test]
    fn numbers_that_are_none_change_nothing() {
        let mut display = display(0);
        let spoil: [fn(&mut Odometry); 6] = [
            |m| m.pose.pose.position.y = f64::NAN,
            |m| m.pose.pose.orientation.x = f64::INFINITY,
            |m| m.pose.covariance[35] = f64::NAN,
            |m| m.pose.covariance[21] = f64::MAX,
            |m| m.twist.twist.angular.z = f64::NEG_INFINITY,
            |m| m.twist.twist.linear.x = -1e39,
        ];
        for spoil in spoil {
            let mut message = odometry(0.0, 0.0);
            spoil(&mut message);
            assert_eq!(shown(&mut display, &message), Err(InvalidFloats));
        }
        assert_eq!(display.drawables().len(), 0);
        // The twist's covariance is of no interest.
        let mut message = odometry(0.0, 0.0);
        message.twist.covariance[0] = f64::NAN;
        assert_eq!(shown(&mut display, &message), Ok(true));
    }
}
