//! `scene.rviz`: the CameraPub and a display for each topic, for the node and for rviz.

use std::fmt::Write as _;

use rcs_rviz_config::NewCamera;

use crate::display_type::color;
use crate::plan::{Plan, Projected};
use crate::scene_names::{CAMERA_INFO_TOPIC, IMAGE_TOPIC, LENS_FRAME, NAMESPACE};

/// Indentation of displays in a file that rviz saves.
const INDENTATION: usize = 4;

/// Near Clip Distance, metres.
const NEAR_CLIP_M: f32 = 0.01;
/// Near Clip Distance where frames have names and axes, metres: those of links beside the lens would cover the image.
const TRY_NEAR_CLIP_M: f32 = 0.5;

const HEAD: &str = "\
Panels:
  - Class: rviz/Displays
    Name: Displays
  - Class: rviz/Views
    Name: Views
Visualization Manager:
  Class: \"\"
  Displays:
";
const TOOLS_AND_VIEW: &str = "  Name: root
  Tools:
    - Class: rviz/Interact
      Hide Inactive Objects: true
    - Class: rviz/MoveCamera
    - Class: rviz/Select
    - Class: rviz/FocusCamera
    - Class: rviz/Measure
  Value: true
  Views:
    Current:
      Class: rviz/Orbit
      Distance: 4
      Focal Point:
        X: 0.5
        Y: 0
        Z: 0.5
      Name: Current View
      Near Clip Distance: 0.01
      Pitch: 0.6
      Target Frame: <Fixed Frame>
      Value: Orbit (rviz)
      Yaw: 3.9
    Saved: ~
Window Geometry:
  Height: 900
  Width: 1400
  X: 60
  Y: 30
";

/// The file's text.
pub(crate) fn text(plan: &Plan) -> String {
    let mut text = HEAD.to_owned() + &grid(plan.is_try) + &frame_names(plan.is_try);
    for (index, projected) in plan.projected.iter().enumerate() {
        text += &display(projected, color(index));
    }
    text += &camera(plan);
    // Writing to a String cannot fail.
    let _ = write!(
        text,
        "  Enabled: true\n  Global Options:\n    Background Color: 48; 48; 48\n    Default Light: true\n    \
         Fixed Frame: \"{}\"\n    Frame Rate: 30\n{TOOLS_AND_VIEW}",
        plan.answers.fixed_frame
    );
    text
}

/// The floor of the fixed frame: cells of 10 cm in the light, else one for rviz's own view.
fn grid(is_projected: bool) -> String {
    let (cell_m, count, style, color, alpha) = if is_projected {
        (0.1, 100, "Billboards", "0; 160; 255", 1.0)
    } else {
        (0.5, 10, "Lines", "160; 160; 164", 0.5)
    };
    format!(
        "    - Alpha: {alpha}
      Cell Size: {cell_m}
      Class: rviz/Grid
      Color: {color}
      Enabled: true
      Line Style:
        Line Width: 0.004
        Value: {style}
      Name: Grid
      Normal Cell Count: 0
      Offset:
        X: 0
        Y: 0
        Z: 0
      Plane: XY
      Plane Cell Count: {count}
      Reference Frame: <Fixed Frame>
      Value: true
"
    )
}

/// The frames of TF with their names, without the lens's, which is in the lens.
fn frame_names(is_projected: bool) -> String {
    format!(
        "    - Class: rviz/TF
      Enabled: {is_projected}
      Frame Timeout: 15
      Frames:
        All Enabled: true
        {LENS_FRAME}:
          Value: false
      Marker Scale: 0.5
      Name: TF
      Show Arrows: false
      Show Axes: true
      Show Names: true
      Tree:
        {{}}
      Update Interval: 0
      Value: {is_projected}
"
    )
}

/// Name of a topic's display.
fn display_name(topic: &str) -> &str {
    topic.trim_start_matches('/')
}

fn display(Projected { topic, display, .. }: &Projected, color: &str) -> String {
    let mut text = format!(
        "    - Class: {}\n      Enabled: true\n      Name: \"{}\"\n      {}: {topic}\n",
        display.class,
        display_name(topic),
        display.topic_key
    );
    for property in display.properties {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "      {}", property.replace("COLOR", color));
    }
    text + "      Value: true\n"
}

/// The CameraPub, whose Visibility comes last in the block.
fn camera(plan: &Plan) -> String {
    let camera = NewCamera {
        name: "CameraPub".to_owned(),
        camera_info_topic: CAMERA_INFO_TOPIC.to_owned(),
        image_topic: IMAGE_TOPIC.to_owned(),
        display_namespace: NAMESPACE.to_owned(),
        near_clip_m: if plan.is_try { TRY_NEAR_CLIP_M } else { NEAR_CLIP_M },
    };
    let mut text = camera.block(INDENTATION, "\n");
    let mut show = |name: &str, is_shown: bool| {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "        \"{name}\": {is_shown}");
    };
    show("Grid", plan.is_try);
    show("TF", plan.is_try);
    plan.projected.iter().for_each(|projected| show(display_name(&projected.topic), true));
    text + "      Value: true\n"
}
