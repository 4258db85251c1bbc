//! Carries out what the pages ask for.

use std::sync::Arc;
use std::time::UNIX_EPOCH;

use rcs_web::{answered_number, LogLine, Operator, Refusal};
use rcs_window::test_images::TestImage;
use serde_json::Value;

use super::nudging::Nudging;
use super::{parameters, records, state};
use crate::runtime::cue_thread;
use crate::runtime::shared::NodeState;

/// The node for the pages.
pub(crate) struct PageOperator {
    shared: Arc<NodeState>,
    nudging: Arc<Nudging>,
}

impl PageOperator {
    pub(super) fn new(shared: &Arc<NodeState>) -> Self {
        Self { shared: Arc::clone(shared), nudging: Nudging::new(shared) }
    }

    /// Blacks out all cameras or a single one, or releases them. All: releases all blackouts.
    fn black_out(&self, body: &Value, caller: &str) -> Result<String, Refusal> {
        let on = switch(body)?;
        let camera = if body["camera"].is_null() { None } else { Some(text(body, "camera")?) };
        let is_known = |camera: &&str| self.shared.cameras().iter().any(|known| known.view().name == *camera);
        if let Some(camera) = camera.filter(|camera| !is_known(camera)) {
            return Err(Refusal::Invalid(format!("camera: there is no camera {camera}")));
        }
        let control = &self.shared.control;
        let kept = match (on, camera) {
            (true, None) => control.set_blackout(true, caller),
            (true, Some(camera)) => control.set_camera_blackout(camera, true, caller),
            (false, camera) => control.release(camera, answered_number(body)?, caller).ok_or_else(outdated)?,
        };
        kept.map_err(Refusal::Failed)?;
        let what = if on { "black" } else { "released" };
        Ok(camera.map_or_else(|| format!("all cameras: {what}"), |camera| format!("camera {camera}: {what}")))
    }

    /// Checks that a request which may light answers the present state.
    fn check_answer(&self, body: &Value) -> Result<(), Refusal> {
        let is_answer = answered_number(body)? == self.shared.control.number();
        is_answer.then_some(()).ok_or_else(outdated)
    }

    /// Sets parameters of a dynamic_reconfigure server.
    fn set_parameters(&self, body: &Value, caller: &str) -> Result<String, Refusal> {
        let name = text(body, "server")?;
        let values = body["values"].as_object().ok_or_else(|| invalid("values: no object"))?;
        let unknown = || Refusal::Invalid(format!("server: there is no server {name}"));
        let mut settings = self.shared.settings();
        let names: Vec<&str> = values.keys().map(String::as_str).collect();
        let names = names.join(", ");
        if let Some(server) = settings.server(name) {
            let request = parameters::request(values, server.groups()).map_err(Refusal::Invalid)?;
            let set = settings.set(&self.shared.ros, &self.shared.control, &request, caller);
            drop(settings);
            cue_thread::follow(&self.shared);
            return set.map(|_| format!("{names} set")).map_err(Refusal::Invalid);
        }
        drop(settings);
        let mut cameras = self.shared.cameras();
        let camera = cameras.iter_mut().find(|camera| camera.has_parameters(name)).ok_or_else(unknown)?;
        let server = camera.servers().find(|server| &**server.name() == name).ok_or_else(unknown)?;
        let request = parameters::request(values, server.groups()).map_err(Refusal::Invalid)?;
        camera.reconfigure(name, &request, caller);
        drop(cameras);
        cue_thread::follow(&self.shared);
        self.shared.ros.events().wake();
        log::info!("{name}: {names} set by {caller}");
        Ok(format!("{names} set"))
    }
}

impl Operator for PageOperator {
    fn is_immediate(&self, request: &str) -> bool {
        matches!(request, "blackout" | "pause" | "test_picture" | "parameters")
    }

    fn post(&self, request: &str, body: &Value, caller: &str) -> Result<String, Refusal> {
        match request {
            "parameters" => self.set_parameters(body, caller),
            "nudge" | "save" | "revert" => self.nudging.post(request, body, caller),
            "cue" => {
                let name = if body["name"].is_null() { None } else { Some(text(body, "name")?) };
                cue_thread::show(&self.shared, name, caller).map(|name| format!("cue {name}")).map_err(Refusal::Failed)
            }
            "save_cue" => {
                let name = text(body, "name")?.trim();
                let saved = cue_thread::save(&self.shared, name, caller);
                saved.map(|()| format!("cue {name} saved")).map_err(Refusal::Failed)
            }
            "remove_cue" => {
                let name = text(body, "name")?;
                let removed = cue_thread::remove(&self.shared, name, caller);
                removed.map(|()| format!("cue {name} removed")).map_err(Refusal::Failed)
            }
            "mark" => records::mark(&self.shared).map(|line| format!("marked: {line}")).map_err(Refusal::Failed),
            "marks" => records::marks(&self.shared).map_err(Refusal::Failed),
            "snapshot" => {
                let saved = records::snapshot(&self.shared, text(body, "camera")?);
                saved.map(|file| format!("saved in {file}")).map_err(Refusal::Failed)
            }
            "blackout" => self.black_out(body, caller),
            "pause" => {
                let on = switch(body)?;
                if !on {
                    self.check_answer(body)?;
                }
                self.shared.control.set_pause(on, caller);
                Ok(["no camera is paused", "all cameras are paused"][usize::from(on)].to_owned())
            }
            "test_picture" => {
                self.check_answer(body)?;
                let control = &self.shared.control;
                let test = match &body["name"] {
                    Value::Null => control.set_test_image(None, caller),
                    _ => {
                        let test = text(body, "name")?.parse::<TestImage>();
                        let test = test.map_err(|error| Refusal::Invalid(format!("name: {error}")))?;
                        control.set_test_image(Some(test), caller)
                    }
                };
                Ok(test.map_or_else(|| "the scene is shown".to_owned(), |name| format!("test picture: {name}")))
            }
            unknown => Err(Refusal::Unknown(unknown.to_owned())),
        }
    }

    fn state(&self) -> String {
        state::state(&self.shared, &self.nudging).to_string()
    }

    fn log_after(&self, id: u64) -> Vec<LogLine> {
        let line = |line: rcs_logging::RecentLine| LogLine {
            id: line.id,
            time_secs: line.time.duration_since(UNIX_EPOCH).unwrap_or_default().as_secs_f64(),
            level: match line.level {
                log::Level::Error => "error",
                log::Level::Warn => "warn",
                log::Level::Info | log::Level::Debug | log::Level::Trace => "info",
            },
            text: line.text,
        };
        rcs_logging::recent_lines(id).into_iter().map(line).collect()
    }

    fn watchers_changed(&self) {
        self.nudging.poll_while_open();
        self.shared.ros.events().wake();
    }
}

fn outdated() -> Refusal {
    Refusal::Failed("the state has changed since; look at it, and press again".to_owned())
}

fn invalid(reason: &str) -> Refusal {
    Refusal::Invalid(reason.to_owned())
}

/// The switch `on` of a request's body.
fn switch(body: &Value) -> Result<bool, Refusal> {
    body["on"].as_bool().ok_or_else(|| invalid("on: neither true nor false"))
}

/// A text of a request's body.
fn text<'b>(body: &'b Value, key: &str) -> Result<&'b str, Refusal> {
    body[key].as_str().ok_or_else(|| Refusal::Invalid(format!("{key}: no text")))
}
