//! Configs that a camera is added to, as `camera_stream new-camera` does.
//!
//! An input is a config; where a byte of zero comes first, what is before it is the camera's name, of which its topic
//! and its namespace are made.

use std::ops::Range;

use rcs_rviz_config::{
    insert_camera, parse, Config, DisplayConfig, DisplaySettings, Finding, FindingKind, InsertError, NewCamera,
};
use saphyr_parser::{Event, Parser, ScalarStyle};

const SOURCE: &str = "fuzz.rviz";
const USUAL_NAME: &str = "Projector";
/// What stands for an empty list, and is replaced.
const NULLS: [&str; 2] = ["~", "null"];

/// A config with a camera more: everything else is as it was, or an error says in one line why there is none.
pub(crate) fn new_camera(data: &[u8]) {
    let Ok(input) = std::str::from_utf8(data) else { return };
    let (name, text) = input.split_once('\0').unwrap_or((USUAL_NAME, input));
    let camera = NewCamera {
        name: name.to_owned(),
        camera_info_topic: "/proj_view/camera_info".to_owned(),
        image_topic: format!("/{name}/image"),
        display_namespace: name.to_owned(),
        near_clip_m: 0.01,
    };
    if name != USUAL_NAME {
        check_block(&camera);
    }
    let extended = match insert_camera(text, SOURCE, &camera) {
        Ok(extended) => extended,
        Err(error) => {
            let error = error.to_string();
            assert!(error.starts_with(SOURCE) && error.lines().count() == 1, "{error:?}");
            return;
        }
    };
    let [before, after] = [text, &extended].map(|text| {
        parse(text, SOURCE).unwrap_or_else(|error| panic!("{error} in\n{extended}\n--- which was made of\n{text}"))
    });
    let problem = problem_of_text(text, &extended).or_else(|| problem_of_config(&before, &after, &camera));
    assert!(problem.is_none(), "{}:\n{text}\n--- became\n{extended}", problem.unwrap_or_default());
    // A second one of the same name is refused.
    if !name.is_empty() {
        let again = insert_camera(&extended, SOURCE, &camera);
        assert!(matches!(again, Err(InsertError::Taken { .. })), "{again:?} for\n{extended}");
    }
}

/// The block that is printed for somebody to paste is the camera.
fn check_block(camera: &NewCamera) {
    let text = format!("Visualization Manager:\n  Displays:\n{}", camera.block(4, "\n"));
    let config = parse(&text, SOURCE).unwrap_or_else(|error| panic!("{error} in\n{text}"));
    assert!(config.displays.len() == 1 && is_camera(&config.displays[0], camera), "{camera:?} became\n{text}");
}

fn is_camera(display: &DisplayConfig, camera: &NewCamera) -> bool {
    let DisplaySettings::CameraPub(settings) = &display.settings else { return false };
    display.enabled
        && display.name == camera.name
        && settings.camera_info_topic == camera.camera_info_topic
        && settings.image_topic == camera.image_topic
        && settings.display_namespace == camera.display_namespace
}

/// What is wrong with the text: what was added is one piece, in its bytes and in its YAML.
fn problem_of_text(before: &str, after: &str) -> Option<&'static str> {
    let is_replaced = |null: &str| {
        let mut places = insertions(before.as_bytes(), after.as_bytes(), null.len());
        places.any(|at| before.get(at..at + null.len()) == Some(null))
    };
    if insertions(before.as_bytes(), after.as_bytes(), 0).is_empty() && !NULLS.into_iter().any(is_replaced) {
        return Some("other bytes are not what they were");
    }
    let [before, after] = [events(before), events(after)];
    let is_null = |event: &Option<Event<'_>>| match event {
        Some(Event::Scalar(value, ScalarStyle::Plain, ..)) => value.is_empty() || NULLS.contains(&&**value),
        _ => false,
    };
    let is_same = !insertions(&before, &after, 0).is_empty()
        || insertions(&before, &after, 1).any(|at| before.get(at).is_some_and(is_null));
    (!is_same).then_some("other YAML is not what it was")
}

/// Where a series may have lost as many elements as this, and got others in their place, so that it is the second one.
fn insertions<T: PartialEq>(before: &[T], after: &[T], removed: usize) -> Range<usize> {
    let kept = before.len().checked_sub(removed).filter(|kept| *kept <= after.len());
    let Some(kept) = kept else { return 0..0 };
    let from_start = before.iter().zip(after).take_while(|(before, after)| before == after).count();
    let from_end = before.iter().rev().zip(after.iter().rev()).take_while(|(before, after)| before == after).count();
    kept.saturating_sub(from_end)..from_start.min(kept) + 1
}

/// What the YAML consists of; `None` is an error, which ends it.
fn events(text: &str) -> Vec<Option<Event<'_>>> {
    let mut events = Vec::new();
    let mut parser = Parser::new_from_str(text);
    while let Some(event) = parser.next_event() {
        let event = event.ok().map(|(event, _)| event);
        let is_error = event.is_none();
        events.push(event);
        if is_error {
            break;
        }
    }
    events
}

/// What is wrong with the config: it has the camera in front, and is otherwise what it was but for its lines.
fn problem_of_config(before: &Config, after: &Config, camera: &NewCamera) -> Option<&'static str> {
    let cameras = |config: &Config| {
        let placed = config.placed_displays();
        placed.iter().filter(|placed| matches!(placed.display.settings, DisplaySettings::CameraPub(_))).count()
    };
    let Some((first, rest)) = after.displays.split_first() else { return Some("there is no display") };
    if !is_camera(first, camera) || cameras(after) != cameras(before) + 1 {
        return Some("the camera is not what it should be");
    }
    if described(rest) != described(&before.displays) {
        return Some("other displays are not what they were");
    }
    // Numbers that are none are not the same as themselves.
    let of_scene = |config: &Config| format!("{:?}", (&config.global, config.enabled, &config.view));
    if of_scene(before) != of_scene(after) {
        return Some("other settings are not what they were");
    }
    // Names that no display had may be the camera's.
    let is_of_name = |finding: &&Finding| matches!(finding.kind, FindingKind::UnknownDisplay { .. });
    let kinds = |config: &Config| -> Vec<String> {
        let others = config.findings.iter().filter(|finding| !is_of_name(finding));
        others.map(|finding| format!("{:?}", (finding.is_note, &finding.path, &finding.kind))).collect()
    };
    (kinds(before) != kinds(after)).then_some("other findings are not what they were")
}

/// Everything about displays but their lines.
fn described(displays: &[DisplayConfig]) -> Vec<String> {
    let describe = |display: &DisplayConfig| {
        let DisplayConfig { name, class, enabled, settings, .. } = display;
        let settings = match settings {
            DisplaySettings::Group(group) => described(&group.displays).join("\n"),
            settings => format!("{settings:?}"),
        };
        format!("{name:?} {class:?} {enabled} {settings}")
    };
    displays.iter().map(describe).collect()
}
