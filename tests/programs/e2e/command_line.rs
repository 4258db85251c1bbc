//! Remappings and private parameters on the command line, and rviz's arguments.

use rcs_tests::ros::{wait_until, RosMaster, Running, PATIENCE};
use rcs_tests::ros_fixture::{config, CameraPub, Setup, CLOUD};

#[test]
fn topics_and_the_nodes_name_and_namespace_are_remapped() {
    let camera = CameraPub { image: "view/image", namespace: "lamp", ..CameraPub::default() };
    let args = ["/cloud:=/other", "__name:=projector_eye", "__ns:=/robot", "/eye/camera_info:=/lens/camera_info"];
    let fixture = Setup::with_cameras(&[CLOUD], &[camera]).args(&args).start();
    fixture.python("latch('/tf_static', tf('map', 'eye'))");
    fixture.python("latch('/lens/camera_info', info()); latch('/cloud', cloud(0x0000ff))");
    fixture.python("latch('/other', cloud(0xff0000)); viewer = Viewer('/robot/lamp/view/image')");
    fixture.wait_for("viewer.middle() == (255, 0, 0)");
    assert_eq!(
        fixture.python("trigger('/robot/lamp/camera_trigger')"),
        "(True, 'New image will be published on: /robot/lamp/view/image')"
    );
    let nodes = fixture.master.output("rosnode", &["list"]).unwrap();
    assert!(nodes.lines().any(|node| node == "/robot/projector_eye"), "{nodes}");
    assert_eq!(fixture.python("{i[6] for i in viewer.infos}"), "{'/robot/projector_eye'}");
}

#[test]
fn an_image_topic_is_remapped_and_the_trigger_answers_with_its_new_name() {
    let fixture = Setup::of(&[CLOUD]).args(&["/view/image:=/wall/picture"]).start();
    fixture.python("place_camera(); latch('/cloud', cloud(0xff0000)); viewer = Viewer('/wall/picture')");
    fixture.wait_for("viewer.middle() == (255, 0, 0)");
    let answer = "(True, 'New image will be published on: /wall/picture')";
    assert_eq!(fixture.python("trigger('/camera_trigger')"), answer);
}

#[test]
fn the_renderer_is_chosen_by_a_private_parameter() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.rviz");
    std::fs::write(&file, config(&[], &[CameraPub::default()])).unwrap();
    let master = RosMaster::start().unwrap();
    let start = |name: &str, args: &[&str]| {
        Running::start(master.program("camera_stream").arg("-d").arg(&file).arg(format!("__name:={name}")).args(args))
            .unwrap()
    };
    let cpu = start("first", &["_renderer:=cpu"]);
    cpu.wait_for_error(&["with cpu"]);
    let mut unknown = start("second", &["_renderer:=voodoo"]);
    assert_eq!(unknown.wait(PATIENCE).unwrap().code(), Some(1));
    unknown.wait_for_error(&["voodoo"]);
    assert_eq!(unknown.errors().len(), 1, "{:?}", unknown.errors());
    // The command line overrides the parameter.
    let both = start("third", &["_renderer:=voodoo", "--renderer", "cpu"]);
    both.wait_for_error(&["with cpu"]);
}

#[test]
fn a_parameter_that_cannot_be_used_ends_the_node_with_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.rviz");
    let other = CameraPub { name: "Other", image: "/other", ..CameraPub::default() };
    std::fs::write(&file, config(&[], &[CameraPub::default(), other])).unwrap();
    let master = RosMaster::start().unwrap();
    let start = |args: &[&str]| {
        Running::start(master.program("camera_stream").args(["--renderer", "cpu", "-d"]).arg(&file).args(args)).unwrap()
    };
    let wrong = [
        "_lazy:=maybe",
        "_lazy:={a: 1}",
        "_watch:=7",
        "_set_mode:=often",
        "_undistort:={a: true}",
        "_stale_timeout:={a: 1}",
        "_max_mesh_mb:=[1, 2]",
        "_mesh_folder:={a: 3}",
        "_window:={a: b}",
        "_mask_topic:=[{a: b}]",
        "_keep_out:=head=0.3 hand=0.2",
        "_orientation:=CameraPub=90 Other=180",
        "_stale_timeout:=never",
        "_predict:=off",
    ];
    for (index, argument) in wrong.iter().enumerate() {
        // The master keeps the parameters of a name.
        let mut node = start(&[argument, &format!("__name:=node_{index}")]);
        assert_eq!(node.wait(PATIENCE).unwrap().code(), Some(1), "{argument}");
        let name = format!(" for ~{}: ", argument[1..].split(":=").next().unwrap());
        let errors = node.errors();
        assert!(errors.last().is_some_and(|line| line.contains(&name)), "{argument}: {errors:?}");
    }
    // A list has one value for each of its elements.
    let lists = ["_orientation:=[{camera: CameraPub, orientation: 90}, Other=180]", "_mesh_folder:=[/a, /b]"];
    let node = start(&[lists[0], lists[1], "_lazy:=False", "__name:=lists"]);
    node.wait_for_error(&["drawing CameraPub, Other"]);
}

#[test]
fn a_robot_description_that_is_remapped_to_a_whole_name_is_read_there_alone() {
    let robot = "{Class: rviz/RobotModel, Name: robot, Enabled: true, Robot Description: robot_description}";
    let args = ["robot_description:=/r1/robot_description"];
    let fixture = Setup::of(&[robot]).args(&args).start();
    let description = |color: &str| {
        format!(
            "'<robot name=\"r\"><link name=\"map\"><visual><origin xyz=\"0 0 2\"/><geometry><box size=\"9 9 0.1\"/></geometry><material \
             name=\"m\"><color rgba=\"{color} 1\"/></material></visual></link></robot>'"
        )
    };
    fixture.python(format!("rospy.set_param('/robot_description', {})", description("0 1 0")));
    // From above, where the view's light comes from.
    fixture.python("latch('/tf_static', tf('map', 'eye', (0, 0, 4), (1, 0, 0, 0)))");
    fixture.python("latch('/eye/camera_info', info()); viewer = Viewer('/view/image')");
    let is_missing = || fixture.log().contains("Parameter [robot_description] does not exist");
    assert!(wait_until(PATIENCE, is_missing), "{}", fixture.log());
    fixture.python(format!("rospy.set_param('/r1/robot_description', {})", description("1 0 0")));
    fixture.wait_for("viewer.middle()[0] > 50 and viewer.middle()[1] == 0");
}

/// Memory in use in MB, and the number of threads.
fn footprint(node: &Running) -> (f64, u32) {
    let status = std::fs::read_to_string(format!("/proc/{}/status", node.id())).unwrap();
    let figure = |key: &str| {
        let line = status.lines().find_map(|line| line.strip_prefix(key)).unwrap();
        line.split_whitespace().next().unwrap().parse::<u32>().unwrap()
    };
    (f64::from(figure("VmRSS:")) / 1024.0, figure("Threads:"))
}

/// Drivers that are loaded only to find no GPU stay in memory, with their threads.
#[test]
#[ignore = "a figure of memory: ./test full"]
fn without_a_gpu_auto_needs_no_more_memory_and_threads_than_cpu() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.rviz");
    std::fs::write(&file, config(&[CLOUD], &[CameraPub::default()])).unwrap();
    let master = RosMaster::start().unwrap();
    let measure = |renderer: &str| {
        let mut command = master.program("camera_stream");
        let args = ["--renderer", renderer, &format!("__name:={renderer}")];
        let node = Running::start(command.arg("-d").arg(&file).args(args)).unwrap();
        let drawing = || node.errors().iter().find(|line| line.contains("drawing ")).cloned();
        assert!(wait_until(PATIENCE, || drawing().is_some()), "{:?}", node.errors());
        (drawing().unwrap(), footprint(&node))
    };
    let (_, (cpu_mb, cpu_threads)) = measure("cpu");
    let (log, (auto_mb, auto_threads)) = measure("auto");
    println!("cpu: {cpu_mb:.1} MB, {cpu_threads} threads; auto: {auto_mb:.1} MB, {auto_threads} threads ({log})");
    if log.contains("with cpu") {
        assert!(auto_mb < cpu_mb + 8.0, "{auto_mb} MB, with cpu {cpu_mb} MB");
        assert!(auto_threads <= cpu_threads + 1, "{auto_threads} threads, with cpu {cpu_threads}");
    }
}

#[test]
fn the_arguments_that_launch_files_give_rviz_are_accepted() {
    let args = "--splash-screen= --help-file h --no-stereo --fullscreen --in-mc-wrapper --disable-anti-aliasing -l -v \
                --opengl 3 __log:=/dev/null -f /world _tf_prefix:=r1 _stale_timeuot:=1";
    let args: Vec<&str> = args.split_whitespace().chain(["_manipulator:={kinematics_solver: kdl}"]).collect();
    let fixture = Setup::of(&[CLOUD]).args(&args).start();
    fixture.python("latch('/tf_static', tf('world', 'eye'))");
    fixture.python("latch('/eye/camera_info', info()); latch('/cloud', cloud(0xff0000, 'world'))");
    fixture.python("viewer = Viewer('/view/image')");
    fixture.wait_for("viewer.middle() == (255, 0, 0)");
    // Parameters that other packages' launch files set below rviz cause no warning.
    assert_eq!(fixture.log_lines(&["did you mean"]), 1, "{}", fixture.log());
    assert_eq!(fixture.log_lines(&["~stale_timeuot; did you mean ~stale_timeout?"]), 1, "{}", fixture.log());
}

#[test]
fn a_camera_that_is_called_like_an_option_has_its_parameters_elsewhere() {
    let camera = CameraPub { name: "mask", ..CameraPub::default() };
    let fixture = Setup::with_cameras(&[CLOUD], &[camera]).args(&["_mask:=none"]).start();
    fixture.wait_for_log("drawing mask").unwrap();
    let services = fixture.master.output("rosservice", &["list"]).unwrap();
    assert!(services.contains("/camera_stream/camera_mask/set_parameters"), "{services}");
    assert_eq!(fixture.master.output("rosparam", &["get", "/camera_stream/mask"]).unwrap().trim(), "none");
}
