//! The ROS 1 distribution of this shell, and the system that it runs on.

use std::path::Path;

use super::finding::Finding;

const CHECK: &str = "distribution";

/// The distribution of this process's environment.
pub(super) fn distribution() -> Finding {
    of(|name| std::env::var(name).ok(), Path::new("/"))
}

/// The distribution that the variables of `environment` name, or Debian's own below `root`/usr.
fn of(environment: impl Fn(&str) -> Option<String>, root: &Path) -> Finding {
    let system = system(root);
    let sourced = environment("ROS_DISTRO").filter(|name| !name.is_empty());
    let is_version_1 = environment("ROS_VERSION").is_none_or(|version| version == "1");
    match sourced {
        Some(name) if is_version_1 => Finding::good(CHECK, format!("{name}, on {system}")),
        Some(name) => Finding::unknown(
            CHECK,
            format!("{name} is ROS 2, on {system}"),
            format!("rosrun and roslaunch need ROS 1: {}", advice(root)),
        ),
        None if root.join("usr/share/roslaunch/package.xml").is_file() => {
            Finding::good(CHECK, format!("Debian's own ROS, on {system}"))
        }
        None => Finding::unknown(
            CHECK,
            format!("no ROS is sourced, on {system}"),
            format!("rosrun and roslaunch need one: {}", advice(root)),
        ),
    }
}

/// The setup files to choose from.
fn advice(root: &Path) -> String {
    let entries = std::fs::read_dir(root.join("opt/ros")).into_iter().flatten().flatten();
    let mut setups: Vec<String> = entries
        .filter(|entry| entry.path().join("share/roslaunch/package.xml").is_file())
        .map(|entry| format!("source /opt/ros/{}/setup.bash", entry.file_name().to_string_lossy()))
        .collect();
    setups.sort();
    if setups.is_empty() {
        "none is installed".to_owned()
    } else {
        setups.join(" or ")
    }
}

/// Name and version of the operating system, and the processor's architecture.
fn system(root: &Path) -> String {
    let release = std::fs::read_to_string(root.join("etc/os-release")).unwrap_or_default();
    let name = release.lines().find_map(|line| line.strip_prefix("PRETTY_NAME=")).map(|name| name.trim_matches('"'));
    format!("{}, {}", name.unwrap_or("an unknown system"), std::env::consts::ARCH)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The line for an environment, below a root with ROS-O, Noetic and ROS 2, and Debian's own ROS if `has_debians`.
    fn line(environment: &[(&str, &str)], has_debians: bool) -> String {
        let root = tempfile::tempdir().unwrap();
        for place in ["opt/ros/one", "opt/ros/noetic"].into_iter().chain(has_debians.then_some("usr")) {
            let package = root.path().join(place).join("share/roslaunch");
            std::fs::create_dir_all(&package).unwrap();
            std::fs::write(package.join("package.xml"), "").unwrap();
        }
        std::fs::create_dir_all(root.path().join("opt/ros/jazzy")).unwrap();
        std::fs::create_dir(root.path().join("etc")).unwrap();
        std::fs::write(root.path().join("etc/os-release"), "NAME=\"Ubuntu\"\nPRETTY_NAME=\"Ubuntu 24.04 LTS\"\n")
            .unwrap();
        let value = |name: &str| environment.iter().find(|(key, _)| *key == name).map(|(_, value)| (*value).to_owned());
        of(value, root.path()).to_string()
    }

    #[test]
    fn the_distribution_is_named_or_what_to_source() {
        let system = format!("on Ubuntu 24.04 LTS, {}", std::env::consts::ARCH);
        let to_source = "source /opt/ros/noetic/setup.bash or source /opt/ros/one/setup.bash";
        let one = [("ROS_DISTRO", "one"), ("ROS_VERSION", "1")];
        assert_eq!(line(&one, true), format!("✓ distribution: one, {system}"));
        assert_eq!(line(&[], true), format!("✓ distribution: Debian's own ROS, {system}"));
        assert_eq!(
            line(&[("ROS_DISTRO", "jazzy"), ("ROS_VERSION", "2")], true),
            format!("? distribution: jazzy is ROS 2, {system}; rosrun and roslaunch need ROS 1: {to_source}")
        );
        assert_eq!(
            line(&[("ROS_DISTRO", "")], false),
            format!("? distribution: no ROS is sourced, {system}; rosrun and roslaunch need one: {to_source}")
        );
    }

    #[test]
    fn a_system_without_ros_and_without_a_name_is_said() {
        let printed = of(|_| None, tempfile::tempdir().unwrap().path()).to_string();
        assert!(printed.contains("no ROS is sourced, on an unknown system"), "{printed}");
        assert!(printed.ends_with("need one: none is installed"), "{printed}");
    }
}
