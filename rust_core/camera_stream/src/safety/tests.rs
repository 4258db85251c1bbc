//! Tests of policies: dark cameras, and the permits of windows.

use rcs_messages::std_msgs::Header;
use rcs_resources::{MeshStore, PackageIndex};
use rcs_transforms::Time;

use super::ages::limits::{AgeLimits, StaleTimeout};
use super::confirmed_displays::ConfirmedDisplays;
use super::names::ForCamera;
use super::permit::Allowance;
use super::rules::KeepOutFrame;
use super::surface::ConfirmRules;
use super::*;
use rcs_confirm::{ConfirmSettings, Unseen};

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

/// Why each camera is dark, a while after the start.
fn causes(safety: &mut Safety, start: Instant, after_secs: f64) -> Vec<Option<DarkCause>> {
    let scene = scene();
    let view = |view| LitView { view, camera: None, unknown_lens: None, is_watched: true };
    let lit: Vec<_> = scene.cameras().iter().map(view).collect();
    let now = Now { ros: Time::ZERO, steady: start + Duration::from_secs_f64(after_secs) };
    let policies = safety.assess(&scene, &lit, |_, _| None, now);
    policies.into_iter().map(|policy| policy.dark_reason.map(|dark| dark.cause)).collect()
}

fn white_mask() -> Image {
    Image::new(Header::default(), [1, 1], "mono8", 1, Arc::new(vec![255]))
}

#[test]
fn a_mask_that_is_missing_or_too_old_makes_its_own_camera_dark() {
    let mut safety = Safety::new(Rules { mask_topics: mask_of_cam(), ..rules() });
    let start = Instant::now();
    assert_eq!(causes(&mut safety, start, 0.0), [Some(DarkCause::Mask), None]);
    safety.take_image("/mask", &white_mask(), start);
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
fn without_a_camera_an_image_is_black_only_where_that_matters() {
    let policy = |rules| {
        let mut safety = Safety::new(rules);
        let scene = scene();
        let lit: Vec<_> = scene
            .cameras()
            .iter()
            .map(|view| LitView { view, camera: None, unknown_lens: None, is_watched: true })
            .collect();
        safety.assess(&scene, &lit, |_, _| None, Now { ros: Time::ZERO, steady: Instant::now() }).remove(0)
    };
    assert_eq!(policy(rules()).without_camera("no pose"), None);
    let mut limits = AgeLimits::off();
    limits.set("1".parse::<StaleTimeout>().unwrap(), |topic| Ok::<_, String>(topic.to_owned())).unwrap();
    let dark = policy(Rules { limits, ..rules() }).without_camera("no pose");
    assert_eq!(dark, Some(DarkReason::new(DarkCause::NoCamera, "no pose")));
    let dark = policy(Rules { mask_topics: mask_of_cam(), ..rules() }).without_camera("no pose").unwrap();
    assert_eq!(dark.cause, DarkCause::Mask);
}

#[test]
fn a_window_that_hears_nothing_knows_whether_eyes_are_protected() {
    let silent = Safety::new(rules()).silent_window("cam");
    assert_eq!((silent.timeout, silent.permit.test), (None, Allowance::All));
    let safety = Safety::new(Rules { mask_topics: mask_of_cam(), ..rules() });
    let (cam, other) = (safety.silent_window("cam"), safety.silent_window("other"));
    assert_eq!((cam.timeout, cam.permit.test), (Some(Duration::from_secs(1)), Allowance::Nothing));
    assert_eq!((other.timeout, other.permit.test), (None, Allowance::All));
    let painted = rcs_render::LightMask::new([1, 1], vec![0]).unwrap();
    let painted_masks = vec![ForCamera { camera: None, value: Arc::new(painted) }];
    let silent = Safety::new(Rules { painted_masks, ..rules() }).silent_window("cam");
    assert_eq!(silent.permit.test, Allowance::Masked);
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
