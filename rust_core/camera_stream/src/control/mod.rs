//! The operator's words: blackout, pause, test images and brightness, of all cameras and of each.
//!
//! ```text
//!  services, dynamic_reconfigure, keys of windows, page ─► Control ─┬─► control thread: black at once
//!                                                                   └─► Generation: voids the grants before it
//! ```
//!
//! Nothing else holds such state. A camera is black while all cameras or it are blacked out. Black is no toggle: it is
//! said any number of times and released by another act. `~blackout false` releases all; what is of one camera is
//! released for that camera. Blackouts are kept in a file before they are acknowledged, so that a node which ends
//! during one does not come back lit, and written to the parameter server for others to read.

pub(crate) mod brightness;
pub(crate) mod cues;
pub(crate) mod pattern;

use std::fmt;
use std::sync::{Arc, Mutex};
use std::time::Instant;

use rcs_light::{BlackoutFile, Blackouts, DarkCause, DarkReason, Generation};
use rcs_process::lock;
use rcs_ros::{ParameterValue, RosNode};
use rcs_window::test_images::TestImage;
use rcs_window::WindowKey;

use crate::options::arguments::LightArgs;
use brightness::{BrightnessSetting, Fade};
use pattern::Pattern;

/// Parameter of `~blackout`, and of a camera's own below its name.
pub(crate) const BLACKOUT: &str = "blackout";

/// The operator's words. Cheap to read from any thread.
pub(crate) struct Control {
    state: Mutex<ControlledState>,
    file: Mutex<KeptBlackouts>,
    /// Sets the parameter of `~blackout`.
    tell: Box<dyn Fn(bool) + Send + Sync>,
    wake: Box<dyn Fn() + Send + Sync>,
}

/// The file, and the number of the blackouts in it.
struct KeptBlackouts {
    file: BlackoutFile,
    number: u64,
}

#[derive(Default)]
struct ControlledState {
    blackouts: Blackouts,
    /// Counts what was said about blackouts, also where that changed nothing.
    number: u64,
    /// Who has paused all cameras.
    paused: Option<String>,
    test_image: Option<TestImage>,
    /// The pattern that came last.
    pattern: Option<Arc<Pattern>>,
    brightness: BrightnessSetting,
    cameras: Vec<CameraState>,
    has_changed: bool,
}

/// The part of one camera.
#[derive(Default)]
struct CameraState {
    name: String,
    is_paused: bool,
    test_image: Option<TestImage>,
    generation: Generation,
}

/// The operator's words on one camera.
#[derive(Clone, Debug)]
pub(crate) struct OperatorSettings {
    /// The generation of the words, or why the operator wants no light.
    pub(crate) light: Result<Generation, DarkReason>,
    /// `true` if the camera itself is blacked out.
    pub(crate) is_switched_off: bool,
    /// Who has paused it.
    pub(crate) paused: Option<String>,
    /// The test image in place of the scene.
    pub(crate) test_image: Option<TestImage>,
    /// The pattern of a calibration in place of both, where it fits.
    pub(crate) pattern: Option<Arc<Pattern>>,
}

/// The operator's words on all cameras.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct ControlState {
    /// Who has blacked out all cameras.
    pub(crate) blackout: Option<String>,
    /// Who has paused all cameras.
    pub(crate) paused: Option<String>,
    /// The test image of all cameras, by its name.
    pub(crate) test_image: Option<&'static str>,
}

impl fmt::Debug for Control {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Control").field("state", &self.state()).finish_non_exhaustive()
    }
}

impl Control {
    /// The control of a node, which is woken by each change, with the blackout and the brightness of its options.
    pub(crate) fn start(ros: &Arc<RosNode>, light: &LightArgs) -> Self {
        let (writer, woken) = (Arc::downgrade(ros), Arc::downgrade(ros));
        let tell = move |is_on: bool| {
            let set =
                writer.upgrade().map(|ros| ros.set_parameter(&format!("~{BLACKOUT}"), ParameterValue::Bool(is_on)));
            if let Some(Err(error)) = set {
                log::error!("{error}");
            }
        };
        let wake = move || {
            if let Some(ros) = woken.upgrade() {
                ros.calls().wake();
                ros.events().wake();
            }
        };
        let file = BlackoutFile::of_node(rcs_ros::ros_folder().as_deref(), ros.name());
        let control = Self::new(file, tell, wake);
        let fade = Fade::steady(light.brightness);
        control.set(|state| state.brightness = BrightnessSetting { fade, fade_secs: light.fade_seconds });
        if light.blackout {
            // An error is in the log, and it is black.
            let _ = control.set_blackout(true, "~blackout at the start");
        }
        control.tell_parameter();
        control
    }

    fn new(
        file: BlackoutFile,
        tell: impl Fn(bool) + Send + Sync + 'static,
        wake: impl Fn() + Send + Sync + 'static,
    ) -> Self {
        let blackouts = file.read();
        if blackouts != Blackouts::default() {
            log::warn!("black as the last run was: {blackouts:?}; ~blackout false releases it");
        }
        let state = Mutex::new(ControlledState { blackouts, ..ControlledState::default() });
        let file = Mutex::new(KeptBlackouts { file, number: 0 });
        Self { state, file, tell: Box::new(tell), wake: Box::new(wake) }
    }

    /// A control without a node.
    #[cfg(test)]
    pub(crate) fn for_test(file: BlackoutFile) -> Self {
        Self::new(file, |_| {}, || {})
    }

    /// Writes the parameter of `~blackout`: at the start, and to a master that was restarted.
    pub(crate) fn tell_parameter(&self) {
        let is_black = lock(&self.state).blackouts.all.is_some();
        (self.tell)(is_black);
    }

    /// Takes the names of a config's cameras. While a camera that is blacked out is not among them, a new one may be
    /// the same by another name, and starts black.
    pub(crate) fn set_cameras<'c>(&self, names: impl Iterator<Item = &'c str>) {
        let names: Vec<&str> = names.collect();
        let changed = self.change(|state| {
            let black = &mut state.blackouts.cameras;
            let mut lost: Vec<String> = black.keys().filter(|black| !names.contains(&&***black)).cloned().collect();
            let new = names.iter().filter(|name| !state.cameras.iter().any(|camera| camera.name == **name));
            let heirs: Vec<&str> = new.copied().filter(|name| !black.contains_key(*name)).collect();
            lost.retain(|_| !heirs.is_empty());
            for name in heirs.into_iter().filter(|_| !lost.is_empty()) {
                log::warn!("camera {name}: black, because {} was and is not in the config any more", lost.join(", "));
                black.insert(name.to_owned(), format!("the blackout of {}", lost.join(", ")));
            }
            black.retain(|name, _| !lost.contains(name));
            // What was granted is of another config.
            state.cameras.iter_mut().for_each(|camera| camera.generation.advance());
            state.cameras.retain(|camera| names.contains(&&*camera.name));
            for name in names {
                state.camera(name);
            }
            state.number += 1;
        });
        if let Err(error) = changed {
            log::error!("{error}");
        }
    }

    /// Blacks out all cameras, or releases all blackouts: also those of single cameras.
    ///
    /// # Errors
    /// It holds, but could not be kept for the next start of the node.
    pub(crate) fn set_blackout(&self, on: bool, caller: &str) -> Result<(), String> {
        let kept = self.change(|state| state.set_blackout(on, caller));
        (self.tell)(on);
        kept
    }

    /// Blacks out a camera, or releases its own blackout.
    ///
    /// # Errors
    /// It holds, but could not be kept for the next start of the node.
    pub(crate) fn set_camera_blackout(&self, name: &str, on: bool, caller: &str) -> Result<(), String> {
        self.change(|state| state.set_camera_blackout(name, on, caller))
    }

    /// Releases a camera's own blackout, or all blackouts, as an answer to the present [`number`](Self::number).
    /// `None`: that is another one by now, and nothing was released.
    pub(crate) fn release(&self, camera: Option<&str>, number: u64, caller: &str) -> Option<Result<(), String>> {
        let mut is_answer = false;
        let kept = self.change(|state| {
            is_answer = state.number == number;
            match camera {
                _ if !is_answer => {}
                Some(name) => state.set_camera_blackout(name, false, caller),
                None => state.set_blackout(false, caller),
            }
        });
        if is_answer {
            self.tell_parameter();
        }
        is_answer.then_some(kept)
    }

    /// Pauses all cameras, or resumes them, also those that a key has paused.
    pub(crate) fn set_pause(&self, on: bool, caller: &str) {
        self.set(|state| {
            state.paused = on.then(|| caller.to_owned());
            if !on {
                state.cameras.iter_mut().for_each(|camera| camera.is_paused = false);
            }
            log::info!("all cameras: pause {} by {caller}", on_or_off(on));
        });
    }

    /// Shows the next test image in all cameras, and after the last one the scene again. Returns its name.
    pub(crate) fn next_test_image(&self, caller: &str) -> Option<&'static str> {
        self.change_test_image(TestImage::after, caller)
    }

    /// Shows a test image in all cameras, or the scene.
    pub(crate) fn set_test_image(&self, test: Option<TestImage>, caller: &str) -> Option<&'static str> {
        self.change_test_image(|_| test, caller)
    }

    fn change_test_image(
        &self,
        next: impl FnOnce(Option<TestImage>) -> Option<TestImage>,
        caller: &str,
    ) -> Option<&'static str> {
        self.set(|state| {
            state.test_image = next(state.test_image);
            state.cameras.iter_mut().for_each(|camera| camera.test_image = None);
            log_test("all cameras", state.test_image, caller);
            state.test_image.map(TestImage::name)
        })
    }

    /// Begins a fade of all cameras to another brightness, or sets the duration of later ones.
    ///
    /// # Errors
    /// A value out of its range; nothing has changed.
    pub(crate) fn set_brightness(
        &self,
        share: Option<f64>,
        fade_secs: Option<f64>,
        caller: &str,
    ) -> Result<(), String> {
        self.set(|state| {
            state.brightness = state.brightness.with(share, fade_secs, Instant::now())?;
            Ok::<_, String>(())
        })?;
        share.iter().for_each(|share| log::info!("all cameras: brightness {share} by {caller}"));
        Ok(())
    }

    /// The brightness of all cameras.
    pub(crate) fn brightness(&self) -> BrightnessSetting {
        lock(&self.state).brightness
    }

    /// Shows a pattern of a calibration for a while.
    pub(crate) fn show_pattern(&self, pattern: Pattern) {
        self.set(|state| state.pattern = Some(Arc::new(pattern)));
    }

    /// Takes a key of a camera's window: B, Shift+L, P or the space bar, T.
    pub(crate) fn press(&self, name: &str, key: WindowKey) {
        match key {
            WindowKey::Character(key @ ('b' | 'B' | 'L')) => {
                let (on, caller) = if key == 'L' { (false, "key Shift+L") } else { (true, "key b") };
                if let Err(error) = self.set_camera_blackout(name, on, caller) {
                    log::error!("camera {name}: {error}");
                }
            }
            WindowKey::Space | WindowKey::Character('p' | 'P') => self.set(|state| {
                let camera = state.camera(name);
                camera.is_paused ^= true;
                log::info!("camera {name}: pause {} by key p", on_or_off(camera.is_paused));
            }),
            WindowKey::Character('t' | 'T') => self.set(|state| {
                let camera = state.camera(name);
                camera.test_image = TestImage::after(camera.test_image);
                log_test(&format!("camera {name}"), camera.test_image, "key t");
            }),
            _ => {}
        }
    }

    /// What holds for a camera.
    pub(crate) fn of_camera(&self, name: &str) -> OperatorSettings {
        let mut state = lock(&self.state);
        let all = state.blackouts.all.as_ref().map(|caller| format!("blackout by {caller}"));
        let own = state.blackouts.cameras.get(name).map(|caller| format!("blackout by {caller}, of this camera"));
        let (paused, test_image, is_switched_off) = (state.paused.clone(), state.test_image, own.is_some());
        let pattern = state.pattern.clone().filter(|pattern| pattern.is_current(Instant::now()));
        let camera = state.camera(name);
        OperatorSettings {
            light: match all.or(own) {
                Some(why) => Err(DarkReason::new(DarkCause::Blackout, why)),
                None => Ok(camera.generation.clone()),
            },
            is_switched_off,
            paused: paused.or_else(|| camera.is_paused.then(|| "key p in its window".to_owned())),
            test_image: camera.test_image.or(test_image),
            pattern,
        }
    }

    /// The words on all cameras.
    pub(crate) fn state(&self) -> ControlState {
        let state = lock(&self.state);
        let (blackout, paused) = (state.blackouts.all.clone(), state.paused.clone());
        ControlState { blackout, paused, test_image: state.test_image.map(TestImage::name) }
    }

    /// Number of what was said about blackouts last. It is another one after each blackout and each release.
    pub(crate) fn number(&self) -> u64 {
        lock(&self.state).number
    }

    /// `true` once after changes.
    pub(crate) fn take_change(&self) -> bool {
        std::mem::take(&mut lock(&self.state).has_changed)
    }

    /// Changes something else than blackouts.
    fn set<T>(&self, change: impl FnOnce(&mut ControlledState) -> T) -> T {
        let mut state = lock(&self.state);
        let result = change(&mut state);
        state.has_changed = true;
        drop(state);
        (self.wake)();
        result
    }

    /// Changes blackouts at once, then writes them to the file.
    fn change(&self, change: impl FnOnce(&mut ControlledState)) -> Result<(), String> {
        let (number, blackouts) = self.set(|state| {
            change(state);
            (state.number, state.blackouts.clone())
        });
        let mut kept = lock(&self.file);
        // A newer one may be in it already.
        if kept.number < number {
            kept.file
                .write(&blackouts)
                .map_err(|error| format!("the blackouts are not kept for a restart: {error}"))?;
            kept.number = number;
        }
        Ok(())
    }
}

impl ControlledState {
    fn set_blackout(&mut self, on: bool, caller: &str) {
        self.blackouts.all = on.then(|| caller.to_owned());
        if !on {
            self.blackouts.cameras.clear();
        }
        self.number += 1;
        self.cameras.iter_mut().for_each(|camera| camera.generation.advance());
        log::warn!("all cameras: blackout {} by {caller}", on_or_off(on));
    }

    fn set_camera_blackout(&mut self, name: &str, on: bool, caller: &str) {
        let is_same = self.blackouts.cameras.contains_key(name) == on;
        self.number += u64::from(on || !is_same);
        if is_same {
            return;
        }
        if on {
            self.blackouts.cameras.insert(name.to_owned(), caller.to_owned());
        } else {
            self.blackouts.cameras.remove(name);
        }
        self.camera(name).generation.advance();
        let all = self.blackouts.all.as_ref().filter(|_| !on);
        let all = all.map(|caller| format!("; all cameras are still black by {caller}")).unwrap_or_default();
        log::warn!("camera {name}: blackout {} by {caller}{all}", on_or_off(on));
    }

    /// The part of a camera, which is new if need be.
    fn camera(&mut self, name: &str) -> &mut CameraState {
        let known = self.cameras.iter().position(|camera| camera.name == name);
        let index = known.unwrap_or_else(|| {
            self.cameras.push(CameraState { name: name.to_owned(), ..CameraState::default() });
            self.cameras.len() - 1
        });
        &mut self.cameras[index]
    }
}

fn on_or_off(on: bool) -> &'static str {
    if on {
        "on"
    } else {
        "off"
    }
}

fn log_test(what: &str, test: Option<TestImage>, caller: &str) {
    match test {
        Some(test) => log::info!("{what}: test picture {} by {caller}", test.name()),
        None => log::info!("{what}: the scene by {caller}"),
    }
}

#[cfg(test)]
mod tests;
