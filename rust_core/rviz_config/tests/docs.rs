//! The tables of `docs/reference/displays.md` name every property that a class reads, with the default that it has.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use rcs_rviz_config::{classes, properties, CameraPubSettings, DisplaySettings, Role, ENTRY};

const CAMERA_PUB: &str = "rviz_camera_stream/CameraPub";

/// Rows that are not properties of the class itself: class and key.
const NOT_OF_THE_CLASS: [(&str, &str); 1] = [
    // Every display has it; the table is also for those who write a CameraPub by hand.
    (CAMERA_PUB, "Enabled"),
];

/// Properties without a row: class and key.
const WITHOUT_ROW: [(&str, &str); 1] = [
    // The row Visibility stands for all tick boxes.
    (CAMERA_PUB, "Visibility / (name)"),
];

fn page() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference/displays.md");
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The text below a heading, up to the next one of its level.
fn section<'a>(page: &'a str, heading: &str) -> Option<&'a str> {
    let (_, rest) = page.split_once(&format!("\n{heading}\n"))?;
    Some(rest.split("\n## ").next().unwrap_or_default())
}

/// The value in a cell: what is in backticks, or all up to a remark in parentheses; `–` and `""` are empty.
fn plain(cell: &str) -> String {
    let cell = cell.trim();
    let value = match cell.strip_prefix('`') {
        Some(quoted) => quoted.split('`').next(),
        None => cell.split(" (").next(),
    };
    value.filter(|value| !["–", "\"\""].contains(value)).unwrap_or_default().trim().to_owned()
}

/// The properties and defaults of the tables in a text whose head has the columns "property" and "default". A row may
/// list several properties with as many defaults, or one default for all of them. A row that begins with … goes on
/// inside of the last property before it.
fn rows(text: &str) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    let (mut columns, mut parent) = (None, String::new());
    for line in text.lines() {
        let Some(line) = line.strip_prefix('|') else {
            columns = None;
            continue;
        };
        let cells: Vec<&str> = line.trim_end_matches('|').split('|').map(str::trim).collect();
        let Some((key, default)) = columns else {
            let column = |name| cells.iter().position(|cell| *cell == name);
            columns = column("property").zip(column("default"));
            continue;
        };
        if cells.iter().all(|cell| cell.starts_with("---")) {
            continue;
        }
        let (inside, keys) = match cells[key].strip_prefix("… ") {
            Some(keys) => (parent.clone() + " / ", keys),
            None => (String::new(), cells[key]),
        };
        let keys: Vec<String> = keys.split(", ").map(|key| inside.clone() + key.trim().trim_matches('`')).collect();
        let defaults: Vec<String> = cells[default].split(", ").map(plain).collect();
        assert!(defaults.len() == 1 || defaults.len() == keys.len(), "{line}");
        if inside.is_empty() {
            parent = keys.last().cloned().unwrap_or_default();
        }
        for (i, key) in keys.into_iter().enumerate() {
            found.insert(key, defaults.get(i).or(defaults.first()).cloned().unwrap_or_default());
        }
    }
    found
}

/// The rows for a class: those of its section, over those of the sections to which it links and of the page's
/// introduction. Of the latter two, rows count whose property the class has.
fn documented(class: &str) -> BTreeMap<String, String> {
    let page = page();
    let keys: BTreeSet<String> = properties(class).into_iter().map(|property| property.key).collect();
    let introduction = rows(page.split("\n## ").next().unwrap_or_default());
    let mut found: BTreeMap<String, String> = BTreeMap::new();
    for rows in std::iter::once(introduction).chain(linked_sections(&page, class).iter().map(|text| rows(text))) {
        found.extend(rows.into_iter().filter(|(key, _)| keys.contains(key)));
    }
    found.extend(rows(&of_class(&page, class)));
    found
}

/// The section of a class.
fn of_class(page: &str, class: &str) -> String {
    section(page, &format!("## {class}")).unwrap_or_else(|| panic!("no section {class}")).to_owned()
}

/// The sections to which that of a class links, with those to which these link, the farthest first.
fn linked_sections(page: &str, class: &str) -> Vec<String> {
    let text = of_class(page, class);
    let anchor = |name: &str| name.replace('/', "").to_lowercase();
    let is_linked = |other: &&str| *other != class && text.contains(&format!("](#{})", anchor(other)));
    let linked: Vec<&str> = classes().iter().map(|class| class.name).filter(is_linked).collect();
    let of = |other: &str| [linked_sections(page, other), vec![of_class(page, other)]].concat();
    linked.into_iter().flat_map(of).collect()
}

#[test]
fn every_property_stands_in_the_documentation_with_its_default() {
    let mut wrong = Vec::new();
    for class in classes().iter().map(|class| class.name) {
        let mut documented = documented(class);
        for (_, key) in NOT_OF_THE_CLASS.iter().filter(|(of, _)| *of == class) {
            assert!(documented.remove(*key).is_some(), "{class} has no row {key}");
        }
        let without_row = |key: &str| WITHOUT_ROW.contains(&(class, key));
        for property in properties(class).into_iter().filter(|property| !without_row(&property.key)) {
            match documented.remove(&property.key) {
                Some(default) if default == property.default => {}
                Some(default) => {
                    wrong.push(format!("{class}: {} is {:?}, not {default:?}", property.key, property.default));
                }
                None => wrong.push(format!("{class}: {} ({:?}) has no row", property.key, property.default)),
            }
        }
        wrong.extend(documented.into_keys().map(|key| format!("{class}: {key} is not read")));
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn a_camera_pub_without_enabled_is_off_as_the_page_has_it() {
    let text = format!("Visualization Manager:\n  Displays:\n  - {{Class: {CAMERA_PUB}, Name: camera}}\n");
    let config = rcs_rviz_config::parse(&text, "a.rviz").unwrap();
    assert_eq!(documented(CAMERA_PUB)["Enabled"], config.displays[0].enabled.to_string());
}

/// The block to paste, below `Displays:` and beside the display that it names.
#[test]
fn the_pages_camera_is_read_as_it_says() {
    let page = page();
    let block = page.split("```yaml\n").find(|block| block.starts_with("    - Class: rviz_camera_stream/CameraPub"));
    let block = block.and_then(|block| block.split("```").next()).expect("the page has a CameraPub");
    let grid = "    - Class: rviz/Grid\n      Name: Grid\n      Enabled: true\n";
    let text = format!("Visualization Manager:\n  Displays:\n{grid}{block}");
    let config = rcs_rviz_config::parse(&text, "a.rviz").unwrap();
    assert_eq!(config.findings, []);
    let camera = &config.displays[1];
    assert_eq!((&*camera.name, camera.enabled), ("Projector", true));
    let DisplaySettings::CameraPub(settings) = &camera.settings else { panic!("{:?}", camera.settings) };
    let topics = [&settings.camera_info_topic, &settings.image_topic, &settings.display_namespace];
    assert_eq!(topics, ["/proj_view/camera_info", "/proj_view/image", "proj_view"]);
    // The topics and the visibility are the camera's own; all else is the default, as the table has it.
    let expected = CameraPubSettings {
        camera_info_topic: settings.camera_info_topic.clone(),
        image_topic: settings.image_topic.clone(),
        display_namespace: settings.display_namespace.clone(),
        visibility: settings.visibility.clone(),
        ..CameraPubSettings::default()
    };
    assert_eq!(*settings, expected);
    assert!(format!("{:?}", settings.visibility).contains("Grid"), "{:?}", settings.visibility);
    // Every row of the table but those for the plugin is in the block.
    for key in
        documented(CAMERA_PUB).into_keys().filter(|key| !["Projection", "Undistort", "Depth Topic"].contains(&&**key))
    {
        assert!(block.contains(&format!(" {key}:")), "{key} is not in the block");
    }
}

#[test]
fn properties_inside_of_others_and_of_entries_are_listed() {
    let of = |class| properties(class).into_iter().map(|property| (property.key, property.default)).collect();
    let grid: BTreeMap<String, String> = of("rviz/Grid");
    assert_eq!(grid["Line Style"], "Lines");
    assert_eq!(grid["Line Style / Line Width"], "0.03");
    assert_eq!(grid["Color"], "160; 160; 164");
    assert_eq!(grid["Offset"], "0; 0; 0");
    let robot: BTreeMap<String, String> = of("rviz/RobotModel");
    assert_eq!(robot[&format!("Links / {ENTRY} / Show Axes")], "false");
    assert_eq!(properties("nobody/Knows"), []);
    let without: Vec<&str> =
        classes().iter().map(|class| class.name).filter(|name| properties(name).is_empty()).collect();
    assert_eq!(without, ["rviz/Group"], "every other class has properties");
}

#[test]
fn the_class_of_a_name_is_the_one_that_a_config_gets() {
    for class in classes() {
        let text = format!("Visualization Manager: {{Displays: [{{Class: {}}}]}}", class.name);
        let config = rcs_rviz_config::parse(&text, "test").unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(config.displays[0].settings.role(), class.role);
        assert!(class.role != Role::Unknown && config.findings.is_empty());
    }
}
