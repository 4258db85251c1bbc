//! The profiles: what a projector is mounted on, and what follows from it.

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion};

/// Mount of the projector.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Profile {
    /// The torso of a Fetch, which has a depth camera in its head.
    Fetch,
    /// A stand or the ceiling, beside a table or an arm.
    Fixed,
    /// Any robot with a link for the projector.
    Mobile,
    /// A robot whose projector is a monitor of another computer.
    TwoComputers,
}

/// Topics that a profile projects: name and message type.
pub(crate) type ProfileTopics = &'static [(&'static str, &'static str)];

impl Profile {
    /// All profiles, as `--profile` takes them.
    pub(crate) const ALL: [Self; 4] = [Self::Fetch, Self::Fixed, Self::Mobile, Self::TwoComputers];

    /// The name on the command line.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Fetch => "fetch",
            Self::Fixed => "fixed",
            Self::Mobile => "mobile",
            Self::TwoComputers => "two-computers",
        }
    }

    /// The profile with a name.
    ///
    /// # Errors
    /// The known names.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let names = Self::ALL.map(Self::name).join(", ");
        Self::ALL
            .into_iter()
            .find(|profile| profile.name() == text)
            .ok_or_else(|| format!("'{text}' is not one of {names}"))
    }

    /// Link that the projector is mounted on, where the profile knows it.
    pub(crate) const fn mount(self) -> Option<&'static str> {
        match self {
            Self::Fetch => Some("torso_lift_link"),
            Self::Fixed | Self::Mobile | Self::TwoComputers => None,
        }
    }

    /// Fixed frame, where the profile knows it.
    pub(crate) const fn fixed_frame(self) -> Option<&'static str> {
        match self {
            Self::Fetch => Some("base_link"),
            Self::Fixed | Self::Mobile | Self::TwoComputers => None,
        }
    }

    /// Colour and depth images of the depth camera, where the profile knows them.
    pub(crate) const fn camera(self) -> Option<[&'static str; 2]> {
        match self {
            Self::Fetch => Some(["/head_camera/rgb/image_raw", "/head_camera/depth_registered/image_raw"]),
            Self::Fixed | Self::Mobile | Self::TwoComputers => None,
        }
    }

    /// Topics to project, where the profile knows them: those of `fetch.launch`.
    pub(crate) const fn topics(self) -> ProfileTopics {
        match self {
            Self::Fetch => &[
                ("/widget/clusters", "sensor_msgs/PointCloud2"),
                ("/widget/desired_object", "sensor_msgs/PointCloud2"),
                ("/move_base/NavfnROS/plan", "nav_msgs/Path"),
                ("/move_base/TrajectoryPlannerROS/global_plan", "nav_msgs/Path"),
                ("/visualization_marker_array", "visualization_msgs/MarkerArray"),
            ],
            Self::Fixed | Self::Mobile | Self::TwoComputers => &[],
        }
    }

    /// Launch file of the package that the profile includes.
    pub(crate) const fn launch_file(self) -> &'static str {
        match self {
            Self::Fetch => "fetch.launch",
            Self::Fixed | Self::Mobile | Self::TwoComputers => "projection.launch",
        }
    }

    /// A first guess of the lens's pose in the mount, as an optical frame (z along the light, x right, y down).
    pub(crate) fn mount_from_lens(self) -> Isometry3<f64> {
        match self {
            Self::Fetch => fetch_mount_from_lens(),
            // Straight down, with the mount's x upwards in the image.
            Self::Fixed => pose(1.5, [[0.0, -1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]),
            Self::Mobile | Self::TwoComputers => {
                let half = std::f64::consts::FRAC_1_SQRT_2;
                // Forward, and down by 45°.
                pose(1.0, [[0.0, -1.0, 0.0], [-half, 0.0, -half], [half, 0.0, -half]])
            }
        }
    }

    /// The guess in words.
    pub(crate) const fn pose_text(self) -> &'static str {
        match self {
            Self::Fetch => "above the torso, tilted down towards a table within reach",
            Self::Fixed => "1.5 m above the mount, straight down, the mount's x axis upwards in the image",
            Self::Mobile | Self::TwoComputers => "1 m above the mount, forward and down by 45 degrees",
        }
    }
}

/// A pose above the mount with the lens's axes x, y and z in the mount.
fn pose(height_m: f64, [x, y, z]: [[f64; 3]; 3]) -> Isometry3<f64> {
    let axes = Matrix3::from_columns(&[x.into(), y.into(), z.into()]);
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    Isometry3::from_parts(Translation3::new(0.0, 0.0, height_m), rotation)
}

/// The pose of `config/fetch_projector.yaml`.
fn fetch_mount_from_lens() -> Isometry3<f64> {
    use std::f64::consts::FRAC_PI_2;
    let base =
        Isometry3::from_parts(Translation3::new(0.10, 0.0, 0.75), UnitQuaternion::from_euler_angles(0.0, 0.77, 0.0));
    let lens = UnitQuaternion::from_euler_angles(-FRAC_PI_2, 0.0, -FRAC_PI_2);
    base * Isometry3::from_parts(Translation3::new(0.11, 0.06, 0.05), lens)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use nalgebra::{Point3, Vector3};
    use rcs_files::projector::ProjectorFile;

    use super::*;

    #[test]
    fn a_profile_is_found_by_its_name() {
        for profile in Profile::ALL {
            assert_eq!(Profile::parse(profile.name()), Ok(profile));
        }
        assert_eq!(Profile::parse("pr2"), Err("'pr2' is not one of fetch, fixed, mobile, two-computers".to_owned()));
    }

    #[test]
    fn the_guessed_poses_look_where_they_say() {
        let fixed = Profile::Fixed.mount_from_lens();
        assert!((fixed * Point3::new(0.0, 0.0, 1.5)).coords.norm() < 1e-9, "the light meets the mount's origin");
        assert!((fixed * Vector3::new(0.0, -1.0, 0.0) - Vector3::x()).norm() < 1e-9, "up is x");
        let mobile = Profile::Mobile.mount_from_lens();
        let floor = mobile * Point3::new(0.0, 0.0, 2f64.sqrt());
        assert!((floor - Point3::new(1.0, 0.0, 0.0)).norm() < 1e-9, "{floor}");
        assert!((mobile * Vector3::x() + Vector3::y()).norm() < 1e-9, "right is -y");
    }

    #[test]
    fn the_pose_of_a_fetch_is_that_of_its_file() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/fetch_projector.yaml");
        let file = ProjectorFile::read(&file).unwrap();
        assert_eq!(Profile::Fetch.mount(), Some(&*file.frames[0].parent));
        let poses = file.frames.iter().map(|frame| Isometry3::from_parts(frame.translation_m.into(), frame.rotation));
        let pose = poses.fold(Isometry3::identity(), |pose, next| pose * next);
        let error = pose.inverse() * Profile::Fetch.mount_from_lens();
        assert!(error.translation.vector.norm() + error.rotation.angle() < 1e-6, "{error}");
    }
}
