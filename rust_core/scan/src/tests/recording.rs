//! Scans of recordings: a slide show that the simulated camera saw.

use std::cell::RefCell;
use std::ops::Range;
use std::rc::Rc;
use std::time::Duration;

use rcs_calibration::patterns::{gray_code, Pattern};
use rcs_calibration::Lens;
use rcs_scan_simulator::Conditions;

use super::world::{Faults, Showing, SimulatedCamera, World, PROJECTOR_PX};
use super::{is_refused, shares};
use crate::devices::{DepthFrame, ScanCamera};
use crate::failure::ScanFailure;
use crate::finish::ScanResult;
use crate::recorded::footage::{Footage, ShownPicture, VisitDepth, VisitFrame};
use crate::recorded::{scan, PatternSequenceError, RecordedOptions};
use crate::session::ScanEvent;

/// A picture and the time that it is shown for.
type Slide = (Showing, Duration);

const SECOND: Duration = Duration::from_secs(1);
/// Times to show each pattern and each mark.
const SHOWN: Duration = Duration::from_millis(500);
const PAUSE: Duration = Duration::from_millis(300);
/// Before the show and after it, nothing is shown.
const IDLE: Slide = (Showing::Pattern(Pattern::Black), SECOND);

/// The recording of a camera, and perhaps of the pictures that were shown.
struct Recording {
    lens: Lens,
    pictures: Vec<(Duration, Vec<u8>)>,
    depths: Vec<(Duration, DepthFrame)>,
    shown: Option<Vec<(Duration, Showing)>>,
    world: Rc<RefCell<World>>,
}

impl Recording {
    fn of(faults: Faults, slides: &[Slide]) -> Self {
        let world = World::new(faults);
        let mut camera = SimulatedCamera(world.clone());
        let began = camera.now();
        let (mut pictures, mut depths, mut shown) = (Vec::new(), Vec::new(), Vec::new());
        let mut until = began;
        for (showing, time) in slides {
            shown.push((camera.now() - began, *showing));
            world.borrow_mut().show(*showing);
            until += *time;
            while camera.now() < until {
                let now = camera.now();
                let frame = camera.frame(now, SECOND).unwrap();
                pictures.push((frame.received - began, frame.grey));
                depths.extend(camera.depth().unwrap().map(|depth| (frame.received - began, depth)));
            }
        }
        Self { lens: camera.lens(), pictures, depths, shown: Some(shown), world }
    }

    fn scan(&self) -> (Result<ScanResult, ScanFailure>, Vec<String>) {
        self.scan_as(gray_code(PROJECTOR_PX))
    }

    fn scan_as(&self, patterns: Vec<Pattern>) -> (Result<ScanResult, ScanFailure>, Vec<String>) {
        let mut warnings = Vec::new();
        let options = RecordedOptions { projector_px: PROJECTOR_PX, patterns, frames: 3 };
        let result = scan(self, &options, &mut |event| {
            if let ScanEvent::Warning(warning) = event {
                warnings.push(warning.to_owned());
            }
        });
        (result, warnings)
    }

    fn without_topic(self) -> Self {
        Self { shown: None, ..self }
    }

    /// Scans and asserts that much is decoded, and correctly.
    fn is_decoded(&self) {
        let (result, warnings) = self.scan();
        let scanned = result.unwrap();
        assert!(scanned.is_complete && warnings.is_empty(), "{warnings:?}");
        let (decoded, right) = shares(&scanned.decoded, &self.world.borrow());
        assert!(decoded > 0.8 && right > 0.99, "{decoded} {right}");
        let depth_m = scanned.capture.depth_m.unwrap();
        assert!(depth_m.iter().filter(|depth| **depth > 0.5).count() * 2 > depth_m.len());
        assert_eq!(
            (scanned.capture.pictures.len(), scanned.capture.camera),
            (gray_code(PROJECTOR_PX).len(), self.lens)
        );
    }

    fn failure(&self) -> ScanFailure {
        let Err(failure) = self.scan().0 else { panic!("the scan was accepted") };
        assert!(!failure.to_string().contains('\n'));
        failure
    }
}

impl Footage for Recording {
    fn name(&self) -> String {
        "scan.bag".to_owned()
    }

    fn lens(&self) -> Lens {
        self.lens
    }

    fn frame_id(&self) -> String {
        "camera_optical".to_owned()
    }

    fn frames(&self, wanted: &dyn Fn(usize) -> bool, visit: &mut VisitFrame<'_>) -> Result<(), ScanFailure> {
        let wanted = self.pictures.iter().enumerate().filter(|(number, _)| wanted(*number));
        for (number, (time, grey)) in wanted {
            visit(number, *time, self.lens.size_px, grey.clone())?;
        }
        Ok(())
    }

    fn has_depth(&self) -> bool {
        true
    }

    fn depths(&self, during: Range<Duration>, visit: &mut VisitDepth<'_>) -> Result<(), ScanFailure> {
        self.depths.iter().filter(|(time, _)| during.contains(time)).try_for_each(|(_, depth)| visit(depth.clone()))
    }

    fn shown(&self, recognise: &dyn Fn(&[u8]) -> Option<Pattern>) -> Result<Option<Vec<ShownPicture>>, ScanFailure> {
        let pattern = |showing: &Showing| match showing {
            Showing::Pattern(pattern) => recognise(&pattern.picture(PROJECTOR_PX)),
            Showing::Mark | Showing::Picture(_) => None,
        };
        let shown = |(at, showing): &(Duration, Showing)| ShownPicture { at: *at, pattern: pattern(showing) };
        Ok(self.shown.as_ref().map(|all| all.iter().map(shown).collect()))
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
    let ScanFailure::Sequence(PatternSequenceError::Ambiguous { one, other }) = failure else { panic!("{failure}") };
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
fn a_mirrored_picture_is_refused_from_a_recording() {
    let picture_from_panel = Conditions::mirrored(PROJECTOR_PX[0]);
    let conditions = Conditions { picture_from_panel, ..Faults::default().conditions };
    let failure = Recording::of(Faults { conditions, ..Faults::default() }, &with_marks()).without_topic().failure();
    assert!(matches!(failure, ScanFailure::Mirrored) && is_refused(&failure));
}

#[test]
fn a_dark_or_empty_recording_is_refused() {
    let failure = Recording::of(Faults { is_dark: true, ..Faults::default() }, &with_marks()).without_topic().failure();
    assert!(matches!(failure, ScanFailure::NoLight { .. }), "{failure}");
    let failure = Recording::of(Faults::default(), &[]).without_topic().failure();
    assert!(matches!(failure, ScanFailure::NoLight { .. }), "{failure}");
}
