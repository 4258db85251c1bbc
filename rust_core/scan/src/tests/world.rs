//! A simulated projector and camera. Time passes only while the session waits for a frame.

use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;
use std::time::{Duration, Instant};

use nalgebra::Vector2;
use rcs_calibration::patterns::Pattern;
use rcs_calibration::Lens;
use rcs_scan_simulator::{Conditions, DepthCamera, Motion, Random, Rig, Room, Scan, View};

use crate::devices::{CameraFrame, DepthFrame, ProjectorScreen, ScanCamera, ScanCameraError};
use crate::scan::patterns;

/// The projector's image.
pub(crate) const PROJECTOR_PX: [u32; 2] = [320, 200];
/// Time from frame to frame.
pub(crate) const PERIOD: Duration = Duration::from_millis(33);

/// An image of the projector.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Showing {
    /// A pattern.
    Pattern(Pattern),
    /// A checkerboard.
    Mark,
    /// Another image of the projector's size, by its number.
    Image(usize),
}

/// The side of the checkerboard's fields, pixels of the projector.
const FIELD_PX: f64 = 20.0;

/// Faults of the simulated projector and camera.
#[derive(Debug, Clone)]
pub(crate) struct Faults {
    /// From showing an image to the first frame that it is all of.
    pub(crate) lag: Duration,
    /// The camera takes its gain from the image, with this time constant.
    pub(crate) adapts_within: Option<Duration>,
    /// Growth of brightness in a second, as a share.
    pub(crate) drift: f64,
    /// The camera moves after this time.
    pub(crate) moves_after: Option<Duration>,
    /// The projector is off.
    pub(crate) is_dark: bool,
    /// The camera sends no frames after this time.
    pub(crate) silent_after: Option<Duration>,
    /// The size of the image that the session takes the projector to have.
    pub(crate) assumed_px: [u32; 2],
    /// Seed of the room and of the places of camera and projector.
    pub(crate) seed: u64,
    /// Light, lenses and sensor; motion and drift are those of the fields above.
    pub(crate) conditions: Conditions,
    /// Width and height of the camera's images, pixels.
    pub(crate) camera_px: [u32; 2],
    /// The camera sends images of this size.
    pub(crate) frame_px: Option<[u32; 2]>,
    /// Frames from one depth image to the next; `None` without depth.
    pub(crate) depth_every: Option<u32>,
}

impl Default for Faults {
    fn default() -> Self {
        Self {
            lag: Duration::from_millis(150),
            adapts_within: None,
            drift: 0.0,
            moves_after: None,
            is_dark: false,
            silent_after: None,
            assumed_px: PROJECTOR_PX,
            seed: 4,
            conditions: Conditions { sharpest_px: 0.4, ambient: 0.08, camera_blur_px: 0.3, ..Conditions::ideal() },
            camera_px: [160, 120],
            frame_px: None,
            depth_every: Some(4),
        }
    }
}

/// Everything that the screen and the camera share.
pub(crate) struct World {
    view: View,
    faults: Faults,
    known: Vec<(Pattern, Vec<u8>)>,
    /// Images that are no patterns.
    others: Vec<Vec<u8>>,
    /// The shown images and their times.
    shown: Vec<(Instant, Showing)>,
    /// The images of each of them, before and after the camera has moved.
    seen: HashMap<(Showing, bool), Vec<u8>>,
    started: Instant,
    now: Instant,
    frames: u32,
    gain: f64,
    depth: Vec<Vec<f32>>,
}

impl World {
    pub(crate) fn new(faults: Faults) -> Rc<RefCell<Self>> {
        let mut rig = Rig::random(faults.seed);
        let [width, height] = faults.camera_px.map(f64::from);
        rig.camera = Lens::pinhole(faults.camera_px, [0.85 * width; 2], [width / 2.0 - 0.5, height / 2.0 - 0.5]);
        rig.projector = Lens::pinhole(PROJECTOR_PX, [340.0, 340.0], [159.5, 120.0]);
        let view = View::new(&Room::cluttered(faults.seed), &rig);
        let known = patterns(faults.assumed_px, 1).into_iter();
        let known = known.map(|pattern| (pattern, pattern.image(faults.assumed_px))).collect();
        let depth = (0..4).map(|seed| DepthCamera::kinect(seed).capture(&view)).collect();
        let now = Instant::now();
        Rc::new(RefCell::new(Self {
            view,
            known,
            others: Vec::new(),
            shown: Vec::new(),
            seen: HashMap::new(),
            started: now,
            now,
            frames: 0,
            gain: 1.0,
            depth,
            faults,
        }))
    }

    /// Number of images that were shown.
    pub(crate) fn shown(&self) -> usize {
        self.shown.len()
    }

    /// Time since the beginning.
    pub(crate) fn elapsed(&self) -> Duration {
        self.now - self.started
    }

    /// The poses and lenses of camera and projector.
    pub(crate) fn rig(&self) -> &Rig {
        self.view.rig()
    }

    /// The projector pixel that lights a camera pixel.
    pub(crate) fn truth(&self, pixel: usize) -> Option<[f64; 2]> {
        let width = self.view.size_px()[0];
        self.view.truth(pixel as u32 % width, pixel as u32 / width).map(|truth| [truth.x, truth.y])
    }

    /// The image of the image that was shown at a time.
    fn sees(&mut self, at: Instant) -> Vec<u8> {
        let shown = self.shown.iter().rev().find(|(from, _)| *from <= at).map(|(_, showing)| *showing);
        let showing = shown.filter(|_| !self.faults.is_dark).unwrap_or(Showing::Pattern(Pattern::Black));
        let has_moved = self.faults.moves_after.is_some_and(|after| at > self.started + after);
        self.sees_of(showing, has_moved)
    }

    fn sees_of(&mut self, showing: Showing, has_moved: bool) -> Vec<u8> {
        if let Some(seen) = self.seen.get(&(showing, has_moved)) {
            return seen.clone();
        }
        let motion = has_moved.then(|| Motion { from_image: 0, shift_px: Vector2::new(2.0, 1.0) });
        let scan = || Scan::new(&self.view, Conditions { motion, ..self.still() });
        let seen = match showing {
            Showing::Pattern(pattern) => scan().capture(&pattern, 0),
            Showing::Image(number) => {
                let scan = scan();
                scan.expose(&scan.light_of(&self.others[number]), 0)
            }
            Showing::Mark => {
                let [mut seen, white] =
                    [Pattern::Black, Pattern::White].map(|pattern| self.sees_of(Showing::Pattern(pattern), has_moved));
                for (pixel, level) in seen.iter_mut().enumerate() {
                    let is_lit = |[u, v]: [f64; 2]| ((u / FIELD_PX).floor() + (v / FIELD_PX).floor()) % 2.0 == 0.0;
                    if self.truth(pixel).is_some_and(is_lit) {
                        *level = white[pixel];
                    }
                }
                seen
            }
        };
        self.seen.insert((showing, has_moved), seen.clone());
        seen
    }

    /// Shows something from now on.
    pub(crate) fn show(&mut self, showing: Showing) {
        self.shown.push((self.now, showing));
    }

    /// The conditions without noise from frame to frame.
    fn still(&self) -> Conditions {
        Conditions { full_well: f64::INFINITY, flicker: 0.0, ..self.faults.conditions.clone() }
    }

    /// The next frame: half of it was exposed a period earlier.
    fn expose(&mut self) -> Vec<u8> {
        self.now += PERIOD;
        self.frames += 1;
        let at = self.now - self.faults.lag + PERIOD;
        let (late, early) = (self.sees(at), self.sees(at - PERIOD));
        let drift = 1.0 + self.faults.drift * self.elapsed().as_secs_f64();
        let mut random = Random::new(&[u64::from(self.frames)]);
        let Conditions { flicker, full_well, read_noise, .. } = self.faults.conditions;
        let gain = self.gain * drift * (1.0 + flicker * random.normal());
        let level = |(late, early): (&u8, &u8)| {
            let light = 0.5 * (f64::from(*late) + f64::from(*early));
            let noise = 255.0 * (light / 255.0 * full_well + read_noise.powi(2)).sqrt() / full_well;
            let noise = if noise.is_finite() { noise } else { 0.8 };
            (gain * light + noise * random.normal()).round().clamp(0.0, 255.0) as u8
        };
        let grey: Vec<u8> = late.iter().zip(&early).map(level).collect();
        if let Some(within) = self.faults.adapts_within {
            let mean = grey.iter().map(|level| f64::from(*level)).sum::<f64>() / grey.len() as f64;
            let share = PERIOD.as_secs_f64() / within.as_secs_f64();
            self.gain *= (60.0 / mean.max(1.0)).powf(share.min(1.0));
            self.gain = self.gain.clamp(0.2, 4.0);
        }
        grey
    }
}

/// The projector.
pub(crate) struct SimulatedScreen(pub(crate) Rc<RefCell<World>>);

impl ProjectorScreen for SimulatedScreen {
    fn name(&self) -> String {
        "the simulated projector".to_owned()
    }

    fn show(&mut self, image: Vec<u8>) -> anyhow::Result<()> {
        let world = &mut *self.0.borrow_mut();
        let pattern = world.known.iter().find(|(_, known)| *known == image).map(|(pattern, _)| *pattern);
        let showing = pattern.map_or(Showing::Image(world.others.len()), Showing::Pattern);
        if pattern.is_none() {
            world.others.push(image);
        }
        world.show(showing);
        Ok(())
    }
}

/// The camera.
pub(crate) struct SimulatedCamera(pub(crate) Rc<RefCell<World>>);

impl ScanCamera for SimulatedCamera {
    fn now(&self) -> Instant {
        self.0.borrow().now
    }

    fn lens(&self) -> Lens {
        self.0.borrow().view.rig().camera
    }

    fn frame_id(&self) -> String {
        "camera_optical".to_owned()
    }

    fn frame(&mut self, after: Instant, timeout: Duration) -> Result<CameraFrame, ScanCameraError> {
        let world = &mut *self.0.borrow_mut();
        loop {
            let grey = world.expose();
            if world.faults.silent_after.is_some_and(|after| world.elapsed() > after) {
                return Err(ScanCameraError::Silent {
                    topic: "/camera/image".to_owned(),
                    waited: timeout,
                    reason: "it has fallen silent".to_owned(),
                    known_topics: Vec::new(),
                });
            }
            if world.now > after {
                let size_px = world.faults.frame_px.unwrap_or(world.view.size_px());
                return Ok(CameraFrame { size_px, grey, received: world.now });
            }
        }
    }

    fn has_depth(&self) -> bool {
        self.0.borrow().faults.depth_every.is_some()
    }

    fn depth(&mut self) -> Result<Option<DepthFrame>, ScanCameraError> {
        let world = self.0.borrow();
        let is_due = world.faults.depth_every.is_some_and(|every| world.frames.is_multiple_of(every));
        let depth_m = || world.depth[world.frames as usize % world.depth.len()].clone();
        Ok(is_due.then(|| DepthFrame { size_px: world.view.size_px(), depth_m: depth_m() }))
    }
}
