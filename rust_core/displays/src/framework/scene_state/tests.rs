//! Displays come, stay and go with a config that is read again.

use super::*;
use rcs_messages::geometry_msgs::TransformStamped;
use rcs_messages::nav_msgs::Path;
use rcs_messages::sensor_msgs::PointField;
use rcs_messages::PointCloud2;
use rcs_resources::PackageIndex;

use crate::framework::display::Display;
use crate::{Level, Statuses};

/// Drawables of each display that a camera with these tick boxes shows, in the scene's order.
fn shown(set: &SceneState, mask: &DisplayMask) -> Vec<DisplayId> {
    let scene = set.scene();
    scene.drawables.iter().map(|drawable| drawable.display).filter(|id| mask.shows(*id)).collect()
}

fn config(displays: &str) -> Config {
    let text = format!("Visualization Manager:\n  Displays:\n{displays}  Global Options: {{Fixed Frame: map}}\n");
    rcs_rviz_config::parse(&text, "test").unwrap()
}

const PATH: &str = "  - {Class: rviz/Path, Name: path, Enabled: true, Topic: /p}\n";
const RED_PATH: &str = "  - {Class: rviz/Path, Name: path, Enabled: true, Topic: /p, Color: 255; 0; 0}\n";
const GRID: &str = "  - {Class: rviz/Grid, Name: grid, Enabled: true}\n";
const CAMERA: &str = "  - {Class: rviz_camera_stream/CameraPub, Name: eye, Enabled: true, Image Topic: /i, \
     Visibility: {Value: true, grid: false}}\n";

/// A path of two poses on `/p`, in the fixed frame.
fn path() -> AnyMessage {
    let mut path = Path { poses: vec![Default::default(); 2], ..Path::default() };
    path.header.frame_id = "map".to_owned();
    for (x, pose) in path.poses.iter_mut().enumerate() {
        pose.pose.position.x = x as f64;
        pose.pose.orientation.w = 1.0;
    }
    AnyMessage::Path(Arc::new(path))
}

/// A cloud in the fixed frame, of floats by the names of their fields.
fn cloud(names: &[&str], values: &[f32]) -> AnyMessage {
    let mut cloud = PointCloud2::default();
    cloud.header.frame_id = "map".to_owned();
    let field = |(index, name): (usize, &&str)| PointField {
        name: (*name).to_owned(),
        offset: index as u32 * 4,
        datatype: PointField::FLOAT32,
        count: 1,
    };
    cloud.fields = names.iter().enumerate().map(field).collect();
    let point_step = names.len() as u32 * 4;
    (cloud.height, cloud.width) = (1, (values.len() / names.len()) as u32);
    (cloud.point_step, cloud.row_step) = (point_step, cloud.width * point_step);
    cloud.set_data(values.iter().flat_map(|value| value.to_le_bytes()).collect());
    AnyMessage::PointCloud2(Arc::new(cloud))
}

const NOW: Time = Time::from_secs_nanos(10, 0);

fn without_messages(config: &Config) -> SceneState {
    SceneState::new(config, None, MeshStore::new(PackageIndex::new([])))
}

/// The state of a config that has received a path.
fn state(first: &str) -> SceneState {
    let mut set = without_messages(&config(first));
    set.take("/p", &path(), NOW);
    set.update(NOW);
    set
}

#[test]
fn a_display_that_stays_keeps_what_it_shows_wherever_it_is_listed() {
    let mut set = state(&format!("{PATH}{CAMERA}"));
    let changed = set.reconfigure(&config(&format!("{GRID}{CAMERA}{PATH}")), None, NOW);
    assert_eq!(changed, Reconfigured { kept: 1, added: 1, removed: 0 });
    // Before the next update, so nothing was placed again.
    let everything = DisplayMask::all();
    let paths = shown(&set, &everything);
    assert_eq!(paths.len(), 1);
    set.update(NOW);
    let mask = &set.cameras()[0].visible;
    assert_eq!(shown(&set, mask), paths, "the camera hides the grid, whatever number it has");
    assert!(shown(&set, &everything).len() > 1);
    assert_eq!(shown(&set, &everything).last(), paths.last(), "in the new order");
}

#[test]
fn a_display_with_other_settings_shows_the_last_message_in_them() {
    let mut set = state(&format!("{PATH}{GRID}"));
    let changed = set.reconfigure(&config(&format!("{RED_PATH}{GRID}")), None, NOW);
    assert_eq!(changed, Reconfigured { kept: 1, added: 1, removed: 1 });
    set.update(NOW);
    assert!(!shown(&set, &set.mask(&hiding("grid"))).is_empty());
}

/// Tick boxes that hide one display.
fn hiding(hidden: &str) -> Visibility {
    let mut visibility = Visibility::default();
    visibility.set(&[hidden], false);
    visibility
}

#[test]
fn a_display_that_was_switched_off_gets_no_message_from_before() {
    let mut set = state(PATH);
    let off = PATH.replace("true", "false");
    assert_eq!(set.reconfigure(&config(&off), None, NOW), Reconfigured { kept: 0, added: 0, removed: 1 });
    assert!(set.topics().is_empty());
    assert_eq!(set.reconfigure(&config(PATH), None, NOW), Reconfigured { kept: 0, added: 1, removed: 0 });
    set.update(NOW);
    assert!(shown(&set, &DisplayMask::all()).is_empty(), "it gets the messages from now on");
    assert_eq!(set.topics()[0].kind, MessageKind::Path);
}

/// rviz shows Axes to every camera, whatever its tick boxes.
#[test]
fn axes_are_hidden_by_their_tick_box() {
    let axes = "  - {Class: rviz/Axes, Name: axes, Enabled: true}\n";
    let set = state(&format!("{axes}{GRID}"));
    let with_axes = shown(&set, &DisplayMask::all());
    let without = shown(&set, &set.mask(&hiding("axes")));
    assert!(without.len() < with_axes.len() && !without.is_empty(), "{without:?} of {with_axes:?}");
    assert_eq!(shown(&set, &set.mask(&hiding("grid"))).len(), with_axes.len() - without.len());
}

#[test]
fn a_display_is_told_when_the_publisher_of_its_topic_is_gone() {
    let markers = "  - {Class: rviz/InteractiveMarkers, Name: im, Enabled: true, Update Topic: /im/update}\n";
    let mut set = without_messages(&config(markers));
    let is_offline = |set: &SceneState| {
        let report = set.reports().next().unwrap();
        report.statuses.get("General").is_some_and(|status| status.text == "Server is offline. Resetting.")
    };
    set.publisher_left("/others/update");
    assert!(!is_offline(&set));
    set.publisher_left("/im/update");
    assert!(is_offline(&set));
}

#[test]
fn points_that_are_left_out_are_counted_in_the_status() {
    let flat = "  - {Class: rviz/PointCloud2, Name: cloud, Enabled: true, Topic: /c, Color Transformer: FlatColor}\n";
    let mut set = state(flat);
    let values = [0.0_f32, 0.0, 1.0, f32::NAN, 0.0, 1.0, 0.0, f32::INFINITY, 1.0];
    let points = cloud(&["x", "y", "z"], &values);
    set.take("/c", &points, NOW);
    set.update(NOW);
    let report = set.reports().next().unwrap();
    let status = report.statuses.get("Points").map(|status| (status.level, status.text.as_str()));
    assert_eq!(status, Some((Level::Ok, "Showing 1 points, 2 without a finite position left out")));
}

/// As in rviz, where it changes the display's property.
#[test]
fn a_message_without_the_fields_of_its_color_transformer_changes_that_and_a_status_reports_it() {
    let rgb = "  - {Class: rviz/PointCloud2, Name: cloud, Enabled: true, Topic: /c, Color Transformer: RGB8}\n";
    let mut set = state(rgb);
    let mut status_after = |names: &[&str], values: &[f32]| {
        set.take("/c", &cloud(names, values), NOW);
        set.update(NOW);
        let report = set.reports().next().unwrap();
        report.statuses.get("Color Transformer").map(|status| (status.level, status.text.clone()))
    };
    assert_eq!(status_after(&["x", "y", "z", "rgb"], &[0.0; 4]), None);
    let text = "RGB8 does not fit the fields of a message. Intensity is used from then on, as by rviz.";
    let changed = Some((Level::Warn, text.to_owned()));
    assert_eq!(status_after(&["x", "y", "z"], &[0.0; 3]), changed);
    assert_eq!(status_after(&["x", "y", "z", "rgb"], &[0.0; 4]), changed);
}

#[test]
fn a_message_counts_as_shown_from_when_its_frame_is_known() {
    let mut set = without_messages(&config(&format!("{PATH}{GRID}")));
    let AnyMessage::Path(path) = path() else { return };
    let mut path = Arc::unwrap_or_clone(path);
    (path.header.frame_id, path.header.stamp.sec) = ("arm".to_owned(), 7);
    let (message, received) = (AnyMessage::Path(Arc::new(path)), Some(Instant::now()));
    let newly_shown = |set: &mut SceneState| {
        set.update(NOW);
        (set.newly_shown().to_vec(), set.reports().next().unwrap().shown)
    };
    set.take_received("/p", &message, received, NOW);
    assert_eq!(newly_shown(&mut set), (Vec::new(), None));
    let mut place = TransformStamped::default();
    (place.header.frame_id, place.child_frame_id, place.header.stamp.sec) = ("map".to_owned(), "arm".to_owned(), 7);
    place.transform.rotation.w = 1.0;
    set.take_transforms(&TFMessage { transforms: vec![place] }, true, "/a");
    let shown = ShownMessage { stamp: Time::from_secs_nanos(7, 0), received };
    assert_eq!(newly_shown(&mut set), (vec![(0, shown)], Some(shown)));
    assert_eq!(newly_shown(&mut set), (Vec::new(), Some(shown)), "reported once");
}

#[test]
fn a_camera_sees_the_changes_of_the_displays_that_it_shows() {
    let mut set = state(&format!("{PATH}{GRID}"));
    let (all, without_path) = (DisplayMask::all(), set.mask(&hiding("path")));
    let before = (set.version(), set.version_shown(&all), set.version_shown(&without_path));
    set.update(NOW);
    let unchanged = (set.version(), set.version_shown(&all), set.version_shown(&without_path));
    assert_eq!(unchanged, before);
    set.take("/p", &path(), NOW);
    assert!(set.update(NOW));
    assert!(set.version_shown(&all) > before.1);
    assert_eq!(set.version_shown(&without_path), before.2);
    set.reset();
    assert!(set.version_shown(&without_path) > before.2, "time jumped back for all");
}

#[test]
fn equal_displays_are_kept_one_for_one() {
    let mut set = state(&format!("{GRID}{GRID}"));
    let changed = set.reconfigure(&config(&format!("{GRID}{GRID}{GRID}")), None, NOW);
    assert_eq!(changed, Reconfigured { kept: 2, added: 1, removed: 0 });
    let ids: HashSet<DisplayId> = set.entries.iter().map(|entry| entry.id).collect();
    assert_eq!(ids.len(), 3);
}

/// Panics with each message.
#[derive(Default)]
struct Panicking(Statuses);

impl Display for Panicking {
    fn topics(&self) -> Vec<TopicRequest> {
        TopicRequest::new("/p", MessageKind::Path, 1).into_iter().collect()
    }

    fn take(&mut self, _message: &AnyMessage, _world: &World<'_>) {
        panic!("a test's panic");
    }

    fn update(&mut self, _world: &World<'_>) -> bool {
        false
    }

    fn drawables(&self) -> &[rcs_scene::Drawable] {
        &[]
    }

    fn statuses(&self) -> &Statuses {
        &self.0
    }
}

#[test]
fn a_display_that_panics_harms_no_other_and_is_made_again_with_the_config() {
    let displays = format!("{PATH}{GRID}");
    let mut set = state(&displays);
    let DisplayEntry { id, listed, settings, .. } = set.entries.remove(0);
    let panicking = DisplayEntry::new(id, listed, settings, |_, _| Some(Box::<Panicking>::default())).unwrap();
    set.entries.insert(0, panicking);
    let ids = [set.entries[0].id, set.entries[1].id];
    // The second one switches it off.
    (0..2).for_each(|_| set.take("/p", &path(), NOW));
    assert!(set.update(NOW) && !set.update(NOW));
    assert_eq!(shown(&set, &DisplayMask::all()), [ids[1]]);
    let status = |set: &SceneState| set.reports().next().unwrap().statuses.get(Statuses::FAULT).cloned();
    assert_eq!(status(&set).map(|status| status.level), Some(Level::Error));

    assert_eq!(set.reconfigure(&config(&displays), None, NOW), Reconfigured { kept: 1, added: 1, removed: 1 });
    set.update(NOW);
    let path = set.entries[0].id;
    assert_eq!((shown(&set, &DisplayMask::all()), status(&set)), (vec![path, ids[1]], None));
}
