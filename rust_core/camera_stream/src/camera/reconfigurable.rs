//! The settings of a camera that dynamic_reconfigure offers, and their names there.
//!
//! A colour is three integers, for which rqt_reconfigure has sliders; the encoding is an enum; each
//! display and group has a switch, named after its path. As in any dynamic_reconfigure server, a value out of bounds
//! becomes the nearest one within, and an unknown parameter is ignored.

use std::collections::HashSet;

use rcs_messages::dynamic_reconfigure::{
    BoolParameter, Config as Values, ConfigDescription, DoubleParameter, Group, GroupState, IntParameter, StrParameter,
};
use rcs_rviz_config::{CameraPubSettings, Config, Role, Visibility};
use rcs_scene::{Encoding, FAR_CLIP_M};

use crate::control::BLACKOUT;
use crate::outputs::parameter_description::{choice_of, parameter};

const FRAME_RATE: &str = "frame_rate";
const BACKGROUND: [&str; 3] = ["background_red", "background_green", "background_blue"];
pub(super) const ENCODING: &str = "image_encoding";
const NEAR_CLIP: &str = "near_clip";
const VISIBILITY: &str = "visibility";
/// Upper end of the frame rate's slider. A config may have more.
const HIGH_FRAME_RATE_HZ: f64 = 100.0;
const NEAREST_CLIP_M: f64 = 0.01;

/// The settings of a camera that a user may change while it runs.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CameraParameters {
    /// Images per second; below 0 on change, 0 on trigger.
    frame_rate_hz: f64,
    background: [u8; 3],
    encoding: Encoding,
    near_clip_m: f64,
    visibility: Visibility,
}

/// The switch of a display or group.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Switch {
    /// Name of the parameter, unique in a config.
    name: String,
    /// The names of the groups around the display and its own.
    path: Vec<String>,
    description: String,
}

/// A name that is valid in ROS and Python: letters, digits and underscores, a letter first.
pub(super) fn ros_name(name: &str, prefix: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let name: String = name.chars().map(plain).collect();
    if name.starts_with(|c: char| c.is_ascii_alphabetic()) {
        name
    } else {
        format!("{prefix}{name}")
    }
}

/// The name, or the first of `name_2`, `name_3`, … that is free; marks it as used.
pub(super) fn unique(name: String, used: &mut HashSet<String>) -> String {
    let numbered = (2..).map(|number| format!("{name}_{number}"));
    let free = std::iter::once(name.clone()).chain(numbered).find(|name| !used.contains(name)).unwrap_or(name);
    used.insert(free.clone());
    free
}

/// The switches of a config: one for each path of a display that is drawn or of a group, because displays of one path
/// share their tick box.
pub(super) fn switches(config: &Config) -> Vec<Switch> {
    let (mut names, mut paths, mut switches) = (HashSet::new(), HashSet::new(), Vec::new());
    for placed in config.placed_displays() {
        let display = placed.display;
        let role = display.settings.role();
        if !matches!(role, Role::Scene | Role::Group) {
            continue;
        }
        let path: Vec<String> = placed.path.iter().map(|name| (*name).to_owned()).collect();
        if !paths.insert(path.clone()) {
            continue;
        }
        let drawn = match role {
            Role::Group => "the group and all that is in it",
            _ => display.class.as_str(),
        };
        let switched_off = if placed.enabled { "" } else { ", which is disabled in the config" };
        switches.push(Switch {
            name: unique(format!("show_{}", ros_name(&path.join("_"), "")), &mut names),
            description: format!("Show {} ({drawn}){switched_off}", path.join(" / ")),
            path,
        });
    }
    switches
}

/// The shortest decimal number that is the same in single precision: most likely the config's.
fn decimal(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}

fn double(name: &str, value: f64) -> DoubleParameter {
    DoubleParameter { name: name.to_owned(), value }
}

/// The groups of the parameters.
fn groups() -> Vec<GroupState> {
    let group = |name: &str, id| GroupState { name: name.to_owned(), state: true, id, parent: 0 };
    vec![group("Default", 0), group("Visibility", 1)]
}

impl CameraParameters {
    /// The settings of a config's camera.
    pub(super) fn of(settings: &CameraPubSettings) -> Self {
        Self {
            frame_rate_hz: decimal(settings.frame_rate_hz),
            background: settings.background_color,
            encoding: settings.image_encoding,
            near_clip_m: decimal(settings.near_clip_m),
            visibility: settings.visibility.clone(),
        }
    }

    /// Writes them to a camera's settings.
    pub(super) fn write_to(&self, settings: &mut CameraPubSettings) {
        settings.frame_rate_hz = self.frame_rate_hz as f32;
        settings.background_color = self.background;
        settings.image_encoding = self.encoding;
        settings.near_clip_m = self.near_clip_m as f32;
        settings.visibility = self.visibility.clone();
    }

    /// Merges changes of a file: its new value wherever the two states differ.
    pub(super) fn with_changes(&self, before: &Self, after: &Self) -> Self {
        fn pick<T: PartialEq + Clone>(own: &T, before: &T, after: &T) -> T {
            if before == after { own } else { after }.clone()
        }
        Self {
            frame_rate_hz: pick(&self.frame_rate_hz, &before.frame_rate_hz, &after.frame_rate_hz),
            background: pick(&self.background, &before.background, &after.background),
            encoding: pick(&self.encoding, &before.encoding, &after.encoding),
            near_clip_m: pick(&self.near_clip_m, &before.near_clip_m, &after.near_clip_m),
            visibility: self.visibility.with_changes(&before.visibility, &after.visibility),
        }
    }

    /// `true` if a switch is on.
    pub(super) fn is_on(&self, switch: &Switch) -> bool {
        self.visibility.is_ticked(&switch.path())
    }

    /// Resets the switches of removed displays to the file's values.
    pub(super) fn forget<'s>(&mut self, gone: impl Iterator<Item = &'s Switch>, in_file: &Self) {
        for switch in gone {
            let path = switch.path();
            self.visibility.set(&path, in_file.visibility.is_ticked(&path));
        }
    }

    /// Applies the values of a request, clamped to the bounds of a description. Returns an unknown encoding.
    pub(super) fn set<'r>(
        &mut self,
        request: &'r Values,
        switches: &[Switch],
        bounds: &ConfigDescription,
    ) -> Option<&'r str> {
        for DoubleParameter { name, value } in request.doubles.iter().filter(|param| !param.value.is_nan()) {
            let own = match name.as_str() {
                FRAME_RATE => &mut self.frame_rate_hz,
                NEAR_CLIP => &mut self.near_clip_m,
                _ => continue,
            };
            let bound = |of: &Values| of.doubles.iter().find(|bound| bound.name == *name).map(|bound| bound.value);
            let (least, most) = (bound(&bounds.min).unwrap_or(*value), bound(&bounds.max).unwrap_or(*value));
            *own = value.min(most).max(least);
        }
        for IntParameter { name, value } in &request.ints {
            if let Some(index) = BACKGROUND.iter().position(|known| known == name) {
                self.background[index] = (*value).clamp(0, 255) as u8;
            }
        }
        let mut unknown = None;
        for StrParameter { value, .. } in request.strs.iter().filter(|param| param.name == ENCODING) {
            match Encoding::from_name(value) {
                Some(encoding) => self.encoding = encoding,
                None => unknown = Some(value.as_str()),
            }
        }
        for BoolParameter { name, value } in &request.bools {
            if name == VISIBILITY {
                self.visibility.set(&[], *value);
            } else if let Some(switch) = switches.iter().find(|switch| switch.name == *name) {
                self.visibility.set(&switch.path(), *value);
            }
        }
        unknown
    }

    /// The values of all parameters. `is_black`: the camera's own blackout is on, which is no setting of its images.
    pub(super) fn values(&self, switches: &[Switch], is_black: bool) -> Values {
        let switch = |switch: &Switch| BoolParameter {
            name: switch.name.clone(),
            value: self.visibility.is_ticked(&switch.path()),
        };
        let blackout = BoolParameter { name: BLACKOUT.to_owned(), value: is_black };
        let all = BoolParameter { name: VISIBILITY.to_owned(), value: self.visibility.is_ticked(&[]) };
        let channel = |(name, value): (&&str, &u8)| IntParameter { name: (*name).to_owned(), value: (*value).into() };
        Values {
            bools: [blackout, all].into_iter().chain(switches.iter().map(switch)).collect(),
            ints: BACKGROUND.iter().zip(&self.background).map(channel).collect(),
            strs: vec![StrParameter { name: ENCODING.to_owned(), value: self.encoding.name().to_owned() }],
            doubles: vec![double(FRAME_RATE, self.frame_rate_hz), double(NEAR_CLIP, self.near_clip_m)],
            groups: groups(),
        }
    }

    /// The parameters with their bounds; these values are the defaults.
    pub(super) fn description(&self, switches: &[Switch]) -> ConfigDescription {
        // The smallest or the largest of all values.
        let bounds = |value: bool, channel: i32, frame_rate_hz: f64, near_clip_m: f64| {
            let mut values = self.values(switches, false);
            values.bools.iter_mut().for_each(|param| param.value = value);
            values.ints.iter_mut().for_each(|param| param.value = channel);
            values.strs.iter_mut().for_each(|param| param.value.clear());
            values.doubles = vec![double(FRAME_RATE, frame_rate_hz), double(NEAR_CLIP, near_clip_m)];
            values
        };
        let plain = |name, kind, description| parameter(name, kind, description, String::new());
        let rate = "Pictures a second; below 0: when the scene changes, 0: only when triggered";
        let colors = ["red", "green", "blue"].map(|color| format!("Background: {color}"));
        let mut parameters = vec![plain(BLACKOUT, "bool", "Black out the picture"), plain(FRAME_RATE, "double", rate)];
        parameters.extend(BACKGROUND.iter().zip(&colors).map(|(name, text)| plain(name, "int", text)));
        let (pixel, encodings) = ("What a pixel of the picture is", Encoding::ALL.map(Encoding::name));
        parameters.push(parameter(ENCODING, "str", pixel, choice_of(pixel, encodings)));
        parameters.push(plain(NEAR_CLIP, "double", "Nearer than this nothing is drawn, in metres"));
        parameters.push(plain(VISIBILITY, "bool", "Whether the camera shows any display"));
        let shown = switches.iter().map(|switch| plain(&switch.name, "bool", &switch.description)).collect();
        let group = |name: &str, id, parameters| Group { name: name.to_owned(), parameters, id, ..Group::default() };
        ConfigDescription {
            groups: vec![group("Default", 0, parameters), group("Visibility", 1, shown)],
            max: bounds(true, 255, HIGH_FRAME_RATE_HZ.max(self.frame_rate_hz), FAR_CLIP_M.max(self.near_clip_m)),
            min: bounds(false, 0, -1.0, NEAREST_CLIP_M),
            dflt: self.values(switches, false),
        }
    }
}

impl Switch {
    /// `true` if both have the same path.
    pub(super) fn is_of_same_display(&self, other: &Self) -> bool {
        self.path == other.path
    }

    /// The display's path and the parameter's name.
    pub(super) fn path_and_name(&self) -> (&[String], &str) {
        (&self.path, &self.name)
    }

    fn path(&self) -> Vec<&str> {
        self.path.iter().map(String::as_str).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn config(displays: &str) -> Config {
        let text = format!("Visualization Manager:\n  Displays: [{displays}]\n");
        rcs_rviz_config::parse(&text, "test").unwrap()
    }

    #[test]
    fn every_display_and_group_has_a_switch_with_a_unique_name() {
        let grid = |name: &str| format!("{{Class: rviz/Grid, Name: {name}, Enabled: true}}");
        let group =
            format!("{{Class: rviz/Group, Name: g, Enabled: true, Displays: [{}, {}]}}", grid("a b"), grid("a_b"));
        let others = "{Class: rviz_camera_stream/CameraPub, Name: eye, Enabled: true}, {Class: x/Unknown, Name: no}";
        let config = config(&[&grid("1"), &group, &grid("1"), &grid("g_a b"), others].map(String::from).join(", "));
        let switches = switches(&config);
        let names: Vec<&str> = switches.iter().map(|switch| switch.name.as_str()).collect();
        assert_eq!(names, ["show_1", "show_g", "show_g_a_b", "show_g_a_b_2", "show_g_a_b_3"]);
        let mut parameters = CameraParameters::of(&CameraPubSettings::default());
        let off = BoolParameter { name: "show_g_a_b_2".to_owned(), value: false };
        let request = Values { bools: vec![off], ..Values::default() };
        parameters.set(&request, &switches, &parameters.description(&switches));
        assert!(!parameters.visibility.shows(&["g", "a_b"]) && parameters.visibility.shows(&["g", "a b"]));
        let off = parameters.values(&switches, true).bools.into_iter().filter(|param| !param.value);
        let off: Vec<String> = off.map(|param| param.name).collect();
        assert_eq!(off, ["show_g_a_b_2"]);
    }

    #[test]
    fn values_out_of_bounds_become_the_nearest_ones_and_nonsense_is_ignored() {
        let mut parameters = CameraParameters::of(&CameraPubSettings::default());
        let bounds = parameters.description(&[]);
        let text = |value: &str| vec![StrParameter { name: ENCODING.to_owned(), value: value.to_owned() }];
        let request = Values {
            doubles: vec![double(FRAME_RATE, -7.0), double(NEAR_CLIP, f64::INFINITY), double("other", 1.0)],
            ints: vec![IntParameter { name: BACKGROUND[1].to_owned(), value: 300 }],
            strs: text("mono8"),
            ..Values::default()
        };
        parameters.set(&request, &[], &bounds);
        let expected = CameraParameters {
            frame_rate_hz: -1.0,
            near_clip_m: FAR_CLIP_M,
            background: [0, 255, 0],
            encoding: Encoding::Mono8,
            ..CameraParameters::of(&CameraPubSettings::default())
        };
        assert_eq!(parameters, expected);
        let nonsense =
            Values { doubles: vec![double(FRAME_RATE, f64::NAN)], strs: text("voodoo"), ..Values::default() };
        parameters.set(&nonsense, &[], &bounds);
        assert_eq!(parameters, expected);
    }

    #[test]
    fn a_users_values_are_replaced_only_where_the_file_changed() {
        let before = CameraParameters::of(&CameraPubSettings::default());
        let own = CameraParameters { background: [1, 2, 3], near_clip_m: 0.5, ..before.clone() };
        let after = CameraParameters { near_clip_m: 0.2, encoding: Encoding::Bgr8, ..before.clone() };
        let merged = own.with_changes(&before, &after);
        let expected = CameraParameters { background: [1, 2, 3], near_clip_m: 0.2, encoding: Encoding::Bgr8, ..before };
        assert_eq!(merged, expected);
    }

    #[test]
    fn a_display_that_is_gone_takes_its_switch_along() {
        let grid = |name: &str| format!("{{Class: rviz/Grid, Name: {name}, Enabled: true}}");
        let all = switches(&config(&[grid("a"), grid("b")].join(", ")));
        let in_file = CameraParameters::of(&CameraPubSettings::default());
        let mut own = in_file.clone();
        own.visibility.set(&["a"], false);
        own.visibility.set(&["b"], false);
        own.forget(all.iter().filter(|switch| switch.path == ["a"]), &in_file);
        assert!(own.visibility.shows(&["a"]) && !own.visibility.shows(&["b"]));
    }

    #[test]
    fn a_configs_numbers_are_reported_as_they_are_written() {
        let settings = CameraPubSettings { near_clip_m: 0.01, frame_rate_hz: 144.1, ..CameraPubSettings::default() };
        let parameters = CameraParameters::of(&settings);
        assert_eq!(parameters.values(&[], false).doubles, [double(FRAME_RATE, 144.1), double(NEAR_CLIP, 0.01)]);
        let most = &parameters.description(&[]).max.doubles[0];
        assert_eq!(most.value, 144.1, "the file's value is within bounds");
        let mut written = CameraPubSettings::default();
        parameters.write_to(&mut written);
        assert_eq!(written, settings);
    }

    #[test]
    fn names_are_valid_in_ros() {
        assert_eq!(ros_name("Camera Pub/2 é", "camera_"), "Camera_Pub_2__");
        assert_eq!(ros_name("2nd", "camera_"), "camera_2nd");
        assert_eq!(ros_name("", "camera_"), "camera_");
        let mut used = HashSet::new();
        let names: Vec<String> = (0..3).map(|_| unique("a".to_owned(), &mut used)).collect();
        assert_eq!(names, ["a", "a_2", "a_3"]);
    }
}
