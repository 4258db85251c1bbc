//! The settings of a camera that dynamic_reconfigure offers, and their names there.
//!
//! A colour is three integers, for which rqt_reconfigure has sliders; the encoding is an enum; each
//! display and group has a switch, named after its path.

use std::collections::HashSet;

use rcs_ros::settings::{NamedValues, Setting, SettingGroup};
use rcs_ros::ParameterValue;
use rcs_rviz_config::{CameraPubSettings, Config, Role, Visibility};
use rcs_scene::{Encoding, FAR_CLIP_M};

use crate::control::BLACKOUT;
use crate::scene::status_tree::path_text;

const FRAME_RATE: &str = "frame_rate";
const BACKGROUND: [&str; 3] = ["background_red", "background_green", "background_blue"];
const ENCODING: &str = "image_encoding";
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

/// The switches of displays, without those of groups.
pub(super) fn displays(switches: &[Switch]) -> impl Iterator<Item = &Switch> {
    switches.iter().filter(|switch| !switches.iter().any(|other| switch.is_around(other)))
}

/// The values that show these displays, by their paths, and hide all others.
///
/// # Errors
/// A display that there is not.
pub(super) fn values_showing(switches: &[Switch], shown: &[String]) -> Result<NamedValues, String> {
    let listed = |switch: &Switch| shown.contains(&switch.text());
    if let Some(unknown) = shown.iter().find(|text| !displays(switches).any(|switch| switch.text() == **text)) {
        return Err(format!("the config has no display '{unknown}'"));
    }
    let value = |switch: &Switch| {
        let is_on =
            displays(switches).any(|display| listed(display) && (switch.is_around(display) || switch == display));
        (switch.name.clone(), is_on.into())
    };
    let all = (VISIBILITY.to_owned(), (!shown.is_empty()).into());
    Ok(switches.iter().map(value).chain([all]).collect())
}

/// The shortest decimal number that is the same in single precision: most likely the config's.
fn decimal(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
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

    /// Takes a value that the table below has accepted; one of an unknown name is ignored.
    ///
    /// # Errors
    /// The name of an unknown encoding.
    pub(super) fn take(&mut self, name: &str, value: &ParameterValue, switches: &[Switch]) -> Result<(), String> {
        match value {
            ParameterValue::Double(value) if name == FRAME_RATE => self.frame_rate_hz = *value,
            ParameterValue::Double(value) if name == NEAR_CLIP => self.near_clip_m = *value,
            ParameterValue::Int(value) => {
                for (channel, _) in self.background.iter_mut().zip(BACKGROUND).filter(|(_, known)| *known == name) {
                    *channel = *value as u8;
                }
            }
            ParameterValue::String(value) if name == ENCODING => {
                self.encoding = Encoding::from_name(value).ok_or_else(|| value.clone())?;
            }
            ParameterValue::Bool(value) if name == VISIBILITY => self.visibility.set(&[], *value),
            ParameterValue::Bool(value) => {
                for switch in switches.iter().filter(|switch| switch.name == name) {
                    self.visibility.set(&switch.path(), *value);
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// `true` if a display is shown, with all groups around it.
    pub(super) fn shows(&self, switch: &Switch) -> bool {
        self.visibility.shows(&switch.path())
    }

    /// The table of the settings; those of the file are the defaults. `is_black`: the camera's own blackout is on,
    /// which is no setting of its images.
    pub(super) fn groups(&self, in_file: &Self, switches: &[Switch], is_black: bool) -> Vec<SettingGroup> {
        let is_ticked = |path: &[&str]| [self, in_file].map(|of| of.visibility.is_ticked(path));
        let channel = |(index, color): (usize, &str)| {
            let values = [self, in_file].map(|of| i32::from(of.background[index]));
            let label = ["Background, red", "Background, green", "Background, blue"][index];
            Setting::new(BACKGROUND[index], &format!("Background: {color}"), values, [0, 255]).labelled(label, "")
        };
        let rate = "Pictures a second; below 0: when the scene changes, 0: only when triggered";
        let (rates, clips) = ([self, in_file].map(|of| of.frame_rate_hz), [self, in_file].map(|of| of.near_clip_m));
        let rate_range = [-1.0, HIGH_FRAME_RATE_HZ.max(in_file.frame_rate_hz)];
        let clip_range = [NEAREST_CLIP_M, FAR_CLIP_M.max(in_file.near_clip_m)];
        let encodings = [self, in_file].map(|of| of.encoding.name());
        let names = Encoding::ALL.map(Encoding::name).into();
        let mut settings = vec![
            Setting::switch(BLACKOUT, "Black out the picture", [is_black, false]),
            Setting::new(FRAME_RATE, rate, rates, rate_range).labelled("Frame rate", "Hz"),
        ];
        settings.extend(["red", "green", "blue"].into_iter().enumerate().map(channel));
        settings.extend([
            Setting::choice(ENCODING, "What a pixel of the picture is", encodings, names).labelled("Encoding", ""),
            Setting::new(NEAR_CLIP, "Nearer than this nothing is drawn, in metres", clips, clip_range)
                .labelled("Near clip", "m"),
            Setting::switch(VISIBILITY, "Whether the camera shows any display", is_ticked(&[])),
        ]);
        let shown = |switch: &Switch| Setting::switch(&switch.name, &switch.description, is_ticked(&switch.path()));
        vec![("Default", settings), ("Visibility", switches.iter().map(shown).collect())]
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

    /// The path as the page and cues write it.
    pub(super) fn text(&self) -> String {
        path_text(&self.path)
    }

    /// `true` if it is the switch of a group around the other one.
    fn is_around(&self, other: &Self) -> bool {
        other.path.len() > self.path.len() && other.path.starts_with(&self.path)
    }

    fn path(&self) -> Vec<&str> {
        self.path.iter().map(String::as_str).collect()
    }
}

#[cfg(test)]
mod tests {
    use rcs_ros::settings::{accepted, settings};

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
        parameters.take("show_g_a_b_2", &false.into(), &switches).unwrap();
        assert!(!parameters.visibility.shows(&["g", "a_b"]) && parameters.visibility.shows(&["g", "a b"]));
        let groups = parameters.groups(&parameters, &switches, true);
        let off = settings(&groups).filter(|setting| setting.value == false.into());
        assert_eq!(off.map(|setting| setting.name.as_str()).collect::<Vec<_>>(), ["show_g_a_b_2"]);
    }

    #[test]
    fn values_out_of_bounds_become_the_nearest_ones_and_nonsense_is_ignored() {
        let mut parameters = CameraParameters::of(&CameraPubSettings::default());
        let groups = parameters.groups(&parameters, &[], false);
        let mut take = |values: &[(&str, ParameterValue)]| {
            let request: Vec<_> = values.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect();
            let taken = accepted(&groups, &request);
            let taken: Vec<_> = taken.iter().map(|(name, value)| parameters.take(name, value, &[])).collect();
            (parameters.clone(), taken.into_iter().collect::<Result<(), _>>())
        };
        let (taken, _) = take(&[
            (FRAME_RATE, (-7.0).into()),
            (NEAR_CLIP, f64::INFINITY.into()),
            ("other", 1.0.into()),
            (BACKGROUND[0], 1.0.into()),
            (BACKGROUND[1], 300.into()),
            (ENCODING, "mono8".into()),
        ]);
        let expected = CameraParameters {
            frame_rate_hz: -1.0,
            near_clip_m: FAR_CLIP_M,
            background: [0, 255, 0],
            encoding: Encoding::Mono8,
            ..CameraParameters::of(&CameraPubSettings::default())
        };
        assert_eq!(taken, expected);
        let nonsense = take(&[(FRAME_RATE, f64::NAN.into()), (ENCODING, "voodoo".into())]);
        assert_eq!(nonsense, (expected, Err("voodoo".to_owned())));
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
    fn a_set_of_displays_ticks_them_and_the_groups_around_them_and_nothing_else() {
        let grid = |name: &str| format!("{{Class: rviz/Grid, Name: {name}, Enabled: true}}");
        let inner = format!("{{Class: rviz/Group, Name: h, Enabled: true, Displays: [{}, {}]}}", grid("a"), grid("b"));
        let group = format!("{{Class: rviz/Group, Name: g, Enabled: true, Displays: [{inner}, {}]}}", grid("c"));
        let switches = switches(&config(&[group, grid("a")].join(", ")));
        let mut parameters = CameraParameters::of(&CameraPubSettings::default());
        let mut show = |shown: &[&str]| {
            let shown: Vec<String> = shown.iter().map(|text| (*text).to_owned()).collect();
            let values = values_showing(&switches, &shown)?;
            values.iter().for_each(|(name, value)| parameters.take(name, value, &switches).unwrap());
            let displays = displays(&switches).filter(|switch| parameters.shows(switch)).map(Switch::text);
            Ok::<Vec<String>, String>(displays.collect())
        };
        for shown in [&["g / h / b", "a"][..], &["g / c"], &[], &["g / h / a", "g / h / b", "g / c", "a"]] {
            assert_eq!(show(shown).unwrap(), shown);
        }
        for unknown in ["b", "g", "g / h", "g/c", ""] {
            assert_eq!(show(&["a", unknown]), Err(format!("the config has no display '{unknown}'")));
        }
    }

    #[test]
    fn a_configs_numbers_are_reported_as_they_are_written() {
        let in_file = CameraPubSettings { near_clip_m: 0.01, frame_rate_hz: 144.1, ..CameraPubSettings::default() };
        let parameters = CameraParameters::of(&in_file);
        let groups = parameters.groups(&parameters, &[], false);
        let of = |name: &str| settings(&groups).find(|setting| setting.name == name).unwrap();
        let values = [FRAME_RATE, NEAR_CLIP].map(|name| of(name).value.clone());
        assert_eq!(values, [144.1, 0.01].map(ParameterValue::Double));
        assert_eq!(of(FRAME_RATE).range[1], values[0], "the file's value is within bounds");
        let mut written = CameraPubSettings::default();
        parameters.write_to(&mut written);
        assert_eq!(written, in_file);
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
