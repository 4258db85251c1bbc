//! `projection.launch`: the package's launch file with the arguments of this projection, and for two computers the
//! window's own.

use std::fmt::Write as _;

use crate::plan::{Limit, Plan, LIMIT_SECS};
use crate::profile::Profile;
use crate::scene_names::{IMAGE_TOPIC, LAUNCH_FILE, PROJECTOR_FILE, SCENE_FILE, WINDOW_LAUNCH_FILE};

/// Value of an argument that switches something off.
const NONE: &str = "none";

/// The text of `projection.launch`. Each argument can be given on the command line.
pub(crate) fn text(plan: &Plan) -> String {
    let answers = &plan.answers;
    let viewer = if answers.profile == Profile::TwoComputers { NONE } else { "projector_window" };
    let arguments = [
        ("rviz_config", plan.path(SCENE_FILE), "scene"),
        ("projector", plan.path(PROJECTOR_FILE), "the projector's CameraInfo and frames"),
        ("fixed_frame", answers.fixed_frame.clone(), "fixed frame"),
        ("viewer", viewer.to_owned(), "projector_window, window, image_view or none"),
        ("monitor", answers.monitor.clone(), "monitor for the viewer"),
        ("stale_timeout", stale_timeout(plan), "age in seconds from which data are hidden; none: no limit"),
        ("stale_timeouts", stale_timeouts(plan), "limits for single topics"),
        ("sample_scene", "false".to_owned(), "publish sample data"),
    ];
    let mut text = format!(
        "<?xml version=\"1.0\"?>\n<!--\n  Written by camera_stream setup, profile {}. Arguments of {} can be given on the \
         command line:\n\n    roslaunch {} viewer:=none\n-->\n<launch>\n",
        answers.profile.name(),
        answers.profile.launch_file(),
        plan.path(LAUNCH_FILE)
    );
    for (name, value, doc) in arguments {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "  <arg name=\"{name}\" default=\"{value}\" doc=\"{doc}\"/>");
    }
    let _ = writeln!(
        text,
        "  <include file=\"$(find rviz_camera_stream)/launch/{}\" pass_all_args=\"true\"/>\n</launch>",
        answers.profile.launch_file()
    );
    text
}

/// The limit of all topics without their own. A grid has no data that could keep the image lit.
fn stale_timeout(plan: &Plan) -> String {
    if plan.is_try {
        NONE.to_owned()
    } else {
        format!("{LIMIT_SECS}")
    }
}

/// The limits of topics that are not the general one, as a YAML list.
fn stale_timeouts(plan: &Plan) -> String {
    let entry = |topic: &str, limit: &str| format!("{{topic: {topic}, limit: {limit}}}");
    let own = plan.projected.iter().filter_map(|projected| match projected.limit {
        _ if plan.is_try => None,
        Limit::Held => Some(entry(&projected.topic, "held")),
        Limit::Secs(LIMIT_SECS) => None,
        Limit::Secs(secs) => Some(entry(&projected.topic, &secs.to_string())),
    });
    let own: Vec<String> = own.collect();
    if own.is_empty() {
        NONE.to_owned()
    } else {
        format!("[{}]", own.join(", "))
    }
}

/// The text of `projector_computer.launch`, for the computer that the projector is connected to.
pub(crate) fn window_text(plan: &Plan) -> String {
    format!(
        "<?xml version=\"1.0\"?>
<!--
  Written by camera_stream setup: the projector's window, for the computer that the projector is connected to.

    roslaunch {WINDOW_LAUNCH_FILE}
-->
<launch>
  <arg name=\"image_topic\" default=\"{IMAGE_TOPIC}\" doc=\"topic of the projector image\"/>
  <arg name=\"monitor\" default=\"{}\" doc=\"monitor, by name or index; auto: the last non-primary one\"/>
  <arg name=\"image_transport\" default=\"compressed\" doc=\"raw or compressed\"/>
  <arg name=\"stale_timeout\" default=\"{}\" doc=\"age in seconds from which the window is black; none: no limit\"/>
  <node pkg=\"rviz_camera_stream\" type=\"projector_window\" name=\"projector_window\" output=\"screen\">
    <param name=\"topic\" value=\"$(arg image_topic)\"/>
    <param name=\"monitor\" value=\"$(arg monitor)\"/>
    <param name=\"image_transport\" value=\"$(arg image_transport)\"/>
    <param name=\"stale_timeout\" value=\"$(arg stale_timeout)\"/>
  </node>
</launch>
",
        plan.answers.monitor,
        stale_timeout(plan)
    )
}
