//! Set points of the joints, with a dead band and speed limits.

use std::time::Duration;

/// Limits of the commands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    /// A goal closer than this to the last one is ignored, radians.
    pub(super) dead_band: f64,
    /// Speed limit of each joint, radians per second.
    pub(super) speeds: [f64; 2],
}

/// Set points of both joints.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Setpoint {
    /// Last accepted goal and last commanded position; `None` before the first.
    sent: Option<SentGoal>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct SentGoal {
    goal: [f64; 2],
    position: [f64; 2],
}

/// Duration of a synchronised motion of both joints within their speed limits.
pub(super) fn duration_of(from: [f64; 2], to: [f64; 2], speeds: [f64; 2]) -> Duration {
    let secs = (0..2).map(|joint| (to[joint] - from[joint]).abs() / speeds[joint]).fold(0.0, f64::max);
    Duration::try_from_secs_f64(secs).unwrap_or_default()
}

impl Setpoint {
    /// Accepts a goal outside the dead band; `true` if it did.
    pub(super) fn take_goal(&mut self, goal: [f64; 2], present: [f64; 2], bounds: &Bounds) -> bool {
        let Some(sent) = &mut self.sent else {
            self.sent = Some(SentGoal { goal, position: present });
            return true;
        };
        let is_new = (0..2).any(|joint| (goal[joint] - sent.goal[joint]).abs() > bounds.dead_band);
        if is_new {
            sent.goal = goal;
        }
        is_new
    }

    /// The last accepted goal.
    pub(super) fn goal(&self) -> Option<[f64; 2]> {
        self.sent.map(|sent| sent.goal)
    }

    /// The next position on a straight line to the goal after `elapsed`; `None` once the goal was commanded.
    pub(super) fn advance(&mut self, elapsed: Duration, bounds: &Bounds) -> Option<[f64; 2]> {
        let sent = self.sent.as_mut()?;
        if sent.position == sent.goal {
            return None;
        }
        let whole = duration_of(sent.position, sent.goal, bounds.speeds).as_secs_f64();
        let share = elapsed.as_secs_f64() / whole;
        // Within rounding of the goal.
        sent.position = if share >= 1.0 - 1e-9 || whole == 0.0 {
            sent.goal
        } else {
            [0, 1].map(|joint| sent.position[joint] + (sent.goal[joint] - sent.position[joint]) * share)
        };
        Some(sent.position)
    }

    /// Forgets the last goal.
    pub(super) fn forget(&mut self) {
        self.sent = None;
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const BOUNDS: Bounds = Bounds { dead_band: 0.01, speeds: [1.0, 0.5] };
    const CYCLE: Duration = Duration::from_millis(50);

    #[test]
    fn both_joints_arrive_together_at_no_more_than_their_speeds() {
        let mut setpoint = Setpoint::default();
        assert!(setpoint.take_goal([0.4, 0.2], [0.0, 0.0], &BOUNDS));
        let path: Vec<[f64; 2]> = std::iter::from_fn(|| setpoint.advance(CYCLE, &BOUNDS)).collect();
        assert_eq!(path.len(), 8, "0.4 s at 20 Hz: {path:?}");
        assert_eq!(path[7], [0.4, 0.2]);
        assert!(path.iter().all(|[pan, tilt]| (pan - 2.0 * tilt).abs() < 1e-12), "{path:?}");
    }

    #[test]
    fn a_goal_within_the_dead_band_is_left() {
        let mut setpoint = Setpoint::default();
        setpoint.take_goal([0.1, 0.0], [0.1, 0.0], &BOUNDS);
        assert!(!setpoint.take_goal([0.109, -0.009], [0.1, 0.0], &BOUNDS));
        assert_eq!(setpoint.goal(), Some([0.1, 0.0]));
        assert!(setpoint.take_goal([0.1, 0.011], [0.1, 0.0], &BOUNDS));
        assert_eq!(setpoint.goal(), Some([0.1, 0.011]));
        setpoint.forget();
        assert!(setpoint.take_goal([0.1, 0.011], [0.1, 0.0], &BOUNDS));
    }

    proptest! {
        #[test]
        fn no_step_is_faster_than_allowed(goals in proptest::collection::vec([-3.0..3.0, -3.0..3.0], 1..40), ms in 1..200_u64) {
            let (mut setpoint, mut last) = (Setpoint::default(), [0.0, 0.0]);
            let elapsed = Duration::from_millis(ms);
            for goal in goals {
                setpoint.take_goal(goal, last, &BOUNDS);
                if let Some(next) = setpoint.advance(elapsed, &BOUNDS) {
                    for joint in 0..2 {
                        let most = BOUNDS.speeds[joint] * elapsed.as_secs_f64();
                        prop_assert!((next[joint] - last[joint]).abs() <= most + 1e-9);
                    }
                    last = next;
                }
            }
        }
    }
}
