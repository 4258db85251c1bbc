//! Questions, errors and the written files, without ROS.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::{Args as _, Command, FromArgMatches as _};
use nalgebra::Isometry3;
use rcs_files::projector::{ProjectorFile, StaticFrame};
use rcs_node_support::dialog::Dialog;
use rcs_rviz_config::{camera_problems, setting_problems, DisplaySettings};

use super::*;
use crate::display_type::DISPLAY_TYPES;
use crate::found::tests::robot;
use crate::scene_names::{LAUNCH_FILE, PROJECTOR_FILE, README_FILE, SCENE_FILE, WINDOW_LAUNCH_FILE};

fn args(words: &[&str]) -> SetupArgs {
    let command = SetupArgs::augment_args(Command::new("setup").no_binary_name(true));
    SetupArgs::from_arg_matches(&command.try_get_matches_from([&["/tmp/first"], words].concat()).unwrap()).unwrap()
}

/// The answers without a terminal.
fn answers(words: &[&str], found: &Found) -> Result<Answers, String> {
    answers::complete(&args(words), found, None).map_err(|error| error.to_string())
}

/// The answers with these lines typed on a terminal, and what it shows.
fn asked(words: &[&str], found: &Found, lines: &[&str]) -> (Result<Answers, SetupError>, String) {
    let (input, mut shown) = (lines.join("\n") + "\n", Vec::new());
    let mut input = input.as_bytes();
    let result = answers::complete(&args(words), found, Some(&mut Dialog::new(&mut input, &mut shown)));
    (result, String::from_utf8(shown).unwrap())
}

/// The files of a plan by their names.
fn files(words: &[&str], found: &Found, rates: &BTreeMap<String, Rate>) -> BTreeMap<&'static str, String> {
    let args = args(words);
    let answers = answers::complete(&args, found, None).unwrap();
    let plan = Plan::new(PathBuf::from("/tmp/first"), answers, rates, args.is_try);
    folder::files(&plan).unwrap().into_iter().collect()
}

/// The arguments of a launch file and the file that it includes.
fn launch_arguments(text: &str) -> (BTreeMap<String, String>, String) {
    let document = roxmltree::Document::parse(text).unwrap();
    let of = |node: &roxmltree::Node<'_, '_>, name: &str| node.attribute(name).unwrap().to_owned();
    let arguments = document.descendants().filter(|node| node.has_tag_name("arg"));
    let arguments = arguments.map(|node| (of(&node, "name"), of(&node, "default"))).collect();
    let include = document.descendants().find(|node| node.has_tag_name("include")).unwrap();
    assert_eq!(include.attribute("pass_all_args"), Some("true"));
    (arguments, of(&include, "file"))
}

const FIXED: [&str; 8] = ["--profile", "fixed", "--size", "1920x1080", "--image", "none", "--show", "/a=PointCloud2"];

#[test]
fn a_fetch_needs_only_its_size() {
    let answers = answers(&["--profile", "fetch", "--size", "1280x800"], &Found::default()).unwrap();
    assert_eq!((&*answers.mount, &*answers.fixed_frame, &*answers.monitor), ("torso_lift_link", "base_link", "auto"));
    assert_eq!(answers.depth.as_deref(), Some("/head_camera/depth_registered/image_raw"));
    let classes: Vec<_> = answers.topics.iter().map(|(_, display)| display.class).collect();
    assert_eq!(classes, ["rviz/PointCloud2", "rviz/PointCloud2", "rviz/Path", "rviz/Path", "rviz/MarkerArray"]);
}

#[test]
fn all_that_is_missing_is_one_error() {
    let error = answers(&["--profile", "mobile"], &Found::default()).unwrap_err();
    let expected =
        "answers missing: --mount FRAME, --size WxH, --image TOPIC|none, --depth TOPIC|none, --show TOPIC[=TYPE] \
                    or --try; give these options, or run the command on a terminal";
    assert_eq!(error, expected);
    let error = answers(&["--try"], &Found::default()).unwrap_err();
    assert!(error.starts_with("answers missing: --profile fetch|fixed|mobile|two-computers, --size WxH;"), "{error}");
}

#[test]
fn without_a_terminal_what_is_found_is_taken() {
    let answers = answers(&["--profile", "mobile", "--mount", "projector_mount"], &robot()).unwrap();
    assert_eq!((&*answers.fixed_frame, &*answers.monitor, answers.size_px), ("odom", "HDMI-1", [1280, 800]));
    assert_eq!(answers.depth.as_deref(), Some("/camera/aligned_depth_to_color/image_raw"));
    let topics: Vec<_> = answers.topics.iter().map(|(topic, _)| topic.as_str()).collect();
    assert_eq!(topics, ["/detections", "/objects"], "results, not what the camera sees");
}

#[test]
fn the_other_computers_monitor_is_not_looked_for_here() {
    let words = ["--profile", "two-computers", "--mount", "projector_mount"];
    let error = answers(&words, &robot()).unwrap_err();
    assert!(error.starts_with("answers missing: --size WxH;"), "{error}");
    let answers = answers(&[&words[..], &["--size", "1280x800"]].concat(), &robot()).unwrap();
    assert_eq!(answers.monitor, "auto");
}

#[test]
fn a_topic_of_unknown_type_is_named_with_what_is_published() {
    let words = ["--profile", "fetch", "--size", "1280x800", "--show", "/detection", "/x", "/scan", "/tf"];
    let error = answers(&words, &robot()).unwrap_err();
    for part in [
        "--show: /detection is published by nobody, so its type is unknown; published: /detections; write /detection=TYPE",
        "; /x is published by nobody, so its type is unknown; write /x=TYPE",
        "; /tf: type 'tf2_msgs/TFMessage' has no display here",
    ] {
        assert!(error.contains(part), "{part}: {error}");
    }
}

#[test]
fn a_terminal_offers_what_is_found() {
    let (result, shown) = asked(&[], &robot(), &["mobile", "projector_mount", "", "", "", "", "", "/objects"]);
    let expected = answers(&["--profile", "mobile", "--mount", "projector_mount", "--show", "/objects"], &robot());
    assert_eq!(result.unwrap(), expected.unwrap());
    for part in [
        "What is the projector mounted on?",
        "Frames: base_link, head_link, odom, projector_mount",
        "Link that the projector is mounted on: ",
        "Fixed frame of the scene [odom]: ",
        "Monitor HDMI-1 1280x800+0+0",
        "Monitor that the projector is [HDMI-1]: ",
        "Native resolution of the projector, pixels [1280x800]: ",
        "[/camera/color/image_raw]: ",
        "  /scan  LaserScan",
        "Topics to project, with spaces between, or grid [/detections /objects]: ",
    ] {
        assert!(shown.contains(part), "{part}: {shown}");
    }
    assert_eq!(shown.matches("]: ").count() + shown.matches("on: ").count() + shown.matches("Profile: ").count(), 8);
}

#[test]
fn an_unusable_answer_is_asked_for_again_and_the_end_of_the_input_ends() {
    let lines = ["pr2", "?", "fixed", "", "", "", "", "wide", "1280x800", "none", "/a", "/a=Path"];
    let (result, shown) = asked(&[], &Found::default(), &lines);
    assert_eq!(result.unwrap().topics[0].1.class, "rviz/Path");
    for part in
        ["'pr2' is not one of", "not a size", "an answer is needed", "/a is published by nobody", "without a robot"]
    {
        assert!(shown.contains(part), "{part}: {shown}");
    }
    let (result, _) = asked(&[], &Found::default(), &lines[..6]);
    assert!(matches!(result, Err(SetupError::Refused(_))), "{result:?}");
}

#[test]
fn a_frame_or_camera_that_is_not_there_is_a_warning_with_near_names() {
    let words = ["--profile", "mobile", "--mount", "projector_mont", "--monitor", "DP-7", "--size", "1280x800"];
    let warnings = answers::warnings(&answers(&words, &robot()).unwrap(), &robot());
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings[0].contains("--mount projector_mont") && warnings[0].contains("did you mean projector_mount?"));
    assert!(warnings[1].contains("--monitor DP-7: not connected; monitors: 0: eDP-1"), "{}", warnings[1]);
    let mistyped = [&words[..], &["--image", "/camera/colour/image_raw", "--depth", "/elsewhere/depth"]].concat();
    let warnings = answers::warnings(&answers(&mistyped, &robot()).unwrap(), &robot());
    let expected = "--image /camera/colour/image_raw: nobody publishes it (did you mean /camera/color/image_raw?)";
    assert!(warnings.len() == 3 && warnings[1] == expected, "{warnings:?}");
    let nothing = answers::warnings(&answers(&FIXED, &Found::default()).unwrap(), &Found::default());
    assert!(nothing[0].starts_with("no ROS master answers: ") && nothing[1].starts_with("no display is open: "));
    let without_frames = Found { frames: BTreeSet::new(), links: BTreeSet::new(), ..robot() };
    let other_size = answers::warnings(&answers(&FIXED, &without_frames).unwrap(), &without_frames);
    assert!(other_size[0].starts_with("nothing publishes TF or a robot's description"), "{other_size:?}");
    assert!(
        other_size[1].starts_with("--size 1920x1080: monitor HDMI-1 1280x800+0+0 has another size; "),
        "{other_size:?}"
    );
}

#[test]
fn the_frames_of_a_calibrated_projector_are_the_folders_own() {
    let folder = tempfile::tempdir().unwrap();
    let guess = &files(&FIXED, &Found::default(), &BTreeMap::new())[PROJECTOR_FILE];
    let path = folder.path().join(PROJECTOR_FILE);
    fs::write(&path, guess).unwrap();
    assert_eq!(folder::calibrated(folder.path()).unwrap(), None);
    let mut file = ProjectorFile::read(&path).unwrap();
    file.frames = ["proj_view", "table"].map(|child| StaticFrame::new("optical", child, &Isometry3::identity())).into();
    file.write(&path).unwrap();
    let mut found = Found::default();
    found.add_projector(&folder::calibrated(folder.path()).unwrap().unwrap());
    let answers = answers(&FIXED, &found).unwrap();
    assert_eq!((&*answers.mount, &*answers.fixed_frame), ("optical", "table"));
}

#[test]
fn where_nothing_is_published_enter_is_a_grid() {
    let (result, shown) = asked(&[], &Found::default(), &["fixed", "", "", "", "1280x800", "", ""]);
    let answers = result.unwrap();
    assert!(answers.topics.is_empty() && answers.image.is_none(), "{answers:?}");
    assert!(shown.ends_with("Topics to project, with spaces between, or grid [grid]: "), "{shown}");
    let plan = Plan::new(PathBuf::from("/tmp/first"), answers, &BTreeMap::new(), false);
    assert!(plan.is_try);
}

/// Options of each profile, without a master.
fn profiles() -> [Vec<&'static str>; 4] {
    let camera = ["--image", "/cam/image", "--depth", "/cam/depth", "--show", "/a=Path", "/b=LaserScan"];
    let with = |words: &[&'static str]| [words, &["--size", "1920x1080"], &camera].concat();
    [
        vec!["--profile", "fetch", "--size", "1280x800"],
        with(&["--profile", "fixed"]),
        with(&["--profile", "mobile", "--mount", "arm_link"]),
        with(&["--profile", "two-computers", "--mount", "arm_link"]),
    ]
}

#[test]
fn the_scene_of_each_profile_is_understood_and_projects_its_topics() {
    for profile in profiles() {
        for is_try in [false, true] {
            let words = [&profile[..], if is_try { &["--try"] } else { &[] }].concat();
            let files = files(&words, &Found::default(), &BTreeMap::new());
            let config = rcs_rviz_config::parse(&files[SCENE_FILE], SCENE_FILE).unwrap();
            assert_eq!(config.findings, [], "{profile:?}");
            assert_eq!(camera_problems(&config), [""; 0]);
            assert!(setting_problems(&config).is_empty(), "{:?}", setting_problems(&config));
            let mut cameras = config.displays.iter().filter_map(|display| match &display.settings {
                DisplaySettings::CameraPub(camera) => Some(camera),
                _ => None,
            });
            let camera = cameras.next().unwrap();
            let shows = |name: &str| camera.visibility.shows(&[name]);
            assert_eq!((shows("Grid"), shows("TF")), (is_try, is_try));
            assert_eq!(camera.near_clip_m > 0.1, is_try, "names of links beside the lens cover the grid");
            for display in config.displays.iter().filter(|display| !["Grid", "TF"].contains(&&*display.name)) {
                assert!(display.enabled && shows(&display.name), "{}", display.name);
            }
        }
    }
}

#[test]
fn every_display_is_written_so_that_it_is_read_without_findings() {
    let topics: Vec<String> = DISPLAY_TYPES
        .iter()
        .enumerate()
        .map(|(index, display)| format!("/topic_{index}={}", display.ros_type))
        .collect();
    let words: Vec<&str> =
        FIXED[..6].iter().copied().chain(["--show"]).chain(topics.iter().map(String::as_str)).collect();
    let scene = &files(&words, &Found::default(), &BTreeMap::new())[SCENE_FILE];
    let config = rcs_rviz_config::parse(scene, SCENE_FILE).unwrap();
    assert_eq!(config.findings, []);
    assert_eq!(config.displays.len(), DISPLAY_TYPES.len() + 3);
    assert!(!scene.contains("COLOR"), "{scene}");
}

#[test]
fn the_projector_file_of_each_profile_is_a_guess_below_the_mount() {
    for words in profiles() {
        let text = &files(&words, &Found::default(), &BTreeMap::new())[PROJECTOR_FILE];
        let file = ProjectorFile::parse(Path::new(PROJECTOR_FILE), text).unwrap();
        assert_eq!(file.warnings(), [""; 0]);
        let info = &file.camera_info;
        assert_eq!((info.P[0], info.P[2]), (1.5 * f64::from(info.width), f64::from(info.width) / 2.0));
        let mount = answers(&words, &Found::default()).unwrap().mount;
        assert_eq!((&*file.frames[0].parent, &*file.frames[0].child), (&*mount, "proj_view"));
        assert!(text.starts_with("# Not calibrated: "), "{text}");
    }
}

#[test]
fn the_launch_file_has_absolute_paths_and_the_package_s_arguments() {
    for words in profiles() {
        let files = files(&words, &Found::default(), &BTreeMap::new());
        let (arguments, included) = launch_arguments(&files[LAUNCH_FILE]);
        let is_fetch = words.contains(&"fetch");
        let file = if is_fetch { "fetch.launch" } else { "projection.launch" };
        assert_eq!(included, format!("$(find rviz_camera_stream)/launch/{file}"));
        assert_eq!(arguments["rviz_config"], "/tmp/first/scene.rviz");
        assert_eq!(arguments["projector"], "/tmp/first/projector.yaml");
        assert_eq!(arguments["viewer"], if words.contains(&"two-computers") { "none" } else { "projector_window" });
        let package = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../launch").join(file);
        let package = fs::read_to_string(package).unwrap();
        for name in arguments.keys() {
            assert!(package.contains(&format!("<arg name=\"{name}\"")), "{file} has no argument {name}");
        }
    }
}

#[test]
fn age_limits_fit_the_rates() {
    let rates = BTreeMap::from([
        ("/a".to_owned(), Rate::Latched),
        ("/b".to_owned(), Rate::Every(Duration::from_secs(2))),
        ("/c".to_owned(), Rate::Every(Duration::from_millis(100))),
    ]);
    let words = [&FIXED[..6], &["--show", "/a=PointCloud2", "/b=MarkerArray", "/c=Path"]].concat();
    let launch = |words: &[&str]| launch_arguments(&files(words, &Found::default(), &rates)[LAUNCH_FILE]).0;
    let arguments = launch(&words);
    assert_eq!(arguments["stale_timeout"], "1");
    assert_eq!(arguments["stale_timeouts"], "[{topic: /a, limit: held}, {topic: /b, limit: 6}]");
    let arguments = launch(&[&words[..], &["--try"]].concat());
    assert_eq!((&*arguments["stale_timeout"], &*arguments["stale_timeouts"]), ("none", "none"), "nothing ages out");
}

#[test]
fn the_readme_has_the_next_commands_with_absolute_paths() {
    let [fetch, .., apart] = profiles();
    let readme = |words: &[&str]| files(words, &Found::default(), &BTreeMap::new())[README_FILE].clone();
    let text = readme(&fetch);
    for command in [
        "    roslaunch /tmp/first/projection.launch\n",
        "    rosrun rviz_camera_stream projector_calibrate scan --size 1280x800 --monitor auto --image \
         /head_camera/rgb/image_raw --camera-info /head_camera/rgb/camera_info --depth \
         /head_camera/depth_registered/image_raw -o /tmp/first/capture\n",
        "    rosrun rviz_camera_stream projector_calibrate solve /tmp/first/capture --size 1280x800 --parent \
         torso_lift_link -o /tmp/first/projector.yaml\n",
        "    rosrun rviz_camera_stream camera_stream doctor /tmp/first\n",
    ] {
        assert!(text.contains(command), "{command}: {text}");
    }
    let text = readme(&apart);
    for part in ["ROS_MASTER_URI", "ROS_IP", "roslaunch projector_computer.launch", "--show-on /projector/patterns"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(readme(&FIXED).contains("projector_calibrate manual -o /tmp/first/lens.yaml"));
    let text =
        readme(&[&FIXED[..4], &["--image", "/camera/image", "--depth", "/camera/depth", "--show", "/a=Path"]].concat());
    let solve = "solve /tmp/first/capture --size 1920x1080 --in-camera-frame --table -o /tmp/first/projector.yaml\n";
    assert!(text.contains(solve) && text.contains("fixed_frame:="), "{text}");
}

#[test]
fn only_two_computers_have_a_launch_file_for_the_window() {
    let [.., mobile, apart] = profiles();
    assert!(!files(&mobile, &Found::default(), &BTreeMap::new()).contains_key(WINDOW_LAUNCH_FILE));
    let files = files(&apart, &Found::default(), &BTreeMap::new());
    let document = roxmltree::Document::parse(&files[WINDOW_LAUNCH_FILE]).unwrap();
    let node = document.descendants().find(|node| node.has_tag_name("node")).unwrap();
    assert_eq!(node.attribute("type"), Some("projector_window"));
}

#[test]
fn a_folder_that_has_files_is_refused_without_overwrite() {
    let folder = tempfile::tempdir().unwrap();
    let free = |overwrite| folder::check_free(folder.path(), overwrite);
    assert!(free(false).is_ok() && folder::check_free(&folder.path().join("new"), false).is_ok());
    fs::write(folder.path().join("x"), "").unwrap();
    let error = free(false).unwrap_err();
    assert!(matches!(error, SetupError::Refused(_)) && error.to_string().contains("--overwrite"), "{error}");
    assert!(free(true).is_ok());
    assert!(matches!(folder::check_free(&folder.path().join("x"), true), Err(SetupError::Refused(_))), "a file");
}

#[test]
fn a_path_that_roslaunch_would_split_is_invalid() {
    for path in ["/tmp/my scene", "/tmp/$(env HOME)", "/tmp/a\"b", "/tmp/a:=b"] {
        let error = folder::absolute(Path::new(path)).unwrap_err();
        assert!(matches!(error, SetupError::Invalid(_)), "{path}: {error}");
    }
    assert!(folder::absolute(Path::new("relative")).unwrap().is_absolute());
}

#[test]
fn a_guess_is_replaced_and_a_calibration_kept() {
    let folder = tempfile::tempdir().unwrap();
    let files: Vec<_> = files(&FIXED, &Found::default(), &BTreeMap::new()).into_iter().collect();
    let path = folder.path().join("deep/first");
    for _ in 0..2 {
        assert_eq!(folder::write(&path, &files).unwrap(), [""; 0]);
    }
    assert_eq!(fs::read_dir(&path).unwrap().count(), 4);
    fs::write(path.join(PROJECTOR_FILE), "frame_id: calibrated, and more than the mark\n").unwrap();
    assert_eq!(folder::write(&path, &files).unwrap(), [PROJECTOR_FILE]);
    assert!(fs::read_to_string(path.join(PROJECTOR_FILE)).unwrap().starts_with("frame_id: calibrated"));
}
