//! Nudging projectors for the pages, and the values that the pages show.
//!
//! The values are asked for every few seconds while a page is open, because others may nudge, too. That waits for other
//! nodes, so it has a thread, which ends with the last page.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

use rcs_node_support::nudge::NudgedProjector;
use rcs_process::lock;
use rcs_render::Orientation;
use rcs_web::Refusal;
use serde_json::{json, Value};

use crate::camera::output::CameraPublisher;
use crate::nudge::{nudge, projector, Step};
use crate::runtime::shared::NodeState;

/// Time between two looks at the values.
const PERIOD: Duration = Duration::from_secs(3);
/// Keys of a step in a request, in the order of [`Step`].
const STEPS: [&str; 6] = ["right_m", "down_m", "forward_m", "pitch_rad", "yaw_rad", "roll_rad"];
/// Names of the values, in the order of a nudge's.
const VALUES: [&str; 6] = ["x", "y", "z", "roll", "pitch", "yaw"];

/// Nudges the projectors of a node's cameras.
pub(super) struct Nudging {
    shared: Arc<NodeState>,
    /// Held from reading a nudge to writing it, so that all steps count.
    stepping: Mutex<()>,
    /// The nudges that pages show, by camera; none for a camera whose projector cannot be nudged.
    known: Mutex<HashMap<String, Value>>,
    is_polling: AtomicBool,
}

impl Nudging {
    pub(super) fn new(shared: &Arc<NodeState>) -> Arc<Self> {
        let (stepping, known, is_polling) = (Mutex::default(), Mutex::default(), AtomicBool::new(false));
        Arc::new(Self { shared: Arc::clone(shared), stepping, known, is_polling })
    }

    /// A camera's nudge on the pages.
    pub(super) fn of_camera(&self, camera: &str) -> Value {
        lock(&self.known).get(camera).cloned().unwrap_or_default()
    }

    /// Asks for the values while a page is open.
    pub(super) fn poll_while_open(self: &Arc<Self>) {
        if !self.shared.page.pages().is_any_open() || self.is_polling.swap(true, Ordering::AcqRel) {
            return;
        }
        let own = Arc::clone(self);
        let started = thread::Builder::new().name("web-nudge".to_owned()).spawn(move || own.poll());
        if let Err(error) = started {
            self.is_polling.store(false, Ordering::Release);
            log::error!("cannot start the thread that asks projectors for their nudges: {error}");
        }
    }

    fn poll(self: &Arc<Self>) {
        let _is_polling = ClearWhenDropped(&self.is_polling);
        while self.shared.page.pages().is_any_open() {
            for (camera, topic, _) in self.targets() {
                self.refresh(camera, &topic);
            }
            thread::sleep(PERIOD);
        }
    }

    /// Each camera's name, CameraInfo topic and orientation.
    fn targets(&self) -> Vec<(String, String, Orientation)> {
        let target = |camera: &CameraPublisher| {
            let view = camera.view();
            (view.name.clone(), view.settings.camera_info_topic.clone(), camera.orientation())
        };
        self.shared.cameras().iter().map(target).collect()
    }

    /// Asks for a camera's values, for the pages.
    fn refresh(&self, camera: String, topic: &str) {
        let ros = &self.shared.ros;
        let found = ros.resolve(topic).and_then(|topic| NudgedProjector::find(ros, &topic));
        let mut known = lock(&self.known);
        let before = known.get(&camera).cloned();
        let now = found.map(|found| found.map(|projector| json_of(&projector))).unwrap_or_else(|error| {
            // The last values, if there are some, cannot be changed at present.
            let mut known = before.clone()?;
            known["problem"] = json!(error.to_string());
            Some(known)
        });
        if now == before {
            return;
        }
        match now {
            Some(now) => known.insert(camera, now),
            None => known.remove(&camera),
        };
        drop(known);
        self.shared.page.pages().state_changed();
    }

    /// Carries out `nudge`, `save` or `revert`. Waits for the projector's node.
    pub(super) fn post(&self, request: &str, body: &Value, caller: &str) -> Result<String, Refusal> {
        let camera = body["camera"].as_str().ok_or_else(|| Refusal::Invalid("camera: no text".to_owned()))?;
        let target = self.targets().into_iter().find(|(name, ..)| name == camera);
        let (_, topic, orientation) =
            target.ok_or_else(|| Refusal::Invalid(format!("camera: there is no camera {camera}")))?;
        let step = step(body)?;
        let ros = &self.shared.ros;
        let stepping = lock(&self.stepping);
        let done = projector(ros, &topic).and_then(|mut projector| {
            if request != "nudge" {
                return projector.trigger(ros, request);
            }
            nudge(ros, &mut projector, orientation, &step)?;
            Ok(format!("{} nudged by {} in all", projector.node, projector.nudge))
        });
        drop(stepping);
        let message = done.map_err(|error| Refusal::Failed(format!("{error:#}")))?;
        self.refresh(camera.to_owned(), &topic);
        log::info!("camera {camera}: {message}; by {caller}");
        Ok(message)
    }
}

/// Clears a flag when its thread ends, also by a panic.
struct ClearWhenDropped<'a>(&'a AtomicBool);

impl Drop for ClearWhenDropped<'_> {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Release);
    }
}

fn json_of(projector: &NudgedProjector) -> Value {
    let mut json = json!({"node": projector.node, "problem": null});
    for (name, value) in VALUES.iter().zip(projector.nudge.0) {
        json[name] = json!(value);
    }
    json
}

/// The step of a request; what is missing is 0.
fn step(body: &Value) -> Result<Step, Refusal> {
    let mut values = [0.0; STEPS.len()];
    for (value, key) in values.iter_mut().zip(STEPS) {
        if !body[key].is_null() {
            *value = body[key].as_f64().ok_or_else(|| Refusal::Invalid(format!("{key}: no number")))?;
        }
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_step_leaves_out_is_zero() {
        let found = step(&json!({"camera": "proj", "down_m": 0.01, "yaw_rad": -1})).unwrap();
        assert_eq!(found, [0.0, 0.01, 0.0, 0.0, -1.0, 0.0]);
        assert_eq!(step(&json!({"right_m": "1"})).unwrap_err(), Refusal::Invalid("right_m: no number".to_owned()));
    }
}
