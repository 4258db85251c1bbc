//! Displays of other packages: the package of a class, and what draws the same without its plugin.
//!
//! rviz loads such classes at run time; this program cannot. Messages for rviz's own displays that their packages
//! publish are listed in their documentation on wiki.ros.org.

use crate::one_line::one_line;

/// A family of classes.
struct Family {
    /// The part of their names before the slash, or the whole name of a class without one.
    prefix: &'static str,
    /// The package to install.
    package: &'static str,
    /// Messages and displays with the same content, or much of it; empty where none is known.
    instead: &'static str,
}

const FAMILIES: [Family; 13] = [
    Family {
        prefix: "Submaps",
        package: "cartographer_rviz",
        instead: "cartographer_occupancy_grid_node's map (rviz/Map)",
    },
    Family {
        prefix: "grid_map_rviz_plugin",
        package: "grid_map_rviz_plugin",
        instead:
            "the clouds, maps and grid cells that grid_map_visualization makes of it (rviz/PointCloud2, rviz/Map, \
                  rviz/GridCells)",
    },
    Family { prefix: "jsk_rviz_plugin", package: "jsk_rviz_plugins", instead: "" },
    Family { prefix: "jsk_rviz_plugins", package: "jsk_rviz_plugins", instead: "" },
    Family {
        prefix: "moveit_rviz_plugin",
        package: "moveit_ros_visualization",
        instead: "the robot as rviz/RobotModel, and the rest as the markers of moveit_visual_tools (rviz/MarkerArray)",
    },
    Family { prefix: "octomap_rviz_plugin", package: "octomap_rviz_plugins", instead: OCTOMAP },
    Family { prefix: "octomap_rviz_plugins", package: "octomap_rviz_plugins", instead: OCTOMAP },
    Family { prefix: "rtabmap_ros", package: "rtabmap_ros", instead: RTABMAP },
    Family { prefix: "rtabmap_rviz_plugins", package: "rtabmap_rviz_plugins", instead: RTABMAP },
    Family { prefix: "rviz_imu_plugin", package: "rviz_imu_plugin", instead: "" },
    Family { prefix: "rviz_plugin_tutorials", package: "rviz_plugin_tutorials", instead: "" },
    Family { prefix: "rviz_visual_tools", package: "rviz_visual_tools", instead: "its markers (rviz/MarkerArray)" },
    Family {
        prefix: "voxblox_rviz_plugin",
        package: "voxblox_rviz_plugin",
        instead: "voxblox's surface_pointcloud (rviz/PointCloud2) or occupied_nodes (rviz/MarkerArray)",
    },
];

const OCTOMAP: &str = "octomap_server's occupied_cells_vis_array (rviz/MarkerArray) or octomap_point_cloud_centers \
                       (rviz/PointCloud2)";
const RTABMAP: &str = "rtabmap's cloud_map (rviz/PointCloud2)";

/// One line, after the class's name: the plugin that a display of another package needs, and the two ways out.
pub(crate) fn needs(class: &str, topics: &[String]) -> String {
    let prefix = class.split('/').next().unwrap_or(class);
    let family = FAMILIES.iter().find(|family| family.prefix == prefix);
    let has_prefix = class.contains('/') && !prefix.is_empty();
    let needs = match (family, has_prefix) {
        (Some(family), _) => format!("a plugin of the package {}", family.package),
        (None, true) => format!("a plugin, probably of the package {}", one_line(prefix)),
        (None, false) => "a plugin of another package".to_owned(),
    };
    let topics = match topics {
        [] => String::new(),
        topics => format!(" (it shows {})", one_line(&topics.join(", "))),
    };
    let instead = match family.map(|family| family.instead) {
        None | Some("") => "what its publisher, or a small node, publishes of it as markers (rviz/MarkerArray)",
        Some(instead) => instead,
    };
    format!("needs {needs}{topics}: draw it in rviz with the CameraPub plugin, or show {instead} instead")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_classes_name_their_package_and_what_shows_the_same() {
        let scene = needs("moveit_rviz_plugin/PlanningScene", &["/monitored_planning_scene".to_owned()]);
        assert_eq!(
            scene,
            "needs a plugin of the package moveit_ros_visualization (it shows /monitored_planning_scene): draw it in rviz \
             with the CameraPub plugin, or show the robot as rviz/RobotModel, and the rest as the markers of \
             moveit_visual_tools (rviz/MarkerArray) instead"
        );
        for (class, package) in [
            ("jsk_rviz_plugin/BoundingBoxArray", "jsk_rviz_plugins "),
            ("octomap_rviz_plugin/OccupancyGrid", "octomap_rviz_plugins "),
            ("Submaps", "cartographer_rviz "),
        ] {
            let text = needs(class, &["/a".to_owned(), "/b".to_owned()]);
            assert!(text.starts_with(&format!("needs a plugin of the package {package}(it shows /a, /b)")), "{text}");
        }
    }

    #[test]
    fn unknown_classes_have_their_prefix_for_a_package() {
        let text = needs("my_plugins/Robots", &[]);
        assert!(text.starts_with("needs a plugin, probably of the package my_plugins: draw it in rviz"), "{text}");
        assert!(text.ends_with("publishes of it as markers (rviz/MarkerArray) instead"), "{text}");
        for class in ["Robots", "/Robots", "/"] {
            assert!(needs(class, &[]).starts_with("needs a plugin of another package: "), "{class}");
        }
    }

    #[test]
    fn families_are_sorted_and_none_is_of_rviz() {
        assert!(FAMILIES.is_sorted_by_key(|family| family.prefix));
        for class in crate::classes() {
            assert!(
                FAMILIES.iter().all(|family| class.name.split('/').next() != Some(family.prefix)),
                "{}",
                class.name
            );
        }
    }

    #[test]
    fn whatever_a_file_holds_it_is_one_line() {
        let text = needs("a\nb/c", &["/x\ny".to_owned()]);
        assert!(!text.contains('\n') && text.contains("a\\nb") && text.contains("/x\\ny"), "{text}");
    }
}
