//! The launch files: which nodes they start, and that these publish images.

use std::collections::BTreeSet;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdout, Stdio};
use std::sync::{LazyLock, Mutex};

use rcs_tests::programs::{program, repository};
use rcs_tests::python_node::PythonNode;
use rcs_tests::ros::{wait_until, RosMaster, Running, PATIENCE};

use crate::{bash_command, printed_by, succeed, target};

/// Runs `roslaunch` with the arguments of each line that it reads, as a shell splits them, and answers with the exit
/// status, the number of lines and the lines that it printed.
const ROSLAUNCH: &str = "
import contextlib, io, shlex, sys, roslaunch
for line in sys.stdin:
    printed = io.StringIO()
    sys.argv = ['roslaunch', *shlex.split(line)]
    try:
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
            roslaunch.main(sys.argv)
        status = 0
    except SystemExit as ended:
        status = ended.code or 0
    lines = printed.getvalue().splitlines()
    print(status, len(lines), *lines, sep='\\n', flush=True)
";

/// One Python with roslaunch for all tests, because roslaunch takes longer to start than to read a launch file. It ends
/// with the tests, at the end of its standard input.
struct Roslaunch {
    process: Child,
    printed: BufReader<ChildStdout>,
}

impl Roslaunch {
    /// With the package as it lies in the repository, and the programs that are built already in a devel space.
    fn start() -> Self {
        let space = Path::new(env!("CARGO_TARGET_TMPDIR")).join("launched");
        let script = format!("{}\nexec /usr/bin/python3 -c \"{ROSLAUNCH}\"", devel_space(&space));
        let mut process = bash_command(&script).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let printed = BufReader::new(process.stdout.take().unwrap());
        Self { process, printed }
    }

    /// The exit status and what is printed with these arguments, on both outputs.
    fn run(&mut self, arguments: &str) -> io::Result<(i32, String)> {
        writeln!(self.process.stdin.as_mut().ok_or(io::ErrorKind::BrokenPipe)?, "{arguments}")?;
        let mut lines = self.printed.by_ref().lines();
        let mut number = || lines.next().unwrap_or_else(|| Err(io::ErrorKind::UnexpectedEof.into()));
        let [status, count] = [number()?, number()?].map(|number| number.parse::<i32>().unwrap());
        let printed = (0..count).map(|_| number()).collect::<io::Result<Vec<_>>>()?;
        Ok((status, printed.iter().map(|line| format!("{line}\n")).collect()))
    }
}

/// The exit status of `roslaunch`, and what it prints.
fn ended(arguments: &str) -> (i32, String) {
    static RUNNING: LazyLock<Mutex<Roslaunch>> = LazyLock::new(|| Mutex::new(Roslaunch::start()));
    RUNNING.lock().unwrap().run(arguments).unwrap()
}

/// What `roslaunch` prints with these arguments, with which it must succeed.
fn roslaunch(arguments: &str) -> String {
    let (status, printed) = ended(arguments);
    assert_eq!(status, 0, "{arguments}: {printed}");
    printed
}

/// The nodes of a launch file with these arguments.
fn nodes(launch: &str) -> Vec<String> {
    let printed = roslaunch(&format!("--nodes rviz_camera_stream {launch}"));
    let mut nodes: Vec<_> = printed.lines().map(str::to_owned).collect();
    nodes.sort();
    nodes
}

/// Makes a devel space of the repository with the programs that are built already, and sources it.
pub(crate) fn devel_space(space: &Path) -> String {
    // roslaunch looks for programs in lib/PACKAGE of the workspaces on CMAKE_PREFIX_PATH; .catkin marks one.
    format!(
        "mkdir -p {0}/lib && ln -sfn {1} {0}/lib/rviz_camera_stream && echo {2} >{0}/.catkin
         {3}
         export CMAKE_PREFIX_PATH={0}:${{CMAKE_PREFIX_PATH:-/usr}}",
        space.display(),
        target().join("release").display(),
        repository().join("ros_pkg").display(),
        from_source(),
    )
}

/// The package as it lies in the repository.
pub(crate) fn from_source() -> String {
    format!("export ROS_PACKAGE_PATH={}:${{ROS_PACKAGE_PATH:-/usr/share}}", repository().join("ros_pkg").display())
}

#[test]
fn demo_opens_rviz_when_asked_to() {
    let cameras = ["/camera1/camera_info", "/camera2/camera_info", "/camera_stream"];
    assert_eq!(nodes("demo.launch use_rviz:=false"), cameras);
    assert_eq!(nodes("demo.launch use_rviz:=true"), [&cameras[..], &["/rviz"]].concat());
    assert_eq!(nodes("demo.launch"), nodes("demo.launch use_rviz:=true"));
}

#[test]
fn a_rehearsal_starts_the_parts_of_its_robot_and_refuses_others() {
    let of_fetch = ["/head_pan", "/head_tilt", "/paper_scene", "/simulated_robot", "/simulated_turret"];
    assert_eq!(nodes("rehearsal.launch"), of_fetch);
    assert_eq!(nodes("rehearsal.launch robot:=table"), ["/simulated_robot"]);
    assert_eq!(nodes("rehearsal.launch robot:=board"), ["/simulated_robot"]);
    let (status, printed) = ended("--nodes rviz_camera_stream rehearsal.launch robot:=pr2");
    assert!(status != 0 && printed.contains("pr2"), "{status}: {printed}");
}

#[test]
fn each_part_of_the_projection_can_be_replaced() {
    let whole = ["/camera_stream", "/clusters", "/desired_object", "/projector", "/projector_window"];
    let sample = ["/sample_markers", "/sample_path"];
    assert_eq!(nodes("projection.launch"), [&whole[..], &sample].concat());
    assert_eq!(nodes("projection.launch sample_scene:=false"), ["/camera_stream", "/projector", "/projector_window"]);
    assert_eq!(nodes("projection.launch sample_scene:=false projector:=none viewer:=none"), ["/camera_stream"]);
    let own_cloud = nodes("projection.launch sample_scene:=false viewer:=image_view clusters:=/my.pcd");
    assert_eq!(own_cloud, ["/camera_stream", "/clusters", "/image_view", "/image_view_place", "/projector"]);
    assert_eq!(
        nodes("projection.launch sample_scene:=false viewer:=window monitor:=0"),
        ["/camera_stream", "/projector"]
    );
    assert_eq!(nodes("fetch.launch"), ["/camera_stream", "/projector", "/projector_window"]);
}

#[test]
fn the_papers_samples_are_started_by_their_arguments() {
    let shown = ["/camera_stream", "/projector"];
    let aimed = ["/line_of_sight", "/turret_aim"];
    let sorted = |parts: &[&[&'static str]]| {
        let mut all = parts.concat();
        all.sort_unstable();
        all
    };
    let fetch = nodes("fetch.launch viewer:=none turret:=true path_arrows:=true line_of_sight:=true");
    assert_eq!(fetch, sorted(&[&shown, &aimed, &["/nav_path_markers"]]));
    let simulated = ["/observer", "/paper_scene", "/simulated_turret"];
    assert_eq!(nodes("paper.launch viewer:=none"), sorted(&[&shown, &aimed, &simulated, &["/nav_path_markers"]]));
    assert_eq!(nodes("arm.launch viewer:=none"), sorted(&[&shown, &aimed, &simulated]));
    assert_eq!(nodes("arm.launch viewer:=none simulate:=false"), sorted(&[&shown, &aimed]));
    let two = ["/camera_stream", "/left_projector", "/right_projector"];
    assert_eq!(nodes("two_projectors.launch sample_scene:=false"), two);
    let windows = nodes("two_projectors.launch sample_scene:=false left_monitor:=0 right_monitor:=HDMI-2");
    assert_eq!(windows, sorted(&[&two, &["/left_window", "/right_window"]]));
}

#[test]
fn an_unknown_viewer_is_refused() {
    let script = format!("{}\nroslaunch --nodes rviz_camera_stream projection.launch viewer:=mirror", from_source());
    let output = crate::bash(&script);
    let error = "No such file or directory: '";
    assert!(printed_by(&output).contains(error), "{}", printed_by(&output));
    assert!(printed_by(&output).contains("/launch/viewers/mirror.launch'"), "{}", printed_by(&output));
    assert!(!printed_by(&output).contains("/camera_stream"), "{}", printed_by(&output));
    // The error, and where roslaunch's own log is.
    let lines = printed_by(&output).lines().filter(|line| !line.trim().is_empty()).count();
    assert!(lines <= 2 && !printed_by(&output).contains("Traceback"), "{}", printed_by(&output));
}

/// The help of a launch file's argument.
fn help_of(launch: &str, argument: &str) -> String {
    let file = std::fs::read_to_string(repository().join("launch").join(launch)).unwrap();
    let begin = format!("<arg name=\"{argument}\" ");
    let line = file.lines().find(|line| line.trim_start().starts_with(&begin)).unwrap_or_default();
    line.split_once(" doc=\"").map(|(_, help)| help.to_owned()).unwrap_or_default()
}

#[test]
fn each_launch_file_with_a_viewer_names_all_of_them() {
    let all = help_of("projection.launch", "viewer");
    assert!(all.contains("window (the same in camera_stream itself"), "{all}");
    for launch in ["fetch.launch", "paper.launch", "arm.launch"] {
        assert_eq!(help_of(launch, "viewer"), all, "{launch}");
    }
}

/// The arguments of a launch file by name, and whether they are required.
fn arguments(launch: &str) -> Vec<(String, bool)> {
    let printed = roslaunch(&format!("--ros-args rviz_camera_stream {launch}"));
    let mut is_required = false;
    let mut found = Vec::new();
    for line in printed.lines() {
        match line.strip_prefix("  ").and_then(|rest| rest.split([' ', ':']).next()) {
            Some(name) => found.push((name.to_owned(), is_required)),
            None => is_required = line.starts_with("Required"),
        }
    }
    found
}

#[test]
fn no_argument_is_required_or_internal() {
    for launch in
        ["demo.launch", "projection.launch", "fetch.launch", "arm.launch", "two_projectors.launch", "paper.launch"]
    {
        let arguments = arguments(launch);
        assert!(arguments.len() > 2, "{launch}: {arguments:?}");
        assert!(arguments.iter().all(|(_, is_required)| !is_required), "{launch}: {arguments:?}");
        assert!(!arguments.iter().any(|(name, _)| name.contains("option") || name.contains("known")), "{arguments:?}");
    }
}

#[test]
fn the_fetch_takes_and_passes_on_every_argument_of_the_projection() {
    let (fetch, whole) = (arguments("fetch.launch"), arguments("projection.launch"));
    let missing: Vec<_> = whole.iter().filter(|argument| !fetch.contains(argument)).collect();
    assert!(missing.is_empty(), "{missing:?}");
    let text = std::fs::read_to_string(repository().join("launch/fetch.launch")).unwrap();
    for (name, _) in whole {
        assert!(text.contains(&format!("<arg name=\"{name}\" value=\"$(arg {name})\"/>")), "{name}");
    }
}

/// The names of a node's parameters by a launch file with these arguments, and all lines of `--dump-params`.
fn parameters(node: &str, launch: &str) -> (BTreeSet<String>, String) {
    let printed = roslaunch(&format!("--dump-params rviz_camera_stream {launch}"));
    let begin = format!("/{node}/");
    let names = printed.lines().filter_map(|line| Some(line.strip_prefix(&begin)?.split(':').next()?.to_owned()));
    (names.collect(), printed.clone())
}

/// The parameters that a program has, by its help.
fn parameters_in_help(name: &str) -> BTreeSet<String> {
    let help = std::process::Command::new(program(name)).arg("--help").output().unwrap();
    let help = String::from_utf8(help.stdout).unwrap();
    let lines = help.lines().filter(|line| line.len() - line.trim_start().len() <= 6);
    let options = lines.filter_map(|line| line.split("--").nth(1)?.split([' ', '=', ',']).next());
    options.map(|option| option.trim().replace('-', "_")).collect()
}

#[test]
fn the_fetch_passes_on_every_option_of_the_nodes_that_it_starts() {
    let samples = "fetch.launch turret:=true path_arrows:=true line_of_sight:=true";
    for node in ["turret_aim", "nav_path_markers", "line_of_sight"] {
        let options = parameters_in_help(node);
        let (set, printed) = parameters(node, samples);
        assert!(set.len() > 1 && set.is_subset(&options), "{node}: {set:?} {printed}");
        // Each that has no argument of its own is one of those of NODE_parameters.
        let further: Vec<_> = options.iter().filter(|option| !["help", "version"].contains(&option.as_str())).collect();
        let given: Vec<_> = further.iter().map(|option| format!("{option}: given")).collect();
        let (all, printed) = parameters(node, &format!("{samples} {node}_parameters:='{{{}}}'", given.join(", ")));
        assert_eq!(all.iter().collect::<Vec<_>>(), further, "{node}");
        for option in further.into_iter().filter(|option| !set.contains(*option)) {
            assert!(printed.contains(&format!("/{node}/{option}: given\n")), "{node} {option}: {printed}");
        }
    }
    for (arguments, expected) in [
        ("moveit_msgs:=melodic", "/line_of_sight/moveit_msgs: melodic"),
        ("target:='{target_point: /grasp}'", "/turret_aim/target_point: /grasp"),
        ("frame_id:=beamer", "/projector/frame_id: beamer"),
    ] {
        let printed = parameters("projector", &format!("{samples} {arguments}")).1;
        assert!(printed.lines().any(|line| line == expected), "{printed}");
        assert_eq!(printed.contains("target_cloud"), !arguments.contains("target_point"), "{printed}");
    }
    let (set, _) = parameters("projector", samples);
    let mut options = parameters_in_help("projector");
    options.retain(|option| !["help", "version"].contains(&option.as_str()));
    assert_eq!(set, options);
}

/// The options of `camera_stream` when a launch file has started it, as the node logs them.
fn effective_options(launch: &str) -> BTreeSet<String> {
    const BEGIN: &str = "options: ";
    let master = RosMaster::start().unwrap();
    let launched = Launched::start(&master, &format!("{launch} renderer:=cpu"));
    let line = || launched.roslaunch.errors().into_iter().find(|line| line.contains(BEGIN));
    assert!(wait_until(PATIENCE, || line().is_some()), "{launch}: {:?}", launched.roslaunch.errors());
    let line = line().unwrap();
    let words = line.split_once(BEGIN).unwrap().1.split(" --").skip(1).map(|word| format!("--{}", word.trim_end()));
    // The terminal's colour ends behind the line.
    words.map(|word| word.split('\x1b').next().unwrap().to_owned()).collect()
}

fn words(text: &str) -> BTreeSet<String> {
    text.split_whitespace().map(str::to_owned).collect()
}

const DEFAULTS: &str =
    "--blend=none --blend-gamma=2.2 --confirm=all --confirm-margin=4 --confirm-tolerance=0.03 --depth-encoding=32FC1 --fixed-frame=none --keep-out=none --lazy \
                        --mask=none --mask-required --mask-topic=none --max-mesh-mb=512 --mesh-folder=none \
                        --no-set-mode --orientation=0 --predict=none --predict-limit=0.1 --projection=exact \
                        --renderer=cpu --screen-delay=0.02 --stale-note --stale-timeout=1 \
                        --stale-timeouts=/move_base/NavfnROS/plan=held \
                        --stale-timeouts=/visualization_marker_array=held --surface=none --undistort --unseen=dark --watch --web=none --web-hosts=none --window=none";

/// Parameters outlive a launch: what one sets, the next must set as well.
#[test]
fn the_projection_sets_every_option_of_the_node() {
    assert_eq!(effective_options("projection.launch viewer:=none sample_scene:=false"), words(DEFAULTS));
    let help = std::process::Command::new(program("camera_stream")).arg("--help").output().unwrap();
    let help = String::from_utf8(help.stdout).unwrap();
    let options = help.split("\nOptions:\n").nth(1).unwrap().split("\nOnly on").next().unwrap();
    let option_lines = options.lines().filter(|line| line.len() - line.trim_start().len() <= 6);
    let set = words(DEFAULTS);
    for option in option_lines.filter_map(|line| line.split("--").nth(1)?.split([' ', '=']).next()) {
        let name = option.strip_prefix("no-").unwrap_or(option);
        let is_it =
            |word: &String| word.trim_start_matches("--").trim_start_matches("no-").split('=').next() == Some(name);
        // A blackout outlives a launch as well: no launch file releases it. Brightness is the operator's.
        let is_operators = ["blackout", "brightness", "fade-seconds"].contains(&name);
        assert!(["help", "version"].contains(&name) || is_operators || set.iter().any(is_it), "{option}");
    }
}

#[test]
fn arguments_of_a_launch_file_become_the_nodes_options() {
    let given = "fetch.launch viewer:=window monitor:=1 fixed_frame:=odom undistort:=false stale_timeout:=none \
                 stale_timeouts:='[{topic: /map, limit: never}, {topic: /plan, limit: 2.5}]' stale_note:=false \
                 orientation:=mirrored-180 mask_topic:=/people predict:=auto set_mode:=true \
                 keep_out:='[{frame: head_1, radius: 0.25}, {frame: hand, radius: 1}]' mask:=/a=b.png \
                 blend:='[{camera: Projector, file: /left.png}]' \
                 surface:='[{camera: Projector, topic: /depth}]' confirm:='[clusters]' unseen:=light";
    let expected = words(DEFAULTS);
    let replaced = [
        "--fixed-frame",
        "--undistort",
        "--stale",
        "--orientation",
        "--mask-topic",
        "--predict=",
        "--no-set",
        "--keep-out",
        "--mask=",
        "--blend=",
        "--surface",
        "--confirm=",
        "--unseen",
        "--window",
    ];
    let mut expected: BTreeSet<String> =
        expected.into_iter().filter(|word| !replaced.iter().any(|begin| word.starts_with(begin))).collect();
    expected.extend(words(
        "--window=1 --fixed-frame=odom --no-undistort --stale-timeout=none --stale-timeouts=/map=never \
         --stale-timeouts=/plan=2.5 --no-stale-note --orientation=mirrored-180 --mask-topic=/people --predict=auto \
         --set-mode --keep-out=head_1=0.25 --keep-out=hand=1 --mask=/a=b.png --blend=Projector=/left.png \
         --surface=Projector=/depth --confirm=clusters --unseen=light",
    ));
    assert_eq!(effective_options(given), expected);
}

#[test]
fn windows_and_blending_are_parameters_of_each_projector() {
    let blend = "two_projectors.launch sample_scene:=false \
                 blend:='[{camera: Left, file: /l.png}, {camera: Right, file: /r.png}]'";
    let options = effective_options(blend);
    assert!(words("--blend=Left=/l.png --blend=Right=/r.png").is_subset(&options), "{options:?}");
    let parameters =
        roslaunch("--dump-params rviz_camera_stream two_projectors.launch left_monitor:=0 stale_timeout:=2");
    for parameter in ["monitor: 0", "stale_timeout: 2", "topic: /left/image", "set_mode: false"] {
        assert!(parameters.contains(&format!("/left_window/{parameter}\n")), "{parameters}");
    }
}

#[test]
fn the_nodes_that_are_scripts_have_help() {
    for script in ["image_view_anywhere", "image_view_overlay", "paper_scene", "rviz_if_installed", "simulated_turret"]
    {
        for option in ["--help", "-h"] {
            let printed = succeed(&format!("ros_pkg/nodes/{script} {option}"));
            assert!(printed.contains("Exit status"), "{script}: {printed}");
        }
    }
    let output = crate::bash("ros_pkg/nodes/image_view_overlay --nope");
    assert_eq!(output.status.code(), Some(2));
    assert!(output.stdout.is_empty() && printed_by(&output).contains("'--nope'"), "{}", printed_by(&output));
}

/// A devel space with the programs that are built already, and roslaunch in it; ended when it is dropped.
pub(crate) struct Launched {
    pub(crate) roslaunch: Running,
    _space: tempfile::TempDir,
}

impl Launched {
    fn start(master: &RosMaster, launch: &str) -> Self {
        Self::run(master, &format!("rviz_camera_stream {launch}"))
    }

    /// Runs roslaunch with these arguments.
    pub(crate) fn run(master: &RosMaster, arguments: &str) -> Self {
        let space = tempfile::tempdir().unwrap();
        let script = format!("{}\nexec roslaunch {arguments}", devel_space(space.path()));
        let roslaunch = Running::start(&mut master.environment(bash_command(&script))).unwrap();
        Self { roslaunch, _space: space }
    }
}

impl Drop for Launched {
    fn drop(&mut self) {
        // It ends its nodes when it is interrupted.
        self.roslaunch.signal("INT");
        self.roslaunch.wait(PATIENCE);
    }
}

/// Waits for one image and returns what rostopic prints of it without its data.
pub(crate) fn image(master: &RosMaster, topic: &str, launched: &Launched) -> String {
    let printed = master.output("rostopic", &["echo", "-n", "1", "--noarr", topic]).unwrap();
    assert!(!printed.is_empty(), "{topic}: {:?} {:?}", launched.roslaunch.lines(), launched.roslaunch.errors());
    printed
}

#[test]
fn demo_shows_both_cameras() {
    let master = RosMaster::start().unwrap();
    let launched = Launched::start(&master, "demo.launch use_rviz:=false renderer:=cpu");
    for (camera, height, width) in [("camera1", 480, 640), ("camera2", 720, 1280)] {
        let image = image(&master, &format!("/rviz1/{camera}/image"), &launched);
        assert!(image.contains(&format!("height: {height}\nwidth: {width}\nencoding: \"rgb8\"")), "{image}");
        assert!(image.contains(&format!("frame_id: \"{camera}\"")), "{image}");
    }
}

#[test]
fn demo_without_a_display_reports_that_rviz_does_not_open() {
    let master = RosMaster::start().unwrap();
    let launched = Launched::start(&master, "demo.launch use_rviz:=true renderer:=cpu");
    assert!(launched.roslaunch.line_with("so rviz does not start").is_some(), "{:?}", launched.roslaunch.lines());
    image(&master, "/rviz1/camera1/image", &launched);
}

#[test]
fn projection_publishes_on_the_topics_of_its_arguments() {
    let master = RosMaster::start().unwrap();
    let launched = Launched::start(
        &master,
        "projection.launch viewer:=none renderer:=cpu image_topic:=/wall/image camera_info_topic:=/wall/projector",
    );
    let image = image(&master, "/wall/image", &launched);
    assert!(image.contains("height: 800\nwidth: 1280"), "{image}");
}

#[test]
fn both_projectors_have_a_image() {
    let master = RosMaster::start().unwrap();
    let launched = Launched::start(&master, "two_projectors.launch renderer:=cpu");
    for side in ["left", "right"] {
        let image = image(&master, &format!("/{side}/image"), &launched);
        assert!(image.contains(&format!("frame_id: \"{side}_proj_view\"")), "{image}");
    }
}

/// Waits until the turret reports that its light is less than a degree from the object to grasp.
const LIT: &str = "
from diagnostic_msgs.msg import DiagnosticArray
lit, objects, arrows = [], [], []
def see(array):
    for status in array.status:
        values = {value.key: value.value for value in status.values}
        miss = values.get('aiming error, degrees', '-')
        if status.message == 'aiming at the target' and miss != '-' and float(miss) < 1:
            lit.append(round(float(values['first joint'].split()[-1]), 1))
seeing = rospy.Subscriber('/diagnostics', DiagnosticArray, see)
beam = rospy.Subscriber('/collision_object', rospy.AnyMsg, objects.append)
drawn = rospy.Subscriber('/path_arrows', rospy.AnyMsg, arrows.append)
view = Viewer('/proj_view/image')
";

#[test]
fn the_whole_paper_runs_in_simulation() {
    for command in ["float64", "trajectory"] {
        let master = RosMaster::start().unwrap();
        let python = PythonNode::start(&master, &[]).unwrap();
        python.run(LIT).unwrap();
        let arguments = format!("paper.launch viewer:=none renderer:=cpu seconds:=3 command:={command}");
        let launched = Launched::start(&master, &arguments);
        // The light follows from one object to the next, the way is shown, and the beam is an obstacle.
        let holds = python.wait_for(PATIENCE, "len(set(lit)) > 1 and arrows and len(objects) > 2");
        let seen = python.run("set(lit), len(arrows), len(objects)");
        assert!(holds, "{seen:?} {:?} {:?}", launched.roslaunch.lines(), launched.roslaunch.errors());
        // The object to grasp is green, and in the middle of the image.
        let green = "view.last is not None and any(p[1] > 1.3 * max(p[0], p[2], 1) for p in (view.pixel(u, v) \
                     for u in range(560, 720, 4) for v in range(320, 480, 4)))";
        assert!(python.wait_for(PATIENCE, green));
        image(&master, "/observer/image", &launched);
    }
}
