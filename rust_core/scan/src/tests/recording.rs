//! Scans of recordings: a slide show that the simulated camera saw.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;
use std::time::{Duration, Instant};

use rcs_calibration::patterns::{gray_code, Pattern};
use rcs_calibration::Lens;
use rcs_files::projector::ProjectorFile;
use rcs_messages::std_msgs::{self, Header};
use rcs_messages::{Image, Time};
use rcs_scan_simulator::Conditions;
use rcs_test_support::BagWriter;
use tempfile::TempDir;

use super::world::{Faults, Showing, SimulatedCamera, World, PROJECTOR_PX};
use super::{is_refused, shares};
use crate::devices::{CameraTopics, DepthTopic, ScanCamera};
use crate::failure::ScanFailure;
use crate::finish::ScanResult;
use crate::recorded::{scan, BagFootage, PatternSequenceError, RecordedOptions};
use crate::session::ScanEvent;

/// An image and the time that it is shown for.
type Slide = (Showing, Duration);

const SECOND: Duration = Duration::from_secs(1);
/// Times to show each pattern and each mark.
const SHOWN: Duration = Duration::from_millis(500);
const PAUSE: Duration = Duration::from_millis(300);
/// Before the show and after it, nothing is shown.
const IDLE: Slide = (Showing::Pattern(Pattern::Black), SECOND);

/// The bag of a camera, with the images that were shown.
struct Recording {
    folder: TempDir,
    lens: Lens,
    has_topic: bool,
    start: Duration,
    world: Rc<RefCell<World>>,
}

impl Recording {
    fn of(faults: Faults, slides: &[Slide]) -> Self {
        let world = World::new(faults);
        let mut camera = SimulatedCamera(world.clone());
        let lens = camera.lens();
        let folder = tempfile::tempdir().unwrap();
        let mut bag = BagWriter::create(folder.path().join("scan.bag")).unwrap();
        let began = camera.now();
        let time = |now: Instant| Time::from_nanos(100_000_000_000 + (now - began).as_nanos() as i64);
        let info = ProjectorFile::from_lens(&lens, "camera_optical").camera_info;
        bag.write("/camera/camera_info", true, time(began), &info).unwrap();
        // Of another type than the camera's, so that they do not count.
        for topic in ["/camera/camera_info", "/camera/image", "/camera/depth", "/shown"] {
            bag.write(topic, false, time(began), &std_msgs::String::default()).unwrap();
        }
        let image = |size_px: [u32; 2], encoding: &str, data: Vec<u8>| {
            let step = data.len() as u32 / size_px[1];
            Image::new(Header::default(), size_px, encoding, step, Arc::new(data))
        };
        let mut until = began;
        for (showing, duration) in slides {
            let shown = match showing {
                Showing::Pattern(pattern) => pattern.image(PROJECTOR_PX),
                Showing::Mark | Showing::Image(_) => vec![1; (PROJECTOR_PX[0] * PROJECTOR_PX[1]) as usize],
            };
            bag.write("/shown", true, time(camera.now()), &image(PROJECTOR_PX, "mono8", shown)).unwrap();
            world.borrow_mut().show(*showing);
            until += *duration;
            while camera.now() < until {
                let now = camera.now();
                let frame = camera.frame(now, SECOND).unwrap();
                let at = time(frame.received);
                bag.write("/camera/image", false, at, &image(frame.size_px, "mono8", frame.grey)).unwrap();
                if let Some(depth) = camera.depth().unwrap() {
                    let data = depth.depth_m.iter().flat_map(|depth| depth.to_le_bytes()).collect();
                    bag.write("/camera/depth", false, at, &image(depth.size_px, "32FC1", data)).unwrap();
                }
            }
        }
        bag.finish().unwrap();
        Self { folder, lens, has_topic: true, start: Duration::ZERO, world }
    }

    fn without_topic(self) -> Self {
        Self { has_topic: false, ..self }
    }

    fn scan(&self) -> (Result<ScanResult, ScanFailure>, Vec<String>) {
        let topics = CameraTopics {
            image: "/camera/image".to_owned(),
            camera_info: "/camera/camera_info".to_owned(),
            depth: DepthTopic::Image("/camera/depth".to_owned()),
        };
        let shown = self.has_topic.then_some("/shown");
        let footage = BagFootage::open(&[self.folder.path().join("scan.bag")], &topics, shown, self.start).unwrap();
        let mut warnings = Vec::new();
        let patterns = gray_code(PROJECTOR_PX);
        let options = RecordedOptions { projector_px: PROJECTOR_PX, patterns, frames: 3 };
        let result = scan(&footage, &options, &mut |event| {
            if let ScanEvent::Warning(warning) = event {
                warnings.push(warning.to_owned());
            }
        });
        (result, warnings)
    }

    /// Scans and asserts that much is decoded, and correctly.
    fn is_decoded(&self) {
        let (result, warnings) = self.scan();
        let scanned = result.unwrap();
        assert!(scanned.ended.is_none() && warnings.is_empty(), "{warnings:?}");
        let (decoded, right) = shares(&scanned.decoded, &self.world.borrow());
        assert!(decoded > 0.8 && right > 0.99, "{decoded} {right}");
        let depth_m = scanned.capture.depth_m.unwrap();
        assert!(depth_m.iter().filter(|depth| **depth > 0.5).count() * 2 > depth_m.len());
        assert_eq!((scanned.capture.images.len(), scanned.capture.camera), (gray_code(PROJECTOR_PX).len(), self.lens));
    }

    fn failure(&self) -> ScanFailure {
        let Err(failure) = self.scan().0 else { panic!("the scan was accepted") };
        assert!(!failure.to_string().contains('\n'));
        failure
    }
}

/// All patterns in their order.
fn in_order() -> Vec<Slide> {
    let patterns = gray_code(PROJECTOR_PX).into_iter().map(|pattern| (Showing::Pattern(pattern), SHOWN));
    std::iter::once(IDLE).chain(patterns).chain([IDLE]).collect()
}

/// All patterns with marks before, between and after them.
fn with_marks() -> Vec<Slide> {
    let mut slides = vec![IDLE];
    for pattern in gray_code(PROJECTOR_PX) {
        slides.extend([(Showing::Mark, PAUSE), (Showing::Pattern(pattern), SHOWN)]);
    }
    slides.extend([(Showing::Mark, PAUSE), IDLE]);
    slides
}

/// As a live scan shows them: black and white in turn first, white in the end.
fn as_live() -> Vec<Slide> {
    let [black, white] = [Pattern::Black, Pattern::White].map(|pattern| (Showing::Pattern(pattern), SECOND));
    let mut slides = vec![black, white, black, white];
    slides.extend(in_order().into_iter().skip(1));
    slides.pop();
    slides.push(white);
    slides
}

#[test]
fn patterns_between_marks_are_found_however_late_they_are_seen() {
    for lag_millis in [33, 800] {
        let faults = Faults { lag: Duration::from_millis(lag_millis), ..Faults::default() };
        Recording::of(faults, &with_marks()).without_topic().is_decoded();
    }
}

#[test]
fn rooms_and_lights_of_all_kinds_can_be_recorded() {
    for seed in 0..4 {
        let conditions = Conditions::random(seed);
        let recording = Recording::of(Faults { seed, conditions, ..Faults::default() }, &with_marks()).without_topic();
        let (result, _) = recording.scan();
        let (decoded, right) = shares(&result.unwrap().decoded, &recording.world.borrow());
        assert!(decoded > 0.6 && right > 0.95, "seed {seed}: {decoded} {right}");
    }
}

#[test]
fn patterns_one_after_the_other_are_found() {
    Recording::of(Faults::default(), &in_order()).without_topic().is_decoded();
}

#[test]
fn patterns_on_a_topic_are_found_in_any_order() {
    Recording::of(Faults::default(), &as_live()).is_decoded();
    let mut slides = as_live();
    slides[6..].reverse();
    Recording::of(Faults::default(), &slides).is_decoded();
}

#[test]
fn a_show_without_one_of_the_patterns_is_refused() {
    let without = |mut slides: Vec<Slide>, index: usize| {
        slides.remove(index);
        slides
    };
    let missing = |slides: Vec<Slide>| Recording::of(Faults::default(), &slides);
    // Both a pattern and the mark before it.
    let failure = missing(without(without(with_marks(), 12), 11)).without_topic().failure();
    let patterns = gray_code(PROJECTOR_PX).len();
    let ScanFailure::Sequence(PatternSequenceError::BetweenMarks { seen, .. }) = &failure else { panic!("{failure}") };
    assert!(*seen == patterns - 1 && failure.to_string().contains("--start"), "{failure}");
    let failure = missing(without(in_order(), 6)).without_topic().failure();
    assert!(matches!(failure, ScanFailure::Sequence(PatternSequenceError::NotInOrder { .. })), "{failure}");
    let failure = missing(without(in_order(), 6)).failure();
    assert!(matches!(failure, ScanFailure::Sequence(PatternSequenceError::NotShown { missing: 1, .. })), "{failure}");
    assert!(is_refused(&failure));
}

#[test]
fn patterns_in_another_order_are_refused() {
    let mut slides = with_marks();
    // The marks stay where they are; the stripes move by one.
    let stripes: Vec<usize> = (6..slides.len() - 2).step_by(2).collect();
    let first = slides[stripes[0]];
    for pair in stripes.windows(2) {
        slides[pair[0]] = slides[pair[1]];
    }
    slides[stripes[stripes.len() - 1]] = first;
    let failure = Recording::of(Faults::default(), &slides).without_topic().failure();
    assert!(matches!(failure, ScanFailure::Sequence(PatternSequenceError::NoPair { .. })), "{failure}");
    assert!(is_refused(&failure));
}

#[test]
fn two_shows_are_refused_unless_the_first_is_skipped() {
    let twice = [in_order(), in_order()].concat();
    let failure = Recording::of(Faults::default(), &twice).without_topic().failure();
    let ScanFailure::Sequence(PatternSequenceError::Ambiguous(one, other)) = failure else { panic!("{failure}") };
    assert!(one > SECOND / 2 && other > one + 15 * SECOND, "{one:?} {other:?}");
    let failure = Recording::of(Faults::default(), &[with_marks(), with_marks()].concat()).without_topic().failure();
    assert!(matches!(failure, ScanFailure::Sequence(PatternSequenceError::BetweenMarks { .. })), "{failure}");
}

#[test]
fn a_delay_longer_than_each_pattern_is_shown_is_refused() {
    let lag = SHOWN + Duration::from_millis(200);
    let failure = Recording::of(Faults { lag, ..Faults::default() }, &as_live()).failure();
    assert!(matches!(failure, ScanFailure::Sequence(_)), "{failure}");
}

#[test]
fn a_camera_that_moves_while_it_is_recorded_is_refused() {
    for secs in [7, 13, 19] {
        let moves_after = Some(Duration::from_secs(secs));
        for recording in [
            Recording::of(Faults { moves_after, ..Faults::default() }, &with_marks()).without_topic(),
            Recording::of(Faults { moves_after, ..Faults::default() }, &as_live()),
        ] {
            let failure = recording.failure();
            assert!(failure.to_string().contains("moved"), "{secs}: {failure}");
            assert!(is_refused(&failure));
        }
    }
}

#[test]
fn a_recorded_camera_that_adapts_its_exposure_is_refused() {
    for millis in [80, 300, 900] {
        let adapts_within = Some(Duration::from_millis(millis));
        for slides in [with_marks(), as_live()] {
            let failure = Recording::of(Faults { adapts_within, ..Faults::default() }, &slides).failure();
            assert!(is_refused(&failure), "{millis}");
        }
    }
}

#[test]
fn a_mirrored_image_is_refused_from_a_recording() {
    let image_from_panel = Conditions::mirrored(PROJECTOR_PX[0]);
    let conditions = Conditions { image_from_panel, ..Faults::default().conditions };
    let failure = Recording::of(Faults { conditions, ..Faults::default() }, &with_marks()).without_topic().failure();
    assert!(matches!(failure, ScanFailure::Mirrored) && is_refused(&failure));
}

#[test]
fn a_dark_or_empty_recording_is_refused() {
    let failure = Recording::of(Faults { is_dark: true, ..Faults::default() }, &with_marks()).without_topic().failure();
    assert!(matches!(failure, ScanFailure::NoLight { .. }), "{failure}");
    let start = 2 * SECOND;
    let failure = Recording { start, ..Recording::of(Faults::default(), &[IDLE]) }.without_topic().failure();
    assert!(matches!(failure, ScanFailure::NoLight { .. }), "{failure}");
}
