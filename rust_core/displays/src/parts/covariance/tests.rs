//! Numbers of a covariance that cannot be drawn; what is drawn of the others is shown by the golden cases.

use rcs_messages::geometry_msgs::PoseWithCovariance;

use super::*;

#[test]
fn what_is_too_large_for_single_precision_is_not_drawn() {
    for i in 0..6 {
        for (variance, is_drawn) in [(3.4e38, true), (3.5e38, false), (f64::MAX, false), (f64::INFINITY, false)] {
            let mut message = PoseWithCovariance::default();
            message.pose.orientation.w = 1.0;
            (0..6).for_each(|i| message.covariance[7 * i] = 1.0);
            message.covariance[7 * i] = variance;
            assert_eq!(uncertain_pose(&message).is_some(), is_drawn, "{i}: {variance:?}");
        }
    }
}
