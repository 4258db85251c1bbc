//! Random walks of what may happen, against an [oracle](oracle::Oracle) that knows when light is allowed.
//!
//! After each event the light is decided anew. A grant must not last longer than the oracle allows, and one of before
//! must be void as soon as the operator or the config says anything. `MANY_SEEDS` makes it 100,000 walks.

mod oracle;

use std::time::{Duration, Instant};

use proptest::prelude::*;
use rcs_displays::CameraView;
use rcs_light::{BlackoutFile, Content, DarkCause, Grant, Now, Pulse};
use rcs_messages::nav_msgs::Path;
use rcs_messages::std_msgs::Header;
use rcs_messages::tf2_msgs::TFMessage;
use rcs_messages::{geometry_msgs, AnyMessage};
use rcs_resources::{MeshStore, PackageIndex};
use rcs_ros::Publishing;
use rcs_transforms::Time;

use self::oracle::{Oracle, Seen};
use super::super::ages::limits::{AgeLimits, StaleTimeout};
use super::super::confirmed_displays::ConfirmedDisplays;
use super::super::names::ForCamera;
use super::super::rules::KeepOutFrame;
use super::super::surface::ConfirmRules;
use super::super::*;
use crate::control::Control;

const START_MS: i64 = 1_000_000;

/// Something that happens. `age` is that of a stamp, and negative for one from the future; `None`: no stamp.
#[derive(Clone, Debug)]
enum Event {
    Wait(u16),
    Pause(u16),
    Jump { ms: i64, is_told: bool },
    Mask { tracker: usize, is_valid: bool, age: Option<i64> },
    TrackerComes(usize),
    TrackerLeaves(usize),
    Head { age: i64 },
    Path { age: Option<i64> },
    Camera { is_there: bool },
    Black { all: bool, on: bool },
    Rename,
    Reload,
    Restart,
    MasterGone,
}

fn event() -> impl Strategy<Value = Event> {
    let age = || prop_oneof![6 => 0..300_i64, 1 => 900..1100_i64, 1 => -3000..3000_i64];
    let stamp = move || prop_oneof![2 => age().prop_map(Some), 1 => Just(None)];
    prop_oneof![
        8 => (0..600_u16).prop_map(Event::Wait),
        1 => (600..8000_u16).prop_map(Event::Pause),
        1 => (-5000..5000_i64, any::<bool>()).prop_map(|(ms, is_told)| Event::Jump { ms, is_told: is_told && ms < 0 }),
        8 => (0..2_usize, prop::bool::weighted(0.9), stamp())
            .prop_map(|(tracker, is_valid, age)| Event::Mask { tracker, is_valid, age }),
        1 => (0..2_usize).prop_map(Event::TrackerComes),
        1 => (0..2_usize).prop_map(Event::TrackerLeaves),
        6 => age().prop_map(|age| Event::Head { age }),
        3 => stamp().prop_map(|age| Event::Path { age }),
        1 => any::<bool>().prop_map(|is_there| Event::Camera { is_there }),
        2 => (any::<bool>(), prop::bool::weighted(0.3)).prop_map(|(all, on)| Event::Black { all, on }),
        1 => Just(Event::Rename),
        1 => Just(Event::Reload),
        1 => Just(Event::Restart),
        1 => Just(Event::MasterGone),
    ]
}

/// The program's state of light, and the oracle beside it.
struct Walk {
    oracle: Oracle,
    start: Instant,
    folder: tempfile::TempDir,
    name: &'static str,
    control: Control,
    safety: Safety,
    scene: SceneState,
    pulse: Pulse,
    /// Grants of before: the oracle's end and words of then.
    granted: Vec<(Grant, i64, u32)>,
    lit: usize,
}

fn scene() -> SceneState {
    let config = "
Visualization Manager:
  Global Options: {Fixed Frame: map}
  Displays:
  - {Class: rviz/Path, Name: path, Enabled: true, Topic: /path}
  - {Class: rviz_camera_stream/CameraPub, Name: cam, Enabled: true, Image Topic: /a, Camera Info Topic: /info}
";
    let config = rcs_rviz_config::parse(config, "test").unwrap();
    SceneState::new(&config, None, MeshStore::new(PackageIndex::new([])))
}

fn safety() -> Safety {
    let mut limits = AgeLimits::off();
    limits.set("1".parse::<StaleTimeout>().unwrap(), |topic| Ok::<_, String>(topic.to_owned())).unwrap();
    Safety::new(Rules {
        limits,
        orientations: Vec::new(),
        blends: Vec::new(),
        painted_masks: Vec::new(),
        mask_topics: vec![ForCamera { camera: None, value: "/mask".to_owned() }],
        keep_out: vec![KeepOutFrame { frame: "head".to_owned(), radius_m: 0.2 }],
        is_required: true,
        confirm: ConfirmRules { surfaces: Vec::new(), displays: ConfirmedDisplays::All, settings: Default::default() },
    })
}

impl Walk {
    fn new() -> Self {
        // In memory, where writing takes no time.
        let memory = std::path::Path::new("/dev/shm");
        let folder = if memory.is_dir() { tempfile::tempdir_in(memory) } else { tempfile::tempdir() };
        let (folder, start) = (folder.unwrap(), Instant::now());
        let control = Control::for_test(BlackoutFile::of_node(Some(folder.path()), "/eye"));
        control.set_cameras(["cam"].into_iter());
        let oracle = Oracle { ahead: START_MS, has_camera: true, ..Oracle::default() };
        let (safety, scene, pulse) = (safety(), scene(), Pulse::start(start));
        Self { oracle, start, folder, name: "cam", control, safety, scene, pulse, granted: Vec::new(), lit: 0 }
    }

    fn steady(&self) -> Instant {
        self.start + Duration::from_millis(self.oracle.now as u64)
    }

    fn ros_ms(&self) -> i64 {
        self.oracle.now + self.oracle.ahead
    }

    /// The header of a message, and what the oracle sees of it.
    fn header(&self, frame: &str, age: Option<i64>, is_valid: bool) -> (Header, Seen) {
        let stamp = age.map(|age| self.ros_ms() - age);
        let mut header = Header { frame_id: frame.to_owned(), ..Header::default() };
        if let Some(ms) = stamp {
            (header.stamp.sec, header.stamp.nsec) = ((ms / 1000) as u32, (ms % 1000) as u32 * 1_000_000);
        }
        (header, Seen { is_valid, stamp, at: self.oracle.now })
    }

    fn wait(&mut self, ms: u16, has_beats: bool) {
        for _ in 0..ms {
            self.oracle.now += 1;
            if has_beats && self.oracle.now % 100 == 0 {
                self.pulse.beat(self.steady());
            }
        }
        if has_beats {
            self.pulse.beat(self.steady());
        } else {
            self.oracle.resumed = Some(self.oracle.now);
        }
    }

    fn happen(&mut self, event: &Event) {
        match *event {
            Event::Wait(ms) => self.wait(ms, true),
            Event::Pause(ms) => self.wait(ms, false),
            Event::Jump { ms, is_told } => {
                self.oracle.ahead += ms;
                if is_told {
                    self.safety.reset();
                    self.scene.reset();
                    self.oracle.forget();
                }
            }
            Event::Mask { tracker, is_valid, age } => {
                let (header, seen) = self.header("lens", age, is_valid);
                let encoding = if is_valid { "mono8" } else { "bgr8" };
                let image = Image::new(header, [1, 1], encoding, 3, Arc::new(vec![255; 3]));
                self.safety.take_image("/mask", &image, &format!("/tracker{tracker}").into(), self.steady());
                self.oracle.masks[tracker] = Some(seen);
            }
            Event::TrackerComes(tracker) => {
                self.oracle.masks[tracker].get_or_insert(Seen::NONE);
            }
            Event::TrackerLeaves(tracker) => self.oracle.masks[tracker] = None,
            Event::Head { age } => self.move_head(age),
            Event::Path { age } => self.send_path(age),
            Event::Camera { is_there } => self.oracle.has_camera = is_there,
            Event::Black { all, on } => self.black(all, on),
            Event::Rename => {
                self.name = if self.name == "cam" { "cam2" } else { "cam" };
                self.set_names();
            }
            Event::Reload => self.set_names(),
            Event::Restart => {
                self.control = Control::for_test(BlackoutFile::of_node(Some(self.folder.path()), "/eye"));
                (self.safety, self.scene) = (safety(), scene());
                self.set_names();
                self.oracle.forget();
                // What the last process has shown ended with it.
                self.granted.clear();
            }
            Event::MasterGone => self.safety.follow_publishers(|_| MaskPublishers::default(), self.steady()),
        }
    }

    fn set_names(&mut self) {
        self.control.set_cameras([self.name].into_iter());
        self.safety.set_names(&ConfigNames { cameras: vec![self.name.to_owned()], ..ConfigNames::default() });
        self.oracle.words += 1;
    }

    fn black(&mut self, all: bool, on: bool) {
        let oracle = &mut self.oracle;
        let before = (oracle.is_all_black, oracle.is_camera_black);
        match all {
            true => self.control.set_blackout(on, "/test").unwrap(),
            false => self.control.set_camera_blackout(self.name, on, "/test").unwrap(),
        }
        match (all, on) {
            (true, true) => oracle.is_all_black = true,
            (true, false) => (oracle.is_all_black, oracle.is_camera_black) = (false, false),
            (false, on) => oracle.is_camera_black = on,
        }
        if before != (oracle.is_all_black, oracle.is_camera_black) {
            oracle.words += 1;
        }
    }

    fn move_head(&mut self, age: i64) {
        let (header, seen) = self.header("map", Some(age), true);
        let mut transform = geometry_msgs::TransformStamped { header, ..Default::default() };
        (transform.child_frame_id, transform.transform.rotation.w) = ("head".to_owned(), 1.0);
        self.scene.take_transforms(&TFMessage { transforms: vec![transform] }, false, "/tracker");
        if self.oracle.head.is_none_or(|newest| newest.stamp < seen.stamp) {
            self.oracle.head = Some(seen);
        }
    }

    fn send_path(&mut self, age: Option<i64>) {
        let (header, seen) = self.header("map", age, true);
        let mut path = Path { header, ..Path::default() };
        path.poses.resize_with(2, geometry_msgs::PoseStamped::default);
        let message = AnyMessage::Path(Arc::new(path));
        let ros = Time::from_nanos(self.ros_ms() * 1_000_000);
        self.scene.take_received("/path", &message, Some(self.steady()), ros);
        self.oracle.path = Some(seen);
    }

    /// Decides about the scene and a test image, and compares with the oracle.
    fn compare(&mut self) -> Result<(), TestCaseError> {
        let ros = Time::from_nanos(self.ros_ms() * 1_000_000);
        let now = Now { ros, steady: self.steady(), resumed: self.pulse.resumed(self.steady()) };
        self.scene.update(ros);
        let view = CameraView { name: self.name.to_owned(), ..self.scene.cameras()[0].clone() };
        let lit = LitView { view: &view, camera: None, unknown_lens: None, is_watched: true };
        let source = |topic: &str, _: MessageKind| {
            let publishing = Publishing { is_connected: true, is_latched: false };
            Some(TopicSource { topic: topic.to_owned(), publishing })
        };
        let trackers = (0..2).filter(|tracker| self.oracle.masks[*tracker].is_some());
        let names = trackers.map(|tracker| format!("/tracker{tracker}").into()).collect();
        // The master is asked after all that was sent.
        let publishers = MaskPublishers { names, listed_at: Some(now.steady + Duration::from_millis(1)) };
        self.safety.follow_publishers(|_| publishers.clone(), now.steady);
        let mut light = self.safety.assess(&self.scene, &[lit], source, now).remove(0);
        let no_camera = || Condition::Dark("no pose".to_owned());
        let camera = if self.oracle.has_camera { Condition::Always } else { no_camera() };
        light.evidence.set(DarkCause::NoCamera, camera);
        for (grant, end, words) in &self.granted {
            let is_allowed = self.oracle.now < *end && *words == self.oracle.words;
            prop_assert!(!grant.is_valid(now.steady) || is_allowed, "a grant of before");
        }
        for content in [Content::Scene, Content::Test] {
            let end = self.oracle.allowed_until(content == Content::Test);
            let operator = self.control.of_camera(self.name).light;
            let decided = light.evidence.decide(content, [1, 1], operator, now.steady);
            let Ok(grant) = decided else { continue };
            prop_assert!(end.is_some(), "{content:?} is lit and must be dark");
            let end = end.unwrap_or_default();
            prop_assert!(
                grant.until() <= self.start + Duration::from_millis(end as u64),
                "{content:?} is lit too long"
            );
            self.lit += 1;
            self.granted.push((grant, end, self.oracle.words));
        }
        let count = self.granted.len();
        self.granted.drain(..count.saturating_sub(8));
        Ok(())
    }
}

#[test]
fn no_walk_gets_light_that_the_rules_do_not_allow() {
    let cases = if std::env::var_os("MANY_SEEDS").is_some() { 100_000 } else { 400 };
    let lit = std::cell::Cell::new(0_usize);
    let config = ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() };
    proptest!(config, |(events in prop::collection::vec(event(), 1..60))| {
        let mut walk = Walk::new();
        for event in &events {
            walk.happen(event);
            walk.compare()?;
        }
        lit.set(lit.get() + walk.lit);
    });
    // A light that is never granted would pass, too.
    assert!(lit.get() > cases as usize, "{} grants in {cases} walks", lit.get());
}
