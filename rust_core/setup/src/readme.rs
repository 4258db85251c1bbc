//! `README.md`: the next commands, to be pasted.

use std::fmt::Write as _;

use rcs_ros::image_topic::camera_info_topic;

use crate::answers::Answers;
use crate::plan::Plan;
use crate::profile::Profile;
use crate::scene_names::{LAUNCH_FILE, PROJECTOR_FILE, WINDOW_LAUNCH_FILE};

/// Topic on which patterns are shown at another computer.
const PATTERNS_TOPIC: &str = "/projector/patterns";

/// A command that starts a program of the package.
const ROSRUN: &str = "rosrun rviz_camera_stream";

/// The command that starts the projection.
pub(crate) fn launch_command(plan: &Plan) -> String {
    format!("roslaunch {}", plan.path(LAUNCH_FILE))
}

/// The command that checks the projection.
pub(crate) fn doctor_command(plan: &Plan) -> String {
    format!("{ROSRUN} camera_stream doctor {}", plan.folder.display())
}

/// The commands that calibrate the projector.
pub(crate) fn calibrate_commands(plan: &Plan) -> Vec<String> {
    let Answers { size_px: [width, height], image, depth, mount, monitor, profile, .. } = &plan.answers;
    // A fixed camera may be in no tree of frames: the capture alone places the projector in its frame.
    let placing = match profile {
        Profile::Fixed => "--in-camera-frame --table".to_owned(),
        _ => format!("--parent {mount}"),
    };
    let (Some(image), Some(depth)) = (image, depth) else {
        return vec![format!("{ROSRUN} projector_calibrate manual -o {}", plan.path("lens.yaml"))];
    };
    let (camera_info, capture) = (camera_info_topic(image), plan.path("capture"));
    let screen = match profile {
        Profile::TwoComputers => format!("--show-on {PATTERNS_TOPIC}"),
        _ => format!("--monitor {monitor}"),
    };
    vec![
        format!(
            "{ROSRUN} projector_calibrate scan --size {width}x{height} {screen} --image {image} \
             --camera-info {camera_info} --depth {depth} -o {capture}"
        ),
        format!(
            "{ROSRUN} projector_calibrate solve {capture} --size {width}x{height} {placing} -o {}",
            plan.path(PROJECTOR_FILE)
        ),
    ]
}

/// The file's text.
pub(crate) fn text(plan: &Plan) -> String {
    let is_apart = plan.answers.profile == Profile::TwoComputers;
    let mut text = String::from("# Projection\n\nWritten by `camera_stream setup`.\n");
    // Writing to a String cannot fail.
    let mut step = |what: &str, commands: &[String]| {
        let commands: String = commands.iter().map(|command| format!("    {command}\n")).collect();
        let _ = write!(text, "\n{what}\n\n{commands}");
    };
    step(&format!("## 1. Start the projection\n\n{}", what_appears(plan)), &[launch_command(plan)]);
    if is_apart {
        let window = ["export ROS_MASTER_URI=http://ROBOT:11311", "export ROS_IP=ADDRESS"].map(str::to_owned);
        let what = format!(
            "On the projector's computer, with a copy of `{WINDOW_LAUNCH_FILE}`. ROBOT is the robot's host name, ADDRESS \
             this computer's address in the robot's network. Set `ROS_IP` on the robot to the robot's address."
        );
        step(&what, &[&window[..], &[format!("roslaunch {WINDOW_LAUNCH_FILE}")]].concat());
    }
    step(&format!("## 2. Calibrate\n\n{}", how_to_calibrate(plan)), &calibrate_commands(plan));
    if is_apart {
        let window = format!("{ROSRUN} projector_window --topic {PATTERNS_TOPIC}");
        step("During the scan, show the patterns on the projector's computer:", &[window]);
    }
    step("## 3. Check the whole chain\n\nWith the projection running:", &[doctor_command(plan)]);
    text + &after_try(plan)
}

fn what_appears(plan: &Plan) -> &'static str {
    if plan.is_try {
        "A grid with cells of 10 cm on the fixed frame's floor and the names of the frames appear."
    } else {
        "The image is black until one of the projected topics has data."
    }
}

fn how_to_calibrate(plan: &Plan) -> String {
    let Answers { image, depth, mount, profile, .. } = &plan.answers;
    if image.is_some() && depth.is_some() {
        let frame = match profile {
            Profile::Fixed => {
                " The lens is placed in the camera's frame: if TF does not have that frame, add `fixed_frame:=` and its \
                 name to the command that starts the projection."
            }
            _ => "",
        };
        format!("End the projection first: the patterns need the monitor.{frame}")
    } else {
        format!(
            "Without a depth camera, measure with a tape. Copy K and P of `lens.yaml` into `{PROJECTOR_FILE}`, and the \
             measured pose of the lens in {mount} into its `frames`."
        )
    }
}

/// How to go on after `--try`.
fn after_try(plan: &Plan) -> String {
    if !plan.is_try {
        return String::new();
    }
    format!(
        "\n## Then\n\nTo project your own topics, run the setup again without `--try`:\n\n    {ROSRUN} camera_stream setup {} --overwrite \
         --profile {} --mount {} --fixed-frame {} --show TOPIC\n",
        plan.folder.display(),
        plan.answers.profile.name(),
        plan.answers.mount,
        plan.answers.fixed_frame
    )
}
