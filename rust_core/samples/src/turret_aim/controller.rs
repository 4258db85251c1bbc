//! Commands the joints to an aim and reports it.

use std::time::{Duration, Instant};

use rcs_robot::Aim;
use rcs_ros::RosNode;

use super::arguments::TurretArguments;
use super::command::{send_goal, send_positions, CommandKind, Commander};
use super::inputs::{MissingInput, Posture};
use super::setpoint::{duration_of, Bounds, Setpoint};
use rcs_node_support::node_status::{Level, NodeStatus};

/// Time after which a goal that was not reached is sent again, because a controller may have started late.
const REPEAT_PERIOD: Duration = Duration::from_secs(1);

/// Controller of the pan-tilt unit.
pub(super) struct Controller {
    commander: Commander,
    dead_band: f64,
    speed: f64,
    /// Shortest duration of a motion.
    period: Duration,
    setpoint: Setpoint,
    sent: Option<Instant>,
}

impl Controller {
    /// Opens the topics.
    ///
    /// # Errors
    /// An invalid topic name.
    pub(super) fn start(node: &RosNode, arguments: &TurretArguments) -> anyhow::Result<Self> {
        let commander = match arguments.command {
            CommandKind::Float64 => Commander::positions(node, [&arguments.pan_topic, &arguments.tilt_topic])?,
            CommandKind::Trajectory => Commander::trajectories(node, &arguments.trajectory_topic)?,
        };
        Ok(Self {
            commander,
            dead_band: arguments.dead_band,
            speed: arguments.speed,
            period: Duration::from_secs_f64(1.0 / arguments.rate),
            setpoint: Setpoint::default(),
            sent: None,
        })
    }

    /// The topics of the commands.
    pub(super) fn topics(&self) -> String {
        self.commander.topics()
    }

    /// Commands the joints for one cycle of `elapsed`. Without a posture they stay.
    ///
    /// # Errors
    /// A command cannot be sent.
    pub(super) fn cycle(
        &mut self,
        posture: &Result<Posture<'_>, MissingInput>,
        elapsed: Duration,
        status: &mut NodeStatus,
    ) -> anyhow::Result<()> {
        let posture = match posture {
            Ok(posture) => posture,
            Err(missing) => {
                self.setpoint.forget();
                match missing {
                    MissingInput::Awaited(what) => status.set(Level::Warn, what, ""),
                    MissingInput::Invalid(what) => status.set(Level::Error, what, ""),
                }
                return Ok(());
            }
        };
        let Some(aim) = posture.pan_tilt.aim(&posture.beam, posture.target, posture.present) else {
            self.setpoint.forget();
            status.set(Level::Warn, "the target is at the lens", "");
            return Ok(());
        };
        report(posture, &aim, status);
        self.command(posture, aim.positions, elapsed)
    }

    fn command(&mut self, posture: &Posture<'_>, goal: [f64; 2], elapsed: Duration) -> anyhow::Result<()> {
        let joints = posture.unit.joints();
        let speed = |most: Option<f64>| most.map_or(self.speed, |most| most.min(self.speed));
        let bounds =
            Bounds { dead_band: self.dead_band, speeds: joints.each_ref().map(|joint| speed(joint.greatest_speed)) };
        let is_new = self.setpoint.take_goal(goal, posture.present, &bounds);
        let goal = self.setpoint.goal().unwrap_or(goal);
        let is_away = (0..2).any(|joint| (goal[joint] - posture.present[joint]).abs() > self.dead_band.max(0.001));
        let repeats = is_away && self.sent.is_none_or(|sent| sent.elapsed() > REPEAT_PERIOD);
        match &self.commander {
            Commander::Positions(topics) => {
                let next = self.setpoint.advance(elapsed, &bounds);
                if let Some(positions) = next.or(repeats.then_some(goal)) {
                    send_positions(topics, positions)?;
                    self.sent = Some(Instant::now());
                }
            }
            Commander::Trajectories(topic) if is_new || repeats => {
                let duration = duration_of(posture.present, goal, bounds.speeds).max(self.period);
                send_goal(topic, joints.each_ref().map(|joint| joint.name.as_str()), goal, duration)?;
                self.sent = Some(Instant::now());
            }
            Commander::Trajectories(_) => {}
        }
        Ok(())
    }
}

/// Reports the aim and the present angular error.
fn report(posture: &Posture<'_>, aim: &Aim, status: &mut NodeStatus) {
    let joints = posture.unit.joints();
    for (key, (joint, position)) in ["first joint", "second joint"].into_iter().zip(joints.iter().zip(aim.positions)) {
        status.value(key, &format!("{} to {position:.4}", joint.name));
    }
    let now = posture.pan_tilt.miss_rad(&posture.beam, posture.target, posture.present);
    let degrees =
        |radians: Option<f64>| radians.map_or("-".to_owned(), |radians| format!("{:.2}", radians.to_degrees()));
    status.value("aiming error, degrees", &degrees(now));
    status.value("smallest error within the limits, degrees", &degrees(Some(aim.miss_rad)));
    if aim.meets() {
        status.set(Level::Ok, "aiming at the target", "");
        return;
    }
    let at_limits = joints.iter().zip(aim.positions).filter_map(|(joint, position)| {
        joint.limit_at(position).map(|limit| format!("joint {} is at its limit of {limit:.3}", joint.name))
    });
    let at_limits: Vec<String> = at_limits.collect();
    let why = if at_limits.is_empty() { "no joint positions light it".to_owned() } else { at_limits.join(", ") };
    let miss = format!("the smallest error is {} degrees", degrees(Some(aim.miss_rad)));
    status.set(Level::Warn, &format!("the target cannot be reached: {why}"), &miss);
}
