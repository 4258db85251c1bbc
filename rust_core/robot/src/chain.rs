//! Kinematic chains: the joints between two links of a robot.

use nalgebra::Isometry3;
use thiserror::Error;

use crate::{Joint, JointKind, Robot};

/// Why a chain or a joint cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ChainError {
    /// The description has no such joint.
    #[error("the robot's description has no joint \"{0}\"; its turning joints are: {1}")]
    NoJoint(String, String),
    /// The joint does not rotate.
    #[error("joint \"{0}\" does not turn: it is neither revolute nor continuous")]
    NotTurning(String),
    /// The joint follows another one (mimic).
    #[error("joint \"{0}\" follows joint \"{1}\" (mimic) and cannot be commanded")]
    Mimic(String, String),
    /// The joint's axis has length 0.
    #[error("joint \"{0}\" has an axis of length 0")]
    NoAxis(String),
    /// The lower limit is above the upper one.
    #[error("joint \"{0}\" has a lower limit above its upper one")]
    NoTravel(String),
    /// The second joint does not move with the first.
    #[error("joint \"{second}\" does not hang on joint \"{first}\": are they in the right order?")]
    NotBehind {
        /// The joint nearer to the base.
        first: String,
        /// The other joint.
        second: String,
    },
    /// The chain has not exactly two rotating joints.
    #[error("{count} joints turn above link \"{link}\" ({names}): name the two to aim with")]
    NotTwo {
        /// The last link of the chain.
        link: String,
        /// Number of rotating joints.
        count: usize,
        /// Their names.
        names: String,
    },
}

impl Robot {
    /// The joint that moves a link; `None` for the root and for unknown links.
    fn joint_above(&self, link: &str) -> Option<(&str, &Joint)> {
        self.joints.iter().find(|(_, joint)| joint.child_link == link).map(|(name, joint)| (name.as_str(), joint))
    }

    /// The link that no joint moves.
    pub fn root(&self) -> Option<&str> {
        let is_moved = |link: &&String| self.joint_above(link).is_some();
        self.links.keys().find(|link| !is_moved(link)).map(String::as_str)
    }

    /// Joints from a link up to the root, each with its name.
    pub fn joints_above<'a>(&'a self, link: &'a str) -> impl Iterator<Item = (&'a str, &'a Joint)> {
        // A description is a tree (`parse` checks that it has one root); no chain has more joints than there are.
        let mut link = link;
        (0..self.joints.len()).map_while(move |_| {
            let (name, joint) = self.joint_above(link)?;
            link = &joint.parent_link;
            Some((name, joint))
        })
    }

    /// Pose of `link` in `ancestor`, if only fixed joints lie between them.
    pub fn fixed_transform(&self, ancestor: &str, link: &str) -> Option<Isometry3<f64>> {
        if ancestor == link {
            return self.links.contains_key(link).then(Isometry3::identity);
        }
        let mut ancestor_from_link = Isometry3::identity();
        for (_, joint) in self.joints_above(link) {
            if joint.kind != JointKind::Fixed {
                return None;
            }
            ancestor_from_link = joint.parent_from_child_at_zero * ancestor_from_link;
            if joint.parent_link == ancestor {
                return Some(ancestor_from_link);
            }
        }
        None
    }

    /// The two rotating joints above a link, the one nearer to the base first.
    ///
    /// # Errors
    /// [`ChainError::NotTwo`], with the names of all.
    pub fn two_turning_joints(&self, link: &str) -> Result<[String; 2], ChainError> {
        let turns = |joint: &Joint| joint.turns() && joint.mimics.is_none();
        let turning = self.joints_above(link).filter(|(_, joint)| turns(joint));
        let mut names: Vec<String> = turning.map(|(name, _)| name.to_owned()).collect();
        names.reverse();
        <[String; 2]>::try_from(names).map_err(|names| ChainError::NotTwo {
            link: link.to_owned(),
            count: names.len(),
            names: list_of(names.iter().map(String::as_str)),
        })
    }

    /// A rotating joint that can be commanded, by its name.
    ///
    /// # Errors
    /// [`ChainError::NoJoint`], [`ChainError::NotTurning`] or [`ChainError::Mimic`].
    pub fn turning_joint(&self, name: &str) -> Result<&Joint, ChainError> {
        let names = || list_of(self.joints.iter().filter(|(_, joint)| joint.turns()).map(|(name, _)| name.as_str()));
        let joint = self.joints.get(name).ok_or_else(|| ChainError::NoJoint(name.to_owned(), names()))?;
        match &joint.mimics {
            _ if !joint.turns() => Err(ChainError::NotTurning(name.to_owned())),
            Some(other) => Err(ChainError::Mimic(name.to_owned(), other.clone())),
            None => Ok(joint),
        }
    }

    /// Checks that the joint `second` moves with the joint `first`.
    ///
    /// # Errors
    /// [`ChainError::NotBehind`].
    pub fn check_order(&self, first: &str, second: &str) -> Result<(), ChainError> {
        let start = self.joints.get(second).map(|joint| joint.parent_link.as_str()).unwrap_or_default();
        let is_behind = self.joints_above(start).any(|(name, _)| name == first);
        if is_behind {
            return Ok(());
        }
        Err(ChainError::NotBehind { first: first.to_owned(), second: second.to_owned() })
    }
}

/// Names with commas between them.
fn list_of<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.collect();
    if names.is_empty() {
        "none".to_owned()
    } else {
        names.join(", ")
    }
}

impl Joint {
    /// `true` if it rotates about an axis.
    pub fn turns(&self) -> bool {
        matches!(self.kind, JointKind::Revolute | JointKind::Continuous)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ARM: &str = "<robot name='r'>
        <link name='base'/><link name='a'/><link name='b'/><link name='mount'/><link name='c'/><link name='lens'/>
        <joint name='lift' type='prismatic'><parent link='base'/><child link='a'/>
          <limit lower='0' upper='1' effort='1' velocity='1'/></joint>
        <joint name='pan' type='revolute'><parent link='a'/><child link='b'/><origin xyz='1 0 0'/><axis xyz='0 0 2'/>
          <limit lower='-2' upper='2' effort='1' velocity='3'/>
          <safety_controller k_velocity='1' soft_lower_limit='-1.5' soft_upper_limit='2.5'/></joint>
        <joint name='bracket' type='fixed'><parent link='b'/><child link='mount'/><origin xyz='0 2 0'/></joint>
        <joint name='tilt' type='continuous'><parent link='mount'/><child link='c'/><axis xyz='0 1 0'/></joint>
        <joint name='optics' type='fixed'><parent link='c'/><child link='lens'/><origin xyz='0 0 3'/></joint>
        </robot>";

    #[test]
    fn the_joints_between_base_and_lens_are_found() {
        let robot = Robot::parse(ARM).unwrap();
        assert_eq!(robot.root(), Some("base"));
        assert_eq!(robot.two_turning_joints("lens").unwrap(), ["pan", "tilt"]);
        assert_eq!(robot.fixed_transform("b", "mount").unwrap().translation.vector.data.0, [[0.0, 2.0, 0.0]]);
        assert_eq!(robot.fixed_transform("c", "lens").unwrap().translation.vector.data.0, [[0.0, 0.0, 3.0]]);
        assert_eq!(robot.fixed_transform("b", "lens"), None, "the tilt lies between them");
        assert_eq!(robot.fixed_transform("lens", "c"), None);
        assert_eq!(robot.check_order("pan", "tilt"), Ok(()));
    }

    #[test]
    fn limits_are_those_of_the_safety_controller_where_they_are_narrower() {
        let robot = Robot::parse(ARM).unwrap();
        let limits = robot.joints["pan"].limits.unwrap();
        assert_eq!((limits.lower, limits.upper, limits.velocity), (-1.5, 2.0, 3.0));
        assert_eq!(robot.joints["tilt"].limits, None);
    }

    #[test]
    fn what_cannot_be_turned_is_named() {
        let robot = Robot::parse(ARM).unwrap();
        let error = |name: &str| robot.turning_joint(name).unwrap_err().to_string();
        assert_eq!(error("head"), "the robot's description has no joint \"head\"; its turning joints are: pan, tilt");
        assert!(error("lift").contains("does not turn"));
        assert!(robot.check_order("tilt", "pan").unwrap_err().to_string().contains("right order"));
        let one = robot.two_turning_joints("mount").unwrap_err();
        assert_eq!(one.to_string(), "1 joints turn above link \"mount\" (pan): name the two to aim with");
    }
}
