//! Settings that change while the node runs: dynamic_reconfigure, the service `reload_config`, and the config's file.

use rcs_tests::puppet::Puppet;
use rcs_tests::stand::{config, CameraPub, Stand, CLOUD};
use std::time::Duration;

const CLIENT: &str = "from dynamic_reconfigure.client import Client\n\
     def client(name='CameraPub'): return Client('/camera_stream/' + name, timeout=30)\n\
     def described(c): return {p['name']: p for p in c.get_parameter_descriptions(30)}\n\
     def connections(topic): return sorted(c.id for c in publishers[topic].impl.connections)\n\
     def eye_connections(): return [c.id for s in eye.subscribers for c in s.impl.connections]\n\
     def corner(): return eye.pixel(1, 1)\n";
const BLACK: &str = "(0, 0, 0)";
const BLUE: &str = "(0, 0, 255)";
const RED: &str = "(255, 0, 0)";
const RELOAD: &str = "trigger('/camera_stream/reload_config')";

fn camera() -> CameraPub {
    CameraPub::default()
}

fn blue() -> CameraPub {
    CameraPub { background: "0; 0; 255", ..camera() }
}

/// A node whose picture has a red square in its middle.
fn stand(config: &str, args: &[&str]) -> Stand {
    let stand = Stand::start(config, args).unwrap();
    stand.puppet("latch('/tf_static', tf('map', 'eye'))");
    stand.puppet("latch('/eye/camera_info', info()); latch('/cloud', cloud(0xff0000))");
    stand.puppet(CLIENT);
    stand.puppet("eye = Eye('/view/image')");
    stand.wait_for("eye.middle() == (255, 0, 0)");
    stand
}

#[test]
fn a_cameras_settings_are_offered_as_rqt_reconfigure_and_dynparam_expect_them() {
    let grouped = format!("{{Class: rviz/Group, Name: My sensors, Enabled: true, Displays: [{CLOUD}]}}");
    let stand = stand(&config(&[&grouped], &[camera()]), &["--no-watch"]);
    let listed = stand.puppet("__import__('dynamic_reconfigure').find_reconfigure_services()");
    assert_eq!(listed, "['/camera_stream/CameraPub']");
    stand.puppet("c = client(); told = []; c.set_config_callback(lambda config: told.append(config))");

    let names = "frame_rate background_red background_green background_blue image_encoding near_clip visibility \
                 show_My_sensors show_My_sensors_cloud";
    assert_eq!(stand.puppet("' '.join(p['name'] for p in c.get_parameter_descriptions(30))"), names);
    let bounds = |name: &str| stand.puppet(format!("[described(c)['{name}'][k] for k in ('type', 'min', 'max')]"));
    assert_eq!(bounds("near_clip"), "['double', 0.01, 100.0]");
    assert_eq!(bounds("background_red"), "['int', 0, 255]");
    let choices = "[e['value'] for e in eval(described(c)['image_encoding']['edit_method'])['enum']]";
    assert_eq!(stand.puppet(choices), "['rgb8', 'rgba8', 'bgr8', 'bgra8', 'mono8', 'mono16']");
    let groups = "[(g, len(d['parameters'])) for g, d in c.get_group_descriptions()['groups'].items()]";
    assert_eq!(stand.puppet(groups), "[('Visibility', 2)]");
    let values = "[c.get_configuration(30)[n] for n in ('frame_rate', 'image_encoding', 'near_clip', 'visibility')]";
    assert_eq!(stand.puppet(values), "[-1.0, 'rgb8', 0.01, True]");
    assert_eq!(
        stand.puppet("sorted(rospy.get_param('/camera_stream/CameraPub').items())[0]"),
        "('background_blue', 0)"
    );

    // The next picture has what was set; what is out of bounds is clamped, and told so.
    let answer =
        stand.puppet("c.update_configuration({'background_blue': 999, 'background_green': -1})['background_blue']");
    assert_eq!(answer, "255");
    stand.wait_for(format!("corner() == {BLUE} and eye.middle() == {RED}"));
    stand.wait_for(
        "told[-1]['background_blue'] == 255 and rospy.get_param('/camera_stream/CameraPub/background_blue') == 255",
    );
    // A group that is switched off hides what is in it.
    stand.puppet("c.update_configuration({'show_My_sensors': False})");
    stand.wait_for(format!("eye.middle() == {BLUE}"));
    stand.puppet("c.update_configuration({'show_My_sensors': True, 'show_My_sensors_cloud': False})");
    stand.puppet("eye.forget()");
    stand.wait_for(format!("eye.middle() == {BLUE}"));
    stand.puppet("c.update_configuration({'show_My_sensors_cloud': True})");
    stand.wait_for(format!("eye.middle() == {RED}"));
    // The cloud is 2 m away.
    stand.puppet("c.update_configuration({'near_clip': 2.5})");
    stand.wait_for(format!("eye.middle() == {BLUE}"));
    stand.puppet("c.update_configuration({'near_clip': 0.0, 'image_encoding': 'bgr8'})");
    stand.wait_for("eye.last.encoding == 'bgr8' and eye.middle() == (0, 0, 255)");
    let late = Puppet::start(&stand.master, &["__name:=late"]).unwrap();
    late.run(CLIENT).unwrap();
    assert_eq!(
        late.run("client().get_configuration(30)['near_clip']").unwrap(),
        "0.01",
        "told to those who come later"
    );
    // 0: only when triggered.
    stand.puppet("c.update_configuration({'frame_rate': 0})");
    std::thread::sleep(Duration::from_millis(500));
    stand.puppet("eye.forget()");
    std::thread::sleep(Duration::from_secs(1));
    assert_eq!(stand.puppet("len(eye.images)"), "0");
}

#[test]
fn a_reload_changes_what_differs_and_nothing_else() {
    let stand = stand(&config(&[CLOUD], &[camera()]), &["--no-watch"]);
    stand.puppet("before = connections('/cloud'), connections('/eye/camera_info'), eye_connections()");
    assert_eq!(stand.puppet(RELOAD), "(True, 'nothing changed')");
    // Another display before it, and another background: the latched cloud is not sent again and yet there.
    let grid = "{Class: rviz/Grid, Name: grid, Enabled: true, Reference Frame: elsewhere}";
    stand.rewrite(&config(&[grid, CLOUD], &[blue()]));
    let answer = stand.puppet(RELOAD);
    assert!(answer.starts_with("(True, ") && answer.contains("1 displays kept, 1 added, 0 removed"), "{answer}");
    stand.wait_for(format!("corner() == {BLUE}"));
    stand.puppet("eye.forget()");
    stand.wait_for(format!("eye.middle() == {RED}"));
    // A display with other settings shows the same cloud in them.
    let outside = "eye.pixel(12, 24)";
    assert_eq!(stand.puppet(outside), BLUE);
    stand.rewrite(&config(&[grid, &CLOUD.replace("Size (m): 1", "Size (m): 2")], &[blue()]));
    assert!(stand.puppet(RELOAD).starts_with("(True, "));
    stand.wait_for(format!("{outside} == {RED}"));
    assert_eq!(
        stand.puppet("before == (connections('/cloud'), connections('/eye/camera_info'), eye_connections())"),
        "True"
    );

    // Another topic, image topic and namespace: what was there before is gone, what is new is there.
    let moved = CameraPub { image: "/other/image", namespace: "lamp", ..blue() };
    stand.puppet("latch('/green', cloud(0x00ff00)); other = eye; eye = Eye('/other/image')");
    stand.rewrite(&config(&[&CLOUD.replace("/cloud", "/green")], &[moved]));
    assert!(stand.puppet(RELOAD).starts_with("(True, "));
    stand.wait_for("eye.middle() == (0, 255, 0)");
    let subscribed = stand.master.output("rostopic", &["list", "-s"]).unwrap();
    assert!(subscribed.contains("/green") && !subscribed.contains("/cloud"), "{subscribed}");
    let published = stand.master.output("rostopic", &["list", "-p"]).unwrap();
    assert!(published.contains("/other/image") && !published.contains("/view/image"), "{published}");
    let services = stand.master.output("rosservice", &["list"]).unwrap();
    assert!(services.contains("/lamp/camera_trigger") && !services.contains("\n/camera_trigger"), "{services}");
    assert_eq!(stand.puppet("trigger('/lamp/camera_trigger')[0]"), "True");

    // Another fixed frame, in which the cloud is placed anew.
    let text = config(&[&CLOUD.replace("/cloud", "/green")], &[CameraPub { image: "/other/image", ..camera() }]);
    stand.rewrite(&text.replace("Fixed Frame: map", "Fixed Frame: world"));
    assert!(stand.puppet(RELOAD).starts_with("(True, "));
    stand.wait_for("len(eye.images) > 0");
    stand.puppet("latch('/tf_static', tf('world', 'map', xyz=(1, 2, 3)))");
    stand.wait_for(format!("eye.middle() == (0, 255, 0) and corner() == {BLACK}"));
}

#[test]
fn what_a_user_set_lasts_until_the_file_says_something_else() {
    let stand = stand(&config(&[CLOUD], &[camera()]), &["--no-watch"]);
    stand.puppet("c = client(); c.update_configuration({'background_blue': 255, 'show_cloud': False})");
    stand.wait_for(format!("corner() == {BLUE} and eye.middle() == {BLUE}"));
    // The file switches the cloud's box on (it was on before) and adds a display.
    let grid = "{Class: rviz/Grid, Name: grid, Enabled: true, Reference Frame: elsewhere}";
    stand.rewrite(&config(&[CLOUD, grid], &[camera()]));
    assert!(stand.puppet(RELOAD).starts_with("(True, "));
    stand.wait_for("'show_grid' in c.get_configuration()");
    assert_eq!(
        stand.puppet("c.get_configuration()['background_blue'], c.get_configuration()['show_cloud']"),
        "(255, False)"
    );
    stand.puppet("eye.forget()");
    stand.wait_for(format!("eye.middle() == {BLUE}"));
    // Other values in the file are taken over, and told.
    let green = CameraPub { background: "0; 255; 0", ..camera() };
    stand.rewrite(&config(&[CLOUD, grid], std::slice::from_ref(&green)));
    assert!(stand.puppet(RELOAD).starts_with("(True, "));
    stand.wait_for("eye.middle() == (0, 255, 0) and c.get_configuration()['background_green'] == 255");
    assert_eq!(stand.puppet("c.get_configuration()['show_cloud']"), "False");
    // A second camera comes with parameters of its own and goes with them.
    let second = CameraPub { name: "Second eye", image: "/second/image", namespace: "second", ..camera() };
    stand.rewrite(&config(&[CLOUD, grid], &[green.clone(), second]));
    assert!(stand.puppet(RELOAD).starts_with("(True, "));
    assert_eq!(stand.puppet("client('Second_eye').get_configuration(30)['background_green']"), "0");
    stand.rewrite(&config(&[CLOUD, grid], &[green]));
    assert!(stand.puppet(RELOAD).starts_with("(True, "));
    let listed = stand.puppet("__import__('dynamic_reconfigure').find_reconfigure_services()");
    assert_eq!(listed, "['/camera_stream/CameraPub']");
}

#[test]
fn a_file_that_cannot_be_read_leaves_everything_as_it_is() {
    let stand = stand(&config(&[CLOUD], &[camera()]), &["_watch:=false"]);
    stand.rewrite("Visualization Manager: {Displays: [\n");
    let answer = stand.puppet(RELOAD);
    assert!(answer.starts_with("(False, '") && answer.contains("scene.rviz:2:") && !answer.contains("\\n"), "{answer}");
    stand.rewrite(&config(&[], &[CameraPub { image: "/no name/image", ..camera() }]));
    let answer = stand.puppet(RELOAD);
    assert!(answer.starts_with("(False, ") && answer.contains("no name"), "{answer}");
    stand.puppet("eye.forget()");
    stand.wait_for(format!("eye.middle() == {RED}"));
    // And nobody watches.
    stand.rewrite(&config(&[CLOUD], &[blue()]));
    std::thread::sleep(Duration::from_secs(2));
    assert_eq!(stand.puppet("corner()"), BLACK);
    assert_eq!(stand.log_lines(&["written again"]), 0, "{}", stand.log());
}

#[test]
fn saving_the_file_changes_the_picture() {
    let stand = stand(&config(&[CLOUD], &[camera()]), &[]);
    stand.puppet("before = connections('/cloud'), eye_connections()");
    stand.rewrite(&config(&[CLOUD], &[blue()]));
    stand.wait_for(format!("corner() == {BLUE}"));
    // Half of a file that somebody takes long to write is not taken.
    let green = config(&[CLOUD], &[CameraPub { background: "0; 255; 0", ..camera() }]);
    stand.rewrite(&green[..green.find("Background").unwrap()]);
    stand.wait_for_log("cannot be read, everything stays as it is").unwrap();
    stand.puppet("eye.forget()");
    stand.wait_for(format!("corner() == {BLUE} and eye.middle() == {RED}"));
    stand.rewrite(&green);
    stand.wait_for("corner() == (0, 255, 0)");
    // Many editors write another file and put it in the place of the old one.
    let beside = stand.config_file().with_extension("tmp");
    std::fs::write(&beside, config(&[CLOUD], &[camera()])).unwrap();
    std::fs::rename(&beside, stand.config_file()).unwrap();
    stand.wait_for(format!("corner() == {BLACK} and eye.middle() == {RED}"));
    assert_eq!(stand.puppet("before == (connections('/cloud'), eye_connections())"), "True");
}
