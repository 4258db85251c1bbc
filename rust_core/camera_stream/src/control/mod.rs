//! The operator's settings: blackout, pause and test pictures, of all cameras and of each.
//!
//! ```text
//!  services, dynamic_reconfigure, keys of windows, page ─► Control ─┬─► control thread: black at once
//!                                                                   └─► LightTicket: last check before an output
//! ```
//!
//! Nothing else holds such state. A camera is black while any blackout holds: `~blackout`, the camera's own switch, or
//! the key B of its window. Each is released where it was set, and `~blackout` releases all. Blackouts are remembered
//! as parameters, so that a node which crashes during one does not come back lit.

pub(crate) mod pattern;
mod ticket;

use std::collections::HashSet;
use std::fmt;
use std::sync::{Arc, Mutex};
use std::time::Instant;

use rcs_ros::{ParameterValue, Parameters, RosNode};
use rcs_scene::lock;
use rcs_window::test_pictures::TestPicture;
use rcs_window::{WindowKey, WindowView};

use pattern::Pattern;

use crate::safety::causes::{DarkCause, DarkReason};
use ticket::Gate;

pub(crate) use ticket::LightTicket;

/// Parameter of `~blackout`, and of a camera's own below its name.
pub(crate) const BLACKOUT: &str = "blackout";
/// Parameter of the key B, below the camera's name.
const KEY_BLACKOUT: &str = "key_blackout";
/// Who set what was remembered.
const REMEMBERED: &str = "a parameter at the start";

/// Sets a parameter below the node.
type Remember = dyn Fn(&str, bool) + Send + Sync;

/// The operator's settings. Cheap to read from any thread.
pub(crate) struct Control {
    state: Mutex<ControlledState>,
    remember: Box<Remember>,
    wake: Box<dyn Fn() + Send + Sync>,
}

#[derive(Default)]
struct ControlledState {
    /// Who has blacked out all cameras.
    blackout: Option<String>,
    /// Who has paused all cameras.
    paused: Option<String>,
    test_picture: Option<TestPicture>,
    /// The pattern that came last.
    pattern: Option<Arc<Pattern>>,
    cameras: Vec<CameraState>,
    /// The names of parameters that were true when the node started, until cameras have taken theirs.
    remembered: HashSet<String>,
    has_changed: bool,
}

/// The part of one camera.
#[derive(Default)]
struct CameraState {
    name: String,
    /// Name of its parameters.
    id: String,
    /// Who has blacked it out by its switch.
    blackout: Option<String>,
    is_key_black: bool,
    is_paused: bool,
    test_picture: Option<TestPicture>,
    gate: Gate,
}

/// The operator's settings of one camera.
#[derive(Clone, Debug, Default)]
pub(crate) struct OperatorSettings {
    /// The blackout that holds.
    pub(crate) blackout: Option<DarkReason>,
    /// `true` if the camera's own switch blacks it out.
    pub(crate) is_switched_off: bool,
    /// Who has paused it.
    pub(crate) paused: Option<String>,
    /// The test picture in place of the scene.
    pub(crate) test_picture: Option<TestPicture>,
    /// The pattern of a calibration in place of both, where it fits.
    pub(crate) pattern: Option<Arc<Pattern>>,
}

/// The operator's settings of all cameras.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct ControlState {
    /// Who has blacked out all cameras.
    pub(crate) blackout: Option<String>,
    /// Who has paused all cameras.
    pub(crate) paused: Option<String>,
    /// The test picture of all cameras, by its name.
    pub(crate) test_picture: Option<&'static str>,
}

impl fmt::Debug for Control {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Control").field("state", &self.state()).finish_non_exhaustive()
    }
}

impl Control {
    /// The control of a node, which is woken by each change. `is_black`: it starts with a blackout.
    pub(crate) fn start(ros: &Arc<RosNode>, is_black: bool) -> Self {
        let (writer, woken) = (Arc::downgrade(ros), Arc::downgrade(ros));
        let remember = move |name: &str, is_on: bool| {
            let set = writer.upgrade().map(|ros| ros.set_parameter(&format!("~{name}"), ParameterValue::Bool(is_on)));
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
        let control = Self::new(remembered(ros.parameters()), remember, wake);
        if is_black || lock(&control.state).remembered.contains(BLACKOUT) {
            control.set_blackout(true, REMEMBERED);
        }
        control
    }

    fn new(
        remembered: HashSet<String>,
        remember: impl Fn(&str, bool) + Send + Sync + 'static,
        wake: impl Fn() + Send + Sync + 'static,
    ) -> Self {
        let state = Mutex::new(ControlledState { remembered, ..ControlledState::default() });
        Self { state, remember: Box::new(remember), wake: Box::new(wake) }
    }

    /// Takes the cameras of a config: each one's name, and the name of its parameters. The first ones get what an
    /// earlier run of the node has left.
    pub(crate) fn set_cameras<'c>(&self, cameras: impl Iterator<Item = (&'c str, &'c str)>) {
        self.change(|state, _| {
            let remembered = std::mem::take(&mut state.remembered);
            for (name, id) in cameras {
                let camera = state.camera(name);
                id.clone_into(&mut camera.id);
                for (parameter, is_key) in [(BLACKOUT, false), (KEY_BLACKOUT, true)] {
                    if !remembered.contains(&format!("{id}/{parameter}")) {
                        continue;
                    }
                    log::warn!("camera {name}: blackout by {REMEMBERED}, ~{id}/{parameter}");
                    match is_key {
                        true => camera.is_key_black = true,
                        false => camera.blackout = Some(REMEMBERED.to_owned()),
                    }
                }
            }
        });
    }

    /// Blacks out all cameras, or releases all blackouts: also those of single cameras and of keys.
    pub(crate) fn set_blackout(&self, on: bool, caller: &str) {
        self.change(|state, remember| {
            state.blackout = on.then(|| caller.to_owned());
            remember(BLACKOUT, on);
            if !on {
                state.cameras.iter_mut().for_each(|camera| camera.release(remember));
            }
            log::warn!("all cameras: blackout {} by {caller}", on_or_off(on));
        });
    }

    /// Sets a camera's own blackout.
    pub(crate) fn set_camera_blackout(&self, name: &str, on: bool, caller: &str) {
        self.change(|state, _| {
            let camera = state.camera(name);
            if camera.blackout.is_some() != on {
                camera.blackout = on.then(|| caller.to_owned());
                log::warn!("camera {name}: blackout {} by {caller}", on_or_off(on));
            }
        });
    }

    /// Pauses all cameras, or resumes them, also those that a key has paused.
    pub(crate) fn set_pause(&self, on: bool, caller: &str) {
        self.change(|state, _| {
            state.paused = on.then(|| caller.to_owned());
            if !on {
                state.cameras.iter_mut().for_each(|camera| camera.is_paused = false);
            }
            log::info!("all cameras: pause {} by {caller}", on_or_off(on));
        });
    }

    /// Shows the next test picture in all cameras, and after the last one the scene again. Returns its name.
    pub(crate) fn next_test_picture(&self, caller: &str) -> Option<&'static str> {
        self.change(|state, _| {
            state.test_picture = TestPicture::after(state.test_picture);
            state.cameras.iter_mut().for_each(|camera| camera.test_picture = None);
            log_test("all cameras", state.test_picture, caller);
            state.test_picture.map(TestPicture::name)
        })
    }

    /// Shows a pattern of a calibration for a while.
    pub(crate) fn show_pattern(&self, pattern: Pattern) {
        self.change(|state, _| state.pattern = Some(Arc::new(pattern)));
    }

    /// Takes a key of a camera's window: B, P or the space bar, T.
    pub(crate) fn press(&self, name: &str, key: WindowKey) {
        self.change(|state, remember| {
            let camera = state.camera(name);
            match key {
                WindowKey::Character('b' | 'B') => {
                    camera.is_key_black ^= true;
                    camera.remember_key(remember);
                    log::warn!("camera {name}: blackout {} by key b", on_or_off(camera.is_key_black));
                }
                WindowKey::Space | WindowKey::Character('p' | 'P') => {
                    camera.is_paused ^= true;
                    log::info!("camera {name}: pause {} by key p", on_or_off(camera.is_paused));
                }
                WindowKey::Character('t' | 'T') => {
                    camera.test_picture = TestPicture::after(camera.test_picture);
                    log_test(&format!("camera {name}"), camera.test_picture, "key t");
                }
                _ => {}
            }
        });
    }

    /// What holds for a camera.
    pub(crate) fn of_camera(&self, name: &str) -> OperatorSettings {
        let mut state = lock(&self.state);
        let (all, paused, test_picture) = (state.blackout.clone(), state.paused.clone(), state.test_picture);
        let pattern = state.pattern.clone().filter(|pattern| pattern.is_current(Instant::now()));
        let camera = state.camera(name);
        let by = |caller: &str, of: &str| DarkReason::new(DarkCause::Blackout, format!("blackout by {caller}{of}"));
        let own = || camera.blackout.as_ref().map(|caller| by(caller, ", of this camera"));
        let key = || camera.is_key_black.then(|| by("key b", " in its window"));
        OperatorSettings {
            blackout: all.map(|caller| by(&caller, "")).or_else(own).or_else(key),
            is_switched_off: camera.blackout.is_some(),
            paused: paused.or_else(|| camera.is_paused.then(|| "key p in its window".to_owned())),
            test_picture: camera.test_picture.or(test_picture),
            pattern,
        }
    }

    /// The ticket of an image of a camera that is begun now.
    pub(crate) fn ticket(&self, name: &str) -> LightTicket {
        lock(&self.state).camera(name).gate.ticket()
    }

    /// The settings of all cameras.
    pub(crate) fn state(&self) -> ControlState {
        let state = lock(&self.state);
        let (blackout, paused) = (state.blackout.clone(), state.paused.clone());
        ControlState { blackout, paused, test_picture: state.test_picture.map(TestPicture::name) }
    }

    /// `true` once after changes.
    pub(crate) fn take_change(&self) -> bool {
        std::mem::take(&mut lock(&self.state).has_changed)
    }

    fn change<T>(&self, change: impl FnOnce(&mut ControlledState, &dyn Fn(&str, bool)) -> T) -> T {
        let mut state = lock(&self.state);
        let result = change(&mut state, &*self.remember);
        let all_black = state.blackout.is_some();
        state.cameras.iter_mut().for_each(|camera| camera.gate.set(all_black || camera.is_black()));
        state.has_changed = true;
        drop(state);
        (self.wake)();
        result
    }
}

impl ControlledState {
    /// The part of a camera, which is new if need be.
    fn camera(&mut self, name: &str) -> &mut CameraState {
        let known = self.cameras.iter().position(|camera| camera.name == name);
        let index = known.unwrap_or_else(|| {
            let mut camera = CameraState { name: name.to_owned(), id: name.to_owned(), ..CameraState::default() };
            camera.gate.set(self.blackout.is_some());
            self.cameras.push(camera);
            self.cameras.len() - 1
        });
        &mut self.cameras[index]
    }
}

impl CameraState {
    fn is_black(&self) -> bool {
        self.blackout.is_some() || self.is_key_black
    }

    fn release(&mut self, remember: &dyn Fn(&str, bool)) {
        self.blackout = None;
        if std::mem::take(&mut self.is_key_black) {
            self.remember_key(remember);
        }
    }

    fn remember_key(&self, remember: &dyn Fn(&str, bool)) {
        remember(&format!("{}/{KEY_BLACKOUT}", self.id), self.is_key_black);
    }
}

impl OperatorSettings {
    /// The view of the camera's window.
    pub(crate) fn window_view(&self) -> WindowView {
        match (&self.blackout, self.test_picture) {
            (Some(_), _) => WindowView::Black,
            // A pattern is an image of the camera.
            (None, Some(test)) if self.pattern.is_none() => WindowView::Test(test),
            (None, _) => WindowView::Live,
        }
    }
}

/// The parameters below a node that are true, with the names of their namespaces.
fn remembered(parameters: &Parameters) -> HashSet<String> {
    let is_on = |value: &ParameterValue| matches!(value, ParameterValue::Bool(true));
    let mut all = HashSet::new();
    for (name, value) in parameters {
        if let ParameterValue::Struct(below) = value {
            all.extend(below.iter().filter(|(_, value)| is_on(value)).map(|(below, _)| format!("{name}/{below}")));
        } else if is_on(value) {
            all.insert(name.clone());
        }
    }
    all
}

fn on_or_off(on: bool) -> &'static str {
    if on {
        "on"
    } else {
        "off"
    }
}

fn log_test(what: &str, test: Option<TestPicture>, caller: &str) {
    match test {
        Some(test) => log::info!("{what}: test picture {} by {caller}", test.name()),
        None => log::info!("{what}: the scene again, after the last test picture, by {caller}"),
    }
}

#[cfg(test)]
mod tests;
