//! Which blackouts hold, and who releases them.

use super::*;

type Written = Arc<Mutex<Vec<(String, bool)>>>;

fn control(remembered: &[&str]) -> (Control, Written) {
    let written = Written::default();
    let writer = Arc::clone(&written);
    let remembered = remembered.iter().map(|name| (*name).to_owned()).collect();
    let remember = move |name: &str, is_on| lock(&writer).push((name.to_owned(), is_on));
    let control = Control::new(remembered, remember, || {});
    control.set_cameras([("Left", "left"), ("Right", "right")].into_iter());
    (control, written)
}

fn blackouts(control: &Control) -> [Option<String>; 2] {
    ["Left", "Right"].map(|name| control.of_camera(name).blackout.map(|dark| dark.why))
}

const B: WindowKey = WindowKey::Character('b');
const T: WindowKey = WindowKey::Character('t');

#[test]
fn a_camera_is_black_while_any_blackout_holds() {
    let (control, _) = control(&[]);
    let why = |text: &str| Some(text.to_owned());
    assert_eq!(blackouts(&control), [None, None]);
    control.set_camera_blackout("Left", true, "/gui");
    control.press("Left", B);
    assert_eq!(blackouts(&control), [why("blackout by /gui, of this camera"), None]);
    control.set_camera_blackout("Left", false, "/gui");
    assert_eq!(blackouts(&control), [why("blackout by key b in its window"), None], "the key holds");
    control.press("Left", B);
    assert_eq!(blackouts(&control), [None, None]);
    control.set_blackout(true, "/script");
    assert_eq!(blackouts(&control), [why("blackout by /script"), why("blackout by /script")]);
}

#[test]
fn releasing_all_releases_cameras_and_keys_and_is_remembered() {
    let (control, written) = control(&[]);
    control.set_blackout(true, "/script");
    control.press("Right", B);
    control.set_camera_blackout("Left", true, "/gui");
    control.set_blackout(false, "/other");
    assert_eq!(blackouts(&control), [None, None]);
    assert!(!control.of_camera("Left").is_switched_off);
    let expected =
        [("blackout", true), ("right/key_blackout", true), ("blackout", false), ("right/key_blackout", false)];
    assert_eq!(*lock(&written), expected.map(|(name, is_on)| (name.to_owned(), is_on)));
}

#[test]
fn what_an_earlier_run_left_blacks_out_its_first_cameras_only() {
    let (control, _) = control(&["left/blackout", "right/key_blackout", "later/blackout"]);
    assert!(control.of_camera("Left").is_switched_off && control.of_camera("Right").blackout.is_some());
    control.set_blackout(false, "/script");
    control.set_cameras([("Left", "left"), ("Later", "later")].into_iter());
    assert_eq!(blackouts(&control), [None, None]);
    assert!(control.of_camera("Later").blackout.is_none());
    let parameters = Parameters::from([
        ("blackout".to_owned(), ParameterValue::Bool(true)),
        ("lazy".to_owned(), ParameterValue::Bool(false)),
        ("left".to_owned(), ParameterValue::Struct([("blackout".to_owned(), ParameterValue::Bool(true))].into())),
    ]);
    assert_eq!(remembered(&parameters), ["blackout", "left/blackout"].map(str::to_owned).into());
}

#[test]
fn a_ticket_is_void_from_the_next_blackout_on() {
    let (control, _) = control(&[]);
    let (left, right) = (control.ticket("Left"), control.ticket("Right"));
    control.press("Left", B);
    assert!(!left.is_valid() && right.is_valid());
    let during = control.ticket("Left");
    control.press("Left", B);
    assert!(!left.is_valid() && !during.is_valid(), "an image from before is an old one");
    assert!(control.ticket("Left").is_valid());
    control.set_blackout(true, "/script");
    assert!(!right.is_valid() && !control.ticket("Later").is_valid());
}

#[test]
fn a_service_has_the_last_word_on_pauses_and_test_pictures_of_keys() {
    let (control, _) = control(&[]);
    control.press("Left", WindowKey::Space);
    assert!(control.of_camera("Left").paused.is_some() && control.of_camera("Right").paused.is_none());
    control.set_pause(false, "/script");
    assert!(control.of_camera("Left").paused.is_none());
    control.press("Left", T);
    control.press("Left", T);
    let shown = |name| control.of_camera(name).test_picture;
    assert_eq!((shown("Left"), shown("Right")), (Some(TestPicture::ALL[1]), None));
    let names: Vec<_> = (0..=TestPicture::ALL.len()).map(|_| control.next_test_picture("/script")).collect();
    assert_eq!(names[..2], [Some("name"), Some("border")]);
    assert_eq!((names[TestPicture::ALL.len()], shown("Left")), (None, None));
}

#[test]
fn a_blackout_hides_a_test_picture_in_the_window() {
    let (control, _) = control(&[]);
    control.press("Left", T);
    assert_eq!(control.of_camera("Left").window_view(), WindowView::Test(TestPicture::ALL[0]));
    control.set_blackout(true, "/script");
    assert_eq!(control.of_camera("Left").window_view(), WindowView::Black);
    assert_eq!(control.state().blackout.as_deref(), Some("/script"));
    assert!(control.take_change() && !control.take_change());
}
