//! Tests of dark cameras.

mod model;

use rcs_messages::std_msgs::Header;
use rcs_resources::{MeshStore, PackageIndex};
use rcs_transforms::Time;

use super::ages::limits::{AgeLimits, StaleTimeout};
use super::confirmed_displays::ConfirmedDisplays;
use super::names::ForCamera;
use super::rules::KeepOutFrame;
use super::surface::ConfirmRules;
use super::*;
use rcs_confirm::{ConfirmSettings, Unseen};
use rcs_light::DarkCause;

const CONFIG: &str = "
Visualization Manager:
  Global Options: {Fixed Frame: map}
  Displays:
  - {Class: rviz_camera_stream/CameraPub, Name: cam, Enabled: true, Image Topic: /a, Camera Info Topic: /info}
  - {Class: rviz_camera_stream/CameraPub, Name: other, Enabled: true, Image Topic: /b, Camera Info Topic: /info}
";

fn rules() -> Rules {
    Rules {
        limits: AgeLimits::off(),
        orientations: Vec::new(),
        blends: Vec::new(),
        painted_masks: Vec::new(),
        mask_topics: Vec::new(),
        keep_out: Vec::new(),
        is_required: true,
        confirm: ConfirmRules {
            surfaces: Vec::new(),
            displays: ConfirmedDisplays::All,
            settings: ConfirmSettings::default(),
        },
    }
}

fn mask_of_cam() -> Vec<ForCamera<String>> {
    vec![ForCamera { camera: Some("cam".to_owned()), value: "/mask".to_owned() }]
}

fn scene() -> SceneState {
    let config = rcs_rviz_config::parse(CONFIG, "test").unwrap();
    SceneState::new(&config, None, MeshStore::new(PackageIndex::new([])))
}

fn cameras(names: &[&str]) -> ConfigNames {
    let cameras = names.iter().map(|name| (*name).to_owned()).collect();
    ConfigNames { cameras, ..ConfigNames::default() }
}

/// The light of each camera, which has a CameraInfo and a pose.
fn lights(safety: &mut Safety, now: Now) -> Vec<CameraLight> {
    let scene = scene();
    let view = |view| LitView { view, camera: None, unknown_lens: None, is_watched: true };
    let lit: Vec<_> = scene.cameras().iter().map(view).collect();
    let mut lights = safety.assess(&scene, &lit, |_, _| None, now);
    lights.iter_mut().for_each(|light| light.evidence.set(DarkCause::NoCamera, Condition::Always));
    lights
}

/// Why each camera is dark, a while after the start.
fn causes(safety: &mut Safety, start: Instant, after_secs: f64) -> Vec<Option<DarkCause>> {
    let now = at(start, after_secs);
    let lights = lights(safety, now);
    lights.into_iter().map(|light| light.evidence.dark_reason(now.steady).map(|dark| dark.cause)).collect()
}

fn at(start: Instant, after_secs: f64) -> Now {
    Now { ros: Time::ZERO, steady: start + Duration::from_secs_f64(after_secs), resumed: None }
}

fn white_mask() -> Image {
    Image::new(Header::default(), [1, 1], "mono8", 1, Arc::new(vec![255]))
}

#[test]
fn a_mask_that_is_missing_or_too_old_makes_its_own_camera_dark() {
    let mut safety = Safety::new(Rules { mask_topics: mask_of_cam(), ..rules() });
    let start = Instant::now();
    assert_eq!(causes(&mut safety, start, 0.0), [Some(DarkCause::Mask), None]);
    safety.take_image("/mask", &white_mask(), &"/tracker".into(), start);
    assert_eq!(causes(&mut safety, start, 0.9), [None, None]);
    assert_eq!(causes(&mut safety, start, 1.1), [Some(DarkCause::Mask), None]);
    let mut lenient = Safety::new(Rules { mask_topics: mask_of_cam(), is_required: false, ..rules() });
    assert_eq!(causes(&mut lenient, start, 0.0), [None, None]);
}

#[test]
fn a_keep_out_frame_without_a_place_makes_all_cameras_dark() {
    let head = KeepOutFrame { frame: "head".to_owned(), radius_m: 0.2 };
    let mut safety = Safety::new(Rules { keep_out: vec![head], ..rules() });
    assert_eq!(causes(&mut safety, Instant::now(), 0.0), [Some(DarkCause::KeepOut); 2]);
}

#[test]
fn a_rule_for_a_camera_that_is_gone_makes_all_cameras_dark_until_the_names_fit() {
    let mut safety = Safety::new(Rules { mask_topics: mask_of_cam(), is_required: false, ..rules() });
    let start = Instant::now();
    let expected = "the config has no camera for mask_topic cam; cameras: camm, other";
    assert_eq!(safety.set_names(&cameras(&["camm", "other"])), Some(expected));
    assert_eq!(causes(&mut safety, start, 0.0), [Some(DarkCause::UnknownName); 2]);
    assert_eq!(safety.set_names(&cameras(&[])), Some("the config has no camera for mask_topic cam; it has none"));
    assert_eq!(causes(&mut safety, start, 0.0), [Some(DarkCause::UnknownName); 2]);
    assert_eq!(safety.set_names(&cameras(&["cam", "other"])), None);
    assert_eq!(causes(&mut safety, start, 0.0), [None, None]);
    let turned = vec![ForCamera { camera: Some("cam".to_owned()), value: "90".parse().unwrap() }];
    let mut safety = Safety::new(Rules { orientations: turned, ..rules() });
    assert!(safety.set_names(&cameras(&["other"])).is_some());
}

#[test]
fn a_cause_that_nobody_has_set_is_dark() {
    let (mut safety, now) = (Safety::new(rules()), at(Instant::now(), 0.0));
    let scene = scene();
    let view = |view| LitView { view, camera: None, unknown_lens: None, is_watched: true };
    let lit: Vec<_> = scene.cameras().iter().map(view).collect();
    let light = safety.assess(&scene, &lit, |_, _| None, now).remove(0);
    assert_eq!(light.evidence.dark_reason(now.steady).map(|dark| dark.cause), Some(DarkCause::NoCamera));
    assert!(CameraLight::unknown().evidence.dark_reason(now.steady).is_some());
}

#[test]
fn light_is_granted_for_the_limit_of_the_data_at_most() {
    let limit = |rules: Rules| Safety::new(rules).light_limit("cam").as_secs_f64();
    assert_eq!(limit(rules()), 5.0);
    assert_eq!(limit(Rules { mask_topics: mask_of_cam(), ..rules() }), 1.0);
    let mut limits = AgeLimits::off();
    limits.set("3".parse::<StaleTimeout>().unwrap(), |topic| Ok::<_, String>(topic.to_owned())).unwrap();
    assert_eq!(limit(Rules { limits, ..rules() }), 3.0);
}

#[test]
fn an_invalid_mask_takes_the_place_of_a_valid_one() {
    for is_required in [true, false] {
        let mut safety = Safety::new(Rules { mask_topics: mask_of_cam(), is_required, ..rules() });
        let (start, tracker) = (Instant::now(), "/tracker".into());
        safety.take_image("/mask", &white_mask(), &tracker, start);
        assert_eq!(causes(&mut safety, start, 0.1), [None, None]);
        let wrong = Image::new(Header::default(), [1, 1], "bgr8", 3, Arc::new(vec![0; 3]));
        safety.take_image("/mask", &wrong, &tracker, start);
        assert_eq!(causes(&mut safety, start, 0.2), [Some(DarkCause::Mask), None]);
    }
}

#[test]
fn of_several_trackers_each_darkens_and_one_that_dies_makes_all_dark_until_it_is_gone() {
    let mut safety = Safety::new(Rules { mask_topics: mask_of_cam(), ..rules() });
    let (start, trackers) = (Instant::now(), ["/a".into(), "/b".into()]);
    let mask = |level| Image::new(Header::default(), [1, 1], "mono8", 1, Arc::new(vec![level]));
    safety.take_image("/mask", &mask(255), &trackers[0], start);
    safety.take_image("/mask", &mask(0), &trackers[1], start);
    let masks = lights(&mut safety, at(start, 0.1))[0].evidence.post().masks.clone();
    assert_eq!(masks.iter().map(|mask| mask.levels()[0]).min(), Some(0), "the darkest counts: {masks:?}");
    safety.take_image("/mask", &mask(255), &trackers[0], start + Duration::from_secs(2));
    assert_eq!(causes(&mut safety, start, 2.1), [Some(DarkCause::Mask), None]);
    let listed = |names: &[&str], at_secs: u64| {
        let names = names.iter().map(|name| (*name).into()).collect();
        let publishers = MaskPublishers { names, listed_at: Some(start + Duration::from_secs(at_secs)) };
        move |_: &str| publishers.clone()
    };
    let now = start + Duration::from_secs(2);
    safety.follow_publishers(listed(&["/a"], 0), now);
    assert_eq!(causes(&mut safety, start, 2.1), [Some(DarkCause::Mask), None], "an older list");
    safety.follow_publishers(listed(&["/a"], 1), now);
    assert_eq!(causes(&mut safety, start, 2.1), [None, None]);
    safety.follow_publishers(listed(&["/a", "/c"], 3), now);
    assert_eq!(causes(&mut safety, start, 2.1), [Some(DarkCause::Mask), None], "/c has sent none yet");
    safety.take_image("/mask", &mask(255), &"/c".into(), now);
    assert_eq!(causes(&mut safety, start, 2.1), [None, None]);
    safety.reset();
    assert_eq!(causes(&mut safety, start, 2.1), [Some(DarkCause::Mask), None], "the time jumped");
}

#[test]
fn a_limit_of_never_does_not_make_a_mask_a_constant() {
    let mut limits = AgeLimits::off();
    limits.set("/mask=never".parse::<StaleTimeout>().unwrap(), |topic| Ok::<_, String>(topic.to_owned())).unwrap();
    let mut safety = Safety::new(Rules { mask_topics: mask_of_cam(), limits, ..rules() });
    let start = Instant::now();
    safety.take_image("/mask", &white_mask(), &"/tracker".into(), start);
    assert_eq!(causes(&mut safety, start, 1.1), [Some(DarkCause::Mask), None]);
}

fn surface_of_cam(displays: ConfirmedDisplays) -> ConfirmRules {
    let surfaces = vec![ForCamera { camera: Some("cam".to_owned()), value: "/depth".to_owned() }];
    ConfirmRules { surfaces, displays, settings: ConfirmSettings::default() }
}

#[test]
fn a_missing_surface_makes_its_own_camera_dark_whatever_is_lit_where_nothing_is_seen() {
    let mut confirm = surface_of_cam(ConfirmedDisplays::All);
    confirm.settings.unseen = Unseen::Light;
    let mut safety = Safety::new(Rules { confirm: confirm.clone(), ..rules() });
    assert!(safety.needs_cameras());
    assert_eq!(causes(&mut safety, Instant::now(), 0.0), [Some(DarkCause::Surface), None]);
    // What is before it in the table is the reason, as for a mask.
    let mut masked = Safety::new(Rules { confirm, mask_topics: mask_of_cam(), ..rules() });
    assert_eq!(causes(&mut masked, Instant::now(), 0.0), [Some(DarkCause::Mask), None]);
}

#[test]
fn a_listed_display_that_is_gone_makes_all_cameras_dark_until_the_names_fit() {
    let confirm = surface_of_cam(ConfirmedDisplays::Named(vec!["cups".to_owned()]));
    let mut safety = Safety::new(Rules { confirm, ..rules() });
    let mut names = cameras(&["cam", "other"]);
    names.displays = vec!["cup".to_owned()];
    let expected = "the config has no display 'cups'; did you mean 'cup'? displays: cup";
    assert_eq!(safety.set_names(&names), Some(expected));
    assert_eq!(causes(&mut safety, Instant::now(), 0.0), [Some(DarkCause::UnknownName); 2]);
    names.displays = vec!["cups".to_owned()];
    assert_eq!(safety.set_names(&names), None);
}
