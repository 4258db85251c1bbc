//! Which blackouts hold, and who releases them.

use super::*;

/// A control with two cameras that keeps its blackouts in a folder.
fn control(folder: &std::path::Path) -> Control {
    let control = Control::new(BlackoutFile::of_node(Some(folder), "/eye"), |_| {}, || {});
    control.set_cameras(["Left", "Right"].into_iter());
    control
}

fn blackouts(control: &Control, names: [&str; 2]) -> [Option<String>; 2] {
    names.map(|name| control.of_camera(name).light.err().map(|dark| dark.why))
}

const BOTH: [&str; 2] = ["Left", "Right"];
const B: WindowKey = WindowKey::Character('b');
const L: WindowKey = WindowKey::Character('L');
const T: WindowKey = WindowKey::Character('t');

fn why(text: &str) -> Option<String> {
    Some(text.to_owned())
}

#[test]
fn black_is_no_toggle_and_is_released_by_another_act() {
    let folder = tempfile::tempdir().unwrap();
    let control = control(folder.path());
    assert_eq!(blackouts(&control, BOTH), [None, None]);
    (0..40).for_each(|_| control.press("Left", B));
    let of_key = why("blackout by key b, of this camera");
    assert_eq!(blackouts(&control, BOTH), [of_key.clone(), None]);
    control.set_camera_blackout("Left", true, "/gui").unwrap();
    assert_eq!(blackouts(&control, BOTH), [of_key, None], "who was first");
    control.press("Left", WindowKey::Character('l'));
    assert!(control.of_camera("Left").is_switched_off);
    (0..3).for_each(|_| control.press("Left", L));
    assert_eq!(blackouts(&control, BOTH), [None, None]);
    control.set_blackout(true, "/script").unwrap();
    control.press("Left", L);
    assert_eq!(blackouts(&control, BOTH), [why("blackout by /script"), why("blackout by /script")], "of all");
}

#[test]
fn releasing_all_releases_single_cameras() {
    let folder = tempfile::tempdir().unwrap();
    let control = control(folder.path());
    control.press("Right", B);
    control.set_blackout(true, "/script").unwrap();
    control.set_blackout(false, "/other").unwrap();
    assert_eq!(blackouts(&control, BOTH), [None, None]);
    assert!(!control.of_camera("Right").is_switched_off);
}

#[test]
fn a_release_is_void_after_any_other_word_about_blackouts() {
    let folder = tempfile::tempdir().unwrap();
    let control = control(folder.path());
    control.set_blackout(true, "/script").unwrap();
    let seen = control.number();
    control.set_blackout(true, "/other").unwrap();
    assert!(control.release(None, seen, "the page").is_none() && control.of_camera("Left").light.is_err());
    assert!(control.release(None, control.number(), "the page").is_some());
    assert_eq!(blackouts(&control, BOTH), [None, None]);
    control.press("Left", B);
    let seen = control.number();
    control.press("Left", B);
    assert!(control.release(Some("Left"), seen, "the page").is_none(), "somebody wants it black still");
    let seen = control.number();
    control.set_pause(true, "/script");
    assert!(control.release(Some("Left"), seen, "the page").is_some());
    assert!(control.of_camera("Left").light.is_ok());
}

#[test]
fn the_next_run_has_the_blackouts_of_the_last_one() {
    let folder = tempfile::tempdir().unwrap();
    let first = control(folder.path());
    first.press("Right", B);
    drop(first);
    let second = control(folder.path());
    assert!(second.of_camera("Left").light.is_ok() && second.of_camera("Right").light.is_err());
    second.set_blackout(true, "/script").unwrap();
    assert!(control(folder.path()).of_camera("Left").light.is_err());
    second.set_blackout(false, "/script").unwrap();
    assert_eq!(blackouts(&control(folder.path()), BOTH), [None, None]);
}

#[test]
fn a_blackout_that_cannot_be_kept_holds_and_is_an_error() {
    let control = Control::new(BlackoutFile::of_node(None, "/eye"), |_| {}, || {});
    assert!(control.set_blackout(true, "/script").is_err());
    assert!(control.of_camera("Left").light.is_err());
}

#[test]
fn a_camera_that_may_be_the_black_one_by_another_name_starts_black() {
    let folder = tempfile::tempdir().unwrap();
    let of_left = why("blackout by the blackout of Left, of this camera");
    let renamed = control(folder.path());
    renamed.press("Left", B);
    renamed.set_cameras(["Links", "Right"].into_iter());
    assert_eq!(blackouts(&renamed, ["Links", "Right"]), [of_left.clone(), None]);
    renamed.set_cameras(["Left", "Right"].into_iter());
    assert!(renamed.of_camera("Left").light.is_err(), "and back");
    // Without a new camera, the blackout waits.
    renamed.set_cameras(["Right"].into_iter());
    assert_eq!(blackouts(&renamed, ["Right", "Right"]), [None, None]);
    let next = Control::new(BlackoutFile::of_node(Some(folder.path()), "/eye"), |_| {}, || {});
    next.set_cameras(["Middle", "Right"].into_iter());
    assert!(next.of_camera("Middle").light.is_err() && next.of_camera("Right").light.is_err(), "all are new to it");
}

#[test]
fn a_word_of_the_operator_and_a_config_void_what_was_granted_before() {
    let folder = tempfile::tempdir().unwrap();
    let control = control(folder.path());
    let evidence = rcs_light::Evidence::unknown(
        &[],
        rcs_light::LightRules::none(std::time::Duration::from_secs(9)),
        Arc::default(),
    );
    let now = Instant::now();
    let grant = |name: &str| evidence.decide(rcs_light::Content::Scene, [1, 1], control.of_camera(name).light, now);
    let (left, right) = (grant("Left").unwrap(), grant("Right").unwrap());
    control.press("Left", B);
    assert!(!left.is_valid(now) && right.is_valid(now) && grant("Left").is_err());
    control.press("Left", L);
    assert!(!left.is_valid(now), "an image from before is an old one");
    let left = grant("Left").unwrap();
    assert!(left.is_valid(now));
    control.set_cameras(BOTH.into_iter());
    assert!(!left.is_valid(now) && !right.is_valid(now));
}

#[test]
fn a_service_has_the_last_word_on_pauses_and_test_images_of_keys() {
    let folder = tempfile::tempdir().unwrap();
    let control = control(folder.path());
    control.press("Left", WindowKey::Space);
    assert!(control.of_camera("Left").paused.is_some() && control.of_camera("Right").paused.is_none());
    control.set_pause(false, "/script");
    assert!(control.of_camera("Left").paused.is_none());
    control.press("Left", T);
    control.press("Left", T);
    let shown = |name| control.of_camera(name).test_image;
    assert_eq!((shown("Left"), shown("Right")), (Some(TestImage::ALL[1]), None));
    let names: Vec<_> = (0..=TestImage::ALL.len()).map(|_| control.next_test_image("/script")).collect();
    assert_eq!(names[..2], [Some("name"), Some("border")]);
    assert_eq!((names[TestImage::ALL.len()], shown("Left")), (None, None));
}
