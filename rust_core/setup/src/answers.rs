//! The answers: from flags, else from the terminal, else from what was found. Without a terminal, everything that is
//! missing is one error.

use anyhow::anyhow;
use rcs_files::projector::TABLE_FRAME;
use rcs_files::sizes::size_px;
use rcs_node_support::dialog::{Dialog, DialogError};
use rcs_node_support::near::near;

use crate::arguments::{self, SetupArgs, Show, NONE};
use crate::display_type::{self, short_name, DisplayType};
use crate::error::SetupError;
use crate::found::Found;
use crate::profile::Profile;

/// The answer that is no topic but a grid to begin with.
const GRID: &str = "grid";
/// Frames that a question lists.
const MAX_LISTED: usize = 60;

const PROFILES: &str = "\
What is the projector mounted on?
  fetch          the torso of a Fetch
  fixed          a stand or the ceiling, beside a table or an arm
  mobile         another robot
  two-computers  a robot, with the projector's monitor at another computer";

/// All answers, each valid by itself.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Answers {
    pub(crate) profile: Profile,
    pub(crate) mount: String,
    pub(crate) fixed_frame: String,
    pub(crate) monitor: String,
    pub(crate) size_px: [u32; 2],
    /// Colour image of the depth camera, if there is one.
    pub(crate) image: Option<String>,
    /// Depth image of the depth camera, if there is one.
    pub(crate) depth: Option<String>,
    /// Topics to project with their displays.
    pub(crate) topics: Vec<(String, &'static DisplayType)>,
}

/// A question and the flag that answers it.
struct Question<'q> {
    /// Flag with the form of its value.
    flag: &'q str,
    /// Shown on the terminal, before the default.
    text: String,
    /// Shown for the answer `?`.
    help: &'static str,
    /// Answer that an empty line means.
    default: Option<String>,
}

/// Takes each answer from a flag, the terminal or what was found.
struct Interview<'a, 'd> {
    dialog: Option<&'a mut Dialog<'d>>,
    /// Flags without an answer.
    missing: Vec<String>,
}

impl Interview<'_, '_> {
    /// The answer to a question; `None` if it is missing.
    fn settle<A>(
        &mut self,
        given: Option<A>,
        question: &Question<'_>,
        read: impl Fn(&str) -> Result<A, String>,
    ) -> Result<Option<A>, DialogError> {
        if given.is_some() {
            return Ok(given);
        }
        let default = question.default.as_deref();
        if let Some(dialog) = &mut self.dialog {
            let offered = default.map(|default| format!(" [{default}]")).unwrap_or_default();
            let answer = dialog.answer(&format!("{}{offered}: ", question.text), |text| match (text, default) {
                ("?", _) => Err(question.help.to_owned()),
                ("", None) => Err("an answer is needed; ? explains".to_owned()),
                ("", Some(default)) => read(default),
                (text, _) => read(text),
            });
            return answer.map(Some);
        }
        let answer = default.and_then(|default| read(default).ok());
        if answer.is_none() {
            self.missing.push(question.flag.to_owned());
        }
        Ok(answer)
    }

    fn say(&mut self, text: &str) -> Result<(), DialogError> {
        self.dialog.as_mut().map_or(Ok(()), |dialog| dialog.say(text))
    }
}

/// All answers.
///
/// # Errors
/// [`SetupError::Invalid`] with everything that is missing or invalid; [`SetupError::Refused`] if the user ends the
/// questions.
pub(crate) fn complete(
    args: &SetupArgs,
    found: &Found,
    dialog: Option<&mut Dialog<'_>>,
) -> Result<Answers, SetupError> {
    let mut interview = Interview { dialog, missing: Vec::new() };
    interview.say("Enter takes what stands in brackets, ? explains a question, Ctrl-C ends without writing.")?;
    let chosen = profile(&mut interview, args)?;
    // Without a profile, only what every profile needs is asked for beside it.
    let profile = chosen.unwrap_or(Profile::Fixed);
    let [mount, fixed_frame] = frames(&mut interview, args, found, profile)?;
    let (monitor, size_px) = monitor(&mut interview, args, found, profile)?;
    let [image, depth] = camera(&mut interview, args, found, profile)?;
    let topics = topics(&mut interview, args, found, profile)?;
    let missing = interview.missing.join(", ");
    let answers = (|| {
        let is_camera = |topic: &String| topic != NONE;
        Some(Answers {
            profile: chosen?,
            mount: mount?,
            fixed_frame: fixed_frame?,
            monitor: monitor?,
            size_px: size_px?,
            image: image.filter(is_camera),
            depth: depth.filter(is_camera),
            topics: topics?,
        })
    })();
    answers.filter(|_| missing.is_empty()).ok_or_else(|| {
        SetupError::Invalid(anyhow!("answers missing: {missing}; give these options, or run the command on a terminal"))
    })
}

/// Mount of the projector.
fn profile(interview: &mut Interview<'_, '_>, args: &SetupArgs) -> Result<Option<Profile>, DialogError> {
    if args.profile.is_none() {
        interview.say(PROFILES)?;
    }
    let flag = "--profile fetch|fixed|mobile|two-computers";
    let help = "what the projector is fixed to decides which frames and topics are offered; fixed is a camera and a projector \
                without a robot, too";
    let question = Question { flag, text: "Profile".to_owned(), help, default: None };
    interview.settle(args.profile, &question, Profile::parse)
}

/// Mount and fixed frame.
fn frames(
    interview: &mut Interview<'_, '_>,
    args: &SetupArgs,
    found: &Found,
    profile: Profile,
) -> Result<[Option<String>; 2], DialogError> {
    let known = found.frame_names();
    if !known.is_empty() && (args.mount.is_none() || args.fixed_frame.is_none()) {
        let names: Vec<&str> = known.iter().copied().take(MAX_LISTED).collect();
        let more = if known.len() > names.len() { ", …" } else { "" };
        interview.say(&format!("Frames: {}{more}", names.join(", ")))?;
    }
    let of_fixed = || found.first_frame(&["map", "base_link"]).unwrap_or_else(|| "map".to_owned());
    let mount = Question {
        flag: "--mount FRAME",
        text: "Link that the projector is mounted on".to_owned(),
        help: "the frame that does not move relative to the projector: a link of the robot, or the room's frame; \
               calibration places the projector in it",
        default: (profile.mount().map(str::to_owned))
            .or_else(|| found.mount.clone())
            .or_else(|| (profile == Profile::Fixed).then(of_fixed)),
    };
    let mount = interview.settle(args.mount.clone(), &mount, arguments::frame)?;
    let of_scene = || match profile {
        Profile::Fixed => found.first_frame(&[TABLE_FRAME]).or_else(|| mount.clone()),
        _ => Some(found.first_frame(&["map", "odom"]).unwrap_or_else(|| "base_link".to_owned())),
    };
    let fixed_frame = Question {
        flag: "--fixed-frame FRAME",
        text: "Fixed frame of the scene".to_owned(),
        help: "the frame in which the scene is drawn, rviz's Fixed Frame: one in which the things that are lit stand still",
        default: profile.fixed_frame().map(str::to_owned).or_else(of_scene),
    };
    let fixed_frame = interview.settle(args.fixed_frame.clone(), &fixed_frame, arguments::frame)?;
    Ok([mount, fixed_frame])
}

/// Monitor and resolution of the projector.
fn monitor(
    interview: &mut Interview<'_, '_>,
    args: &SetupArgs,
    found: &Found,
    profile: Profile,
) -> Result<(Option<String>, Option<[u32; 2]>), DialogError> {
    // This computer's monitors are not those of the projector's computer.
    let is_here = profile != Profile::TwoComputers;
    if is_here && args.monitor.is_none() {
        for monitor in &found.monitors {
            interview.say(&format!("Monitor {monitor}"))?;
        }
    }
    let last = found.monitors.iter().rfind(|monitor| !monitor.is_primary && !monitor.is_virtual);
    let last = last.filter(|monitor| is_here && arguments::monitor(&monitor.name).is_ok());
    let name = Question {
        flag: "--monitor NAME",
        text: "Monitor that the projector is".to_owned(),
        help: "the output that the projector is connected to (xrandr lists them); auto is the last that is not primary",
        default: Some(last.map_or("auto".to_owned(), |monitor| monitor.name.clone())),
    };
    let name = interview.settle(args.monitor.clone(), &name, arguments::monitor)?;
    let of_monitor = name.as_deref().filter(|_| is_here).and_then(|name| found.monitor(name));
    let size = Question {
        flag: "--size WxH",
        text: "Native resolution of the projector, pixels".to_owned(),
        help: "WIDTHxHEIGHT by the projector's data sheet; in another one the projector scales, and no pixel fits",
        default: of_monitor.map(|monitor| format!("{}x{}", monitor.size_px.0, monitor.size_px.1)),
    };
    let size = interview.settle(args.size, &size, size_px)?;
    Ok((name, size))
}

/// Colour and depth image of the camera that calibrates.
fn camera(
    interview: &mut Interview<'_, '_>,
    args: &SetupArgs,
    found: &Found,
    profile: Profile,
) -> Result<[Option<String>; 2], DialogError> {
    let guessed = profile.camera().map_or_else(|| found.camera_images(), |topics| topics.map(Some));
    let [image, depth] = guessed.map(|topic| topic.map(str::to_owned));
    // A first image without perception needs no camera. On a terminal, where no camera runs yet, none is offered.
    let is_asked = interview.dialog.is_some();
    let without = || (args.is_try || is_asked).then(|| NONE.to_owned());
    let question = Question {
        flag: "--image TOPIC|none",
        text: "Colour image of the depth camera that calibrates, or none".to_owned(),
        help: "the topic of its images (sensor_msgs/Image) for projector_calibrate scan; none: calibrate later, or by hand",
        default: image.or_else(without),
    };
    let image = interview.settle(args.image.clone(), &question, arguments::image)?;
    if image.as_deref() == Some(NONE) && args.depth.is_none() {
        return Ok([image, Some(NONE.to_owned())]);
    }
    let question = Question {
        flag: "--depth TOPIC|none",
        text: "Depth image that is registered to it".to_owned(),
        help:
            "a depth image with the same pixels as the colour image (depth_registered, aligned_depth_to_color), or none",
        default: depth.or_else(without),
    };
    let depth = interview.settle(args.depth.clone(), &question, arguments::image)?;
    Ok([image, depth])
}

/// Topics to project.
fn topics(
    interview: &mut Interview<'_, '_>,
    args: &SetupArgs,
    found: &Found,
    profile: Profile,
) -> Result<Option<Vec<(String, &'static DisplayType)>>, SetupError> {
    if !args.show.is_empty() {
        return resolve_all(&args.show, found)
            .map(Some)
            .map_err(|reason| SetupError::Invalid(anyhow!("--show: {reason}")));
    }
    if args.is_try {
        return Ok(Some(Vec::new()));
    }
    if found.displayable().next().is_some() {
        interview.say("Topics that can be projected:")?;
    }
    for (topic, display) in found.displayable() {
        interview.say(&format!("  {topic}  {}", short_name(display)))?;
    }
    let of_profile = profile.topics().iter().map(|(topic, ros_type)| format!("{topic}={ros_type}"));
    let results = found.displayable().filter(|(topic, display)| display.is_result && !found.is_of_sensor(topic));
    let offered: Vec<String> = match profile.topics() {
        [] => results.map(|(topic, _)| topic.to_owned()).collect(),
        _ => of_profile.collect(),
    };
    let is_asked = interview.dialog.is_some();
    let question = Question {
        flag: "--show TOPIC[=TYPE] or --try",
        text: "Topics to project, with spaces between, or grid".to_owned(),
        help: "TOPIC, or TOPIC=TYPE where nobody publishes it yet, such as /objects=PointCloud2; grid: a grid and the names \
               of the frames to begin with, topics follow in rviz",
        default: match offered.as_slice() {
            [] => is_asked.then(|| GRID.to_owned()),
            offered => Some(offered.join(" ")),
        },
    };
    let read = |text: &str| {
        if text == GRID {
            return Ok(Vec::new());
        }
        let shown: Result<Vec<Show>, String> = text.split_whitespace().map(arguments::show).collect();
        resolve_all(&shown?, found)
    };
    Ok(interview.settle(None, &question, read)?)
}

/// The topics with their displays.
fn resolve_all(shown: &[Show], found: &Found) -> Result<Vec<(String, &'static DisplayType)>, String> {
    let mut resolved: Vec<(String, &'static DisplayType)> = Vec::new();
    let mut problems = Vec::new();
    for show in shown {
        match resolve(show, found) {
            Ok(_) if resolved.iter().any(|(topic, _)| *topic == show.topic) => {}
            Ok(display) => resolved.push((show.topic.clone(), display)),
            Err(problem) => problems.push(problem),
        }
    }
    if problems.is_empty() {
        Ok(resolved)
    } else {
        Err(problems.join("; "))
    }
}

/// The display of a topic: by the type that is given, else by the master's.
fn resolve(show: &Show, found: &Found) -> Result<&'static DisplayType, String> {
    let topic = &show.topic;
    if let Some(display) = show.display {
        return Ok(display);
    }
    if let Some(ros_type) = found.topics.get(topic) {
        return display_type::find(ros_type).map_err(|reason| format!("{topic}: {reason}"));
    }
    let near = near(topic, found.displayable().map(|(topic, _)| topic)).join(", ");
    let hint = if near.is_empty() { String::new() } else { format!("; published: {near}") };
    Err(format!("{topic} is published by nobody, so its type is unknown{hint}; write {topic}=TYPE"))
}

/// Warnings about answers that do not fit what was found.
pub(crate) fn warnings(answers: &Answers, found: &Found) -> Vec<String> {
    let known = found.frame_names();
    let frame = |option: &str, name: &str| {
        let near = near(name, known.iter().copied()).join(", ");
        let hint = if near.is_empty() { String::new() } else { format!(" (did you mean {near}?)") };
        let is_missing = !known.is_empty() && !known.contains(name);
        is_missing.then(|| {
            format!("{option} {name}: neither TF nor the robot's description has this frame{hint}; check it before projecting")
        })
    };
    let frames = [frame("--mount", &answers.mount), frame("--fixed-frame", &answers.fixed_frame)];
    // A camera that does not run yet is no fault.
    let camera = |option: &str, topic: Option<&String>| {
        let topic = topic.filter(|topic| !found.topics.contains_key(*topic))?;
        let images = found.topics.iter().filter(|(_, ros_type)| *ros_type == "sensor_msgs/Image");
        let near = near(topic, images.map(|(name, _)| name.as_str()));
        near.first().map(|near| format!("{option} {topic}: nobody publishes it (did you mean {near}?)"))
    };
    let cameras = [camera("--image", answers.image.as_ref()), camera("--depth", answers.depth.as_ref())];
    let unchecked = match (found.has_master, known.is_empty()) {
        (false, _) => Some("no ROS master answers: frames, topics and rates are not checked".to_owned()),
        (true, true) => Some("nothing publishes TF or a robot's description: frames are not checked".to_owned()),
        (true, false) => None,
    };
    let unknown = frames.into_iter().chain(cameras).flatten();
    unchecked.into_iter().chain(unknown).chain(monitor_warning(answers, found)).collect()
}

/// A monitor that is not there, has another size, or cannot be checked.
fn monitor_warning(answers: &Answers, found: &Found) -> Option<String> {
    let Answers { monitor: name, size_px: [width, height], .. } = answers;
    if answers.profile == Profile::TwoComputers {
        return None;
    }
    if found.monitors.is_empty() {
        return Some("no display is open: the monitor and its size are not checked".to_owned());
    }
    let Some(monitor) = found.monitor(name) else {
        let names = rcs_window::list_lines(&found.monitors).join(", ");
        return Some(format!("--monitor {name}: not connected; monitors: {names}"));
    };
    (monitor.size_px != (*width, *height)).then(|| {
        format!("--size {width}x{height}: monitor {monitor} has another size; set its native mode, or correct --size")
    })
}
